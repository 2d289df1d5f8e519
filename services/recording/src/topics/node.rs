//! A foreign message as a tree, whatever its encoding, and paths to the numbers in it.

use std::rc::Rc;

/// A value in a message.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Node {
    /// Numbers and booleans.
    Number(f64),
    Text(String),
    List(Vec<Node>),
    Record(Vec<(Rc<str>, Node)>),
    /// Contents that cannot be a signal: bytes, absent messages.
    Nothing,
}

/// A step into a message.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Step {
    Field(String),
    Index(usize),
}

/// The steps of a path such as `wrench.force.x`, `axes[2]` or `"swing rate [deg/s]".value`; none if it is no valid path.
pub(crate) fn path(text: &str) -> Option<Vec<Step>> {
    let (mut steps, mut rest) = (Vec::new(), text);
    loop {
        let (name, after) = match rest.strip_prefix('"') {
            Some(quoted) => quoted.split_once('"')?,
            None => rest.split_at(rest.find(['.', '[']).unwrap_or(rest.len())),
        };
        let is_quoted = rest.starts_with('"');
        (is_quoted || !name.is_empty() && !name.contains([']', '"'])).then_some(())?;
        steps.push(Step::Field(name.to_owned()));
        rest = after;
        while let Some(index) = rest.strip_prefix('[') {
            let (index, after) = index.split_once(']')?;
            steps.push(Step::Index(index.parse().ok()?));
            rest = after;
        }
        if rest.is_empty() {
            return Some(steps);
        }
        rest = rest.strip_prefix('.')?;
    }
}

/// A field's name as written in a path.
fn in_path(name: &str) -> String {
    match name.is_empty() || name.contains(['.', '[', ']', '"']) {
        true => format!("\"{name}\""),
        false => name.to_owned(),
    }
}

impl Node {
    pub(crate) fn field(&self, name: &str) -> Option<&Node> {
        match self {
            Self::Record(fields) => fields.iter().find(|(n, _)| **n == *name).map(|(_, v)| v),
            _ => None,
        }
    }

    fn step(&self, step: &Step) -> Option<&Node> {
        match (self, step) {
            (_, Step::Field(name)) => self.field(name),
            (Self::List(list), Step::Index(i)) => list.get(*i),
            _ => None,
        }
    }

    /// The node at the end of a path.
    pub(crate) fn at(&self, path: &[Step]) -> Option<&Node> {
        path.iter().try_fold(self, |node, step| node.step(step))
    }

    /// The number at the end of a path. With a name the path ends at a list, and the number is the entry whose
    /// index in a list of texts beside it has that name (`sensor_msgs/JointState`).
    pub(crate) fn number(&self, path: &[Step], name: Option<&str>) -> Option<f64> {
        let node = match name {
            None => match (self.at(path), path.split_last()) {
                (None, Some((Step::Field(last), before))) => return self.at(before)?.turn(last),
                (found, _) => found?,
            },
            Some(name) => {
                let (_, parent) = path.split_last()?;
                let Node::List(list) = self.at(path)? else {
                    return None;
                };
                list.get(self.at(parent)?.place_of(name)?)?
            }
        };
        match node {
            Self::Number(x) => Some(*x),
            _ => None,
        }
    }

    /// A rotation \[rad\] of a quaternion, by its name in [`TURNS`]: roll, pitch and yaw of ROS. The pitch goes on beyond a
    /// quarter turn, as a bucket does. None for a quaternion that nobody filled in.
    fn turn(&self, name: &str) -> Option<f64> {
        let [x, y, z, w] = self.quaternion()?;
        let is_unit = (x * x + y * y + z * z + w * w - 1.0).abs() < 0.1;
        let up = 1.0 - 2.0 * (x * x + y * y);
        let (ahead, aside) = (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z));
        // Not `hypot`: a wheel with it would need a newer C library.
        let level = (ahead * ahead + aside * aside).sqrt();
        let turns = [
            (2.0 * (w * x + y * z)).atan2(up),
            (2.0 * (w * y - x * z)).atan2(level.copysign(up)),
            aside.atan2(ahead),
        ];
        let at = TURNS.iter().position(|turn| *turn == name)?;
        is_unit.then_some(turns[at])
    }

    /// The numbers of a quaternion: a record of x, y, z and w.
    fn quaternion(&self) -> Option<[f64; 4]> {
        let Self::Record(fields) = self else {
            return None;
        };
        let parts = ["x", "y", "z", "w"].map(|name| match self.field(name) {
            Some(Self::Number(x)) => *x,
            _ => f64::NAN,
        });
        (fields.len() == 4 && !parts.iter().any(|x| x.is_nan())).then_some(parts)
    }

    /// Index of a text in the first list of texts that contains it.
    fn place_of(&self, name: &str) -> Option<usize> {
        let Self::Record(fields) = self else {
            return None;
        };
        fields.iter().find_map(|(_, node)| match node {
            Self::List(list) => list
                .iter()
                .position(|n| matches!(n, Self::Text(text) if text == name)),
            _ => None,
        })
    }

    /// Time of the measurement in the message's own header [ns].
    pub(crate) fn stamp(&self) -> Option<i64> {
        let stamp = self.field("header").and_then(|h| h.field("stamp"));
        let stamp = stamp
            .or_else(|| self.field("stamp"))
            .or_else(|| self.field("timestamp"))?;
        let number = |names: &[&str]| {
            let found = names.iter().find_map(|name| stamp.field(name));
            match found {
                Some(Self::Number(x)) => Some(*x),
                _ => None,
            }
        };
        let seconds = number(&["sec", "secs", "seconds"])?;
        let nanoseconds = number(&["nanosec", "nsec", "nsecs", "nanos"]).unwrap_or(0.0);
        let ns = seconds * 1e9;
        (ns.abs() < 9e18).then(|| ns as i64 + nanoseconds as i64)
    }

    /// Calls `found` with path and value of every number, and of the first numbers of a list. Of a quaternion, whose numbers
    /// are no angles, these are its rotations.
    pub(crate) fn numbers(&self, before: &str, found: &mut dyn FnMut(&str, f64)) {
        let dot = if before.is_empty() { "" } else { "." };
        match self {
            Self::Number(x) => found(before, *x),
            Self::Record(_) if self.quaternion().is_some() => {
                for name in TURNS {
                    let turn = self.turn(name).unwrap_or(f64::NAN);
                    found(&format!("{before}{dot}{name}"), turn);
                }
            }
            Self::Record(fields) => {
                for (name, node) in fields {
                    node.numbers(&format!("{before}{dot}{}", in_path(name)), found);
                }
            }
            Self::List(list) => {
                for (i, node) in list.iter().take(MOST_SHOWN).enumerate() {
                    node.numbers(&format!("{before}[{i}]"), found);
                }
            }
            Self::Text(_) | Self::Nothing => {}
        }
    }
}

