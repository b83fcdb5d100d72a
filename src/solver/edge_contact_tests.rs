use super::*;
#[test]
fn two_points_that_ask_the_same_are_solved_with_the_floor_under_the_second() {
    // K of two equal points, row by row; its second pivot is nothing.
    let mut a = [4.0, 4.0, 4.0];
    let mut x = [[8.0; 7]; 2];
    factorize(&mut a, x.len());
    substitute(&a, &mut x);
    assert_eq!(a, [2.0, 2.0, (FLOOR * 4.0).sqrt()]);
    assert!(x.iter().flatten().all(|x| x.is_finite()));
    assert!((0..7).all(|column| (x[0][column] + x[1][column] - 2.0).abs() < 1e-9), "{x:?}");
}

#[test]
fn a_factor_solves_what_it_was_made_of() {
    let k = [[4.0, 1.0, 0.5], [1.0, 3.0, -0.25], [0.5, -0.25, 2.0]];
    let known = [
        [1.0, -2.0, 3.0, 0.5, 4.0, -1.0, 2.0],
        [0.25, 1.0, -1.0, 2.0, 0.0, 3.0, -2.0],
        [5.0, 1.5, 2.5, -3.0, 1.0, 0.75, 0.0],
    ];
    let mut a = [k[0][0], k[1][0], k[1][1], k[2][0], k[2][1], k[2][2]];
    let mut x = [0, 1, 2]
        .map(|i| -> [f64; 7] { std::array::from_fn(|column| (0..3).map(|j| k[i][j] * known[j][column]).sum()) });
    factorize(&mut a, x.len());
    substitute(&a, &mut x);
    for (got, expected) in x.iter().flatten().zip(known.iter().flatten()) {
        assert!((got - expected).abs() < 1e-12, "{got} for {expected}");
    }
}

#[test]
fn members_are_sorted_into_blocks_that_share_no_node() {
    let edge = |from, to| EdgeConstraint { nodes: [from, to], weights: [0.5; 2] };
    // Two chains, with the edges in no order; nodes 2, 5 and 7 push, too, 7 alone.
    let mut rim = EdgeContact {
        constraints: vec![edge(4, 5), edge(0, 1), edge(2, 6), edge(3, 4), edge(1, 2)],
        members: vec![2, 5, 7, 8, 9, 10, 11, 12],
        ..EdgeContact::default()
    };
    rim.find_blocks(8);
    let blocks: Vec<Vec<_>> =
        ranges(&rim.ends).map(|of| rim.order[of].iter().map(|place| rim.members[*place]).collect()).collect();
    assert_eq!(blocks, [vec![2, 9, 10, 12], vec![5, 8, 11], vec![7]]);
    assert!(rim.order.iter().enumerate().all(|(at, place)| rim.places[*place] == at));
}
