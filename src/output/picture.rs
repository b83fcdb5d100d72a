//! `shot.svg`: the shot at a glance, drawn from the run's own numbers.
//!
//! Left, deflection profiles through the point of impact; right, projectile velocity and contact force over time.

use std::fmt::Write;

use super::summary::residual_velocity;
use crate::case::{Along, Case};
use crate::outcome::Outcome;
use crate::simulation::Run;

const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 380.0;
/// Profile colours from first to last: blue to red, told apart in grey too.
const COLOURS: [&str; 6] = ["#9ecae1", "#6baed6", "#3182bd", "#fdae6b", "#e6550d", "#a63603"];

/// A plot area with linear axes.
struct Panel {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
    x: [f64; 2],
    y: [f64; 2],
}

impl Panel {
    fn at(&self, x: f64, y: f64) -> (f64, f64) {
        let share = |v: f64, range: [f64; 2]| (v - range[0]) / (range[1] - range[0]).max(1e-30);
        (
            self.left + (self.right - self.left) * share(x, self.x),
            self.bottom - (self.bottom - self.top) * share(y, self.y),
        )
    }

    fn line(&self, points: impl Iterator<Item = (f64, f64)>, style: &str) -> String {
        let mut path = String::new();
        for (x, y) in points {
            let (px, py) = self.at(x, y);
            let _ = write!(path, "{px:.1},{py:.1} ");
        }
        format!("<polyline points=\"{}\" fill=\"none\" {style}/>\n", path.trim_end())
    }

    /// Frame, ticks and titles; `right_axis` moves the numbers of y to the right-hand side.
    fn axes(&self, x_title: &str, y_title: &str, right_axis: bool) -> String {
        let mut out = String::new();
        if !right_axis {
            let _ = writeln!(
                out,
                "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"none\" stroke=\"#888\"/>",
                self.left,
                self.top,
                self.right - self.left,
                self.bottom - self.top
            );
            for tick in ticks(self.x) {
                let (px, _) = self.at(tick, self.y[0]);
                let _ = writeln!(
                    out,
                    "<text x=\"{px:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
                    self.bottom + 16.0,
                    label(tick)
                );
            }
            let middle = 0.5 * (self.left + self.right);
            let below = self.bottom + 34.0;
            let _ = writeln!(out, "<text x=\"{middle:.1}\" y=\"{below:.1}\" text-anchor=\"middle\">{x_title}</text>");
        }
        let (x, anchor) = if right_axis { (self.right + 6.0, "start") } else { (self.left - 6.0, "end") };
        for tick in ticks(self.y) {
            let (_, py) = self.at(self.x[0], tick);
            let _ = writeln!(
                out,
                "<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\">{}</text>",
                py + 4.0,
                label(tick)
            );
        }
        let (tx, ty) = (if right_axis { self.right + 50.0 } else { self.left - 40.0 }, 0.5 * (self.top + self.bottom));
        let _ = writeln!(
            out,
            "<text x=\"{tx:.1}\" y=\"{ty:.1}\" text-anchor=\"middle\" transform=\"rotate(-90 {tx:.1} {ty:.1})\">{y_title}</text>"
        );
        out
    }
}

/// Round numbers inside a range, about five of them.
fn ticks(range: [f64; 2]) -> Vec<f64> {
    let span = range[1] - range[0];
    if !(span > 0.0 && span.is_finite()) {
        return Vec::new();
    }
    let rough = span / 5.0;
    let power = 10.0_f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= rough).unwrap_or(rough);
    let first = (range[0] / step).ceil() as i64;
    let last = (range[1] / step).floor() as i64;
    (first..=last).map(|n| n as f64 * step).collect()
}

