//! Checks of a run: each number, its limits, and what that means for the result. One table for the terminal, `summary.json` and the report.

use super::breakage::{Breakage, clearance};
use super::number::{fraction, grouped, short};
use super::summary::{peak, residual_velocity, verdict};
use super::warnings::{Warning, areal_density, assumed, fibre, mass, warning};
use crate::case::{Case, ContactSampling, Motion, Numerics, Projectile, Shape};
use crate::physics::projectile_body::Body;
use crate::run::Run;
use crate::run::outcome::Outcome;
use crate::solver::energy_balance::Balance;

/// Energy error that practitioners accept, over the energy exchanged [-].
pub const ENERGY_LIMIT: f64 = 0.02;
/// Energy by state functions that nothing accounts for, over the energy exchanged, above which a run is to be looked at [-].
pub const GAINED_LIMIT: f64 = 0.01;
/// Hourglass energy that practitioners accept, over the internal energy [-].
pub const HOURGLASS_LIMIT: f64 = 0.05;
/// Depth of a node in the projectile, over the diagonal of the largest element [-]: no place of the fabric is farther from a node,
/// so where its surface runs between them is not known any better.
const PENETRATION_LIMIT: f64 = 0.5;
/// Depth of whole fabric in a neighbouring ply, over the thinnest fabric's thickness [-]: beyond it, plies have changed places.
const PLY_PENETRATION_LIMIT: f64 = 1.0;
/// Crossovers along the side of an element that resolve the failure of single yarns.
pub const CROSSOVERS_LIMIT: u32 = 1;
/// Least diameter of a projectile over the longest element side [-]: contact is sampled at nodes.
pub const CELLS_LIMIT: f64 = 3.0;
/// Errors of energy and momentum that change no figure of a result [-].
const NEGLIGIBLE: f64 = 1e-4;
/// Energy from nowhere above which a result is not to be used, over what was exchanged or what the fabric holds [-].
const UNUSABLE: f64 = 0.1;
/// Reason to look at a projectile that has met nothing.
const MISSED: &str = "the projectile never met the fabric: look at /projectile/offset_mm";
/// Share of the projectile's impulse that went into the frame that is to be looked at, and that makes it no shot on fabric [-].
const FRAME_LIMITS: [f64; 2] = [0.01, 0.05];
/// Share of unit cells without equilibrium that no longer is a matter of a few places [-].
const UNCONVERGED_LIMIT: f64 = 1e-6;
/// Residual of a unit cell that is rounding and no more, over the breaking load, in double and in single precision [-]: some fifty times what the
/// iteration accepts.
const MISSED_FOR_ROUNDING: [f64; 2] = [1e-9, 1e-4];
/// Energy that the law itself does not conserve, over what was exchanged, that is to be looked at [-].
const LAW_LIMIT: f64 = 0.05;
/// Half the spread of the absorbed energy over meshes, steps and places in a cell near the limit and up to three times it, over
/// the energy at the limit [-]: largest of `docs/src/objectivity.md`, by default and with the paper's numerics.
const ABSORBED_SCATTER: [f64; 2] = [0.1, 0.35];
/// A load over the breaking load above which another mesh, or another place of the hit in a mesh whose lines are counted from the edges, may
/// break a yarn [-]: the limit of S-720 differs by up to 12 % then, and tension grows with velocity to the power 4/3 (Smith).
const NEAR_BREAKING: f64 = 0.85;
/// Level of a check.
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
    /// Level as one word.
    pub fn word(self) -> &'static str {
        ["fine", "look", "bad"][self as usize]
    }

    /// Advice on a result whose worst check has this level.
    pub fn advice(self) -> &'static str {
        ["trust", "look", "do not use"][self as usize]
    }
}

/// A check of a run.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Check {
    /// Quantity.
    pub name: &'static str,
    /// Value found, with its unit.
    pub value: String,
    /// Level.
    pub level: Level,
    /// Reason for the level; empty where it is fine.
    pub reason: String,
    /// Warning with its number, where the check calls for one.
    pub warning: Option<Warning>,
}

