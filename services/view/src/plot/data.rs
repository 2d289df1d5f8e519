//! The marks of a plot as numbers, for the script of the report that draws them again to look closer.

use serde_json::{Value, json};

use super::{Item, Mark, Plot};

/// Digits of a time, and of a value: what a screen can show of it, and a reader of a zoomed part.
const TIME: usize = 7;
const VALUE: usize = 5;

/// Ranges, names and marks; null where there is no number.
pub(super) fn of(plot: &Plot) -> Value {
    let x = plot.x_extent();
    let names: Vec<Value> = plot.y_names.iter().map(|(at, n)| json!([at, n])).collect();
    json!({
        "title": plot.title,
        "x": [x.0, x.1],
        "y": plot.y_range.map(|(low, high)| [low, high]),
        // Null where there is no end.
        "possible": [plot.y_possible.0, plot.y_possible.1],
        "names": names,
        "items": plot.items.iter().filter_map(item).collect::<Vec<_>>(),
    })
}

fn item(item: &Item) -> Option<Value> {
    let (label, class) = (&item.label, item.style.class());
    let mark = match &item.mark {
        Mark::Line(points) => json!({
            "line": [column(points, TIME, |p| p.0), column(points, VALUE, |p| p.1)],
        }),
        Mark::Band(points) => json!({
            "band": [
                column(points, TIME, |p| p.0),
                column(points, VALUE, |p| p.1),
                column(points, VALUE, |p| p.2),
            ],
        }),
        Mark::Shade(spans) => json!({
            "shade": [column(spans, TIME, |s| s.0), column(spans, TIME, |s| s.1)],
        }),
        Mark::Level(y) => json!({ "level": rounded(*y, VALUE) }),
        Mark::Bars { .. } => return None,
    };
    let mut all = json!({ "label": label, "class": class });
    if let (Value::Object(all), Value::Object(mark)) = (&mut all, mark) {
        all.extend(mark);
    }
    Some(all)
}

fn column<P>(points: &[P], digits: usize, pick: impl Fn(&P) -> f64) -> Vec<Value> {
    points.iter().map(|p| rounded(pick(p), digits)).collect()
}

/// The number with so many significant digits, null where it is none.
fn rounded(value: f64, digits: usize) -> Value {
    let text = format!("{value:.*e}", digits - 1);
    match text.parse::<f64>() {
        // An integer takes two bytes less.
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
        let line = r#"[[0.1234568,2,3],[0.33333,null,7000]]"#;
        assert_eq!(items[0]["line"].to_string(), line);
    }
}
