//! Plots as SVG: axes, lines, dots and words. Shapes carry classes; their colours are those of the page, or of `STYLE` in a file of
//! its own.

/// Style of plots on white, for files of their own.
pub(crate) const STYLE: &str = ".grid { stroke: #222; stroke-opacity: 0.1; } .frame { fill: none; stroke: #888; } text { fill: #222; } \
    .curve { fill: none; stroke: currentColor; stroke-width: 2; } .dashed { stroke-dasharray: 7 4; } .interval { stroke-opacity: 0.45; } \
    .dot { fill: currentColor; fill-opacity: 0.35; stroke: currentColor; } \
    .ink { color: #222; } .k0 { color: #1f5fae; } .k1 { color: #cc5a0a; } .k2 { color: #2a8f7f; } .t0 { color: #a9c9ea; } \
    .t1 { color: #7fb0de; } .t2 { color: #5593cd; } .t3 { color: #3075b5; } .t4 { color: #185795; } .t5 { color: #07345f; }";

/// Size of a plot; on a phone a unit is a little less than a pixel.
pub(crate) const SIZE: [f64; 2] = [440.0, 300.0];
/// Points of a line at most.
const POINTS: usize = 600;

/// Width of a letter at the size of tick labels.
const LETTER: f64 = 6.4;

/// An axis over a length on the paper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Axis {
    /// Values at the ends.
    pub(crate) range: [f64; 2],
    /// Their places on the paper.
    pub(crate) paper: [f64; 2],
}

impl Axis {
    /// An axis whose ticks lie evenly. A range that is none becomes one.
    fn linear(range: [f64; 2], paper: [f64; 2]) -> Self {
        let [low, high] = if range[0].is_finite() { range } else { [0.0, range[1]] };
        let high = if high.is_finite() && high > low { high } else { low + 1.0 };
        Self { range: [low, high], paper }
    }

    /// Place of a value.
    fn at(&self, value: f64) -> f64 {
        let share = (value - self.range[0]) / (self.range[1] - self.range[0]);
        self.paper[0] + share * (self.paper[1] - self.paper[0])
    }

    /// Round numbers on the axis: about five, or one, two and five times the powers of ten (powers alone where it is long).
    fn ticks(&self) -> Vec<f64> {
        let [low, high] = self.range;
        let step = round_step((high - low) / 5.0);
        let count = (low / step).ceil() as i64..=(high / step * (1.0 + 1e-12)).floor() as i64;
        count.map(|n| n as f64 * step).collect()
    }
}

/// One, two or five times a power of ten, at least this.
fn round_step(least: f64) -> f64 {
    let power = 10.0_f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|step| *step >= least).unwrap_or(least)
}

/// Range widened at its upper end to where a tick lies.
fn rounded_up([low, high]: [f64; 2]) -> [f64; 2] {
    let span = high - low;
    if !(span > 0.0 && span.is_finite()) {
        return [low, high];
    }
    let step = round_step(span / 5.0);
    [low, (high / step).ceil() * step]
}

