//! Drawing of a plot as SVG.

use std::fmt::Write;

use super::scale::Axis;
use super::{Item, Mark, Plot, STYLE, decimate, escape};

/// Height of a line of text, and mean width of a character, in a 12 px sans serif.
const LINE: f64 = 17.0;
const CHARACTER: f64 = 6.7;

/// The frame of the marks within the picture, and its axes.
struct Frame {
    left: f64,
    top: f64,
    width: f64,
    height: f64,
    x: Axis,
    y: Axis,
}

pub(super) fn svg(plot: &Plot, width: f64, height: f64) -> String {
    let mut out = format!(
        "<svg class=\"plot\" viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{}\">",
        escape(&plot.title)
    );
    body(&mut out, plot, "", width, height);
    out.push_str("</svg>");
    out
}

/// Height of caption and source.
const HEAD: f64 = 48.0;

pub(super) fn file(caption: &str, source: &str, plots: &[Plot], width: f64, height: f64) -> String {
    let total = HEAD + height * plots.len() as f64;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"plot file\" width=\"{width}\" \
         height=\"{total}\" viewBox=\"0 0 {width} {total}\"><style>{STYLE}</style>\
         <rect class=\"paper\" width=\"{width}\" height=\"{total}\"/>\
         <text class=\"caption\" x=\"4\" y=\"18\">{}</text><text class=\"key\" x=\"4\" y=\"35\">{}</text>",
        escape(caption),
        escape(source)
    );
    for (i, plot) in plots.iter().enumerate() {
        let _ = write!(
            out,
            "<g transform=\"translate(0 {})\">",
            HEAD + height * i as f64
        );
        let letter = (b'a' + (i % 26) as u8) as char;
        let prefix = if plots.len() > 1 {
            format!("({letter}) ")
        } else {
            String::new()
        };
        body(&mut out, plot, &prefix, width, height);
        out.push_str("</g>");
    }
    out.push_str("</svg>\n");
    out
}

fn body(out: &mut String, plot: &Plot, prefix: &str, width: f64, height: f64) {
    let title = escape(&format!("{prefix}{}", plot.title));
    let _ = write!(out, "<text class=\"title\" x=\"4\" y=\"14\">{title}</text>");
    let top = 20.0 + legend(out, plot, width);
    let y_count = ((height - top - 36.0) / 38.0).max(2.0) as usize;
    let y_ticks = if plot.y_names.is_empty() {
        Axis::new(plot.y_scale, plot.y_extent(), 0.0, 1.0).ticks(y_count)
    } else {
        plot.y_names.clone()
    };
    let longest = y_ticks
        .iter()
        .map(|t| t.1.chars().count())
        .max()
        .unwrap_or(1);
    let left = 12.0 + CHARACTER * longest as f64;
    let width = (width - left - 12.0).max(10.0);
    let height = (height - top - 40.0).max(10.0);
    let frame = Frame {
        left,
        top: top + 4.0,
        width,
        height,
        x: Axis::new(plot.x_scale, plot.x_extent(), 0.0, width),
        y: Axis::new(plot.y_scale, plot.y_extent(), height, 0.0),
    };
    axes(out, plot, &frame, &y_ticks);
    marks(out, plot, &frame);
}

/// Draws the legend below the title and returns its height.
fn legend(out: &mut String, plot: &Plot, width: f64) -> f64 {
    let mut named = plot.items.iter().filter(|i| !i.label.is_empty()).peekable();
    if named.peek().is_none() {
        return 0.0;
    }
    let (mut x, mut y) = (6.0, 14.0 + LINE);
    for item in named {
        let room = 30.0 + CHARACTER * item.label.chars().count() as f64;
        if x > 6.0 && x + room > width {
            (x, y) = (6.0, y + LINE);
        }
        swatch(out, item, x, y - 4.0);
        let (label, at) = (escape(&item.label), x + 22.0);
        let _ = write!(
            out,
            "<text class=\"key\" x=\"{at:.0}\" y=\"{y:.0}\">{label}</text>"
        );
        x += room + 8.0;
    }
    y - 10.0
}

