//! Graded meshes: elements that grow away from the hit.
//!
//! Promises: without growth a graded mesh is the even one, to the last bit, one ply or a pack; whatever the growth, area and mass
//! are those of the even mesh, energy and momentum close, the part of a symmetric scene
//! gives the whole, and waves run at the speeds of the even mesh.
//! Red when: an element's size misses in its strain, its forces, its hourglass stiffness, its energy or its nodes' masses; when contact
//! between plies, the wave front or a mirror plane takes elements for alike.

use ripstop::case::{Case, Opening};
use ripstop::model::Model;
use ripstop::model::mesh::Mesh;
use ripstop::run::{Run, Skips};

use crate::support::{builtin, run, shipped};

const PAPER: &str = "cases/s720-1ply-155.json";

/// A small ply, 40 × 32 elements of which most are far from the projectile.
fn small(sets: &[&str]) -> Case {
    let size = ["/pack/width_mm=50.8", "/pack/height_mm=40.64", "/expect=[]", "/output/profile_times_us=[]"];
    let shot = ["/projectile/length_mm=8", "/projectile/mass_g=1", "/projectile/velocity_m_s=300"];
    let run = ["/solver/end_time_us=25", "/solver/run_until=end_time"];
    builtin(PAPER, &[&size[..], &shot, &run, sets].concat())
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
        let even = run(&small(sets));
        assert!(!even.events.is_empty(), "yarns must fail for this to mean anything");
        assert_same(&run(&small(&[sets, &[STILL]].concat())), &even);
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
        assert!(
            (5.0..6.01).contains(&default) && (1.5..2.01).contains(&fine),
            "{sets:?}: {default} and {fine} crossovers"
        );
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
        let [even, grown] = [&[][..], &[GROWN]].map(|g| Model::<f64>::new(&small(&[sets, g].concat())).unwrap());
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
            let [x, y] = small(sets).projectile.unwrap().offset;
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
        let case = small(&[sets, &[GROWN, "/pack/edges=free", "/projectile/velocity_m_s=600"]].concat());
        let run = run(&case);
        assert!(!run.events.is_empty(), "yarns must fail for this to mean anything");
        assert!(run.energy_error < energy && run.momentum_error < 1e-9, "{} {}", run.energy_error, run.momentum_error);
    }
}

#[test]
fn a_quarter_gives_the_whole_and_the_wave_front_changes_no_bit() {
    for sets in [&[][..], &["/pack/plies=2", "/pack/layup=[{},{\"orientation_deg\":90}]"]] {
        let case = small(&[sets, &[GROWN]].concat());
        let with = |skips| {
            let options = ripstop::run::Options::default().skips(skips);
            let stop = std::sync::atomic::AtomicBool::new(false);
            ripstop::run::run(&case, options, &stop, &mut ()).unwrap()
        };
        let (part, whole, all) = (with(Skips::default()), with(Skips::WHOLE), with(Skips::NONE));
        assert_eq!((part.planes.copies(), whole.planes.copies()), (4, 1));
        assert_same(&whole, &all);
        assert!(whole.element_steps_computed < all.element_steps_computed);
        assert!(!whole.events.is_empty(), "yarns must fail for this to mean anything");
        for (a, b) in part.history.iter().zip(&whole.history) {
            let off = (a.projectile_velocity - b.projectile_velocity).abs();
            assert!(off < 1e-9 * 300.0, "{} {}", a.projectile_velocity, b.projectile_velocity);
        }
        let places = |run: &Run| {
            let mut places: Vec<_> = run.events.iter().map(|e| (e.step, e.ply, e.i, e.j, e.yarn)).collect();
            places.sort_unstable();
            places
        };
        assert_eq!(places(&part), places(&whole));
    }
}

#[test]
fn waves_run_through_growing_elements_at_their_speed() {
    // Struck in the middle and graded along its yarns from there: strain, front and kink are those of the even strip.
    let grading = "/pack/mesh_grading={\"fine_radius_mm\":20,\"growth_ratio\":1.05,\"max_crossovers\":4}";
    let case = builtin("cases/verify/strip-crimped-155.json", &[grading, "/solver/shock_viscosity=0.3"]);
    assert!(Model::<f64>::new(&case).unwrap().ply_types[0].mesh.is_graded());
    let run = run(&case);
    for checked in crate::support::checked(&case, &run) {
        assert!(checked["pass"] == true, "{checked:?}");
    }
}

#[test]
fn elements_are_fine_where_an_oblique_point_slides() {
    /// From where to where elements are the finest along X and Y, from the hit [m].
    fn fine(sets: &[&str]) -> [[f64; 2]; 2] {
        let case = small(&[&["/solver/numerics=default", "/projectile/azimuth_deg=30"], sets].concat());
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
    assert!(
        [across, along].as_flattened().iter().all(|at| (at.abs() - 5.5e-3).abs() < ELEMENT),
        "{across:?}, {along:?}"
    );
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
