//! What people outside heft use must name what heft has: the Foxglove layout and the Python example.

use messages::channels::{Channel, Visitor};
use messages::{ExcavatorEstimate, LoaderEstimate, Message};
use serde_json::Value;

struct HasField<'a>(&'a str);

impl Visitor for HasField<'_> {
    type Output = bool;
    fn visit<M: Message>(self) -> bool {
        M::index(self.0).is_some()
    }
}

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
        assert!(channel.payload.visit(HasField(field)), "no field {path}");
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

/// Names of the fields behind the head, as the Python structure lists them.
fn python_fields<'a>(text: &'a str, class: &str) -> Vec<&'a str> {
    let class = text
        .split(&format!("class {class}("))
        .nth(1)
        .expect("the class");
    let fields = class
        .split("_fields_ = ")
        .nth(1)
        .and_then(|f| f.split("TRUSTED").next())
        .expect("its fields");
    fields.split('"').skip(1).step_by(2).collect()
}

#[test]
fn the_python_example_lists_the_fields_in_our_order() {
    let text = include_str!("../../../tests/tools/subscribe.py");
    fn own<M: Message>() -> Vec<&'static str> {
        let first = M::FIELDS
            .iter()
            .rposition(|f| f.name.starts_with("estimate_"))
            .map_or(0, |i| i + 1);
        M::FIELDS[first..].iter().map(|f| f.name).collect()
    }
    assert_eq!(
        python_fields(text, "ExcavatorEstimate"),
        own::<ExcavatorEstimate>()
    );
    assert_eq!(
        python_fields(text, "LoaderEstimate"),
        own::<LoaderEstimate>()
    );
}
