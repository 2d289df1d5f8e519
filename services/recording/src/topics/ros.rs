//! Messages of ROS: their definitions (`ros2msg`, `ros1msg`), and their bytes (CDR, or ROS 1's serialization).
//! Every length is checked against the remaining bytes before memory is reserved for it.

use std::collections::BTreeMap;
use std::rc::Rc;

use super::node::Node;

/// Largest depth of nested definitions.
const DEEPEST: usize = 32;
/// Longest list that may hold signals: longer ones are images or point clouds.
const LONGEST: usize = 4096;

/// The fields of each type that a schema defines.
#[derive(Debug)]
pub(crate) struct Definitions {
    types: BTreeMap<String, Vec<Field>>,
    main: String,
}

#[derive(Debug, PartialEq)]
struct Field {
    name: Rc<str>,
    base: Base,
    count: Count,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Count {
    One,
    Fixed(usize),
    Sequence,
}

#[derive(Debug, Clone, PartialEq)]
enum Base {
    Bool,
    Int(usize),
    Uint(usize),
    Float(usize),
    Text,
    /// Seconds and nanoseconds of ROS 1; whether they have a sign.
    Time(bool),
    Record(String),
}

impl Definitions {
    /// Reads the definitions of a schema called `name`; `None` if they are not complete.
    pub(crate) fn parse(name: &str, text: &str) -> Option<Self> {
        let main = short(name);
        let mut types: BTreeMap<String, Vec<Field>> = BTreeMap::new();
        let mut current = main.clone();
        types.insert(current.clone(), Vec::new());
        for line in text.lines() {
            let line = line.split('#').next().unwrap_or("").trim();
            if line.starts_with("=====") || line.is_empty() {
                continue;
            }
            if let Some(next) = line.strip_prefix("MSG:") {
                current = short(next.trim());
                types.entry(current.clone()).or_default();
                continue;
            }
            if let Some(field) = field(line, &current)? {
                types.get_mut(&current)?.push(field);
            }
        }
        let complete = types.values().flatten().all(|f| match &f.base {
            Base::Record(name) => types.contains_key(name),
            _ => true,
        });
        complete.then_some(Self { types, main })
    }

    /// Decodes a CDR message; `None` if it is malformed.
    pub(crate) fn cdr(&self, message: &[u8]) -> Option<Node> {
        let (head, bytes) = message.split_first_chunk::<4>()?;
        let (little, widest) = match head[1] {
            0 => (false, 8),
            1 => (true, 8),
            6 => (false, 4),
            7 => (true, 4),
            _ => return None,
        };
        (head[0] == 0).then_some(())?;
        let mut bytes = Bytes {
            bytes,
            at: 0,
            little,
            widest,
            with_nul: true,
            records: most_records(bytes),
        };
        self.record(&self.main, &mut bytes, 0)
    }

    /// Decodes a ROS 1 message; `None` if it is malformed.
    pub(crate) fn ros1(&self, message: &[u8]) -> Option<Node> {
        let mut bytes = Bytes {
            bytes: message,
            at: 0,
            little: true,
            widest: 1,
            with_nul: false,
            records: most_records(message),
        };
        self.record(&self.main, &mut bytes, 0)
    }

    fn record(&self, name: &str, bytes: &mut Bytes<'_>, depth: usize) -> Option<Node> {
        (depth < DEEPEST).then_some(())?;
        bytes.records = bytes.records.checked_sub(1)?;
        let fields = self.types.get(name)?;
        if fields.is_empty() && bytes.with_nul {
            bytes.take(1)?; // CDR knows no structure without a member
        }
        let fields = fields
            .iter()
            .map(|f| Some((Rc::clone(&f.name), self.field(f, bytes, depth)?)));
        Some(Node::Record(fields.collect::<Option<_>>()?))
    }

