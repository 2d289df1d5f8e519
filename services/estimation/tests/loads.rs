//! Detection of loads, and the totals of trucks.

use estimation::loads::{Events, Ledger, Load, Row, Settings, Stage, Truck, Witness};
use estimation::{CommonError, Quantity};

const RATED: f64 = 1000.0;
const DT: f64 = 0.01;
/// Mean and standard deviation of an estimator without information.
const PRIOR: (f64, f64) = (500.0, 400.0);

/// A ledger with a clock, and the loads and trucks that it has reported.
struct Site {
    ledger: Ledger,
    time: f64,
    said: Vec<Load>,
    trucks: Vec<Truck>,
    truck: Option<f64>,
    common: Option<CommonError>,
}

impl Site {
    fn new(target: Option<f64>) -> Self {
        let settings = Settings {
            target,
            ..Settings::with_rated(RATED)
        };
        Self {
            ledger: Ledger::new(settings),
            time: 0.0,
            said: Vec::new(),
            trucks: Vec::new(),
            truck: None,
            common: None,
        }
    }

    fn note(&mut self, events: Events) {
        self.said.extend(events.load);
        self.trucks.extend(events.truck);
    }

    fn row(&mut self, (value, std): (f64, f64), speed: f64, changing: bool) {
        self.time += DT;
        let row = Row {
            time: self.time,
            payload: Some(Quantity { value, std }),
            speed,
            changing,
            trusted: std < 100.0,
            truck: self.truck,
            common: self.common,
            ..Row::default()
        };
        let events = self.ledger.step(&row);
        self.note(events);
    }

    /// Stands for this time with this estimate.
    fn stand(&mut self, seconds: f64, estimate: (f64, f64)) {
        for _ in 0..(seconds / DT) as u32 {
            self.row(estimate, 0.0, false);
        }
    }

    /// Swings with this content; the estimate converges within a second.
    fn swing(&mut self, kg: f64) {
        for i in 0..300 {
            let share = (-f64::from(i) * DT / 0.3).exp();
            self.row(
                (kg + share * (PRIOR.0 - kg), 30.0 + share * 370.0),
                0.5,
                false,
            );
        }
    }

    /// Opens the bucket.
    fn open(&mut self) {
        for _ in 0..60 {
            self.row(PRIOR, 0.0, true);
        }
    }

    /// Digs, swings, dumps, swings back.
    fn cycle(&mut self, kg: f64, rest: f64) {
        self.stand(3.0, PRIOR);
        self.swing(kg);
        self.open();
        self.stand(0.5, PRIOR);
        self.swing(rest);
    }

    fn loads(&mut self) -> Vec<Load> {
        let events = self.ledger.finish();
        self.note(events);
        let settled = self.said.iter().filter(|l| l.stage == Stage::Settled);
        settled.copied().collect()
    }
}

#[test]
fn what_all_payloads_are_off_together_hides_no_load() {
    let loads = |scale_std: f64| {
        let mut site = Site::new(None);
        site.ledger = Ledger::new(Settings {
            common: CommonError {
                scale_std,
                zero_std: 0.0,
            },
            ..Settings::with_rated(RATED)
        });
        // The common error of the scale has a standard deviation of 0.4 of each payload.
        let swing = |site: &mut Site, kg: f64| {
            let std = f64::hypot(30.0, 0.4 * kg);
            (0..300).for_each(|_| site.row((kg, std), 0.5, false));
        };
        for kg in [700.0, 650.0] {
            site.stand(3.0, PRIOR);
            swing(&mut site, kg);
            site.open();
            site.stand(0.5, PRIOR);
            swing(&mut site, 40.0);
        }
        let loads = site.loads();
        let weighed = loads.iter().filter(|l| l.witness != Witness::Nothing);
        (loads.len(), weighed.count())
    };
    assert_eq!([0.0, 0.4, f64::NAN].map(loads), [(2, 0), (2, 2), (2, 0)]);
}

