//! The parts of the page in words: verdict, trust, energy, expectations, the case, machine and timing.

use std::fmt::Write;

use serde_json::Value;

use super::super::breakage::Breakage;
use super::super::chart::escape;
use super::super::checks::{self, Check, Level, assumed_fields};
use super::super::energies::{self, Energies};
use super::super::expectation::{Judgement, expected, got, judgement, note, quantity};
use super::super::number::{fixed, grouped, short};
use super::super::summary::{absorbed_energy, flies_freely, residual_velocity};
use super::super::verdict::{reached, symmetry, verdict};
use crate::case::{self, Case};
use crate::run::Run;
use crate::run::outcome::Outcome;

/// The verdict, told to somebody who has never seen one, with the numbers that go with it.
pub(super) fn header(case: &Case, run: &Run, signs: &[Check]) -> String {
    let verdict = verdict(case, run);
    let class = if verdict.complete { run.outcome.word() } else { "broken-off" };
    let (word, title) = (escape(verdict.word), escape(&case.title));
    let mut out = format!(
        "<header>\n<p class=\"over\">{title}</p>\n<h1 class=\"verdict {class}\">{word}</h1>\n<p class=\"story\">{}</p>\n\
         <dl class=\"figures\">\n",
        escape(&story(case, run))
    );
    for (name, number, more) in figures(case, run) {
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "<div><dt>{}</dt><dd>{} <small>{}</small></dd></div>",
            escape(name),
            escape(&number),
            escape(&more)
        );
    }
    out + "</dl>\n" + &answer(case, signs) + "</header>\n"
}

/// What happened, in a sentence or two.
fn story(case: &Case, run: &Run) -> String {
    let verdict = verdict(case, run);
    if !verdict.complete {
        return format!("The run broke off and did not reach its end: {} {}.", verdict.word, verdict.detail);
    }
    if !flies_freely(case) {
        return format!("{} computed. No projectile flies freely here, so there is no verdict.", reached(run));
    }
    let struck = case.projectile.as_ref().map_or(0.0, |p| p.velocity);
    let left = residual_velocity(case, run).unwrap_or(0.0);
    let (speed, before) = (short(left, 3), short(struck, 4));
    let pack = if run.plies == 1 { "the ply".to_owned() } else { format!("all {} plies", run.plies) };
    let stop = run.stop_time.map_or(String::new(), |time| format!(" {} µs after impact", short(time * 1e6, 3)));
    let went = if run.is_unbroken() {
        format!("passed {pack} without breaking a yarn")
    } else {
        format!("went through {pack}")
    };
    match run.outcome {
        Outcome::Perforated => format!(
            "The projectile {went} and leaves at {speed} m/s, {} % of the {before} m/s it struck with.",
            fixed(100.0 * left / struck, 0)
        ),
        Outcome::Stopped => {
            let carried =
                run.carried_velocity.map(|speed| format!(" It flies on with it, at {} m/s.", short(speed, 3)));
            let carried = carried.unwrap_or_default();
            format!("The fabric stopped the projectile, which struck at {before} m/s,{stop}.{carried}")
        }
        Outcome::Rebounded => {
            let flies = match run.rebound_velocity {
                Some(rebound) => format!("flies back at {}", short(rebound, 3)),
                None => format!("flies off at {}", short(left.abs(), 3)),
            };
            format!("The fabric turned the projectile{stop}: it struck at {before} m/s and {flies} m/s.")
        }
        Outcome::Running => format!(
            "Not decided: the computation ended at {}, the projectile still flying at {speed} of {before} m/s. \
             Raise /solver/end_time_us for a verdict.",
            reached(run)
        ),
    }
}

/// Name, number and remark.
fn figures(case: &Case, run: &Run) -> Vec<(&'static str, String, String)> {
    let mut all = Vec::new();
    if let (Some(projectile), Some(left)) = (&case.projectile, residual_velocity(case, run)) {
        let name = if run.outcome == Outcome::Perforated { "leaves at" } else { "velocity left" };
        let struck = format!("of {} m/s", short(projectile.velocity, 4));
        all.push((name, format!("{} m/s", short(left, 3)), struck.clone()));
        if let Some(rebound) = run.rebound_velocity {
            all.push(("rebound velocity", format!("{} m/s", short(rebound, 3)), struck.clone()));
        }
        if let Some(carried) = run.carried_velocity {
            all.push(("carried along at", format!("{} m/s", short(carried, 3)), struck));
        }
    }
    if run.impact_energy > 0.0 {
        let absorbed = absorbed_energy(run);
        let share =
            format!("{} % of {} J", fixed(100.0 * absorbed / run.impact_energy, 0), short(run.impact_energy, 3));
        all.push(("energy absorbed", format!("{} J", short(absorbed, 3)), share));
    }
    all.push(("largest deflection", format!("{} mm", short(run.deflection() * 1e3, 3)), String::new()));
    let last = run.history.last();
    let broken = Breakage::of(case, run);
    let pieces = broken.pieces() as u64;
    let places = if pieces == 0 {
        String::new()
    } else {
        format!("in {} places, {} at the hit", grouped(pieces), grouped(broken.at_hit as u64))
    };
    all.push(("yarns broken", grouped(broken.yarns.iter().sum::<usize>() as u64), places));
    if run.plies > 1 {
        let through = last.map_or(0, |row| row.perforated_plies);
        all.push(("plies perforated", format!("{through} of {}", run.plies), String::new()));
    }
    all
}

