//! `report.html` and its animation. That the page works in a browser is in `tests/external.rs`.
//!
//! Promise: the verdict comes first and says when a run broke off; every level of a check can be reached and gives its reason; what a
//! user wrote is words; nothing is asked of a network; keyframes show what the history says.

use ripstop::case::Case;
use ripstop::output;
use ripstop::output::checks::{ENERGY_LIMIT, Level, checks, warnings};
use ripstop::output::report::report;
use ripstop::output::{Animation, Keyframe};
use ripstop::run::outcome::Outcome;
use ripstop::run::{Options, Run};
use ripstop::solver::Divergence;
use serde_json::json;

use crate::support::read;

/// Every part of the page.
const PARTS: [&str; 10] =
    ["playback", "plots", "velocity", "force", "deflection", "energy", "failures", "trust", "case", "machine"];

/// Changes that make a shot throw debris ahead.
const TORN: [&str; 5] = [
    "/pack/width_mm=50",
    "/pack/height_mm=45",
    "/projectile/velocity_m_s=430",
    "/solver/end_time_us=80",
    "/solver/run_until=end_time",
];

/// What makes a run another one.
type Change = fn(&mut Run);
/// A sign of trust, the code of its warning, how to give it a value, and values that are fine, to be looked at, and bad.
type Ladder = (&'static str, Option<&'static str>, fn(&mut Shot, f64), [f64; 3]);

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
        let case = read("shot", &text.to_string(), changes);
        let mut animation = Animation::new(&case);
        let run = Options::default().threads(1).observe(&case, &mut animation).unwrap();
        Self { case, run, animation }
    }

    fn page(&self) -> String {
        report(&self.case, &self.run, &output::summary(&self.case, &self.run, 1.0), &self.animation)
    }

    fn warns(&self, code: &str) -> bool {
        warnings(&self.case, &checks(&self.case, &self.run)).iter().any(|warning| warning.kind.code == code)
    }

    fn level(&self, name: &str) -> Level {
        checks(&self.case, &self.run).into_iter().find(|check| check.name == name).unwrap().level
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
    for field in &shot.case.fields {
        let mark = if field.assumed { "* " } else { "" };
        assert!(page.contains(&format!("{mark}<code>{}</code>", field.pointer)), "{}", field.pointer);
    }
    let assumed = shot.case.fields.iter().filter(|field| field.assumed).count();
    let words = format!("{assumed} of {} parameters", shot.case.fields.len());
    assert!(assumed > 5 && between(&page, "<header>", "</header>").contains(&words), "{words}");
    assert!(page.len() < 1_500_000, "{}", page.len());
}

#[test]
fn what_the_frame_took_is_not_the_fabrics() {
    let level = |changes: &[&str]| Shot::new(changes).level("place of the hit");
    // The pack has 30.48 mm, the projectile a radius of 2.75 mm.
    assert_eq!(level(&["/projectile/offset_mm=[12.4,0]"]), Level::Fine);
    assert_eq!(level(&["/projectile/offset_mm=[12.6,0]"]), Level::Bad);
    assert_eq!(level(&["/projectile/offset_mm=[12.6,0]", "/pack/edges=free"]), Level::Fine);
    assert_eq!(level(&["/projectile/offset_mm=[19,0]", "/pack/edges=free"]), Level::Look, "beside it");
    // Wider than the pack: it strikes the middle alone, until it is through.
    let ball = r#"/projectile={"shape":"sphere","diameter_mm":40,"mass_g":250,"velocity_m_s":600}"#;
    assert_eq!(level(&[ball, "/projectile/velocity_m_s=60"]), Level::Look);
    assert_eq!(level(&[ball, "/solver/end_time_us=100"]), Level::Bad);
}

#[test]
fn without_a_projectile_and_without_pictures_the_rest_is_there() {
    let mut shot = Shot::new(&["/projectile=null", "/pack/initial_velocity_m_s=[0,0,1]"]);
    let page = shot.page();
    assert!(!page.contains("id=\"velocity\"") && page.contains("id=\"playback\"") && page.contains(">done</h1>"));
    shot.animation = Animation::new(&shot.case);
    let page = shot.page();
    assert!(!page.contains("id=\"playback\"") && page.contains("id=\"energy\""));
}

