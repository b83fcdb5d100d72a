//! `report.html`: what it says. That it works in a browser is in `tests/browser.rs`.
//!
//! Promise: the verdict comes first and says when a run broke off; every level of trust can be reached and gives its reason; what a
//! user wrote is words; nothing is asked of a network; but for machine and timing the same run gives the same page; it stays
//! below 5 MB.

use std::sync::atomic::AtomicBool;

use ripstop::case::{self, Case};
use ripstop::output;
use ripstop::output::report::{Animation, report};
use ripstop::output::trust::{self, Level};
use ripstop::run::outcome::Outcome;
use ripstop::run::{self, Options, Run};
use ripstop::solver::Divergence;
use serde_json::{Value, json};

/// Every part of the page.
const PARTS: [&str; 13] = [
    "playback",
    "plots",
    "velocity",
    "force",
    "deflection",
    "energy",
    "failures",
    "profile",
    "unit-cell",
    "tension",
    "trust",
    "case",
    "machine",
];

/// Changes that make a shot throw debris ahead.
const TORN: [&str; 5] = [
    "/pack/width_mm=50",
    "/pack/height_mm=45",
    "/projectile/velocity_m_s=450",
    "/solver/end_time_us=80",
    "/solver/run_until=end_time",
];

/// What makes a run another one.
type Change = fn(&mut Run);
/// A sign of trust, how to give it a value, and values that are fine, to be looked at, and bad.
type Ladder = (&'static str, fn(&mut Shot, f64), [f64; 3]);

struct Shot {
    case: Case,
    run: Run,
    animation: Animation,
}

impl Shot {
    /// 24 × 24 elements, fast enough to break yarns, with changes of the case.
    fn new(changes: &[&str]) -> Self {
        let text = json!({
            "title": "a small shot",
            "fabric": {"file": "fabrics/s-720.json"},
            "pack": {"width_mm": 30, "height_mm": 30},
            "projectile": {"shape": "cylinder", "diameter_mm": 5.5, "length_mm": 12, "mass_g": 3, "velocity_m_s": 600},
            "solver": {"end_time_us": 10, "numerics": "paper"},
        });
        let changes: Vec<String> = changes.iter().map(|&change| change.to_owned()).collect();
        let case = case::from_str("shot", &text.to_string(), &changes).unwrap();
        Self::with_threads(case, 1)
    }

    fn with_threads(case: Case, threads: usize) -> Self {
        let mut animation = Animation::new(&case);
        let options = Options { threads: Some(threads), ..Options::default() };
        let run = run::run(&case, options, &AtomicBool::new(false), &mut animation).unwrap();
        Self { case, run, animation }
    }

    fn page(&self) -> String {
        report(&self.case, &self.run, &output::summary(&self.case, &self.run, 1.0), &self.animation)
    }

    fn level(&self, name: &str) -> (Level, String) {
        let sign = trust::signs(&self.case, &self.run).into_iter().find(|sign| sign.name == name).unwrap();
        (sign.level, sign.reason)
    }
}

/// Text between two marks.
fn between<'a>(page: &'a str, from: &str, to: &str) -> &'a str {
    page.split_once(from).unwrap().1.split_once(to).unwrap().0
}

#[test]
fn every_part_is_there_and_nothing_asks_for_a_network() {
    let shot = Shot::new(&[]);
    let page = shot.page();
    for id in PARTS {
        assert_eq!(page.matches(&format!("id=\"{id}\"")).count(), 1, "{id}");
    }
    for scheme in ["http:", "https:", "//cdn", "@import", "url("] {
        assert!(!page.contains(scheme), "{scheme}");
    }
    assert!(page.contains("default-src 'none'"));
    assert_eq!(page.matches("<image").count(), 3);
    let unbroken = page.replace("<wbr>", "");
    for field in &shot.case.fields {
        assert!(unbroken.contains(&format!("<code>{}</code>", field.pointer)), "{}", field.pointer);
    }
    assert!(page.len() < 1_500_000, "{}", page.len());
}

