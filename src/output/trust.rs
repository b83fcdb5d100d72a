//! Whether a run is to be trusted: each sign with its number, what it is held against, and what that means. A sign to be looked
//! at is one that [`warnings`] speak of, or one that they do not count.

use super::breakage::Breakage;
use super::number::{fraction, grouped, short};
use super::summary::residual_velocity;
use super::verdict::verdict;
use crate::case::{Case, ContactSampling, Motion, Numerics, Shape};
use crate::kernels::projectile_shape::Body;
use crate::output::warnings::{
    self, CELLS_LIMIT, CROSSOVERS_LIMIT, ENERGY_LIMIT, GAINED_LIMIT, HOURGLASS_LIMIT, PENETRATION_LIMIT,
    PLY_PENETRATION_LIMIT,
};
use crate::run::Run;
use crate::run::outcome::Outcome;
use crate::solver::energy_balance::Balance;

/// Errors of energy and momentum that change no figure of a result [-].
const NEGLIGIBLE: f64 = 1e-4;
/// Energy from nowhere above which a result is not to be used, over what was put in or what the fabric holds [-].
const UNUSABLE: f64 = 0.1;
/// Share of unit cells without equilibrium that no longer is a matter of a few places [-].
const UNCONVERGED_LIMIT: f64 = 1e-6;
/// Energy that the law itself makes or loses, over what was put in, that is to be looked at [-].
const LAW_LIMIT: f64 = 0.05;

/// How a sign is to be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// As it should be.
    Fine,
    /// To be looked at before the result is used.
    Look,
    /// The result is not to be used.
    Bad,
}

impl Level {
    /// One word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Fine => "fine",
            Self::Look => "look",
            Self::Bad => "bad",
        }
    }

    /// What to do with a result whose worst sign is of this level.
    pub fn advice(self) -> &'static str {
        match self {
            Self::Fine => "trust",
            Self::Look => "look",
            Self::Bad => "do not use",
        }
    }
}

/// One sign.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct QualityCheck {
    /// What it is about.
    pub name: &'static str,
    /// The number found.
    pub value: String,
    /// How to read it.
    pub level: Level,
    /// Why.
    pub reason: String,
}

/// Every sign of a run, the same ones in the same order for alike cases.
pub fn signs(case: &Case, run: &Run) -> Vec<QualityCheck> {
    let mut all = vec![end(case, run), gained(run), stored(run), energy(run), momentum(run), hourglass(run)];
    if case.projectile.is_some() {
        all.push(penetration(run, warnings::longest_diagonal(case)));
        all.extend(warnings::cells_across(case).map(width));
        all.push(mesh_under_hit(case, run));
        all.push(frame(case, run));
    }
    if run.plies > 1 {
        all.push(ply_penetration(case, run));
    }
    all.extend([newton(run), law(run)]);
    all.extend((run.plies > 1).then(|| separation(run)));
    all.push(mesh(case));
    all
}

/// The worst of the signs.
pub fn worst(signs: &[QualityCheck]) -> Level {
    signs.iter().map(|sign| sign.level).max().unwrap_or(Level::Fine)
}

/// A number against two limits: above the first it is to be looked at, above the second (or no number) it is bad.
fn level(value: f64, [look, bad]: [f64; 2]) -> Level {
    match value {
        value if value <= look => Level::Fine,
        value if value <= bad => Level::Look,
        _ => Level::Bad,
    }
}

impl QualityCheck {
    /// A share against two limits, and what it means by level.
    fn of_share(name: &'static str, share: f64, limits: [f64; 2], reasons: [&str; 3]) -> Self {
        let level = level(share.abs(), limits);
        Self { name, value: fraction(share), level, reason: by_level(level, reasons) }
    }
}

/// Text by level.
fn by_level<T: Into<String>>(level: Level, [fine, look, bad]: [T; 3]) -> String {
    match level {
        Level::Fine => fine,
        Level::Look => look,
        Level::Bad => bad,
    }
    .into()
}

fn end(case: &Case, run: &Run) -> QualityCheck {
    let verdict = verdict(case, run);
    let (level, reason) = match (&run.divergence, verdict.complete) {
        (Some(_), _) => (Level::Bad, "the numbers went out of hand; what came before is not to be used"),
        (None, false) => (Level::Bad, "the run was broken off; what is shown ends there"),
        (None, true) => (Level::Fine, "the run came to its end"),
    };
    let value = if verdict.complete { "complete" } else { verdict.word };
    QualityCheck { name: "end of the run", value: value.to_owned(), level, reason: reason.to_owned() }
}

