//! The keys of `variability`.

use super::fields::{CaseKey, KeyType, above, key, number, within, word};
use super::units::{DEG, M_S, MM, NONE};
use super::words::Word;
use super::{Distribution, HitPlace};

/// What a scatter is.
const SCATTER: &str = "Standard deviation of a normal distribution, half the width of a uniform one.";
const RELATIVE: &str =
    "Standard deviation of a normal distribution, half the width of a uniform one, over the nominal value.";

pub(super) static VARIABILITY: &[CaseKey] = &[
    key("seed", KeyType::Whole(0, u32::MAX), "Number that all draws come from.").default(1.0, "one sequence of shots"),
    key("shot", KeyType::Whole(0, u32::MAX), "The shot whose draws this case has, counted from 0.")
        .optional("the nominal case: nothing varies"),
    word(
        "hit",
        HitPlace::WORDS,
        "Where the projectile hits: the point of aim, or anywhere in the unit cell around it, evenly.",
    )
    .default_word("aimed", "the point of aim"),
    key("velocity", KeyType::Object(VELOCITY), "Impact velocity about the nominal one.").optional("it does not vary"),
    key(
        "obliquity",
        KeyType::Object(ANGLE),
        "Angle of the line of flight about the nominal one; at normal incidence in any direction.",
    )
    .optional("it does not vary"),
    key(
        "yaw",
        KeyType::Object(ANGLE),
        "Yaw about the nominal one, in the plane of the azimuth; at normal incidence in any direction.",
    )
    .optional("it does not vary"),
    key(
        "modulus",
        KeyType::Object(FRACTION),
        "Axial modulus of the fibre: one draw for warp, one for weft of a fabric.",
    )
    .optional("it does not vary"),
    key(
        "crimp",
        KeyType::Object(FRACTION),
        "Crimp: one draw for warp, one for weft of a fabric; an areal density that is given stays.",
    )
    .optional("it does not vary"),
    key(
        "yarn_strength",
        KeyType::Object(STRENGTH),
        "Strength of yarns along their length and between them, after Weibull.",
    )
    .optional("it does not vary"),
];

/// The distribution of a value.
const fn distribution() -> CaseKey {
    word("distribution", Distribution::WORDS, "Distribution about the nominal value.")
        .default_word("normal", "assumed: many small causes")
}

static VELOCITY: &[CaseKey] = &[distribution(), number("scatter_m_s", M_S, above(0.0, 1000.0), SCATTER)];

static ANGLE: &[CaseKey] = &[distribution(), number("scatter_deg", DEG, above(0.0, 45.0), SCATTER)];

static FRACTION: &[CaseKey] = &[distribution(), number("scatter", NONE, above(0.0, 0.5), RELATIVE)];

static STRENGTH: &[CaseKey] = &[
    number("shape", NONE, within(1.0, 1000.0), "Weibull's shape m along a yarn; large: even.")
        .help("Kevlar 49 yarn has 8 to 22, by gauge length"),
    number(
        "gauge_length_mm",
        MM,
        within(0.01, 1e5),
        "Length of the yarns whose mean failure strain is the fabric's failure_strain; a shorter piece is stronger.",
    ),
    number("yarn_shape", NONE, within(1.0, 1000.0), "Weibull's shape of the distribution of whole yarns about mean 1.")
        .optional("yarns do not differ but along their length"),
];
