//! `report.html` and its animation. That the page works in a browser is in `tests/external.rs`.
//!
//! Promise: the verdict comes first and says when a run broke off; every level of a check can be reached and gives its reason; what a
//! user wrote is words; nothing is asked of a network; keyframes lie evenly over a run and show what the history says.

use std::sync::atomic::AtomicBool;

use ripstop::case::{self, Case};
use ripstop::output;
use ripstop::output::checks::{Level, checks};
use ripstop::output::report::report;
use ripstop::output::{Animation, Keyframe};
use ripstop::run::outcome::Outcome;
use ripstop::run::{self, Options, Run};
use ripstop::solver::Divergence;
use serde_json::{Value, json};

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
        let mut animation = Animation::new(&case);
        let options = Options::default().threads(1);
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
    let level = |changes: &[&str]| Shot::new(changes).level("place of the hit").0;
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
fn what_has_no_rim_is_not_told_to_round_it() {
    let round =
        [r#""cylinder","length_mm":9,"edge_radius_mm":2.75"#, r#""cone","length_mm":9"#, r#""sphere""#, r#""bar""#];
    for shape in round.into_iter().chain([r#""cylinder","length_mm":12"#]) {
        let body = format!(r#"/projectile={{"shape":{shape},"diameter_mm":5.5,"mass_g":3,"velocity_m_s":900}}"#);
        let shot = Shot::new(&[&body, "/pack/edges=free", "/solver/contact_sampling=edges"]);
        let (_, reason) = shot.level("sensitivity to the mesh under the hit");
        assert!(!shot.run.events.is_empty() && reason.contains("rim") != round.contains(&shape), "{shape}: {reason}");
    }
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
    let outcomes = [
        (Outcome::Perforated, "perforated", "Leaves at"),
        (Outcome::Stopped, "stopped", "At 7.0 µs, struck at 600 m/s, deflected"),
        (Outcome::Rebounded, "rebounded", "Turned at 7.0 µs, flies at"),
        (Outcome::Running, "undecided", "raise /solver/end_time_us for a verdict"),
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
        assert!(header.contains("answer bad"), "{header}");
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
            |s, x| {
                (s.run.element_steps_computed, s.run.newton.unconverged) = (1_000_000_000, x as u64);
                s.run.newton.max_residual = 1e-3;
            },
            [0.0, 1.0, 1e6],
        ),
        ("end of the run", |s, x| s.run.interrupted = x > 1.0, [0.0, 0.0, 2.0]),
        (
            "energy of the unit-cell law",
            |s, x| s.run.history.last_mut().unwrap().balance.law = x * s.run.exchanged_energy,
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
fn energies_and_profiles_are_drawn_where_there_are_any() {
    let mut shot = Shot::new(&["/output/profile_times_us=[2,4]"]);
    let lines = |page: &str, id: &str| between(page, &format!("id=\"{id}\""), "</figure>").matches("<polyline").count();
    let before = shot.page();
    assert_eq!(lines(&before, "profile"), 2);
    let from = shot.run.history.len() / 2;
    for row in &mut shot.run.history[from..] {
        row.balance.separation = 0.2 * shot.run.impact_energy;
    }
    let page = shot.page();
    let figure = between(&page, "id=\"energy\"", "</figure>");
    assert_eq!(lines(&page, "energy"), lines(&before, "energy") + 1);
    assert!(figure.contains("ply separation"));
    let axis: Vec<f64> = between(figure, "data-y=\"", "\"").split(' ').map(|n| n.parse().unwrap()).collect();
    assert!(axis[0] <= -0.2 * shot.run.impact_energy, "given is below zero: {axis:?}");
}

#[test]
fn keyframes_lie_evenly_over_a_run_whenever_it_ends_and_open_at_the_largest_deflection() {
    for changes in [&["/solver/end_time_us=16", "/solver/run_until=end_time"][..], &["/solver/end_time_us=400"], &TORN]
    {
        let shot = Shot::new(changes);
        let (end, step) = (shot.run.history.last().unwrap().time, shot.run.time_step);
        let animation = &shot.animation;
        let times: Vec<f64> = animation.keyframes.iter().map(|keyframe| keyframe.time).collect();
        let last = times.len() - 1;
        let gap = times[last - 1] / (last - 1) as f64;
        assert!((20..=82).contains(&times.len()) && times[0] == 0.0, "{times:?}");
        assert!((times[last] - end).abs() < 2.0 * step && end - times[last - 1] < gap + 2.0 * step, "{times:?} {end}");
        let all = times[..last].iter().enumerate();
        let off = all.map(|(n, time)| (time / gap - n as f64).abs()).fold(0.0, f64::max);
        assert!(off <= step / gap, "{times:?}");
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
        let page: Value = serde_json::from_str(between(&shot.page(), "id=\"animation\">", "</script>")).unwrap();
        assert_eq!(page["opening"], animation.opening());
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

#[test]
fn a_thick_pack_shows_some_plies_and_says_which() {
    let page = Shot::new(&["/pack/plies=12", "/solver/end_time_us=4", "/output/history_interval_us=2"]).page();
    assert_eq!(between(&page, "Of 12 plies these are shown: ", "."), "1, 3, 4, 6, 7, 9, 10, 12");
    assert!(page.len() < 5_000_000, "{}", page.len());
}
