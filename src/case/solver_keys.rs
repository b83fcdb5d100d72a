//! The keys of `solver`.

use super::fields::{CaseKey, above, number, within, word};
use super::units::{MM, NONE, US};
use super::words::Word;
use super::{Accuracy, ContactSampling, Numerics, RunUntil, StretchSampling, Symmetry};

/// Hourglass stiffness over the full-integration stiffness where the case gives none.
const HOURGLASS: f64 = 0.001;

pub(super) static SOLVER: &[CaseKey] = &[
    number(
        "end_time_us",
        US,
        within(1e-6, 1e9),
        "End of the run. Needed where nothing flies freely into the pack, or run_until is \"end_time\".",
    )
    .derived("when the outcome is known, after 1000 µs at the latest, 8000 µs where no two opposite sides are clamped"),
    word(
        "numerics",
        Numerics::WORDS,
        "The scheme that keys left out take their values from: ripstop's own, or the paper's (one even element per crossover, contact \
        at nodes, stretches at the centre, no viscosity).",
    )
    .default_word("default", "measured: tension shocks neither ring nor make energy"),
    word(
        "accuracy",
        Accuracy::WORDS,
        "How far the mesh around the hit is refined, where elements_per_crossover is left out.",
    )
    .default_word("default", "measured: a ballistic limit within 5 % of the converged one"),
    number("courant", NONE, above(0.0, 1.0), "Time step over the critical one.")
        .default(0.9, "model: margin for contact, shear and hourglass stiffness")
        .help("above 1 the time step exceeds the critical step and leapfrog integration is unstable"),
    number("hourglass", NONE, within(0.0, 1.0), "Hourglass stiffness over the full-integration stiffness.")
        .default(HOURGLASS, "model: keeps hourglass energy small without stiffening"),
    number(
        "shock_viscosity",
        NONE,
        within(0.0, 1.0),
        "Viscosity along the yarns over the stiffness, times length of an element over wave speed, for smooth waves one crossover at most; 0: none, as in the paper.",
    )
    .derived("0.3, where a bar strikes 0.8, measured: tension behind a shock peaks at most a third above its plateau; 0 with \"numerics\": \"paper\""),
    number(
        "failure_length_mm",
        MM,
        within(0.0, 100.0),
        "Length along a yarn over which the strain that breaks it is averaged, and which breaks; over its width the root mean square \
        counts. 0: that of an element, as in the paper.",
    )
    .derived("0.9, assumed: the order of a yarn's width; 0 with \"numerics\": \"paper\""),
    word("symmetry", Symmetry::WORDS, "Whether mirror symmetry may be used.")
        .default_word("auto", "same result, less work"),
    word(
        "contact_sampling",
        ContactSampling::WORDS,
        "Where contact with the projectile is sampled: at nodes, or also where the rim of a flat face crosses the edges \
        of elements.",
    )
    .derived("rim, measured: before failure nearer to a finer mesh than nodes; nodes with \"numerics\": \"paper\""),
    word(
        "stretch_sampling",
        StretchSampling::WORDS,
        "Where an element's stretches are taken: at its centre, or as the root of the mean of their squares over the element.",
    )
    .derived("mean, measured: the ballistic limit is within 1 % of the converged one, not 4 %; centre with \"numerics\": \"paper\""),
    word(
        "run_until",
        RunUntil::WORDS,
        "When the run ends: with the outcome, when a projectile that stopped is free of the fabric too, or at end_time_us.",
    )
        .default_word("outcome", "nothing asked for happens after it"),
];
