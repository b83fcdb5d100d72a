//! Result of a run: `summary.json`, the energies at the end, and the verdict in a line.

use serde_json::{Map, Value, json};

use super::breakage::Breakage;
use super::checks::{self, Check, checks};
use super::expect;
use super::number::{fixed, grouped, short, us};
use super::warnings::assumed_fields;
use crate::case::{Case, Motion, case_hash};
use crate::physics::rigid_body::MirrorPlanes;
use crate::run::outcome::Outcome;
use crate::run::{PlySample, Run, Sample};
use crate::solver::Divergence;

/// Depth of a crater in clay that NIJ 0101.06 accepts [m].
const SIGNATURE_LIMIT: f64 = 44e-3;

/// The summary of a run. `wall_seconds`: time since the command began [s].
///
/// Numbers that are not finite become `null`.
pub fn summary(case: &Case, run: &Run, wall_seconds: f64) -> Value {
    let checks = checks(case, run);
    let parts = [result(case, run), cost(run, wall_seconds), origin(case, run, &checks)];
    let mut summary: Value =
        parts.iter().filter_map(Value::as_object).flatten().map(|(key, value)| (key.clone(), value.clone())).collect();
    summary["notes"] = json!(case.notes);
    let checked = expect::check(case, run, &summary);
    summary["trust"] = trust(&checks);
    summary["expect"] = checked.into();
    summary
}

/// Advice in a word or two, and the checks that gave it.
fn trust(checks: &[Check]) -> Value {
    let (level, why) = checks::advice(checks);
    let reason = |check: &&Check| json!({"sign": check.name, "value": check.value, "reason": check.reason});
    json!({"advice": level.advice(), "why": why.iter().map(reason).collect::<Vec<_>>()})
}

/// Kinetic energy the projectile has lost [J].
pub fn absorbed_energy(run: &Run) -> f64 {
    run.impact_energy - run.history.last().map_or(run.impact_energy, |row| row.balance.projectile)
}

/// Velocity along the line of flight that is left [m/s]; `None` where nothing flies.
pub fn residual_velocity(case: &Case, run: &Run) -> Option<f64> {
    case.projectile.as_ref()?;
    match run.outcome {
        Outcome::Stopped => Some(0.0),
        _ => run.history.last().map(|row| row.projectile_velocity),
    }
}

/// Depth of the deepest crater in the clay behind a pack [m]; `None` without clay, or where the projectile went through.
fn backface_signature(case: &Case, run: &Run) -> Option<f64> {
    case.backing.filter(|_| run.outcome != Outcome::Perforated).map(|_| peak(run, |row| row.balance.crater))
}

pub(super) fn peak(run: &Run, quantity: fn(&Sample) -> f64) -> f64 {
    run.history.iter().map(quantity).fold(0.0, f64::max)
}

/// Results.
fn result(case: &Case, run: &Run) -> Value {
    let last = run.history.last().copied().unwrap_or_default();
    let broken = Breakage::of(case, run);
    json!({
        "title": case.title,
        "outcome": run.outcome.word(),
        "residual_velocity_m_s": residual_velocity(case, run),
        "residual_velocity_scatter_m_s": checks::scatter(case, run),
        "rebound_velocity_m_s": run.rebound_velocity,
        "carried_velocity_m_s": run.carried_velocity,
        "stop_time_us": run.stop_time.map(|t| t * 1e6),
        "absorbed_energy_j": absorbed_energy(run),
        "fabric_energy_before_j": run.fabric_energy,
        "exchanged_energy_j": run.exchanged_energy,
        "max_deflection_mm": run.deflection() * 1e3,
        "max_penetration_mm": run.max_penetration * 1e3,
        "max_ply_penetration_mm": run.max_ply_penetration * 1e3,
        "last_ply_deflection_mm": peak(run, |s| s.last_deflection) * 1e3,
        "backface_signature_mm": backface_signature(case, run).map(|depth| depth * 1e3),
        "perforated_plies": last.perforated_plies,
        "plies": plies(run),
        "peak_yarn_tension_n": peak(run, |s| s.balance.max_tension),
        "breaking_load_ratio": peak(run, |s| s.balance.max_load),
        "peak_contact_force_n": peak(run, |s| s.contact_force),
        "failed_yarns": { "warp": last.failed[0], "weft": last.failed[1] },
        "broken_yarns": { "warp": broken.yarns[0], "weft": broken.yarns[1] },
        "failures_at": { "hit": broken.at_hit, "edges": broken.at_edges, "elsewhere": broken.elsewhere },
        "eroded_elements": last.eroded,
        "energy_error": run.energy_error,
        "energy_gained": run.energy_gained,
        "law_energy_j": last.balance.law,
        "ply_separation_j": last.balance.separation,
        "backing_energy_j": last.balance.backing,
        "viscous_dissipation_j": last.balance.viscous,
        "momentum_error": run.momentum_error,
        "hourglass_fraction": run.hourglass_fraction,
        "newton": run.newton,
        "interrupted": run.interrupted,
        "device_lost": run.lost,
        "checkpoint_failed": run.checkpoint_error,
        "unstable": run.divergence.as_ref().map(unstable),
    })
}