/// Names of the rotations of a quaternion, about the axes of ROS.
pub(crate) const TURNS: [&str; 3] = ["angle_x", "angle_y", "angle_z"];

/// Number of entries of a list that are shown.
const MOST_SHOWN: usize = 12;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_name_fields_and_places() {
        let field = |name: &str| Step::Field(name.into());
        assert_eq!(
            path("a.b[2][0].c"),
            Some(vec![
                field("a"),
                field("b"),
                Step::Index(2),
                Step::Index(0),
                field("c")
            ])
        );
        let quoted = path("a.\"rate [deg/s].x\"[1].b");
        let steps = [
            field("a"),
            field("rate [deg/s].x"),
            Step::Index(1),
            field("b"),
        ];
        assert_eq!(quoted, Some(steps.to_vec()));
        for wrong in [
            "", "a..b", "a[", "a[x]", "[1]", "a]b", "\"a", "\"a\"b", "a.",
        ] {
            assert_eq!(path(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn a_number_is_found_by_the_name_of_its_place() {
        let text = |t: &str| Node::Text(t.into());
        let message = Node::Record(vec![
            ("name".into(), Node::List(vec![text("boom"), text("swing")])),
            (
                "velocity".into(),
                Node::List(vec![Node::Number(1.0), Node::Number(2.0)]),
            ),
        ]);
        let velocity = path("velocity").expect("a path");
        assert_eq!(message.number(&velocity, Some("swing")), Some(2.0));
        assert_eq!(message.number(&velocity, Some("arm")), None);
        assert_eq!(
            message.number(&path("velocity[0]").expect("a path"), None),
            Some(1.0)
        );
        assert_eq!(message.number(&velocity, None), None, "a list is no number");
    }

    #[test]
    fn a_quaternion_has_rotations_and_a_bucket_may_curl_beyond_a_quarter_turn() {
        let message = |parts: [f64; 4]| {
            let parts = ["x", "y", "z", "w"].into_iter().zip(parts);
            let fields = parts.map(|(name, x)| (name.into(), Node::Number(x)));
            Node::Record(vec![("q".into(), Node::Record(fields.collect()))])
        };
        let turn = |node: &Node, name: &str| {
            node.number(&path(&format!("q.{name}")).expect("a path"), None)
        };
        let (yaw, roll) = (0.7_f64, 0.1_f64);
        for pitch in [-2.5_f64, -0.4, 0.0, 1.2, 2.5] {
            let half = |angle: f64| (angle / 2.0).sin_cos();
            let ((sx, cx), (sy, cy), (sz, cz)) = (half(roll), half(pitch), half(yaw));
            let node = message([
                sx * cy * cz - cx * sy * sz,
                cx * sy * cz + sx * cy * sz,
                cx * cy * sz - sx * sy * cz,
                cx * cy * cz + sx * sy * sz,
            ]);
            let found = turn(&node, "angle_y").expect("an angle");
            assert!((found - pitch).abs() < 1e-12, "{found} {pitch}");
            if pitch.abs() < 1.5 {
                assert!((turn(&node, "angle_x").expect("an angle") - roll).abs() < 1e-12);
                assert!((turn(&node, "angle_z").expect("an angle") - yaw).abs() < 1e-12);
            }
            assert!(turn(&node, "y").is_some() && turn(&node, "angle").is_none());
        }
        assert_eq!(turn(&message([0.0; 4]), "angle_y"), None, "not filled in");
        let mut listed = Vec::new();
        message([0.0, 0.0, 0.0, 1.0]).numbers("", &mut |path, _| listed.push(path.to_owned()));
        assert_eq!(listed, ["q.angle_x", "q.angle_y", "q.angle_z"]);
    }
}