#[test]
fn the_verdict_of_each_outcome_comes_first() {
    let mut shot = Shot::new(&[]);
    for (outcome, rebound, story) in [
        (Outcome::Perforated, None, "Leaves at"),
        (Outcome::Stopped, None, "At 7.0 µs, struck at 600 m/s, deflected"),
        (Outcome::Rebounded, Some(12.3), "flies back at 12.3 m/s"),
        (Outcome::Running, None, "raise /solver/end_time_us for a verdict"),
    ] {
        (shot.run.outcome, shot.run.stop_time, shot.run.rebound_velocity) = (outcome, Some(7e-6), rebound);
        let page = shot.page();
        let header = between(&page, "<header>", "</header>");
        assert!(header.contains(&format!("verdict {}\">", outcome.word())) && header.contains(story), "{header}");
        assert!(page.find("<header>") < page.find("<figure"), "{outcome:?}");
        assert_eq!(header.contains("rebound velocity"), rebound.is_some(), "{header}");
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
        assert!(header.contains("answer bad"), "{header}");
        let drawings = between(&page, "id=\"plots\"", "id=\"trust\"");
        assert!(!drawings.contains("NaN,") && !drawings.contains(",NaN") && !drawings.contains("inf,"), "{word}");
        assert!(!page.contains("<away>"));
    }
}

