//! `shot.svg`: the shot at a glance, drawn from the run's own numbers.
//!
//! Left, deflection profiles through the point of impact; right, projectile velocity and contact force over time.

use super::chart::{self, ChartAxis};
use super::summary::residual_velocity;
use crate::case::{Case, Word};
use crate::run::Run;
use crate::run::outcome::Outcome;

const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 380.0;
/// Top and bottom of both plots.
const TOP: f64 = 72.0;
const BOTTOM: f64 = HEIGHT - 56.0;
/// Profile colours from first to last: blue to red, told apart in grey too.
const COLOURS: [&str; 6] = ["#9ecae1", "#6baed6", "#3182bd", "#fdae6b", "#e6550d", "#a63603"];

/// Frame and grid.
const STYLE: &str = ".grid { stroke: #222; stroke-opacity: 0.1; } .frame { fill: none; stroke: #888; } \
                     .speed { fill: #08519c; } .force { fill: #e6550d; }";

/// The picture of a run as SVG text.
pub fn picture(case: &Case, run: &Run) -> String {
    let mut out = chart::text(24.0, 28.0, "font-size=\"16\" font-weight=\"bold\"", &case.title);
    out += &chart::text(24.0, 48.0, "font-size=\"13\"", &verdict(case, run));
    out += &profiles(case, run);
    out += &history(run);
    chart::svg([WIDTH, HEIGHT], " fill=\"#222\"", STYLE, &out)
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
    let fold = |f: fn(f64, f64) -> f64, of: fn(&crate::run::profile::ProfilePoint) -> f64, from: f64| {
        points().map(of).fold(from, f)
    };
    let x = [fold(f64::min, |p| p.reference, 0.0) * 1e3, fold(f64::max, |p| p.reference, 0.0) * 1e3];
    let y = [fold(f64::min, |p| p.deflection, 0.0) * 1e3, fold(f64::max, |p| p.deflection, 0.0) * 1e3 * 1.08];
    if x[1] <= x[0] || y[1] <= y[0] {
        let hint = "no deflection profiles asked for (/output/profile_times_us)";
        return chart::text(90.0, 200.0, "fill=\"#888\"", hint);
    }
    let (x, y) = (ChartAxis::linear(x, [76.0, 470.0]), ChartAxis::linear(y, [BOTTOM, TOP]));
    let along = case.output.profile_along.word();
    let mut out = chart::axes(&x, &y, [&format!("position along the {along} [mm]"), "deflection [mm]"]);
    let last = run.profiles.len().saturating_sub(1).max(1);
    for (n, profile) in run.profiles.iter().enumerate() {
        let colour = COLOURS[n * (COLOURS.len() - 1) / last];
        let line = profile.points.iter().map(|p| [p.position * 1e3, p.deflection * 1e3]);
        out += &chart::line(&x, &y, line, &format!("stroke=\"{colour}\" stroke-width=\"1.8\""));
        let below = TOP + 18.0 + 15.0 * n as f64;
        if below < BOTTOM {
            let style = format!("text-anchor=\"end\" fill=\"{colour}\"");
            out += &chart::text(x.paper[1] - 8.0, below, &style, &format!("{:.0} µs", profile.time * 1e6));
        }
    }
    out
}

fn history(run: &Run) -> String {
    let end = run.history.last().map_or(1.0, |s| s.time * 1e6).max(1e-6);
    let velocities = || run.history.iter().map(|s| s.projectile_velocity);
    // The first row's force is an impulse over one step, not a mean.
    let force = run.history.iter().skip(1).map(|s| s.contact_force).fold(1.0, f64::max);
    let time = ChartAxis::linear([0.0, end], [560.0, 880.0]);
    let over = |range| ChartAxis::linear(range, [BOTTOM, TOP]);
    let speed = over([velocities().fold(0.0, f64::min), velocities().fold(1e-3, f64::max) * 1.05]);
    let load = over([0.0, force * 1.05]);
    let forces = run.history.iter().skip(1).map(|s| [s.time * 1e6, s.contact_force]);
    let mut out = chart::line(&time, &load, forces, "stroke=\"#e6550d\" stroke-width=\"1\" stroke-opacity=\"0.6\"");
    let line = run.history.iter().map(|s| [s.time * 1e6, s.projectile_velocity]);
    out += &chart::line(&time, &speed, line, "stroke=\"#08519c\" stroke-width=\"2.2\"");
    out += &chart::axes(&time, &speed, ["time [µs]", ""]);
    out += &chart::upright(520.0, 0.5 * (TOP + BOTTOM), "speed", "projectile velocity [m/s]");
    for tick in load.ticks() {
        out += &chart::text(time.paper[1] + 6.0, load.at(tick) + 4.0, "", &chart::label(tick));
    }
    out + &chart::upright(930.0, 0.5 * (TOP + BOTTOM), "force", "contact force [N]")
}