fn label(x: f64) -> String {
    let text = format!("{x:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.replace('-', "−") }
}

/// Escapes text for XML.
pub(crate) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// The picture of a run as SVG text.
pub fn picture(case: &Case, run: &Run) -> String {
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" \
         font-family=\"sans-serif\" font-size=\"12\" fill=\"#222\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    );
    let _ =
        writeln!(out, "<text x=\"24\" y=\"28\" font-size=\"16\" font-weight=\"bold\">{}</text>", escape(&case.title));
    let _ = writeln!(out, "<text x=\"24\" y=\"48\" font-size=\"13\">{}</text>", verdict(case, run));
    out += &profiles(case, run);
    out += &history(run);
    out += "</svg>\n";
    out
}

fn verdict(case: &Case, run: &Run) -> String {
    let word = run.outcome.word();
    let speed = residual_velocity(case, run).unwrap_or(0.0);
    match (run.outcome, run.stop_time) {
        (Outcome::Perforated | Outcome::Rebounded, _) => format!("{word}, {speed:.1} m/s left"),
        (Outcome::Stopped, Some(time)) => format!("{word} at {:.0} µs", time * 1e6),
        _ => format!("{word} at the end of the run"),
    }
}

fn profiles(case: &Case, run: &Run) -> String {
    let points = || run.profiles.iter().flat_map(|p| &p.points);
    let fold = |f: fn(f64, f64) -> f64, of: fn(&crate::profile::ProfilePoint) -> f64, from: f64| {
        points().map(of).fold(from, f)
    };
    let x = [fold(f64::min, |p| p.reference, 0.0) * 1e3, fold(f64::max, |p| p.reference, 0.0) * 1e3];
    let y = [fold(f64::min, |p| p.deflection, 0.0) * 1e3, fold(f64::max, |p| p.deflection, 0.0) * 1e3 * 1.08];
    let panel = Panel { left: 76.0, right: 470.0, top: 72.0, bottom: HEIGHT - 56.0, x, y };
    if x[1] <= x[0] || y[1] <= y[0] {
        return format!(
            "<text x=\"{}\" y=\"{}\" fill=\"#888\">no deflection profiles asked for (/output/profile_times_us)</text>\n",
            90, 200
        );
    }
    let along = if case.output.profile_along == Along::Warp { "warp" } else { "weft" };
    let mut out = panel.axes(&format!("position along the {along} [mm]"), "deflection [mm]", false);
    let last = run.profiles.len().saturating_sub(1).max(1);
    for (n, profile) in run.profiles.iter().enumerate() {
        let colour = COLOURS[n * (COLOURS.len() - 1) / last];
        let line = profile.points.iter().map(|p| (p.position * 1e3, p.deflection * 1e3));
        out += &panel.line(line, &format!("stroke=\"{colour}\" stroke-width=\"1.8\""));
        let y = panel.top + 18.0 + 15.0 * n as f64;
        if y < panel.bottom {
            let (x, time) = (panel.right - 8.0, profile.time * 1e6);
            let _ =
                writeln!(out, "<text x=\"{x}\" y=\"{y}\" text-anchor=\"end\" fill=\"{colour}\">{time:.0} µs</text>");
        }
    }
    out
}

fn history(run: &Run) -> String {
    let end = run.history.last().map_or(1.0, |s| s.time * 1e6).max(1e-6);
    let velocities = || run.history.iter().map(|s| s.projectile_velocity);
    // The first row's force is an impulse over one step, not a mean.
    let force = run.history.iter().skip(1).map(|s| s.contact_force).fold(1.0, f64::max);
    let panel = |y| Panel { left: 560.0, right: 880.0, top: 72.0, bottom: HEIGHT - 56.0, x: [0.0, end], y };
    let speed = panel([velocities().fold(0.0, f64::min), velocities().fold(1e-3, f64::max) * 1.05]);
    let load = panel([0.0, force * 1.05]);
    let forces = run.history.iter().skip(1).map(|s| (s.time * 1e6, s.contact_force));
    let mut out = load.line(forces, "stroke=\"#e6550d\" stroke-width=\"1\" stroke-opacity=\"0.6\"");
    let line = run.history.iter().map(|s| (s.time * 1e6, s.projectile_velocity));
    out += &speed.line(line, "stroke=\"#08519c\" stroke-width=\"2.2\"");
    out += &speed.axes("time [µs]", "<tspan fill=\"#08519c\">projectile velocity [m/s]</tspan>", false);
    out += &load.axes("", "<tspan fill=\"#e6550d\">contact force [N]</tspan>", true);
    out
}
