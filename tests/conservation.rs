//! Energy, momentum, stability and repeatability of whole runs.
//!
//! Promises: the energy balance closes; a conservative law returns stored energy for work; momentum is constant where
//! nothing holds the fabric; whatever registers the kernels use, every number is the same to the last bit; what no wave has reached is
//! still exactly at rest; hard scenes stay bounded or are diagnosed. Red when: a force misses in the gather, work and force disagree,
//! a failure or contact loses energy unbooked, rest is not rest; a lane is computed from its neighbours, a sum depends on how many are
//! added at once, padding leaks in, or a register's own instruction differs from what one number does.

use ripstop::case::Case;
use ripstop::model::Model;
use ripstop::num::scalar::{Real, Scalar};
use ripstop::num::simd::{Pair, Vectors};
use ripstop::output::checks::{Level, checks};
use ripstop::run::{Precision, RunScalar, Sample, Simulation};
use ripstop::solver::energy_balance::{Balance, EnergyBalance};
use ripstop::solver::node_update::field;
use ripstop::solver::state::State;
use ripstop::solver::{FailureEvent, Stepper};

use crate::support::{builtin, closes, finish, read, run, run_as};

const SMALL: &str = "cases/verify/mirror.json";

#[test]
fn energy_and_momentum_close_over_a_perforating_shot() {
    // The identity of the balance is exact but for rounding: 300 steps of sums of 45 J in f64, and of f32 state.
    for (precision, energy, momentum) in [(Precision::F64, 1e-11, 1e-9), (Precision::F32, 5e-3, 5e-3)] {
        let run = run_as(&builtin(SMALL, &["/solver/end_time_us=120"]), precision, 2);
        assert!(!run.events.is_empty(), "yarns must fail for this to mean anything");
        closes(&run, [energy, momentum]);
        let last = run.history.last().unwrap().balance;
        assert!(last.failure > 0.0 && last.contact > 0.0 && last.friction > 0.0);
        let mut balances = run.history.iter().map(|row| row.balance);
        assert!(balances.all(|b| b.internal > -0.01 * b.kinetic - 1e-9 && b.hourglass >= 0.0));
    }
}

/// The rim crosses two edges that end at one node, farther away than what is looked at.
#[test]
fn a_rim_over_long_elements_loses_no_momentum() {
    let text = r#"{"title": "long elements", "fabric": {"file": "fabrics/s-728.json"},
        "pack": {"width_mm": 20.32, "height_mm": 17.93, "edges": "free",
            "mesh_grading": {"fine_radius_mm": 0.3756, "growth_ratio": 1.612, "max_crossovers": 4}},
        "projectile": {"shape": "cylinder", "mass_g": 1, "diameter_mm": 5.5, "length_mm": 10, "velocity_m_s": 200},
        "solver": {"end_time_us": 1, "run_until": "end_time", "courant": 0.3}}"#;
    for symmetry in ["auto", "none"] {
        let run = run(&read("long", text, &[&format!("/solver/symmetry={symmetry}")]));
        assert!(run.events.is_empty() && run.history.iter().any(|row| row.balance.contact > 0.1));
        closes(&run, [1e-12; 2]);
    }
}

/// (work − stored)/stored of a strike without failure.
fn work_not_stored(law: &str, courant: f64) -> f64 {
    let sets = [format!("/fabric/crossover/law={law}"), format!("/solver/courant={courant}")];
    let sets = [&sets[0], &sets[1], "/solver/end_time_us=15", "/projectile/velocity_m_s=150"];
    let run = run(&builtin(SMALL, &sets));
    assert!(run.events.is_empty());
    let b = run.history.last().unwrap().balance;
    (b.internal - b.stored) / b.stored
}

#[test]
fn conservative_laws_store_all_the_work_and_the_published_one_nearly_all() {
    // The trapezoidal work of forces with kinks (slack to taut) meets the energy as the step shrinks.
    let (long, short) = (work_not_stored("variational", 0.6), work_not_stored("variational", 0.1));
    assert!(short.abs() < 2.5e-3 && short.abs() < 0.2 * long.abs(), "{long} {short}");
    // (18) is not conjugate to the sinusoid: its work differs from the stored energy whatever the step.
    let published = work_not_stored("published", 0.1);
    assert!((-0.15..-0.005).contains(&published), "{published}");
}

