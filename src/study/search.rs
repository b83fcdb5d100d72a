//! Roots and maxima of functions of one variable.

/// Halvings of a bracket at most.
const STEPS: usize = 200;
/// Share of the larger part that golden sections keep.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Where a function changes its sign between `a` and `b`, to within `tolerance`: regula falsi (Illinois), halved where that is slow.
pub(super) fn root(f: impl Fn(f64) -> f64, mut a: f64, mut b: f64, tolerance: f64) -> f64 {
    let (mut fa, mut fb) = (f(a), f(b));
    for step in 0..STEPS {
        let middle = if step % 3 == 2 { 0.5 * (a + b) } else { (a * fb - b * fa) / (fb - fa) };
        let x = if middle > a.min(b) && middle < a.max(b) { middle } else { 0.5 * (a + b) };
        let fx = f(x);
        if fx == 0.0 || (b - a).abs() <= tolerance {
            return x;
        }
        if (fx > 0.0) == (fb > 0.0) {
            fa *= 0.5;
        } else {
            (a, fa) = (b, fb);
        }
        (b, fb) = (x, fx);
    }
    b
}

/// The end of an interval around `inside`: where a function, which is positive inside, becomes negative. It is looked for in steps that double,
/// the first of which has the sign of the side, up to `last`; `None`: there is no end before it.
pub(super) fn outer_end(f: impl Fn(f64) -> f64, inside: f64, step: f64, last: f64, tolerance: f64) -> Option<f64> {
    let (mut inside, mut step) = (inside, step);
    for _ in 0..STEPS {
        let next = if step > 0.0 { (inside + step).min(last) } else { (inside + step).max(last) };
        if f(next) < 0.0 {
            return Some(root(f, inside, next, tolerance));
        }
        if next == last {
            return None;
        }
        inside = next;
        step *= 2.0;
    }
    None
}

/// Place, to within `tolerance`, and height of the maximum of a function with one, by golden sections.
pub(super) fn peak(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64, tolerance: f64) -> (f64, f64) {
    let inner = |low: f64, high: f64| [high - GOLDEN * (high - low), low + GOLDEN * (high - low)];
    let [mut a, mut b] = inner(low, high);
    let (mut fa, mut fb) = (f(a), f(b));
    for _ in 0..STEPS {
        if high - low <= tolerance {
            break;
        }
        if fa < fb {
            (low, a, fa) = (a, b, fb);
            b = inner(low, high)[1];
            fb = f(b);
        } else {
            (high, b, fb) = (b, a, fa);
            a = inner(low, high)[0];
            fa = f(a);
        }
    }
    if fa < fb { (b, fb) } else { (a, fa) }
}

/// The same for a function that may have several: first the best of evenly spaced places.
pub(super) fn highest(f: impl Fn(f64) -> f64, low: f64, high: f64, count: usize, tolerance: f64) -> (f64, f64) {
    let width = (high - low) / count as f64;
    let at = |n: usize| low + width * n as f64;
    let best = (0..=count)
        .map(|n| (at(n), f(at(n))))
        .fold((low, f64::NEG_INFINITY), |best, next| if next.1 > best.1 { next } else { best });
    let found = peak(&f, (best.0 - width).max(low), (best.0 + width).min(high), tolerance);
    if found.1 > best.1 { found } else { best }
}
