//! The keys of `fabric`.

use super::fields::{CaseKey, KeyType, above, key, number, within, word};
use super::units::{DENIER, DTEX, G_M2, GPA, KG_M3, MM, MM_N13, MPA, NONE, PER_CM, PER_INCH, RAD, TEX};
use super::words::Word;
use super::{Law, MembraneForce, ShearModulus};

const NOT_PUBLISHED: &str = "assumed: not published for this fabric";

pub(super) static FABRIC: &[CaseKey] = &[
    key("name", KeyType::Text, "Designation."),
    number("fibre_density_kg_m3", KG_M3, within(100.0, 30_000.0), "Density of the fibre; gives the yarn's section."),
    number("areal_density_g_m2", G_M2, within(0.01, 1e5), "Mass per area of the fabric.")
        .derived("linear density × (1 + crimp) × count of both yarns"),
    key("warp", KeyType::Object(YARN), "Yarns along X."),
    key("weft", KeyType::Object(YARN), "Yarns along Y."),
    key("crossover", KeyType::Object(CROSSOVER), "Interaction of warp and weft.").optional(""),
    number("thickness_mm", MM, within(1e-3, 100.0), "Thickness of the fabric: shear resultant and ply spacing.")
        .default(0.30, NOT_PUBLISHED),
    key("shear", KeyType::WordOrObject(&["none"], SHEAR), "Resistance to trellis shear, (25) of the paper.")
        .optional(""),
];

static YARN: &[CaseKey] = &[
    key("absent", KeyType::Flag, "True: no yarn in this direction, its count still sets the element size.")
        .default_false("a woven fabric has both yarns"),
    number("linear_density_denier", DENIER, within(0.01, 1e6), "Mass of 9000 m of yarn.")
        .one_of("linear density")
        .only("absent", &["false"]),
    number("linear_density_tex", TEX, within(0.001, 1e5), "Mass of 1000 m of yarn.")
        .one_of("linear density")
        .only("absent", &["false"]),
    number("linear_density_dtex", DTEX, within(0.01, 1e6), "Mass of 10 000 m of yarn.")
        .one_of("linear density")
        .only("absent", &["false"]),
    number("modulus_gpa", GPA, within(1e-6, 1e4), "Axial modulus of the fibre.").only("absent", &["false"]),
    number("failure_strain", NONE, above(0.0, 1.0), "Axial strain at which the yarn breaks; 1: never.")
        .only("absent", &["false"]),
    number("count_per_inch", PER_INCH, within(0.1, 1000.0), "Crossovers along this yarn per inch.").one_of("count"),
    number("count_per_cm", PER_CM, within(0.04, 400.0), "Crossovers along this yarn per cm.").one_of("count"),
    number("crimp", NONE, within(0.0, 0.5), "Yarn length over fabric length, minus one.").only("absent", &["false"]),
];

static CROSSOVER: &[CaseKey] = &[
    word("law", Law::WORDS, "Unit-cell law.").default_word("published", "the paper's (11)-(24)"),
    word("membrane_force", MembraneForce::WORDS, "In-plane force of the published law: T.")
        .default_word("tension", "the paper's yarn tension"),
    number("gap_mm", MM, within(0.0, 1.0), "Initial gap between the yarns, (22).").default(0.0, NOT_PUBLISHED),
    key("compression", KeyType::WordOrObject(&["rigid"], COMPRESSION), "Transverse compression of the yarns, (21).")
        .optional(""),
];

static COMPRESSION: &[CaseKey] = &[
    number("a_mm", MM, within(0.0, 10.0), "Largest compression a of (21); a = b = 0 is rigid.")
        .default(0.10, NOT_PUBLISHED),
    number("b_mm_n13", MM_N13, within(0.0, 10.0), "b of (21).").default(0.10, NOT_PUBLISHED),
];

static SHEAR: &[CaseKey] = &[
    number("thickness_mm", MM, within(1e-3, 100.0), "Thickness that carries the shear stress.")
        .derived("the fabric's thickness_mm"),
    number("g1_mpa", MPA, within(0.0, 1e6), "Modulus before locking.").default(10.0, NOT_PUBLISHED),
    number("g2_mpa", MPA, within(0.0, 1e6), "Modulus after locking, at least g1_mpa.").default(1000.0, NOT_PUBLISHED),
    number("gamma1", RAD, within(0.0, 1.5), "Shear angle where locking begins.").default(0.35, NOT_PUBLISHED),
    number("gamma2", RAD, within(0.0, 1.5), "Shear angle where locking is complete, at least gamma1.")
        .default(0.60, NOT_PUBLISHED),
    word("modulus", ShearModulus::WORDS, "Tangent: dτ/dγ = G(γ).")
        .default_word("tangent", "model: G of (25) as the slope of the stress"),
];
