//! Plain-text tables: columns padded to their widest cell, whatever its colour, two blanks between them.

use std::fmt;

use console::{Alignment, measure_text_width, pad_str};

/// Side to which a column's cells stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Align {
    /// Words.
    Left,
    /// Numbers.
    Right,
}

/// A table; print it with `{}`.
#[derive(Clone, Debug)]
pub(crate) struct TextTable {
    align: Vec<Align>,
    rows: Vec<Vec<String>>,
}

impl TextTable {
    /// A table without a heading, with one alignment per column.
    pub(crate) fn plain(align: &[Align]) -> Self {
        Self { align: align.to_vec(), rows: Vec::new() }
    }

    /// A table with a heading.
    pub(crate) fn new(columns: &[(&str, Align)]) -> Self {
        let mut table = Self::plain(&columns.iter().map(|(_, align)| *align).collect::<Vec<_>>());
        table.row(columns.iter().map(|(name, _)| *name));
        table
    }

    /// Adds a row; cells beyond the last column are left out.
    pub(crate) fn row<T: Into<String>>(&mut self, cells: impl IntoIterator<Item = T>) {
        self.rows.push(cells.into_iter().map(Into::into).collect());
    }
}

impl fmt::Display for TextTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let cells = |column: usize| self.rows.iter().filter_map(move |row| row.get(column));
        let width = |column: usize| cells(column).map(|cell| measure_text_width(cell)).max().unwrap_or(0);
        let widths: Vec<usize> = (0..self.align.len()).map(width).collect();
        for row in &self.rows {
            let padded = row.iter().zip(&widths).zip(&self.align).map(|((cell, &width), align)| match align {
                Align::Left => pad_str(cell, width, Alignment::Left, None),
                Align::Right => pad_str(cell, width, Alignment::Right, None),
            });
            let line = padded.collect::<Vec<_>>().join("  ");
            writeln!(f, "{}", line.trim_end())?;
        }
        Ok(())
    }
}
