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
mod tests {
    use super::*;

    #[test]
    fn a_bar_in_a_cell_does_not_end_it() {
        assert_eq!(
            table(&["a", ""], [vec!["x|y", "z"], vec!["", "w"]]),
            "| a | |\n|---|---|\n| x\\|y | z |\n| | w |\n"
        );
    }
}
