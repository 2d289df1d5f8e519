//! What each bucket held, as the run counted it.

use std::fmt::Write;

use super::html::{row, table, text};
use crate::loads::clock;
use crate::number::{interval_95, value_and_std};
use crate::weighed::LoadRow;

/// A table of the loads; nothing where none was counted.
pub(super) fn write(body: &mut String, loads: &[LoadRow]) {
    if loads.is_empty() {
        return;
    }
    let head = [
        "load",
        "truck",
        "filled",
        "dumped",
        "in the bucket, kg",
        "95 %",
        "left in it, kg",
        "weighed by",
        "trusted",
    ];
    let rows: String = loads.iter().map(cells).map(|cells| row(&cells)).collect();
    let _ = write!(
        body,
        "<section class=\"words loads\"><h2>What each bucket held</h2>{}<p class=\"note\">As the run counted it. \
         <code>heft loads</code> adds up trucks and days.</p></section>",
        table(1, &head, &rows)
    );
}

fn cells(load: &LoadRow) -> Vec<String> {
    let kg = |(value, std): (f64, f64)| value_and_std(value, std).0;
    let trusted = match (load.is_trusted, load.why) {
        (true, _) => "yes".to_owned(),
        (false, "") => "no".to_owned(),
        (false, why) => format!("no: {}", text(why)),
    };
    vec![
        load.number.to_string(),
        load.truck.to_string(),
        clock(load.filled),
        if load.is_carried {
            "not yet".into()
        } else {
            clock(load.dumped)
        },
        kg(load.mass),
        interval_95(load.mass.0, load.mass.1),
        if load.is_carried {
            String::new()
        } else {
            kg(load.carry_back)
        },
        load.witness.to_owned(),
        trusted,
    ]
}

#[cfg(test)]
mod tests {
    use messages::{LOADER_REASONS, LoaderLoads, loads_bits};

    use super::*;
    use crate::weighed::of_loader;

    #[test]
    fn a_load_is_a_row_with_its_interval_and_why_it_is_not_trusted() {
        let mut message = LoaderLoads {
            load: 2,
            truck: 1,
            mass: 930.0,
            mass_std: 91.0,
            filled: 7.7,
            dumped: 17.1,
            witness: 1,
            flags: loads_bits::TRUSTED,
            ..LoaderLoads::default()
        };
        let trusted = cells(&of_loader(&message));
        assert_eq!(trusted[3], "0:17.1");
        assert_eq!(trusted[4], "930");
        assert_eq!(trusted[7..], ["pressure", "yes"]);
        (message.flags, message.reason) = (loads_bits::CARRIED, 1);
        let doubted = cells(&of_loader(&message));
        assert_eq!(doubted[3], "not yet");
        assert_eq!(doubted[8], format!("no: {}", LOADER_REASONS[1].1));
    }
}