#[test]
fn a_vibrating_ply_keeps_its_energy_over_a_hundred_thousand_steps() {
    let end = "/solver/end_time_us=80300";
    let sets =
        [end, "/solver/courant=0.9", "/output/history_interval_us=100", "/pack/width_mm=50.8", "/pack/height_mm=40.64"];
    let run = run(&builtin("cases/verify/membrane-frequency.json", &sets));
    assert!(run.steps > 100_000, "{}", run.steps);
    assert!(run.energy_error < 1e-6, "{}", run.energy_error);
    // Stored plus kinetic energy without any bookkeeping: bounded oscillation of O((ωΔt)²), no drift. The state is
    // compared by the vibration's own energy, not by that of the pre-tension.
    let energy: Vec<f64> =
        run.history.iter().map(|s| s.balance.kinetic + s.balance.stored + s.balance.hourglass).collect();
    let vibration = run.history.iter().map(|s| s.balance.kinetic).fold(0.0, f64::max);
    let third = energy.len() / 3;
    let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
    let drift = (mean(&energy[2 * third..]) - mean(&energy[..third])).abs() / vibration;
    assert!(vibration > 0.0 && drift < 1e-3, "drift {drift} of {vibration} J");
}

/// Of a body of a kilogram, the fabric takes up a ten thousandth of its energy in 100 µs.
#[test]
fn errors_are_held_against_what_the_fabric_took_up_not_what_the_body_flies_with() {
    let level = |mass: &str, law: &str| {
        let sets = [mass, law, "/solver/numerics=paper", "/solver/end_time_us=100", "/output/profile_times_us=[]"];
        let more = ["/pack/width_mm=40", "/pack/height_mm=40", "/projectile/velocity_m_s=20", "/expect=[]"];
        let case = builtin("cases/s720-1ply-155.json", &[&sets[..], &more].concat());
        let run = run(&case);
        let end = run.history.last().unwrap().balance;
        let taken_up = run.impact_energy - end.projectile;
        assert!(taken_up < 0.02 * run.impact_energy && run.impact_energy > 0.5, "{taken_up} J");
        let share = checks(&case, &run).into_iter().find(|check| check.name == "energy of the unit-cell law").unwrap();
        let gained =
            end.kinetic + end.stored + end.hourglass + end.viscous + end.contact + end.friction - end.law - taken_up;
        assert!((end.gained * taken_up - gained).abs() < 1e-9 * taken_up, "{} of {taken_up} J, {gained} J", end.gained);
        (share.level, end.gained)
    };
    // The published law loses 8 % of what it takes up, whatever the body weighs.
    let gained = ["/projectile/mass_g=30", "/projectile/mass_g=1000"].map(|mass| {
        assert_eq!(level(mass, "/fabric/crossover/law=variational").0, Level::Fine, "{mass}");
        let (found, gained) = level(mass, "/fabric/crossover/law=published");
        assert_eq!(found, Level::Look, "{mass}");
        gained
    });
    assert!((gained[1] / gained[0] - 1.0).abs() < 0.2, "{gained:?}");
}

#[test]
fn fabric_no_wave_has_reached_is_exactly_at_rest() {
    for fabric in [
        "/fabric/crossover/compression=rigid",
        "/fabric/crossover/gap_mm=0.01",
        "/fabric/warp/crimp=0",
        "/fabric/weft/crimp=0.2",
    ] {
        for law in ["published", "variational"] {
            let law_set = format!("/fabric/crossover/law={law}");
            let sets = [law_set.as_str(), fabric, "/projectile/offset_mm=[0,0]", "/projectile/obliquity_deg=0"];
            let case = builtin(SMALL, &sets);
            check_rest::<f64>(&case);
            check_rest::<f32>(&case);
        }
    }
}

fn check_rest<S: RunScalar>(case: &Case) {
    let mut simulation = Simulation::<S>::new(case).unwrap();
    let steps = 8;
    for _ in 0..steps {
        simulation.advance(case);
    }
    let grid = simulation.model.grid;
    let (middle, mut moving) = (grid.columns / 2, false);
    for row in 0..=grid.rows {
        for column in 0..=grid.columns {
            let away = row.abs_diff(grid.rows / 2).max(column.abs_diff(middle));
            let still = (0..field::COUNT).all(|f| simulation.state.nodes.get(row, f, column) == S::splat(0.0));
            // Two rings are under the projectile; information travels one ring a step.
            assert!(still || away <= 3 + steps, "row {row} column {column} moved: {}", case.title);
            moving |= !still;
        }
    }
    assert!(moving);
}