fn unstable(Divergence { step, kernel, quantity, place: [ply, row, column] }: &Divergence) -> Value {
    json!({ "step": step, "kernel": kernel, "quantity": quantity, "ply": ply, "row": row, "column": column })
}

/// Plies of a pack at the end of the run, and their largest deflections; empty for a single ply.
fn plies(run: &Run) -> Vec<Value> {
    let end = run.ply_history.len().saturating_sub(run.plies);
    let ply = |last: &PlySample| {
        json!({
            "ply": last.ply,
            "kinetic_energy_j": last.moment.kinetic,
            "stored_energy_j": last.moment.stored,
            "max_deflection_mm": run.deflections.get(last.ply).copied().unwrap_or(0.0) * 1e3,
            "failed_yarns": { "warp": last.failed[0], "weft": last.failed[1] },
        })
    };
    run.ply_history[end..].iter().map(ply).collect()
}

/// Costs.
fn cost(run: &Run, wall_seconds: f64) -> Value {
    let element_steps = (run.elements as u64).saturating_mul(run.steps);
    let part = element_steps / run.planes.copies();
    json!({
        "elements": run.elements,
        "steps": run.steps,
        "time_us": run.history.last().map_or(0.0, |row| row.time * 1e6),
        "time_step_us": run.time_step * 1e6,
        "time_step_set_by": run.step_set_by,
        "element_steps": element_steps,
        "element_steps_computed": run.element_steps_computed,
        "wall_s": wall_seconds,
        "loop_s": run.loop_seconds,
        "host_overhead_s": run.host_seconds,
        "element_steps_per_s": element_steps as f64 / run.loop_seconds,
        "skipped": {
            "symmetry": element_steps - part,
            "mirror_planes": run.planes.names(),
            "wavefront": part.saturating_sub(run.element_steps_computed),
            "switched_off": run.skips.switched_off(),
        },
        "timings": timings(run),
    })
}

/// Wall time of the kernels and of the rest of the loop, and their share of it; empty where nothing was timed.
fn timings(run: &Run) -> Map<String, Value> {
    let timed: f64 = run.kernel_seconds.iter().map(|(_, seconds)| seconds).sum();
    let rest = [("other", (run.loop_seconds - timed).max(0.0))];
    let all = run.kernel_seconds.iter().chain(rest.iter().filter(|_| timed > 0.0));
    let entry = |seconds: f64| json!({ "s": seconds, "share": seconds / run.loop_seconds });
    all.map(|(name, seconds)| ((*name).to_owned(), entry(*seconds))).collect()
}

/// Origin: backend, version, case, assumptions, warnings.
fn origin(case: &Case, run: &Run, checks: &[Check]) -> Value {
    let assumed: Vec<&str> = assumed_fields(case).map(|field| field.pointer.as_str()).collect();
    json!({
        "backend": run.backend,
        "adapter": run.adapter,
        "threads": run.threads,
        "precision": run.precision,
        "version": env!("CARGO_PKG_VERSION"),
        "case": case.name,
        "case_hash": case_hash(&case.as_run),
        "assumed": assumed,
        "warnings": checks::warnings(case, checks),
    })
}

/// Mass of all plies over their area [kg/m²].
pub fn areal_density(case: &Case) -> f64 {
    case.layers().iter().map(|layer| f64::from(layer.plies) * layer.fabric.areal_density).sum()
}

/// Largest contact force and its time, in words; `None` without contact.
pub(super) fn peak_force(run: &Run) -> Option<[String; 2]> {
    let rows = run.history.iter().filter(|row| row.contact_force > 0.0);
    let peak = rows.max_by(|a, b| a.contact_force.total_cmp(&b.contact_force))?;
    Some([format!("{} N", short(peak.contact_force, 3)), format!("{} µs", short(peak.time * 1e6, 3))])
}

