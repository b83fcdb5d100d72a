//! Tables in Markdown, for the pages of `docs/`.

/// A table: its head and its rows, as many cells in each. A bar inside a cell is escaped.
pub fn table<Cell: AsRef<str>>(head: &[&str], rows: impl IntoIterator<Item = Vec<Cell>>) -> String {
    let mut out = line(head) + &format!("|{}\n", "---|".repeat(head.len()));
    for row in rows {
        out += &line(&row);
    }
    out
}

fn line<Cell: AsRef<str>>(cells: &[Cell]) -> String {
    let cell = |cell: &Cell| match cell.as_ref() {
        "" => "| ".to_owned(),
        text => format!("| {} ", text.replace('|', "\\|")),
    };
    cells.iter().map(cell).collect::<String>() + "|\n"
}

#[cfg(test)]
#[path = "markdown_tests.rs"]
mod tests;
