//! Accepted descriptions, their printed form, and the errors of refused ones.

use config::{Description, Excavator, Form, Loader, Numbers, Tables, Value, Variant};
use messages::Machine;

/// One error of a text that is meant to have exactly one.
fn error(text: &str) -> config::Error {
    let errors = Excavator::parse(text, "bench.toml").expect_err("the text is wrong");
    assert_eq!(errors.0.len(), 1, "{errors}");
    errors.0[0].clone()
}

#[test]
fn an_empty_description_is_the_reference_machine() {
    let excavator = Excavator::parse("", "empty.toml").expect("nothing to refuse");
    assert_eq!(excavator, Excavator::default());
    assert_eq!(excavator.machine.nominal_damping, 1500.0);
    assert_eq!(Loader::parse("", "empty.toml"), Ok(Loader::default()));
}

#[test]
fn every_default_lies_in_its_own_range_and_contradicts_nothing() {
    fn check<M: Tables>() {
        let machine = M::default();
        assert!(machine.contradictions().is_empty());
        for table in machine.tables() {
            for (i, key) in table.keys().iter().enumerate() {
                let value = table.get(i).expect("every key has a value");
                let numbers = match value {
                    Value::Number(x) => vec![x],
                    Value::Numbers(list) => list.to_vec(),
                    _ => vec![],
                };
                if matches!(
                    key.form,
                    Form::Number | Form::Count | Form::List(_) | Form::Numbers
                ) {
                    let range = key.range.expect("numbers have a range");
                    assert!(numbers.iter().all(|x| (range.low..=range.high).contains(x)));
                }
                assert!(key.doc.trim().ends_with('.'), "{} is documented", key.name);
            }
        }
    }
    check::<Excavator>();
    check::<Loader>();
}

#[test]
fn the_printed_description_reads_back_to_the_last_bit() {
    let mut excavator = Excavator::paper_preset(4451.320000000001);
    excavator.sensors.swing_velocity_std = 0.1 + 0.2;
    excavator.estimator.q_c = f64::MIN_POSITIVE.max(1e-15);
    excavator.estimator.variant = Variant::Tolerant;
    excavator.estimator.forgetting = Numbers::new(&[1.0 - f64::EPSILON]).expect("one number");
    let text = excavator.to_toml();
    assert_eq!(Excavator::parse(&text, "x"), Ok(excavator));
    let text = Loader::default().to_toml();
    assert_eq!(Loader::parse(&text, "x"), Ok(Loader::default()));
}

#[test]
fn an_unknown_key_names_its_line_and_the_nearest_key() {
    let e = error("[sensors]\nrate = 100\n\nswing_velocty_std = 0.01\n");
    assert_eq!(
        (e.line, e.key.as_str()),
        (Some(4), "sensors.swing_velocty_std")
    );
    assert_eq!(e.remedy, "did you mean sensors.swing_velocity_std?");
}

#[test]
fn a_key_in_the_wrong_table_is_answered_with_its_place() {
    let e = error("[machine]\nrate = 100\n");
    assert_eq!(e.remedy, "the key is sensors.rate: put it under [sensors]");
}

#[test]
fn a_key_of_the_other_machine_is_named_as_such() {
    let e = error("machine.wheelbase = 2.3\n");
    assert_eq!(
        e.remedy,
        "machine.wheelbase belongs to the loader; leave it out here"
    );
}

#[test]
fn an_unknown_table_names_its_line_and_the_nearest_table() {
    let e = error("\n[sensor]\nrate = 100\n");
    assert_eq!(
        (e.line, e.remedy.as_str()),
        (Some(2), "did you mean [sensors]?")
    );
}

#[test]
fn a_number_out_of_range_is_answered_with_the_range_and_the_unit() {
    let e = error("[sensors]\nrate = -5\n");
    assert_eq!(e.what, "sensors.rate is -5 Hz, outside from 1 to 100000 Hz");
    assert_eq!(
        e.to_string(),
        "sensors.rate is -5 Hz, outside from 1 to 100000 Hz\n  where: bench.toml:2, key sensors.rate\n  \
         what to do: give a number from 1 to 100000 Hz"
    );
    assert!(
        error("[estimator]\nforgetting = [0.9, 1.5, 0.9]")
            .what
            .contains("1.5")
    );
    assert!(error("[sensors]\nrate = nan").what.contains("NaN"));
}

