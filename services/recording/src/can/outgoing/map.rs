//! An output map: the frames that are sent, with their identifiers.

use std::path::Path;

use messages::channels::Channel;
use sheet::loads::STATUS_GROUP;
use toml_edit::{Document, Item, TableLike};

use super::table::{LOADS, LOADS_FLAGS, LOADS_NUMBERS, Number, Quantity, VERDICT_NUMBERS};
use super::{Content, FrameTable, Kind, Outgoing, position};
use crate::Error;
use crate::can::node::Name;
use crate::map::hint;

/// J1939 proprietary B: parameter groups defined by manufacturers.
const PROPRIETARY_B: std::ops::RangeInclusive<i64> = 0xff00..=0xffff;
const VERDICT: &str = "verdict";
const STATUS: &str = "loads";
/// Keys of the table `can`.
const KEYS: &[&str] = &["rate", "source", "priority", "channel", "frames", "name"];
/// The fields of a NAME.
const NAME_KEYS: &[&str] = &[
    "identity",
    "manufacturer",
    "ecu_instance",
    "function_instance",
    "function",
    "vehicle_system",
    "vehicle_system_instance",
    "industry_group",
    "arbitrary_address",
];

pub(super) struct Parser<'a> {
    table: &'static FrameTable,
    text: &'a str,
    path: &'a Path,
}

impl<'a> Parser<'a> {
    pub(super) fn new(table: &'static FrameTable, text: &'a str, path: &'a Path) -> Self {
        Self { table, text, path }
    }

    fn error(&self, what: impl Into<String>, remedy: impl Into<String>) -> Error {
        Error::new(what, self.path.display().to_string(), remedy)
    }

    pub(super) fn outgoing(&self) -> Result<Outgoing, Error> {
        let document = Document::parse(self.text.to_owned());
        let document = document.map_err(|e| {
            let what = e.message().trim().replace('\n', "; ");
            self.error(what, "correct the TOML")
        })?;
        let can = document.get("can").and_then(|c| c.as_table_like());
        self.known(document.as_table(), &["can"])?;
        if let Some(can) = can {
            self.known(can, KEYS)?;
        }
        let get = |key: &str| can.and_then(|c| c.get(key));
        let source = self.whole("source", get("source"), 0xfd)?.unwrap_or(0x80);
        let priority = self.whole("priority", get("priority"), 7)?.unwrap_or(6);
        let rate = self.rate(get("rate"))?;
        let channel = self.channel(get("channel"))?;
        let kinds = self.frames(get("frames"), channel, priority << 26 | source)?;
        Ok(Outgoing {
            machine: self.table.machine,
            channel,
            period: 1.0 / rate,
            source: source as u8,
            name: self.name(get("name"))?,
            kinds,
        })
    }

    /// A whole number from 0 to `most`; none if the map does not give it.
    fn whole(&self, key: &str, item: Option<&Item>, most: u32) -> Result<Option<u32>, Error> {
        let Some(item) = item else {
            return Ok(None);
        };
        let number = item.as_integer().and_then(|n| u32::try_from(n).ok());
        let number = number.filter(|n| *n <= most);
        number.map(Some).ok_or_else(|| {
            let what = format!("can.{key} is no whole number from 0 to {most}");
            self.error(what, "correct it")
        })
    }

    /// Frames a second [Hz].
    fn rate(&self, item: Option<&Item>) -> Result<f64, Error> {
        let rate = item.map_or(Some(10.0), |item| {
            item.as_float()
                .or_else(|| item.as_integer().map(|n| n as f64))
        });
        rate.filter(|r| (0.01..=1000.0).contains(r))
            .ok_or_else(|| self.error("can.rate is no number from 0.01 to 1000", "correct it"))
    }

