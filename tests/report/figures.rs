//! Curves and maps of the report.

use ripstop::output;

use super::{Shot, TORN, between};

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