#[test]
fn without_a_projectile_and_without_pictures_the_rest_is_there() {
    let mut shot = Shot::new(&["/projectile=null", "/pack/initial_velocity_m_s=[0,0,1]"]);
    let page = shot.page();
    assert!(!page.contains("id=\"velocity\"") && page.contains("id=\"playback\"") && page.contains(">done</h1>"));
    shot.animation = Animation::new(&shot.case);
    let page = shot.page();
    assert!(!page.contains("id=\"playback\"") && !page.contains("id=\"tension\"") && page.contains("id=\"unit-cell\""));
}

#[test]
fn the_verdict_of_each_outcome_comes_first() {
    let mut shot = Shot::new(&[]);
    let outcomes = [
        (Outcome::Perforated, "perforated", "went through the ply and leaves at"),
        (Outcome::Stopped, "stopped", "stopped the projectile, which struck at 600 m/s, 7 µs after impact"),
        (Outcome::Rebounded, "rebounded", "turned the projectile 7 µs after impact"),
        (Outcome::Running, "undecided", "Not decided"),
    ];
    for (outcome, word, story) in outcomes {
        shot.run.outcome = outcome;
        shot.run.stop_time = Some(7e-6);
        let page = shot.page();
        let header = between(&page, "<header>", "</header>");
        assert!(header.contains(&format!("verdict {}\">{word}</h1>", outcome.word())), "{header}");
        assert!(header.contains(story), "{header}");
        assert!(page.find("<header>") < page.find("<figure"), "{word}");
        assert!(!header.contains("rebound velocity"), "{header}");
    }
    shot.run.outcome = Outcome::Rebounded;
    shot.run.rebound_velocity = Some(12.3);
    let page = shot.page();
    let header = between(&page, "<header>", "</header>");
    for told in ["flies back at 12.3 m/s", "<dt>rebound velocity</dt><dd>12.3 m/s <small>of 600 m/s</small>"] {
        assert!(header.contains(told), "{header}");
    }
}

#[test]
fn a_run_that_broke_off_says_so_before_anything_else() {
    let break_off: [(&str, Change); 3] = [
        ("unstable", |run| {
            run.divergence =
                Some(Divergence { step: 7, kernel: "node_update", quantity: "v = NaN".into(), place: [0, 3, 5] });
            run.energy_error = f64::NAN;
            for row in &mut run.history[5..] {
                row.balance.kinetic = f64::NAN;
                row.contact_force = f64::INFINITY;
                row.projectile_velocity = f64::NAN;
            }
        }),
        ("interrupted", |run| run.interrupted = true),
        ("device lost", |run| run.lost = Some("it went <away>".to_owned())),
    ];
    for (word, change) in break_off {
        let mut shot = Shot::new(&[]);
        shot.run.outcome = Outcome::Stopped;
        change(&mut shot.run);
        let page = shot.page();
        let header = between(&page, "<header>", "</header>");
        assert!(header.contains(&format!("verdict broken-off\">{word}</h1>")), "{header}");
        assert!(header.contains("The run broke off") && header.contains("answer bad"), "{header}");
        let drawings = between(&page, "id=\"plots\"", "id=\"trust\"");
        assert!(!drawings.contains("NaN,") && !drawings.contains(",NaN") && !drawings.contains("inf,"), "{word}");
        assert!(!page.contains("<away>"));
    }
}

