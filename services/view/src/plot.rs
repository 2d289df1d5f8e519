//! The plot of report and figures: time histories with bands, histograms, levels and shaded stretches, written as SVG.
//!
//! Colours are classes (`assets/plot.css`), so that a page can follow the reader's light or dark
//! setting; `Plot::file` puts the style sheet into the file itself.

mod data;
mod decimate;
mod draw;
mod scale;

pub use decimate::decimate;
pub use scale::Scale;

/// Most points of a mark; more than two a pixel are not visible.
pub const MAX_POINTS: usize = 2000;

/// The style sheet of the marks, in CSS variables of the page.
pub const STYLE: &str = include_str!("../assets/plot.css");

/// The role of a mark; it decides its colour, width and dashes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Style {
    /// Estimator number 0, 1, 2...
    Series(usize),
    /// The truth or the reference.
    Truth,
    /// A stretch in which heft trusts the estimate.
    Trusted,
    /// A stretch in which a condition holds.
    Holds,
    /// The expectation, or a threshold.
    Limit,
}

impl Style {
    /// Name of the CSS class.
    fn class(self) -> String {
        match self {
            Self::Series(i) => format!("s{}", i % 6),
            Self::Truth => "truth".into(),
            Self::Trusted => "trusted".into(),
            Self::Holds => "holds".into(),
            Self::Limit => "limit".into(),
        }
    }
}

/// Something drawn in a plot.
#[derive(Debug, Clone)]
enum Mark {
    Line(Vec<(f64, f64)>),
    Band(Vec<(f64, f64, f64)>),
    Shade(Vec<(f64, f64)>),
    Bars { edges: Vec<f64>, heights: Vec<f64> },
    Level(f64),
}

#[derive(Debug, Clone)]
struct Item {
    label: String,
    style: Style,
    mark: Mark,
}

/// A plot under construction: axes first, then marks from back to front.
#[derive(Debug, Clone)]
pub struct Plot {
    title: String,
    x_label: String,
    x_scale: Scale,
    y_scale: Scale,
    x_range: Option<(f64, f64)>,
    y_range: Option<(f64, f64)>,
    y_possible: (f64, f64),
    x_names: Vec<(f64, String)>,
    y_names: Vec<(f64, String)>,
    items: Vec<Item>,
}

impl Plot {
    /// An empty plot; `title` names the ordinate with its unit, `x_label` the abscissa.
    pub fn new(title: impl Into<String>, x_label: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            x_label: x_label.into(),
            x_scale: Scale::Linear,
            y_scale: Scale::Linear,
            x_range: None,
            y_range: None,
            y_possible: (f64::NEG_INFINITY, f64::INFINITY),
            x_names: Vec::new(),
            y_names: Vec::new(),
            items: Vec::new(),
        }
    }

    /// Logarithmic axes; values that are not positive are left out.
    #[must_use]
    pub fn logarithmic(mut self) -> Self {
        self.x_scale = Scale::Logarithmic;
        self.y_scale = Scale::Logarithmic;
        self
    }

    /// Fixes the range of the ordinate.
    #[must_use]
    pub fn y_range(mut self, low: f64, high: f64) -> Self {
        self.y_range = Some((low, high));
        self
    }

    /// The physical range of the quantity: no band and no margin widens the ordinate beyond it; a line may.
    #[must_use]
    pub fn y_possible(mut self, (low, high): (f64, f64)) -> Self {
        self.y_possible = (low, high);
        self
    }

    /// Fixes the range of the abscissa.
    #[must_use]
    pub fn x_range(mut self, low: f64, high: f64) -> Self {
        self.x_range = Some((low, high));
        self
    }

    /// Names in place of numbers on the abscissa.
    #[must_use]
    pub fn x_names(mut self, names: Vec<(f64, String)>) -> Self {
        self.x_names = names;
        self
    }

    /// Names in place of numbers on the ordinate.
    #[must_use]
    pub fn y_names(mut self, names: Vec<(f64, String)>) -> Self {
        self.y_names = names;
        self
    }

    /// A line through `points`. A value that is not finite interrupts it; a point with an abscissa that is not finite is left
    /// out. An empty label keeps it out of the legend.
    pub fn line(&mut self, label: impl Into<String>, style: Style, points: &[(f64, f64)]) {
        let mut line = decimate(points, MAX_POINTS);
        line.retain(|(x, _)| x.is_finite());
        self.add(label, style, Mark::Line(line));
    }

    /// A band between the second and the third value of each point.
    pub fn band(&mut self, label: impl Into<String>, style: Style, points: &[(f64, f64, f64)]) {
        let mut band = decimate::decimate_band(points, MAX_POINTS / 2);
        band.retain(|(x, ..)| x.is_finite());
        self.add(label, style, Mark::Band(band));
    }

    /// Shaded stretches of the abscissa.
    pub fn shade(&mut self, label: impl Into<String>, style: Style, spans: &[(f64, f64)]) {
        self.add(label, style, Mark::Shade(spans.to_vec()));
    }

    /// Bars between `edges` (one more than `heights`).
    pub fn bars(&mut self, label: impl Into<String>, style: Style, edges: &[f64], heights: &[f64]) {
        let (edges, heights) = (edges.to_vec(), heights.to_vec());
        self.add(label, style, Mark::Bars { edges, heights });
    }

    /// A horizontal line over the whole width.
    pub fn level(&mut self, label: impl Into<String>, style: Style, y: f64) {
        self.add(label, style, Mark::Level(y));
    }

    fn add(&mut self, label: impl Into<String>, style: Style, mark: Mark) {
        let label = label.into();
        self.items.push(Item { label, style, mark });
    }

    /// The title.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// Label of the abscissa.
    pub fn x_label(&self) -> &str {
        &self.x_label
    }

    /// The marks for the script of the report; bars and logarithmic axes are left out.
    pub fn data(&self) -> serde_json::Value {
        data::of(self)
    }

    /// The plot as an `<svg>` element for a page that holds [`STYLE`].
    pub fn svg(&self, width: u32, height: u32) -> String {
        draw::svg(self, f64::from(width), f64::from(height))
    }

    /// Range of the abscissa over all marks.
    fn x_extent(&self) -> (f64, f64) {
        let given = self.x_range.map(|r| scale::Extent::of(self.x_scale, r));
        given.unwrap_or_else(|| {
            let mut extent = scale::Extent::new(self.x_scale);
            for item in &self.items {
                match &item.mark {
                    Mark::Line(points) => points.iter().for_each(|p| extent.add(p.0)),
                    Mark::Band(points) => points.iter().for_each(|p| extent.add(p.0)),
                    Mark::Bars { edges, .. } => edges.iter().for_each(|&e| extent.add(e)),
                    Mark::Shade(_) | Mark::Level(_) => {}
                }
            }
            extent.plain()
        })
    }

    /// Range of the ordinate: lines and bars whole, bands without their widest tenth. The interval of a filter without
    /// measurements would flatten everything else.
    fn y_extent(&self) -> (f64, f64) {
        self.y_range.unwrap_or_else(|| {
            let mut extent = scale::Extent::new(self.y_scale);
            for item in &self.items {
                match &item.mark {
                    Mark::Line(points) => points.iter().for_each(|p| extent.add(p.1)),
                    Mark::Band(points) => add_band(&mut extent, points, self.y_possible),
                    Mark::Bars { heights, .. } => {
                        extent.add(0.0);
                        heights.iter().for_each(|&h| extent.add(h));
                    }
                    Mark::Level(y) => extent.add(*y),
                    Mark::Shade(_) => {}
                }
            }
            extent.padded(self.y_possible)
        })
    }
}

