//! Numbers in words.

pub use crate::case::bytes;

/// At least `digits` significant digits, trailing zeros of a fraction left out; very large and small with an exponent.
pub fn short(value: f64, digits: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let magnitude = value.abs().log10().floor() as i32;
    if !(-4..7).contains(&magnitude) {
        return format!("{value:.*e}", (digits - 1).max(0) as usize);
    }
    let decimals = (digits - 1 - magnitude).max(0) as usize;
    let text = format!("{value:.decimals$}");
    if decimals > 0 { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A fixed number of decimals, without a sign on zero.
pub fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.chars().all(|c| matches!(c, '0' | '.')) => digits.to_owned(),
        _ => text,
    }
}

/// A fraction in percent, or with an exponent where percent would say nothing.
pub fn fraction(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        size if size >= 1e-4 => format!("{:.2} %", value * 100.0),
        _ => format!("{value:.1e}"),
    }
}

/// A time [s] in µs without rounding noise.
pub fn us(time: f64) -> String {
    format!("{} µs", short(time * 1e6, 5))
}

/// A whole number in groups of three.
pub fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let groups = digits.as_bytes().rchunks(3).rev().map(String::from_utf8_lossy);
    groups.collect::<Vec<_>>().join(" ")
}
