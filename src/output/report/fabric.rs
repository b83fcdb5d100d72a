//! Figures of the fabric: deflection profiles, and the response of its unit cell.

use super::super::chart;
use super::super::number::short;
use super::animated_ply::AnimatedPly;
use super::animation::{Animation, Keyframe};
use super::figure::{self, Figure, FigureNumbers};
use crate::case::{Along, Case, Fabric, Word};
use crate::model::unit_cell_curve;
use crate::run::Run;

/// Profiles drawn at most.
const PROFILES: usize = 6;
/// Points of the unit-cell curve.
const POINTS: usize = 121;
/// Stretch up to which a cell is drawn whose yarns do not break [-].
const FAR: f64 = 1.1;

/// A line of nodes at one time: position and deflection [mm].
struct NodeLine {
    /// [µs]
    time: f64,
    points: Vec<[f64; 2]>,
}

/// Deflection profiles: those the case asks for, else some of the animation's.
pub(super) fn profiles(case: &Case, run: &Run, animation: Option<&Animation>) -> Option<Figure> {
    let (lines, along) = if run.profiles.is_empty() {
        (of_film(animation?), Along::Warp)
    } else {
        (of_run(run), case.output.profile_along)
    };
    let points = || lines.iter().flat_map(|line| &line.points).filter(|p| p[0].is_finite() && p[1].is_finite());
    let x = points().fold([0.0_f64; 2], |[low, high], p| [low.min(p[0]), high.max(p[0])]);
    let y = points().fold([0.0_f64; 2], |[low, high], p| [low.min(p[1]), high.max(p[1])]);
    let [x, y] = figure::axes(x, y);
    let along = along.word();
    let mut drawing = chart::axes(&x, &y, [&format!("position along the {along} [mm]"), "deflection [mm]"]);
    let mut legend = Vec::new();
    let mut rows = Vec::new();
    for (n, line) in lines.iter().enumerate() {
        let time = short(line.time, 3);
        drawing += &chart::line(&x, &y, line.points.iter().copied(), &format!("class=\"curve t{n}\""));
        legend.push((format!("line t{n}"), format!("{time} µs")));
        rows.extend(line.points.iter().map(|p| vec![time.clone(), short(p[0], 4), short(p[1], 4)]));
    }
    Some(Figure {
        id: "profile",
        title: "Deflection profile".to_owned(),
        caption: format!("The struck ply along the {along} through the point of impact, from light to dark in time."),
        drawing,
        legend,
        axes: Some([x, y]),
        numbers: FigureNumbers {
            heads: ["time [µs]", "position [mm]", "deflection [mm]"].map(str::to_owned).to_vec(),
            rows,
            file: "profiles.csv",
        },
        ..Figure::default()
    })
}

/// Deflection of the first and the last ply over time.
pub(super) fn deflection(animation: &Animation) -> Option<Figure> {
    let last = animation.strips.len().checked_sub(1)?;
    let strips: Vec<usize> = if last == 0 { vec![0] } else { vec![0, last] };
    let end = animation.keyframes.last()?.time * 1e6;
    let axes = figure::axes([0.0, end], [0.0, 1e3 * animation.deflection()]);
    let name = |strip: usize| format!("ply {}", animation.strips[strip].ply + 1);
    let at = |keyframe: &Keyframe, strip: usize| 1e3 * keyframe.deflections[strip];
    let points = |strip: usize| animation.keyframes.iter().map(|k| [k.time * 1e6, at(k, strip)]).collect();
    let lines = strips.iter().map(|strip| (name(*strip), points(*strip)));
    let (drawing, mut legend) = figure::lines(axes, ["time [µs]", "deflection [mm]"], lines);
    let row = |keyframe: &Keyframe| {
        let deflections = strips.iter().map(|strip| short(at(keyframe, *strip), 4));
        std::iter::once(short(keyframe.time * 1e6, 4)).chain(deflections).collect()
    };
    let heads = strips.iter().map(|strip| format!("{} [mm]", name(*strip)));
    if last == 0 {
        legend.clear();
    }
    Some(Figure {
        id: "deflection",
        title: "Deflection".to_owned(),
        caption: "Of fabric that hangs on an edge; debris does not count.".to_owned(),
        drawing,
        legend,
        axes: Some(axes),
        over_time: true,
        numbers: FigureNumbers::over_time(heads, animation.keyframes.iter().map(row).collect(), "history.csv"),
    })
}

/// At most so many of a number of things, evenly, the last one among them.
fn some(count: usize, most: usize) -> Vec<usize> {
    let shown = count.min(most);
    (1..=shown).map(|n| n * count / shown - 1).collect()
}

fn of_run(run: &Run) -> Vec<NodeLine> {
    let line = |at: usize| {
        let profile = &run.profiles[at];
        let points = profile.points.iter().map(|p| [p.position * 1e3, p.deflection * 1e3]).collect();
        NodeLine { time: profile.time * 1e6, points }
    };
    some(run.profiles.len(), PROFILES).into_iter().map(line).collect()
}