fn swatch(out: &mut String, item: &Item, x: f64, y: f64) {
    let class = item.style.class();
    let _ = match item.mark {
        Mark::Line(_) | Mark::Level(_) => {
            let to = x + 18.0;
            write!(
                out,
                "<path class=\"line {class}\" d=\"M{x:.0} {y:.0}H{to:.0}\"/>"
            )
        }
        Mark::Band(_) => area(out, "band", &class, (x, y - 5.0, 18.0, 10.0)),
        Mark::Shade(_) => area(out, "shade", &class, (x, y - 5.0, 18.0, 10.0)),
        Mark::Bars { .. } => area(out, "bar", &class, (x, y - 5.0, 18.0, 10.0)),
    };
}

fn area(out: &mut String, kind: &str, class: &str, r: (f64, f64, f64, f64)) -> std::fmt::Result {
    let (x, y, w, h) = (short(r.0), short(r.1), short(r.2), short(r.3));
    write!(
        out,
        "<rect class=\"{kind} {class}\" x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\"/>"
    )
}

fn axes(out: &mut String, plot: &Plot, f: &Frame, ticks: &[(f64, String)]) {
    let (right, bottom) = (f.left + f.width, f.top + f.height);
    for (value, label) in ticks {
        let at = f.top + f.y.place(*value);
        if !at.is_finite() {
            continue;
        }
        let (text_x, text_y) = (f.left - 6.0, at + 4.0);
        let _ = write!(
            out,
            "<path class=\"grid\" d=\"M{:.1} {at:.1}H{right:.1}\"/>\
             <text class=\"tick end\" x=\"{text_x:.1}\" y=\"{text_y:.1}\">{}</text>",
            f.left,
            escape(label)
        );
    }
    let named = !plot.x_names.is_empty();
    let x_ticks = if named {
        plot.x_names.clone()
    } else {
        f.x.ticks((f.width / 75.0) as usize)
    };
    for (value, label) in &x_ticks {
        let at = f.left + f.x.place(*value);
        if !at.is_finite() {
            continue;
        }
        let (mark, text_y) = (bottom + 4.0, bottom + 17.0);
        let _ = write!(
            out,
            "<path class=\"axis\" d=\"M{at:.1} {bottom:.1}V{mark:.1}\"/>\
             <text class=\"tick middle\" x=\"{at:.1}\" y=\"{text_y:.1}\">{}</text>",
            escape(label)
        );
    }
    let _ = write!(
        out,
        "<path class=\"axis\" d=\"M{:.1} {:.1}V{bottom:.1}H{right:.1}\"/>\
         <text class=\"label end\" x=\"{right:.1}\" y=\"{:.1}\">{}</text>",
        f.left,
        f.top,
        bottom + 32.0,
        escape(&plot.x_label)
    );
}

/// The marks in a nested picture, which clips at the frame.
fn marks(out: &mut String, plot: &Plot, f: &Frame) {
    let (x, y) = (&f.x, &f.y);
    let _ = write!(
        out,
        "<svg x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" overflow=\"hidden\">",
        f.left, f.top, f.width, f.height
    );
    for item in &plot.items {
        let class = item.style.class();
        match &item.mark {
            Mark::Line(points) => {
                let few = decimate(points, 2 * f.width as usize);
                let path = line_path(few.iter().map(|p| (x.place(p.0), y.place(p.1))));
                let _ = write!(out, "<path class=\"line {class}\" d=\"{path}\"/>");
            }
            Mark::Band(points) => {
                let few = decimate::decimate_band(points, f.width as usize);
                let placed = few
                    .iter()
                    .map(|p| (x.place(p.0), y.place(p.1), y.place(p.2)));
                let path = band_path(&placed.collect::<Vec<_>>());
                let _ = write!(out, "<path class=\"band {class}\" d=\"{path}\"/>");
            }
            Mark::Shade(spans) => shades(out, &class, spans, f),
            Mark::Bars { edges, heights } => bars(out, &class, edges, heights, f),
            Mark::Level(value) => {
                let at = y.place(*value);
                if at.is_finite() {
                    let (to, at) = (short(f.width), short(at));
                    let _ = write!(out, "<path class=\"line {class}\" d=\"M0 {at}H{to}\"/>");
                }
            }
        }
    }
    out.push_str("</svg>");
}

