//! A figure of the page: a drawing with its words for those who do not see it, a legend, and the numbers behind it.

use std::fmt::Write;

use super::super::chart::{self, ChartAxis, escape};

/// Size of a drawing; on a phone a unit is a little less than a pixel.
pub(super) const SIZE: [f64; 2] = [440.0, 300.0];
/// Rows of numbers shown below a figure at most.
const ROWS: usize = 25;

/// A figure.
#[derive(Debug, Default)]
pub(super) struct Figure {
    pub(super) id: &'static str,
    pub(super) title: String,
    /// One or two sentences: what is to be seen.
    pub(super) caption: String,
    /// What lies inside the drawing; empty where there is nothing to show, and the caption says so in a line.
    pub(super) drawing: String,
    /// Class and words of each line or area.
    pub(super) legend: Vec<(String, String)>,
    /// The axes, from which the page reads values.
    pub(super) axes: Option<[ChartAxis; 2]>,
    /// Time runs along the drawing: the page marks the playback's time there.
    pub(super) over_time: bool,
    pub(super) numbers: FigureNumbers,
}

/// The numbers behind a figure.
#[derive(Debug, Default)]
pub(super) struct FigureNumbers {
    pub(super) heads: Vec<String>,
    pub(super) rows: Vec<Vec<String>>,
    /// The file that has all of them.
    pub(super) file: &'static str,
}

/// The axes that a drawing of the usual size leaves room for.
pub(super) fn axes(x: [f64; 2], y: [f64; 2]) -> [ChartAxis; 2] {
    [ChartAxis::linear(x, [64.0, SIZE[0] - 14.0]), ChartAxis::linear(chart::rounded_up(y), [SIZE[1] - 46.0, 12.0])]
}

/// Points of a line at most.
const POINTS: usize = 600;

/// A drawing of lines, each under a name, and its legend.
pub(super) fn lines(
    [x, y]: [ChartAxis; 2],
    titles: [&str; 2],
    lines: impl IntoIterator<Item = (String, Vec<[f64; 2]>)>,
) -> (String, Vec<(String, String)>) {
    let (mut drawing, mut legend) = (chart::axes(&x, &y, titles), Vec::new());
    for (n, (name, points)) in lines.into_iter().enumerate() {
        let points = chart::thinned(&points, POINTS);
        drawing += &chart::line(&x, &y, points.into_iter(), &format!("class=\"curve k{n}\""));
        legend.push((format!("line k{n}"), name));
    }
    (drawing, legend)
}

impl Figure {
    pub(super) fn html(&self) -> String {
        let (id, [width, height]) = (self.id, SIZE);
        let (title, caption) = (escape(&self.title), escape(&self.caption));
        if self.drawing.is_empty() {
            return format!("<p class=\"plot nothing\" id=\"{id}\"><b>{title}:</b> {caption}</p>\n");
        }
        let data = |name: &str, axis: ChartAxis| {
            let [[from, to], [start, end]] = [axis.range(), axis.paper];
            format!(" data-{name}=\"{from} {to} {start} {end}\"")
        };
        let axes = self.axes.map_or(String::new(), |[x, y]| {
            let time = if self.over_time { data("time", x) } else { String::new() };
            time + &data("x", x) + &data("y", y)
        });
        let mut out = format!(
            "<figure class=\"plot\" id=\"{id}\">\n<figcaption><h3>{title}</h3><p>{caption}</p></figcaption>\n\
             <svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-labelledby=\"{id}-t {id}-d\"{axes}>\n\
             <title id=\"{id}-t\">{title}</title><desc id=\"{id}-d\">{caption}</desc>\n{}</svg>\n",
            self.drawing
        );
        if !self.legend.is_empty() {
            out += "<ul class=\"legend\">";
            for (class, words) in &self.legend {
                // Writing to a string cannot fail.
                let _ = write!(out, "<li><i class=\"{class}\"></i>{}</li>", escape(words));
            }
            out += "</ul>\n";
        }
        out + &self.numbers.html() + "</figure>\n"
    }
}

impl FigureNumbers {
    /// Numbers over time, under these heads.
    pub(super) fn over_time(heads: impl Iterator<Item = String>, rows: Vec<Vec<String>>, file: &'static str) -> Self {
        Self { heads: std::iter::once("time [µs]".to_owned()).chain(heads).collect(), rows, file }
    }

    fn html(&self) -> String {
        if self.rows.is_empty() {
            return String::new();
        }
        let step = self.rows.len().div_ceil(ROWS);
        let last = self.rows.len() - 1;
        let shown = self.rows.iter().enumerate().filter(|(n, _)| n.is_multiple_of(step) || *n == last);
        let rows: Vec<&[String]> = shown.map(|(_, row)| row.as_slice()).collect();
        let all = if rows.len() == self.rows.len() { "" } else { "; all of them in " };
        let file = if all.is_empty() { "" } else { self.file };
        format!(
            "<details><summary>Numbers</summary>{}<p class=\"note\">{} of {} rows{all}<code>{file}</code></p></details>\n",
            table(&self.heads, &rows),
            rows.len(),
            self.rows.len()
        )
    }
}

/// A table of numbers.
fn table(heads: &[String], rows: &[&[String]]) -> String {
    let mut out = "<div class=\"scroll\" tabindex=\"0\"><table class=\"numbers\"><thead><tr>".to_owned();
    for head in heads {
        let _ = write!(out, "<th scope=\"col\">{}</th>", escape(head));
    }
    out += "</tr></thead><tbody>";
    for row in rows {
        out += "<tr>";
        for cell in *row {
            let _ = write!(out, "<td>{}</td>", escape(cell));
        }
        out += "</tr>";
    }
    out + "</tbody></table></div>"
}
