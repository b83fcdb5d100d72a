//! Shipped and small scenes with all that a run of them gives, patches of elements, and seeded numbers for the tests.
//!
//! No physics of the solver is repeated here.

pub(crate) mod patch;

use std::fs;
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant, SystemTime};

use ripstop::case::{self, Case, Compression, Law};
use ripstop::output;
use ripstop::run::{Options, Precision, Run, Simulation};
use serde_json::Value;

/// Laws of the solver.
pub(crate) const SOLVER_LAWS: [Law; 2] = [Law::Published, Law::Variational];

/// Compression of the crossover: rigid, and the project's assumed constants (a in m, b in m·N^(1/3)).
pub(crate) const CROSSOVERS: [Option<Compression>; 2] = [None, Some(Compression { a: 1e-4, b: 1e-4 })];

/// Failure strain of Kevlar 129 [-].
pub(crate) const FAILURE_STRAIN: f64 = 0.035;

/// The balances of energy and of momentum close to these errors.
#[track_caller]
pub(crate) fn closes(run: &Run, [energy, momentum]: [f64; 2]) {
    let found = [run.energy_error, run.momentum_error];
    assert!(found[0] < energy && found[1] < momentum, "errors of energy and momentum: {found:?}");
}

/// A number is another to this tolerance.
#[track_caller]
pub(crate) fn near(got: f64, expected: f64, tolerance: f64) {
    assert!((got - expected).abs() <= tolerance, "{got} instead of {expected} ± {tolerance}");
}

/// A number is another to this part of it.
#[track_caller]
pub(crate) fn close(got: f64, expected: f64, relative: f64) {
    near(got, expected, relative * expected.abs());
}

/// SplitMix64: the same numbers on every machine.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// Uniform in [low, high).
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        let unit = ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64;
        low + (high - low) * unit
    }

    /// Three numbers in [−size, size).
    pub(crate) fn vector(&mut self, size: f64) -> [f64; 3] {
        std::array::from_fn(|_| self.between(-size, size))
    }
}

/// The largest of many errors and where it was.
#[derive(Debug, Default)]
pub(crate) struct Worst {
    pub(crate) error: f64,
    pub(crate) place: String,
}

impl Worst {
    /// Takes note of an error; a NaN counts as infinite.
    pub(crate) fn see(&mut self, error: f64, place: impl FnOnce() -> String) {
        let error = if error.is_nan() { f64::INFINITY } else { error.abs() };
        if error > self.error {
            *self = Self { error, place: place() };
        }
    }

    #[track_caller]
    pub(crate) fn assert_at_most(&self, limit: f64) {
        assert!(self.error <= limit, "{:.3e} > {limit:.0e} at {}", self.error, self.place);
    }
}

/// A shipped case on the paper's numerics (one even element per crossover, contact at nodes, no viscosity) with changes, each
/// `/pointer=value`.
pub(crate) fn builtin(path: &str, sets: &[&str]) -> Case {
    shipped(path, &[&["/solver/numerics=paper"], sets].concat())
}

/// A shipped case as it is, with changes, each `/pointer=value`.
pub(crate) fn shipped(path: &str, sets: &[&str]) -> Case {
    let sets: Vec<String> = sets.iter().map(ToString::to_string).collect();
    case::read(Path::new(path), &sets).unwrap_or_else(|e| panic!("{e}"))
}

/// The case of a text, with changes, each `/pointer=value`.
pub(crate) fn read(name: &str, text: &str, sets: &[&str]) -> Case {
    let sets: Vec<String> = sets.iter().map(ToString::to_string).collect();
    case::from_str(name, text, &sets).unwrap_or_else(|e| panic!("{e}"))
}

/// Runs a case in double precision on one thread: tests run beside each other.
pub(crate) fn run(case: &Case) -> Run {
    run_as(case, Precision::F64, 1)
}

/// Runs a case.
pub(crate) fn run_as(case: &Case, precision: Precision, threads: usize) -> Run {
    let options = Options::default().threads(threads).precision(precision);
    let run = options.run(case).unwrap_or_else(|e| panic!("{e}"));
    assert!(run.divergence.is_none(), "{}: {:?}", case.title, run.divergence);
    assert_eq!(run.newton.unconverged, 0, "{}", case.title);
    run
}

/// The run of a simulation that goes on to its end, whatever becomes of it.
pub(crate) fn finish(mut simulation: Simulation<f64>, case: &Case) -> Run {
    while !simulation.finished(case) {
        simulation.advance(case);
    }
    simulation.into_run(1.0)
}

