//! The animation of a shot: which pictures there are, what they show, and where it opens.

use ripstop::output::report::Animation;
use ripstop::run::outcome::Outcome;
use serde_json::Value;

use super::{Shot, TORN, between};

/// How far a time is at most from where it would be if all lay evenly, in even gaps.
fn off_even(times: &[f64]) -> f64 {
    let gap = times[times.len() - 1] / (times.len() - 1) as f64;
    times.iter().enumerate().map(|(n, time)| (time / gap - n as f64).abs()).fold(0.0, f64::max)
}

#[test]
fn pictures_lie_evenly_and_there_are_not_too_many() {
    for end in ["5", "10", "16", "40"] {
        let shot = Shot::new(&[&format!("/solver/end_time_us={end}"), "/solver/run_until=end_time"]);
        let times: Vec<f64> = shot.animation.shown().keyframes.iter().map(|keyframe| keyframe.time).collect();
        assert!((20..=65).contains(&times.len()), "{end}: {}", times.len());
        assert!(off_even(&times) < 0.5 + shot.run.time_step * times.len() as f64 / times[times.len() - 1], "{times:?}");
        assert!(
            times[0] == 0.0
                && (times[times.len() - 1] - end.parse::<f64>().unwrap() * 1e-6).abs() < 2.0 * shot.run.time_step
        );
    }
}

#[test]
fn pictures_fill_a_shot_that_is_decided_early() {
    let shot = Shot::new(&["/solver/end_time_us=400"]);
    let end = shot.run.history.last().unwrap().time;
    assert!(shot.run.outcome == Outcome::Perforated && end < 100e-6, "{end}");
    let times: Vec<f64> = shot.animation.shown().keyframes.iter().map(|keyframe| keyframe.time).collect();
    assert_eq!((times.len(), times[0]), (61, 0.0));
    assert!((times[60] - end).abs() < 2.0 * shot.run.time_step, "{} {end}", times[60]);
    assert!(off_even(&times) < 0.55, "{times:?}");
}

#[test]
fn the_playback_opens_at_the_largest_deflection_before_the_projectile_is_gone() {
    let film_of =
        |page: &str| -> Value { serde_json::from_str(between(page, "id=\"animation\">", "</script>")).unwrap() };
    let stopped = Shot::new(&["/projectile/velocity_m_s=30", "/solver/end_time_us=600"]);
    assert_eq!(stopped.run.outcome, Outcome::Stopped);
    let animation = stopped.animation.shown();
    let opening = &animation.keyframes[animation.opening()];
    assert!(animation.keyframes.iter().all(|keyframe| keyframe.deflection() <= opening.deflection()));
    assert!((opening.deflection() / stopped.run.deflection() - 1.0).abs() < 0.02);
    assert_eq!(film_of(&stopped.page())["opening"], animation.opening());
    // 12 mm long, it leaves what it broke behind.
    let perforated = Shot::new(&TORN);
    let animation = perforated.animation.shown();
    let at = |still: usize| animation.keyframes[still].pose.unwrap()[2] - animation.keyframes[still].deflection();
    assert!(at(60) > 0.02 && at(animation.opening()) < 0.007, "{} {}", at(60), at(animation.opening()));
}

#[test]
fn the_film_shows_what_is_there() {
    let shot = Shot::new(&["/solver/symmetry=none", "/solver/end_time_us=14"]);
    let last = shot.animation.keyframes.last().unwrap();
    let deepest = last.displacement.iter().map(|u| u[2]).fold(0.0, f32::max);
    let row = shot.run.history.last().unwrap();
    // The history counts standing fabric only.
    assert!(
        f64::from(deepest) >= row.deflection - 1e-6 && f64::from(deepest) < 2.0 * row.deflection,
        "{deepest} {}",
        row.deflection
    );
    let broken = |yarn: usize| last.tension.iter().filter(|cell| cell[yarn].is_none()).count() as u64;
    assert_eq!([broken(0), broken(1)], row.failed);
    // A yarn breaks at its modulus times failure strain times cross-section; shear adds little.
    let yarn = &shot.case.fabric.warp;
    let strength = yarn.modulus * yarn.failure_strain * yarn.area(shot.case.fabric.fibre_density);
    let peak = f64::from(shot.animation.peak_tension());
    assert!((0.8..1.1).contains(&(peak / strength)), "{peak} of {strength}");
    // A quarter of it is the same as the whole.
    let quarter = Shot::new(&["/solver/end_time_us=14"]);
    let part = quarter.animation.keyframes.last().unwrap();
    assert_eq!(quarter.animation.strips[0].elements, shot.animation.strips[0].elements);
    assert_eq!(part.tension.len() * 4, last.tension.len());
    let corner = |animation: &Animation, tension: &[[Option<f32>; 2]]| tension[animation.strips[0].cells() - 1];
    let [a, b] = [corner(&quarter.animation, &part.tension), corner(&shot.animation, &last.tension)];
    assert!((0..2).all(|yarn| (a[yarn].unwrap() - b[yarn].unwrap()).abs() < 1e-3), "{a:?} {b:?}");
}

#[test]
fn a_thick_pack_shows_some_plies_and_says_which() {
    let shot = Shot::new(&["/pack/plies=12", "/solver/end_time_us=4", "/output/history_interval_us=2"]);
    let page = shot.page();
    let said = between(&page, "Of 12 plies these are shown: ", ".");
    let shown: Vec<usize> = said.split(", ").map(|ply| ply.parse().unwrap()).collect();
    assert_eq!(shown, [1, 3, 4, 6, 7, 9, 10, 12]);
    assert!(page.len() < 5_000_000, "{}", page.len());
    let animation: Value = serde_json::from_str(between(&page, "id=\"animation\">", "</script>")).unwrap();
    assert_eq!(animation["strips"].as_array().unwrap().len(), 8);
}