#[test]
fn text_for_a_number_is_answered_with_how_to_write_it() {
    let e = error("[sensors]\nrate = \"fast\"\n");
    assert_eq!(
        e.what,
        "sensors.rate is a word; it takes a number from 1 to 100000 Hz"
    );
    assert_eq!(e.remedy, "write it like rate = 100.0");
    let e = error("[estimator]\nvariant = \"best\"\n");
    assert!(
        e.what.ends_with("\"auto\" or \"known\" or \"tolerant\""),
        "{e}"
    );
    let e = error("[estimator.paper]\nlambda_normal = [0.9, 0.9]\n");
    assert!(e.what.contains("a list of 3 numbers"), "{e}");
}

#[test]
fn broken_toml_names_its_line() {
    let e = error("[sensors]\nrate = 100\nrate = 200\n");
    assert_eq!(e.line, Some(3), "{e}");
    assert_eq!(error("[sensors\n").line, Some(1));
    assert_eq!(error("[sensors]\nrate 100\n").line, Some(2));
}

#[test]
fn contradictions_between_keys_are_found() {
    let e = error("[machine]\ninertia_min = 30000\n");
    assert_eq!((e.line, e.key.as_str()), (Some(2), "machine.inertia_min"));
    let e = error("[prior]\ninertia = 100\n");
    assert_eq!((e.line, e.key.as_str()), (Some(2), "prior.inertia"));
    let e = error("[machine]\noperating_mass = 5500\n[machine.geometry]\nboom_length = 0\n");
    assert_eq!(e.key, "machine.geometry.boom_length");
    assert!(Loader::parse("[prior]\ncg_height = 4.0", "x").is_err());
}

#[test]
fn a_mass_in_newtons_and_a_wheelbase_in_millimetres_are_found() {
    let check = |text: &str| Description::parse(text, "x", Some(Machine::Loader));
    for wrong in [
        "[machine]\nmass = 46000\nwheelbase = 2.3",
        "[machine]\nmass = 120000\nwheelbase = 2.9",
    ] {
        let errors = check(wrong).expect_err("newtons").to_string();
        assert!(
            errors.contains("newtons where kilograms belong"),
            "{errors}"
        );
    }
    for right in [
        "[machine]\nmass = 4700\nwheelbase = 2.3",
        "[machine]\nmass = 50000\nwheelbase = 4.5",
        "[machine]\nmass = 5\nwheelbase = 0.1\nwheel_radius = 0.03",
    ] {
        assert!(check(right).is_ok(), "{right}");
    }
}

#[test]
fn all_defects_are_reported_at_once_in_the_order_of_the_file() {
    let text = "[sensors]\nrate = 0\nspeed = 3\n[prior]\npayload = true\n";
    let errors = Excavator::parse(text, "x.toml").expect_err("three defects");
    let lines: Vec<_> = errors.0.iter().map(|e| e.line).collect();
    assert_eq!(lines, [Some(2), Some(3), Some(5)]);
    assert_eq!(errors.to_string().lines().count(), 9);
}

#[test]
fn set_overrides_one_key_and_refuses_without_a_change() {
    let mut excavator = Excavator::default();
    excavator
        .set("sensors.swing_velocity_std=0.008")
        .expect("a known key");
    assert_eq!(excavator.sensors.swing_velocity_std, 0.008);
    excavator
        .set("estimator.variant=known")
        .expect("a word needs no quotes");
    assert_eq!(excavator.estimator.variant, Variant::Known);
    excavator
        .set("estimator.forgetting=0.97")
        .expect("one factor is a list of one");
    assert_eq!(*excavator.estimator.forgetting, [0.97]);
    excavator
        .set("estimator.convergence_delay = 0.2")
        .expect("spaces are harmless");
    excavator
        .set("estimator.convergence_delay=none")
        .expect("none unsets");
    assert_eq!(excavator.estimator.convergence_delay, None);
    let before = excavator.clone();
    let unknown = excavator.set("sensors.rat=5").expect_err("no such key");
    assert_eq!(unknown.remedy, "did you mean sensors.rate?");
    assert!(
        unknown.to_string().contains("where: --set sensors.rat=5"),
        "{unknown}"
    );
    for wrong in [
        "sensors.rate",
        "sensors.rate=0",
        "machine.inertia_max=1",
        "rate=1",
        "=",
        "",
    ] {
        assert!(excavator.set(wrong).is_err(), "{wrong}");
    }
    assert_eq!(excavator, before);
}

