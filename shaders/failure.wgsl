// failure: strains of yarns as failure judges them, over a piece of yarn. Needs `cells`, and `strain_slot` to say which strains count.
// Twin: src/solver/failure.rs

/// Stands for the strain of a piece of yarn that is broken or absent.
const BROKEN: f32 = -1.0;

/// Strain of a yarn (0 warp, 1 weft) of an element.
fn strain_of(element: u32, which: u32) -> f32 { return bitcast<f32>(cells[cell_word(strain_slot(), STRAIN + which, element)]); }

/// Failure strains of an element's yarns.
fn failure_strain(element: u32) -> vec2<f32> {
    if (!STRENGTH) { return scene.failure_strain; }
    return scene.failure_strain * yarn_pair(2u, 0u, element);
}

/// Length of an element along a yarn over the finest.
fn width_along(ply: u32, axis: u32, at: u32) -> f32 {
    if (!GRADED) { return 1.0; }
    return line_at(ply, axis, at).width;
}

/// Sums over a row of elements along a yarn: strain times length and length of those that are whole, and 1 where none is broken.
struct Sums {
    strain: f32,
    length: f32,
    whole: f32,
}

/// Elements of a ply along an axis, and which of their ends a mirror plane cuts (1 the first, 2 the last).
struct Axis {
    count: i32,
    cut: u32,
}

fn axis_of(ply: u32, axis: u32) -> Axis {
    let count = i32(select(plies[ply].rows, plies[ply].columns, axis == 0u));
    return Axis(count, select(cut_sides(ply) >> 2u, cut_sides(ply), axis == 0u));
}

/// The element at a place along an axis; past a mirror plane lies the image. Negative: there is none.
fn element_along(a: Axis, at: i32) -> i32 {
    if (at < 0 && (a.cut & 1u) != 0u) { return -1 - at; }
    if (at >= a.count) { return select(-1, 2 * a.count - 1 - at, (a.cut & 2u) != 0u); }
    return at;
}

/// Adds an element. A broken one, slack beside its break, says nothing of the others.
fn add_strain(sums: ptr<function, Sums>, element: u32, which: u32, length: f32) {
    let strain = strain_of(element, which);
    if (strain >= 0.0) {
        (*sums).strain += length * strain;
        (*sums).length += length;
    } else if (is_present(element_ply(element), element_place(element))) {
        (*sums).whole = 0.0;
    }
}

/// The elements along a yarn that lie within the failure length of the middle of one at a place (row, column).
fn row_of(ply: u32, place: vec2<u32>, which: u32) -> Sums {
    var sums = Sums(0.0, 0.0, 1.0);
    let reach = scene.failure_reach[which];
    let own = place[1u - which];
    let axis = axis_of(ply, which);
    let half = 0.5 * width_along(ply, which, own);
    add_strain(&sums, element_at(ply, place), which, 2.0 * min(half, reach));
    for (var side = 0u; side < 2u; side++) {
        var begin = half;
        for (var along = 1; begin < reach; along++) {
            let at = element_along(axis, i32(own) + select(along, -along, side == 0u));
            if (at < 0) { break; }
            let width = width_along(ply, which, u32(at));
            let next = select(vec2<u32>(u32(at), place.y), vec2<u32>(place.x, u32(at)), which == 0u);
            add_strain(&sums, element_at(ply, next), which, min(width, reach - begin));
            begin += width;
        }
    }
    return sums;
}

/// The elements side by side in a yarn with one at a place (row, column): the first, and one past the last.
fn side_by_side(ply: u32, place: vec2<u32>, which: u32) -> vec2<u32> {
    let line = line_at(ply, 1u - which, place[which]);
    return vec2<u32>(u32(line.yarn_first), u32(line.yarn_end));
}

/// The place (row, column) so far across the yarn.
fn place_across(place: vec2<u32>, which: u32, at: u32) -> vec2<u32> {
    return select(vec2<u32>(place.x, at), vec2<u32>(at, place.y), which == 0u);
}

/// The piece of a yarn around an element, of the failure length and all its breadth: root mean square over its rows of the mean strains along
/// them, of the elements that are whole, but at most the largest strain of the elements side by side in its middle; and 1 where none is broken,
/// else 0. Zeros unless one of those side by side has at least this strain. They all get the same, so that they break together.
fn piece_of(element: u32, which: u32, least: f32) -> vec2<f32> {
    let ply = element_ply(element);
    let place = element_place(element);
    let across = side_by_side(ply, place, which);
    var largest = BROKEN;
    for (var at = across.x; at < across.y; at++) {
        largest = max(largest, strain_of(element_at(ply, place_across(place, which, at)), which));
    }
    if (largest < least) { return vec2<f32>(0.0); }
    var squares = 0.0;
    var area = 0.0;
    var whole = 1.0;
    for (var at = across.x; at < across.y; at++) {
        let row = row_of(ply, place_across(place, which, at), which);
        let breadth = width_along(ply, 1u - which, at);
        whole = min(whole, row.whole);
        if (row.length > 0.0) {
            squares += breadth * row.strain * row.strain / row.length;
            area += breadth * row.length;
        }
    }
    return vec2<f32>(min(largest, sqrt(squares / area)), whole);
}

/// Whether an element lies in the piece around another one of its yarn that reached the failure strain.
fn breaks_with_another(element: u32, which: u32) -> bool {
    let ply = element_ply(element);
    let place = element_place(element);
    let line = line_at(ply, which, place[1u - which]);
    for (var at = u32(line.breaking_first); at < u32(line.breaking_end); at++) {
        let other = element_at(ply, place_across(place, 1u - which, at));
        let limit = failure_strain(other)[which];
        if (other != element && limit <= piece_of(other, which, limit).x) { return true; }
    }
    return false;
}
