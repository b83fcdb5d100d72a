use super::*;

#[test]
fn a_bar_in_a_cell_does_not_end_it() {
    assert_eq!(table(&["a", ""], [vec!["x|y", "z"], vec!["", "w"]]), "| a | |\n|---|---|\n| x\\|y | z |\n| | w |\n");
}