/// Swings with a content of which the estimate stays vague.
fn swing_vaguely(site: &mut Site, estimate: (f64, f64)) {
    for _ in 0..300 {
        site.row(estimate, 0.5, false);
    }
}

#[test]
fn an_uncertain_load_is_not_carried_through_an_opening_nor_an_uncertain_empty_bucket_through_a_filling()
 {
    let mut site = Site::new(None);
    for (full, empty) in [
        ((520.0, 240.0), (90.0, 150.0)),
        ((560.0, 200.0), (20.0, 70.0)),
    ] {
        site.stand(3.0, PRIOR);
        swing_vaguely(&mut site, full);
        site.open();
        site.stand(0.5, PRIOR);
        swing_vaguely(&mut site, empty);
    }
    let loads = site.loads();
    let kg: Vec<f64> = loads.iter().map(|l| l.weight.kg.round()).collect();
    assert_eq!(kg, [520.0, 560.0], "{loads:?}");
    assert!(loads.iter().all(|l| l.dumped.is_some_and(|t| t > l.filled)));
}

#[test]
fn a_load_that_nothing_weighs_counts_when_it_is_dumped_and_makes_the_sum_wide() {
    let mut site = Site::new(None);
    for _ in 0..3 {
        site.stand(3.0, PRIOR);
        swing_vaguely(&mut site, (600.0, 300.0));
        site.open();
        site.stand(0.5, PRIOR);
        site.swing(20.0);
    }
    let loads = site.loads();
    assert_eq!(loads.len(), 3, "{loads:?}");
    assert!(
        loads
            .iter()
            .all(|l| l.witness == Witness::Nothing && !l.trusted)
    );
    let all = site.ledger.all();
    assert_eq!((all.loads, all.unweighed), (3, 3));
    assert!(
        all.std() > 890.0,
        "what a load may be is the same of all: {all:?}"
    );
}

#[test]
fn of_a_load_of_which_nothing_is_known_the_sum_has_what_loads_are() {
    let mut site = Site::new(None);
    site.stand(3.0, PRIOR);
    swing_vaguely(&mut site, (-200.0, 5.0 * RATED));
    site.open();
    site.stand(0.5, PRIOR);
    let loads = site.loads();
    assert_eq!(loads.len(), 1, "{loads:?}");
    assert!(
        (loads[0].weight.kg, loads[0].weight.std) == (600.0, 400.0),
        "{loads:?}"
    );
}

#[test]
fn a_load_that_is_changing_all_the_way_to_the_truck_is_dumped_there() {
    let mut site = Site::new(None);
    site.stand(3.0, PRIOR);
    for _ in 0..300 {
        site.row((800.0, 100.0), 0.5, true);
    }
    site.open();
    site.stand(0.5, PRIOR);
    site.swing(20.0);
    let loads = site.loads();
    assert_eq!(loads.len(), 1, "{loads:?}");
    assert!((loads[0].weight.kg - 800.0).abs() < 1.0 && loads[0].carry_back_weighed);
    assert_ne!(loads[0].witness, Witness::Nothing);
}

#[test]
fn a_swing_that_goes_on_one_way_brings_no_second_load() {
    let mut site = Site::new(None);
    site.stand(3.0, PRIOR);
    for _ in 0..100 {
        site.row((800.0, 100.0), 0.5, false);
    }
    // A hanging load: the estimator reports a changing content until it is dumped.
    for _ in 0..400 {
        site.row((900.0, 300.0), 0.4, true);
    }
    site.open();
    site.stand(0.5, PRIOR);
    site.swing(20.0);
    let loads = site.loads();
    assert_eq!(loads.len(), 1, "{loads:?}");
}

#[test]
fn a_load_that_nothing_weighs_counts_too_where_it_leaves_in_the_swing() {
    let mut site = Site::new(None);
    for kg in [700.0, 800.0] {
        site.stand(3.0, PRIOR);
        swing_vaguely(&mut site, (kg, 280.0));
        // The estimate follows the load as it leaves, and is close for the emptied bucket.
        for i in 0..80 {
            let left = 1.0 - f64::from(i) / 80.0;
            site.row((kg * left + 20.0, 60.0 + 200.0 * left), 0.4, true);
        }
        site.stand(0.6, (20.0, 60.0));
        site.swing(20.0);
    }
    let loads = site.loads();
    assert_eq!(loads.len(), 2, "{loads:?}");
    assert!(loads.iter().all(|load| load.carry_back_weighed));
}

