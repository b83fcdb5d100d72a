//! `fit.html`: tables and figures.

use maud::{Markup, html};

use super::Fit;
use super::draw::plots;
use super::text::notes;
use crate::output::number::short;
use crate::study::page::{arithmetic_table, document, figures, quantile_row, remarks, residual_table, table};

/// The page. `title`: what was fitted.
pub fn html(fit: &Fit, title: &str) -> String {
    document(&format!("Ballistic limit: {title}"), &sections(fit), "fit.json")
}

/// Sections of the fit, without a page around them.
pub(in crate::study) fn sections(fit: &Fit) -> Markup {
    let rows = fit.quantiles.iter().map(|of| quantile_row(format!("{} %", short(100.0 * of.p, 3)), of));
    let title = format!("Velocities by chance, {}, {} intervals", fit.request.link.word(), fit.request.interval.word());
    let heads = ["chance of a perforation", "velocity [m/s]", "low [m/s]", "high [m/s]"];
    html! {
        p class="answer" { (answer(fit)) }
        (remarks(&notes(fit)))
        (figures(&plots(fit)))
        (table(&title, &heads, rows))
        (arithmetic_table("Arithmetic V50", &fit.arithmetic))
        (residual_table("Residual velocity, Vr = a (Vs^p − V₀^p)^(1/p)", "V₀ [m/s]", &fit.residual))
    }
}

/// V50 and σ in one sentence.
fn answer(fit: &Fit) -> String {
    let [perforated, stopped] = fit.outcomes.counts();
    let shots = format!("{} shots: {perforated} perforated, {stopped} stopped.", perforated + stopped);
    match (&fit.estimate, fit.v50()) {
        (Ok(found), Some(v50)) => {
            let [low, high] = v50.bounds.words();
            let level = short(100.0 * fit.request.level, 3);
            let sigma = short(found.sigma, 3);
            format!("{shots} V50 {} m/s, {level} % interval {low} to {high} m/s; σ {sigma} m/s.", short(found.mu, 4))
        }
        _ => shots,
    }
}