/// Numbers of a run that a verdict is weighed by: name, number, and more on it. For the terminal and the report.
pub fn margins(case: &Case, run: &Run) -> Vec<(&'static str, String, String)> {
    let mut all = Vec::new();
    let absorbed = absorbed_energy(run);
    if run.impact_energy > 0.0 {
        let share = fixed(100.0 * absorbed / run.impact_energy, 0);
        let of = format!("{share} % of {} J", short(run.impact_energy, 3));
        all.push(("energy absorbed", format!("{} J", short(absorbed, 3)), of));
        let pack = areal_density(case);
        let of = format!("over {} kg/m²", short(pack, 3));
        all.push(("energy per areal density", format!("{} J·m²/kg", short(absorbed / pack, 3)), of));
    }
    all.extend(peak_force(run).map(|[force, time]| ("peak contact force", force, format!("at {time}"))));
    let load = short(100.0 * peak(run, |row| row.balance.max_load), 4);
    all.push(("highest load of a yarn", format!("{load} %"), "of its breaking load".to_owned()));
    let back = short(1e3 * peak(run, |row| row.last_deflection), 3);
    all.push(("back-face deflection", format!("{back} mm"), String::new()));
    all.extend(backface_signature(case, run).map(|depth| {
        let of = format!("in an assumed clay; NIJ 0101.06 accepts {} mm", short(1e3 * SIGNATURE_LIMIT, 3));
        ("back-face signature", format!("{} mm", short(1e3 * depth, 3)), of)
    }));
    let broken = Breakage::of(case, run);
    let [total, warp, weft] = [broken.yarns.iter().sum(), broken.yarns[0], broken.yarns[1]].map(|n| grouped(n as u64));
    let [pieces, hit, edges, elsewhere] =
        [broken.pieces(), broken.at_hit, broken.at_edges, broken.elsewhere].map(|count| grouped(count as u64));
    let places = format!(
        "{warp} warp, {weft} weft, in {pieces} places: {hit} at the hit, {edges} at edges, {elsewhere} elsewhere"
    );
    all.push(("yarns broken", total, if broken.pieces() > 0 { places } else { String::new() }));
    all
}

/// Costs in words, for the terminal and the report.
pub fn costs(case: &Case, run: &Run, summary: &Value) -> impl Iterator<Item = (&'static str, String)> {
    let element_steps = run.elements as u64 * run.steps;
    let rate = element_steps as f64 / run.loop_seconds / 1e6;
    let [elements, steps] = [run.elements as u64, run.steps].map(grouped);
    let share = fixed(100.0 * run.element_steps_computed as f64 / element_steps.max(1) as f64, 1);
    let computed = match run.planes {
        MirrorPlanes::NONE => format!("{share} % computed"),
        planes => format!("{share} % computed: {}", symmetry(planes)),
    };
    let (courant, set_by) = (case.solver.courant, &run.step_set_by);
    let wall = summary["wall_s"].as_f64().unwrap_or(0.0);
    let threads = if run.threads == 1 { "1 thread".to_owned() } else { format!("{} threads", run.threads) };
    let on = format!("on {}, {}, {}", run.backend, run.adapter.as_ref().unwrap_or(&threads), run.precision);
    let rows = [
        ("time step", format!("{}, {courant} of the critical step, set by: {set_by}", us(run.time_step))),
        ("work", format!("{elements} elements × {steps} steps, {computed}")),
        ("not skipped", run.skips.switched_off().join(", ")),
        ("wall time", format!("{wall:.2} s, the loop {:.2} s: {rate:.1} M element-steps/s {on}", run.loop_seconds)),
    ];
    rows.into_iter().filter(|(_, value)| !value.is_empty())
}