#[test]
fn no_wave_sends_numbers_ahead_that_are_slow_to_compute_with() {
    let case = builtin("cases/s720-1ply-155.json", &[]);
    let mut simulation = Simulation::<f32>::new(&case).unwrap();
    for _ in 0..60 {
        simulation.advance(&case);
    }
    let (nodes, grid) = (&simulation.state.nodes, simulation.model.grid);
    let mut moving = 0;
    for row in 0..grid.node_rows() {
        for column in 0..=grid.columns {
            let speeds = [0, 1, 2].map(|a| nodes.get(row, field::VELOCITY + a, column).abs());
            let places = [0, 1, 2].map(|a| nodes.get(row, field::DISPLACEMENT + a, column));
            assert!(speeds.iter().all(|v| *v == 0.0 || (v * v).is_normal()), "row {row} column {column}: {speeds:?}");
            assert!(places.iter().all(|u| !u.is_subnormal()), "row {row} column {column}: {places:?}");
            moving += usize::from(speeds[2] > 0.0);
        }
    }
    assert!(moving > 300, "{moving}");
}

/// Scenes beside those of `cases/stress`.
#[test]
fn hard_scenes_stay_bounded() {
    let scenes: [&[&str]; 6] = [
        &["/projectile/velocity_m_s=1"],
        &["/projectile/velocity_m_s=10"],
        &["/fabric/weft/modulus_gpa=0.096"],
        &["/projectile/offset_mm=[25.4,0]"],
        &["/projectile/offset_mm=[25.4,20.32]"],
        &["/pack/edges=free", "/projectile/velocity_m_s=2000"],
    ];
    for (sets, precision) in scenes.into_iter().flat_map(|sets| [(sets, Precision::F64), (sets, Precision::F32)]) {
        let run = run_as(&builtin(SMALL, sets), precision, 2);
        let given = run.history[0].balance.projectile + run.history[0].balance.contact;
        for b in run.history.iter().map(|s| s.balance) {
            let sum = b.kinetic + b.internal + b.hourglass + b.failure + b.projectile + b.contact + b.friction;
            assert!(sum.is_finite() && sum < 1.02 * given + 1e-9, "{sets:?} {precision:?}: {b:?}");
            assert!(b.stored >= 0.0 && b.kinetic < 1.02 * given + 1e-9, "{sets:?} {precision:?}: {b:?}");
        }
    }
}

/// All energies by their state functions, and what left, without any bookkeeping. The published law and the kinks between slack and taut
/// at Courant 0.9 invented 1.1 % in 500 µs and some 700 failures when this was written, 2.1 % in a quarter, which invents four times alike.
#[test]
fn a_perforated_ply_runs_on_with_bounded_energy() {
    for (symmetry, allowed) in [("/solver/symmetry=none", 1.02), ("/solver/symmetry=auto", 1.04)] {
        let sets = ["/solver/end_time_us=500", "/projectile/obliquity_deg=0", "/projectile/offset_mm=[0,0]", symmetry];
        let run = run(&builtin(SMALL, &sets));
        assert!(run.events.len() > 10);
        let sum = |s: &Sample| {
            let b = s.balance;
            b.kinetic + b.stored + b.hourglass + b.projectile + b.contact + b.friction + b.failure
        };
        let given = sum(&run.history[0]);
        let most = run.history.iter().map(sum).fold(0.0, f64::max);
        assert!(most < allowed * given, "{given} → {most} J");
        let fabric = |s: &Sample| s.balance.kinetic + s.balance.stored;
        assert!(run.history.iter().all(|s| fabric(s) < given), "the fabric never has more than was given");
    }
}

#[test]
fn a_number_that_is_not_finite_is_found_with_step_kernel_and_place() {
    let case = builtin(SMALL, &[]);
    let mut simulation = Simulation::<f64>::new(&case).unwrap();
    for _ in 0..20 {
        simulation.advance(&case);
    }
    simulation.state.nodes.set(7, field::VELOCITY + 1, 5, f64::NAN);
    let run = finish(simulation, &case);
    let trouble = run.divergence.unwrap();
    assert!(trouble.step >= 20 && trouble.step <= 22, "{trouble:?}");
    assert_eq!(trouble.place[0], 0);
    assert!(trouble.place[1].abs_diff(7) <= 1 && trouble.place[2].abs_diff(5) <= 1, "{trouble:?}");
    assert!(trouble.quantity.contains("NaN"), "{trouble:?}");
}

#[test]
fn too_long_a_step_is_diagnosed_and_produces_no_verdict() {
    // Straight taut yarns reach the bound; a crimped fabric is softer and forgives.
    let case = builtin("cases/verify/strip-uncrimped-155.json", &[]);
    let mut simulation = Simulation::<f64>::new(&case).unwrap();
    std::sync::Arc::make_mut(&mut simulation.model).dt *= 1.05 / 0.9;
    let run = finish(simulation, &case);
    let trouble = run.divergence.expect("a run at Courant 1.05 must not pass as a result");
    assert!(trouble.step > 0 && !trouble.quantity.is_empty());
}