fn energy(run: &Run) -> QualityCheck {
    let reasons = [
        "next to nothing: assembly, contact and failure close; it closes by construction and does not see the step",
        "more than 0.01 %, within the 2 % practitioners accept",
        "above the 2 % practitioners accept: energy was made or lost",
    ];
    QualityCheck::of_share("work balance", run.energy_error, [NEGLIGIBLE, ENERGY_LIMIT], reasons)
}

fn gained(run: &Run) -> QualityCheck {
    let reasons = [
        "by state functions, the shares of law and ply separation apart: the step neither made nor lost energy that counts",
        "by state functions: the step made or lost energy; compare with a lower Courant number",
        "by state functions: the step made or lost so much energy that the result is not to be used",
    ];
    QualityCheck::of_share("energy gained", run.energy_gained, [GAINED_LIMIT, 5.0 * GAINED_LIMIT], reasons)
}

/// The fabric's elastic energy must lie between nothing and what there was to take it from.
fn stored(run: &Run) -> QualityCheck {
    let first = run.history.first().map(|row| row.balance).unwrap_or_default();
    let made = |row: &Balance| row.external.max(0.0) + row.law.max(0.0) + row.separation.max(0.0);
    let most = |row: &Balance| first.projectile + first.kinetic + first.internal.max(0.0) + made(row);
    let peak = run.history.iter().map(|row| most(&row.balance)).fold(0.0, f64::max);
    let slack = GAINED_LIMIT * peak;
    let is_low = |row: &Balance| row.internal < -slack - row.law.abs();
    let is_high = |row: &Balance| row.internal > most(row) + slack;
    let all = || run.history.iter().map(|row| &row.balance);
    let (level, reason) = if all().any(|row| !row.internal.is_finite()) {
        (Level::Bad, "not a number")
    } else if all().any(is_low) {
        (Level::Bad, "below zero: the fabric gave back energy that it never had")
    } else if all().any(is_high) {
        (Level::Bad, "more than there was to take it from: the arithmetic made energy")
    } else {
        (Level::Fine, "never below zero, never more than there was to take it from")
    };
    let last = run.history.last().map_or(0.0, |row| row.balance.internal);
    QualityCheck { name: "elastic energy", value: format!("{} J", short(last, 3)), level, reason: reason.to_owned() }
}

fn momentum(run: &Run) -> QualityCheck {
    let reasons =
        ["next to nothing: contact and supports balance", "more than 0.01 %", "above 2 %: forces do not balance"];
    QualityCheck::of_share("momentum error", run.momentum_error, [NEGLIGIBLE, ENERGY_LIMIT], reasons)
}

fn hourglass(run: &Run) -> QualityCheck {
    let reasons = [
        "below 5 %: the elements' artificial stiffness carried next to nothing",
        "above the 5 % practitioners accept: the fabric was stiffer than asked for",
        "above 10 %: the artificial stiffness carried the load",
    ];
    QualityCheck::of_share("hourglass / internal energy", run.hourglass_fraction, [HOURGLASS_LIMIT, UNUSABLE], reasons)
}

fn penetration(run: &Run, diagonal: f64) -> QualityCheck {
    let level = level(run.max_penetration, [PENETRATION_LIMIT * diagonal, 2.0 * diagonal]);
    let half = short(PENETRATION_LIMIT * 1e3 * diagonal, 2);
    let reason = match level {
        Level::Fine => format!("below half an element's diagonal ({half} mm)"),
        Level::Look => {
            format!(
                "deeper than half an element's diagonal ({half} mm): single nodes behind a sharp rim or torn yarns change little"
            )
        }
        Level::Bad => "deeper than two diagonals of an element: fabric slipped through the projectile".to_owned(),
    };
    QualityCheck {
        name: "fabric inside the projectile",
        value: format!("{} mm", short(run.max_penetration * 1e3, 2)),
        level,
        reason,
    }
}

fn ply_penetration(case: &Case, run: &Run) -> QualityCheck {
    let thinnest = warnings::thinnest(case);
    let thick = short(thinnest * 1e3, 3);
    let level = level(run.max_ply_penetration, [PLY_PENETRATION_LIMIT * thinnest, 20.0 * thinnest]);
    let reason = by_level(
        level,
        [
            format!("less than a ply is thick ({thick} mm)"),
            format!("more than a ply is thick ({thick} mm): single nodes of torn, crumpled fabric passed a neighbour"),
            "more than twenty plies are thick: plies have changed places".to_owned(),
        ],
    );
    let value = format!("{} mm", short(run.max_ply_penetration * 1e3, 3));
    QualityCheck { name: "plies inside each other", value, level, reason }
}

