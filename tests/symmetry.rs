//! The same shot with fewer elements: a half or a quarter of a symmetric scene, and graded meshes, whose elements grow away from the hit;
//! and scenes that are images of each other.
//!
//! Promises: mirrored shots, and shots with warp and weft exchanged, are the same shot; a scene is cut exactly where it is its own mirror
//! image; the run of the part gives the history, the failures and the profiles of the whole to round-off, for one ply and for packs, even
//! and graded, against clay, in f64 and f32; the paper's shot computes at most a quarter of what there is; the case and the caller can ask
//! for the whole. Without growth a graded mesh is the even one, to the last bit, one ply or a pack; whatever the growth, area and mass are
//! those of the even mesh, energy and momentum close, and waves run at the speeds of the even mesh.
//! Red when: a plane is taken that is none, a mass or an impulse on a plane is not its share, a sum is not made whole, a failure has
//! no image, contact between plies looks across a plane; an element's size misses in its strain, its forces, its hourglass stiffness, its
//! energy or its nodes' masses.

use ripstop::case::{Case, Opening};
use ripstop::model::Model;
use ripstop::model::mesh::Mesh;
use ripstop::output::{self, csv};
use ripstop::physics::rigid_body::MirrorPlanes;
use ripstop::run::{Options, Precision, Run, Skips};
use serde_json::json;

use crate::support::{builtin, checked, closes, near, run, shipped};

const PAPER: &str = "cases/s720-1ply-155.json";

/// A small ply, 24 × 20 elements, struck in the middle.
fn small(sets: &[&str]) -> Case {
    let size = ["/pack/width_mm=30.48", "/pack/height_mm=25.4", "/expect=[]", "/output/profile_times_us=[6]"];
    let shot = ["/projectile/length_mm=8", "/projectile/mass_g=1", "/projectile/velocity_m_s=300"];
    let run = ["/solver/end_time_us=14", "/solver/run_until=end_time"];
    builtin(PAPER, &[&size[..], &shot, &run, sets].concat())
}

/// 40 × 32 elements of which most are far from the projectile, for longer.
fn large(sets: &[&str]) -> Case {
    let size =
        ["/pack/width_mm=50.8", "/pack/height_mm=40.64", "/output/profile_times_us=[]", "/solver/end_time_us=25"];
    small(&[&size[..], sets].concat())
}

fn planes(sets: &[&str]) -> [bool; 2] {
    Model::<f64>::part(&small(sets)).unwrap().planes.0
}

#[test]
fn a_scene_is_cut_where_it_is_its_own_mirror_image() {
    const BOTH: [bool; 2] = [true, true];
    const X: [bool; 2] = [true, false];
    const Y: [bool; 2] = [false, true];
    const NONE: [bool; 2] = [false, false];
    let scenes: [(&[&str], [bool; 2]); 28] = [
        (&[], BOTH),
        (&["/solver/symmetry=none"], NONE),
        (&["/projectile/offset_mm=[1.27,0]"], Y),
        (&["/projectile/offset_mm=[0,-0.1]"], X),
        (&["/pack/width_mm=31.75"], Y), // 25 columns: the plane runs through cells
        (&["/pack/height_mm=24.13"], X),
        (&["/projectile/obliquity_deg=20"], Y),
        (&["/projectile/obliquity_deg=20", "/projectile/azimuth_deg=90"], X),
        (&["/projectile/obliquity_deg=20", "/projectile/azimuth_deg=45"], NONE),
        (&["/projectile/yaw_deg=5"], Y),
        (&["/projectile/angular_velocity_rad_s=[100,0,0]"], X),
        (&["/projectile/angular_velocity_rad_s=[0,100,0]"], Y),
        (&["/projectile/angular_velocity_rad_s=[0,0,100]"], NONE),
        (&["/projectile/angular_velocity_rad_s=[0,0,100]", "/projectile/rotation=locked"], BOTH),
        (&["/projectile/shape=fragment"], BOTH),
        (&["/projectile/shape=fragment", "/projectile/roll_deg=30"], NONE),
        (&["/projectile/shape=fragment", "/projectile/obliquity_deg=20"], Y),
        (&["/pack/edges={\"left\":\"free\"}"], Y),
        (&["/pack/edges={\"top\":\"roller\"}"], X),
        (&["/pack/initial_velocity_m_s=[1,0,0]", "/pack/edges=free"], Y),
        (&[ARCH, "/pack/initial_deflection/warp_half_waves=1", "/projectile/standoff_mm=1"], BOTH),
        (&[ARCH, "/pack/initial_deflection/warp_half_waves=2", "/projectile/standoff_mm=1"], Y),
        (&[ARCH, "/pack/initial_deflection/weft_half_waves=4", "/projectile/standoff_mm=1"], X),
        (&["/pack/plies=2", "/pack/layup=[{},{\"orientation_deg\":90}]"], BOTH),
        (&["/pack/plies=2", "/pack/layup=[{},{\"orientation_deg\":30}]"], NONE),
        (&["/pack/plies=2", "/pack/layup=[{},{\"edges\":{\"left\":\"free\"}}]"], Y),
        (&["/pack/plies=2", "/pack/layup=[{},{\"orientation_deg\":90,\"edges\":{\"left\":\"free\"}}]"], X),
        (&["/pack/plies=2", "/pack/layup=[{},{\"orientation_deg\":-180,\"edges\":{\"top\":\"free\"}}]"], X),
    ];
    for (sets, expected) in scenes {
        assert_eq!(planes(sets), expected, "{sets:?}");
    }
    assert_eq!(Model::<f64>::new(&small(&[])).unwrap().planes, MirrorPlanes::NONE, "the whole is asked for");
}