#[test]
fn limits_can_be_moved_together() {
    let mut excavator = Excavator::default();
    let all = [
        "machine.inertia_min=30000",
        "machine.inertia_max=90000",
        "prior.inertia=50000",
    ];
    assert!(
        excavator.set(all[0]).is_err(),
        "alone it contradicts the others"
    );
    excavator.set_all(&all).expect("together they fit");
    assert_eq!(excavator.machine.inertia_max, 90000.0);
}

#[test]
fn a_description_finds_out_for_which_machine_it_is() {
    let of = |text: &str| Description::parse(text, "x", None).map(|d| d.machine());
    assert_eq!(of("machine.kind = \"loader\""), Ok(Machine::Loader));
    assert_eq!(
        of("[machine]\nwheelbase = 2.0\n[sensors]\nrate = 100"),
        Ok(Machine::Loader)
    );
    assert_eq!(
        of("[machine.geometry]\nboom_length = 4"),
        Ok(Machine::Excavator)
    );
    assert!(of("[sensors]\nrate = 100").is_err());
    let given = Description::parse("[sensors]\nrate = 100", "x", Some(Machine::Loader));
    assert_eq!(given.map(|d| d.machine()), Ok(Machine::Loader));
    let printed = Description::default_of(Machine::Loader).to_toml();
    assert_eq!(of(&printed), Ok(Machine::Loader));
    assert!(Excavator::parse(&printed, "x").is_err());
    for kind in ["\"crane\"", "3"] {
        let refused = of(&format!("machine.kind = {kind}\nmachine.wheelbase = 2.0"));
        let said = refused.expect_err("no machine").to_string();
        assert!(
            said.contains(&format!("there is no machine {kind}")),
            "{said}"
        );
        assert!(said.contains("x:1, key machine.kind"), "{said}");
    }
}

#[test]
fn the_shipped_descriptions_are_valid() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/descriptions");
    let mut found = 0;
    for entry in std::fs::read_dir(folder).expect("the folder") {
        let path = entry.expect("an entry").path();
        let text = std::fs::read_to_string(&path).expect("readable");
        let name = path.display().to_string();
        Description::parse(&text, &name, None).unwrap_or_else(|errors| panic!("{errors}"));
        found += 1;
    }
    assert!(found >= 3);
}

#[test]
fn an_operating_mass_scales_what_is_not_stated_and_nothing_that_is() {
    let said = "[machine]\nkind = \"excavator\"\noperating_mass = 21500\nrated_payload = 1900\n[machine.geometry]\nboom_length = 5.7\n";
    let of_file = Excavator::parse(said, "m.toml").expect("valid");
    assert_eq!(of_file.geometry.boom_length, 5.7);
    assert!((of_file.geometry.boom_centre / 5.7 - 0.48).abs() < 1e-9);
    assert!((25e3..40e3).contains(&of_file.machine.upper_inertia));
    assert_eq!(of_file.estimator.payload_max, 1.6 * 1900.0);
    let again = Excavator::parse(&of_file.to_toml(), "again.toml").expect("valid");
    assert_eq!(again, of_file);

    let mut by_set = Excavator::default();
    by_set
        .set_all(&[
            "machine.rated_payload=1900",
            "machine.geometry.boom_length=5.7",
        ])
        .expect("valid");
    by_set.set("machine.operating_mass=21500").expect("valid");
    assert_eq!(by_set, of_file);
}

#[test]
fn what_a_loader_s_file_leaves_open_follows_from_its_mass_whoever_states_it() {
    let few = "[machine]\nkind = \"loader\"\nmass = 25000\nwheel_radius = 0.8\n";
    let of_file = Loader::parse(few, "loader.toml").expect("valid");
    assert_eq!(of_file.machine.wheel_radius, 0.8);
    assert!((of_file.machine.wheelbase - 3.98).abs() < 0.01);
    assert!((of_file.prior.cg_height - 1.49).abs() < 0.01);
    let share = of_file.estimator.converged_height / of_file.prior.cg_height;
    assert!((share - 0.089).abs() < 1e-3, "{share}");
    let mut by_set = Loader::default();
    by_set.set("machine.mass=9000").expect("valid");
    by_set.set("machine.wheel_radius=0.8").expect("valid");
    by_set.set("machine.mass=25000").expect("valid");
    assert_eq!(by_set, of_file);
    let stated: Vec<&str> = Description::Loader(Box::new(of_file))
        .stated()
        .into_keys()
        .collect();
    assert_eq!(stated, ["machine.mass", "machine.wheel_radius"]);
}