    fn field(&self, field: &Field, bytes: &mut Bytes<'_>, depth: usize) -> Option<Node> {
        let count = match field.count {
            Count::One => return self.one(&field.base, bytes, depth),
            Count::Fixed(count) => count,
            Count::Sequence => usize::try_from(bytes.uint(4)?).ok()?,
        };
        // Each entry of a list takes at least a byte, except for types without fields.
        (count <= bytes.bytes.len() - bytes.at).then_some(())?;
        if count > LONGEST {
            for _ in 0..count {
                self.one(&field.base, bytes, depth)?;
            }
            return Some(Node::Nothing);
        }
        let list = (0..count).map(|_| self.one(&field.base, bytes, depth));
        Some(Node::List(list.collect::<Option<_>>()?))
    }

    fn one(&self, base: &Base, bytes: &mut Bytes<'_>, depth: usize) -> Option<Node> {
        Some(match base {
            Base::Bool => Node::Number(f64::from(u8::from(bytes.uint(1)? != 0))),
            Base::Uint(size) => Node::Number(bytes.uint(*size)? as f64),
            Base::Int(size) => Node::Number(bytes.int(*size)? as f64),
            Base::Float(4) => Node::Number(f64::from(f32::from_bits(bytes.uint(4)? as u32))),
            Base::Float(_) => Node::Number(f64::from_bits(bytes.uint(8)?)),
            Base::Text => Node::Text(bytes.text()?),
            Base::Time(signed) => {
                let part = |bytes: &mut Bytes<'_>| {
                    Some(if *signed {
                        bytes.int(4)? as f64
                    } else {
                        bytes.uint(4)? as f64
                    })
                };
                let (sec, nsec) = (part(bytes)?, part(bytes)?);
                Node::Record(vec![
                    ("sec".into(), Node::Number(sec)),
                    ("nsec".into(), Node::Number(nsec)),
                ])
            }
            Base::Record(name) => self.record(name, bytes, depth + 1)?,
        })
    }
}

/// `package/Name` of `package/msg/Name`.
fn short(name: &str) -> String {
    name.replace("/msg/", "/")
}

/// A line of a definition: no field for a constant, `None` for a malformed line.
fn field(line: &str, current: &str) -> Option<Option<Field>> {
    let (kind, rest) = line.split_once(char::is_whitespace)?;
    let rest = rest.trim();
    let name: String = rest
        .chars()
        .take_while(|c| c.is_alphanumeric() || *c == '_')
        .collect();
    if rest[name.len()..].trim_start().starts_with('=') {
        return Some(None); // a constant
    }
    (!name.is_empty()).then_some(())?;
    let (kind, count) = match kind.find('[') {
        None => (kind, Count::One),
        Some(at) => {
            let inner = kind[at..].strip_prefix('[')?.strip_suffix(']')?;
            let count = match inner {
                "" => Count::Sequence,
                bound if bound.starts_with("<=") => Count::Sequence,
                count => Count::Fixed(count.parse().ok()?),
            };
            (&kind[..at], count)
        }
    };
    let base = match kind.split("<=").next()? {
        "bool" => Base::Bool,
        "byte" | "char" | "uint8" => Base::Uint(1),
        "uint16" => Base::Uint(2),
        "uint32" => Base::Uint(4),
        "uint64" => Base::Uint(8),
        "int8" => Base::Int(1),
        "int16" => Base::Int(2),
        "int32" => Base::Int(4),
        "int64" => Base::Int(8),
        "float32" => Base::Float(4),
        "float64" => Base::Float(8),
        "string" => Base::Text,
        "time" => Base::Time(false),
        "duration" => Base::Time(true),
        "Header" => Base::Record("std_msgs/Header".into()),
        other if other.contains('/') => Base::Record(short(other)),
        "wstring" => return None,
        other => {
            let package = current.split('/').next()?;
            Base::Record(format!("{package}/{other}"))
        }
    };
    Some(Some(Field {
        name: name.into(),
        base,
        count,
    }))
}

struct Bytes<'a> {
    bytes: &'a [u8],
    at: usize,
    little: bool,
    /// Numbers are aligned to their size, or to this if it is smaller.
    widest: usize,
    /// Texts end with a zero, which is counted in their length.
    with_nul: bool,
    /// Number of records that may still follow.
    records: usize,
}

/// Largest number of records of a message beside one per byte: in ROS 1 records of types without fields take no bytes, and types may
/// consist of them.
const EMPTY: usize = 1000;