const ARCH: &str = "/pack/initial_deflection={\"amplitude_mm\":0.5,\"warp_half_waves\":1,\"weft_half_waves\":1}";

fn skipping(case: &Case, skips: Skips, precision: Precision) -> Run {
    let options = Options::default().threads(2).precision(precision).skips(skips);
    let run = options.run(case).unwrap();
    assert!(run.divergence.is_none(), "{:?}", run.divergence);
    run
}

/// The run of the part against that of the whole: every column of the history within `allowed` of its largest value, the same
/// failures, and what a summary counts.
fn agree(case: &Case, precision: Precision, parts: u64, allowed: f64) -> [Run; 2] {
    let [part, whole] = [Skips::default(), Skips::WHOLE].map(|skips| skipping(case, skips, precision));
    assert_eq!((part.planes.copies(), whole.planes.copies()), (parts, 1));
    assert_eq!((part.elements, part.steps), (whole.elements, whole.steps));
    assert!(part.element_steps_computed * parts <= whole.element_steps_computed + 64 * whole.steps);
    assert_eq!(part.history.len(), whole.history.len());
    for (name, read) in csv::COLUMNS.iter().filter(|(name, _)| !name.ends_with("_error") && *name != "energy_gained") {
        let scale = whole.history.iter().map(|row| read(row).abs()).fold(0.0, f64::max);
        for (p, w) in part.history.iter().zip(&whole.history) {
            let off = (read(p) - read(w)).abs();
            assert!(off <= allowed * scale, "{name} is {off:e} of {scale:e} off at {} s", w.time);
        }
    }
    let places = |run: &Run| run.events.iter().map(|e| (e.step, e.ply, e.j, e.i, e.yarn)).collect::<Vec<_>>();
    assert_eq!(places(&part), places(&whole));
    assert_eq!(part.profiles.len(), whole.profiles.len());
    for (p, w) in part.profiles.iter().zip(&whole.profiles) {
        assert_eq!(p.points.len(), w.points.len());
        for (p, w) in p.points.iter().zip(&w.points) {
            let close = |a: f64, b: f64, scale: f64| (a - b).abs() <= (1e2 * allowed).min(1e-2) * scale;
            assert!(close(p.reference, w.reference, 1e-2) && close(p.position, w.position, 1e-2), "{p:?} {w:?}");
            assert!(close(p.deflection, w.deflection, 1e-3) && close(p.strain, w.strain, 1e-2), "{p:?} {w:?}");
            assert!(close(p.force, w.force, 1e5), "{p:?} {w:?}");
        }
    }
    for (p, w) in part.ply_history.iter().zip(&whole.ply_history) {
        assert_eq!((p.time, p.ply, p.failed), (w.time, w.ply, w.failed));
        assert!((p.moment.kinetic - w.moment.kinetic).abs() <= 1e2 * allowed * part.impact_energy);
    }
    assert_eq!(part.ply_history.len(), whole.ply_history.len());
    assert!((part.impact_energy / whole.impact_energy - 1.0).abs() < 1e-12);
    assert!((part.max_penetration - whole.max_penetration).abs() <= allowed * 1e-2);
    assert!(part.momentum_error <= 10.0 * whole.momentum_error + 1e-10, "{}", part.momentum_error);
    [part, whole]
}