#[test]
fn every_level_of_trust_can_be_reached() {
    let set: [Ladder; 8] = [
        ("work balance", |s, x| s.run.energy_error = x, [1e-6, 1e-3, 0.14]),
        ("momentum error", |s, x| s.run.momentum_error = x, [1e-6, 1e-3, f64::NAN]),
        ("hourglass / internal energy", |s, x| s.run.hourglass_fraction = x, [0.05, 0.06, 0.14]),
        ("fabric inside the projectile", |s, x| s.run.max_penetration = x, [0.5e-3, 1.0e-3, 4e-3]),
        (
            "unit cells unsolved",
            |s, x| (s.run.element_steps_computed, s.run.newton.unconverged) = (1_000_000_000, x as u64),
            [0.0, 1.0, 1e6],
        ),
        ("end of the run", |s, x| s.run.interrupted = x > 1.0, [0.0, 0.0, 2.0]),
        (
            "energy of the unit-cell law",
            |s, x| s.run.history.last_mut().unwrap().balance.law = x * s.run.impact_energy,
            [0.01, 0.07, 0.14],
        ),
        ("plies inside each other", |s, x| (s.run.plies, s.run.max_ply_penetration) = (2, x), [0.2e-3, 0.5e-3, 7e-3]),
    ];
    let mut shot = Shot::new(&[]);
    for (name, change, values) in set {
        let mut reasons = Vec::new();
        for (value, level) in values.into_iter().zip([Level::Fine, Level::Look, Level::Bad]) {
            change(&mut shot, value);
            let (found, reason) = shot.level(name);
            // A run that ends has no level in between.
            assert_eq!(
                found,
                if name == "end of the run" && level == Level::Look { Level::Fine } else { level },
                "{name} {value}"
            );
            reasons.push(reason);
        }
        assert_ne!(reasons[0], reasons[2], "{name}");
        let page = shot.page();
        // The report and the terminal's line of trust say the same.
        let advice = &output::summary(&shot.case, &shot.run, 1.0)["trust"]["advice"];
        assert_eq!(advice, "do not use", "{name}");
        assert!(page.contains("answer bad") && page.contains("</span> Do not use:</b>"), "{name}");
        assert!(page.contains("<span class=\"level bad\">do not use</span>"), "{name}");
        shot = Shot::new(&[]);
    }
    for (name, change) in [
        ("crossovers per element", "/pack/crossovers_per_element=2"),
        ("projectile width", "/projectile/diameter_mm=3"),
    ] {
        let other = Shot::new(&[change]);
        assert_eq!(shot.level(name).0, Level::Fine, "{name}");
        assert_eq!(other.level(name).0, Level::Look, "{name}");
    }
    let place = |changes: &[&str]| Shot::new(changes).level("sensitivity to the mesh under the hit").0;
    let (slow, rim) = ("/projectile/velocity_m_s=20", "/solver/contact_sampling=edges");
    assert_eq!([place(&[]), place(&[rim])], [Level::Look; 2]);
    assert_eq!(place(&[slow]), Level::Fine);
    let ball = r#"/projectile={"shape": "sphere", "diameter_mm": 5.5, "mass_g": 3, "velocity_m_s": 600}"#;
    assert_eq!(place(&[ball]), Level::Fine);
    for (gained, level) in [(0.009, Level::Fine), (-0.02, Level::Look), (0.2, Level::Bad), (f64::NAN, Level::Bad)] {
        shot.run.energy_gained = gained;
        assert_eq!(shot.level("energy gained").0, level, "{gained}");
    }
}

#[test]
fn assumed_parameters_are_named_with_their_values() {
    let shot = Shot::new(&[]);
    let page = shot.page();
    let list = between(&page, "<ul class=\"assumed\">", "</ul>").replace("<wbr>", "");
    let assumed: Vec<_> = shot.case.fields.iter().filter(|field| field.assumed).collect();
    assert_eq!(list.matches("<li>").count(), assumed.len());
    assert!(assumed.len() > 5 && list.contains("<code>/fabric/shear/g1_mpa</code> <b>10 MPa</b>"), "{list}");
    assert!(between(&page, "<header>", "</header>").contains(&format!(
        "{} of {} parameters",
        assumed.len(),
        shot.case.fields.len()
    )));
}

#[test]
fn what_a_user_wrote_is_words() {
    let evil = "</title></script><script>alert(1)</script><!--\"'&";
    let change = format!("/title={}", json!(evil));
    let name = format!("/fabric/name={}", json!(evil));
    let plain = Shot::new(&[]).page();
    let page = Shot::new(&[change.as_str(), name.as_str()]).page();
    assert!(page.contains("&lt;/title&gt;&lt;/script&gt;&lt;script&gt;alert(1)"));
    assert!(!page.contains("<script>alert") && !page.contains("<!--"));
    for tag in ["<script", "</script", "<title", "</title"] {
        assert_eq!(page.matches(tag).count(), plain.matches(tag).count(), "{tag}");
    }
}