/// All checks of a run, the same ones in the same order for alike cases.
pub fn checks(case: &Case, run: &Run) -> Vec<Check> {
    let gained = gained(run);
    let energy = energy(run, gained.warning.is_some());
    let mut all = vec![end(case, run), gained, stored(run), energy, momentum(run), hourglass(run)];
    if let Some(projectile) = &case.projectile {
        all.push(penetration(case, run));
        all.extend(width(case));
        all.extend([aim(case, projectile, run), mesh_under_hit(case, projectile, run), frame(case, run)]);
    }
    all.extend((run.plies > 1).then(|| ply_penetration(case, run)));
    all.extend([newton(run), law(run)]);
    all.extend((run.plies > 1).then(|| separation(run)));
    all.push(mesh(case));
    all
}

/// Warnings before a run, in order of code.
pub fn case_warnings(case: &Case) -> Vec<Warning> {
    warnings(case, &width(case).into_iter().chain([mesh(case)]).collect::<Vec<_>>())
}

/// Warnings after a run, in order of code.
pub fn warnings(case: &Case, checks: &[Check]) -> Vec<Warning> {
    let found = checks.iter().filter_map(|check| check.warning.clone());
    let of_case = [assumed(case), mass(case), areal_density(case), fibre(case)];
    let mut all: Vec<Warning> = of_case.into_iter().flatten().chain(found).collect();
    all.sort_by_key(|warning| warning.kind.code);
    all
}

/// Worst level of the checks, and those of this level unless all are fine.
pub fn advice(checks: &[Check]) -> (Level, Vec<&Check>) {
    let level = checks.iter().map(|check| check.level).max().unwrap_or(Level::Fine);
    (level, checks.iter().filter(|check| check.level == level && level != Level::Fine).collect())
}

impl Check {
    /// A check by level, with its reason where it is to be looked at, or bad.
    fn new(name: &'static str, value: String, level: Level, [look, bad]: [&str; 2]) -> Self {
        Self { name, value, level, reason: ["", look, bad][level as usize].to_owned(), warning: None }
    }

    /// A check of a share against two limits.
    fn share(name: &'static str, share: f64, limits: [f64; 2], reasons: [&str; 2]) -> Self {
        Self::new(name, fraction(share), level(share.abs(), limits), reasons)
    }

    /// The check with a warning where the value is above its limit, or no number at all.
    fn warned(self, number: usize, value: f64, limit: f64, message: String) -> Self {
        let is_within = value <= limit; // what is no number is not
        let warning = (!is_within).then(|| warning(number, value, limit, message));
        Self { warning, ..self }
    }

    /// The check of a share with a warning where it is above its limit.
    fn warned_share(self, number: usize, what: &str, share: f64, limit: f64) -> Self {
        let [found, accepted] = [share, limit].map(|part| part * 100.0);
        self.warned(number, share, limit, format!("{what} is {found:.1} %, above the {accepted:.0} % accepted"))
    }

    /// A check of a depth [m] with this number of digits into something, with a warning above the first limit, which is so much of what.
    fn depth(
        name: &'static str,
        (depth, digits): (f64, i32),
        limits: [f64; 2],
        reasons: [&str; 2],
        [into, of]: [&str; 2],
    ) -> Self {
        let [found, allowed] = [depth, limits[0]].map(|depth| depth * 1e3);
        let message = format!("a node got {found:.3} mm into {into}, deeper than {of}, {allowed:.3} mm");
        let value = format!("{} mm", short(found, digits));
        Self::new(name, value, level(depth, limits), reasons).warned(4, found, allowed, message)
    }
}

/// Level of a value: above the first limit it is to be looked at, above the second (or no number) it is bad.
fn level(value: f64, [look, bad]: [f64; 2]) -> Level {
    match value {
        value if value <= look => Level::Fine,
        value if value <= bad => Level::Look,
        _ => Level::Bad,
    }
}

/// [`Level::Look`] on a condition.
fn look_if(condition: bool) -> Level {
    if condition { Level::Look } else { Level::Fine }
}

fn end(case: &Case, run: &Run) -> Check {
    let verdict = verdict(case, run);
    let reason = match run.divergence {
        Some(_) => "the run became unstable; what came before is not to be used",
        None => "the run was broken off; what is shown ends there",
    };
    let (value, level) = if verdict.complete { ("complete", Level::Fine) } else { (verdict.word, Level::Bad) };
    Check::new("end of the run", value.to_owned(), level, ["", reason])
}

