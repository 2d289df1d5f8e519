//! The machine as a drawing whose joints turn with the measured angles. It is not to scale: it shows the posture, and which
//! angles are measured. The live page turns the same groups by their names.

use std::fmt::Write;

use messages::{Machine, Message, Value, Words};

use crate::run::Input;

/// Signals that move the drawing \[rad\]: joint angles, and the slope under the machine.
pub const JOINTS: [&str; 7] = [
    "swing_angle",
    "boom_angle",
    "arm_angle",
    "bucket_angle",
    "lift_angle",
    "tilt_angle",
    "slope",
];

/// Posture of a machine: the last measured angle of each of [`JOINTS`] \[rad\].
pub type Posture = [Option<f64>; JOINTS.len()];

/// Takes the valid angles of a message of sensors.
pub fn take<M: Message>(posture: &mut Posture, sensors: &M) {
    let Some(Words::Bits(bits)) = Words::of_field(M::WORDS, "valid") else {
        return;
    };
    let valid = M::index("valid").and_then(|i| sensors.get(i));
    let Some(Value::U32(valid)) = valid else {
        return;
    };
    for (angle, name) in posture.iter_mut().zip(JOINTS) {
        let bit = bits.iter().find(|entry| entry.name == name);
        if bit.is_some_and(|entry| valid & entry.number != 0) {
            let value = M::index(name).and_then(|i| sensors.get(i));
            *angle = value.map(Value::as_f64).filter(|x| x.is_finite());
        }
    }
}

/// Posture of a machine at `time` \[s\], by the last measurements before it; `None` if no joint was measured.
pub fn at(inputs: &[Input], time: f64) -> Option<Posture> {
    let angle = |name: &&str| {
        let input = inputs.iter().find(|input| input.name == *name)?;
        let before = input.points.partition_point(|(t, _)| *t <= time);
        let values = input.points[..before].iter().map(|point| point.1);
        values.rev().find(|value| value.is_finite())
    };
    let posture = JOINTS.each_ref().map(angle);
    posture.iter().any(Option::is_some).then_some(posture)
}

/// A joint in the drawing: its signal, its position on the link before it [px], and its angle if none is measured [rad].
struct Joint {
    signal: &'static str,
    at: (f64, f64),
    usual: f64,
}

impl Joint {
    fn open(&self, out: &mut String, posture: &Posture) {
        let place = JOINTS.iter().position(|name| *name == self.signal);
        let measured = place.and_then(|i| posture[i]);
        let class = if measured.is_some() {
            "joint"
        } else {
            "joint unmeasured"
        };
        let angle = measured.unwrap_or(self.usual);
        let (x, y) = self.at;
        // Angles are positive upwards, and the picture's y axis points down.
        let _ = write!(
            out,
            "<g transform=\"translate({x} {y})\"><g class=\"{class}\" data-joint=\"{}\" transform=\"rotate({:.1})\">",
            self.signal,
            -angle.to_degrees()
        );
    }
}

/// The drawing of a machine as SVG.
pub fn svg(machine: Machine, posture: &Posture) -> String {
    let mut out = format!(
        "<svg class=\"posture\" viewBox=\"0 0 640 350\" role=\"img\" aria-label=\"posture of the {0}\" data-machine=\"{0}\">\
         <path class=\"ground\" d=\"M0 316H640\"/>",
        machine.name()
    );
    match machine {
        Machine::Excavator => excavator(&mut out, posture),
        Machine::Loader => loader(&mut out, posture),
    }
    out.push_str("</svg>");
    out
}

fn excavator(out: &mut String, posture: &Posture) {
    out.push_str(
        "<rect class=\"dark\" x=\"60\" y=\"268\" width=\"200\" height=\"48\" rx=\"24\"/>\
         <path class=\"body\" d=\"M150 250H190V268H150Z\"/>\
         <path class=\"body\" d=\"M48 178Q48 166 60 166H150L160 128H214L232 190V250H60Q48 250 48 238Z\"/>\
         <path class=\"glass\" d=\"M168 138H206L219 186H168Z\"/>",
    );
    let joints = [
        ("boom_angle", (226.0, 216.0), 0.7),
        ("arm_angle", (214.0, 0.0), -1.4),
        ("bucket_angle", (124.0, 0.0), -1.2),
    ];
    let links = [
        "<path class=\"link\" d=\"M0 -12L104 -40L214 -9V9L108 -6L0 12Z\"/><circle class=\"pin\" r=\"7\"/>",
        "<path class=\"link\" d=\"M-34 -12L0 -15L124 -7V7L0 11Z\"/><circle class=\"pin\" r=\"6\"/>",
        "<path class=\"bucket\" d=\"M-6 6L-4 -12Q14 -50 44 -38L70 0Z\"/><circle class=\"pin\" r=\"5\"/>",
    ];
    chain(out, posture, &joints, &links);
    top_view(out, posture);
}