fn width(cells: f64) -> QualityCheck {
    let level = if cells < CELLS_LIMIT { Level::Look } else { Level::Fine };
    let reason = by_level(
        level,
        ["at least three: it cannot slip between nodes", "fewer than three: it may slip between nodes", ""],
    );
    QualityCheck { name: "projectile width", value: format!("{} elements", short(cells, 2)), level, reason }
}

/// Half the spread of the absorbed energy over meshes, steps and places in a cell near the limit and up to three times it, over
/// the energy at the limit [-]: largest of `docs/src/objectivity.md`, by default and with the paper's numerics.
const ABSORBED_SCATTER: [f64; 2] = [0.1, 0.35];

/// A load over the breaking load above which another mesh, or another place of the hit in a mesh whose lines are counted from the edges, may
/// break a yarn [-]: the limit of S-720 differs by up to 12 % then, and tension grows with velocity to the power 4/3 (Smith).
const NEAR_BREAKING: f64 = 0.85;

/// By how much the velocity of a sharp-rimmed projectile that leaves may differ with the mesh [m/s], and with the place of the hit where
/// lines of nodes do not follow it, as measured on one fabric, S-720; `None` where that was not measured or nothing broke.
pub fn scatter(case: &Case, run: &Run) -> Option<f64> {
    let projectile = case.projectile.as_ref().filter(|p| p.motion == Motion::Free)?;
    let has_rim = Body::new(projectile).ok()?.profile.has_round_rim() && projectile.edge_radius == 0.0;
    let left = residual_velocity(case, run)?;
    if run.outcome != Outcome::Perforated || !has_rim || run.events.is_empty() || left <= 0.0 {
        return None;
    }
    let share = ABSORBED_SCATTER[usize::from(case.solver.numerics == Numerics::Paper)];
    // The energy that a perforation takes is about that at the limit.
    let taken = projectile.velocity.powi(2) - left.powi(2);
    Some((0.5 * share * taken.max(0.0) / left).min(projectile.velocity))
}

/// Largest strain of a piece of yarn over its failure strain [-].
fn highest_load(run: &Run) -> f64 {
    run.history.iter().map(|row| row.balance.max_load).fold(0.0, f64::max)
}

/// What the signs say in one word, and why: the signs that are not fine, the worst first.
pub fn answer(signs: &[QualityCheck]) -> (Level, Vec<&QualityCheck>) {
    let level = worst(signs);
    (level, signs.iter().filter(|sign| sign.level == level && level != Level::Fine).collect())
}

/// Whether the outcome depends on how the mesh lies under the projectile; the figures are those of `docs/src/objectivity.md`.
fn mesh_under_hit(case: &Case, run: &Run) -> QualityCheck {
    let broken: u64 = run.history.last().map_or(0, |row| row.failed.iter().sum());
    let body = case.projectile.as_ref().and_then(|projectile| Body::new(projectile).ok());
    let has_rim = body.is_some_and(|body| body.profile.has_round_rim());
    // An ogive without a tip is half a ball.
    let is_ball = case.projectile.as_ref().is_some_and(|p| match p.shape {
        Shape::Sphere { .. } => true,
        Shape::Ogive { .. } => !p.shape.is_pointed(),
        _ => false,
    });
    let tip = case.projectile.as_ref().filter(|p| p.shape.is_pointed()).map(|p| p.edge_radius);
    let at_rim = case.solver.contact_sampling == ContactSampling::Edges;
    let (level, reason) = match broken {
        0 if has_rim && highest_load(run) > NEAR_BREAKING => {
            (Level::Look, "no yarn broke, but one came near to it: with another mesh the projectile may pass")
        }
        0 => (Level::Fine, "no yarn broke: another mesh changes what is lost by a few per cent"),
        _ if is_ball => (
            Level::Fine,
            "a ball: finer elements move a ballistic limit by 1 to 4 % on one or two plies, by up to 10 % on four",
        ),
        _ if tip == Some(0.0) => (
            Level::Bad,
            "a sharp point: fabric stands on it or slips off, which no mesh decides; give it its edge_radius_mm",
        ),
        _ if tip.is_some() => (
            Level::Look,
            "a point: what a perforation takes depends on the mesh; compare with \"accuracy\": \"converged\"",
        ),
        _ if !has_rim || at_rim => (
            Level::Look,
            "a sharp rim: finer elements change the energy that a perforation takes; compare with \"accuracy\": \"converged\", or give \
             the rim its edge_radius_mm",
        ),
        _ => (
            Level::Look,
            "contact was sampled at nodes: a ballistic limit hangs on where in a cell the hit is; compare with \
             \"contact_sampling\": \"edges\"",
        ),
    };
    let value = match scatter(case, run) {
        Some(scatter) => format!("± {} m/s", short(scatter, 2)),
        None if broken == 0 => format!("at most {} of a breaking load", fraction(highest_load(run))),
        None => "not measured".to_owned(),
    };
    QualityCheck { name: "sensitivity to the mesh under the hit", value, level, reason: reason.to_owned() }
}