fn gained(run: &Run) -> Check {
    let reasons = [
        "by state functions: the integration created or dissipated energy; compare with a lower Courant number",
        "by state functions: the integration created or dissipated so much energy that the result is not to be used",
    ];
    let check = Check::share("energy gained", run.energy_gained, [GAINED_LIMIT, 5.0 * GAINED_LIMIT], reasons);
    check.warned_share(2, "energy that nothing accounts for", run.energy_gained.abs(), GAINED_LIMIT)
}

/// `warned`: there is a warning of this number already.
fn energy(run: &Run, warned: bool) -> Check {
    let reasons = [
        "more than 0.01 %, within the 2 % practitioners accept",
        "above the 2 % practitioners accept: energy was created or dissipated",
    ];
    let check = Check::share("work balance", run.energy_error, [NEGLIGIBLE, ENERGY_LIMIT], reasons);
    if warned { check } else { check.warned_share(2, "the energy error", run.energy_error, ENERGY_LIMIT) }
}

/// The fabric's elastic energy must lie between nothing and what there was to take it from.
fn stored(run: &Run) -> Check {
    let made = |row: &Balance| row.external.max(0.0) + row.law.max(0.0) + row.separation.max(0.0);
    let most = |row: &Balance| run.fabric_energy + (run.impact_energy - row.projectile).max(0.0) + made(row);
    let slack = GAINED_LIMIT * run.exchanged_energy;
    let all = || run.history.iter().map(|row| &row.balance);
    let fault = if all().any(|row| !row.internal.is_finite()) {
        Some("not a number")
    } else if all().any(|row| row.internal < -slack - row.law.abs()) {
        Some("below zero: the fabric gave back energy that it never had")
    } else if all().any(|row| row.internal > most(row) + slack) {
        Some("more than there was to take it from: the arithmetic made energy")
    } else {
        None
    };
    let last = run.history.last().map_or(0.0, |row| row.balance.internal);
    let level = if fault.is_some() { Level::Bad } else { Level::Fine };
    Check::new("elastic energy", format!("{} J", short(last, 3)), level, ["", fault.unwrap_or_default()])
}

fn momentum(run: &Run) -> Check {
    let reasons = ["more than 0.01 %", "above 2 %: forces do not balance"];
    Check::share("momentum error", run.momentum_error, [NEGLIGIBLE, ENERGY_LIMIT], reasons)
}

fn hourglass(run: &Run) -> Check {
    let reasons = [
        "above the 5 % practitioners accept: the fabric was stiffer than asked for",
        "above 10 %: the artificial stiffness carried the load",
    ];
    let share = run.hourglass_fraction;
    let check = Check::share("hourglass / internal energy", share, [HOURGLASS_LIMIT, UNUSABLE], reasons);
    check.warned_share(3, "hourglass energy over internal energy", share, HOURGLASS_LIMIT)
}

fn penetration(case: &Case, run: &Run) -> Check {
    let layers = case.layers();
    let diagonals = layers.iter().map(|layer| layer.mesh.length[0].hypot(layer.mesh.length[1]));
    let diagonal = diagonals.fold(0.0, f64::max);
    let limit = PENETRATION_LIMIT * diagonal;
    let half = short(1e3 * limit, 2);
    let look = format!(
        "deeper than half an element's diagonal ({half} mm): single nodes behind a sharp rim or torn yarns change little"
    );
    let reasons = [&look, "deeper than two diagonals of an element: fabric slipped through the projectile"];
    let (limits, words) = ([limit, 2.0 * diagonal], ["the projectile", "half an element's diagonal"]);
    Check::depth("fabric inside the projectile", (run.max_penetration, 2), limits, reasons, words)
}

fn ply_penetration(case: &Case, run: &Run) -> Check {
    let thinnest = case.layers().iter().map(|layer| layer.fabric.thickness).fold(f64::INFINITY, f64::min);
    let thick = short(thinnest * 1e3, 3);
    let look =
        format!("more than a ply is thick ({thick} mm): single nodes of torn, crumpled fabric passed a neighbour");
    let reasons = [&look, "more than twenty plies are thick: plies have changed places"];
    let limits = [PLY_PENETRATION_LIMIT * thinnest, 20.0 * thinnest];
    let words = ["a neighbouring ply", "the thinnest ply is thick"];
    Check::depth("plies inside each other", (run.max_ply_penetration, 3), limits, reasons, words)
}