#[test]
fn a_vague_load_that_begins_to_leave_in_the_swing_weighs_what_it_did_before() {
    let mut site = Site::new(None);
    site.stand(3.0, PRIOR);
    swing_vaguely(&mut site, (560.0, 240.0));
    // It leaves in the last half second of the swing, and while the machine stands.
    for step in 0..=40 {
        let left = f64::from(step) / 40.0;
        let estimate = (560.0 - 360.0 * left, 240.0 - 110.0 * left);
        site.row(estimate, 0.2, true);
    }
    for _ in 0..60 {
        site.row((200.0, 130.0), 0.0, true);
    }
    site.stand(0.5, PRIOR);
    swing_vaguely(&mut site, (30.0, 60.0));
    let loads = site.loads();
    assert_eq!(loads.len(), 1, "{loads:?}");
    assert!((loads[0].weight.kg - 560.0).abs() < 1.0, "{loads:?}");
}

#[test]
fn the_next_load_is_seen_beside_a_surer_empty_bucket() {
    let mut site = Site::new(None);
    for _ in 0..3 {
        site.stand(3.0, PRIOR);
        swing_vaguely(&mut site, (600.0, 330.0));
        site.open();
        site.stand(0.5, PRIOR);
        for _ in 0..300 {
            site.row((30.0, 280.0), -0.5, false);
        }
    }
    assert_eq!(site.loads().len(), 3);
}

/// Swings in one direction with a hanging load, and stands.
fn swing_hanging(site: &mut Site, speed: f64) {
    for i in 0..1000 {
        site.time += DT;
        let swings = i < 400;
        let row = Row {
            time: site.time,
            payload: Some(Quantity {
                value: 100.0,
                std: 2.0 * RATED,
            }),
            speed: if swings { speed } else { 0.0 },
            hangs: swings,
            ..Row::default()
        };
        let events = site.ledger.step(&row);
        site.note(events);
    }
}

#[test]
fn a_load_that_hangs_has_a_row_where_it_is_set_down_and_what_swings_on_the_way_back_has_none() {
    let mut site = Site::new(None);
    for speed in [0.5, -0.5, 0.5, -0.5, 0.5] {
        swing_hanging(&mut site, speed);
    }
    let loads = site.loads();
    assert_eq!(loads.len(), 3, "{loads:?}");
    let is_unweighed = |load: &Load| load.witness == Witness::Nothing && !load.trusted;
    assert!(loads.iter().all(is_unweighed));
    assert!(
        (loads[0].dumped.unwrap_or(0.0) - 4.0).abs() < 0.1,
        "{loads:?}"
    );
    let all = site.ledger.all();
    assert!(
        (all.kg - 1800.0).abs() < 60.0 && all.std() > 1100.0,
        "{all:?}"
    );
}

#[test]
fn an_empty_bucket_that_opens_is_no_load() {
    let mut site = Site::new(None);
    site.cycle(900.0, 20.0);
    for _ in 0..3 {
        site.open();
        site.swing(20.0);
    }
    assert_eq!(site.loads().len(), 1);
}

#[test]
fn each_dig_swing_dump_and_return_is_one_load_with_what_stays_behind() {
    let mut site = Site::new(None);
    for kg in [900.0, 650.0, 700.0] {
        site.cycle(kg, 40.0);
    }
    let loads = site.loads();
    assert_eq!(loads.len(), 3);
    for (load, kg) in loads.iter().zip([900.0, 650.0, 700.0]) {
        assert!(load.trusted && load.weight.quantity().holds(kg), "{load:?}");
        assert!(
            load.carry_back_weighed && load.carry_back.quantity().holds(40.0),
            "{load:?}"
        );
        assert!(load.dumped.is_some_and(|t| t > load.filled + 2.5));
    }
    assert_eq!(
        loads.iter().map(|l| l.number).collect::<Vec<_>>(),
        [1, 2, 3]
    );
}

