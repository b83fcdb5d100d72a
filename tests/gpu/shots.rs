//! Whole runs on the device.
//!
//! Promises: up to the first broken yarn a shot is the processor's to 1e-4 of the impact velocity; after that the first failures and
//! the outcome are the same and integral quantities agree; a run gives the same bits every time, for every batch length and
//! whatever is left out at rest; a part of a symmetric scene is the whole; no failure is lost.
//! Red when: a kernel, the energy balance, the order of stages or the host loop of the GPU backend differs from the processor's.

mod endings;
mod references;

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;

use libtest_mimic::Trial;
use ripstop::case::{Case, ContactSampling};
use ripstop::gpu::Device;
use ripstop::run::device::DeviceSimulation;
use ripstop::run::{self, Options, Precision, Run, Skips};

use super::harness::{Outcome, trial};
use crate::support::{self, builtin, result, run, run_as, shipped};

/// Tests by name.
type Tests = &'static [(&'static str, fn(&'static Device) -> Outcome)];

/// The longest first, so that no thread is left alone with it.
const TESTS: Tests = &[
    ("shots_are_the_processors_until_yarns_break_and_break_the_same", features),
    ("neither_batches_nor_rest_nor_chance_change_a_bit", same_bits),
    ("a_part_is_the_whole_and_the_processors_part", parts),
];

/// The tests.
pub(crate) fn tests() -> Vec<Trial> {
    let named = |(name, test): &(&str, fn(&'static Device) -> Outcome)| trial(format!("shots::{name}"), *test);
    references::TESTS.iter().chain(TESTS).chain(endings::TESTS).map(named).collect()
}

fn begun<'a>(device: &'a Device, case: &Case, skips: Skips) -> DeviceSimulation<'a> {
    DeviceSimulation::with_skips(case, device, skips).unwrap_or_else(|e| panic!("{}: {e}", case.name))
}

/// Results of a simulation at its end.
fn to_its_end(case: &Case, mut simulation: DeviceSimulation<'_>) -> Run {
    while !simulation.finished() {
        simulation.advance(case);
    }
    sound(case, simulation.into_run(1.0))
}

/// Runs a case on the device, to its end.
fn run_on(device: &Device, case: &Case) -> Run {
    sound(case, run_until(device, case, &AtomicBool::new(false)))
}

/// Runs a case on the device until it ends or is interrupted.
fn run_until(device: &Device, case: &Case, interrupt: &AtomicBool) -> Run {
    let options = Options::default().threads(1).device(device);
    run::run(case, options, interrupt, &mut ()).unwrap_or_else(|e| panic!("{}: {e}", case.name))
}

/// A run that nothing cut short, with every unit cell solved.
#[track_caller]
fn sound(case: &Case, run: Run) -> Run {
    assert!(run.divergence.is_none() && run.lost.is_none(), "{}: {:?} {:?}", case.title, run.divergence, run.lost);
    assert_eq!((run.newton.unconverged, run.backend), (0, "gpu"), "{}", case.title);
    failures_add_up(case, &run);
    run
}

/// Step, ply, row, column and yarn of each failure.
fn places(run: &Run) -> Vec<(u64, u32, u32, u32, u8)> {
    run.events.iter().map(|e| (e.step, e.ply, e.j, e.i, e.yarn)).collect()
}

/// Every failure once and in order, and the counts of the last row are those of the list.
#[track_caller]
fn failures_add_up(case: &Case, run: &Run) {
    let places = places(run);
    assert!(places.windows(2).all(|pair| pair[0] < pair[1]), "not in order of step, element, yarn: {places:?}");
    let mut broken = BTreeMap::<_, [u64; 2]>::new();
    places.iter().for_each(|p| broken.entry((p.1, p.2, p.3)).or_default()[usize::from(p.4)] += 1);
    assert!(broken.values().flatten().all(|count| *count < 2), "a yarn of an element breaks once");
    // The last step is a sample, so that the last row counts every failure.
    let last = run.history.last().unwrap();
    let sums: [u64; 2] = [0, 1].map(|yarn| broken.values().map(|of: &[u64; 2]| of[yarn]).sum::<u64>());
    assert_eq!(last.failed, sums, "failures lost or invented");
    let woven = u64::from(case.fabric.warp.present) + u64::from(case.fabric.weft.present);
    let bare = broken.values().filter(|of| of.iter().sum::<u64>() == woven).count() as u64;
    assert_eq!(last.eroded, bare, "eroded is what has lost every yarn");
}

/// Faults of many scenes together.
fn report(wrong: Vec<String>) -> Outcome {
    if wrong.is_empty() { Ok(()) } else { Err(wrong.join("\n")) }
}

/// Rows up to the first failure of either run.
fn unbroken<'a>(one: &'a Run, two: &'a Run) -> impl Iterator<Item = (&'a run::Sample, &'a run::Sample)> {
    let first = |run: &Run| run.events.first().map_or(f64::INFINITY, |e| e.step as f64 * run.time_step);
    let broken = first(one).min(first(two));
    one.history.iter().zip(&two.history).take_while(move |(row, _)| row.time <= broken)
}