#[test]
fn a_quarter_and_a_half_give_the_history_of_the_whole() {
    agree(&small(&["/projectile/velocity_m_s=150", "/solver/end_time_us=10"]), Precision::F32, 4, 1e-3);
    let torn = |case: &Case, parts| {
        let [part, _] = agree(case, Precision::F64, parts, 1e-7);
        assert!(part.events.len() >= 8, "{} failures", part.events.len());
    };
    torn(&small(&[]), 4);
    torn(&small(&["/projectile/offset_mm=[2.54,0]"]), 2);
    torn(&small(&["/projectile/offset_mm=[0,-1]"]), 2);
    torn(&small(&["/projectile/obliquity_deg=20"]), 2);
    torn(&small(&["/projectile/obliquity_deg=20", "/projectile/azimuth_deg=90", "/output/profile_along=weft"]), 2);
    let sphere = r#"/projectile={"shape":"sphere","diameter_mm":6,"mass_g":1,"velocity_m_s":300}"#;
    agree(&small(&[sphere, "/pack/edges=free"]), Precision::F64, 4, 1e-7);
    let [against_clay, _] = agree(&small(&["/backing={\"pressure_mpa\":5}"]), Precision::F64, 4, 1e-7);
    assert!(against_clay.history.last().unwrap().balance.backing > 0.1);
    torn(&small(&["/solver/shock_viscosity=0.3", "/pack/mesh_grading=graded", "/pack/elements_per_crossover=2"]), 4);
    // The struck ply turned: its plane lies at the end of its rows.
    torn(&small(&["/pack/layup=[{\"orientation_deg\":90}]", "/output/profile_along=weft"]), 4);
}

#[test]
fn a_part_of_a_pack_gives_the_history_of_the_whole() {
    let crossed = ["/pack/plies=2", "/pack/layup=[{},{\"orientation_deg\":90}]", "/output/profile_times_us=[]"];
    for (more, parts) in [("/projectile/velocity_m_s=250", 4), ("/projectile/offset_mm=[1,0]", 2), (GROWN, 4)] {
        let [part, whole] = agree(&small(&[&crossed[..], &[more]].concat()), Precision::F64, parts, 1e-7);
        assert!(part.events.iter().any(|e| e.ply == 1) && part.events.len() > 16, "{}", part.events.len());
        assert!((part.max_ply_penetration - whole.max_ply_penetration).abs() < 1e-9 && part.max_ply_penetration > 1e-5);
    }
    // Cells that do not lie over each other.
    let other = r#"/pack/layup=[{},{"fabric":{"file":"fabrics/s-728.json"}},{}]"#;
    agree(
        &small(&["/pack/plies=3", other, "/output/profile_times_us=[]", "/solver/end_time_us=9"]),
        Precision::F64,
        2, // S-728 has an odd number of cells across
        1e-7,
    );
}

#[test]
fn the_papers_shot_computes_at_most_a_quarter_at_unchanged_history() {
    let case = builtin(PAPER, &[]);
    let [part, _] = agree(&case, Precision::F64, 4, 1e-6);
    let whole = part.elements as u64 * part.steps;
    assert!(4 * part.element_steps_computed <= whole, "{} of {whole}", part.element_steps_computed);
    let summary = output::summary(&case, &part, 0.0);
    let skipped = &summary["skipped"];
    assert_eq!(skipped["mirror_planes"], json!(["x", "y"]));
    assert_eq!(skipped["symmetry"], json!(whole - whole / 4));
    assert_eq!(skipped["wavefront"], json!(whole / 4 - part.element_steps_computed));
    let left = part.history.last().unwrap().projectile_velocity;
    assert!((left - 95.8912).abs() < 1e-4 && part.events.len() == 32, "{left} m/s, {} events", part.events.len());
}

/// Velocities [m/s] and deflections [m] of two shots in which the same number of yarns breaks.
#[track_caller]
fn same_shot(a: &Run, b: &Run, [velocity, deflection]: [f64; 2]) {
    assert_eq!((a.history.len(), a.events.len()), (b.history.len(), b.events.len()));
    for (x, y) in a.history.iter().zip(&b.history) {
        assert!((x.projectile_velocity - y.projectile_velocity).abs() <= velocity, "{x:?}\n{y:?}");
        assert!((x.deflection - y.deflection).abs() <= deflection, "{x:?}\n{y:?}");
    }
}