#[test]
fn a_load_is_reported_within_a_second_of_the_swing_and_final_at_the_dump() {
    let mut site = Site::new(None);
    site.stand(3.0, PRIOR);
    let begun = site.time;
    site.swing(800.0);
    let reported = site.said.first().copied().expect("a load");
    assert_eq!(reported.stage, Stage::Carried);
    assert!(
        reported.filled - begun < 0.1,
        "it was full when the swing began"
    );
    let opened = site.time;
    site.open();
    let dumped = site.said.last().copied().expect("a load");
    assert_eq!(dumped.stage, Stage::Dumped);
    assert!(dumped.dumped.is_some_and(|t| (t - opened).abs() < 0.1));
    assert!((dumped.weight.kg - 800.0).abs() < 60.0);
}

#[test]
fn a_bucket_that_opens_and_keeps_its_load_counts_once() {
    let mut site = Site::new(None);
    site.stand(3.0, PRIOR);
    site.swing(800.0);
    site.open();
    site.stand(0.5, (800.0, 40.0));
    site.swing(800.0);
    site.open();
    site.swing(20.0);
    assert_eq!(site.loads().len(), 1);
}

#[test]
fn a_load_dumped_in_parts_weighs_what_was_carried_to_the_truck() {
    let weighed = |carried: (f64, f64), rest: (f64, f64)| {
        let mut site = Site::new(None);
        site.stand(3.0, PRIOR);
        site.swing(carried.0);
        site.stand(0.5, carried);
        site.open();
        site.stand(3.0, rest);
        site.open();
        site.stand(1.0, (20.0, 30.0));
        let loads = site.loads();
        assert_eq!(loads.len(), 1, "{carried:?} {rest:?}");
        loads[0].weight.kg
    };
    // Too little for two contents, and too much for the same one by the same filter.
    assert!((weighed((900.0, 90.0), (700.0, 85.0)) - 900.0).abs() < 20.0);
    // A better estimate of the same content may differ by what it has gained.
    assert!((weighed((900.0, 95.0), (820.0, 25.0)) - 820.0).abs() < 20.0);
}

#[test]
fn a_load_that_is_dumped_and_replaced_unseen_counts_twice() {
    let mut site = Site::new(None);
    site.stand(3.0, PRIOR);
    site.swing(800.0);
    site.open();
    for _ in 0..300 {
        site.row(PRIOR, -0.5, false);
    }
    site.stand(3.0, PRIOR);
    site.swing(800.0);
    site.open();
    site.swing(20.0);
    let loads = site.loads();
    assert_eq!(loads.len(), 2, "{loads:?}");
    assert!(!loads[0].carry_back_weighed && loads[1].carry_back_weighed);
}

/// A loader pushes its bucket into the pile twice, with a short estimate of half of the load in between, drives away and dumps.
/// `way_back`: duration of a drive backwards and forwards between the two pushes [s].
fn push_in(site: &mut Site, way_back: f64) {
    let mut drive = |seconds: f64, estimate: (f64, f64), speed: f64, changing: bool| {
        for _ in 0..(seconds / DT) as u32 {
            site.time += DT;
            let events = site.ledger.step(&Row {
                time: site.time,
                payload: Some(Quantity {
                    value: estimate.0,
                    std: estimate.1,
                }),
                speed,
                changing,
                trusted: !changing,
                witness: Witness::Pressure,
                ..Row::default()
            });
            site.said.extend(events.load);
        }
    };
    drive(2.0, (0.0, 20.0), 0.0, false);
    drive(1.0, PRIOR, 0.8, true);
    drive(0.6, (450.0, 40.0), 0.3, false);
    drive(1.5, PRIOR, 0.4, true);
    drive(way_back, PRIOR, -1.5, true);
    drive(1.0, PRIOR, 0.0, true);
    drive(way_back, PRIOR, 1.5, true);
    drive(2.0, (900.0, 30.0), -1.5, false);
    drive(0.6, PRIOR, 0.0, true);
    drive(2.0, (10.0, 20.0), 0.0, false);
}

