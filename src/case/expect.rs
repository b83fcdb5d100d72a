//! Statements about the result that a case carries.

use schemars::JsonSchema;
use serde::Deserialize;

use super::CaseError;
use super::text::{number_text, percent, quote, short_number_text};

/// A statement about the result, checked after the run.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Expect {
    /// Name of the quantity: any number or word of `summary.json`, any column of `history.csv` (with `at_us`),
    /// or a measured wave quantity.
    pub quantity: String,
    /// Expected word, value or range.
    pub bound: Bound,
    /// Time at which a history or profile quantity is read [s].
    pub at: Option<f64>,
    /// Interval over which a speed or frequency is measured [s].
    pub between: Option<[f64; 2]>,
    /// Where the statement comes from.
    pub source: String,
    /// Why it is known not to hold; empty: it must.
    pub known_difference: String,
}

/// The expectation itself.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Bound {
    /// A word, e.g. an outcome.
    Word(String),
    /// |got − value| ≤ tolerance (already absolute, in the quantity's own unit).
    Value {
        /// Expected.
        value: f64,
        /// Allowed absolute difference.
        tolerance: f64,
    },
    /// min ≤ got ≤ max.
    Range {
        /// −∞ when absent.
        min: f64,
        /// +∞ when absent.
        max: f64,
    },
}

#[derive(Debug, Deserialize, JsonSchema)]
pub(super) struct ExpectKeys {
    /// A name of summary.json, a column of history.csv, or a measured wave quantity.
    #[schemars(length(min = 1))]
    quantity: String,
    /// The expected number or word.
    value: Option<NumberOrWord>,
    /// Least value; instead of value.
    #[schemars(range(min = -1e15, max = 1e15))]
    min: Option<f64>,
    /// Largest value; instead of value.
    #[schemars(range(min = -1e15, max = 1e15))]
    max: Option<f64>,
    /// Allowed difference from a number, absolute or "1%".
    tolerance: Option<Tolerance>,
    /// Time at which the quantity is read.
    #[schemars(rename = "at_us", range(min = 0, max = 1e9))]
    at: Option<f64>,
    /// Interval of a measured speed or frequency.
    #[schemars(rename = "between_us", inner(range(min = 0, max = 1e9)))]
    between: Option<[f64; 2]>,
    /// Where the statement comes from.
    #[schemars(length(min = 1))]
    source: String,
    /// Why the statement is known not to hold: shown, and no failure.
    #[schemars(length(min = 1))]
    known_difference: Option<String>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
enum NumberOrWord {
    Number(#[schemars(range(min = -1e15, max = 1e15))] f64),
    Word(String),
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
enum Tolerance {
    Absolute(#[schemars(range(min = 0, max = 1e15))] f64),
    Percent(#[schemars(extend("pattern" = "%$"))] String),
}

impl ExpectKeys {
    /// The statement at a pointer.
    pub(super) fn expect(self, at: &str) -> Result<Expect, CaseError> {
        let bound = self.bound(at)?;
        if let Some([first, last]) = self.between {
            let us = |time: f64| short_number_text(time * 1e6);
            let refused =
                |expected: &str, found: String| Err(CaseError::at(format!("{at}/between_us"), expected, found));
            if first >= last {
                return refused("two times, the earlier one first", format!("[{},{}]", us(first), us(last)));
            }
            if self.at.is_some() {
                return refused("either \"at_us\" or \"between_us\"", "both".to_owned());
            }
        }
        let Self { quantity, at, between, source, .. } = self;
        let known_difference = self.known_difference.unwrap_or_default();
        Ok(Expect { quantity, bound, at, between, source, known_difference })
    }

    fn bound(&self, at: &str) -> Result<Bound, CaseError> {
        let refused =
            |key: &str, expected: &str, found: String| Err(CaseError::at(format!("{at}{key}"), expected, found));
        let in_words = |tolerance: &Tolerance| match tolerance {
            Tolerance::Absolute(number) => number_text(*number),
            Tolerance::Percent(text) => quote(text),
        };
        let ranged = self.min.is_some() || self.max.is_some();
        match (&self.value, &self.tolerance) {
            (Some(_), _) if ranged => refused("/value", "either \"value\" or \"min\" and \"max\"", "both".to_owned()),
            (Some(NumberOrWord::Word(word)), None) => Ok(Bound::Word(word.clone())),
            (Some(NumberOrWord::Word(_)), Some(tolerance)) => {
                refused("/tolerance", "no tolerance with a word as value", in_words(tolerance))
            }
            (Some(NumberOrWord::Number(_)), None) => {
                let expected = "a tolerance with a number as value, absolute or like \"1%\"";
                refused("/tolerance", expected, "nothing".to_owned())
            }
            (Some(NumberOrWord::Number(value)), Some(tolerance)) => {
                let tolerance = match tolerance {
                    Tolerance::Absolute(number) => *number,
                    Tolerance::Percent(text) => percent(text).unwrap_or_default() * value.abs(),
                };
                Ok(Bound::Value { value: *value, tolerance })
            }
            (None, Some(tolerance)) => refused("/tolerance", "no tolerance without \"value\"", in_words(tolerance)),
            (None, None) if !ranged => refused("", "\"value\", \"min\" or \"max\"", "none of them".to_owned()),
            (None, None) => {
                let (min, max) = (self.min.unwrap_or(f64::NEG_INFINITY), self.max.unwrap_or(f64::INFINITY));
                if min > max {
                    let expected = format!("at most max, which is {}", number_text(max));
                    return refused("/min", &expected, number_text(min));
                }
                Ok(Bound::Range { min, max })
            }
        }
    }
}

impl Expect {
    /// The statement in words.
    pub(super) fn in_words(&self) -> String {
        let bound = match &self.bound {
            Bound::Word(word) => format!("= {}", quote(word)),
            Bound::Value { value, tolerance } => format!("= {} ± {}", number_text(*value), number_text(*tolerance)),
            Bound::Range { min, max } if *max == f64::INFINITY => format!("≥ {}", number_text(*min)),
            Bound::Range { min, max } if *min == f64::NEG_INFINITY => format!("≤ {}", number_text(*max)),
            Bound::Range { min, max } => format!("in [{}, {}]", number_text(*min), number_text(*max)),
        };
        format!("{} {bound}", self.quantity)
    }
}