fn most_records(message: &[u8]) -> usize {
    message.len() + EMPTY
}

impl<'a> Bytes<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let end = self.at.checked_add(count)?;
        let taken = self.bytes.get(self.at..end)?;
        self.at = end;
        Some(taken)
    }

    fn uint(&mut self, size: usize) -> Option<u64> {
        self.at = self.at.next_multiple_of(size.min(self.widest));
        let bytes = self.take(size)?;
        let add = |value: u64, byte: &u8| value << 8 | u64::from(*byte);
        Some(if self.little {
            bytes.iter().rev().fold(0, add)
        } else {
            bytes.iter().fold(0, add)
        })
    }

    fn int(&mut self, size: usize) -> Option<i64> {
        let unused = 64 - 8 * size as u32;
        Some((self.uint(size)? << unused) as i64 >> unused)
    }

    fn text(&mut self) -> Option<String> {
        let length = usize::try_from(self.uint(4)?).ok()?;
        let bytes = self.take(length)?;
        let bytes = if self.with_nul {
            bytes.strip_suffix(&[0]).unwrap_or(bytes)
        } else {
            bytes
        };
        Some(String::from_utf8_lossy(bytes).into_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topics::node::path;

    const TWIST: &str = "# comment\nVector3 linear\nVector3 angular\nint32 MOST=3\n\
        ================\nMSG: geometry_msgs/Vector3\nfloat64 x 0.5\nfloat64 y\nfloat64 z # up\n";

    #[test]
    fn a_twist_is_read_in_both_orders_of_bytes() {
        let types = Definitions::parse("geometry_msgs/msg/Twist", TWIST).expect("complete");
        for little in [true, false] {
            let mut bytes = vec![0, u8::from(little), 0, 0];
            for i in 0..6 {
                let x = f64::from(i);
                bytes.extend(if little {
                    x.to_le_bytes()
                } else {
                    x.to_be_bytes()
                });
            }
            let node = types.cdr(&bytes).expect("whole");
            let z = path("angular.z").expect("a path");
            assert_eq!(node.number(&z, None), Some(5.0));
            assert_eq!(types.cdr(&bytes[..bytes.len() - 1]), None, "cut off");
        }
    }

    #[test]
    fn types_that_take_no_bytes_end_too() {
        let nothing = "MSG: a/T20\n";
        let mut text = String::from("T1 a\nT1[16] b\n");
        for i in 1..20 {
            let rule = "=".repeat(16);
            text += &format!(
                "{rule}\nMSG: a/T{i}\nT{next} a\nT{next}[16] b\n",
                next = i + 1
            );
        }
        text += &format!("{}\n{nothing}", "=".repeat(16));
        let types = Definitions::parse("a/T0", &text).expect("complete");
        assert_eq!(types.ros1(&[0; 64]), None);
    }

    #[test]
    fn numbers_are_aligned_and_lengths_are_not_trusted() {
        let types = Definitions::parse("a/B", "string s\nfloat64[] v\nuint8 n").expect("complete");
        let mut bytes = vec![0, 1, 0, 0];
        bytes.extend(3_u32.to_le_bytes());
        bytes.extend(b"ab\0\0"); // and one of padding
        bytes.extend(1_u32.to_le_bytes());
        bytes.extend([0; 4]); // to 16
        bytes.extend(7.5_f64.to_le_bytes());
        bytes.push(9);
        let node = types.cdr(&bytes).expect("whole");
        assert_eq!(node.field("s"), Some(&Node::Text("ab".into())));
        let at = |text| node.number(&path(text).expect("a path"), None);
        assert_eq!((at("v[0]"), at("n")), (Some(7.5), Some(9.0)));
        bytes[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
        assert_eq!(types.cdr(&bytes), None);
        assert_eq!(types.cdr(&[0, 3, 0, 0, 1]), None, "parameter lists");
    }

    #[test]
    fn what_is_not_defined_is_refused() {
        assert!(Definitions::parse("a/B", "other/Type x").is_none());
        assert!(
            Definitions::parse("a/B", "B itself").is_some_and(|d| d.cdr(&[0, 1, 0, 0]).is_none())
        );
    }
}
