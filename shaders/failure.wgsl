// failure: nonlocal failure. Marks the yarns whose own strain and whose mean strain over what lies around the element have both reached
// the failure strain, and those whose mean along themselves is beyond what one alone bears: they break in the next step. Marks lie
// apart from what other invocations read.
//   in      flags    array<u32>  (E)      bit 0 warp alive, bit 1 weft alive
//   in/out  strains  array<f32>  (3, E)   of warp and weft [-], and which of them are to break: 1 warp, 2 weft
//   in      status   array<u32>           counters
// Twin: src/step/failure.rs and src/model/neighbourhood.rs

@group(1) @binding(0) var<storage, read> flags: array<u32>;
@group(1) @binding(1) var<storage, read_write> strains: array<f32>;
@group(1) @binding(2) var<storage, read_write> status: array<atomic<u32>>;

/// Shares of an element that rounding makes.
const SAME: f32 = 1e-6;

/// Elements of a ply along one of its axes, from a place on, and what lies around it.
struct Window {
    middle: f32,
    first: u32,
    end: u32,
    /// One past the last element there is.
    count: u32,
    /// Whether mirror planes cut the ply before the first element, behind the last.
    before: bool,
    behind: bool,
}

/// What lies around a row (axis 0) or a column (axis 1).
fn window(ply: u32, axis: u32, at: u32) -> Window {
    let count = select(plies[ply].rows, plies[ply].columns, axis == 1u);
    let cut = select(cut_sides(ply) >> 2u, cut_sides(ply), axis == 1u);
    let middle = f32(at) + 0.5;
    let first = u32(max(floor(middle - scene.neighbourhood), 0.0));
    let end = min(u32(ceil(middle + scene.neighbourhood)), count);
    return Window(middle, first, end, count, (cut & 1u) != 0u, (cut & 2u) != 0u);
}

/// How much of the element after a line lies around.
fn overlap(span: Window, line: f32) -> f32 {
    let reach = scene.neighbourhood;
    return max(min(line + 1.0, span.middle + reach) - max(line, span.middle - reach), 0.0);
}

/// How much of an element counts: past a mirror plane its image does too.
fn weight(span: Window, at: u32) -> f32 {
    var sum = overlap(span, f32(at));
    if (span.before) {
        sum += overlap(span, -f32(at) - 1.0);
    }
    if (span.behind) {
        sum += overlap(span, f32(2u * span.count - at - 1u));
    }
    return sum;
}

/// Mean strain of a yarn over its whole pieces along a window; `line`: its row or column.
fn mean_along(ply: u32, yarn: u32, line: u32, along: Window) -> f32 {
    var strain = 0.0;
    var length = 0.0;
    for (var at = along.first; at < along.end; at++) {
        let share = weight(along, at);
        let piece = element_at(ply, select(vec2<u32>(at, line), vec2<u32>(line, at), yarn == 0u));
        if ((flags[piece] & (1u << yarn)) != 0u) {
            strain += share * strains[yarn * scene.elements + piece];
            length += share;
        }
    }
    return strain / length;
}

/// Whether a yarn (0 warp, 1 weft) of an element is to break.
fn breaks(element: u32, yarn: u32, limit: f32) -> bool {
    let own = strains[yarn * scene.elements + element];
    if (own < limit || (flags[element] & (1u << yarn)) == 0u) {
        return false;
    }
    let ply = element_ply(element);
    let place = element_place(element);
    // Rows lie across the warp.
    let across = window(ply, yarn, place[yarn]);
    let along = window(ply, 1u - yarn, place[1u - yarn]);
    var sum = 0.0;
    var weights = 0.0;
    for (var line = across.first; line < across.end; line++) {
        let width = weight(across, line);
        // A piece of yarn that is broken, slack beside its break, says nothing of those beside it.
        var whole = width > SAME;
        var strain = 0.0;
        var length = 0.0;
        for (var at = along.first; at < along.end && whole; at++) {
            let part = weight(along, at);
            if (part > SAME) {
                let other = element_at(ply, select(vec2<u32>(at, line), vec2<u32>(line, at), yarn == 0u));
                whole = (flags[other] & (1u << yarn)) != 0u;
                strain += part * strains[yarn * scene.elements + other];
                length += part;
            }
        }
        if (whole) {
            sum += width * strain;
            weights += width * length;
        }
    }
    return weights == 0.0 || sum >= limit * weights
        || mean_along(ply, yarn, place[yarn], along) >= limit * scene.alone;
}

@compute @workgroup_size(64)
fn failure(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let element = invocation(group, groups, local);
    if (!is_due(element) || step.index > atomicLoad(&status[BAD_STEP])) {
        return;
    }
    let warp = breaks(element, 0u, scene.warp_failure_strain);
    let weft = breaks(element, 1u, scene.weft_failure_strain);
    if (warp || weft) {
        strains[2u * scene.elements + element] = f32(u32(warp) + 2u * u32(weft));
    }
}
