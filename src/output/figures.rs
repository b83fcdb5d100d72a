//! Figures of a run: plots with their words, for the report and `shot.svg`, and the plan of its pack.

use super::animation::{Animation, Keyframe};
use super::breakage::Breakage;
use super::csv::HistoryColumn;
use super::number::short;
use super::plot::{self, Figure, Plot};
use super::summary::{peak_force, residual_velocity};
use crate::case::{Case, Edge, Edges, Layer, Opening, Shape, Yarn};
use crate::model::unit_cell;
use crate::run::outcome::Outcome;
use crate::run::{DeflectionProfile, Run, Sample};

/// Deflection profiles at most.
const PROFILES: usize = 6;
/// Points of a curve of the unit cell.
const CELL_POINTS: usize = 120;
/// End of a curve whose yarn never breaks [-].
const NO_BREAK: f64 = 0.05;

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
    let peak = peak_force(run);
    let plot =
        peak.as_ref().map(|_| over_time(0.0, "force [N]", &[line("force", &run.history, |row| row.contact_force)]));
    let caption = peak.map_or("none.".to_owned(), |[force, time]| {
        format!("Of the fabric on the projectile, mean between rows of the history; at most {force}, at {time}.")
    });
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
    let curves: [HistoryColumn; 10] = [
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

/// Clamps and free sides of every ply, in words.
pub fn held(case: &Case) -> String {
    let layers = case.layers();
    let hold = |layer: &Layer| (layer.edges, layer.mesh.frame.opening);
    let alike = layers.windows(2).all(|pair| hold(&pair[0]) == hold(&pair[1]));
    let of_layer = |(index, layer): (usize, &Layer)| {
        let sides = of_sides(&layer.edges);
        let sides = match case.pack.window {
            Some(window) => format!("all outside a round window of {} mm", short(window.diameter * 1e3, 4)),
            None if layer.mesh.frame.corner > 0.0 => {
                format!("{sides}; {} mm at each corner clamped", short(layer.mesh.frame.corner * 1e3, 4))
            }
            None => sides,
        };
        let turned = if layer.mesh.frame.opening == Opening::Rectangle { ", cut to the frame" } else { "" };
        if alike { sides + turned } else { format!("/pack/layup/{index}: {sides}{turned}") }
    };
    let mut words: Vec<String> = layers.iter().enumerate().map(of_layer).collect();
    words.dedup();
    words.join("; ")
}

/// Backing of the pack, in words.
pub fn behind(case: &Case) -> String {
    let Some(clay) = case.backing else { return "nothing".to_owned() };
    let gap = if clay.gap > 0.0 { format!("{} mm of air, then ", short(clay.gap * 1e3, 4)) } else { String::new() };
    let deeper = clay.doubling_depth.map(|depth| format!(", twice that {} mm deep", short(depth * 1e3, 4)));
    format!("{gap}clay that resists with {} MPa{}", short(clay.pressure * 1e-6, 3), deeper.unwrap_or_default())
}

/// Sides by what holds them.
fn of_sides(edges: &Edges) -> String {
    let sides = [("left", edges.left), ("right", edges.right), ("bottom", edges.bottom), ("top", edges.top)];
    let of = |edge: Edge| {
        let names: Vec<&str> = sides.iter().filter(|(_, own)| *own == edge).map(|(name, _)| *name).collect();
        let names = if names.len() == sides.len() { "all sides".to_owned() } else { names.join(", ") };
        (!names.is_empty())
            .then(|| format!("{names} {}", if edge == Edge::Roller { "on rollers" } else { edge.word() }))
    };
    [Edge::Clamped, Edge::Roller, Edge::Free].into_iter().filter_map(of).collect::<Vec<_>>().join("; ")
}

/// Width of the drawing, and its margin.
const PAPER: [f64; 2] = [440.0, 12.0];

/// Corners of a rectangle of these half sizes, turned by the angle of this cosine and sine: left bottom, right bottom, right top, left top.
fn rectangle([a, b]: [f64; 2], [c, s]: [f64; 2]) -> [[f64; 2]; 4] {
    [[-a, -b], [a, -b], [a, b], [-a, b]].map(|[x, y]| [c * x - s * y, s * x + c * y])
}

/// The plan as SVG, Y upwards; classes as of the page.
pub(crate) fn drawing(case: &Case) -> String {
    let (pack, layers) = (&case.pack, case.layers());
    let sizes = case.projectile.as_ref().map(|p| (p.offset, 0.5 * p.shape.diameter()));
    let aimed = sizes.map_or(0.0, |([x, y], radius)| x.abs().max(y.abs()) + radius);
    let [width, height] = pack.size();
    let half = (0.5 * width.max(height)).max(aimed);
    let [paper, margin] = PAPER;
    let scale = (0.5 * paper - margin) / half;
    let tall = 2.0 * (0.5 * height).max(aimed) * scale + 2.0 * margin;
    let at = |[x, y]: [f64; 2]| [0.5 * paper + scale * x, 0.5 * tall - scale * y];
    let points = |corners: &[[f64; 2]]| {
        corners.iter().map(|corner| at(*corner).map(|x| format!("{x:.1}")).join(",")).collect::<Vec<_>>().join(" ")
    };
    let mut out = format!("<svg viewBox=\"0 0 {paper} {tall:.1}\" role=\"img\" aria-label=\"{}\">", held(case));
    let whole = points(&rectangle([0.5 * width, 0.5 * height], [1.0, 0.0]));
    let held = if pack.window.is_some() { "clamp" } else { "cloth" };
    out += &format!("<polygon class=\"{held}\" points=\"{whole}\"/>");
    if let Some(window) = pack.window {
        let ([x, y], radius) = (at([0.0; 2]), 0.5 * window.diameter * scale);
        out += &format!("<circle class=\"cloth\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\"/>");
    }
    for layer in layers.iter() {
        out += &sides(layer, &points);
        let (s, c) = layer.orientation.sin_cos();
        let length = 0.3 * width.min(height);
        out += &format!(
            "<polyline class=\"warp\" points=\"{}\"/>",
            points(&[[-c * length, -s * length], [c * length, s * length]])
        );
    }
    if let (Some(([x, y], radius)), Some(projectile)) = (sizes, &case.projectile) {
        out += &match projectile.shape {
            Shape::Bar { along, .. } => {
                let mut half = [radius; 2];
                half[along as usize] = 0.5 * [width, height][along as usize];
                format!(
                    "<polygon class=\"aim\" points=\"{}\"/>",
                    points(&rectangle(half, [1.0, 0.0]).map(|[a, b]| [a + x, b + y]))
                )
            }
            _ => {
                let [cx, cy] = at([x, y]);
                format!("<circle class=\"aim\" cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"{:.1}\"/>", (radius * scale).max(1.0))
            }
        };
    }
    out + "</svg>"
}

/// Sides and corner clamps of a ply.
fn sides(layer: &Layer, points: &impl Fn(&[[f64; 2]]) -> String) -> String {
    let frame = &layer.mesh.frame;
    if frame.opening == Opening::Round {
        return String::new();
    }
    let (s, c) = layer.orientation.sin_cos();
    let corners = match frame.opening {
        Opening::Mesh => rectangle([0, 1].map(|a| 0.5 * layer.mesh.count[a] as f64 * layer.mesh.length[a]), [c, s]),
        _ => rectangle(frame.half, [1.0, 0.0]),
    };
    let Edges { left, right, bottom, top } = layer.edges;
    let of = [(0, 3, left), (1, 2, right), (0, 1, bottom), (3, 2, top)];
    let lines = of.map(|(from, to, edge)| {
        format!("<polyline class=\"{}\" points=\"{}\"/>", edge.word(), points(&[corners[from], corners[to]]))
    });
    let clamps = corners.map(|[x, y]| {
        let inner = [x - frame.corner.copysign(x), y - frame.corner.copysign(y)];
        format!("<polygon class=\"clamp\" points=\"{}\"/>", points(&[[x, y], [inner[0], y], inner, [x, inner[1]]]))
    });
    lines.into_iter().chain(clamps.into_iter().filter(|_| frame.corner > 0.0)).collect()
}