/// Velocity of the projectile at a time by linear interpolation [m/s].
pub(crate) fn velocity_at(run: &Run, time: f64) -> f64 {
    let after = run.history.iter().position(|s| s.time >= time).unwrap_or(run.history.len() - 1);
    let (a, b) = (&run.history[after - 1], &run.history[after]);
    a.projectile_velocity + (b.projectile_velocity - a.projectile_velocity) * (time - a.time) / (b.time - a.time)
}

/// The expectations of a case against its run.
pub(crate) fn checked(case: &Case, run: &Run) -> Vec<Value> {
    output::check(case, run, &output::summary(case, run, 0.0))
}

/// 24 × 16 elements struck off centre and aslant, with failures, friction, rotation, profiles on and between samples.
pub(crate) fn ply() -> Case {
    let sets = ["/pack/width_mm=30.48", "/pack/height_mm=20.32", "/projectile/velocity_m_s=400"];
    let times = ["/solver/end_time_us=36", "/output/profile_times_us=[5,11.03,30]", "/output/history_interval_us=0.7"];
    builtin("cases/verify/mirror.json", &[&sets[..], &times, &["/expect=[]"]].concat())
}

/// Three such plies, one of them turned, that touch and rub.
pub(crate) fn pack() -> Case {
    let layup = r#"/pack/layup=[{"plies":1},{"plies":1,"orientation_deg":30},{"plies":1}]"#;
    let sets = ["/pack/width_mm=25.4", "/pack/height_mm=22.86", "/projectile/velocity_m_s=500", layup];
    let times = ["/solver/end_time_us=26", "/output/history_interval_us=0.7"];
    builtin("cases/verify/mirror.json", &[&sets[..], &times, &["/expect=[]"]].concat())
}

/// Two plies struck in the middle, of which a quarter is computed; the run ends with its outcome.
pub(crate) fn quarter() -> Case {
    let size = ["/pack/width_mm=25.4", "/pack/height_mm=25.4", "/pack/plies=2", "/expect=[]", "/solver/end_time_us=80"];
    let shot = ["/projectile/length_mm=5", "/projectile/mass_g=0.3", "/projectile/velocity_m_s=60"];
    let profile = "/output/profile_times_us=[20]";
    builtin("cases/s720-1ply-155.json", &[&size[..], &shot, &[profile]].concat())
}

/// Everything a run computed, every digit.
pub(crate) fn result(case: &Case, run: &Run) -> Vec<String> {
    let Run { history, events, profiles, ply_history, .. } = run;
    let rows = history.iter().map(|row| format!("{row:?}"));
    let events = events.iter().map(|event| format!("{event:?}"));
    let profiles = profiles.iter().map(|profile| format!("{profile:?}"));
    let plies = ply_history.iter().map(|ply| format!("{ply:?}"));
    let summary = without_costs(output::summary(case, run, 0.0));
    rows.chain(events).chain(profiles).chain(plies).chain([summary.to_string()]).collect()
}

/// A summary without what the run cost.
pub(crate) fn without_costs(mut summary: Value) -> Value {
    for cost in ["loop_s", "host_overhead_s", "wall_s", "element_steps_per_s", "threads", "timings"] {
        summary.as_object_mut().unwrap().remove(cost).unwrap_or_else(|| panic!("{cost}"));
    }
    summary
}

/// Every file of a finished run by name, byte by byte, but for what the run cost; those of folders within, too.
pub(crate) fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let (name, path) = (entry.file_name().into_string().unwrap(), entry.path());
        if path.is_dir() {
            files.extend(self::files(&path).into_iter().map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)));
            continue;
        }
        let bytes = fs::read(&path).unwrap();
        let bytes = match name.as_str() {
            "summary.json" => without_costs(serde_json::from_slice(&bytes).unwrap()).to_string().into_bytes(),
            "report.html" => without_machine(&bytes).to_vec(),
            _ => bytes,
        };
        files.push((name, bytes));
    }
    files.sort();
    files
}

/// A report up to its last section, which has the cost of the run.
fn without_machine(page: &[u8]) -> &[u8] {
    let mark = b"id=\"machine\"";
    &page[..page.windows(mark.len()).position(|part| part == mark).unwrap()]
}

/// The files of two runs are the same.
#[track_caller]
pub(crate) fn same_files(one: &[(String, Vec<u8>)], two: &[(String, Vec<u8>)]) {
    let names = |files: &[(String, Vec<u8>)]| files.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
    assert_eq!(names(one), names(two));
    for ((name, one), (_, two)) in one.iter().zip(two) {
        let first =
            one.split(|byte| *byte == b'\n').zip(two.split(|byte| *byte == b'\n')).find(|(one, two)| one != two);
        let words = first.map(|(one, two)| {
            [one, two].map(|line| String::from_utf8_lossy(&line[..line.len().min(200)]).into_owned())
        });
        assert!(one == two, "{name}: {} and {} bytes, {words:?}", one.len(), two.len());
    }
}