#[test]
fn wheels_of_a_class_are_as_large_as_tyres_and_a_stated_radius_carries_their_inertia() {
    let of = |sets: &[&str]| {
        let mut loader = Loader::default();
        loader.set_all(sets).expect("valid");
        loader
    };
    for (mass, tyre) in [
        (2500.0, 0.38),
        (10e3, 0.63),
        (13e3, 0.70),
        (19e3, 0.77),
        (50e3, 0.98),
    ] {
        let class = of(&[&format!("machine.mass={mass}")]);
        let away = class.machine.wheel_radius / tyre - 1.0;
        assert!(away.abs() < 2.0 * class.prior.radius_std, "{mass}: {away}");
    }
    let stated = of(&["machine.mass=33000", "machine.wheel_radius=0.8"]);
    assert_eq!(stated.prior.radius_std, Loader::default().prior.radius_std);
    assert!((stated.machine.axle_inertia - 0.035 * 33e3 * 0.64).abs() < 1e-6);
    let reference = of(&["machine.mass=4800"]);
    assert_eq!(
        reference.machine.wheel_radius,
        Loader::default().machine.wheel_radius
    );
    assert_eq!(reference.prior, Loader::default().prior);
}

#[test]
fn a_class_is_a_valid_machine_of_any_size() {
    for machine in Machine::ALL {
        for mass in [1500.0, 5000.0, 21e3, 90e3] {
            let mut description = Description::default_of(machine);
            let key = config::mass_key(machine);
            description.set(&format!("{key}={mass}")).expect("valid");
        }
    }
}

#[test]
fn a_key_without_a_successor_is_left_out() {
    for (old, name) in [
        ("[estimator]\ndrop_q_m = 62500.0\n", "estimator.drop_q_m"),
        (
            "[machine.arm_cylinder]\ncount = 2.0\n",
            "machine.arm_cylinder",
        ),
        (
            "machine.arm_cylinder = { rod_area = 0.005 }\n",
            "machine.arm_cylinder",
        ),
        (
            "machine.boom_cylinder.rod_area_std = 1e-5\n",
            "machine.boom_cylinder.rod_area_std",
        ),
        ("sensors.pressure_std = 1e4\n", "sensors.pressure_std"),
    ] {
        let read = Excavator::parse(old, "old.toml");
        assert_eq!(read, Ok(Excavator::default()), "{old}");
        assert_eq!(config::old_names(Machine::Excavator, old), [name]);
    }
    let mut set = Excavator::default();
    let retired = ["machine.arm_cylinder.count=2", "sensors.pressure_std=1e4"];
    set.set_all(&retired).expect("read");
    assert_eq!(set, Excavator::default());
    assert!(
        set.set("machine.arm_cylinders.count=2").is_err(),
        "no such key"
    );
    // The loader has this key.
    let loader = "sensors.pressure_std = 1e4\n";
    let read = Loader::parse(loader, "x").expect("valid");
    assert_eq!(read.sensors.pressure_std, 1e4);
    assert!(config::old_names(Machine::Loader, loader).is_empty());
}

#[test]
fn a_key_is_read_by_its_old_name_too_and_not_by_both() {
    let old = "[sensors]\nslope_follows = 0.3\nslope_follows_std = 0.05\n";
    let today = old.replace("slope_follows", "slope_acceleration_sensitivity");
    let read = Loader::parse(old, "old.toml").expect("valid");
    assert_eq!(read.sensors.slope_acceleration_sensitivity, 0.3);
    assert_eq!(Ok(&read), Loader::parse(&today, "new.toml").as_ref());
    assert!(!read.to_toml().contains("slope_follows"));
    assert_eq!(
        config::old_names(Machine::Loader, old),
        ["sensors.slope_follows", "sensors.slope_follows_std"]
    );
    assert!(config::old_names(Machine::Loader, &today).is_empty());
    let machine = Description::parse(old, "old.toml", None).map(|found| found.machine());
    assert_eq!(machine, Ok(Machine::Loader), "by its keys alone");

    let mut set = Loader::default();
    set.set("sensors.slope_follows=0.3").expect("valid");
    assert_eq!(set.sensors.slope_acceleration_sensitivity, 0.3);
    let wrong = set.set("sensors.slope_follows=3").expect_err("too large");
    assert_eq!(wrong.key, "sensors.slope_acceleration_sensitivity");

    let both = format!("{old}slope_acceleration_sensitivity = 0.2\n");
    let errors = Loader::parse(&both, "both.toml").expect_err("stated twice");
    assert_eq!((errors.0.len(), errors.0[0].line), (1, Some(4)));
}

