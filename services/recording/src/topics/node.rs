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
            None => self.at(path)?,
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

    /// Calls `found` with path and value of every number, and of the first number of a list. Texts beside a list are
    /// the names of its entries.
    pub(crate) fn numbers(&self, before: &str, found: &mut dyn FnMut(&str, f64)) {
        match self {
            Self::Number(x) => found(before, *x),
            Self::Record(fields) => {
                for (name, node) in fields {
                    let dot = if before.is_empty() { "" } else { "." };
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
}