    /// The channel of the estimates, by default the first.
    fn channel(&self, item: Option<&Item>) -> Result<&'static Channel, Error> {
        let mut channels = self.table.channels.iter().copied();
        let channel = match item {
            None => channels.next(),
            Some(item) => channels.find(|c| item.as_str() == Some(c.name)),
        };
        channel.ok_or_else(|| {
            let all: Vec<&str> = self.table.channels.iter().map(|c| c.name).collect();
            let all = all.join(", ");
            self.error(
                "can.channel is no channel of estimates",
                format!("one of {all}"),
            )
        })
    }

    /// The frames that the map names, all of them if it names none; each has its own identifier.
    fn frames(
        &self,
        item: Option<&Item>,
        channel: &'static Channel,
        base: u32,
    ) -> Result<Vec<Kind>, Error> {
        let mut kinds = self.kinds(channel, base);
        if let Some(frames) = item {
            let frames = frames.as_table_like();
            let frames =
                frames.ok_or_else(|| self.error("can.frames is no table", "write [can.frames]"))?;
            let names: Vec<&str> = kinds.iter().map(|k| k.name).collect();
            self.known(frames, &names)?;
            kinds.retain(|k| frames.contains_key(k.name));
            for kind in &mut kinds {
                (kind.id, kind.extended) = self.identifier(kind.name, frames, base)?;
            }
        }
        for (n, kind) in kinds.iter().enumerate() {
            let twin = kinds[..n]
                .iter()
                .find(|k| (k.id, k.extended) == (kind.id, kind.extended));
            if let Some(twin) = twin {
                let what = format!("{} and {} have one identifier", twin.name, kind.name);
                return Err(self.error(what, "give each its own"));
            }
        }
        Ok(kinds)
    }

    /// The NAME of J1939, and its identity if the map gives one.
    fn name(&self, item: Option<&Item>) -> Result<(Name, Option<u32>), Error> {
        let mut name = Name::default();
        let Some(item) = item else {
            return Ok((name, None));
        };
        let table = item.as_table_like();
        let table = table.ok_or_else(|| self.error("can.name is no table", "write [can.name]"))?;
        let mut identity = None;
        for (key, value) in table.iter() {
            if key == "arbitrary_address" {
                let flag = value.as_bool().ok_or_else(|| {
                    let what = "can.name.arbitrary_address is neither true nor false";
                    self.error(what, "write true or false")
                })?;
                name.arbitrary_address = flag;
                continue;
            }
            let (place, bits) = match key {
                "identity" => (identity.insert(0), 21),
                "manufacturer" => (&mut name.manufacturer, 11),
                "ecu_instance" => (&mut name.ecu_instance, 3),
                "function_instance" => (&mut name.function_instance, 5),
                "function" => (&mut name.function, 8),
                "vehicle_system" => (&mut name.vehicle_system, 7),
                "vehicle_system_instance" => (&mut name.vehicle_system_instance, 4),
                "industry_group" => (&mut name.industry_group, 3),
                _ => {
                    let remedy = hint(key, NAME_KEYS.iter().copied(), "the keys are");
                    let what = format!("a NAME has no field {key}");
                    return Err(self.error(what, remedy));
                }
            };
            let most = (1_i64 << bits) - 1;
            let number = value.as_integer().filter(|n| (0..=most).contains(n));
            *place = number.ok_or_else(|| {
                let what = format!("can.name.{key} is no whole number from 0 to {most}");
                self.error(what, "correct it")
            })? as u32;
        }
        Ok((name, identity))
    }

    /// All frames, with their default groups.
    fn kinds(&self, channel: &'static Channel, base: u32) -> Vec<Kind> {
        let table = self.table;
        let kind = |name, channel, group: u16, content| Kind {
            name,
            channel,
            id: base | u32::from(group) << 8,
            extended: true,
            content,
        };
        let quantity = |row: &'static Quantity, channel, first: u16| {
            let at = [row.field, row.std_field].map(|field| position(channel, field));
            kind(
                row.name,
                channel,
                first + row.group,
                Content::Quantity(at, row),
            )
        };
        let flags = |flags, numbers: &'static [Number], channel| {
            let numbers = numbers.iter().map(|n| (position(channel, n.field), n));
            Content::Flags(flags, numbers.collect())
        };
        let verdict = flags(table.flags, VERDICT_NUMBERS, channel);
        let loads = flags(LOADS_FLAGS, LOADS_NUMBERS, table.loads);
        let status = table.loads_group + STATUS_GROUP;
        let quantities = table.quantities.iter().map(|row| quantity(row, channel, 0));
        let of_loads = LOADS
            .iter()
            .map(|row| quantity(row, table.loads, table.loads_group));
        quantities
            .chain([kind(VERDICT, channel, table.verdict, verdict)])
            .chain(of_loads)
            .chain([kind(STATUS, table.loads, status, loads)])
            .collect()
    }

    fn identifier(
        &self,
        name: &str,
        frames: &dyn TableLike,
        base: u32,
    ) -> Result<(u32, bool), Error> {
        let item = frames.get(name);
        let group = item.and_then(|i| i.as_integer());
        if let Some(group) = group.filter(|g| PROPRIETARY_B.contains(g)) {
            return Ok((base | (group as u32) << 8, true));
        }
        let fields = item.and_then(|i| i.as_table_like());
        let id = fields.and_then(|f| f.get("id")?.as_integer());
        match id.filter(|id| (0..0x800).contains(id)) {
            Some(id) => Ok((id as u32, false)),
            None => Err(self.error(
                format!("can.frames.{name} names no identifier"),
                "write a parameter group of proprietary B (0xff00 to 0xffff), or { id = ... } with 11 bits",
            )),
        }
    }

    fn known(&self, table: &dyn TableLike, keys: &[&str]) -> Result<(), Error> {
        let unknown = table
            .iter()
            .map(|(key, _)| key)
            .find(|key| !keys.contains(key));
        unknown.map_or(Ok(()), |key| {
            let remedy = hint(key, keys.iter().copied(), "the keys are");
            Err(self.error(format!("an output map has no key `{key}`"), remedy))
        })
    }
}