#[test]
fn energy_of_a_drive_does_not_round_the_balance() {
    // The drive's energy is a hundred million times what it does to the fabric: added up with it, the rest would be rounded away, and
    // an error with it.
    let sets = ["/projectile/motion=prescribed", "/projectile/mass_g=1e6", "/solver/end_time_us=3"];
    let run = run(&builtin(SMALL, &[&sets[..], &["/output/history_interval_us=0.05"]].concat()));
    let last = run.history.last().unwrap().balance;
    assert!(last.external > 0.0 && last.projectile > 1e8 * last.external, "{last:?}");
    assert!(0.0 < run.energy_error && run.energy_error < 1e-12, "{}", run.energy_error);
}

#[test]
fn energy_that_steps_too_long_for_it_invent_stops_the_run() {
    // Straight yarns of a bent ply go slack and taut again; near the critical step the leapfrog heats what has kinks. Work and
    // kinetic energy stay in balance: only the energy stored shows it.
    let bent = [
        "/projectile=null",
        "/fabric/weft/crimp=0",
        "/pack/width_mm=5.08",
        "/pack/height_mm=8.89",
        "/pack/edges=clamped",
        "/pack/initial_deflection={\"amplitude_mm\":0.0006,\"warp_half_waves\":0,\"weft_half_waves\":2}",
        "/solver/end_time_us=120",
        "/output/history_interval_us=2",
    ];
    let shoot = |courant: &str| {
        let case = builtin(SMALL, &[&bent[..], &[courant]].concat());
        finish(Simulation::new(&case).unwrap(), &case)
    };
    let long = shoot("/solver/courant=0.99");
    assert!(long.energy_error < 1e-9, "{}", long.energy_error);
    let trouble = long.divergence.expect("energy out of nowhere must not pass as a result");
    assert!(trouble.quantity.starts_with("energy by state functions "), "{trouble:?}");
    assert_eq!(shoot("/solver/courant=0.5").divergence, None);
}

#[test]
fn energy_of_yarns_that_fail_at_once_was_there() {
    // The bulge strains yarns beyond what breaks them: they break in the first step, and what they release was stored.
    let bulge = "/pack/initial_deflection={\"amplitude_mm\":0.5,\"warp_half_waves\":3,\"weft_half_waves\":0}";
    let small =
        ["/projectile=null", "/pack/width_mm=12.7", "/pack/height_mm=5.08", "/fabric/warp/failure_strain=0.005"];
    let run = run(&builtin(SMALL, &[&small[..], &[bulge, "/pack/edges=clamped", "/solver/end_time_us=5"]].concat()));
    let b = &run.history[0].balance;
    assert!((b.internal / b.stored - 1.0).abs() < 1e-9, "{} J of work, {} J stored", b.internal, b.stored);
    let broken = run.history.iter().find(|sample| sample.failed[0] > 0).unwrap();
    assert!(broken.balance.failure > broken.balance.stored, "{broken:?}");
    assert!(run.energy_error < 1e-11, "{}", run.energy_error);
}

#[test]
fn single_precision_follows_double_until_failure() {
    let case = builtin("cases/verify/mirror.json", &["/solver/end_time_us=20", "/projectile/velocity_m_s=150"]);
    let (double, single) = (run(&case), run_as(&case, Precision::F32, 2));
    assert_eq!(double.events.len(), 0, "before the first failure");
    for (a, b) in double.history.iter().zip(&single.history) {
        let apart = (a.projectile_velocity - b.projectile_velocity).abs();
        assert!(apart < 1e-4 * 150.0, "{apart} m/s at {} s", a.time);
    }
    assert!(single.energy_error < 5e-3);
}

/// Everything that a run leaves behind.
#[derive(Debug, PartialEq)]
struct Trace<S> {
    nodes: Vec<S>,
    elements: Vec<S>,
    balances: Vec<Balance>,
    failures: Vec<FailureEvent>,
    /// Evaluations, solved cells, largest residual, elements computed.
    counts: Vec<[f64; 4]>,
}

