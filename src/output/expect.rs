//! Expectations of a case against its run.
//!
//! A quantity is, in this order: a wave quantity measured on deflection profiles (`plateau_strain`,
//! `shock_speed_m_s`, `kink_speed_m_s`) or on the history (`frequency_hz`); with `at_us`, a column of `history.csv`
//! at that time; else a key of `summary.json` (`failed_yarns.warp` for one inside another) or the last row of a
//! column. What cannot be found or measured has failed, with the reason.

use serde_json::{Value, json};

use super::csv;
use super::number::short;
use crate::case::{Bound, Case, Expect};
use crate::run::{DeflectionProfile, Run, Sample};

/// A time [s] in µs as the case gave it, without the noise of the conversion.
fn microseconds(time: f64) -> f64 {
    (time * 1e15).round() / 1e9
}

/// Round-off of both balances in single precision \[-\]: each of N steps rounds to u = 6e-8 of what was exchanged. Energy: u N for N = 330, of
/// one sign where a body carries a node along; largest seen 9.9e-6, of one element. Momentum: u√N for N = 1100; largest seen 1.9e-7.
const SINGLE_ROUND_OFF: [(&str, f64); 2] = [("energy_error", 2e-5), ("momentum_error", 2e-6)];

/// The expectation as a run of this precision can meet it: bounds on round-off are those of f64 and no tighter than
/// round-off itself in f32.
fn in_precision(expect: &Expect, precision: &str) -> Expect {
    let mut out = expect.clone();
    let round_off = SINGLE_ROUND_OFF.iter().find(|(name, _)| precision == "f32" && *name == expect.quantity);
    if let (Bound::Range { max, .. }, Some((_, least))) = (&mut out.bound, round_off)
        && *max < *least
    {
        *max = *least;
        out.source = format!("{} (bound of f32)", expect.source);
    }
    out
}

/// Compares every expectation of `case` with the run and its summary (which need not have `expect` itself). The results stand in
/// `summary.json`: number, word or flag found, whether the expectation holds, and a note on why there is nothing to compare;
/// times in µs.
pub fn check(case: &Case, run: &Run, summary: &Value) -> Vec<Value> {
    let one = |expect: &Expect| {
        let expect = &in_precision(expect, run.precision);
        let found = find(expect, run, summary);
        let (got, note) = (found.as_ref().unwrap_or(&Value::Null), found.as_ref().err());
        let pass = holds(&expect.bound, got);
        let mut out = json!({
            "quantity": expect.quantity,
            "expected": expect.bound,
            "got": got,
            "pass": pass,
            "source": expect.source,
        });
        let more = [
            ("at_us", expect.at.map(|time| json!(microseconds(time)))),
            ("between_us", expect.between.map(|times| json!(times.map(microseconds)))),
            ("note", note.map(|note| json!(note))),
            ("known_difference", expect.known_difference.as_ref().filter(|_| !pass).map(|why| json!(why))),
        ];
        more.into_iter().filter_map(|(key, value)| Some((key, value?))).for_each(|(key, value)| out[key] = value);
        out
    };
    case.expect.iter().map(one).collect()
}

fn holds(bound: &Bound, got: &Value) -> bool {
    match (bound, got) {
        (Bound::Word(word), Value::String(got)) => word == got,
        (Bound::Word(word), Value::Bool(got)) => *word == got.to_string(),
        (Bound::Word(_), _) => false,
        (Bound::Value { value, tolerance }, got) => got.as_f64().is_some_and(|got| (got - value).abs() <= *tolerance),
        (Bound::Range { min, max }, got) => got.as_f64().is_some_and(|got| (*min..=*max).contains(&got)),
    }
}

fn find(expect: &Expect, run: &Run, summary: &Value) -> Result<Value, String> {
    match expect.quantity.as_str() {
        "plateau_strain" => plateau_strain(expect, run),
        "shock_speed_m_s" => wave_speed(expect, run, "longitudinal front", DeflectionProfile::front),
        "kink_speed_m_s" => wave_speed(expect, run, "kink", DeflectionProfile::kink),
        "frequency_hz" => frequency(&run.history, expect.between.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]))
            .map(Value::from)
            .ok_or_else(|| "the kinetic energy has fewer than two whole peaks in this interval".to_owned()),
        name if expect.between.is_some() => {
            Err(format!("between_us belongs to a measured speed or frequency, not to {name}; use at_us"))
        }
        name => match expect.at {
            Some(time) => at(name, time, run),
            None => at_end(name, run, summary),
        },
    }
}