#[test]
fn a_bucket_that_is_pushed_in_twice_holds_one_load_and_a_way_to_the_truck_makes_two() {
    for (way_back, loads) in [(0.0, 1), (3.0, 2)] {
        let mut site = Site::new(None);
        push_in(&mut site, way_back);
        let found = site.loads();
        assert_eq!(found.len(), loads, "{way_back}: {found:?}");
        assert!(found[loads - 1].weight.quantity().holds(900.0));
    }
}

#[test]
fn a_load_that_is_driven_through_a_gap_is_one_load() {
    let mut site = Site::new(None);
    let mut drive = |seconds: f64, weighed: Option<f64>| {
        for _ in 0..(seconds / DT) as u32 {
            site.time += DT;
            let events = site.ledger.step(&Row {
                time: site.time,
                payload: weighed.map(|value| Quantity { value, std: 30.0 }),
                speed: 5.0,
                trusted: true,
                witness: Witness::Pressure,
                ..Row::default()
            });
            site.said.extend(events.load);
        }
    };
    drive(2.0, Some(10.0));
    drive(2.0, Some(900.0));
    for _ in 0..4 {
        drive(1.0, None);
        drive(2.0, Some(890.0));
    }
    drive(2.0, Some(10.0));
    assert_eq!(site.loads().len(), 1);
}

#[test]
fn a_load_that_leaves_before_a_gap_is_not_the_equal_one_after_it() {
    let loads = |opens: bool| {
        let mut site = Site::new(None);
        site.stand(3.0, PRIOR);
        site.swing(800.0);
        if opens {
            site.open();
        }
        site.time += 4.0;
        site.stand(1.0, PRIOR);
        site.swing(800.0);
        site.open();
        site.swing(20.0);
        site.loads().len()
    };
    assert_eq!(loads(true), 2);
    assert_eq!(loads(false), 1, "nothing left before the gap");
}

#[test]
fn a_scale_that_rises_slowly_fills_one_load_and_scoops_add_to_it() {
    let mut site = Site::new(None);
    site.stand(2.0, (0.0, 15.0));
    for i in 0..1000 {
        site.row((0.6 * f64::from(i), 15.0), 0.2, false);
    }
    site.stand(2.0, (600.0, 15.0));
    site.stand(2.0, (900.0, 15.0));
    for i in 0..100 {
        site.row((900.0 - 9.0 * f64::from(i), 15.0), 0.2, false);
    }
    site.stand(2.0, (5.0, 15.0));
    let loads = site.loads();
    assert_eq!(loads.len(), 1, "{loads:?}");
    assert!(loads[0].weight.quantity().holds(900.0));
}

#[test]
fn a_load_dumped_in_two_halves_is_two_loads_that_add_up() {
    let mut site = Site::new(None);
    for kg in [0.0, 900.0, 450.0, 0.0] {
        site.stand(2.0, (kg, 15.0));
    }
    assert_eq!(site.loads().len(), 2);
    assert!((site.ledger.all().kg - 900.0).abs() < 1.0);
}

/// Total of ten loads of 800 kg whose weight has these standard deviations: of rests, of common zero and scale.
fn ten_loads(rest: f64, zero_std: f64, scale_std: f64) -> (Quantity, Vec<Load>) {
    let mut site = Site::new(None);
    site.common = Some(CommonError {
        scale_std,
        zero_std,
    });
    for k in 0..10 {
        site.stand(
            2.0,
            (800.0, 15.0_f64.hypot(zero_std).hypot(800.0 * scale_std)),
        );
        let noise = if k % 2 == 0 { rest } else { -rest };
        site.stand(2.0, (noise, rest.max(15.0).hypot(zero_std)));
    }
    let loads = site.loads();
    let all = site.ledger.all();
    let total = Quantity {
        value: all.kg,
        std: all.std(),
    };
    (total, loads)
}