#[test]
fn what_is_stated_are_the_keys_that_the_size_does_not_give() {
    let stated = |d: &Description| d.stated().into_keys().collect::<Vec<_>>();
    for machine in Machine::ALL {
        assert!(stated(&Description::default_of(machine)).is_empty());
    }
    let mut sized = Description::default_of(Machine::Excavator);
    let said = [
        "machine.operating_mass=21500",
        "machine.geometry.boom_length=5.7",
    ];
    sized.set_all(&said).expect("valid");
    assert_eq!(
        stated(&sized),
        ["machine.geometry.boom_length", "machine.operating_mass"],
        "and nothing that follows from them"
    );
    // The value of the reference machine, on a machine of another size.
    let reference = Excavator::default().geometry.boom_mass;
    let boom = format!("machine.geometry.boom_mass={reference}");
    sized.set(&boom).expect("valid");
    assert!(stated(&sized).contains(&"machine.geometry.boom_mass"));
}

#[test]
fn a_description_differs_from_an_earlier_one_by_what_either_states() {
    let mut now = Description::default_of(Machine::Loader);
    now.set("sensors.slope_follows=0.3").expect("valid");
    let earlier = |key: &str, value: &str| {
        let pair = (key.to_owned(), value.to_owned());
        now.changed_since(&[pair].into())
    };
    let key = "sensors.slope_acceleration_sensitivity";
    assert!(earlier(key, "0.3").is_empty());
    assert!(
        earlier("sensors.slope_follows", "0.3").is_empty(),
        "its old name"
    );
    assert_eq!(earlier(key, "0.2"), [key]);
    assert_eq!(earlier("machine.mass", "11000.0"), ["machine.mass", key]);
    assert_eq!(
        now.changed_since(&Default::default()),
        [key],
        "it was a default"
    );
    let gone = [(key, "0.3"), ("machine.no_longer", "1.0")];
    let gone = gone.map(|(key, value)| (key.to_owned(), value.to_owned()));
    assert!(now.changed_since(&gone.into()).is_empty());
}

#[test]
fn numbers_are_set_as_people_write_them() {
    let mut excavator = Excavator::default();
    for (text, value) in [(".05", 0.05), ("+0.3", 0.3), ("00.2", 0.2), ("3.e-1", 0.3)] {
        let set = format!("sensors.swing_torque_delay={text}");
        excavator.set(&set).expect("a number");
        assert_eq!(excavator.sensors.swing_torque_delay, value, "{text}");
    }
    excavator.set("sensors.rate=5.").expect("a number");
    excavator.set("sensors.rate=1e2").expect("a number");
    assert_eq!(excavator.sensors.rate, 100.0);
    excavator
        .set("machine.rated_payload=.5e3")
        .expect("a number");
    assert_eq!(excavator.machine.rated_payload, Some(500.0));
    excavator
        .set("estimator.paper.covariance=[.5, 5., +1]")
        .expect("a list");
    for wrong in [
        "sensors.rate=inf",
        "sensors.rate=0,5",
        "sensors.rate=.",
        "estimator.variant=.5",
    ] {
        assert!(excavator.set(wrong).is_err(), "{wrong}");
    }
}

#[test]
fn a_number_that_is_nearer_to_zero_than_anything_of_a_machine_is_refused() {
    let mut excavator = Excavator::default();
    let error = excavator
        .set("machine.geometry.bucket_mass=1.3e-160")
        .expect_err("no mass");
    assert!(
        error
            .what
            .contains("nearer to 0 than anything of a machine"),
        "{error}"
    );
    assert!(error.remedy.contains("from 0 to"), "{error}");
    excavator
        .set("machine.geometry.bucket_mass=0")
        .expect("zero is none");
}