/// A tick's label.
fn label(tick: f64) -> String {
    if tick != 0.0 && !(1e-4..1e6).contains(&tick.abs()) {
        return format!("{tick:.0e}").replace('-', "−");
    }
    let text = format!("{tick:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.replace('-', "−") }
}

/// Text escaped for XML and HTML, between tags and inside quotes.
pub(crate) fn escape(text: &str) -> String {
    let entities = [('&', "&amp;"), ('<', "&lt;"), ('>', "&gt;"), ('"', "&quot;"), ('\'', "&#39;")];
    entities.into_iter().fold(text.to_owned(), |text, (letter, entity)| text.replace(letter, entity))
}

/// A figure of a page: a plot with its words.
#[derive(Clone, Debug)]
pub(crate) struct Figure {
    pub(crate) id: String,
    pub(crate) title: String,
    /// One or two sentences: what is to be seen.
    pub(crate) caption: String,
    /// `None` where there is nothing to show, and the caption says so in a line.
    pub(crate) plot: Option<Plot>,
}

impl Figure {
    pub(crate) fn new(id: &str, title: &str, caption: impl Into<String>, plot: Option<Plot>) -> Self {
        Self { id: id.to_owned(), title: title.to_owned(), caption: caption.into(), plot }
    }
}

/// A plot: two axes, and what lies between them.
#[derive(Clone, Debug)]
pub struct Plot {
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    titles: [String; 2],
    shapes: String,
    /// Class and words of each line.
    pub(crate) legend: Vec<(String, String)>,
    /// Time runs along x: the page marks the playback's time there.
    pub(crate) over_time: bool,
}

impl Plot {
    /// An empty plot with these ranges, the upright one widened to its next tick.
    pub fn new(x: [f64; 2], y: [f64; 2], titles: [&str; 2]) -> Self {
        let x = Axis::linear(x, [64.0, SIZE[0] - 14.0]);
        let y = Axis::linear(rounded_up(y), [SIZE[1] - 46.0, 12.0]);
        let titles = titles.map(str::to_owned);
        Self { x, y, titles, shapes: String::new(), legend: Vec::new(), over_time: false }
    }

    /// Adds a line; a name puts it into the legend.
    pub fn line(&mut self, class: &str, name: &str, points: &[[f64; 2]]) {
        self.shapes += &line(&self.x, &self.y, &thinned(points, POINTS), class);
        if !name.is_empty() {
            self.legend.push((format!("line {class}"), name.to_owned()));
        }
    }

    /// Adds a dot, with words for the pointer.
    pub fn dot(&mut self, class: &str, [x, y]: [f64; 2], radius: f64, words: &str) {
        let ([x, y], words) = ([self.x.at(x), self.y.at(y)], escape(words));
        let circle = format!("<circle class=\"dot {class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\">");
        self.shapes += &(circle + &format!("<title>{words}</title></circle>\n"));
    }

    /// Adds a bar from 0 along x under its words; the upright axis has no numbers then.
    pub fn bar(&mut self, class: &str, [end, y]: [f64; 2], words: &str) {
        self.shapes += &line(&self.x, &self.y, &[[0.0, y], [end, y]], &format!("bar {class}"));
        self.shapes += &text(self.x.at(0.0) + 4.0, self.y.at(y) - 14.0, "", words);
        self.titles[1].clear();
    }

    /// Adds words to the legend.
    pub fn name(&mut self, class: &str, words: &str) {
        self.legend.push((class.to_owned(), words.to_owned()));
    }

    /// Contents of the drawing.
    pub(crate) fn drawing(&self) -> String {
        axes(&self.x, &self.y, self.titles.each_ref().map(String::as_str)) + &self.shapes
    }
}

/// A file of plots beside each other, under a title and a line of words.
pub fn file(title: &str, words: &str, plots: &[Plot]) -> String {
    let mut out = text(24.0, 28.0, "font-size=\"16\" font-weight=\"bold\"", title) + &text(24.0, 48.0, "", words);
    for (n, plot) in plots.iter().enumerate() {
        let across = SIZE[0] * n as f64;
        out += &format!("<g transform=\"translate({across} 64)\">\n{}", plot.drawing());
        for (n, (class, name)) in plot.legend.iter().enumerate() {
            let (x, y) = (64.0 + 125.0 * (n % 3) as f64, SIZE[1] + 6.0 + 16.0 * (n / 3) as f64);
            let (class, end) = (class.split_once(' ').map_or("", |(_, class)| class), x + 20.0);
            out += &format!("<line class=\"curve {class}\" x1=\"{x}\" x2=\"{end}\" y1=\"{y}\" y2=\"{y}\"/>\n");
            out += &text(x + 26.0, y + 4.0, "", name);
        }
        out += "</g>\n";
    }
    let rows = plots.iter().map(|plot| plot.legend.len().div_ceil(3)).max().unwrap_or(0);
    let [width, height] = [SIZE[0] * plots.len().max(1) as f64, SIZE[1] + 72.0 + 16.0 * rows as f64];
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" \
         font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n\
         <style>{STYLE}</style>\n{out}</svg>\n"
    )
}

/// Words at a place. `attributes`: class, anchor, size.
fn text(x: f64, y: f64, attributes: &str, words: &str) -> String {
    format!("<text x=\"{x:.1}\" y=\"{y:.1}\" {attributes}>{}</text>\n", escape(words))
}

/// A line through points, those left out that are no numbers.
fn line(x: &Axis, y: &Axis, points: &[[f64; 2]], class: &str) -> String {
    let places = points.iter().map(|p| [x.at(p[0]), y.at(p[1])]).filter(|p| p[0].is_finite() && p[1].is_finite());
    let places: Vec<String> = places.map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
    format!("<polyline points=\"{}\" fill=\"none\" class=\"curve {class}\"/>\n", places.join(" "))
}