/// A history column at a time [s].
fn at(name: &str, time: f64, run: &Run) -> Result<Value, String> {
    let (_, read_column) = csv::find(name).ok_or_else(|| format!("history.csv has no column {name}"))?;
    let end = run.history.last().map_or(0.0, |row| row.time);
    // The last row may stand a rounding before the end asked for.
    let read = if time > end && time <= end + 1e-3 * run.time_step { end } else { time };
    let value = csv::between(&run.history, read, read_column)
        .ok_or_else(|| format!("the run ended at {:.3} µs; \"run_until\": \"end_time\" makes it go on", end * 1e6))?;
    Ok(json!(value))
}

fn at_end(name: &str, run: &Run, summary: &Value) -> Result<Value, String> {
    match summary.pointer(&format!("/{}", name.replace('.', "/"))) {
        Some(value @ (Value::Number(_) | Value::String(_) | Value::Bool(_))) => return Ok(value.clone()),
        Some(Value::Null) => return Err(format!("this run has no {name}")),
        Some(_) => return Err(format!("{name} is neither a number nor a word")),
        None => {}
    }
    let (_, read) = csv::find(name)
        .ok_or_else(|| format!("{name} is no key of summary.json, column of history.csv or measured quantity"))?;
    let last = run.history.last().map(|row| json!(read(row)));
    last.ok_or_else(|| "the history is empty".to_owned())
}

/// The profile that was taken at a time [s].
fn profile(run: &Run, time: f64) -> Result<&DeflectionProfile, String> {
    let is_it = |profile: &&DeflectionProfile| (profile.time - time).abs() <= run.time_step;
    let missing = || format!("no profile was taken at {} µs; list it in /output/profile_times_us", microseconds(time));
    run.profiles.iter().find(is_it).ok_or_else(missing)
}

fn plateau_strain(expect: &Expect, run: &Run) -> Result<Value, String> {
    let time = expect.at.ok_or("plateau_strain needs at_us")?;
    Ok(json!(profile(run, time)?.plateau_strain().ok_or("the profile has no wave")?))
}

fn wave_speed(
    expect: &Expect,
    run: &Run,
    wave: &str,
    place: impl Fn(&DeflectionProfile) -> Option<f64>,
) -> Result<Value, String> {
    let between = expect.between.ok_or_else(|| format!("{} needs between_us", expect.quantity))?;
    let [from, to] = [profile(run, between[0])?, profile(run, between[1])?];
    let places = place(to).zip(place(from)).ok_or_else(|| format!("the profiles have no {wave}"))?;
    Ok(json!((places.0 - places.1) / (to.time - from.time)))
}

/// Fundamental frequency of a free vibration [Hz] between two times [s]: half the frequency of the peaks of the
/// fabric's kinetic energy, each located by a parabola. `None` with fewer than two whole peaks.
pub fn frequency(history: &[Sample], between: [f64; 2]) -> Option<f64> {
    let rows: Vec<[f64; 2]> = history
        .iter()
        .filter(|row| (between[0]..=between[1]).contains(&row.time))
        .map(|row| [row.time, row.balance.kinetic])
        .collect();
    let low = rows.iter().map(|row| row[1]).fold(f64::INFINITY, f64::min);
    let high = rows.iter().map(|row| row[1]).fold(f64::NEG_INFINITY, f64::max);
    let middle = 0.5 * (low + high);
    // A peak lies between rising and falling through the middle, so that ripples on it do not count.
    let mut peaks = Vec::new();
    let mut risen: Option<usize> = None;
    for n in 1..rows.len() {
        if rows[n - 1][1] < middle && rows[n][1] >= middle {
            risen = Some(n);
        } else if rows[n - 1][1] >= middle
            && rows[n][1] < middle
            && let Some(start) = risen.take()
        {
            let top = (start..n).max_by(|a, b| rows[*a][1].total_cmp(&rows[*b][1]))?;
            peaks.push(vertex(&rows[top - 1..=top + 1]));
        }
    }
    let (first, last) = (peaks.first()?, peaks.last()?);
    (peaks.len() >= 2).then(|| 0.5 * (peaks.len() - 1) as f64 / (last - first))
}