/// Whether velocities up to the first failure are the same, in more than `least` rows.
fn same_until_failure(one: &Run, two: &Run, impact: f64, least: usize) -> Outcome {
    assert_eq!(one.time_step, two.time_step);
    if unbroken(one, two).count() <= least {
        return Err(format!("{} rows before the first failure", unbroken(one, two).count()));
    }
    let off = |(a, b): &(&run::Sample, &run::Sample)| (a.projectile_velocity - b.projectile_velocity).abs();
    let wrong = unbroken(one, two).find(|rows| rows.0.time != rows.1.time || off(rows) > 1e-4 * impact);
    wrong.map_or(Ok(()), |rows| Err(format!("{} m/s at {} s, before the first failure", off(&rows), rows.0.time)))
}

/// The first `least` failures of two runs are the same.
fn same_failures(one: &Run, two: &Run, least: usize) -> Outcome {
    let [one, two] = [one, two].map(places);
    let same = one.iter().zip(&two).take_while(|(a, b)| a == b).count();
    let next = || format!("{same} of {} failures are the same; {:?} for {:?}", one.len(), two.get(same), one.get(same));
    if same >= least { Ok(()) } else { Err(next()) }
}

/// Largest errors of energy and of momentum.
const ERRORS: [f64; 2] = [2e-6; 2];

/// Largest errors of a run in single precision.
fn within(run: &Run, [energy, momentum]: [f64; 2]) -> Outcome {
    let found = format!("energy error {:e}, momentum error {:e}", run.energy_error, run.momentum_error);
    if run.energy_error <= energy && run.momentum_error <= momentum { Ok(()) } else { Err(found) }
}

fn impact(case: &Case) -> f64 {
    case.projectile.as_ref().unwrap().velocity
}

const EDGES: &str = "/solver/contact_sampling=edges";
const ASIDE: &str = "/projectile/offset_mm=[4,-3]";
const PAIR: [&str; 2] = ["/pack/plies=2", "/pack/layup=[{},{\"orientation_deg\":90}]"];

