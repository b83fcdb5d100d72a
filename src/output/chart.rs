//! What every drawing shares: axes, lines and words as SVG. Shapes carry classes; colours are the drawing's own affair.

use std::fmt::Write;

/// Frame, grid, words of drawings on white.
pub(crate) const STYLE: &str =
    ".grid { stroke: #222; stroke-opacity: 0.1; } .frame { fill: none; stroke: #888; } text { fill: #222; }";

/// Width of a letter at the size of tick labels.
const LETTER: f64 = 6.4;

/// An axis over a length on the paper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ChartAxis {
    /// Values at the ends.
    range: [f64; 2],
    /// Where they lie on the paper.
    pub(crate) paper: [f64; 2],
}

impl ChartAxis {
    /// An axis whose ticks lie evenly. A range that is none becomes one.
    pub(crate) fn linear(range: [f64; 2], paper: [f64; 2]) -> Self {
        let [low, high] = if range[0].is_finite() { range } else { [0.0, range[1]] };
        let high = if high.is_finite() && high > low { high } else { low + 1.0 };
        Self { range: [low, high], paper }
    }

    /// Values at the ends.
    pub(crate) fn range(&self) -> [f64; 2] {
        self.range
    }

    /// Where a value lies.
    pub(crate) fn at(&self, value: f64) -> f64 {
        let share = (value - self.range[0]) / (self.range[1] - self.range[0]);
        self.paper[0] + share * (self.paper[1] - self.paper[0])
    }

    /// Round numbers on it: about five.
    pub(crate) fn ticks(&self) -> Vec<f64> {
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

/// A range widened at its upper end to where a tick lies.
pub(crate) fn rounded_up([low, high]: [f64; 2]) -> [f64; 2] {
    let span = high - low;
    if !(span > 0.0 && span.is_finite()) {
        return [low, high];
    }
    let step = round_step(span / 5.0);
    [low, (high / step).ceil() * step]
}

/// A number as an axis shows it.
pub(crate) fn label(tick: f64) -> String {
    if tick != 0.0 && !(1e-4..1e6).contains(&tick.abs()) {
        return format!("{tick:.0e}").replace('-', "−");
    }
    let text = format!("{tick:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.replace('-', "−") }
}

/// Escapes text for XML and HTML, between tags and inside quotes.
pub(crate) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '\'' => out += "&#39;",
            c => out.push(c),
        }
    }
    out
}

/// A picture on white. `attributes`: more of what holds for all of it.
pub(crate) fn svg([width, height]: [f64; 2], attributes: &str, style: &str, body: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" \
         font-family=\"sans-serif\" font-size=\"12\"{attributes}>\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n\
         <style>{style}</style>\n{body}</svg>\n"
    )
}

/// A rectangle on the paper, with what lies inside its element.
pub(crate) fn area([left, right]: [f64; 2], [top, bottom]: [f64; 2], attributes: &str, inside: &str) -> String {
    let [width, height] = [right - left, bottom - top];
    let end = if inside.is_empty() { "/>".to_owned() } else { format!(">{inside}</rect>") };
    format!("<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" {attributes}{end}\n")
}

/// Words at a place. `attributes`: class, anchor, size.
pub(crate) fn text(x: f64, y: f64, attributes: &str, words: &str) -> String {
    format!("<text x=\"{x:.1}\" y=\"{y:.1}\" {attributes}>{}</text>\n", escape(words))
}

/// A line through points, those left out that are no numbers.
pub(crate) fn line(x: &ChartAxis, y: &ChartAxis, points: impl Iterator<Item = [f64; 2]>, attributes: &str) -> String {
    format!("<polyline points=\"{}\" fill=\"none\" {attributes}/>\n", places(x, y, points))
}

/// Places on the paper, as SVG writes them.
pub(crate) fn places(x: &ChartAxis, y: &ChartAxis, points: impl Iterator<Item = [f64; 2]>) -> String {
    let mut path = String::new();
    for [px, py] in points.map(|p| [x.at(p[0]), y.at(p[1])]).filter(|p| p[0].is_finite() && p[1].is_finite()) {
        // Writing to a string cannot fail.
        let _ = write!(path, "{px:.1},{py:.1} ");
    }
    path.trim_end().to_owned()
}

/// Points of a line as dense as paper can show: of every few the lowest and the highest.
pub(crate) fn thinned(points: &[[f64; 2]], most: usize) -> Vec<[f64; 2]> {
    if points.len() <= most {
        return points.to_vec();
    }
    let size = points.len().div_ceil(most / 2).max(2);
    let mut out = Vec::with_capacity(most + 2);
    for part in points.chunks(size) {
        let extreme = |largest: bool| {
            let order = |a: &usize, b: &usize| part[*a][1].total_cmp(&part[*b][1]);
            let at = 0..part.len();
            if largest { at.max_by(order) } else { at.min_by(order) }.unwrap_or(0)
        };
        let (low, high) = (extreme(false), extreme(true));
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
pub(crate) fn axes(x: &ChartAxis, y: &ChartAxis, [x_title, y_title]: [&str; 2]) -> String {
    let [left, right] = x.paper;
    let [bottom, top] = y.paper;
    let mut out = String::new();
    for tick in x.ticks() {
        let at = x.at(tick);
        let _ = writeln!(out, "<line class=\"grid\" x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"{top}\" y2=\"{bottom}\"/>");
        out += &text(at, bottom + 16.0, "class=\"tick\" text-anchor=\"middle\"", &label(tick));
    }
    let ticks = y.ticks();
    for tick in &ticks {
        let at = y.at(*tick);
        let _ = writeln!(out, "<line class=\"grid\" x1=\"{left}\" x2=\"{right}\" y1=\"{at:.1}\" y2=\"{at:.1}\"/>");
        out += &text(left - 6.0, at + 4.0, "class=\"tick\" text-anchor=\"end\"", &label(*tick));
    }
    let (width, height) = (right - left, bottom - top);
    let _ = writeln!(out, "<rect class=\"frame\" x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\"/>");
    out += &text(0.5 * (left + right), bottom + 34.0, "class=\"title\" text-anchor=\"middle\"", x_title);
    let widest = ticks.iter().map(|tick| label(*tick).chars().count()).max().unwrap_or(0) as f64;
    out + &upright(left - 16.0 - LETTER * widest, 0.5 * (top + bottom), "title", y_title)
}

/// Words from bottom to top around a place.
pub(crate) fn upright(x: f64, y: f64, class: &str, words: &str) -> String {
    let turn = format!("class=\"{class}\" text-anchor=\"middle\" transform=\"rotate(-90 {x:.1} {y:.1})\"");
    text(x, y, &turn, words)
}

#[cfg(test)]
#[path = "chart_tests.rs"]
mod tests;