/// Waits until a file is there and another than before; when it was written.
pub(crate) fn wait_for_another(path: &Path, before: Option<SystemTime>) -> Option<SystemTime> {
    let patience = Instant::now() + Duration::from_secs(120);
    while Instant::now() < patience {
        let now = path.metadata().and_then(|file| file.modified()).ok();
        if now.is_some() && now != before {
            return now;
        }
        thread::sleep(Duration::from_millis(1));
    }
    panic!("{} does not change", path.display());
}

/// A patch of a ply that flies ahead of the projectile, torn out or held on one side.
pub(crate) mod torn {
    use ripstop::case::Case;
    use ripstop::model::Model;
    use ripstop::num::scalar::Scalar;
    use ripstop::solver::element_totals::field as element;
    use ripstop::solver::node_update::field as node;
    use ripstop::solver::state::State;

    use super::builtin;

    /// Half the width of the patch [elements]; its yarns run on for long enough to cover.
    pub(crate) const SEAM: isize = 20;

    /// A ply of 80 by 80 even elements, with nothing asked of it.
    pub(crate) const PLY: &[&str] = &[
        "/pack/width_mm=101.6",
        "/pack/height_mm=101.6",
        "/pack/elements_per_crossover=1",
        "/pack/mesh_grading=none",
        "/solver/contact_sampling=nodes",
        "/output/profile_times_us=[]",
        "/expect=[]",
    ];

    /// A projectile that flies slowly behind a ply, and touches nothing before the end.
    pub(crate) fn case(sets: &[&str]) -> Case {
        let slow = [
            "/projectile/velocity_m_s=20",
            "/projectile/standoff_mm=2",
            "/pack/initial_velocity_m_s=[0, 0, 150]",
            "/solver/end_time_us=70",
        ];
        builtin("cases/s720-1ply-155.json", &[PLY, &slow, sets].concat())
    }

    /// The larger of the distances of an element from the middle of the ply, in elements.
    pub(crate) fn ring(r: isize, c: isize) -> isize {
        let away = |at: isize| if at < 0 { -at - 1 } else { at };
        away(r).max(away(c))
    }

    /// Cuts the yarns that `is_cut` names by row, column from the pack's centre, and yarn.
    pub(crate) fn cut<S: Scalar>(model: &Model<S>, state: &mut State<S>, is_cut: impl Fn(isize, isize, usize) -> bool) {
        let mesh = &model.ply_type(0).mesh;
        let [column_0, row_0] = mesh.centre().map(|line| line as isize);
        for (row, column) in (0..mesh.rows).flat_map(|row| (0..mesh.columns).map(move |column| (row, column))) {
            for yarn in (0..2).filter(|yarn| is_cut(row as isize - row_0, column as isize - column_0, *yarn)) {
                state.elements.set(row, element::ALIVE + yarn, column + 1, S::splat(0.0));
            }
        }
    }

    /// Sets a field of the nodes for which `value` has a number, by row and column from the pack's centre.
    pub(crate) fn put<S: Scalar>(
        model: &Model<S>,
        state: &mut State<S>,
        field: usize,
        value: impl Fn(isize, isize) -> Option<f64>,
    ) {
        let mesh = &model.ply_type(0).mesh;
        let [column_0, row_0] = mesh.centre().map(|line| line as isize);
        for (row, column) in (0..=mesh.rows).flat_map(|row| (0..=mesh.columns).map(move |column| (row, column))) {
            if let Some(value) = value(row as isize - row_0, column as isize - column_0) {
                state.nodes.set(row, field, column, S::splat(value));
            }
        }
    }

    /// Tears the patch out on three sides, and on the fourth where `loose` says so. The rest is at rest, but for a node in a corner
    /// that tears itself off: without a yarn that failed on the way nothing perforates.
    pub(crate) fn tear<S: Scalar>(model: &Model<S>, state: &mut State<S>, loose: bool) {
        cut(model, state, |r, c, _| ring(r, c) == SEAM && (c != -SEAM - 1 || loose));
        put(model, state, node::VELOCITY + 2, |r, c| (r.abs().max(c.abs()) > SEAM).then_some(0.0));
        state.nodes.set(2, node::VELOCITY + 2, 2, S::splat(3000.0));
    }
}
