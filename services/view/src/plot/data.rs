//! The marks of a plot as numbers, for the report's script, which redraws them for zooming.

use serde_json::{Value, json};

use super::{Item, Mark, Plot};

/// Significant digits of a value: enough for a screen and for a zoomed part. A time has a resolution of a millionth of the plot's
/// length, wherever it begins.
const VALUE: usize = 5;
const TIME: i32 = 6;

/// Ranges, names and marks; null where there is no number.
pub(super) fn of(plot: &Plot) -> Value {
    let x = plot.x_extent();
    let names: Vec<Value> = plot.y_names.iter().map(|(at, n)| json!([at, n])).collect();
    json!({
        "title": plot.title,
        "x": [x.0, x.1],
        "y": plot.y_range.map(|(low, high)| [low, high]),
        // Null without a bound.
        "possible": [plot.y_possible.0, plot.y_possible.1],
        "names": names,
        "items": plot.items.iter().filter_map(|i| item(i, x.1 - x.0)).collect::<Vec<_>>(),
    })
}

fn item(item: &Item, length: f64) -> Option<Value> {
    let times = |points: &mut dyn Iterator<Item = f64>| -> Vec<Value> {
        points.map(|t| time(t, length)).collect()
    };
    let (label, class) = (&item.label, item.style.class());
    let mark = match &item.mark {
        Mark::Line(points) => json!({
            "line": [times(&mut points.iter().map(|p| p.0)), column(points, |p| p.1)],
        }),
        Mark::Band(points) => json!({
            "band": [
                times(&mut points.iter().map(|p| p.0)),
                column(points, |p| p.1),
                column(points, |p| p.2),
            ],
        }),
        Mark::Shade(spans) => json!({
            "shade": [times(&mut spans.iter().map(|s| s.0)), times(&mut spans.iter().map(|s| s.1))],
        }),
        Mark::Level(y) => json!({ "level": rounded(*y) }),
        Mark::Bars { .. } => return None,
    };
    let mut all = json!({ "label": label, "class": class });
    if let (Value::Object(all), Value::Object(mark)) = (&mut all, mark) {
        all.extend(mark);
    }
    Some(all)
}

fn column<P>(points: &[P], pick: impl Fn(&P) -> f64) -> Vec<Value> {
    points.iter().map(|p| rounded(pick(p))).collect()
}

/// A time rounded to a share of the plot's length.
fn time(t: f64, length: f64) -> Value {
    let decimals = TIME - length.log10().floor().clamp(-9.0, 9.0) as i32;
    let text = format!("{t:.*}", decimals.max(0) as usize);
    number(&text)
}

/// The number with [`VALUE`] significant digits, null if it is not finite.
fn rounded(value: f64) -> Value {
    number(&format!("{value:.*e}", VALUE - 1))
}

fn number(text: &str) -> Value {
    match text.parse::<f64>() {
        // Written as an integer, which takes two bytes less.
        Ok(v) if v.fract() == 0.0 && v.abs() < 1e9 => json!(v as i64),
        Ok(v) if v.is_finite() => json!(v),
        _ => Value::Null,
    }
}

#[cfg(test)]
mod tests {
    use super::super::Style;
    use super::*;

    #[test]
    fn numbers_are_short_and_gaps_are_null() {
        let mut plot = Plot::new("a", "t");
        let points = [(0.123_456_789, 1.0 / 3.0), (2.0, f64::NAN), (3.0, 7e3)];
        plot.line("x", Style::Series(0), &points);
        plot.bars("y", Style::Series(1), &[0.0, 1.0], &[1.0]);
        let items = &of(&plot)["items"];
        assert_eq!(items.as_array().map(Vec::len), Some(1));
        let line = r#"[[0.123457,2,3],[0.33333,null,7000]]"#;
        assert_eq!(items[0]["line"].to_string(), line);
    }

    #[test]
    fn times_since_1970_keep_their_hundredths() {
        let mut plot = Plot::new("a", "t");
        let begin = 1_795_300_012.34;
        plot.line("x", Style::Series(0), &[(begin, 1.0), (begin + 60.01, 2.0)]);
        let items = &of(&plot)["items"];
        assert_eq!(
            items[0]["line"][0].to_string(),
            "[1795300012.34,1795300072.35]"
        );
    }
}
