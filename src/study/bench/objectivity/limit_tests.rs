use std::convert::Infallible;

use super::*;

fn found(guess: f64, limit: f64) -> (Option<VelocityBracket>, u32) {
    let mut shots = 0;
    let found = bisect(guess, 0.01, |velocity| {
        shots += 1;
        Ok::<bool, Infallible>(velocity > limit)
    });
    (found.unwrap_or(None), shots)
}

#[test]
fn the_bracket_holds_the_limit_and_is_as_narrow_as_asked() {
    for guess in [60.0, 100.0, 141.0, 142.5, 250.0] {
        let (limit, shots) = found(guess, 142.0);
        let limit = limit.unwrap_or(VelocityBracket { stopped: f64::NAN, perforated: f64::NAN });
        assert!(limit.stopped <= 142.0 && 142.0 < limit.perforated, "{guess}: {limit:?}");
        assert!(limit.perforated - limit.stopped <= 0.01 * guess, "{guess}: {limit:?}");
        // Half a dozen to reach the limit from a guess far off, as many to close in on it.
        assert!(shots <= 16, "{guess}: {shots} shots");
    }
}

#[test]
fn no_bracket_is_no_limit() {
    assert_eq!(found(100.0, f64::INFINITY).0, None);
    assert_eq!(found(100.0, 0.0).0, None);
}