#[test]
fn a_zero_error_cancels_between_load_and_rest_and_a_scale_error_does_not() {
    let [sound, zero, scale] = [[0.0; 2], [60.0, 0.0], [0.0, 0.06]].map(|[zero, scale]| {
        let (total, loads) = ten_loads(0.0, zero, scale);
        assert_eq!(loads.len(), 10);
        total.std
    });
    assert!(zero < 1.5 * sound, "{zero} {sound}");
    assert!((scale - 0.06 * 8000.0).abs() < 0.1 * scale, "{scale}");
}

#[test]
fn what_a_lift_arm_s_loads_are_off_together_is_at_most_a_share_of_each_row() {
    let known = |witness: Witness, std: f64| {
        let arm = CommonError {
            scale_std: 0.06,
            zero_std: 60.0,
        };
        let mut ledger = Ledger::new(Settings {
            lift_arm: Some(arm),
            ..Settings::with_rated(RATED)
        });
        for k in 0..400 {
            ledger.step(&Row {
                time: DT * f64::from(k),
                payload: Some(Quantity { value: 800.0, std }),
                trusted: true,
                witness,
                ..Row::default()
            });
        }
        let weight = ledger.carried().expect("a load").weight;
        assert!(weight.common_std <= 0.9 * weight.std, "{weight:?}");
        weight.known
    };
    assert_eq!(known(Witness::Pressure, 100.0).zero_std, 60.0);
    // An emptied bucket has shown most of it.
    let left = known(Witness::Pressure, 40.0);
    assert!(left.std(800.0) < 40.0 && left.zero_std > 10.0, "{left:?}");
    assert_eq!(known(Witness::Scale, 40.0), CommonError::default());
}

#[test]
fn a_rest_that_is_weighed_badly_adds_no_more_than_an_emptied_bucket_can_keep() {
    let (total, loads) = ten_loads(150.0, 0.0, 0.0);
    assert!(loads.iter().all(|load| load.is_emptied), "{loads:?}");
    let left = |load: &Load| load.carry_back.kg.abs();
    assert!(loads.iter().all(|load| left(load) < 75.0), "{loads:?}");
    assert!(
        total.holds(8000.0) && total.std < 10.0_f64.sqrt() * 90.0,
        "{total:?}"
    );
}

#[test]
fn what_is_left_for_a_second_truck_is_no_emptied_bucket() {
    let mut site = Site::new(None);
    for kg in [900.0, 300.0, 20.0] {
        site.stand(2.0, (kg, 60.0));
    }
    let loads = site.loads();
    assert!(!loads[0].is_emptied && (loads[0].carry_back.kg - 300.0).abs() < 1.0);
}

#[test]
fn ten_loads_are_not_ten_times_as_certain() {
    let mut site = Site::new(None);
    for _ in 0..10 {
        site.cycle(800.0, 20.0);
    }
    let one = site.loads()[0].delivered().std;
    let all = site.ledger.all();
    assert_eq!(all.loads, 10);
    assert!(
        all.std() > 0.8 * 10.0 * one,
        "shared errors add up: {} {one}",
        all.std()
    );
    assert!(all.std() < 10.0 * one, "those of each load average out");
}

#[test]
fn trucks_begin_by_key_signal_or_pause() {
    let mut site = Site::new(Some(2400.0));
    site.truck = Some(7.0);
    site.cycle(900.0, 20.0);
    site.cycle(900.0, 20.0);
    let missing = site.ledger.truck().remaining().expect("a target");
    assert!((missing - 640.0).abs() < 80.0, "{missing}");
    let events = site.ledger.next_truck();
    site.note(events);
    assert!(
        site.ledger.next_truck().is_empty(),
        "an empty truck is none"
    );
    site.cycle(500.0, 20.0);
    site.truck = Some(8.0);
    site.cycle(600.0, 20.0);
    site.time += 400.0;
    site.cycle(700.0, 20.0);
    site.loads();
    let counts: Vec<_> = site
        .trucks
        .iter()
        .map(|t| (t.number, t.total.loads))
        .collect();
    assert_eq!(counts, [(1, 2), (2, 1), (3, 1), (4, 1)]);
    assert_eq!(site.ledger.day().trucks, 4);
}

