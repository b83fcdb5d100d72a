//! Figures of a run: plots with their words, for the report and `shot.svg`.

use super::animation::{Animation, Keyframe};
use super::plot::{self, Figure, Plot};
use crate::case::{Case, Yarn};
use crate::model::unit_cell;
use crate::output::breakage::Breakage;
use crate::output::number::short;
use crate::output::summary::residual_velocity;
use crate::run::outcome::Outcome;
use crate::run::{DeflectionProfile, Run, Sample};

/// Deflection profiles at most.
const PROFILES: usize = 6;
/// Points of a curve of the unit cell.
const CELL_POINTS: usize = 120;
/// End of a curve whose yarn never breaks [-].
const NO_BREAK: f64 = 0.05;

/// A quantity of the history under its name.
type HistoryCurve = (&'static str, fn(&Sample) -> f64);
/// A line under its name.
type Line = (String, Vec<[f64; 2]>);

/// Plot of lines from the origin. `least`: the upper end of the vertical axis at least.
fn plot_of(least: f64, titles: [&str; 2], lines: &[Line]) -> Plot {
    let points = || lines.iter().flat_map(|(_, points)| points).filter(|p| p[0].is_finite() && p[1].is_finite());
    let end = points().map(|p| p[0]).fold(1e-6, f64::max);
    let range = [points().map(|p| p[1]).fold(0.0, f64::min), points().map(|p| p[1]).fold(least, f64::max)];
    let mut plot = Plot::new([0.0, end], range, titles);
    for (n, (name, points)) in lines.iter().enumerate() {
        plot.line(&format!("k{n}"), if lines.len() > 1 { name } else { "" }, points);
    }
    plot
}

/// Plot of lines over time [µs].
fn over_time(least: f64, title: &str, lines: &[Line]) -> Plot {
    let mut plot = plot_of(least, ["time [µs]", title], lines);
    plot.over_time = true;
    plot
}

/// A quantity of the history over time.
fn line(name: &str, rows: &[Sample], of: impl Fn(&Sample) -> f64) -> Line {
    (name.to_owned(), rows.iter().map(|row| [row.time * 1e6, of(row)]).collect())
}

/// Projectile velocity.
pub(crate) fn velocity(run: &Run) -> Figure {
    let of = |row: &Sample| row.projectile_velocity;
    let [first, last] = [run.history.first(), run.history.last()].map(|row| row.map_or(0.0, of));
    let caption = format!("From {} to {} m/s along the line of flight.", short(first, 4), short(last, 3));
    let plot = over_time(0.0, "velocity [m/s]", &[line("velocity", &run.history, of)]);
    Figure::new("velocity", "Projectile velocity", caption.replace('-', "−"), Some(plot))
}

/// Contact force.
pub(crate) fn force(run: &Run) -> Figure {
    let peak = run.history.iter().filter(|row| row.contact_force != 0.0);
    let peak = peak.max_by(|a, b| a.contact_force.total_cmp(&b.contact_force));
    let caption = peak.map_or("none.".to_owned(), |row| {
        let (force, time) = (short(row.contact_force, 3), short(row.time * 1e6, 3));
        format!("Of the fabric on the projectile, mean between rows of the history; at most {force} N, at {time} µs.")
    });
    let plot = peak.map(|_| over_time(0.0, "force [N]", &[line("force", &run.history, |row| row.contact_force)]));
    Figure::new("force", "Contact force", caption, plot)
}

/// Failures of yarns.
pub(crate) fn failures(case: &Case, run: &Run) -> Figure {
    let (mut caption, mut plot) = ("none.".to_owned(), None);
    if let Some(first) = run.events.first() {
        let broken = Breakage::of(case, run);
        let ([warp, weft], pieces) = (broken.yarns, broken.pieces());
        let time = short(first.step as f64 * run.time_step * 1e6, 3);
        caption = format!(
            "{warp} yarns of the warp and {weft} of the weft broke, in {pieces} places, which are counted here; the first at {time} µs."
        );
        let lines = ["warp", "weft"].into_iter().enumerate();
        let lines: Vec<Line> = lines.map(|(n, name)| line(name, &run.history, |row| row.failed[n] as f64)).collect();
        plot = Some(over_time(5.0, "failures [-]", &lines));
    }
    Figure::new("failures", "Failed yarns", caption, plot)
}

/// Deflection of the first and the last ply.
pub(crate) fn deflection(animation: &Animation) -> Option<Figure> {
    let mut plies = vec![0, animation.plies.len().checked_sub(1)?];
    plies.dedup();
    let at = |keyframe: &Keyframe, ply: usize| [keyframe.time * 1e6, 1e3 * keyframe.deflections[ply]];
    let points = |ply: usize| animation.keyframes.iter().map(|keyframe| at(keyframe, ply)).collect();
    let lines = plies.iter().map(|ply| (format!("ply {}", animation.plies[*ply].ply + 1), points(*ply)));
    let plot = over_time(0.0, "deflection [mm]", &lines.collect::<Vec<_>>());
    let caption = "Of fabric that an edge holds; debris does not count.".to_owned();
    Some(Figure::new("deflection", "Deflection", caption, Some(plot)))
}

/// Energies and their sum.
pub(crate) fn energy(run: &Run) -> Figure {
    let curves: [HistoryCurve; 10] = [
        ("projectile", |row| row.balance.projectile),
        ("fabric, kinetic", |row| row.balance.kinetic),
        ("fabric, internal", |row| row.balance.internal),
        ("yarn failure", |row| row.balance.failure),
        ("friction", |row| row.balance.friction),
        ("contact", |row| row.balance.contact),
        ("hourglass", |row| row.balance.hourglass),
        ("viscous forces", |row| row.balance.viscous),
        ("clay", |row| row.balance.backing),
        ("ply separation", |row| -row.balance.separation),
    ];
    let curves: Vec<_> = curves.iter().filter(|(_, of)| run.history.iter().any(|row| of(row) != 0.0)).collect();
    let sum = |row: &Sample| curves.iter().map(|(_, of)| of(row)).sum::<f64>();
    let top = run.history.iter().map(sum).filter(|x| x.is_finite()).fold(0.0, f64::max);
    let lines: Vec<Line> = curves.iter().map(|(name, of)| line(name, &run.history, of)).collect();
    let mut plot = over_time(top, "energy [J]", &lines);
    plot.line("ink", "sum", &line("", &run.history, sum).1);
    let caption = "A level sum means that energy is conserved.";
    Figure::new("energy", "Where the energy is", caption, Some(plot))
}

/// Deflection profiles that the case asks for.
pub(crate) fn profiles(case: &Case, run: &Run) -> Option<Figure> {
    let (count, shown) = (run.profiles.len(), run.profiles.len().min(PROFILES));
    let chosen = (1..=shown).map(|n| &run.profiles[n * count / shown - 1]);
    let line = |profile: &DeflectionProfile| -> Line {
        let points = profile.points.iter().map(|p| [p.position * 1e3, p.deflection * 1e3]).collect();
        (format!("{} µs", short(profile.time * 1e6, 3)), points)
    };
    let lines: Vec<Line> = chosen.map(line).collect();
    let points = || lines.iter().flat_map(|(_, points)| points).filter(|p| p[0].is_finite() && p[1].is_finite());
    let range = |a: usize| points().fold([0.0_f64; 2], |[low, high], p| [low.min(p[a]), high.max(p[a])]);
    let along = case.output.profile_along.word();
    let title = format!("position along the {along} [mm]");
    let mut plot = Plot::new(range(0), range(1), [&title, "deflection [mm]"]);
    for (n, (time, points)) in lines.iter().enumerate() {
        plot.line(&format!("t{n}"), time, points);
    }
    let caption =
        format!("The struck ply along the {along} through the point of impact, from faint to strong in time.");
    (count > 0).then(|| Figure::new("profile", "Deflection profile", caption, Some(plot)))
}

/// Tension over stretch of the first fabric's unit cell: one yarn pulled while the other keeps its length, and both alike, up to the break.
pub(crate) fn unit_cell(case: &Case) -> Figure {
    let layers = case.layers();
    let fabric = &layers[0].fabric;
    let yarns = [&fabric.warp, &fabric.weft];
    let strain = |yarn: &Yarn| yarn.breaking_strain().unwrap_or(NO_BREAK);
    let pulls =
        [("warp, weft held", [true, false]), ("weft, warp held", [false, true]), ("warp, both pulled", [true; 2])];
    let lines =
        pulls.into_iter().filter(|(_, pulled)| yarns.iter().zip(pulled).all(|(yarn, pulled)| yarn.present || !pulled));
    let lines: Vec<Line> = lines
        .map(|(name, pulled)| {
            let a = usize::from(!pulled[0]);
            let end = (1.0 + yarns[a].crimp) * (1.0 + strain(yarns[a]));
            let stretches = (0..=CELL_POINTS).map(|n| 1.0 + (end - 1.0) * n as f64 / CELL_POINTS as f64);
            let points = stretches.flat_map(|pull| {
                let [warp, weft] = pulled.map(|pulled| if pulled { pull } else { 1.0 });
                unit_cell::solve(fabric, &[warp], &[weft])
            });
            let unbroken = points.take_while(|point| (0..2).all(|b| point.cell.strain[b] <= strain(yarns[b])));
            (name.to_owned(), unbroken.map(|point| [100.0 * (point.stretch[a] - 1.0), point.cell.tension[a]]).collect())
        })
        .collect();
    let plot = plot_of(0.0, ["stretch [%]", "tension of a yarn [N]"], &lines);
    let caption = format!("{}: the law that every element follows, from rest to the break.", fabric.name);
    Figure::new("unit-cell", "Unit cell", caption, Some(plot))
}

/// `shot.svg`: the shot at a glance.
pub(crate) fn shot(case: &Case, run: &Run) -> String {
    let (word, speed) = (run.outcome.word(), residual_velocity(case, run).unwrap_or(0.0));
    let verdict = match (run.outcome, run.stop_time) {
        (Outcome::Perforated | Outcome::Rebounded, _) => format!("{word}, {speed:.1} m/s left"),
        (Outcome::Stopped, Some(time)) => format!("{word} at {:.0} µs", time * 1e6),
        _ => format!("{word} at the end of the run"),
    };
    let figures = [profiles(case, run), Some(velocity(run)), Some(force(run))];
    let plots: Vec<Plot> = figures.into_iter().flatten().filter_map(|figure| figure.plot).collect();
    plot::file(&case.title, &verdict, &plots)
}
