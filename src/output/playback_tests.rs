use std::io::Read;

use flate2::read::ZlibDecoder;

use super::super::animation::Keyframe;
use super::*;

fn case() -> Case {
    crate::case::shipped(&["/expect=[]"])
}

/// An animation of one ply whose numbers follow a rule.
fn animation(keyframes: usize, nodes: usize) -> Animation {
    let mut animation = Animation::new(&case());
    // Like noise, so that it cannot be packed.
    let rough = |n: usize| ((n * n % 99_991 * 7919) % 100_003) as f32 * 1e-8;
    animation.plies = vec![AnimatedPly::for_tests((0..nodes).map(|n| [rough(n), rough(n + 1), 0.0]).collect())];
    for at in 0..keyframes {
        animation.keyframes.push(Keyframe {
            step: at as u64,
            time: at as f64,
            deflections: vec![0.0],
            displacement: (0..nodes).map(|n| [rough(n + at), -rough(n * at), rough(at)]).collect(),
            tension: (0..nodes).map(|n| [(n % 5 > 0).then_some(n as f32), (at < 2).then_some(at as f32)]).collect(),
            pose: None,
        });
    }
    animation
}

#[test]
fn numbers_come_back_to_half_a_step() {
    let animation = animation(4, 50);
    let packed = pack(&case(), &animation)
        .map(|(_, numbers)| BASE64_STANDARD.decode(numbers))
        .and_then(Result::ok)
        .unwrap_or_default();
    let mut bytes = Vec::new();
    assert!(ZlibDecoder::new(packed.as_slice()).read_to_end(&mut bytes).is_ok());
    let (steps, nodes, first) = (Rounding::of(&animation), 50, 2 * 50 * (3 + 3 * animation.keyframes.len()));
    let word = |block: usize, n: usize| {
        i16::from_le_bytes([bytes[2 * nodes * block + n], bytes[2 * nodes * block + nodes + n]])
    };
    let (mut moved, mut load) = (vec![[0_i16; 3]; nodes], vec![[0_u8; 2]; nodes]);
    let half = |got: f64, step: f64, expected: f32| (got * step - f64::from(expected)).abs() <= 0.51 * step;
    for (at, keyframe) in animation.keyframes.iter().enumerate() {
        for n in 0..nodes {
            for axis in 0..3 {
                moved[n][axis] = moved[n][axis].wrapping_add(word(3 + 3 * at + axis, n));
                let got = f64::from(moved[n][axis]);
                assert!(half(got, steps.displacement, keyframe.displacement[n][axis]), "{at} {n} {axis}");
            }
            for yarn in 0..2 {
                load[n][yarn] = load[n][yarn].wrapping_add(bytes[first + nodes * (2 * at + yarn) + n]);
                let whole = |tension| load[n][yarn] < BROKEN && half(load[n][yarn].into(), steps.tension, tension);
                let right = keyframe.tension[n][yarn].map_or(load[n][yarn] == BROKEN, whole);
                assert!(right, "{at} {n} {yarn}: {}", load[n][yarn]);
            }
        }
    }
    assert_eq!(bytes.len(), first + 2 * nodes * animation.keyframes.len());
}

#[test]
fn an_animation_that_is_too_large_loses_keyframes_and_one_of_a_single_one_is_none() {
    let (description, numbers) = pack(&case(), &animation(60, 16_000)).unwrap_or_default();
    let kept = description["times"].as_array().map_or(0, Vec::len);
    assert!((2..60).contains(&kept) && numbers.len() <= BUDGET, "{kept} {}", numbers.len());
    assert!(pack(&case(), &animation(1, 10)).is_none());
}
