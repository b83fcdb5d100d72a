//! Defects of `element_force` in unit cells and in trellis shear.

use super::super::Mutant;

const fn mutant(name: &'static str, scene: &'static str, find: &'static str, put: &'static str) -> Mutant {
    Mutant { name, kernel: "element_force", scene, find, put }
}

pub(super) const MUTANTS: &[Mutant] = &[
    mutant(
        "cosine of shear missing",
        "Published, rigid",
        "shear_resultant(angle) / sqrt(1.0 - squared(followed))",
        "shear_resultant(angle)",
    ),
    mutant(
        "force never refined",
        "soft at first touch",
        "Found(x, refine(stretch, x, best), iterations",
        "Found(x, best, iterations",
    ),
    mutant(
        "refined height beyond that without compression",
        "soft at first touch",
        "min(trial.other_height + trial.residual / trial.other.stiffness, scene.height_sum - x)",
        "trial.other_height + trial.residual / trial.other.stiffness",
    ),
    mutant("refined once", "soft at first touch", "i < REFINEMENTS", "i < 1u"),
    mutant(
        "compression missing",
        "Variational, compressible",
        "scene.compression_a - scene.compression_b * q, 0.0",
        "0.0, 0.0",
    ),
    mutant("unequal contact forces accepted", "Published, rigid", "abs(pivot.force - other.force) + so", "so"),
    mutant(
        "compression forgotten by the steps",
        "Variational, compressible",
        "let give = b * q * cube * (1.0 / 3.0);",
        "let give = 0.0;",
    ),
    mutant(
        "energy of compression",
        "Variational, compressible, yarns exchanged",
        "- d / (a * a * a)",
        "+ d / (a * a * a)",
    ),
    mutant(
        "contact force halved",
        "Variational, compressible",
        "force = PI * s.arc.slope",
        "force = HALF_PI * s.arc.slope",
    ),
    mutant("arc length term missing", "Published, compressible", "0.5 * a2 * g_minus_1", "0.5 * secant * g_minus_1"),
    mutant("shares of the yarns exchanged", "Variational, compressible", "slope.yx * per_sum", "slope * per_sum"),
    mutant(
        "heights guided past the crossover",
        "Variational, compressible",
        "(give * (slope.x * slope.y) + (slope.x + slope.y))",
        "(slope.x + slope.y)",
    ),
    mutant(
        "heights that fall with the force alone",
        "Published, compressible",
        "force * (1.0 + strain) - height * slope * strain",
        "force * (1.0 + strain)",
    ),
    mutant(
        "guide of the pivot for that of the warp",
        "Variational, compressible",
        "select(pair.yx, pair, PIVOT == 0u)",
        "select(pair, pair.yx, PIVOT == 0u)",
    ),
    mutant(
        "heights predicted the wrong way",
        "Variational, compressible",
        "+ height - predictor.dh_dstretch * change",
        "+ height + predictor.dh_dstretch * change",
    ),
    mutant("series coefficient doubled", "Variational, rigid", "    0.015625,", "    0.03125,"),
    mutant(
        "curvature of the arc",
        "Variational, compressible",
        "(1.0 + excess) * inverse_secant * inverse_secant - b",
        "(1.0 + excess) * inverse_secant - b",
    ),
    mutant(
        "tangent shear as secant",
        "Variational, compressible",
        "0.5 * scene.shear_slope * squared(into) + scene.shear_rise * past;",
        "scene.shear_slope * squared(into) + scene.shear_rise * past;",
    ),
    mutant("shear even in its angle", "Variational, rigid, yarns exchanged", "select(q, -q, gamma < 0.0)", "q"),
    mutant(
        "shear energy past the ramp",
        "Variational, rigid",
        "0.5 * scene.shear_slope * squared(into) * past",
        "scene.shear_slope * squared(into) * past",
    ),
    mutant("upper half of the arc sine", "Variational, compressible", "HALF_PI - 2.0 * angle", "HALF_PI - angle"),
    mutant(
        "height of the wrong yarn",
        "Variational, compressible, yarns exchanged",
        "out.height[1u - PIVOT] = best.other_height;",
        "out.height[1u - PIVOT] = found.x;",
    ),
    mutant(
        "warm start not used",
        "Variational, compressible",
        "vec2<f32>(warm[PIVOT], warm[1u - PIVOT])",
        "vec2<f32>(0.5 * top)",
    ),
];
