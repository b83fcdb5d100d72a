//! Frames: the whole scene at one time.
//!
//! Promise: a frame is what the run computed at its time, the same whichever part of a symmetric scene was computed. Loads in frames, playback,
//! history and summary are those of the state. What files make of it is
//! the affair of `tests/external.rs`.
//! Red when: mirror images point the wrong way or stand in the wrong place, broken yarns count as alive, what has moved is
//! left out, units are wrong, or frames come at other times than asked for.

use ripstop::FrameCollector;
use ripstop::case::Case;
use ripstop::output::{Animation, summary};
use ripstop::run::frame::Frame;
use ripstop::run::{Options, Run, Sample, Skips};

use crate::support::read;

/// 24 × 20 elements, yarns of which break; two plies, a history row for every step.
fn shot(sets: &[&str]) -> Case {
    let text = r#"{"title": "shot", "fabric": {"file": "fabrics/s-720.json"},
        "pack": {"width_mm": 30, "height_mm": 25, "plies": 2},
        "projectile": {"shape": "cylinder", "diameter_mm": 5.5, "length_mm": 20, "mass_g": 3, "velocity_m_s": 600},
        "solver": {"end_time_us": 10, "run_until": "end_time", "numerics": "paper"}, "output": {"frames": 6, "history_interval_us": 0.001}}"#;
    read("shot", text, sets)
}

fn collected(case: &Case, skips: Skips) -> (Run, Vec<Frame>) {
    let mut collector = FrameCollector::new(case, case.output.frames as usize);
    let run = Options::default().skips(skips).observe(case, &mut collector).unwrap();
    (run, collector.frames())
}

#[track_caller]
fn assert_close(what: &str, got: impl IntoIterator<Item = f32>, expected: impl IntoIterator<Item = f32>) {
    let (got, expected): (Vec<f32>, Vec<f32>) = (got.into_iter().collect(), expected.into_iter().collect());
    let largest = expected.iter().fold(0.0_f32, |largest, x| largest.max(x.abs()));
    assert_eq!(got.len(), expected.len(), "{what}");
    for (at, (got, expected)) in got.iter().zip(&expected).enumerate() {
        assert!((got - expected).abs() <= 1e-6 * largest, "{what} {at}: {got}, expected {expected} of {largest}");
    }
}

#[test]
fn a_quarter_gives_the_frames_of_the_whole() {
    let case = shot(&[]);
    let ((part, few), (whole, all)) = (collected(&case, Skips::default()), collected(&case, Skips::NONE));
    assert_eq!((part.planes.copies(), whole.planes.copies()), (4, 1));
    assert_eq!((few.len(), all.len()), (6, 6));
    assert!(all[5].alive[0].contains(&0) && all[5].alive[1].contains(&0), "yarns must fail for this to mean anything");
    assert!(all[5].shear_angle.iter().any(|angle| angle.abs() > 0.01));
    for (few, all) in few.into_iter().zip(all) {
        assert_eq!((few.step, few.time.to_bits()), (all.step, all.time.to_bits()));
        assert_eq!(few.alive, all.alive);
        assert_close("displacement", few.displacement.into_flattened(), all.displacement.into_flattened());
        assert_close("velocity", few.velocity.into_flattened(), all.velocity.into_flattened());
        assert_close("shear angle", few.shear_angle, all.shear_angle);
        for yarn in 0..2 {
            assert_close("tension", few.tension[yarn].clone(), all.tension[yarn].clone());
            assert_close("strain", few.strain[yarn].clone(), all.strain[yarn].clone());
            assert_close("height", few.height[yarn].clone(), all.height[yarn].clone());
        }
        let [few, all] = [few.projectile.unwrap(), all.projectile.unwrap()];
        assert!((few.position[2] - all.position[2]).abs() < 1e-12 && few.rotation == [1.0, 0.0, 0.0, 0.0]);
    }
}