/// Whether to trust it, in one box.
fn answer(case: &Case, signs: &[Check]) -> String {
    let (level, why) = checks::advice(signs);
    let why = why.iter().map(|sign| sign.name).collect::<Vec<_>>().join(", ");
    let words = match level {
        Level::Fine => format!("all {} checks are fine.", signs.len()),
        Level::Look | Level::Bad => format!("{why}."),
    };
    let (assumed, fields) = (assumed_fields(case).count(), case.fields.len());
    let inputs = match assumed {
        0 => "Every parameter has a published or measured source.".to_owned(),
        _ => format!("{assumed} of {fields} parameters are assumed, not published: the answer is as good as they are."),
    };
    format!(
        "<p class=\"answer {}\"><b>{}</b> {}<br><span>{}</span> <a href=\"#trust\">Why</a></p>\n",
        level.word(),
        mark(level),
        escape(&words),
        escape(&inputs)
    )
}

/// A level as everywhere else, and a mark for those who do not see colours.
fn mark(level: Level) -> String {
    let mark = match level {
        Level::Fine => '✓',
        Level::Look => '▲',
        Level::Bad => '✕',
    };
    let advice = level.advice();
    let (first, rest) = advice.split_at(1);
    format!("<span aria-hidden=\"true\">{mark}</span> {}{rest}:", first.to_uppercase())
}

/// A row of a table, all of it escaped.
fn row(name: &str, cells: &[String]) -> String {
    let cells: String = cells.iter().map(|cell| format!("<td>{cell}</td>")).collect();
    format!("<tr><th scope=\"row\">{name}</th>{cells}</tr>\n")
}

/// A word with the colour of a level.
fn level(class: &str, word: &str) -> String {
    format!("<span class=\"level {class}\">{word}</span>")
}

/// Every sign with its reason, and what was assumed.
pub(super) fn trust(case: &Case, signs: &[Check], summary: &Value) -> String {
    let mut out = "<section id=\"trust\"><h2>Is this run to be trusted?</h2>\n<table class=\"signs\"><thead><tr>\
                   <th scope=\"col\">check</th><th scope=\"col\">found</th><th scope=\"col\">level</th>\
                   <th scope=\"col\">why</th></tr></thead><tbody>\n"
        .to_owned();
    for sign in signs {
        let level = level(sign.level.word(), sign.level.advice());
        out += &row(&escape(sign.name), &[escape(&sign.value), level, escape(&sign.reason)]);
    }
    out += "</tbody></table>\n";
    out += &expectations(summary);
    out + &assumed(case) + "</section>\n"
}

fn assumed(case: &Case) -> String {
    let fields: Vec<&case::Field> = assumed_fields(case).collect();
    if fields.is_empty() {
        return String::new();
    }
    let mut out = format!(
        "<div class=\"assumptions\"><h3>Assumed parameters</h3><p>{} of {} fields: the paper does not publish them, nor does another source that the \
         case names. Vary those that matter with <code>--set</code> and see how far the answer moves.</p>\n<ul class=\"assumed\">\n",
        fields.len(),
        case.fields.len()
    );
    for field in fields {
        let (pointer, value, source) = (pointer(field), escape(&field.with_unit()), escape(&field.source));
        let _ = writeln!(out, "<li><code>{pointer}</code> <b>{value}</b> <span>{source}</span></li>");
    }
    out + "</ul></div>\n"
}

/// A JSON pointer that a narrow column may break between its words.
fn pointer(field: &case::Field) -> String {
    let breakable = escape(&field.pointer).replace('/', "<wbr>/").replace('_', "_<wbr>");
    breakable.trim_start_matches("<wbr>").to_owned()
}

