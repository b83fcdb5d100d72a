//! `v50.html`: the answer, the curve of V0 to V100 with the thresholds, residual velocities, tables.

use super::report::{arithmetic_of, notes};
use super::{Design, V50Request, V50Result};
use crate::case::Case;
use crate::output::chart::{self, ChartAxis, escape};
use crate::output::number::short;
use crate::study::fit;
use crate::study::fit::draw::{CURVE, PANEL, PERFORATED, STOPPED, dot, evenly, residual_panel};
use crate::study::fit::page::{document, figures, row, table};

/// The page.
pub fn html(case: &Case, request: &V50Request, seed: u32, result: &V50Result) -> String {
    let mut body = format!("<p class=\"answer\">{}</p>\n", escape(&answer(request, result)));
    body += &format!("<p>{}</p>\n", escape(&parts(result)));
    for note in notes(case, request, result) {
        body += &format!("<p class=\"note\">{}.</p>\n", escape(&note));
    }
    let mut panels = Vec::new();
    if !(sorted(result).is_empty() && result.ranged.is_empty()) {
        panels.push(("chance of a perforation over impact velocity", chance(request, result)));
    }
    if !result.passed.is_empty() {
        panels.push(("residual over impact velocity", residual_panel(&result.passed, &result.residual)));
    }
    body += &figures(panels);
    body += &quantiles(result);
    body += &arithmetic(request.design, result);
    body += &residual(result);
    body += &bands(result);
    body += &thresholds(result);
    body += &format!("<p class=\"note\">Seed {seed}; design: {}.</p>\n", request.design.word());
    document(&format!("V50: {}", case.title), &body, "v50.json and v50.csv")
}

fn answer(request: &V50Request, result: &V50Result) -> String {
    let Some(v50) = result.v50 else { return format!("{} shots give no V50.", result.shots) };
    let [low, high] = result.bounds.words();
    let sigma = result.sigma.map_or_else(String::new, |sigma| format!("; σ {} m/s", short(sigma, 3)));
    let level = short(100.0 * request.fit.level, 3);
    format!("V50 {} m/s, {level} % interval {low} to {high} m/s{sigma}.", short(v50, 4))
}

/// What the interval is made of.
fn parts(result: &V50Result) -> String {
    let metres = |width: f64| format!("± {} m/s", short(width, 2));
    let sampling = result.width.sampling.map_or_else(|| "no end".to_owned(), metres);
    format!(
        "Of its width, sampling: {sampling}; mesh and time step: {}; brackets: {}.",
        metres(result.width.numerical),
        metres(result.width.bracket)
    )
}

/// Thresholds as a staircase of their distribution, or shots, and the curve fitted to them.
fn chance(request: &V50Request, result: &V50Result) -> String {
    let middles: Vec<f64> = sorted(result);
    let of_shots = result.ranged.iter().map(|shot| shot.velocity);
    let seen: Vec<f64> = if middles.is_empty() { of_shots.collect() } else { middles.clone() };
    let ends = [result.bounds.low, result.bounds.high].into_iter().flatten();
    let all = || seen.iter().copied().chain(ends.clone());
    let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
    let room = (0.15 * (high - low)).max(2e-3 * high.abs()).max(1e-9);
    let range = [low - room, high + room];
    let x = ChartAxis::linear(range, [64.0, PANEL[0] - 18.0]);
    let y = ChartAxis::linear([0.0, 1.0], [PANEL[1] - 58.0, 22.0]);
    let mut out = chart::axes(&x, &y, ["impact velocity [m/s]", "chance of a perforation"]);
    if let (Some(low), Some(high)) = (result.bounds.low, result.bounds.high) {
        let (left, right) = (x.at(low.max(range[0])), x.at(high.min(range[1])));
        let height = y.paper[0] - y.paper[1];
        out += &format!(
            "<rect x=\"{left:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{height:.1}\" fill=\"{CURVE}\" fill-opacity=\"0.08\"/>\n",
            y.paper[1],
            right - left
        );
    }
    let points = evenly(range).filter_map(|velocity| Some([velocity, result.probability(velocity)?]));
    out += &chart::line(&x, &y, points, &format!("stroke=\"{CURVE}\" stroke-width=\"2\""));
    let n = middles.len() as f64;
    for (rank, threshold) in middles.iter().enumerate() {
        out += &dot([x.at(*threshold), y.at((rank as f64 + 0.5) / n)], 1, STOPPED);
    }
    if request.design != Design::Thresholds {
        for shot in &result.ranged {
            let (height, colour) = if shot.perforated { (1.0, PERFORATED) } else { (0.0, STOPPED) };
            out += &dot([x.at(shot.velocity), y.at(height)], 1, colour);
        }
    }
    let legend = match request.design {
        Design::Thresholds => "dots: thresholds of realisations; line: normal; band: interval of V50",
        _ => "orange: perforated, blue: stopped; line: fit; band: interval of V50",
    };
    out + &chart::text(x.paper[0], PANEL[1] - 8.0, "font-size=\"11\"", legend)
}

