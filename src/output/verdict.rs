//! Verdict of a run, in one line.

use super::checks;
use super::number::{short, us};
use super::summary::{flies_freely, residual_velocity};
use crate::case::Case;
use crate::physics::mirror_planes::MirrorPlanes;
use crate::run::Run;
use crate::run::outcome::Outcome;
use crate::solver::Divergence;

/// The verdict of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Verdict {
    /// Verdict in a word or two.
    pub word: &'static str,
    /// Velocities, deflection, time.
    pub detail: String,
    /// Whether the run came to its end; else the verdict is as far as it got.
    pub complete: bool,
}

impl Verdict {
    /// Mark between word and detail.
    pub fn mark(&self) -> &'static str {
        if self.detail.starts_with("at ") { "" } else { ":" }
    }
}

/// Verdict of a run: first that it broke off, if it did.
pub fn verdict(case: &Case, run: &Run) -> Verdict {
    if let Some(trouble) = &run.divergence {
        return broken_off("unstable", format!("at {}: {}", place(trouble), trouble.quantity));
    }
    let deflection = run.deflection() * 1e3;
    let deflected = format!("deflected {} mm at most", short(deflection, 4));
    if let Some(reason) = &run.lost {
        return broken_off("device lost", format!("at {}, {deflected}: {reason}", reached(run)));
    }
    if run.interrupted {
        return broken_off("interrupted", format!("at {}, {deflected}", reached(run)));
    }
    if !flies_freely(case) {
        return ended("done", format!("{} computed, {deflected}", reached(run)));
    }
    let velocity = residual_velocity(case, run).unwrap_or(0.0);
    let stop = run.stop_time.map_or(String::new(), |time| format!("at {:.1} µs, ", time * 1e6));
    let struck = case.projectile.as_ref().map_or(0.0, |p| p.velocity);
    let through = run.history.last().map_or(0, |row| row.perforated_plies);
    let torn = if run.plies > 1 { format!("{through} of {} plies perforated, ", run.plies) } else { String::new() };
    let struck = format!("{torn}struck at {} m/s", short(struck, 4));
    let velocity = short(velocity, 4);
    match run.outcome {
        Outcome::Perforated => {
            let left = residual_velocity(case, run).unwrap_or(0.0);
            let leaves = match checks::scatter(case, run) {
                Some(scatter) => format!("{} m/s ± {} by the mesh", short(left, 3), short(scatter, 2)),
                None => format!("{velocity} m/s"),
            };
            let past = if run.is_unbroken() { ", past fabric of which no yarn broke" } else { "" };
            ended("perforated", format!("leaves at {leaves}{past}, {struck}"))
        }
        Outcome::Stopped => {
            let carried = run.carried_velocity.map(|speed| format!("carried along at {} m/s, ", short(speed, 3)));
            ended("stopped", format!("{stop}{}{struck}, {deflected}", carried.unwrap_or_default()))
        }
        Outcome::Rebounded => {
            let flies = match run.rebound_velocity {
                Some(rebound) => format!("flies back at {} m/s", short(rebound, 4)),
                None => format!("flies at {velocity} m/s"),
            };
            ended("rebounded", format!("turned {stop}{flies}, {struck}, {deflected}"))
        }
        Outcome::Running => ended(
            "undecided",
            format!(
                "at {}: {velocity} m/s left, {struck}, {deflected}; raise /solver/end_time_us for a verdict",
                reached(run)
            ),
        ),
    }
}

fn ended(word: &'static str, detail: String) -> Verdict {
    Verdict { word, detail, complete: true }
}

fn broken_off(word: &'static str, detail: String) -> Verdict {
    Verdict { word, detail, complete: false }
}

/// Time reached.
pub fn reached(run: &Run) -> String {
    us(run.history.last().map_or(0.0, |row| row.time))
}

/// Place where a run went wrong.
pub fn place(trouble: &Divergence) -> String {
    let [ply, row, column] = trouble.place;
    format!("step {}, kernel {}, ply {ply}, row {row}, column {column}", trouble.step, trouble.kernel)
}

/// Mirror planes that a scene is cut at, if it is.
pub fn symmetry(planes: MirrorPlanes) -> String {
    let names = planes.names();
    let part = match names.len() {
        0 => return "none: the whole scene is computed".to_owned(),
        1 => "a half",
        _ => "a quarter",
    };
    format!("{part}, mirrored at {} = 0", names.join(" = 0 and "))
}
