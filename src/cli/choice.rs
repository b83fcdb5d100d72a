//! Options that take one of a few words: the words, what the help says of each, and what it stands for in the library.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use ripstop::model::unit_cell_curve::CurveLaw;
use ripstop::num::link::Link;
use ripstop::run::Precision;

/// Word, help, meaning.
pub(crate) type Choice<T> = (&'static str, &'static str, T);

/// Number type.
pub(crate) const PRECISIONS: &[Choice<Precision>] =
    &[("f64", "Double, the reference", Precision::F64), ("f32", "Single", Precision::F32)];

/// Unit-cell law.
pub(crate) const LAWS: &[Choice<CurveLaw>] = &[
    ("published", "The paper's (13)-(24)", CurveLaw::Published),
    ("projected", "The paper's with T cos α in the plane", CurveLaw::Projected),
    ("variational", "Sinusoidal yarns, forces conjugate to the arc length", CurveLaw::Variational),
    ("kawabata", "Saw-tooth cell", CurveLaw::Kawabata),
];

/// Distribution of the thresholds.
pub(crate) const LINKS: &[Choice<Link>] = &[("probit", "Normal", Link::Probit), ("logit", "Logistic", Link::Logit)];

/// Reads one of these words.
pub(crate) fn one_of<T: Copy + Send + Sync + 'static>(
    choices: &'static [Choice<T>],
) -> impl TypedValueParser<Value = T> {
    let words = choices.iter().map(|(word, help, _)| PossibleValue::new(*word).help(*help));
    let meaning = |word: String| choices.iter().find(|choice| choice.0 == word).map(|choice| choice.2);
    PossibleValuesParser::new(words).try_map(move |word| meaning(word).ok_or("no such word"))
}