fn add_band(extent: &mut scale::Extent, points: &[(f64, f64, f64)], (least, most): (f64, f64)) {
    let finite = points.iter().filter(|p| p.1.is_finite() && p.2.is_finite());
    let mut widths: Vec<_> = finite.map(|p| (p.2 - p.1, p.1, p.2)).collect();
    widths.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (_, low, high) in widths.iter().take(widths.len() * 9 / 10) {
        extent.add(low.max(least));
        extent.add(high.min(most));
    }
}

/// Plots one below the other in a file, with `caption` and the `source` of the data above them.
pub fn file(caption: &str, source: &str, plots: &[Plot], width: u32, height: u32) -> String {
    draw::file(caption, source, plots, f64::from(width), f64::from(height))
}

/// Text escaped for HTML and SVG.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(n: usize) -> Vec<(f64, f64)> {
        (0..n)
            .map(|i| (i as f64 * 0.001, (i as f64 * 0.01).sin()))
            .collect()
    }

    #[test]
    fn a_million_samples_make_a_small_plot() {
        let mut plot = Plot::new("a", "t");
        plot.line("x", Style::Series(0), &wave(1_000_000));
        let svg = plot.svg(900, 280);
        assert!(
            svg.len() < 40_000,
            "{} bytes: 2 points a pixel at 12 bytes",
            svg.len()
        );
    }

    #[test]
    fn text_cannot_break_out_of_the_markup() {
        let mut plot = Plot::new("<script>", "t\"");
        plot.line("a&b", Style::Truth, &[(0.0, 1.0), (1.0, 2.0)]);
        let svg = plot.svg(400, 200);
        assert!(!svg.contains("<script>") && svg.contains("a&amp;b"));
    }

    #[test]
    fn an_empty_plot_and_one_of_nothing_but_nan_can_be_drawn() {
        let mut plot = Plot::new("a", "t");
        assert!(plot.svg(400, 200).ends_with("</svg>"));
        plot.line("x", Style::Truth, &[(0.0, f64::NAN), (f64::NAN, 1.0)]);
        plot.band("y", Style::Truth, &[(0.0, f64::NAN, f64::INFINITY)]);
        let svg = plot.svg(400, 200);
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
    }

    #[test]
    fn a_file_stands_alone() {
        let file = file(
            "c",
            "s",
            &[Plot::new("a", "t"), Plot::new("b", "t")],
            600,
            200,
        );
        assert!(file.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\""));
        assert!(file.contains("(a)") && file.contains("(b)") && file.contains("<style>"));
    }
}