/// View from above: heading of the upper body; hidden if nothing measures it.
fn top_view(out: &mut String, posture: &Posture) {
    let swing = Joint {
        signal: "swing_angle",
        at: (590.0, 48.0),
        usual: 0.0,
    };
    swing.open(out, posture);
    out.push_str(
        "<circle class=\"ring\" r=\"34\"/><path class=\"needle\" d=\"M-12 -8H4V-3H32V3H4V8H-12Z\"/></g></g>",
    );
}

fn loader(out: &mut String, posture: &Posture) {
    let ground = Joint {
        signal: "slope",
        at: (250.0, 316.0),
        usual: 0.0,
    };
    ground.open(out, posture);
    out.push_str(
        "<g transform=\"translate(-250 -316)\">\
         <path class=\"body\" d=\"M70 196Q70 184 82 184H176L186 108H262L284 196H340V262H70Z\"/>\
         <path class=\"glass\" d=\"M196 118H256L272 182H196Z\"/>\
         <circle class=\"dark\" cx=\"136\" cy=\"264\" r=\"52\"/><circle class=\"hub\" cx=\"136\" cy=\"264\" r=\"18\"/>\
         <circle class=\"dark\" cx=\"366\" cy=\"264\" r=\"52\"/><circle class=\"hub\" cx=\"366\" cy=\"264\" r=\"18\"/>",
    );
    let joints = [
        ("lift_angle", (300.0, 160.0), -0.5),
        ("tilt_angle", (170.0, 0.0), 0.5),
    ];
    let links = [
        "<path class=\"link\" d=\"M0 -10L86 -24L170 -8V8L86 -4L0 10Z\"/><circle class=\"pin\" r=\"7\"/>",
        "<path class=\"bucket\" d=\"M-4 -44Q-20 0 8 22L86 22L16 -12Z\"/><circle class=\"pin\" r=\"6\"/>",
    ];
    chain(out, posture, &joints, &links);
    out.push_str("</g></g></g>");
}

/// Links in a chain.
fn chain(
    out: &mut String,
    posture: &Posture,
    joints: &[(&'static str, (f64, f64), f64)],
    links: &[&str],
) {
    for (&(signal, at, usual), link) in joints.iter().zip(links) {
        Joint { signal, at, usual }.open(out, posture);
        out.push_str(link);
    }
    for _ in joints {
        out.push_str("</g></g>");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{ExcavatorSensors, excavator_bits as bits};

    #[test]
    fn measured_angles_turn_their_joints_and_others_stay_dashed() {
        let mut posture = Posture::default();
        let sensors = ExcavatorSensors {
            valid: bits::BOOM_ANGLE,
            boom_angle: 0.5,
            arm_angle: 9.0,
            ..Default::default()
        };
        take(&mut posture, &sensors);
        let svg = svg(Machine::Excavator, &posture);
        assert!(
            svg.contains("class=\"joint\" data-joint=\"boom_angle\" transform=\"rotate(-28.6)\"")
        );
        assert!(svg.contains(
            "class=\"joint unmeasured\" data-joint=\"arm_angle\" transform=\"rotate(80.2)\""
        ));
    }

    #[test]
    fn the_posture_of_a_moment_is_what_was_measured_last_before_it() {
        let input = |name, points: &[(f64, f64)]| Input {
            name,
            unit: "rad",
            points: points.to_vec(),
        };
        let boom = input(
            "boom_angle",
            &[(0.0, 0.1), (1.0, 0.2), (2.0, f64::NAN), (3.0, 0.4)],
        );
        let inputs = [input("swing_torque", &[(0.0, 9.0)]), boom];
        let posture = at(&inputs, 2.5).expect("a joint");
        assert_eq!(posture[1], Some(0.2));
        assert_eq!(posture.iter().flatten().count(), 1);
        assert_eq!(at(&inputs[..1], 2.5), None);
        assert_eq!(at(&inputs, -1.0), None);
    }

    #[test]
    fn every_group_is_closed() {
        for machine in Machine::ALL {
            let svg = svg(machine, &Posture::default());
            assert_eq!(svg.matches("<g ").count(), svg.matches("</g>").count());
        }
    }
}
