//! The V50 of standards.

use ripstop::study::arithmetic_v50::{Arithmetic, RULES, Refusal, Rule, arithmetic_v50};

use super::{near, outcomes};

const THREE: Rule = Rule { standard: "MIL-STD-662F", pairs: 3, spread: 38.0 };

#[test]
fn equally_many_lowest_perforations_and_highest_stops_are_taken() {
    let text = "480/0 500/0 505/0 512/0 508/1 515/1 520/1 560/1";
    let found = arithmetic_v50(&outcomes(text), &THREE).unwrap();
    near(found.mean, (500.0 + 505.0 + 512.0 + 508.0 + 515.0 + 520.0) / 6.0, 1e-9);
    near(found.spread, 20.0, 1e-9);
    let found = arithmetic_v50(&outcomes(text), &RULES[0]).unwrap();
    near(found.mean, (505.0 + 512.0 + 508.0 + 515.0) / 4.0, 1e-9);
}

/// A published set of 3 + 3 has the mean 1241.5 and the spread 478: its extremes are kept here.
#[test]
fn a_spread_that_is_too_wide_is_refused_with_the_mean() {
    let text = "1000/0 1200/0 1250/0 1240/1 1281/1 1478/1";
    let why = arithmetic_v50(&outcomes(text), &THREE).unwrap_err();
    let Refusal::TooWide(Arithmetic { mean, spread }) = why else { panic!("{why:?}") };
    near(mean, 1241.5, 1e-9);
    near(spread, 478.0, 1e-9);
}

#[test]
fn a_spread_that_is_just_met_is_met() {
    let within =
        |fastest: &str| arithmetic_v50(&outcomes(&format!("400/0 410/0 420/0 425/1 430/1 {fastest}/1")), &THREE);
    assert!(within("438").is_ok());
    assert!(within("438.1").is_err());
}

#[test]
fn too_few_shots_are_refused() {
    let why = arithmetic_v50(&outcomes("400/0 410/0 430/1 432/1 434/1"), &THREE).unwrap_err();
    assert_eq!(why, Refusal::TooFew { counts: [3, 2] });
}
