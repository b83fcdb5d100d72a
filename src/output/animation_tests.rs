use super::*;

#[test]
fn lines_are_dense_around_the_impact_and_end_at_the_edges() {
    assert_eq!(kept_lines(160, 80, 161).len(), 161);
    let few = kept_lines(160, 80, 60);
    assert!(few.len() <= 60 && few.len() > 50, "{}", few.len());
    assert_eq!((few[0], few[few.len() - 1]), (0, 160));
    let dense = few.iter().filter(|line| line.abs_diff(80) <= DENSE).count();
    assert_eq!(dense, 2 * DENSE + 1);
    assert!(few.windows(2).all(|pair| pair[0] < pair[1]));
    let half = kept_lines(80, 0, 30);
    assert_eq!((half[0], half[half.len() - 1]), (0, 80));
}

fn keyframe(step: u64) -> Keyframe {
    Keyframe {
        step,
        time: step as f64,
        deflections: vec![0.0],
        displacement: vec![[1.0; 3]; 4],
        tension: Vec::new(),
        pose: None,
    }
}

#[test]
fn an_animation_opens_at_the_largest_deflection_that_the_projectile_is_near() {
    let mut animation = Animation::new(&crate::case::shipped(&["/expect=[]"]));
    let of = |(step, [deflection, height]): (u64, [f64; 2])| {
        let pose = Some([0.0, 0.0, height, 1.0, 0.0, 0.0, 0.0]);
        Keyframe { deflections: vec![0.0, deflection], pose, ..keyframe(step) }
    };
    animation.keyframes = (0..).zip([[0.0, 0.0], [2.0, 1.0], [3.0, 3.5], [4.0, 9.0]]).map(of).collect();
    assert_eq!(animation.opening(), 1);
    // A body that reaches 1 m back from its centre of mass.
    let body = SurfaceMesh { points: vec![[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]], faces: Vec::new() };
    animation.body = Some(body);
    assert_eq!(animation.opening(), 2);
}

#[test]
fn damaged_animations_are_refused() {
    let case = crate::case::shipped(&["/expect=[]"]);
    let mut animation = Animation::new(&case);
    animation.plies = vec![AnimatedPly::for_tests(vec![[0.0; 3]; 4])];
    animation.keyframes = vec![keyframe(0), keyframe(1)];
    let resume = |bytes: &[u8]| Animation::resume(&case, bytes, 2, 1e-7);
    let taken = |animation: &Animation| resume(&animation.to_bytes()).map(|animation| animation.keyframes);
    assert_eq!(taken(&animation), Some(animation.keyframes.clone()));
    for length in 0..animation.to_bytes().len() {
        assert!(resume(&animation.to_bytes()[..length]).is_none(), "{length} bytes");
    }
    let wrong: [fn(&mut Animation); 6] = [
        |animation| animation.keyframes[0].deflections.clear(),
        |animation| animation.keyframes[1].time = 0.0,
        |animation| animation.keyframes[1].displacement.truncate(3),
        |animation| animation.keyframes[0].tension.push([None; 2]),
        |animation| animation.plies[0].hit[1] = 1,
        |animation| animation.body = Some(SurfaceMesh::one_face_of_no_points()),
    ];
    for change in wrong {
        let mut animation = animation.clone();
        change(&mut animation);
        assert_eq!(taken(&animation), None);
    }
}

#[test]
fn a_yarn_that_is_broken_in_one_place_is_broken_from_end_to_end() {
    let along = |squares: &[f64]| squares.iter().copied().fold(0.0, end_to_end);
    assert_eq!(along(&[4.0, 9.0, f64::NAN]), 9.0);
    assert_eq!(along(&[4.0, BROKEN, 9.0]), BROKEN);
}

#[test]
fn first_and_last_of_many_plies_are_shown() {
    assert_eq!(shown(3), [0, 1, 2]);
    assert_eq!(shown(50), [0, 7, 14, 21, 28, 35, 42, 49]);
    for plies in 9..65 {
        let shown = shown(plies);
        assert!(shown.len() == PLIES && shown[0] == 0 && shown[PLIES - 1] == plies - 1, "{plies}");
        assert!(shown.windows(2).all(|pair| pair[0] < pair[1]), "{plies}");
    }
}