#[test]
fn a_frame_is_what_the_history_says_of_its_step() {
    let case = shot(&[]);
    let (run, frames) = collected(&case, Skips::default());
    for (at, frame) in frames.iter().enumerate() {
        assert!((frame.time - 2e-6 * at as f64).abs() <= 0.5 * run.time_step, "frame {at} at {}", frame.time);
        // The first row stands after the first contact, and the last step before the end.
        let Some(row) = run.history.iter().find(|row| at > 0 && (row.time - frame.time).abs() < 1e-12) else {
            assert!(at == 0 || at == 5, "no row at {}", frame.time);
            continue;
        };
        let deepest = frame.displacement.iter().fold(0.0_f64, |most, u| most.max(f64::from(u[2].abs())));
        assert!((deepest / row.deflection - 1.0).abs() < 1e-6, "{deepest} {}", row.deflection);
        let pose = frame.projectile.unwrap();
        // Half a step apart.
        assert!((pose.velocity[2] / row.projectile_velocity - 1.0).abs() < 1e-3, "{pose:?} {row:?}");
        assert!((pose.position[2] + 10e-3 - row.projectile_displacement).abs() < 1e-9, "{:?}", pose.position);
    }
    let last = frames.last().unwrap();
    let broken = |yarn: usize| last.alive[yarn].iter().zip(&last.tension[yarn]).filter(|(alive, _)| **alive == 0);
    assert!((0..2).flat_map(broken).all(|(_, tension)| *tension == 0.0));
    let peak = last.tension.iter().flatten().fold(0.0_f32, |peak, tension| peak.max(*tension));
    let row = run.history.last().unwrap();
    assert!((f64::from(peak) / row.balance.max_tension - 1.0).abs() < 0.05, "{peak} {}", row.balance.max_tension);
}

#[test]
fn a_yarn_is_broken_in_a_frame_when_it_is_in_the_run() {
    // What breaks in the step from the positions of a frame is not known yet.
    for numerics in ["paper", "default"] {
        let case = shot(&[&format!("/solver/numerics={numerics}")]);
        let (run, frames) = collected(&case, Skips::default());
        assert!(run.events.len() > 100);
        for frame in &frames {
            let broken = run.events.iter().filter(|event| event.step < frame.step).count();
            let gone = frame.alive.iter().flatten().filter(|alive| **alive == 0).count();
            assert_eq!(gone, broken, "{numerics}, at {} s", frame.time);
        }
    }
}

/// Tension of the whole yarn in every element [N], from the strains of the elements: a yarn has those whose middles lie within its spacing.
/// `lines`: of nodes, across and along the yarn [m].
fn tensions(strain: &dyn Fn(usize, usize) -> f64, lines: &[Vec<f64>; 2], stiffness: f64) -> Vec<Vec<f64>> {
    let number = |[low, high]: [f64; 2]| (0.5 * (low + high) / 1.27e-3 + 1e-9).floor();
    let across: Vec<[f64; 2]> = lines[0].windows(2).map(|ends| [ends[0], ends[1]]).collect();
    let of_row = |side: &[f64; 2]| {
        let beside = || (0..across.len()).filter(|at| number(across[*at]) == number(*side));
        let breadth = |at: usize| across[at][1] - across[at][0];
        let total: f64 = beside().map(breadth).sum();
        let mean = |at: usize| beside().map(|row| breadth(row) * strain(row, at)).sum::<f64>() / total;
        (0..lines[1].len() - 1).map(|at| stiffness * mean(at)).collect()
    };
    across.iter().map(of_row).collect()
}

