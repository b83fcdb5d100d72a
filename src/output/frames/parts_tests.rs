use super::*;

#[test]
fn a_cell_is_hidden_where_it_has_no_yarn_and_nowhere_else() {
    assert_eq!([ghost(0, 0), ghost(1, 0), ghost(0, 1), ghost(1, 1)], [HIDDEN, 0, 0, 0]);
    // A sum would be nothing in a byte.
    assert_eq!(ghost(255, 1), 0);
}
