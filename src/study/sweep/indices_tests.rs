use std::f64::consts::PI;

use super::super::design::SweepDesign;
use super::super::factor::Factor;
use super::*;

fn ishigami(x: &[f64]) -> f64 {
    x[0].sin() + 7.0 * x[1].sin().powi(2) + 0.1 * x[2].powi(4) * x[0].sin()
}

/// Groups of responses over the box from −π to π.
fn groups(count: usize, f: impl Fn(&[f64]) -> f64) -> Vec<Vec<f64>> {
    let range = format!("/x={}..{PI}", -PI);
    let factors: Vec<Factor> = (0..3).filter_map(|_| Factor::parse(&range).ok()).collect();
    let points = SweepDesign::Total(count).points(&factors).unwrap_or_default();
    let at = |point: &Vec<String>| f(&point.iter().filter_map(|x| x.parse().ok()).collect::<Vec<f64>>());
    points.chunks(5).map(|group| group.iter().map(at).collect()).collect()
}

#[test]
fn both_indices_of_ishigamis_function_are_the_known_ones() {
    let found = indices(&groups(1999, ishigami), 0.9).unwrap_or_default();
    assert_eq!(found.len(), 3);
    for (key, [first, total]) in found.iter().zip([[0.3139, 0.5576], [0.4424, 0.4424], [0.0, 0.2437]]) {
        for (index, expected) in [(key.first, first), (key.total, total)] {
            assert!((index.value - expected).abs() < 0.01, "{key:?} {expected}");
            assert!(index.bounds.is_some_and(|[low, high]| low < expected && expected < high), "{key:?}");
            assert!(index.bounds.is_some_and(|[low, high]| high - low < 0.12), "{key:?}");
        }
    }
}

#[test]
fn intervals_hold_about_as_often_as_they_say() {
    // Groups drawn by chance, as the bootstrap takes them.
    let known = [0.3139, 0.4424, 0.0, 0.5576, 0.4424, 0.2437];
    let (mut held, campaigns) = ([0; 6], 200);
    for campaign in 0..campaigns {
        let of = |group: u32| {
            let key = |element| DrawKey { seed: 1, shot: campaign, ply: group, yarn: 0, element };
            let [u, v] = [key(0).uniform(), key(1).uniform()];
            let [a, b] = [&u[..3], &v[..3]].map(|u| [0, 1, 2].map(|n: usize| PI * (2.0 * u[n] - 1.0)));
            let with = |key: usize| ishigami(&[0, 1, 2].map(|n| if n == key { b[n] } else { a[n] }));
            vec![ishigami(&a), ishigami(&b), with(0), with(1), with(2)]
        };
        let found = indices(&(0..128).map(of).collect::<Vec<_>>(), 0.9).unwrap_or_default();
        let all = found.iter().map(|key| key.first).chain(found.iter().map(|key| key.total));
        for ((held, known), index) in held.iter_mut().zip(known).zip(all) {
            *held += u32::from(index.bounds.is_some_and(|[low, high]| low <= known && known <= high));
        }
    }
    let parts = held.map(|held| f64::from(held) / f64::from(campaigns));
    assert!(parts.iter().all(|part| (0.80..=0.97).contains(part)), "{parts:?}");
}

#[test]
fn keys_that_only_add_have_one_index_and_what_does_not_vary_has_none() {
    let found = indices(&groups(512, |x| 2.0 * x[0] + x[1]), 0.9).unwrap_or_default();
    for (key, expected) in found.iter().zip([0.8, 0.2, 0.0]) {
        let off = [key.first, key.total].map(|index| (index.value - expected).abs());
        assert!(off.iter().all(|off| *off < 0.02), "{found:?}");
    }
    assert!(found.get(2).is_some_and(|key| key.first.value == 0.0 && key.total.value == 0.0), "{found:?}");
    assert!(indices(&groups(64, |_| 3.0), 0.9).is_none() && indices(&[], 0.9).is_none());
    let few = indices(&groups(7, ishigami), 0.9).unwrap_or_default();
    assert!(few.len() == 3 && few.iter().all(|key| key.total.bounds.is_none()));
}