#[test]
fn mirrored_and_swapped_shots_are_the_same_shot() {
    let image =
        |sets: &[&str]| run(&builtin("cases/verify/mirror.json", &[sets, &["/solver/end_time_us=25"]].concat()));
    // Until rounding is amplified by the first failures (about 40 µs here) histories agree to solver tolerance.
    let base = image(&[]);
    let lost = base.history[0].projectile_velocity - base.history.last().unwrap().projectile_velocity;
    assert!(lost > 1.0, "the shot does something: {lost} m/s");
    same_shot(
        &base,
        &image(&["/projectile/offset_mm=[-4.4,-2.3]", "/projectile/azimuth_deg=145"]),
        [1e-9 * lost, 1e-11],
    );
    let swapped = [
        "/pack/width_mm=40.64",
        "/pack/height_mm=50.8",
        "/fabric/warp/crimp=0.0139",
        "/fabric/weft/crimp=0.0218",
        "/projectile/offset_mm=[-2.3,4.4]",
        "/projectile/azimuth_deg=55",
    ];
    same_shot(&base, &image(&swapped), [1e-6 * lost, 1e-8]);
}

/// Histories and failures to the last bit.
#[track_caller]
fn assert_same(one: &Run, other: &Run) {
    assert!(one.history == other.history && one.ply_history == other.ply_history && one.events == other.events);
    assert_eq!(one.time_step.to_bits(), other.time_step.to_bits());
}

const STILL: &str = "/pack/mesh_grading={\"fine_radius_mm\":5,\"growth_ratio\":1,\"lines_from\":\"edges\"}";
const GROWN: &str = "/pack/mesh_grading={\"fine_radius_mm\":5,\"growth_ratio\":1.3,\"max_crossovers\":8}";
const TURNED: &str = "/pack/layup=[{},{\"orientation_deg\":90},{\"orientation_deg\":30}]";

#[test]
fn without_growth_it_is_the_even_mesh_to_the_last_bit() {
    let aside = "/projectile/offset_mm=[4,-3]";
    let scenes: [&[&str]; 4] = [&[], &[aside], &["/pack/plies=3", TURNED], &["/pack/plies=2", "/solver/symmetry=none"]];
    for sets in scenes {
        let even = run(&large(sets));
        assert!(!even.events.is_empty(), "yarns must fail for this to mean anything");
        assert_same(&run(&large(&[sets, &[STILL]].concat())), &even);
    }
}

