//! `bench.svg`: run time against error, both logarithmic, one panel per case.
//!
//! Paper and ink follow the reader's preference for light or dark; without one they are light.

use std::fmt::Write;

use super::{BenchResult, BenchRow};
use crate::output::plot::{self, Axis, escape, label};

const WIDTH: f64 = 960.0;
/// Of one panel.
const HEIGHT: f64 = 520.0;
const LEFT: f64 = 90.0;
const RIGHT: f64 = 930.0;
/// Top and bottom of the plot area within a panel.
const TOP: f64 = 72.0;
const BOTTOM: f64 = HEIGHT - 62.0;
/// Height of a line of labels, and width of a letter.
const LINE: f64 = 14.0;
const LETTER: f64 = 6.2;

const STYLE: &str = "<style>
  .paper { fill: #ffffff; }
  text, .scatter { fill: #1c2430; }
  .scatter { fill-opacity: 0.07; }
  .grid, .frame, .limit, .lead { stroke: #1c2430; fill: none; }
  .grid { stroke-opacity: 0.1; }
  .frame { stroke-opacity: 0.5; }
  .limit { stroke-opacity: 0.6; stroke-dasharray: 5 4; }
  .lead { stroke-opacity: 0.35; }
  .front { stroke: #0b62b0; stroke-width: 1.8; fill: none; }
  .best { fill: #0b62b0; }
  .other { fill: #8a5a00; }
  @media (prefers-color-scheme: dark) {
    .paper { fill: #14181d; }
    text, .scatter { fill: #e6e9ee; }
    .grid, .frame, .limit, .lead { stroke: #e6e9ee; }
    .front { stroke: #6db6ff; }
    .best { fill: #6db6ff; }
    .other { fill: #f0b54a; }
  }
</style>
<rect class=\"paper\" width=\"100%\" height=\"100%\"/>
";

/// The picture of everything measured. `tolerance`: error that is good enough [-].
pub fn plot(measured: &[BenchResult], tolerance: f64) -> String {
    let height = HEIGHT * measured.len().max(1) as f64;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" \
         width=\"{WIDTH}\" height=\"{height}\" \
         font-family=\"sans-serif\" font-size=\"12\">\n{STYLE}"
    );
    for (at, one) in measured.iter().enumerate() {
        let _ = writeln!(out, "<g transform=\"translate(0 {})\">\n{}</g>", HEIGHT * at as f64, panel(one, tolerance));
    }
    out + "</svg>\n"
}

fn panel(measured: &BenchResult, tolerance: f64) -> String {
    let mut rows: Vec<(&BenchRow, [f64; 2])> =
        measured.rows.iter().filter_map(|row| Some((row, [row.time(), row.velocity_error()? * 100.0]))).collect();
    rows.sort_by(|a, b| a.1[0].total_cmp(&b.1[0]));
    let limit = tolerance * 100.0;
    let values = |of: usize| rows.iter().map(move |(_, point)| point[of]);
    let x = Axis::logarithmic(&values(0).collect::<Vec<_>>(), [LEFT, RIGHT]);
    let y = Axis::logarithmic(&values(1).chain([limit]).collect::<Vec<_>>(), [BOTTOM, TOP]);
    let mut out = String::new();
    let title = format!("{}: run time against error", measured.case.title);
    out += &plot::text(24.0, 28.0, "font-size=\"16\" font-weight=\"bold\"", &title);
    out += &plot::text(24.0, 48.0, "font-size=\"13\"", &caption(measured));
    out += &plot::axes(&x, &y, ["time in the loop [s]", "error of the velocity history [%]"]);
    let at = y.at(limit);
    let _ = writeln!(out, "<line class=\"limit\" x1=\"{LEFT}\" x2=\"{RIGHT}\" y1=\"{at:.1}\" y2=\"{at:.1}\"/>");
    let _ = writeln!(
        out,
        "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\" font-size=\"11\">asked for: {} %</text>",
        RIGHT - 4.0,
        at - 4.0,
        label(limit)
    );
    if let Some(scatter) = measured.scatter().map(|error| y.at(error * 100.0)).filter(|at| *at < BOTTOM) {
        let (width, height) = (RIGHT - LEFT, BOTTOM - scatter);
        let _ = writeln!(
            out,
            "<rect class=\"scatter\" x=\"{LEFT}\" y=\"{scatter:.1}\" width=\"{width}\" height=\"{height:.1}\"/>\n\
             <text x=\"{}\" y=\"{:.1}\" font-size=\"11\">scatter of the reference</text>",
            LEFT + 6.0,
            BOTTOM - 6.0
        );
    }
    let front = rows.iter().filter(|(row, _)| row.on_front);
    let line: Vec<String> = front.map(|(_, point)| format!("{:.1},{:.1}", x.at(point[0]), y.at(point[1]))).collect();
    let _ = writeln!(out, "<polyline class=\"front\" points=\"{}\"/>", line.join(" "));
    out + &points(&rows, &x, &y)
}

fn caption(measured: &BenchResult) -> String {
    let front = "line: what no other choice beats";
    match measured.cheapest.map(|at| &measured.rows[at]) {
        Some(row) => {
            let time = row.time();
            let decimals = (2.0 - time.log10().floor()).clamp(0.0, 9.0) as usize;
            format!("cheapest that is good enough: {}, {time:.decimals$} s; {front}", row.choice.name)
        }
        None => format!("no choice is good enough; {front}"),
    }
}

/// Points with their labels, each where none was put before.
fn points(rows: &[(&BenchRow, [f64; 2])], x: &Axis, y: &Axis) -> String {
    let mut out = String::new();
    let dots: Vec<[f64; 2]> = rows.iter().map(|(_, point)| [x.at(point[0]), y.at(point[1])]).collect();
    let mut taken: Vec<[f64; 4]> = dots.iter().map(|[px, py]| [px - 5.0, px + 5.0, py - 5.0, py + 5.0]).collect();
    for (n, (row, _)) in rows.iter().enumerate() {
        let [px, py] = dots[n];
        let class = if row.on_front { "best" } else { "other" };
        let other = if row.same_outcome { String::new() } else { format!(" ({})", row.run.outcome.word()) };
        let name = row.choice.name.split(':').next().unwrap_or_default();
        let name = format!("{name}{other}");
        let _ = writeln!(out, "<circle class=\"{class}\" cx=\"{px:.1}\" cy=\"{py:.1}\" r=\"4.5\"/>");
        let place = free_place(&taken, [px, py], LETTER * name.chars().count() as f64);
        taken.push(place);
        let (tx, ty) = (place[0], place[3] - 3.0);
        if (ty - py).abs() > 1.5 * LINE {
            let end = place[2] + 0.5 * LINE;
            let _ =
                writeln!(out, "<line class=\"lead\" x1=\"{px:.1}\" y1=\"{py:.1}\" x2=\"{tx:.1}\" y2=\"{end:.1}\"/>");
        }
        let _ = writeln!(out, "<text x=\"{tx:.1}\" y=\"{ty:.1}\" font-size=\"11\">{}</text>", escape(&name));
    }
    out
}

/// A rectangle (left, right, top, bottom) for a label of this width beside a point, away from what is taken: the
/// nearest line above or below, right of the point or left of it.
fn free_place(taken: &[[f64; 4]], [px, py]: [f64; 2], width: f64) -> [f64; 4] {
    let place = |line: i32, right: bool| {
        let left = if right { px + 8.0 } else { px - 8.0 - width };
        let top = py - 0.5 * LINE + LINE * f64::from(line);
        [left, left + width, top, top + LINE]
    };
    let lines = (0..16).flat_map(|n| [n, -n]);
    let candidates = lines.flat_map(|line| [place(line, true), place(line, false)]);
    let inside = |p: &[f64; 4]| p[0] >= LEFT && p[1] <= RIGHT && p[2] >= TOP && p[3] <= BOTTOM;
    let clear = |p: &[f64; 4]| taken.iter().all(|t| p[1] < t[0] || t[1] < p[0] || p[3] <= t[2] || t[3] <= p[2]);
    candidates.into_iter().find(|p| inside(p) && clear(p)).unwrap_or_else(|| place(0, true))
}

#[cfg(test)]
#[path = "plot_tests.rs"]
mod tests;
