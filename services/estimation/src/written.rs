//! Serialisation of arrays of any length (feature `serde`); serde itself supports those up to 32, of a length that is a number.

use core::fmt;
use core::marker::PhantomData;

use serde::de::{Error, SeqAccess, Visitor};
use serde::ser::SerializeTuple;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// An array, element by element.
pub(crate) fn serialize<S: Serializer, T: Serialize, const N: usize>(
    array: &[T; N],
    to: S,
) -> Result<S::Ok, S::Error> {
    let mut tuple = to.serialize_tuple(N)?;
    for element in array {
        tuple.serialize_element(element)?;
    }
    tuple.end()
}

/// Reads an array, element by element.
pub(crate) fn deserialize<'a, D: Deserializer<'a>, T: Deserialize<'a> + Copy, const N: usize>(
    from: D,
) -> Result<[T; N], D::Error> {
    from.deserialize_tuple(N, Elements(PhantomData))
}

struct Elements<T, const N: usize>(PhantomData<T>);

impl<'a, T: Deserialize<'a> + Copy, const N: usize> Visitor<'a> for Elements<T, N> {
    type Value = [T; N];

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{N} elements")
    }

    fn visit_seq<A: SeqAccess<'a>>(self, mut from: A) -> Result<[T; N], A::Error> {
        let short = || A::Error::custom("too few elements");
        let mut array = [from.next_element()?.ok_or_else(short)?; N];
        for element in array.iter_mut().skip(1) {
            *element = from.next_element()?.ok_or_else(short)?;
        }
        Ok(array)
    }
}

/// Arrays of arrays.
pub(crate) mod rows {
    use super::{Deserialize, Deserializer, Serialize, Serializer};

    #[derive(Clone, Copy, Serialize, Deserialize)]
    #[serde(transparent, bound = "T: Copy + Serialize + for<'b> Deserialize<'b>")]
    struct Row<T, const N: usize>(#[serde(with = "super")] [T; N]);

    pub(crate) fn serialize<S, T, const N: usize, const R: usize>(
        rows: &[[T; N]; R],
        to: S,
    ) -> Result<S::Ok, S::Error>
    where
        S: Serializer,
        T: Copy + Serialize + for<'b> Deserialize<'b>,
    {
        super::serialize(&rows.map(Row), to)
    }

    pub(crate) fn deserialize<'a, D, T, const N: usize, const R: usize>(
        from: D,
    ) -> Result<[[T; N]; R], D::Error>
    where
        D: Deserializer<'a>,
        T: Copy + Serialize + for<'b> Deserialize<'b>,
    {
        super::deserialize::<D, Row<T, N>, R>(from).map(|rows| rows.map(|row| row.0))
    }
}