fn shades(out: &mut String, class: &str, spans: &[(f64, f64)], f: &Frame) {
    for (from, to) in spans {
        let (from, to) = (f.x.place(*from), f.x.place(*to));
        if from.is_finite() && to.is_finite() {
            let _ = area(
                out,
                "shade",
                class,
                (from, 0.0, (to - from).max(0.5), f.height),
            );
        }
    }
}

fn bars(out: &mut String, class: &str, edges: &[f64], heights: &[f64], f: &Frame) {
    let (x, y) = (&f.x, &f.y);
    let base = y.place(0.0);
    for (edge, height) in edges.windows(2).zip(heights) {
        let (from, to, top) = (x.place(edge[0]), x.place(edge[1]), y.place(*height));
        if [base, from, to, top].iter().all(|v| v.is_finite()) && *height != 0.0 {
            let rect = (
                from + 0.5,
                top.min(base),
                (to - from - 1.0).max(0.5),
                (base - top).abs(),
            );
            let _ = area(out, "bar", class, rect);
        }
    }
}

/// A path through points in pixels; a point that is not finite interrupts it.
fn line_path(points: impl Iterator<Item = (f64, f64)>) -> String {
    let mut path = String::new();
    let mut down = false;
    for (x, y) in points {
        if !x.is_finite() || !y.is_finite() {
            down = false;
            continue;
        }
        let pen = if down { 'L' } else { 'M' };
        let _ = write!(path, "{pen}{} {}", short(x), short(y));
        down = true;
    }
    path
}

/// Closed areas, one for each stretch without a gap.
fn band_path(points: &[(f64, f64, f64)]) -> String {
    let mut path = String::new();
    let finite = |p: &(f64, f64, f64)| p.0.is_finite() && p.1.is_finite() && p.2.is_finite();
    for part in points.split(|p| !finite(p)).filter(|part| part.len() > 1) {
        let there = part.iter().map(|p| (p.0, p.1));
        let back = part.iter().rev().map(|p| (p.0, p.2));
        path.push_str(&line_path(there.chain(back)));
        path.push('Z');
    }
    path
}

/// A tenth of a pixel, without a useless ".0".
fn short(value: f64) -> String {
    let text = format!("{value:.1}");
    text.strip_suffix(".0")
        .map_or_else(|| text.clone(), str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::super::Style;
    use super::*;

    #[test]
    fn a_gap_lifts_the_pen_and_splits_the_band() {
        let gap = [(0.0, 1.0), (1.0, f64::NAN), (2.0, 3.25)];
        assert_eq!(line_path(gap.into_iter()), "M0 1M2 3.2");
        let band = [
            (0.0, 0.0, 1.0),
            (1.0, 0.0, 1.0),
            (f64::NAN, 0.0, 0.0),
            (3.0, 0.0, 1.0),
            (4.0, 0.0, 1.0),
        ];
        assert_eq!(band_path(&band).matches('Z').count(), 2);
    }

    #[test]
    fn the_style_names_a_class_for_every_role() {
        for style in [
            Style::Series(0),
            Style::Series(5),
            Style::Truth,
            Style::Trusted,
            Style::Limit,
        ] {
            assert!(STYLE.contains(&format!(".{}", style.class())), "{style:?}");
        }
    }
}
