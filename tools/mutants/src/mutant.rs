//! A mutant, and where it stands in the source.

use std::ops::Range;

use twox_hash::XxHash3_64;

/// A change of one place of the source.
#[derive(Clone, Debug)]
pub struct Mutant {
    /// Path from the root of the repository.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Function that holds it, with its type.
    pub function: String,
    /// Kind of change.
    pub operator: &'static str,
    /// What is written, and what the mutant has in its place, in short.
    pub change: [String; 2],
    /// Which of several alike in this function, from 1.
    pub number: usize,
    /// How the source is rewritten.
    pub edit: Edit,
}

/// The text that is put into the source.
#[derive(Clone, Debug)]
pub enum Edit {
    /// `if mutant { other } else { original }` around an expression.
    Instead {
        /// The expression [bytes].
        range: Range<usize>,
        /// What the mutant computes.
        other: String,
    },
    /// A statement that the mutant leaves out [bytes].
    LeaveOut(Range<usize>),
    /// A value that the mutant gives at once, at the start of a function's body [bytes].
    GiveAtOnce {
        /// Behind the opening brace [bytes].
        at: usize,
        /// The value, as source.
        value: String,
    },
}

impl Mutant {
    /// What stays the same when lines move.
    pub fn name(&self) -> String {
        let [from, to] = &self.change;
        let number = if self.number > 1 { format!(" #{}", self.number) } else { String::new() };
        format!("{}: {}: `{from}` -> `{to}`{number}", self.file, self.function)
    }

    /// Orders mutants at random, the same way each time; what is changed elsewhere changes nothing.
    pub fn rank(&self, seed: u64) -> u64 {
        XxHash3_64::oneshot_with_seed(seed, self.name().as_bytes())
    }
}

/// Source in one short line.
pub fn short(text: &str) -> String {
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ").replace('`', "'");
    if line.chars().count() <= 70 {
        return line;
    }
    let head: String = line.chars().take(50).collect();
    let tail: String = line.chars().rev().take(17).collect::<Vec<_>>().into_iter().rev().collect();
    format!("{head}…{tail}")
}