#[test]
fn days_end_at_midnight() {
    let mut site = Site::new(None);
    site.time = 86_380.0;
    site.cycle(900.0, 20.0);
    site.time += 10.0;
    site.cycle(800.0, 20.0);
    let days: Vec<i64> = site.loads().iter().map(|l| l.day).collect();
    assert_eq!(days, [0, 1]);
}

#[test]
fn a_controller_gets_a_value_always_and_never_the_prior_again() {
    let mut site = Site::new(None);
    assert!(site.ledger.now().std > 0.0, "before any row");
    site.swing(800.0);
    let swung = site.ledger.now();
    assert!((swung.kg - 800.0).abs() < 40.0 && swung.age.is_some_and(|a| a < 0.1));
    site.stand(5.0, PRIOR);
    let stood = site.ledger.now();
    assert_eq!(stood.kg, swung.kg, "the last known value");
    assert!(stood.age.is_some_and(|a| (a - 5.0).abs() < 0.1));
    assert!(1.96 * stood.std > stood.kg, "it may have been emptied");
    site.swing(30.0);
    assert!(
        (site.ledger.now().kg - 30.0).abs() < 60.0,
        "{:?}",
        site.ledger.now()
    );
    let before = site.ledger.now();
    site.time += 3.0;
    let nothing = Row {
        time: site.time,
        ..Row::default()
    };
    site.ledger.step(&nothing);
    let after = site.ledger.now();
    assert!(after.kg == before.kg && after.std > 3.0 * before.std);
}

#[test]
fn nothing_that_comes_in_lets_a_number_out_that_is_none() {
    let bad = [
        f64::NAN,
        f64::INFINITY,
        -f64::INFINITY,
        1e300,
        -1e300,
        0.0,
        -1.0,
    ];
    for (rated, latest) in [
        (RATED, 1e12),
        (RATED, f64::MAX),
        (0.0, 1e12),
        (f64::NAN, 1e12),
        (1e160, 1e12),
    ] {
        let mut ledger = Ledger::new(Settings::with_rated(rated));
        let mut seed = 1_u64;
        let mut time = 0.0;
        for i in 0..20_000 {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let pick = (seed >> 33) as usize;
            let any = |k: usize, good: f64| {
                if (pick >> k).is_multiple_of(5) {
                    bad[(pick >> 3) % bad.len()]
                } else {
                    good
                }
            };
            time += any(2, 0.01);
            if !time.is_finite() || time.abs() > latest {
                time = f64::from(i);
            }
            let row = Row {
                time,
                payload: Some(Quantity {
                    value: any(4, 900.0 * f64::from((i / 500) % 2)),
                    std: any(6, 20.0),
                }),
                common: Some(CommonError {
                    scale_std: any(8, 0.02),
                    zero_std: any(9, 10.0),
                }),
                speed: any(10, 0.3),
                changing: pick.is_multiple_of(7),
                truck: Some(any(12, 1.0)),
                ..Row::default()
            };
            let events = ledger.step(&row);
            let (now, truck) = (ledger.now(), ledger.truck());
            assert!(
                now.kg.is_finite() && now.std.is_finite() && now.std >= 0.0,
                "{row:?} {now:?} {ledger:?}"
            );
            assert!(
                truck.total.kg.is_finite() && truck.total.std().is_finite(),
                "{row:?}"
            );
            if let Some(load) = events.load {
                assert!(load.weight.kg.is_finite() && load.weight.std.is_finite());
                assert!(load.filled.is_finite() && load.dumped.is_none_or(f64::is_finite));
                assert!(load.dumped.is_none_or(|t| t >= load.filled), "{load:?}");
            }
        }
    }
}