/// Points of a line as dense as paper can show: of every few the lowest and the highest.
fn thinned(points: &[[f64; 2]], most: usize) -> Vec<[f64; 2]> {
    if points.len() <= most {
        return points.to_vec();
    }
    let size = points.len().div_ceil(most / 2).max(2);
    let mut out = Vec::with_capacity(most + 2);
    for part in points.chunks(size) {
        let order = |a: &usize, b: &usize| part[*a][1].total_cmp(&part[*b][1]);
        let [low, high] = [(0..part.len()).min_by(order), (0..part.len()).max_by(order)].map(|at| at.unwrap_or(0));
        out.push(part[low.min(high)]);
        out.push(part[low.max(high)]);
    }
    if let (Some(first), Some(last)) = (points.first(), points.last()) {
        out.insert(0, *first);
        out.push(*last);
    }
    out
}

/// Frame, grid, tick labels and titles.
fn axes(x: &Axis, y: &Axis, [x_title, y_title]: [&str; 2]) -> String {
    let [left, right] = x.paper;
    let [bottom, top] = y.paper;
    let mut out = String::new();
    for tick in x.ticks() {
        let at = x.at(tick);
        out += &format!("<line class=\"grid\" x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"{top}\" y2=\"{bottom}\"/>\n");
        out += &text(at, bottom + 16.0, "class=\"tick\" text-anchor=\"middle\"", &label(tick));
    }
    let ticks = if y_title.is_empty() { Vec::new() } else { y.ticks() };
    for tick in &ticks {
        let at = y.at(*tick);
        out += &format!("<line class=\"grid\" x1=\"{left}\" x2=\"{right}\" y1=\"{at:.1}\" y2=\"{at:.1}\"/>\n");
        out += &text(left - 6.0, at + 4.0, "class=\"tick\" text-anchor=\"end\"", &label(*tick));
    }
    let (width, height) = (right - left, bottom - top);
    out += &format!("<rect class=\"frame\" x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\"/>\n");
    out += &text(0.5 * (left + right), bottom + 34.0, "class=\"title\" text-anchor=\"middle\"", x_title);
    let widest = ticks.iter().map(|tick| label(*tick).chars().count()).max().unwrap_or(0) as f64;
    let (x, y) = (left - 16.0 - LETTER * widest, 0.5 * (top + bottom));
    // From bottom to top.
    let turn = format!("class=\"title\" text-anchor=\"middle\" transform=\"rotate(-90 {x:.1} {y:.1})\"");
    out + &text(x, y, &turn, y_title)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis) -> String {
        axis.ticks().iter().map(|tick| label(*tick)).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn a_linear_axis_has_round_ticks_whatever_its_range() {
        assert_eq!(labels(&Axis::linear([0.0, 155.0], [0.0, 1.0])), "0 50 100 150");
        assert_eq!(labels(&Axis::linear([-0.3, 0.3], [0.0, 1.0])), "−0.2 0 0.2");
        assert_eq!(labels(&Axis::linear(rounded_up([0.0, 0.7]), [0.0, 1.0])), "0 0.2 0.4 0.6 0.8");
        for range in [[0.0, 0.0], [f64::NAN, f64::NAN], [2.0, f64::INFINITY], [f64::INFINITY, f64::NEG_INFINITY]] {
            let axis = Axis::linear(range, [0.0, 1.0]);
            assert!(axis.at(1.0).is_finite() && !axis.ticks().is_empty(), "{range:?}");
        }
    }

    #[test]
    fn a_line_that_is_too_dense_keeps_its_peaks_and_ends() {
        let mut points: Vec<[f64; 2]> = (0..10_000).map(|n| [f64::from(n), (f64::from(n) * 0.01).sin()]).collect();
        points[4321][1] = 9.0;
        let thin = thinned(&points, 400);
        assert!(thin.len() <= 404, "{}", thin.len());
        assert!(thin.contains(&[4321.0, 9.0]) && thin[0] == points[0] && thin.last() == points.last());
        assert!(thin.windows(2).all(|pair| pair[0][0] <= pair[1][0]));
        assert_eq!(thinned(&points[..300], 400), points[..300]);
    }
}
