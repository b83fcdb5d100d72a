//! Values that random scenes draw.

use std::ops::Range;

use proptest::prelude::{BoxedStrategy, Just, Strategy, prop_oneof};
use proptest::sample::select;
use serde_json::{Value, json};

/// Four significant digits: a case that people can read.
pub(super) fn short(x: f64) -> f64 {
    format!("{x:.3e}").parse().unwrap_or(x)
}

/// Values of a range: few enough to be shrunk in a dozen trials, to zero in a range around it, else to the start.
const VALUES: i32 = 1000;

/// Uniform; a range that begins below zero is as wide above it.
pub(super) fn number(range: Range<f64>) -> BoxedStrategy<f64> {
    let Range { start, end } = range;
    if start < 0.0 {
        return (-VALUES..VALUES + 1).prop_map(move |i| short(end * f64::from(i) / f64::from(VALUES))).boxed();
    }
    (0..VALUES + 1).prop_map(move |i| short(start + (end - start) * f64::from(i) / f64::from(VALUES))).boxed()
}

/// Uniform in the logarithm.
pub(super) fn log(range: Range<f64>) -> BoxedStrategy<f64> {
    let Range { start, end } = range;
    (0..VALUES + 1).prop_map(move |i| short(start * (end / start).powf(f64::from(i) / f64::from(VALUES)))).boxed()
}

/// Zero now and then, else in the logarithm.
pub(super) fn zero_or(range: Range<f64>) -> BoxedStrategy<f64> {
    prop_oneof![1 => Just(0.0), 3 => log(range)].boxed()
}

/// How the sides of a pack are held: left, right, bottom, top.
pub(super) fn sides([left, right, bottom, top]: [&str; 4]) -> Value {
    json!({"left": left, "right": right, "bottom": bottom, "top": top})
}

/// Every side held in a way of its own.
pub(super) fn any_sides() -> impl Strategy<Value = Value> {
    [(); 4].map(|()| select(vec!["clamped", "free", "roller"])).prop_map(sides)
}