/// Whether the fabric held in its frame until the outcome was decided.
fn frame(case: &Case, run: &Run) -> QualityCheck {
    let broken = Breakage::of(case, run);
    let level = if broken.tore_off() { Level::Look } else { Level::Fine };
    let reason = by_level(
        level,
        [
            "no more pieces of yarn than at the hit, so far as they decide",
            "more than at the hit: the fabric tore off its frame and flew with the projectile; a slower shot may pass where this one is \
             stopped, and in a test fabric slips in its clamps",
            "",
        ],
    );
    QualityCheck { name: "broken at the edges", value: grouped(broken.torn_off as u64), level, reason }
}

fn newton(run: &Run) -> QualityCheck {
    let solved = run.element_steps_computed.max(1) as f64;
    let share = run.newton.unconverged as f64 / solved;
    let level = level(share, [0.0, UNCONVERGED_LIMIT]);
    let reason = match level {
        Level::Fine => {
            format!("every unit cell found its equilibrium (residual {})", fraction(run.newton.max_residual))
        }
        Level::Look => "a few unit cells missed their equilibrium".to_owned(),
        Level::Bad => "many unit cells missed their equilibrium".to_owned(),
    };
    QualityCheck { name: "unit cells unsolved", value: grouped(run.newton.unconverged), level, reason }
}

/// An energy at the end over the energy put in [-].
fn of_given(run: &Run, energy: impl Fn(&Balance) -> f64) -> f64 {
    let end = run.history.last().map(|row| row.balance).unwrap_or_default();
    let start = run.history.first().map(|row| row.balance).unwrap_or_default();
    // Pre-tension and a deflection are put in too; the first row comes after first contact.
    let at_start = start.kinetic + start.stored + start.hourglass + start.projectile;
    let given = run.impact_energy.max(at_start) + end.external.max(0.0);
    match energy(&end) {
        0.0 => 0.0,
        energy => energy / given.max(f64::MIN_POSITIVE),
    }
}

fn law(run: &Run) -> QualityCheck {
    let reasons = [
        "of the energy put in: the published law is not derived from an energy, a few per cent are its own",
        "the unit-cell law gives back other energy than it takes; compare with \"law\": \"variational\"",
        "the unit-cell law made or lost so much energy that the result is not to be used; take \"law\": \"variational\"",
    ];
    QualityCheck::of_share(
        "energy of the unit-cell law",
        of_given(run, |end| end.law).abs(),
        [LAW_LIMIT, UNUSABLE],
        reasons,
    )
}

fn separation(run: &Run) -> QualityCheck {
    let reasons = [
        "of the energy put in: plies that are moved out of each other strain their yarns by no more than counts",
        "moving plies out of each other gave the fabric energy that nothing put in",
        "moving plies out of each other gave the fabric so much energy that the result is not to be used",
    ];
    QualityCheck::of_share(
        "energy of ply separation",
        of_given(run, |end| end.separation),
        [GAINED_LIMIT, 5.0 * GAINED_LIMIT],
        reasons,
    )
}

fn mesh(case: &Case) -> QualityCheck {
    let count = case.pack.crossovers_per_element;
    let level = if count > CROSSOVERS_LIMIT { Level::Look } else { Level::Fine };
    let reason = by_level(
        level,
        ["single yarns fail, as in the fabric", "more than one: yarns fail in bundles, which delays failure", ""],
    );
    QualityCheck { name: "crossovers per element", value: format!("{count} × {count}"), level, reason }
}
