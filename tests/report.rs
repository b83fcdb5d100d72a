//! `report.html`: what it says. That it works in a browser is in `tests/browser.rs`.
//!
//! Promise: the verdict comes first and says when a run broke off; every level of trust can be reached and gives its reason; what a
//! user wrote is words; nothing is asked of a network; but for machine and timing the same run gives the same page; it stays
//! below 5 MB.

mod figures;
mod playback;

use std::sync::atomic::AtomicBool;

use ripstop::case::{self, Case};
use ripstop::output;
use ripstop::output::checks::{Level, checks};
use ripstop::output::report::{Animation, report};
use ripstop::run::outcome::Outcome;
use ripstop::run::{self, Options, Run};
use ripstop::solver::Divergence;
use serde_json::json;

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
        let options = Options::default().threads(threads);
        let run = run::run(&case, options, &AtomicBool::new(false), &mut animation).unwrap();
        Self { case, run, animation }
    }

    fn page(&self) -> String {
        report(&self.case, &self.run, &output::summary(&self.case, &self.run, 1.0), &self.animation)
    }

    fn level(&self, name: &str) -> (Level, String) {
        let check = checks(&self.case, &self.run).into_iter().find(|check| check.name == name).unwrap();
        (check.level, check.reason)
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