/// Thresholds, ascending.
fn sorted(result: &V50Result) -> Vec<f64> {
    let mut middles = result.middles();
    middles.sort_by(f64::total_cmp);
    middles
}

fn quantiles(result: &V50Result) -> String {
    let mut rows = String::new();
    if let Some(sample) = result.sample.filter(|sample| sample.count > 1) {
        rows +=
            &row(&["V0: slowest threshold seen".to_owned(), short(sample.range[0], 5), String::new(), String::new()]);
    }
    for quantile in &result.quantiles {
        let [low, high] = quantile.bounds.words();
        let value = quantile.value.map_or_else(String::new, |value| short(value, 5));
        rows += &row(&[format!("V{}", short(100.0 * quantile.p, 3)), value, low, high]);
    }
    if let Some(sample) = result.sample.filter(|sample| sample.count > 1) {
        rows +=
            &row(&["V100: fastest threshold seen".to_owned(), short(sample.range[1], 5), String::new(), String::new()]);
    }
    table(
        "Velocities by chance; intervals of the sampling alone",
        &["", "velocity [m/s]", "low [m/s]", "high [m/s]"],
        &rows,
    )
}

fn arithmetic(design: Design, result: &V50Result) -> String {
    let rows: String = result
        .arithmetic
        .iter()
        .map(|(rule, found)| {
            let (value, why) = match found {
                Ok(found) => (short(found.mean, 5), format!("spread {} m/s", short(found.spread, 3))),
                Err(why) => ("none".to_owned(), fit::refusal(why)),
            };
            row(&[fit::rule(rule), rule.standard.to_owned(), value, why])
        })
        .collect();
    table(&format!("Arithmetic V50 of {}", arithmetic_of(design)), &["rule", "standard", "V50 [m/s]", ""], &rows)
}

fn residual(result: &V50Result) -> String {
    let rows: String = result
        .residual
        .iter()
        .map(|(curve, found)| match found {
            Ok(found) => {
                let [low, high] = found.bounds.words();
                let numbers = [found.factor, found.exponent, found.scatter].map(|number| short(number, 4));
                let [factor, exponent, scatter] = numbers;
                row(&[curve.words().to_owned(), short(found.limit, 5), low, high, factor, exponent, scatter])
            }
            Err(few) => row(&[curve.words().to_owned(), fit::too_few(few)]),
        })
        .collect();
    let heads = ["curve", "limit [m/s]", "low [m/s]", "high [m/s]", "a", "p", "scatter [m/s]"];
    table("Residual velocity: Vr = a (Vs^p − V0^p)^(1/p)", &heads, &rows)
}

fn bands(result: &V50Result) -> String {
    let one = |band: &super::ResidualBand| {
        let [from, to] = band.impact.map(|velocity| short(velocity, 4));
        let [least, largest] = band.range.map(|velocity| short(velocity, 4));
        row(&[format!("{from} to {to}"), band.count.to_string(), short(band.mean, 4), least, largest])
    };
    let rows: String = result.bands.iter().map(one).collect();
    if rows.is_empty() {
        return rows;
    }
    let heads = ["impact velocity [m/s]", "perforations", "mean residual [m/s]", "least [m/s]", "largest [m/s]"];
    table("Residual velocities by impact velocity", &heads, &rows)
}

fn thresholds(result: &V50Result) -> String {
    let one = |(number, found): (usize, &Result<[f64; 2], String>)| {
        let mark = if result.non_monotone.contains(&number) { "not monotone" } else { "" };
        match found {
            Ok([low, high]) => row(&[number.to_string(), short(*low, 6), short(*high, 6), mark.to_owned()]),
            Err(reason) => row(&[number.to_string(), String::new(), String::new(), reason.clone()]),
        }
    };
    let rows: String = result.thresholds.iter().enumerate().map(one).collect();
    if rows.is_empty() {
        return rows;
    }
    table("Thresholds", &["realisation", "highest stop [m/s]", "lowest perforation [m/s]", ""], &rows)
}
