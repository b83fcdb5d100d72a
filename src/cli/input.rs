//! Input of commands: cases from files and standard input, and values of options.

use std::fs::File;
use std::io::{self, Read};
use std::ops::RangeInclusive;
use std::path::Path;
use std::str::FromStr;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use ripstop::case::{self, Case, CaseError};
use ripstop::model::unit_cell_curve::CurveLaw;
use ripstop::num::link::Link;
use ripstop::run::Precision;

use super::failure::CommandFailure;

/// Size of a case or fabric at most [bytes].
const MAX_BYTES: u64 = 1 << 20;
/// Largest stretch that is solved.
const MAX_STRETCH: f64 = 2.0;
/// Values in a range at most.
const MAX_COUNT: usize = 10_000;

/// Reads a case, named after what was changed in it; of one from standard input, files of fabrics lie in the current folder.
pub(crate) fn read(path: &Path, sets: &[String]) -> Result<Case, CommandFailure> {
    Ok(Source::open(path)?.case(sets)?)
}

/// Source of a case that is read with different changes. Standard input can be read once alone.
pub(crate) enum Source<'a> {
    /// A file.
    File(&'a Path),
    /// Text from standard input.
    Piped(String),
}

impl<'a> Source<'a> {
    /// The source that the command line names; `-` is standard input.
    pub(crate) fn open(path: &'a Path) -> Result<Self, CommandFailure> {
        let failed = |error: io::Error| CommandFailure::expected("standard input", "a case", error);
        if path == Path::new("-") {
            limited(io::stdin()).map(Self::Piped).map_err(failed)
        } else {
            Ok(Self::File(path))
        }
    }

    /// Name on the command line.
    pub(crate) fn name(&self) -> String {
        match self {
            Self::File(path) => path.display().to_string(),
            Self::Piped(_) => "-".to_owned(),
        }
    }

    /// The case with changes, named after them.
    pub(crate) fn case(&self, sets: &[String]) -> Result<Case, CaseError> {
        let mut case = match self {
            Self::File(path) => case::read(path, sets),
            Self::Piped(text) => case::from_text("stdin", text, Path::new("."), sets),
        }?;
        case.name_changes(sets);
        Ok(case)
    }
}

/// Folder of a file.
pub(crate) fn folder(file: &Path) -> &Path {
    file.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."))
}

/// Text of a file.
pub(crate) fn text(path: &str) -> io::Result<String> {
    limited(File::open(path)?)
}

/// Text of a reader that may have no end.
fn limited(reader: impl Read) -> io::Result<String> {
    let mut text = String::new();
    reader.take(MAX_BYTES + 1).read_to_string(&mut text)?;
    if text.len() as u64 > MAX_BYTES { Err(io::Error::other("more than 1 MiB")) } else { Ok(text) }
}

/// Word of an option, its help, its meaning.
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

/// Parser of one of these words.
pub(crate) fn one_of<T: Copy + Send + Sync + 'static>(
    choices: &'static [Choice<T>],
) -> impl TypedValueParser<Value = T> {
    let words = choices.iter().map(|(word, help, _)| PossibleValue::new(*word).help(*help));
    let meaning = |word: String| choices.iter().find(|choice| choice.0 == word).map(|choice| choice.2);
    PossibleValuesParser::new(words).try_map(move |word| meaning(word).ok_or("no such word"))
}

/// A number that fits.
fn number(text: &str, expected: &str, fits: impl Fn(f64) -> bool) -> Result<f64, String> {
    let number = text.trim().parse().ok().filter(|number| fits(*number));
    number.ok_or_else(|| format!("expected {expected}, found {text:?}"))
}

/// A number, or a percentage with its sign, as a fraction.
fn fraction(text: &str, expected: &str, range: RangeInclusive<f64>) -> Result<f64, String> {
    let (digits, scale) = text.trim().strip_suffix('%').map_or((text, 1.0), |digits| (digits, 100.0));
    let fits = |number: f64| range.contains(&(number / scale));
    number(digits, expected, fits).map(|number| number / scale)
}

/// A two-sided confidence.
pub(crate) fn level(text: &str) -> Result<f64, String> {
    fraction(text, "a confidence from 0.01 to 0.9999, such as 0.9 or 90%", 0.01..=0.9999)
}

/// An error that is good enough.
pub(crate) fn tolerance(text: &str) -> Result<f64, String> {
    fraction(text, "an error above 0 and at most 100%, such as 1% or 0.01", f64::MIN_POSITIVE..=1.0)
}

/// A difference above 0 in percent, as a fraction.
pub(crate) fn percent(text: &str) -> Result<f64, String> {
    let expected = "a difference above 0 in percent, such as 2 or 0.5%";
    let fits = |percent: f64| percent > 0.0 && percent.is_finite();
    number(text.trim().trim_end_matches('%'), expected, fits).map(|percent| percent / 100.0)
}

/// A time above 0 [µs], in s.
pub(crate) fn interval(text: &str) -> Result<f64, String> {
    number(text, "a time above 0 in µs", |time| time > 0.0 && time.is_finite()).map(|time| time * 1e-6)
}

/// Stretches Λ: one, or `first:last:count` with both ends.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Stretches(pub(crate) Vec<f64>);

impl FromStr for Stretches {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let stretch = |text: &str| {
            let expected = format!("a stretch above 0 and at most {MAX_STRETCH}; unstretched is 1");
            number(text, &expected, |stretch| stretch > 0.0 && stretch <= MAX_STRETCH)
        };
        match text.split(':').collect::<Vec<_>>()[..] {
            [value] => Ok(Self(vec![stretch(value)?])),
            [first, last, count] => {
                let (first, last) = (stretch(first)?, stretch(last)?);
                let last_number = count.trim().parse::<usize>().ok().filter(|count| (2..=MAX_COUNT).contains(count));
                let end =
                    last_number.ok_or(format!("expected a count between 2 and {MAX_COUNT}, found {count:?}"))? - 1;
                let inner = (0..end).map(|n| first + (last - first) * n as f64 / end as f64);
                Ok(Self(inner.chain([last]).collect()))
            }
            _ => Err("expected one stretch, or first:last:count like 1:1.05:26".to_owned()),
        }
    }
}

/// A range of velocities `A..B` [m/s].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Velocities(pub(crate) [f64; 2]);

impl FromStr for Velocities {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let ends =
            text.split_once("..").and_then(|(low, high)| Some([low.trim().parse().ok()?, high.trim().parse().ok()?]));
        match ends {
            Some([low, high]) if low > 0.0 && high > low && high <= 5000.0 => Ok(Self([low, high])),
            _ => Err(format!("expected two velocities in m/s, the lower first, such as 150..250, found {text:?}")),
        }
    }
}
