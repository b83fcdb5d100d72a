//! Factors of a sweep: `/pointer=1,2,4,8` or `/pointer=100..300:20` (from, to, step).

use crate::output::csv::number;
use crate::study::StudyError;

/// Points of a sweep at most.
const MAX_POINTS: usize = 10_000;

/// A key and its values.
#[derive(Clone, Debug, PartialEq)]
pub struct Factor {
    /// JSON pointer.
    pub pointer: String,
    /// Values, as the case file would have them.
    pub values: Vec<String>,
}

impl Factor {
    /// Reads `/pointer=values`.
    ///
    /// # Errors
    /// When it has another form, or a range is none.
    pub fn parse(text: &str) -> Result<Self, StudyError> {
        let help = "for example --over /pack/plies=1,2,4,8 or --over /projectile/velocity_m_s=100..300:20";
        let wrong = |expected: &str, found: &str| {
            StudyError::new(format!("--over {text}"), expected, format!("{found:?}"), help)
        };
        let Some((pointer, values)) = text.split_once('=').filter(|(pointer, _)| pointer.starts_with('/')) else {
            return Err(wrong("/json/pointer=values", text));
        };
        let pointer = pointer.to_owned();
        let Some((low, rest)) = values.split_once("..") else {
            let values: Vec<String> = split(values).into_iter().filter(|value| !value.is_empty()).collect();
            if values.is_empty() {
                return Err(wrong("values after =", ""));
            }
            return Ok(Self { pointer, values });
        };
        let (high, step) = rest.split_once(':').map_or((rest, None), |(high, step)| (high, Some(step)));
        let parse = |text: &str| {
            let parsed = text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
            parsed.ok_or_else(|| wrong("a number", text))
        };
        let [low, high] = [parse(low)?, parse(high)?];
        if high <= low {
            return Err(wrong("a range from a lower to a higher number", values));
        }
        let Some(step) = step else {
            let help = "write /pointer=A..B:STEP";
            let place = format!("--over {pointer}");
            return Err(StudyError::new(place, "values, or a range with a step", "a range without a step", help));
        };
        let step = parse(step)?;
        let count = ((high - low) / step + 1e-9).floor();
        if !(step > 0.0 && count < MAX_POINTS as f64) {
            return Err(wrong("a step above 0 that makes fewer than 10 000 values", values));
        }
        // Rounding of a sum of steps has no place in a case.
        let at = |n: usize| format!("{:.12e}", low + step * n as f64).parse().map(number).unwrap_or_default();
        Ok(Self { pointer, values: (0..=count as usize).map(at).collect() })
    }

    /// The last part of the pointer.
    pub fn name(&self) -> &str {
        self.pointer.rsplit('/').next().unwrap_or_default()
    }
}

/// All combinations of the values, the last factor fastest; each point has a value of every factor, as the case file would have it.
///
/// # Errors
/// When there are too many.
pub fn grid(factors: &[Factor]) -> Result<Vec<Vec<String>>, StudyError> {
    let mut points = vec![Vec::new()];
    for Factor { pointer, values } in factors {
        let count = points.len() * values.len();
        if count > MAX_POINTS {
            let expected = format!("at most {MAX_POINTS} points");
            return Err(StudyError::new(
                "--over",
                expected,
                format!("{count} of them at {pointer}"),
                "take longer steps",
            ));
        }
        let with = |point: Vec<String>| values.iter().map(move |value| [point.clone(), vec![value.clone()]].concat());
        points = points.into_iter().flat_map(with).collect();
    }
    Ok(points)
}

/// Values apart at commas, but for those inside brackets and quotes.
fn split(text: &str) -> Vec<String> {
    let mut parts = vec![String::new()];
    let (mut depth, mut quoted) = (0_i32, false);
    for c in text.chars() {
        match c {
            '"' => quoted = !quoted,
            '[' | '{' if !quoted => depth += 1,
            ']' | '}' if !quoted => depth -= 1,
            _ => {}
        }
        match (c, parts.last_mut()) {
            (',', _) if depth == 0 && !quoted => parts.push(String::new()),
            (_, Some(part)) => part.push(c),
            (_, None) => {}
        }
    }
    parts.into_iter().map(|part| part.trim().to_owned()).collect()
}

#[cfg(test)]
#[path = "factor_tests.rs"]
mod tests;
