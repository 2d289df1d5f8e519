//! The Foxglove layout and the Python example name only existing channels, messages and fields.

use messages::channels::Channel;
use messages::{ExcavatorEstimate, LoaderEstimate, Message};
use serde_json::Value;

fn channel(name: &str) -> Option<&'static Channel> {
    messages::channels::find(name)
}

#[test]
fn the_foxglove_layout_names_channels_and_fields_that_exist() {
    let layout: Value =
        serde_json::from_str(include_str!("../assets/foxglove-layout.json")).expect("JSON");
    let panels = layout["configById"].as_object().expect("panels");
    let mut seen = 0;
    for path in panels
        .values()
        .filter_map(|p| p["paths"].as_array())
        .flatten()
    {
        let path = path["value"].as_str().expect("a path");
        let (name, field) = path.split_once('.').expect("channel.field");
        let channel = channel(name).unwrap_or_else(|| panic!("no channel {name}"));
        let shape = channel.payload.shape();
        assert!(shape.index(field).is_some(), "no field {path}");
        seen += 1;
    }
    assert!(seen > 8);
    assert!(
        channel(
            panels["RawMessages!health"]["topicPath"]
                .as_str()
                .expect("a topic")
        )
        .is_some()
    );
}

#[test]
fn the_python_example_shows_channels_and_messages_that_there_are() {
    let text = include_str!("../../../tests/tools/subscribe.py");
    for name in ["excavator/inertia_ukf", "loader/cg_ukf"] {
        assert!(text.contains(name) && channel(name).is_some(), "{name}");
    }
    let named = [ExcavatorEstimate::NAME, LoaderEstimate::NAME];
    assert!(named.iter().all(|name| text.contains(name)));
    // Names that it reads, except those of the head, must be fields.
    let read = text.split("{e.").skip(1).map(|rest| {
        let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_');
        &rest[..end.unwrap_or(rest.len())]
    });
    for field in read.filter(|f| *f != "flags") {
        let known = ExcavatorEstimate::index(field).or(LoaderEstimate::index(field));
        assert!(known.is_some(), "{field}");
    }
}