/// Plies in touch at rest, with gaps between them, of two fabrics and turned, in a round window.
const PACKS: [(&str, &[&str]); 4] = [
    ("touching plies", &["/pack/plies=3"]),
    (
        "plies in a round window",
        &[
            "/pack/window={\"diameter_mm\":24}",
            r#"/pack/layup=[{},{"orientation_deg":30},{"orientation_deg":90,"standoff_mm":0.2}]"#,
        ],
    ),
    ("plies with gaps", &["/pack/plies=3", "/pack/spacing_mm=0.45"]),
    (
        "turned plies",
        &[r#"/pack/layup=[{},{"orientation_deg":30,"edges":"free"},
            {"orientation_deg":90,"fabric":{"name":"coarse","fibre_density_kg_m3":1440,"areal_density_g_m2":190,
                "thickness_mm":0.2,
                "warp":{"linear_density_denier":1420,"modulus_gpa":96,"failure_strain":0.035,"count_per_inch":17,"crimp":0.02},
                "weft":{"linear_density_denier":1420,"modulus_gpa":96,"failure_strain":0.035,"count_per_inch":15,"crimp":0.02},
                "crossover":{"law":"published","gap_mm":0,"compression":{"a_mm":0.1,"b_mm_n13":0.1}},
                "shear":{"g1_mpa":10,"g2_mpa":1000,"gamma1":0.35,"gamma2":0.6}}}]"#],
    ),
];

/// An oblique shot at 300 m/s on a small pack.
fn packed(pack: &[&str], more: &[&str]) -> Case {
    let small =
        ["/pack/width_mm=30", "/pack/height_mm=25", "/solver/end_time_us=16", "/output/history_interval_us=0.25"];
    builtin("cases/verify/mirror.json", &[&small[..], pack, more].concat())
}

/// 40 × 32 crossovers in elements that grow away from the hit.
fn graded(sets: &[&str]) -> Case {
    let size = ["/pack/width_mm=50.8", "/pack/height_mm=40.64", "/expect=[]", "/output/profile_times_us=[]"];
    let mesh = ["/pack/mesh_grading={\"fine_radius_mm\":5,\"growth_ratio\":1.3}"];
    let shot = ["/projectile/length_mm=8", "/projectile/mass_g=1", "/projectile/velocity_m_s=400"];
    let run = ["/solver/end_time_us=9", "/output/history_interval_us=0.05"];
    builtin("cases/s720-1ply-155.json", &[&size[..], &mesh, &shot, &run, sets].concat())
}

/// Two elements a crossover, and half the projectile: llvmpipe ends every loop of a kernel after 65 535 turns of all of them, which solves of
/// more points at an edge exceed.
fn finer(sets: &[&str]) -> Case {
    let own = [
        "/pack/elements_per_crossover=2",
        "/pack/mesh_grading={\"fine_radius_mm\":2.5,\"growth_ratio\":1.3}",
        "/projectile/diameter_mm=2.75",
        "/solver/end_time_us=6",
    ];
    graded(&[&own[..], sets].concat())
}

/// A small ply and a small pack, one ply turned, that tear.
fn torn() -> [Case; 2] {
    [support::ply(), support::pack()].map(|mut case| {
        case.solver.contact_sampling = ContactSampling::Edges;
        (case.solver.end_time, case.output.history_interval) = (12e-6, 0.2e-6);
        case.output.profile_times.clear();
        case
    })
}

/// Scenes, with the rows before a failure and the first failures that must be the same at least.
fn scenes() -> Vec<(String, Case, [usize; 2])> {
    let mut all = vec![(
        "violent".to_owned(),
        builtin("cases/verify/mirror.json", &["/projectile/velocity_m_s=600", "/solver/end_time_us=10"]),
        [0, 20],
    )];
    all.extend(torn().map(|case| (format!("edges, {} plies", case.pack.plies), case, [1, 20])));
    all.extend(PACKS.map(|(name, pack)| (name.to_owned(), packed(pack, &[]), [8, 0])));
    for sets in [&[ASIDE, EDGES][..], &PAIR] {
        all.push((format!("graded, {sets:?}"), finer(sets), [8, 4]));
    }
    all
}