/// Elements that a projectile is wide; of a bar, which meets whole rows of nodes, that says nothing.
fn width(case: &Case) -> Option<Check> {
    let shape = case.projectile.as_ref().map(|p| p.shape).filter(|shape| !shape.is_bar())?;
    let sides = case.layers().iter().map(|layer| layer.mesh.length[0].max(layer.mesh.length[1])).fold(0.0, f64::max);
    let cells = shape.diameter() / sides;
    let level = look_if(cells < CELLS_LIMIT);
    let reasons = ["fewer than three: it may slip between nodes", ""];
    let message = format!("the projectile is {cells:.1} elements wide; below {CELLS_LIMIT} it may slip between nodes");
    let warning = (level == Level::Look).then(|| warning(6, cells, CELLS_LIMIT, message));
    let check = Check::new("projectile width", format!("{} elements", short(cells, 2)), level, reasons);
    Some(Check { warning, ..check })
}

/// Difference of the velocity of a sharp-rimmed projectile that leaves with the mesh [m/s], and with the place of the hit where
/// lines of nodes do not follow it, as measured on one fabric, S-720; `None` where that was not measured or nothing broke.
pub fn scatter(case: &Case, run: &Run) -> Option<f64> {
    let projectile = case.projectile.as_ref().filter(|p| p.motion == Motion::Free)?;
    let has_rim = Body::new(projectile)?.profile.has_round_rim() && projectile.edge_radius == 0.0;
    let left = residual_velocity(case, run)?;
    if run.outcome != Outcome::Perforated || !has_rim || run.events.is_empty() || left <= 0.0 {
        return None;
    }
    let share = ABSORBED_SCATTER[usize::from(case.solver.numerics == Numerics::Paper)];
    // The energy that a perforation takes is about that at the limit.
    let taken = projectile.velocity.powi(2) - left.powi(2);
    Some((0.5 * share * taken.max(0.0) / left).min(projectile.velocity))
}

/// Dependence of the outcome on how the mesh lies under the projectile; the figures are those of `docs/src/objectivity.md`.
fn mesh_under_hit(case: &Case, projectile: &Projectile, run: &Run) -> Check {
    let broken: u64 = run.history.last().map_or(0, |row| row.failed.iter().sum());
    let load = peak(run, |row| row.balance.max_load);
    let (shape, edge_radius) = (&projectile.shape, projectile.edge_radius);
    let has_rim = Body::new(projectile).is_some_and(|body| body.profile.has_round_rim());
    // An ogive without a tip is half a ball, and so is a cylinder whose rim is rounded off.
    let is_round =
        matches!(shape, Shape::Sphere { .. } | Shape::Ogive { .. }) || edge_radius > 0.499 * shape.diameter();
    let is_ball = is_round && !shape.is_pointed();
    let tip = shape.is_pointed().then_some(edge_radius);
    let reason = if broken == 0 && !is_ball && load > NEAR_BREAKING {
        "no yarn broke, but one came near to it: with another mesh the projectile may pass"
    } else if broken == 0 || is_ball {
        ""
    } else if tip == Some(0.0) {
        "a sharp point: fabric stands on it or slips off, which no mesh decides; give it its edge_radius_mm"
    } else if tip.is_some() || shape.is_bar() {
        "a point or a bar: what a perforation takes depends on the mesh; compare with \"accuracy\": \"converged\""
    } else if edge_radius > 0.0 {
        "a rim: finer elements change the energy that a perforation takes; compare with \"accuracy\": \"converged\""
    } else if !has_rim || case.solver.contact_sampling == ContactSampling::Edges {
        "a sharp rim: finer elements change the energy that a perforation takes; compare with \"accuracy\": \"converged\", or give \
         the rim its edge_radius_mm"
    } else {
        "contact was sampled at nodes: a ballistic limit depends on where in a cell the hit is; compare with \
         \"contact_sampling\": \"edges\""
    };
    let level = match reason {
        "" => Level::Fine,
        _ if broken > 0 && tip == Some(0.0) => Level::Bad,
        _ => Level::Look,
    };
    let value = match scatter(case, run) {
        Some(scatter) => format!("± {} m/s", short(scatter, 2)),
        None if broken == 0 => format!("at most {} of a breaking load", fraction(load)),
        None => "not measured".to_owned(),
    };
    Check::new("sensitivity to the mesh under the hit", value, level, [reason; 2])
}