#[test]
fn every_level_of_trust_can_be_reached() {
    let set: [Ladder; 8] = [
        ("work balance", None, |s, x| s.run.energy_error = x, [1e-6, 1e-3, 0.14]),
        ("momentum error", None, |s, x| s.run.momentum_error = x, [1e-6, 1e-3, f64::NAN]),
        ("hourglass / internal energy", Some("W3"), |s, x| s.run.hourglass_fraction = x, [0.05, 0.06, 0.14]),
        ("fabric inside the projectile", Some("W4"), |s, x| s.run.max_penetration = x, [0.5e-3, 1.0e-3, 4e-3]),
        (
            "unit cells unsolved",
            None,
            |s, x| {
                (s.run.element_steps_computed, s.run.newton.unconverged) = (1_000_000_000, x as u64);
                s.run.newton.max_residual = 1e-3;
            },
            [0.0, 1.0, 1e6],
        ),
        ("end of the run", None, |s, x| s.run.interrupted = x > 1.0, [0.0, 0.0, 2.0]),
        (
            "energy of the unit-cell law",
            None,
            |s, x| s.run.history.last_mut().unwrap().balance.law = x * s.run.exchanged_energy,
            [0.01, 0.07, 0.14],
        ),
        (
            "plies inside each other",
            Some("W4"),
            |s, x| (s.run.plies, s.run.max_ply_penetration) = (2, x),
            [0.2e-3, 0.5e-3, 7e-3],
        ),
    ];
    let mut shot = Shot::new(&[]);
    for (name, code, change, values) in set {
        for (value, level) in values.into_iter().zip([Level::Fine, Level::Look, Level::Bad]) {
            change(&mut shot, value);
            // A run that ends has no level in between.
            let level = if name == "end of the run" && level == Level::Look { Level::Fine } else { level };
            assert_eq!(shot.level(name), level, "{name} {value}");
            assert!(code.is_none_or(|code| shot.warns(code) == (level != Level::Fine)), "{name} {value}");
        }
        // The report and the terminal's line of trust say the same.
        assert_eq!(output::summary(&shot.case, &shot.run, 1.0)["trust"]["advice"], "do not use", "{name}");
        assert!(shot.page().contains("<span class=\"level bad\">do not use</span>"), "{name}");
        shot = Shot::new(&[]);
    }
    for (name, change) in [
        ("crossovers per element", "/pack/crossovers_per_element=2"),
        ("projectile width", "/projectile/diameter_mm=3"),
    ] {
        let other = Shot::new(&[change]);
        assert_eq!(shot.level(name), Level::Fine, "{name}");
        assert_eq!(other.level(name), Level::Look, "{name}");
    }
    let place = |changes: &[&str]| Shot::new(changes).level("sensitivity to the mesh under the hit");
    let (slow, rim) = ("/projectile/velocity_m_s=20", "/solver/contact_sampling=edges");
    assert_eq!([place(&[]), place(&[rim])], [Level::Look; 2]);
    assert_eq!(place(&[slow]), Level::Fine);
    let ball = r#"/projectile={"shape": "sphere", "diameter_mm": 5.5, "mass_g": 3, "velocity_m_s": 600}"#;
    assert_eq!(place(&[ball]), Level::Fine);
    for (gained, level) in [(0.009, Level::Fine), (-0.02, Level::Look), (0.2, Level::Bad), (f64::NAN, Level::Bad)] {
        shot.run.energy_gained = gained;
        assert_eq!((shot.level("energy gained"), shot.warns("W2")), (level, level != Level::Fine), "{gained}");
    }
    shot.run.energy_gained = 0.0;
    for (error, is_warned) in [(ENERGY_LIMIT, false), (1.001 * ENERGY_LIMIT, true), (f64::NAN, true)] {
        shot.run.energy_error = error;
        assert_eq!(shot.warns("W2"), is_warned, "{error}");
    }
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
fn shares_are_of_all_that_was_put_in() {
    // Of 2.4 J that the fabric holds before the shot, a projectile that loses 0.1 J lets loose the most.
    let pretension = r#"/pack/pretension={"warp_n_per_m": 200000, "weft_n_per_m": 200000}"#;
    let sets = ["/projectile/mass_g=0.3", "/projectile/velocity_m_s=100", "/solver/end_time_us=60"];
    // A bar that is drawn out of the way gives up nothing; a ply that flies against a body at rest gives it something.
    let driven = [r#"/projectile={"shape": "bar", "diameter_mm": 4, "velocity_m_s": 100, "motion": "prescribed"}"#];
    let flying = ["/pack/initial_velocity_m_s=[0,0,-100]", "/projectile/velocity_m_s=0.01", "/pack/edges=free"];
    for sets in
        [&[&sets[..], &[pretension]].concat()[..], &[&driven[..], &[pretension]].concat(), &driven, &flying, &[]]
    {
        let shot = Shot::new(sets);
        let energies = output::Energies::of(&shot.run).unwrap();
        let shares: Vec<f64> = energies.shares.iter().map(|share| share.1 / energies.given).collect();
        assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{sets:?}: {energies:?}");
        assert!(shares.iter().all(|share| (-0.15..=1.02).contains(share)), "{sets:?}: {energies:?}");
        assert!(shares.last().unwrap().abs() < 0.02, "{sets:?}: {energies:?}");
        assert!(shot.page().contains(&energies.text(energies.given)), "{sets:?}");
    }
}

#[test]
fn keyframes_reach_the_end_of_a_run_whenever_it_ends_and_open_at_the_largest_deflection() {
    for changes in [&["/solver/end_time_us=16", "/solver/run_until=end_time"][..], &["/solver/end_time_us=400"], &TORN]
    {
        let shot = Shot::new(changes);
        let animation = &shot.animation;
        let (end, count) = (shot.run.history.last().unwrap().time, animation.keyframes.len());
        assert!((20..=82).contains(&count) && animation.keyframes[0].time == 0.0, "{count}");
        assert!((animation.keyframes[count - 1].time - end).abs() < 2.0 * shot.run.time_step, "{end}");
        // It opens where the projectile, 12 mm long, has not left the fabric behind.
        let (opening, last) = (&animation.keyframes[animation.opening()], animation.keyframes.last().unwrap());
        let ahead = |keyframe: &Keyframe| keyframe.pose.unwrap().position[2] - keyframe.deflection();
        assert!(ahead(opening) < 0.007, "{}", ahead(opening));
        if changes == TORN {
            assert!(ahead(last) > 0.02, "{}", ahead(last));
            // Debris that flies ahead does not count.
            let debris = last.displacement.iter().fold(0.0_f32, |most, u| most.max(u[2]));
            let shown = animation.deflection();
            let held = shot.run.history.iter().map(|row| row.deflection).fold(0.0, f64::max);
            assert!((shown / held - 1.0).abs() < 0.1 && shown < 0.5 * f64::from(debris), "{shown} {held} {debris}");
        }
    }
}

#[test]
fn a_keyframe_shows_what_is_there() {
    const EVEN: &[&str] = &[
        "/solver/end_time_us=80",
        "/solver/numerics=default",
        "/pack/mesh_grading=none",
        "/pack/elements_per_crossover=1",
        "/output/history_interval_us=0.01",
        "/projectile/velocity_m_s=100",
    ];
    let shot = Shot::new(&[&["/solver/symmetry=none"], EVEN].concat());
    let last = shot.animation.keyframes.last().unwrap();
    let broken = |yarn: usize| last.tension.iter().filter(|cell| cell[yarn].is_none()).count() as u64;
    assert!(broken(0) > 0 && broken(1) > 0);
    assert_eq!([broken(0), broken(1)], shot.run.history.last().unwrap().failed);
    // A yarn breaks at its modulus times failure strain times cross-section; shear adds little.
    let yarn = &shot.case.fabric.warp;
    let strength = yarn.modulus * yarn.failure_strain * yarn.area(shot.case.fabric.fibre_density);
    let peak = f64::from(shot.animation.peak_tension());
    assert!((0.8..1.1).contains(&(peak / strength)), "{peak} of {strength}");
    // A quarter of it is the same as the whole.
    let quarter = Shot::new(EVEN);
    let part = quarter.animation.keyframes.last().unwrap();
    assert_eq!(part.tension.len() * 4, last.tension.len());
    let [a, b] = [part, last].map(|keyframe| *keyframe.tension.last().unwrap());
    assert!((0..2).all(|yarn| (a[yarn].unwrap() - b[yarn].unwrap()).abs() < 1e-3), "{a:?} {b:?}");
}
