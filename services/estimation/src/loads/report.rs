//! Report of the ledger for other programs, in plain numbers.

use super::book::Truck;
use super::ledger::Ledger;
use super::load::{Load, Stage, Weight};
use super::now::Now;
use sheet::loads::bits;

/// Sources of the numbers.
struct At {
    now: Now,
    load: Load,
    delivered: Weight,
    truck: Truck,
    flags: u32,
}

/// The structure from the rows of the sheet.
macro_rules! report {
    (
        numbers { $( $name:ident ($($place:tt)*) $unit:tt $doc:tt; )* }
        codes { $( $code:ident ($($code_place:tt)*) $code_doc:tt; )* }
    ) => {
        /// Present content of the bucket, the latest load, and its truck.
        #[repr(C)]
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct LoadReport {
            $( #[doc = $doc] pub $name: f64, )*
            $( #[doc = $code_doc] pub $code: u32, )*
        }

        impl LoadReport {
            fn at(at: &At) -> Self {
                Self {
                    $( $name: at.$($place)*, )*
                    $( $code: at.$($code_place)*, )*
                }
            }
        }
    };
}

sheet::loads_fields!(report);

impl LoadReport {
    /// Report of a ledger; `last` is the latest load that it has reported.
    pub fn of(ledger: &Ledger, last: Option<&Load>) -> Self {
        let (now, truck) = (ledger.now(), ledger.truck());
        // A load that leaves may come back: it is not final. One that was carried and no longer is, is unknown.
        let carried = ledger.carried();
        // What stays in the bucket is weighed after the dump: until it is final, the ledger has it as the truck does.
        let left = ledger.unbooked().or(last.copied());
        let load = carried.or(left.filter(|load| load.stage != Stage::Carried));
        let flags = flags(load.as_ref(), carried.is_some(), &now, &truck);
        let load = load.unwrap_or_default();
        Self::at(&At {
            now,
            delivered: load.delivered(),
            load,
            truck,
            flags,
        })
    }
}

fn flags(load: Option<&Load>, carried: bool, now: &Now, truck: &Truck) -> u32 {
    let is = |yes: bool, bit: u32| if yes { bit } else { 0 };
    let of_load = load.map_or(0, |load| {
        is(load.trusted, bits::TRUSTED)
            | is(carried, bits::CARRIED)
            | is(!carried, bits::FINAL)
            | is(load.carry_back_weighed, bits::CARRY_BACK_WEIGHED)
    });
    let total = &truck.total;
    of_load
        | is(now.age.is_some(), bits::WEIGHED)
        | is(total.loads > 0 && total.untrusted == 0, bits::TRUCK_TRUSTED)
        | is(truck.target.is_some(), bits::HAS_TARGET)
}

#[cfg(test)]
mod tests {
    use super::super::{Row, Settings, Stage, Witness};
    use super::*;
    use crate::Quantity;
    use sheet::loads::{NEVER, STAGES, WITNESSES};

    #[test]
    fn codes_of_stages_and_witnesses_are_those_of_the_sheet() {
        for stage in Stage::ALL {
            assert_eq!(STAGES[stage.code() as usize].name, stage.name());
        }
        for witness in Witness::ALL {
            assert_eq!(WITNESSES[witness.code() as usize].name, witness.name());
        }
        assert_eq!(
            (STAGES.len(), WITNESSES.len()),
            (Stage::ALL.len(), Witness::ALL.len())
        );
    }

    #[test]
    fn a_load_is_reported_from_before_it_is_weighed_until_its_truck_holds_it() {
        let mut ledger = Ledger::new(Settings {
            target: Some(2000.0),
            ..Settings::with_rated(1000.0)
        });
        let (mut last, mut report) = (None, LoadReport::of(&ledger, None));
        assert_eq!((report.payload_age, report.load), (NEVER, 0));
        assert!(report.payload_std > 500.0, "nothing is known");
        assert_eq!(report.flags, bits::HAS_TARGET);
        for i in 0..1200 {
            let time = f64::from(i) * 0.01;
            let value = if (200..500).contains(&i) { 900.0 } else { 20.0 };
            // No row weighs it in the last seconds.
            let payload = (i < 1000).then_some(Quantity { value, std: 20.0 });
            let changing = (500..540).contains(&i);
            let row = Row {
                time,
                payload,
                changing,
                trusted: true,
                ..Row::default()
            };
            last = ledger.step(&row).load.or(last);
            report = LoadReport::of(&ledger, last.as_ref());
            if report.truck_loads == 1 {
                assert_eq!(report.delivered, report.truck_mass, "at {time} s");
            }
            if i == 450 {
                let carried = bits::TRUSTED | bits::CARRIED | bits::WEIGHED | bits::HAS_TARGET;
                assert_eq!((report.flags, report.load), (carried, 1));
                assert!((report.mass - 900.0).abs() < 30.0 && report.dumped == 0.0);
            }
        }
        let has = |bit: u32| report.flags & bit != 0;
        assert!(has(bits::FINAL) && has(bits::TRUCK_TRUSTED) && !has(bits::CARRIED));
        assert!((report.truck_mass - 880.0).abs() < 30.0, "{report:?}");
        assert!((report.remaining - 1120.0).abs() < 30.0, "{report:?}");
        assert!((report.payload_age - 2.0).abs() < 0.02, "{report:?}");
        assert!(report.payload.abs() < 60.0, "the last known value stays");
        assert!(report.payload_std > 100.0, "and is less certain with time");
    }
}