fn features(device: &'static Device) -> Outcome {
    let mut wrong = Vec::new();
    for (name, case, [rows, failures]) in scenes() {
        let precision = if name == "violent" { Precision::F64 } else { Precision::F32 };
        let (cpu, gpu) = (run_as(&case, precision, 2), run_on(device, &case));
        assert_eq!(cpu.planes, gpu.planes, "{name}");
        let checks = [
            same_until_failure(&cpu, &gpu, impact(&case).min(400.0), rows),
            same_failures(&cpu, &gpu, failures),
            within(&gpu, ERRORS),
        ];
        wrong.extend(checks.into_iter().filter_map(Result::err).map(|line| format!("{name}: {line}")));
        if case.pack.plies > 1 {
            let contact = gpu.history.last().map_or(0.0, |row| row.balance.contact + row.balance.friction);
            assert!(contact > 0.0, "{name}: nothing touches");
        }
        if name.starts_with("edges") {
            let mut nodes = case.clone();
            nodes.solver.contact_sampling = ContactSampling::Nodes;
            assert!(places(&run_on(device, &nodes)) != places(&gpu), "{name}: as if nodes alone were met");
        }
    }
    // The face is wider than the ply: its edge crosses sides between two held nodes, and between a held and a free one.
    let small = ["/pack/width_mm=3.81", "/pack/height_mm=6.35", "/projectile/friction=0.3", "/solver/end_time_us=12"];
    let sets = [&small[..], &[EDGES, "/expect=[]", "/output/profile_times_us=[]"]].concat();
    let case = builtin("cases/s720-1ply-155.json", &sets);
    let (cpu, gpu) = (run(&case), run_on(device, &case));
    let [c, g] = [&cpu, &gpu].map(|run| run.history.last().unwrap().projectile_velocity);
    assert!((c - g).abs() < 2e-2 * 155.0, "across clamps: {g} for {c} m/s");
    wrong.extend(within(&gpu, ERRORS).err());
    // A tip that pushes held nodes, which count as a thousand bodies: the motion found has four digits less there than what moves.
    let case = shipped("cases/stress/oblique-tip.json", &["/solver/end_time_us=26", "/expect=[]"]);
    wrong.extend(within(&run_on(device, &case), ERRORS).err());
    report(wrong)
}

/// Every row and every failure, every digit.
#[track_caller]
fn equal(case: &Case, one: &Run, two: &Run, what: &str) {
    let [one, two] = [one, two].map(|run| result(case, run));
    let other = one.iter().zip(&two).find(|(one, two)| one != two);
    assert!(other.is_none() && one.len() == two.len(), "{}, {what}: {other:?}", case.name);
}

fn same_bits(device: &'static Device) -> Outcome {
    let mirror = ["/output/profile_times_us=[10,30.03,50]", "/output/history_interval_us=0.7"];
    // A long strip: the wave takes most of the run to its ends. Yarns break in the middle meanwhile.
    let strip =
        ["/pack/width_mm=30", "/projectile/velocity_m_s=400", "/solver/end_time_us=16", "/output/profile_times_us=[]"];
    let wide = ["/pack/width_mm=60", "/pack/height_mm=50", "/solver/end_time_us=9"];
    let [ply, pack] = torn();
    // Scene, batch lengths, and the part of the elements that is at rest at least.
    let mut scenes: Vec<(Case, &[usize], f64)> = vec![
        (builtin("cases/verify/mirror.json", &mirror), &[7], 0.0),
        (builtin("cases/s720-1ply-155.json", &strip), &[], 0.25),
        (ply, &[1, 256], 0.0),
        (pack, &[7], 0.0),
        (graded(&[ASIDE]), &[7], 0.0),
        (graded(&[PAIR[0], PAIR[1], ASIDE, EDGES]), &[7], 0.0),
    ];
    let window = "/pack/window={\"diameter_mm\":48}";
    let wider = |pack: &[&str]| {
        if pack[0].contains("window") { packed(pack, &[&wide[..], &[window]].concat()) } else { packed(pack, &wide) }
    };
    // In a round window, and of two fabrics: plies in touch and with gaps are parts of these.
    scenes.extend([1, 3].map(|at: usize| (wider(PACKS[at].1), &[7][..], 0.3)));
    for (case, lengths, rest) in scenes {
        let once = run_on(device, &case);
        assert!(once.events.len() > 10 || rest > 0.0, "{}", once.events.len());
        if lengths.is_empty() {
            equal(&case, &once, &run_on(device, &case), "the second time");
        }
        for steps in lengths {
            let simulation = begun(device, &case, Skips::default()).with_batch(*steps);
            equal(&case, &once, &to_its_end(&case, simulation), &format!("batches of {steps} steps"));
        }
        let skips = [Skips::WHOLE, Skips { wavefront: false, ..Skips::WHOLE }];
        let [part, whole] = skips.map(|skips| to_its_end(&case, begun(device, &case, skips)));
        assert!(part.events == whole.events && format!("{:?}", part.history) == format!("{:?}", whole.history));
        assert_eq!(whole.element_steps_computed, whole.steps * whole.elements as u64);
        let saved = 1.0 - part.element_steps_computed as f64 / whole.element_steps_computed as f64;
        assert!(saved >= rest, "{saved} at rest");
    }
    Ok(())
}