/// Abscissa of the vertex of the parabola through three points.
fn vertex(points: &[[f64; 2]]) -> f64 {
    let [a, b, c] = [points[0], points[1], points[2]];
    let (left, right) = (b[0] - a[0], c[0] - b[0]);
    let (fall, rise) = (b[1] - c[1], b[1] - a[1]);
    let below = left * fall + right * rise;
    if below > 0.0 { b[0] - 0.5 * (left * left * fall - right * right * rise) / below } else { b[0] }
}

/// Quantity of an expectation in `summary.json`, with the time or interval.
pub fn quantity(check: &Value) -> String {
    let name = check["quantity"].as_str().unwrap_or_default();
    if let Some(at) = check["at_us"].as_f64() {
        return format!("{name} at {} µs", short(at, 7));
    }
    match (check["between_us"][0].as_f64(), check["between_us"][1].as_f64()) {
        (Some(from), Some(to)) => format!("{name} between {} and {} µs", short(from, 7), short(to, 7)),
        _ => name.to_owned(),
    }
}

/// Bound of an expectation in words.
pub fn expected(check: &Value) -> String {
    let expected = &check["expected"];
    let number = |key: &str| expected[key].as_f64();
    if let Some(word) = expected.as_str() {
        return word.to_owned();
    }
    match (number("value"), number("tolerance"), number("min"), number("max")) {
        (Some(value), Some(tolerance), ..) => format!("{value} ± {}", short(tolerance, 6)),
        (.., Some(min), Some(max)) => format!("{min} to {max}"),
        (.., Some(min), None) => format!("≥ {min}"),
        (.., None, Some(max)) => format!("≤ {max}"),
        _ => "-".to_owned(),
    }
}

/// Result of the run in words.
pub fn got(check: &Value) -> String {
    match &check["got"] {
        Value::Number(number) => number.as_f64().map_or_else(String::new, |number| short(number, 6)),
        Value::String(word) => word.clone(),
        Value::Null => "nothing".to_owned(),
        other => other.to_string(),
    }
}

/// Reason why there is nothing to compare, how the number was read, or why it is known to differ.
pub fn note(check: &Value) -> String {
    let notes = ["note", "known_difference"].into_iter().filter_map(|key| check[key].as_str());
    notes.map(|note| format!("({note})")).collect::<Vec<_>>().join(" ")
}

/// Judgement of an expectation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Judgement {
    /// It holds.
    Holds,
    /// It does not, and the case says why.
    Known,
    /// It does not.
    Fails,
}

/// Judgement of an expectation in `summary.json`.
pub fn judgement(check: &Value) -> Judgement {
    match (check["pass"] == true, check["known_difference"].is_string()) {
        (true, _) => Judgement::Holds,
        (false, true) => Judgement::Known,
        (false, false) => Judgement::Fails,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::energy_balance::Balance;

    #[test]
    fn finds_the_frequency_of_a_vibration_between_its_samples() {
        let frequency_hz = 1234.5;
        let row = |n: u32| {
            let time = f64::from(n) * 7e-6;
            let velocity = (std::f64::consts::TAU * frequency_hz * time).sin();
            Sample {
                time,
                balance: Balance { kinetic: velocity * velocity, ..Balance::default() },
                ..Sample::default()
            }
        };
        let history: Vec<Sample> = (0..800).map(row).collect();
        let all = [f64::NEG_INFINITY, f64::INFINITY];
        let got = frequency(&history, all).unwrap_or_default();
        assert!((got / frequency_hz - 1.0).abs() < 1e-4, "{got}");
        assert_eq!(frequency(&history[..40], all), None);
        assert_eq!(frequency(&[], all), None);
    }

    #[test]
    fn a_parabola_has_its_vertex_wherever_its_points_are() {
        let point = |x: f64| [x, 3.0 - 2.0 * (x - 1.3).powi(2)];
        assert!((vertex(&[point(0.0), point(1.0), point(4.0)]) - 1.3).abs() < 1e-12);
    }
}