#[test]
fn tensions_are_those_of_the_state_whatever_the_mesh() {
    const SHOT: [&str; 8] = [
        "/solver/numerics=default",
        "/solver/end_time_us=20",
        "/pack/plies=1",
        "/pack/width_mm=50.8",
        "/pack/height_mm=40.64",
        "/projectile/velocity_m_s=120",
        "/output/frames=5",
        "/pack/mesh_grading=none",
    ];
    for mesh in ["/pack/elements_per_crossover=1", "/pack/elements_per_crossover=3", "/pack/mesh_grading={}"] {
        let case = shot(&[&SHOT[..], &[mesh]].concat());
        let (mut collector, mut animation) = (FrameCollector::new(&case, 5), Animation::new(&case));
        let run = Options::default().observe(&case, &mut collector).unwrap();
        Options::default().observe(&case, &mut animation).unwrap();
        let scene = collector.scene().unwrap();
        let (columns, rows) = (scene.plies[0].columns, scene.plies[0].rows);
        let x: Vec<f64> = (0..=columns).map(|column| scene.reference[column][0].into()).collect();
        let y: Vec<f64> = (0..=rows).map(|row| scene.reference[row * (columns + 1)][1].into()).collect();
        let narrowest = x.windows(2).map(|ends| ends[1] - ends[0]).fold(1.0, f64::min);
        let widest = x.windows(2).map(|ends| ends[1] - ends[0]).fold(0.0, f64::max);
        assert_eq!(widest > 4.0 * narrowest, mesh.contains("grading"), "{mesh}: {narrowest} to {widest}");
        let rows_of_history = &run.history;
        for frame in &collector.frames()[1..4] {
            let row = &rows_of_history[frame.step as usize];
            let mut peak = 0.0_f64;
            for (yarn, own) in [&case.fabric.warp, &case.fabric.weft].into_iter().enumerate() {
                let place = |across: usize, along: usize| {
                    if yarn == 0 { across * columns + along } else { along * columns + across }
                };
                let lines = if yarn == 0 { [y.clone(), x.clone()] } else { [x.clone(), y.clone()] };
                let stiffness = own.modulus * own.area(case.fabric.fibre_density);
                let strain = |across: usize, along: usize| f64::from(frame.strain[yarn][place(across, along)]).max(0.0);
                for (across, tensions) in tensions(&strain, &lines, stiffness).iter().enumerate() {
                    for (along, tension) in tensions.iter().enumerate() {
                        let shown = f64::from(frame.tension[yarn][place(across, along)]);
                        assert!((shown - tension).abs() < 1e-3, "{mesh} {yarn}: {shown} for {tension}");
                        peak = peak.max(*tension);
                    }
                }
            }
            let deepest = frame.displacement.iter().fold(0.0_f64, |most, u| most.max(f64::from(u[2].abs())));
            for (name, got, expected) in [
                ("tension", row.balance.max_tension, peak),
                ("deflection", row.deflection, deepest),
                ("deflection of the back", row.last_deflection, deepest),
            ] {
                assert!(expected > 0.0 && (got / expected - 1.0).abs() < 1e-4, "{mesh}, {name}: {got}, {expected}");
            }
        }
        // A keyframe has the tensions of the step before.
        for keyframe in &animation.keyframes[2..] {
            let shown = keyframe.tension.iter().flatten().flatten().copied().fold(0.0_f32, f32::max);
            let before = rows_of_history[keyframe.step as usize - 1].balance.max_tension;
            assert!((f64::from(shown) / before - 1.0).abs() < 1e-5, "{mesh}, playback: {shown} {before}");
        }
        let most = |of: &dyn Fn(&Sample) -> f64| rows_of_history.iter().map(of).fold(0.0, f64::max);
        let told = summary(&case, &run, 1.0);
        for (key, expected) in [
            ("peak_yarn_tension_n", most(&|row| row.balance.max_tension)),
            ("breaking_load_ratio", most(&|row| row.balance.max_load)),
            ("last_ply_deflection_mm", 1e3 * most(&|row| row.deflection)),
            ("peak_contact_force_n", most(&|row| row.contact_force)),
        ] {
            assert_eq!(told[key].as_f64(), Some(expected), "{mesh} {key}");
        }
        // Forces between rows are what slowed the projectile, from the first touch on.
        let given: f64 = rows_of_history.windows(2).map(|row| row[1].contact_force * (row[1].time - row[0].time)).sum();
        let lost = 3e-3 * (120.0 - rows_of_history.last().unwrap().projectile_velocity);
        assert!((given / lost - 1.0).abs() < 0.01 && rows_of_history[0].contact_force == 0.0, "{mesh}: {given} {lost}");
    }
}