/// Halves and quarters of scenes; after the first ones with contact at edges, and in graded meshes, where yarns break.
fn parts(device: &'static Device) -> Outcome {
    const NODES: usize = 3;
    let size = ["/pack/width_mm=30.48", "/pack/height_mm=25.4", "/expect=[]", "/output/profile_times_us=[]"];
    let shot =
        ["/projectile/length_mm=8", "/projectile/mass_g=1", "/projectile/velocity_m_s=200", "/solver/end_time_us=9"];
    let small = |sets: &[&str]| builtin("cases/s720-1ply-155.json", &[&size[..], &shot, sets].concat());
    let scenes = [
        (small(&[]), 4),
        (small(&["/projectile/offset_mm=[2.54,0]"]), 2),
        (small(&PAIR), 4),
        (small(&["/backing={}"]), 4),
        (small(&["/projectile/obliquity_deg=20", "/projectile/azimuth_deg=90", EDGES]), 2),
        (small(&[PAIR[0], PAIR[1], EDGES]), 4),
        (graded(&[]), 4),
        (graded(&PAIR), 4),
        (graded(&[EDGES]), 4),
    ];
    let mut wrong = Vec::new();
    for (number, (case, copies)) in scenes.into_iter().enumerate() {
        let [part, whole] =
            [Skips::default(), Skips::WHOLE].map(|skips| to_its_end(&case, begun(device, &case, skips)));
        let processor = run_as(&case, Precision::F32, 2);
        assert_eq!((part.planes.copies(), whole.planes.copies(), processor.planes), (copies, 1, part.planes));
        assert_eq!((part.elements, part.steps, part.history.len()), (whole.elements, whole.steps, whole.history.len()));
        wrong.extend(within(&part, ERRORS).err().map(|line| format!("scene {number}: {line}")));
        for (name, other) in [("whole", &whole), ("processor", &processor)] {
            if number >= NODES {
                let found = same_until_failure(other, &part, impact(&case), 8).err();
                wrong.extend(found.map(|line| format!("scene {number}, {name}: {line}")));
                continue;
            }
            assert!(part.element_steps_computed * copies <= whole.element_steps_computed + 64 * whole.steps);
            let off = part.history.iter().zip(&other.history).find_map(|(p, o)| {
                let off = [
                    (p.projectile_velocity - o.projectile_velocity) / 200.0,
                    (p.balance.kinetic - o.balance.kinetic) / 20.0,
                    (p.balance.contact - o.balance.contact) / 20.0,
                    (p.balance.friction - o.balance.friction) / 20.0,
                    (p.deflection - o.deflection) / 2e-3,
                ];
                off.iter().any(|off| off.abs() > 2e-4).then(|| format!("at {} s: {off:?}", p.time))
            });
            wrong.extend(off.map(|line| format!("scene {number}, {name}: {line}")));
        }
    }
    report(wrong)
}