fn trace<S: RunScalar>(case: &Case, vectors: Vectors, steps: u64) -> Trace<S> {
    let model = Model::<S>::new(case).unwrap();
    let mut state = State::new(case, &model);
    let mut balance = EnergyBalance::default();
    let mut stepper = Stepper::with_vectors(&model, vectors);
    let (mut balances, mut failures, mut counts) = (Vec::new(), Vec::new(), Vec::new());
    for step in 0..steps {
        let totals = stepper.step(&model, &mut state, &mut balance, step.is_multiple_of(3));
        balances.push(balance.balance());
        failures.extend(stepper.failures.iter().copied());
        counts.push([totals.iterations, totals.solved, totals.max_residual, totals.computed as f64]);
    }
    Trace { nodes: state.nodes.data.to_vec(), elements: elements_of(&model, &state), balances, failures, counts }
}

/// Fields of the elements that there are; what vectors write beyond the last column is not one of them.
fn elements_of<S: RunScalar>(model: &Model<S>, state: &State<S>) -> Vec<S> {
    let mesh = &model.ply_type(0).mesh;
    let fields = (0..mesh.rows).flat_map(|row| (0..state.elements.fields).map(move |field| (row, field)));
    fields.flat_map(|(row, field)| (1..=mesh.columns).map(move |at| state.elements.get(row, field, at))).collect()
}

fn same_on_all<S: RunScalar>(case: &Case, steps: u64) {
    let all = Vectors::all();
    let widest = trace::<S>(case, all[0], steps);
    assert!(!widest.failures.is_empty(), "yarns break");
    for vectors in &all[1..] {
        let other = trace::<S>(case, *vectors, steps);
        let names = format!("{} against {}", vectors.name(), all[0].name());
        assert!(other.failures == widest.failures, "failures: {names}");
        assert_eq!(other.counts, widest.counts, "{names}");
        assert!(other.balances == widest.balances, "energies: {names}");
        let differs = |one: &[S], two: &[S]| one.iter().zip(two).position(|(a, b)| a != b);
        assert_eq!(differs(&other.nodes, &widest.nodes), None, "nodes: {names}");
        assert_eq!(differs(&other.elements, &widest.elements), None, "elements: {names}");
    }
}

/// A shot through fabric of an odd size, off centre, so that what has been reached begins and ends anywhere.
fn shot(more: &[&str]) -> Case {
    let size = ["/pack/width_mm=43", "/pack/height_mm=31", "/projectile/velocity_m_s=400"];
    let rest = ["/projectile/offset_mm=[3.1,-2.2]", "/output/profile_times_us=[]", "/expect=[]"];
    builtin("cases/s720-1ply-155.json", &[&size[..], &rest[..], more].concat())
}

#[test]
fn every_kind_of_register_gives_the_same_bits() {
    assert_eq!(Vectors::all().last().unwrap().name(), "scalar");
    let pack = shot(&["/pack/plies=3", "/pack/mesh_grading/fine_radius_mm=5"]);
    for (case, steps) in [(shot(&[]), 130), (shot(&["/fabric/crossover/law=variational"]), 60), (pack, 150)] {
        same_on_all::<f64>(&case, steps);
        same_on_all::<f32>(&case, steps);
    }
}

/// Largest and smallest of pairs in registers like `n` are those of one number alone, to the sign of a zero and whatever is not a
/// number.
fn same_extremes<R: Real>(n: R, name: &str) {
    let values = [0.0, -0.0, 1.0, -1.5, f64::INFINITY, f64::NAN].map(R::Scalar::splat);
    let same = |found: R, one: R::Scalar| {
        let bits = (0..R::LANES).map(|lane| found.lane(lane).to_f64().to_bits());
        assert!(bits.into_iter().all(|bits| bits == one.to_f64().to_bits()), "{name}: not {one:?}");
    };
    for a in values {
        for b in values {
            let (x, y) = (n.broadcast(a), n.broadcast(b));
            same(x.max(y), Real::max(a, b));
            same(x.min(y), Real::min(a, b));
        }
    }
}

fn same_extremes_on_all<S: RunScalar>() {
    for vectors in Vectors::all() {
        match vectors {
            Vectors::None => {}
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Vectors::Avx512(simd) => same_extremes(Pair::of(S::lanes(simd)), vectors.name()),
            #[cfg(all(any(target_arch = "x86", target_arch = "x86_64"), not(feature = "quick-build")))]
            Vectors::Avx2(simd) => same_extremes(Pair::of(S::lanes(simd)), vectors.name()),
            #[cfg(target_arch = "aarch64")]
            Vectors::Neon(simd) => same_extremes(Pair::of(S::lanes(simd)), vectors.name()),
        }
    }
}

#[test]
fn the_largest_and_the_smallest_are_those_of_one_number_alone() {
    same_extremes_on_all::<f64>();
    same_extremes_on_all::<f32>();
}