#[test]
fn a_converged_mesh_is_finer_far_from_the_hit_too() {
    let largest = |sets: &[&str]| -> f64 {
        let case = shipped(PAPER, &[&["/expect=[]"], sets].concat());
        let widths = |middles: &[f64]| middles.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
        case.layers()[0].middles().iter().map(|middles| widths(middles) / 1.27e-3).fold(0.0, f64::max)
    };
    let converged = "/solver/accuracy=converged";
    for sets in [&[][..], &["/pack/elements_per_crossover=4"], &["/pack/mesh_grading=graded"]] {
        let [default, fine] = [&[][..], &[converged]].map(|more| largest(&[sets, more].concat()));
        assert!((5.0..6.01).contains(&default) && (1.5..2.01).contains(&fine), "{sets:?}: {default} {fine}");
    }
    // What a case says itself stays, and the largest elements are never smaller than the finest.
    let said = largest(&[converged, r#"/pack/mesh_grading={"max_crossovers": 4}"#]);
    assert!((3.0..4.01).contains(&said), "{said}");
    assert!((largest(&[converged, "/pack/crossovers_per_element=8", "/pack/mesh_grading=graded"]) - 8.0).abs() < 1e-9);
}

#[test]
fn it_covers_the_same_cloth_with_fewer_elements_and_the_same_mass() {
    for sets in
        [&[][..], &["/projectile/offset_mm=[9,-3]"], &["/pack/crossovers_per_element=2"], &["/pack/plies=3", TURNED]]
    {
        let [even, grown] = [&[][..], &[GROWN]].map(|g| Model::<f64>::new(&large(&[sets, g].concat())).unwrap());
        assert!(grown.elements() * 3 < even.elements() * 2, "{} of {}", grown.elements(), even.elements());
        assert_eq!(grown.dt.to_bits(), even.dt.to_bits(), "the finest elements set the step");
        for (even, grown) in even.ply_types.iter().zip(&grown.ply_types) {
            let [(a, first), (b, last)] = [even, grown].map(|of| {
                let Mesh { rows, columns, .. } = of.mesh;
                let mass = |row: usize| of.row_mass(row).mass[..=columns].iter().sum::<f64>();
                ((0..=rows).map(mass).sum::<f64>(), of.mesh.reference(rows, columns))
            });
            // A ply that is cut to the frame has the elements whose middles lie in it: as much cloth, but for half an element at its edge.
            let cut = grown.mesh.frame.opening != Opening::Mesh;
            let edge = if cut { grown.mesh.longest() / grown.mesh.frame.half[1] } else { 0.0 };
            assert!((a / b - 1.0).abs() < 1e-13 + 0.1 * edge && first == last, "{a} {b} {first:?} {last:?}");
            let widths: Vec<f64> = (0..grown.mesh.columns).map(|c| grown.mesh.widths(0, c)[0]).collect();
            assert!(widths.windows(2).all(|w| w[0] <= 1.3001 * w[1] && w[1] <= 1.3001 * w[0]), "{widths:?}");
            let [x, y] = large(sets).projectile.unwrap().offset;
            let hit = grown.mesh.to_ply([x, y, 0.0])[1];
            for row in 0..grown.mesh.rows {
                let near = [row, row + 1].iter().any(|at| (grown.mesh.reference(*at, 0)[1] - hit).abs() < 5e-3);
                assert!(!near || (grown.mesh.widths(row, 0)[1] - 1.0).abs() < 1e-12, "{row} {hit}");
            }
        }
    }
}

#[test]
fn energy_and_momentum_close() {
    let oblique = ["/projectile/offset_mm=[4,-3]", "/projectile/obliquity_deg=20"];
    // Packs that are torn close to 4e-7 on the even mesh too.
    let scenes: [(&[&str], f64); 3] = [(&[], 1e-11), (&oblique, 1e-11), (&["/pack/plies=3", TURNED], 1e-5)];
    for (sets, energy) in scenes {
        let case = large(&[sets, &[GROWN, "/pack/edges=free", "/projectile/velocity_m_s=600"]].concat());
        let run = run(&case);
        assert!(!run.events.is_empty(), "yarns must fail for this to mean anything");
        closes(&run, [energy, 1e-9]);
    }
}

#[test]
fn waves_run_through_growing_elements_at_their_speed() {
    // Struck in the middle and graded along its yarns from there: strain, front and kink are those of the even strip.
    let grading = "/pack/mesh_grading={\"fine_radius_mm\":20,\"growth_ratio\":1.05,\"max_crossovers\":4}";
    let case = builtin("cases/verify/strip-crimped-155.json", &[grading, "/solver/shock_viscosity=0.3"]);
    assert!(Model::<f64>::new(&case).unwrap().ply_types[0].mesh.is_graded());
    let run = run(&case);
    for checked in checked(&case, &run) {
        assert!(checked["pass"] == true, "{checked:?}");
    }
}

#[test]
fn elements_are_fine_where_an_oblique_point_slides() {
    /// From where to where elements are the finest along X and Y, from the hit [m].
    fn fine(sets: &[&str]) -> [[f64; 2]; 2] {
        let case = large(&[&["/solver/numerics=default", "/projectile/azimuth_deg=30"], sets].concat());
        let mesh = &Model::<f64>::new(&case).unwrap().ply_types[0].mesh;
        [0, 1].map(|axis| {
            let line = |at: usize| mesh.reference(at * axis, at * (1 - axis))[axis];
            let is_fine = |at: &usize| line(at + 1) - line(*at) < 1.001 * mesh.length[axis];
            let count = [mesh.columns, mesh.rows][axis];
            [line((0..count).find(is_fine).unwrap()), line((0..count).rfind(is_fine).unwrap() + 1)]
        })
    }
    // Six elements a crossover; the fine part ends on a line of nodes.
    const ELEMENT: f64 = 1.27e-3 / 6.0;
    const CONE: &[&str] = &["/projectile/shape=cone", "/projectile/nose_length_mm=6"];
    const OBLIQUE: &str = "/projectile/obliquity_deg=40";
    let [across, along] = fine(CONE);
    [across, along].as_flattened().iter().for_each(|at| near(at.abs(), 5.5e-3, ELEMENT));
    // An eighth of the smaller side, by the tangent of the obliquity: 4.3 mm, of which 3.7 along X and 2.1 along Y.
    let way = 0.125 * 40.64e-3 * 40_f64.to_radians().tan();
    let [x, y] = fine(&[CONE, &[OBLIQUE]].concat());
    for (oblique, square, share) in [(x, across, 0.75_f64.sqrt()), (y, along, 0.5)] {
        assert!((oblique[0] - square[0]).abs() < 1e-9, "{oblique:?} for {square:?}");
        let longer = oblique[1] - square[1] - way * share;
        assert!(longer.abs() < ELEMENT, "{oblique:?} for {square:?}: {longer}");
    }
    // Beyond 45° it goes no further.
    let steep = [45, 80].map(|at| fine(&[CONE, &[&format!("/projectile/obliquity_deg={at}")]].concat()));
    assert_eq!(steep[0], steep[1]);
    // A rim breaks yarns early, or holds them.
    let flat = [&[][..], &[OBLIQUE]].map(fine);
    assert_eq!(flat[0], flat[1]);
}