#[test]
fn the_same_run_gives_the_same_page() {
    let one = Shot::new(&[]);
    let mut two = Shot::with_threads(one.case.clone(), 2);
    two.run.threads = one.run.threads;
    two.run.loop_seconds = one.run.loop_seconds;
    two.run.kernel_seconds = one.run.kernel_seconds.clone();
    assert!(one.page() == two.page());
}

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
fn deflection_over_time_is_that_of_fabric_that_hangs_on_an_edge() {
    let shot = Shot::new(&TORN);
    let (animation, debris) = (&shot.animation, shot.run.history.last().unwrap().deflection);
    let largest = animation.deflection();
    assert!((largest / shot.run.deflection() - 1.0).abs() < 0.1, "{largest} {}", shot.run.deflection());
    assert!(largest < 0.5 * debris, "{largest} {debris}");
    let page = shot.page();
    let figure = between(&page, "id=\"deflection\"", "</figure>");
    let last = animation.keyframes.last().unwrap().deflection();
    assert!(figure.contains(&format!("<td>{}</td>", output::number::short(1e3 * last, 4))), "{last}");
}

#[test]
fn what_shows_nothing_takes_a_line() {
    let page = Shot::new(&["/projectile/velocity_m_s=20"]).page();
    assert_eq!(between(&page, "id=\"failures\">", "</p>"), "<b>Failed yarns:</b> none.");
    let broken = Shot::new(&[]).page();
    assert!(between(&broken, "id=\"failures\">", "</figure>").contains("yarns of the warp and"));
}

#[test]
fn energy_below_zero_is_drawn_below_zero() {
    let mut shot = Shot::new(&[]);
    let areas = |page: &str| between(page, "id=\"energy\"", "</svg>").matches("<polygon").count();
    let before = areas(&shot.page());
    let from = shot.run.history.len() / 2;
    for row in &mut shot.run.history[from..] {
        row.balance.separation = 0.2 * shot.run.impact_energy;
    }
    let page = shot.page();
    let figure = between(&page, "id=\"energy\"", "</figure>");
    assert_eq!(areas(&page), before + 1);
    assert!(figure.contains("What is below zero was given") && figure.contains("ply separation"));
    let axis: Vec<f64> = between(figure, "data-y=\"", "\"").split(' ').map(|n| n.parse().unwrap()).collect();
    assert!(axis[0] <= -0.2 * shot.run.impact_energy, "{axis:?}");
}

#[test]
fn early_maps_have_a_scale_of_their_own() {
    let page = Shot::new(&[]).page();
    let maps = between(&page, "id=\"tension\"", "</figure>");
    let scales: Vec<f64> =
        maps.split("</i><span>").skip(1).map(|part| between(&format!("|{part}"), "|", " N").parse().unwrap()).collect();
    assert_eq!(scales.len(), 3);
    // That of the whole shot is that of the map before the first failure.
    let [early, most, _] = scales[..] else { panic!("{scales:?}") };
    assert!(early <= most, "{scales:?}");
    let slow = Shot::new(&["/projectile/velocity_m_s=60", "/solver/end_time_us=200"]);
    let strip = &slow.animation.strips[0];
    let peak = f64::from(slow.animation.shown().peak_tension());
    let maps = slow.page();
    let maps = between(&maps, "id=\"tension\"", "</figure>");
    let text = |tension: f64| format!("<span>{} N</span>", output::number::short(tension, 3));
    assert!(maps.contains(&text(peak)) && strip.cells() > 0);
}

#[test]
fn plies_have_their_energies_over_time() {
    let page = Shot::new(&["/pack/plies=3", "/solver/end_time_us=4"]).page();
    let figure = between(&page, "id=\"plies\"", "</figure>");
    assert_eq!(figure.matches("<polyline").count(), 3);
    assert!(figure.contains("ply 3 [J]"));
    assert!(!Shot::new(&[]).page().contains("id=\"plies\""));
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
