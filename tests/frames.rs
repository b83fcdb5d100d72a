//! Frames: the whole scene at one time.
//!
//! Promise: a frame is what the run computed at its time, the same whichever part of a symmetric scene was computed. What files make of it is
//! the affair of `tests/external.rs`.
//! Red when: mirror images point the wrong way or stand in the wrong place, broken yarns count as alive, what has moved is
//! left out, units are wrong, or frames come at other times than asked for.

use std::sync::atomic::AtomicBool;

use ripstop::FrameCollector;
use ripstop::case::{self, Case};
use ripstop::run::frame::Frame;
use ripstop::run::{self, Options, Run, Skips};

/// 24 × 20 elements, yarns of which break; two plies, a history row for every step.
fn shot(sets: &[&str]) -> Case {
    let text = r#"{"title": "shot", "fabric": {"file": "fabrics/s-720.json"},
        "pack": {"width_mm": 30, "height_mm": 25, "plies": 2},
        "projectile": {"shape": "cylinder", "diameter_mm": 5.5, "length_mm": 20, "mass_g": 3, "velocity_m_s": 600},
        "solver": {"end_time_us": 10, "run_until": "end_time", "numerics": "paper"}, "output": {"frames": 6, "history_interval_us": 0.001}}"#;
    let sets: Vec<String> = sets.iter().map(ToString::to_string).collect();
    case::from_str("shot", text, &sets).unwrap_or_else(|error| panic!("{error}"))
}

fn collected(case: &Case, skips: Skips) -> (Run, Vec<Frame>) {
    let mut collector = FrameCollector::new(case, case.output.frames as usize);
    let run = run::run(case, Options::default().skips(skips), &AtomicBool::new(false), &mut collector).unwrap();
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
        assert!(
            (pose.velocity[2] / row.projectile_velocity - 1.0).abs() < 1e-3,
            "{pose:?} {}",
            row.projectile_velocity
        );
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