/// Place of the hit: on fabric, not beside it, nor on what holds it.
fn aim(case: &Case, projectile: &Projectile, run: &Run) -> Check {
    let to_frame = clearance(case, projectile.offset);
    let has_missed = run.history.iter().all(|row| row.contact_force == 0.0);
    let is_over = to_frame < 0.5 * projectile.shape.diameter();
    let reasons = [
        if has_missed { MISSED } else { "the projectile reaches over the clamps: what they take is not the fabric's" },
        "the frame took more than a little of the impulse, or the projectile went through it: take a larger pack, aim farther inside",
    ];
    let share = if is_over && run.outcome == Outcome::Perforated { 1.0 } else { run.frame_share };
    let level = level(share, FRAME_LIMITS).max(look_if(has_missed || is_over));
    let took = format!(", which took {} of the impulse", fraction(run.frame_share));
    let took = if run.frame_share > 0.0 { &took } else { "" };
    let value = format!("{} mm from the nearest clamp{took}", short(1e3 * to_frame, 3));
    let value = if to_frame.is_finite() { value } else { "no clamp".to_owned() };
    Check::new("place of the hit", value, level, reasons)
}

/// Hold of the fabric in its frame until the outcome was decided.
fn frame(case: &Case, run: &Run) -> Check {
    let broken = Breakage::of(case, run);
    let [torn, cut] = broken.torn_first;
    let reasons = [
        "more than at the hit by then: the fabric tore off its frame and flew with the projectile; a slower shot may pass where this one is \
         stopped, and in a test fabric slips in its clamps",
        "",
    ];
    let [value, at_hit] = [torn, cut].map(|count| grouped(count as u64));
    let message = format!("{value} yarns had broken at the edges, {at_hit} at the hit");
    let check = Check::new("broken at the edges", value, look_if(broken.is_torn_off()), reasons);
    check.warned(8, torn as f64, cut as f64, message)
}

fn newton(run: &Run) -> Check {
    let share = run.newton.unconverged as f64 / run.element_steps_computed.max(1) as f64;
    // In single precision more cells miss what is accepted, by no more than they are rounded.
    let is_rounding = run.newton.max_residual <= MISSED_FOR_ROUNDING[usize::from(run.precision == "f32")];
    let most = if is_rounding { f64::INFINITY } else { UNCONVERGED_LIMIT };
    let reasons = ["a few unit cells missed their equilibrium", "many unit cells missed their equilibrium"];
    let value = grouped(run.newton.unconverged);
    Check::new("unit cells unsolved", value, level(share, [0.0, most]), reasons)
}

/// An energy at the end over the energy exchanged [-].
fn of_exchanged(run: &Run, energy: impl Fn(&Balance) -> f64) -> f64 {
    run.history.last().map_or(0.0, |row| energy(&row.balance)) / run.exchanged_energy.max(f64::MIN_POSITIVE)
}

fn law(run: &Run) -> Check {
    let reasons = [
        "the unit-cell law gives back other energy than it takes; compare with \"law\": \"variational\"",
        "the unit-cell law created or dissipated so much energy that the result is not to be used; take \"law\": \"variational\"",
    ];
    let share = of_exchanged(run, |end| end.law).abs();
    Check::share("energy of the unit-cell law", share, [LAW_LIMIT, UNUSABLE], reasons)
}

fn separation(run: &Run) -> Check {
    let reasons = [
        "moving plies out of each other gave the fabric energy that nothing put in",
        "moving plies out of each other gave the fabric so much energy that the result is not to be used",
    ];
    let share = of_exchanged(run, |end| end.separation);
    Check::share("energy of ply separation", share, [GAINED_LIMIT, 5.0 * GAINED_LIMIT], reasons)
}

fn mesh(case: &Case) -> Check {
    let [count, limit] = [case.pack.crossovers_per_element, CROSSOVERS_LIMIT];
    let reasons = ["more than one: yarns fail in bundles, which delays failure", ""];
    let message = format!("an element holds {count} × {count} crossovers; more than one delays failure");
    let check = Check::new("crossovers per element", format!("{count} × {count}"), look_if(count > limit), reasons);
    check.warned(5, count.into(), limit.into(), message)
}
