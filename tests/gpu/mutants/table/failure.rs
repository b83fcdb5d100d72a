//! Defects of `failure`.

use super::super::Mutant;

const fn mutant(name: &'static str, scene: &'static str, find: &'static str, put: &'static str) -> Mutant {
    Mutant { name, kernel: "failure", scene, find, put }
}

pub(super) const MUTANTS: &[Mutant] = &[
    mutant("own strain not asked for", "nonlocal", "own < limit || ", ""),
    mutant("own strain alone", "nonlocal", "weights == 0.0 || sum >= limit * weights", "true"),
    mutant("broken yarns break again", "nonlocal", " || (flags[element] & (1u << yarn)) == 0u", ""),
    mutant(
        "limit of the warp for the weft",
        "nonlocal",
        "breaks(element, 1u, scene.weft",
        "breaks(element, 1u, scene.warp",
    ),
    mutant(
        "strain of the warp for the weft",
        "nonlocal",
        "let own = strains[yarn * scene.elements + element]",
        "let own = strains[element]",
    ),
    mutant(
        "mean of the other yarn",
        "nonlocal",
        "strains[yarn * scene.elements + other]",
        "strains[(1u - yarn) * scene.elements + other]",
    ),
    mutant("mark of the other yarn", "nonlocal", "u32(warp) + 2u * u32(weft)", "u32(weft) + 2u * u32(warp)"),
    mutant("broken pieces count", "nonlocal", "whole = (flags[other] & (1u << yarn)) != 0u;", ""),
    mutant("life of the other yarn", "nonlocal", "(flags[other] & (1u << yarn))", "(flags[other] & (2u >> yarn))"),
    mutant("halves count as wholes", "nonlocal", "let part = weight(along, at);", "let part = 1.0;"),
    mutant("outer lines count as wholes", "nonlocal", "let width = weight(across, line);", "let width = 1.0;"),
    mutant(
        "lines taken for pieces",
        "nonlocal",
        "window(ply, yarn, place[yarn]);",
        "window(ply, 1u - yarn, place[1u - yarn]);",
    ),
    mutant(
        "rows and columns exchanged",
        "nonlocal",
        "vec2<u32>(line, at), yarn == 0u",
        "vec2<u32>(line, at), yarn == 1u",
    ),
    mutant(
        "a window of one size",
        "nonlocal, two elements per crossover",
        "let reach = scene.neighbourhood;",
        "let reach = 2.0;",
    ),
    mutant(
        "one that is alone spared",
        "nonlocal, one row bears all",
        "\n        || mean_along(ply, yarn, place[yarn], along) >= limit * scene.alone",
        "",
    ),
    mutant("one that is alone bears no more", "nonlocal, one row bears all", "limit * scene.alone", "limit"),
    mutant(
        "mean along another line",
        "nonlocal, one row bears all",
        "along) >= limit * scene",
        "across) >= limit * scene",
    ),
    mutant(
        "broken pieces of its own count",
        "nonlocal, one row bears all",
        "if ((flags[piece] & (1u << yarn)) != 0u) {",
        "if (true) {",
    ),
    mutant(
        "pieces of its own as wholes",
        "nonlocal, one row bears all",
        "let share = weight(along, at);",
        "let share = 1.0;",
    ),
    mutant(
        "small parts left out",
        "nonlocal, three crossovers per element",
        "const SAME: f32 = 1e-6;",
        "const SAME: f32 = 0.2;",
    ),
    mutant(
        "last half left out",
        "nonlocal",
        "ceil(middle + scene.neighbourhood)",
        "floor(middle + scene.neighbourhood)",
    ),
    mutant(
        "beyond the end",
        "nonlocal",
        "min(u32(ceil(middle + scene.neighbourhood)), count)",
        "u32(ceil(middle + scene.neighbourhood))",
    ),
    mutant("no images in front", "nonlocal, a quarter", "if (span.before) {", "if (false) {"),
    mutant(
        "image of the wrong element",
        "nonlocal, a quarter",
        "overlap(span, -f32(at) - 1.0)",
        "overlap(span, -f32(at))",
    ),
    mutant(
        "planes of the other axis",
        "nonlocal, a part of turned plies",
        "select(cut_sides(ply) >> 2u, cut_sides(ply)",
        "select(cut_sides(ply), cut_sides(ply) >> 2u",
    ),
    mutant("no images behind", "nonlocal, a part of turned plies", "if (span.behind) {", "if (false) {"),
    mutant(
        "image behind one too far",
        "nonlocal, a part of turned plies",
        "2u * span.count - at - 1u",
        "2u * span.count - at",
    ),
    mutant(
        "size of the storage for that of the ply",
        "nonlocal, plies of two fabrics",
        "select(plies[ply].rows, plies[ply].columns, axis == 1u)",
        "select(scene.rows, scene.columns, axis == 1u)",
    ),
    mutant("limits of another sheet", "nonlocal, plies of two fabrics", "&& plies[ply].sheet == scene.sheet &&", "&&"),
];