#[test]
fn a_length_that_is_that_of_the_reference_machine_is_stated_all_the_same() {
    let of = |length: f64| {
        let text = format!(
            "[machine]\noperating_mass = 6500\n[machine.geometry]\nboom_length = {length:?}\n"
        );
        Excavator::parse(&text, "x").expect("a machine file")
    };
    let [same, beside] = [of(3.0), of(3.000001)];
    assert_eq!(
        same.machine.geometry_tolerance,
        beside.machine.geometry_tolerance
    );
    assert!((same.geometry.boom_centre - beside.geometry.boom_centre).abs() < 1e-5);
    assert!((same.geometry.boom_centre - 1.44).abs() < 1e-3);
    // Also where it is printed with all the rest, and read again.
    assert_eq!(Excavator::parse(&same.to_toml(), "x"), Ok(same));
    let mut set = Excavator::default();
    set.set_all(&[
        "machine.geometry.boom_length=3",
        "machine.operating_mass=6500",
    ])
    .expect("keys");
    assert!((set.geometry.boom_centre - 1.44).abs() < 1e-3);
    let loader = "[machine]\nmass = 6000\nwheel_radius = 0.55\n";
    let loader = Loader::parse(loader, "x").expect("a machine file");
    assert_eq!(loader.machine.wheel_radius, 0.55);
    assert_eq!(Loader::parse(&loader.to_toml(), "x"), Ok(loader));
}

#[test]
fn a_printed_file_with_another_mass_has_the_rest_of_its_size() {
    let printed = Excavator::default().to_toml();
    let changed = printed
        .replace("operating_mass = \"none\"", "operating_mass = 22000.0")
        .replace("boom_length = 3.0", "boom_length = 5.7");
    let of_print = Excavator::parse(&changed, "x").expect("a machine file");
    let short = "[machine]\noperating_mass = 22000\n[machine.geometry]\nboom_length = 5.7\n";
    assert_eq!(
        of_print,
        Excavator::parse(short, "x").expect("a machine file")
    );
    let printed = Loader::default().to_toml();
    let changed = printed.replacen("mass = 4700.0", "mass = 12000.0", 1);
    let of_print = Loader::parse(&changed, "x").expect("a machine file");
    let short = Loader::parse("[machine]\nmass = 12000\n", "x");
    assert_eq!(Ok(of_print), short);
}

#[test]
fn a_misspelt_key_is_named_though_nothing_says_which_machine() {
    for (text, meant) in [
        ("[machine]\noperating_mas = 21500\n", "operating_mass"),
        ("[machne]\nboom_length = 5\n", "[machine]"),
        ("[machine.geometry]\nboom_lenght = 5\n", "boom_length"),
    ] {
        let errors = Description::parse(text, "a.toml", None).expect_err("it is misspelt");
        assert!(errors.to_string().contains(meant), "{errors}");
    }
    let errors = Description::parse("", "a.toml", None).expect_err("nothing is said");
    assert!(errors.to_string().contains("which machine"), "{errors}");
}

#[test]
fn a_text_states_what_stands_in_it() {
    let text = "[machine]\nmass = 4700\n[machine.lift_arm]\nlength = 2.0\n";
    let states = |key| Description::states(Machine::Loader, text, key);
    assert!(states("machine.mass") && states("machine.lift_arm.length"));
    assert!(!states("machine.wheelbase") && !states("prior.cg_ratio"));
    let printed = Loader::default().to_toml();
    assert!(!Description::states(
        Machine::Loader,
        &printed,
        "machine.mass"
    ));
}

#[test]
fn keys_without_their_tables_are_answered_with_the_tables_of_their_machine() {
    let said = |text: &str| {
        let errors = Description::parse(text, "m.toml", None).expect_err("keys without tables");
        let all = errors.0.into_iter().map(|e| e.to_string());
        all.collect::<Vec<_>>().join("\n")
    };
    let excavator = said("operating_mass = 17000\nboom_length = 5.2\nboom_pin = 0.2\n");
    for table in ["[machine]", "[machine.geometry]"] {
        let remedy = format!("put it under {table}");
        assert!(excavator.contains(&remedy), "{excavator}");
    }
    let loader = said("kind = \"loader\"\n[machine]\nmass = 5200\n");
    assert!(loader.contains("put it under [machine]"), "{loader}");
    assert!(!loader.contains("the tables are"), "{loader}");
    let other = said("kind = \"digger\"\n");
    assert!(other.contains("there is no machine \"digger\""), "{other}");
}
