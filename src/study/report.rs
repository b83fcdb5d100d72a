//! Result of a study in words and tables, the same at the terminal and on the page.

use crate::output::number::short;
use crate::output::plot::Figure;

/// Result of a study.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Title of the case; empty where the first line of counts names the file of shots.
    pub title: String,
    /// Lines on how many shots there were, and what became of them.
    pub counts: Vec<String>,
    /// Lines of the answer; the first begins with V50 up to its first comma. None in a sweep.
    pub answer: Vec<String>,
    /// Sentences that a reader should know before the numbers are used.
    pub notes: Vec<String>,
    /// Tables in their order.
    pub tables: Vec<ReportTable>,
    /// Tables for the page alone.
    pub(super) page_tables: Vec<ReportTable>,
    /// Drawings for the page.
    pub(super) panels: Vec<Figure>,
}

/// Table of a report.
#[derive(Clone, Debug, Default)]
pub struct ReportTable {
    /// Title; empty of a table that stands alone.
    pub title: String,
    /// Names of the columns; none where the cells say what they are.
    pub heads: Vec<String>,
    /// First column of numbers. A last column without a name is text.
    pub first_number: usize,
    /// Cells by row.
    pub rows: Vec<Vec<String>>,
    /// Lines below it.
    pub foot: String,
}

impl ReportTable {
    pub(super) fn new(
        title: impl Into<String>,
        heads: &[&str],
        first_number: usize,
        rows: impl IntoIterator<Item = Vec<String>>,
    ) -> Self {
        let heads = heads.iter().map(|head| (*head).to_owned()).collect();
        Self { title: title.into(), heads, first_number, rows: rows.into_iter().collect(), foot: String::new() }
    }

    /// Whether a column holds text.
    pub fn is_text(&self, column: usize) -> bool {
        column < self.first_number || (column + 1 == self.heads.len() && self.heads[column].is_empty())
    }

    pub(super) fn foot(self, foot: &str) -> Self {
        Self { foot: foot.to_owned(), ..self }
    }
}

/// Headline of a V50 with its interval.
pub(super) fn headline(v50: f64, level: f64, [low, high]: [String; 2]) -> String {
    format!("V50 {} m/s, {} % interval {low} to {high} m/s", short(v50, 4), short(100.0 * level, 3))
}