/// Energy given to the fabric, and where it is at the end of a run.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Energies {
    /// Sources of the fabric's energy, apart: the projectile, a drive, and what it had before the shot [J].
    pub sources: Vec<(&'static str, f64)>,
    /// Sum of the sources [J].
    pub given: f64,
    /// Shares [J]; they add up to what was given.
    pub shares: Vec<(&'static str, f64)>,
    /// The largest of them [J].
    pub scale: f64,
}

impl Energies {
    /// Energies of the last state of a run; `None` without energy in it, or with numbers that are not finite.
    pub fn of(run: &Run) -> Option<Self> {
        let (end, absorbed) = (&run.history.last()?.balance, absorbed_energy(run));
        let all = [
            ("lost by the projectile", absorbed),
            ("given by the drive", end.external),
            ("held before the shot", run.fabric_energy),
        ];
        // What rounding makes is no source.
        let least = 1e-9 * all.iter().map(|source| source.1.abs()).fold(0.0, f64::max);
        let sources: Vec<_> = all.into_iter().filter(|source| source.1 > least).collect();
        let given = sources.iter().map(|source| source.1).sum();
        let mut shares = vec![
            ("fabric, kinetic", end.kinetic),
            ("fabric, elastic", end.stored),
            ("hourglass", end.hourglass),
            ("viscous forces", end.viscous),
            ("contact", end.contact),
            ("friction", end.friction),
            ("yarn failure", end.failure),
        ];
        let mut also = |name, energy, counts: bool| shares.extend(counts.then_some((name, energy)));
        also("unit-cell law", -end.law, end.law != 0.0);
        also("ply separation", -end.separation, end.separation != 0.0);
        also("clay behind the pack", end.backing, end.backing != 0.0);
        also("gained by the projectile", -absorbed, absorbed < -least);
        also("taken by the drive", -end.external, end.external < -least);
        let found: f64 = shares.iter().map(|share| share.1).sum();
        shares.push(("unaccounted", given - found));
        let scale = shares.iter().map(|share| share.1.abs()).fold(given, f64::max);
        let finite = shares.iter().all(|share| share.1.is_finite());
        (finite && scale > 0.0).then_some(Self { sources, given, shares, scale })
    }

    /// An energy [J] with unit and decimals that suit the largest.
    pub fn text(&self, energy: f64) -> String {
        let (factor, unit) = match self.scale {
            0.1.. => (1.0, "J"),
            1e-4.. => (1e3, "mJ"),
            _ => (1e6, "µJ"),
        };
        let decimals = (4.0 - (factor * self.scale).log10().floor()).clamp(0.0, 4.0) as usize;
        format!("{} {unit}", fixed(factor * energy, decimals))
    }

    /// A share of what was given, in per cent; empty where nothing was.
    pub fn percent(&self, energy: f64) -> String {
        if self.given > 1e-9 * self.scale {
            format!("{} %", fixed(100.0 * energy / self.given, 1))
        } else {
            String::new()
        }
    }
}

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
    let (word, detail) = words(case, run);
    let complete = run.divergence.is_none() && run.lost.is_none() && !run.interrupted;
    Verdict { word, detail, complete }
}

fn words(case: &Case, run: &Run) -> (&'static str, String) {
    let deflected = format!("deflected {} mm at most", short(run.deflection() * 1e3, 4));
    let reached = reached(run);
    if let Some(divergence) = &run.divergence {
        return ("unstable", format!("at {}: {}", place(divergence), divergence.quantity));
    }
    if let Some(reason) = &run.lost {
        return ("device lost", format!("at {reached}, {deflected}: {reason}"));
    }
    if run.interrupted {
        return ("interrupted", format!("at {reached}, {deflected}"));
    }
    let Some(projectile) = case.projectile.as_ref().filter(|p| p.motion == Motion::Free) else {
        return ("done", format!("{reached} computed, {deflected}"));
    };
    let left = residual_velocity(case, run).unwrap_or(0.0);
    let velocity = short(left, 4);
    let stop = run.stop_time.map_or(String::new(), |time| format!("at {:.1} µs, ", time * 1e6));
    let through = run.history.last().map_or(0, |row| row.perforated_plies);
    let torn = if run.plies > 1 { format!("{through} of {} plies perforated, ", run.plies) } else { String::new() };
    let by = if projectile.is_bullet_of_lead() { " by a bullet of lead computed as rigid" } else { "" };
    let struck = format!("{torn}struck at {} m/s{by}", short(projectile.velocity, 4));
    match run.outcome {
        Outcome::Perforated => {
            let leaves = match checks::scatter(case, run) {
                Some(scatter) => format!("{} m/s ± {} by the mesh", short(left, 3), short(scatter, 2)),
                None => format!("{velocity} m/s"),
            };
            let past = if run.history.last().is_some_and(|row| row.failed == [0; 2]) {
                ", past fabric of which no yarn broke"
            } else {
                ""
            };
            ("perforated", format!("leaves at {leaves}{past}, {struck}"))
        }
        Outcome::Stopped => {
            let carried = run.carried_velocity.map(|speed| format!("carried along at {} m/s, ", short(speed, 3)));
            ("stopped", format!("{stop}{}{struck}, {deflected}", carried.unwrap_or_default()))
        }
        Outcome::Rebounded => {
            let flies = match run.rebound_velocity {
                Some(rebound) => format!("flies back at {} m/s", short(rebound, 4)),
                None => format!("flies at {velocity} m/s"),
            };
            ("rebounded", format!("turned {stop}{flies}, {struck}, {deflected}"))
        }
        Outcome::Running => {
            let has_met = run.history.iter().any(|row| row.contact_force != 0.0);
            let advice = ["it never met the fabric", "raise /solver/end_time_us for a verdict"][usize::from(has_met)];
            ("undecided", format!("at {reached}: {velocity} m/s left, {struck}, {deflected}; {advice}"))
        }
    }
}

/// Time reached.
pub fn reached(run: &Run) -> String {
    us(run.history.last().map_or(0.0, |row| row.time))
}

/// Place where a run went wrong.
pub fn place(divergence: &Divergence) -> String {
    let [ply, row, column] = divergence.place;
    format!("step {}, kernel {}, ply {ply}, row {row}, column {column}", divergence.step, divergence.kernel)
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
