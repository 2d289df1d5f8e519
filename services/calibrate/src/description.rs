//! Keys of a description by name: a calibration must not know every field of it.

use config::{Tables, Value};

/// The number under a key such as `sensors.swing_torque_std`; none if there is no such key or no number.
pub fn number<M: Tables>(description: &M, key: &str) -> Option<f64> {
    let (table_name, name) = key.rsplit_once('.')?;
    let tables = description.tables();
    let table = tables.into_iter().find(|t| t.name() == table_name)?;
    let index = table.keys().iter().position(|k| k.name == name)?;
    match table.get(index) {
        Some(Value::Number(number)) => Some(number),
        _ => None,
    }
}

/// Sets a number, moved into the key's range; false if there is no such key.
pub fn set<M: Tables>(description: &mut M, key: &str, value: f64) -> bool {
    let Some((table_name, name)) = key.rsplit_once('.') else {
        return false;
    };
    let mut tables = description.tables_mut();
    let Some(table) = tables.iter_mut().find(|t| t.name() == table_name) else {
        return false;
    };
    let Some(index) = table.keys().iter().position(|k| k.name == name) else {
        return false;
    };
    let value = match table.keys()[index].range {
        Some(range) => value.clamp(range.low, range.high),
        None => value,
    };
    table.set(index, &Value::Number(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_read_and_set_within_their_range() {
        let mut d = config::Excavator::default();
        assert_eq!(number(&d, "machine.nominal_damping"), Some(1500.0));
        assert!(set(&mut d, "sensors.rate", 1e9));
        assert_eq!(d.sensors.rate, 100_000.0);
        assert!(!set(&mut d, "machine.nothing", 1.0));
        assert_eq!(number(&d, "machine.nothing"), None);
    }
}