fn expectations(summary: &Value) -> String {
    let checks: Vec<&Value> = summary["expect"].as_array().into_iter().flatten().collect();
    if checks.is_empty() {
        return String::new();
    }
    let mut out = "<h3>What the case expects</h3><table class=\"signs\"><tbody>\n".to_owned();
    for check in checks {
        let (class, word) = match judgement(check) {
            Judgement::Holds => ("fine", "holds"),
            Judgement::Known => ("bad", "known difference"),
            Judgement::Fails => ("bad", "fails"),
        };
        let (bound, found) = (escape(&expected(check)), escape(&got(check)));
        let why = format!("{} {}", check["source"].as_str().unwrap_or_default(), note(check));
        let cells = [format!("{found}, expected {bound}"), level(class, word), escape(why.trim())];
        out += &row(&escape(&quantity(check)), &cells);
    }
    out + "</tbody></table>\n"
}

/// Where the energy went.
pub(super) fn energy(run: &Run) -> String {
    let Some(energies) = Energies::of(run) else { return String::new() };
    let mut out = format!(
        "<section id=\"spent\"><h2>Where the energy went</h2><table class=\"signs\"><thead><tr><th scope=\"col\">given to the fabric\
         </th><td>{}</td><td></td><td></td></tr></thead><tbody>\n",
        escape(&energies.text(energies.given))
    );
    for (name, energy) in &energies.shares {
        let (text, percent) = (escape(&energies.text(*energy)), escape(&energies.percent(*energy)));
        let (name, meaning) = (escape(name), escape(energies::meaning(name)));
        let _ = writeln!(
            out,
            "<tr><th scope=\"row\">{name}</th><td>{text}</td><td>{percent}</td><td class=\"meaning\">{meaning}</td></tr>"
        );
    }
    out + "</tbody></table></section>\n"
}

/// Every field of the case, as `ripstop check` lists it.
pub(super) fn case(case: &Case) -> String {
    let mut out = format!(
        "<section id=\"case\"><h2>The case as read</h2><p>{}</p><details><summary>All {} fields</summary><p class=\"note\">Fields marked * are assumed. \
         <code>case.json</code> beside this page computes the same again.</p>\n<div class=\"scroll\" tabindex=\"0\">\
         <table class=\"fields\"><thead><tr><th scope=\"col\">field</th><th scope=\"col\">value</th>\
         <th scope=\"col\">origin</th><th scope=\"col\">source</th></tr></thead><tbody>\n",
        escape(&case::mesh(case)).replace('\n', "<br>"),
        case.fields.len()
    );
    for field in &case.fields {
        let class = if field.assumed { " class=\"assumed\"" } else { "" };
        let mark = if field.assumed { "* " } else { "" };
        let (pointer, value, source) = (pointer(field), escape(&field.with_unit()), escape(&field.source));
        let origin = field.origin.word();
        let _ = writeln!(
            out,
            "<tr{class}><th scope=\"row\">{mark}<code>{pointer}</code></th><td>{value}</td><td>{origin}</td><td>{source}</td></tr>"
        );
    }
    out + "</tbody></table></div></details></section>\n"
}

/// What computed it and how long it took.
pub(super) fn machine(run: &Run, summary: &Value) -> String {
    let text = |key: &str| summary[key].as_str().unwrap_or_default().to_owned();
    let element_steps = run.elements as u64 * run.steps;
    let share = 100.0 * run.element_steps_computed as f64 / element_steps.max(1) as f64;
    let device = run.adapter.clone().unwrap_or_else(|| format!("{} threads", run.threads));
    let [elements, steps] = [run.elements as u64, run.steps].map(grouped);
    let wall = short(summary["wall_s"].as_f64().unwrap_or(0.0), 3);
    let rows = [
        ("ripstop", format!("{}, case hash {}", text("version"), text("case_hash"))),
        ("computed on", format!("{}, {device}, {}", run.backend, run.precision)),
        ("time step", format!("{} µs, set by: {}", short(run.time_step * 1e6, 5), run.step_set_by)),
        ("work", format!("{elements} elements × {steps} steps, {} % of it computed", fixed(share, 1))),
        ("symmetry", symmetry(run.planes)),
        ("switched off", run.skips.switched_off().join(", ")),
        ("time", format!("{wall} s, of which the loop {} s", short(run.loop_seconds, 3))),
        ("speed", format!("{} M element-steps/s", short(element_steps as f64 / run.loop_seconds / 1e6, 3))),
    ];
    let kernel = |(name, seconds): &(&str, f64)| format!("{name} {} %", fixed(100.0 * seconds / run.loop_seconds, 0));
    let kernels = run.kernel_seconds.iter().map(kernel).collect::<Vec<_>>().join(", ");
    let rows = rows.into_iter().chain([("of the loop", kernels)]);
    let mut out = "<section id=\"machine\"><h2>Machine and timing</h2><table class=\"signs\"><tbody>\n".to_owned();
    for (name, value) in rows.filter(|row| !row.1.is_empty()) {
        out += &row(name, &[escape(&value)]);
    }
    out + "</tbody></table></section>\n"
}