/// The row of nodes of the struck ply through the point of impact, and its mirror image where half of it is kept.
fn of_film(animation: &Animation) -> Vec<NodeLine> {
    let Some(strip) = animation.strips.first() else { return Vec::new() };
    let line = |at: usize| {
        let keyframe = &animation.keyframes[at];
        let points = row(strip, keyframe);
        let mirrored = (0..2).any(|axis| animation.planes.0[axis] && runs_along(strip, axis));
        let images = points.iter().filter(|p| mirrored && p[0] != 0.0).map(|p| [-p[0], p[1]]);
        let mut all: Vec<[f64; 2]> = points.iter().copied().chain(images).collect();
        all.sort_by(|a, b| a[0].total_cmp(&b[0]));
        NodeLine { time: keyframe.time * 1e6, points: all }
    };
    some(animation.keyframes.len(), PROFILES).into_iter().map(line).collect()
}

/// Whether the rows of a strip run along this axis of the pack.
fn runs_along(strip: &AnimatedPly, axis: usize) -> bool {
    let [from, to] = [strip.reference[0], strip.reference[strip.counts()[0]]];
    (to[axis] - from[axis]).abs() > (to[1 - axis] - from[1 - axis]).abs()
}

fn row(strip: &AnimatedPly, keyframe: &Keyframe) -> Vec<[f64; 2]> {
    let length = strip.lines[0].len();
    let nodes = strip.hit[1] * length..(strip.hit[1] + 1) * length;
    let origin = strip.reference[strip.hit[1] * length + strip.hit[0]];
    let [from, to] = [strip.reference[nodes.start], strip.reference[nodes.end - 1]];
    let step = [0, 1].map(|a| f64::from(to[a] - from[a]));
    let size = step[0].hypot(step[1]);
    nodes
        .map(|node| {
            let (at, moved) = (strip.reference[node], keyframe.displacement[node]);
            let across = |a: usize| f64::from(at[a] + moved[a] - origin[a]) * step[a] / size;
            [1e3 * (across(0) + across(1)), 1e3 * f64::from(moved[2])]
        })
        .collect()
}

/// Tensions of both yarns while the unit cell of the struck ply is stretched along one: the paper's Figure 4.
pub(super) fn unit_cell(case: &Case) -> Option<Figure> {
    let layers = case.layers();
    let fabric = &layers.first()?.fabric;
    let curve = stretched(fabric)?;
    let stiff = if fabric.warp.present { 0 } else { 1 };
    let [along, across] = if stiff == 0 { ["warp", "weft"] } else { ["weft", "warp"] };
    let span = 2e3 * [&fabric.warp, &fabric.weft][stiff].half_span();
    let at = |point: &unit_cell_curve::CurvePoint| (point.stretch[stiff] - 1.0) * span;
    let top = curve.iter().flat_map(|point| point.cell.tension).fold(0.0, f64::max);
    let axes = figure::axes([0.0, curve.iter().map(at).fold(0.0, f64::max)], [0.0, top]);
    let points = |yarn: usize| curve.iter().map(|point| [at(point), point.cell.tension[yarn]]).collect();
    let lines = [("warp", 0), ("weft", 1)].map(|(name, yarn)| (name.to_owned(), points(yarn)));
    let titles = [&format!("extension of a cell along the {along} [mm]"), "yarn tension [N]"];
    let (drawing, legend) = figure::lines(axes, titles, lines);
    let row = |point: &unit_cell_curve::CurvePoint| {
        let [warp, weft] = point.cell.tension;
        [at(point), point.stretch[stiff], warp, weft, point.cell.force].map(|number| short(number, 4)).to_vec()
    };
    let heads = ["extension [mm]", "stretch [-]", "warp [N]", "weft [N]", "contact [N]"];
    Some(Figure {
        id: "unit-cell",
        title: "One crossing of two yarns, pulled".to_owned(),
        caption: format!(
            "The unit cell of {}: stretched along the {along}, held along the {across}, up to the failure of a yarn or a \
             stretch of {FAR}; as Figure 4 of Shahkarami & Vaziri (2006) shows it.",
            fabric.name
        ),
        drawing,
        legend,
        axes: Some(axes),
        numbers: FigureNumbers {
            heads: heads.map(str::to_owned).to_vec(),
            rows: curve.iter().map(row).collect(),
            file: "ripstop crossover",
        },
        ..Figure::default()
    })
}

/// The cell from rest to the point where a yarn breaks.
fn stretched(fabric: &Fabric) -> Option<Vec<unit_cell_curve::CurvePoint>> {
    let yarn = [&fabric.warp, &fabric.weft].into_iter().find(|yarn| yarn.present)?;
    let far = ((1.0 + yarn.crimp) * (1.0 + yarn.failure_strain)).min(FAR);
    let stretches: Vec<f64> = (0..POINTS).map(|n| 1.0 + (far - 1.0) * n as f64 / (POINTS - 1) as f64).collect();
    let held = [1.0];
    let mut curve = if fabric.warp.present {
        unit_cell_curve::solve(fabric, &stretches, &held)
    } else {
        unit_cell_curve::solve(fabric, &held, &stretches)
    };
    let broken = curve.iter().position(|point| (0..2).any(|yarn| point.is_broken(fabric, yarn)));
    curve.truncate(broken.unwrap_or(POINTS).max(2));
    Some(curve)
}

#[cfg(test)]
#[path = "fabric_tests.rs"]
mod tests;
