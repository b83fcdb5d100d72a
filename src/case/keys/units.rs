//! Units: that of a key, which is the end of its name, and others that a value may bring with it: `"8 in"` for `width_mm`.

use std::f64::consts::PI;

use serde_json::{Map, Value, json};

use super::super::changes;
use super::super::error::{is_at_or_below, number_text};
use super::{CASE, keys};

/// Unit of a key: its sign; SI = value · numerator / denominator, so that decimal factors round once.
pub(in crate::case) struct Unit(pub(super) &'static str, f64, f64);

/// Units by the ends of the names of their keys; of several that fit the first is meant.
const UNITS: [(&str, Unit); 21] = [
    ("_deg", Unit("deg", PI, 180.0)),
    ("_mm", Unit("mm", 1.0, 1e3)),
    ("_mm_n13", Unit("mm·N^(1/3)", 1.0, 1e3)),
    ("_us", Unit("µs", 1.0, 1e6)),
    ("_m_s", Unit("m/s", 1.0, 1.0)),
    ("_rad_s", Unit("rad/s", 1.0, 1.0)),
    ("_g", Unit("g", 1.0, 1e3)),
    ("_g_mm2", Unit("g·mm²", 1.0, 1e9)),
    ("_kg_m3", Unit("kg/m³", 1.0, 1.0)),
    ("_g_m2", Unit("g/m²", 1.0, 1e3)),
    ("_g_den", Unit("g/den", GRAM_PER_DENIER[0], GRAM_PER_DENIER[1])),
    ("_cn_tex", Unit("cN/tex", 1e4, 1.0)),
    ("_denier", Unit("denier", 1.0, 9e6)),
    ("_tex", Unit("tex", 1.0, 1e6)),
    ("_dtex", Unit("dtex", 1.0, 1e7)),
    ("_per_inch", Unit("1/inch", 1e4, 254.0)),
    ("_per_cm", Unit("1/cm", 100.0, 1.0)),
    ("_per_s", Unit("1/s", 1.0, 1.0)),
    ("_gpa", Unit("GPa", 1e9, 1.0)),
    ("_mpa", Unit("MPa", 1e6, 1.0)),
    ("_n_per_m", Unit("N/m", 1.0, 1.0)),
];

/// Weight of a gram on a yarn of one denier [N·m/kg]: 9.80665e-3 N times 9e6 m/kg.
const GRAM_PER_DENIER: [f64; 2] = [8_825_985.0, 100.0];
/// Pound-force [1e-13 N].
const POUND_FORCE: f64 = 44_482_216_152_605.0;

/// A unit that a value may bring: its spellings, plain and in lower case, and SI = value · numerator / denominator.
type Spelled = (&'static str, f64, f64);

/// Units of one quantity each. The unit of a key is among those of its quantity.
const QUANTITIES: [&[Spelled]; 13] = [
    &[("%", 1.0, 100.0)],
    &[
        ("mm", 1.0, 1e3),
        ("cm", 1.0, 1e2),
        ("m", 1.0, 1.0),
        ("um", 1.0, 1e6),
        ("in inch inches", 254.0, 1e4),
        ("ft foot feet", 3048.0, 1e4),
        ("mil mils", 254.0, 1e7),
    ],
    &[
        ("m/s", 1.0, 1.0),
        ("km/s", 1e3, 1.0),
        ("km/h", 1e3, 3600.0),
        ("ft/s fps ft/sec", 3048.0, 1e4),
        ("mph", 44_704.0, 1e5),
    ],
    &[
        ("g", 1.0, 1e3),
        ("kg", 1.0, 1.0),
        ("mg", 1.0, 1e6),
        ("gr grain grains", 6_479_891.0, 1e11),
        ("oz", 28_349_523_125.0, 1e12),
        ("lb lbs", 45_359_237.0, 1e8),
    ],
    &[
        ("g/m2 gsm", 1.0, 1e3),
        ("kg/m2", 1.0, 1.0),
        ("oz/yd2", 28_349_523_125.0, 836_127_360_000.0),
        ("lb/ft2 psf", 45_359_237.0, 9_290_304.0),
    ],
    &[("kg/m3", 1.0, 1.0), ("g/cm3 g/cc", 1e3, 1.0), ("lb/in3", 45_359_237e4, 16_387_064.0)],
    &[("denier den", 1.0, 9e6), ("tex", 1.0, 1e6), ("dtex", 1.0, 1e7)],
    &[("/inch /in", 1e4, 254.0), ("/cm", 100.0, 1.0), ("/10cm", 10.0, 1.0), ("/m", 1.0, 1.0)],
    &[("/s", 1.0, 1.0)],
    &[
        ("gpa", 1e9, 1.0),
        ("mpa n/mm2", 1e6, 1.0),
        ("psi", POUND_FORCE, 6_451_600_000.0),
        ("ksi", POUND_FORCE, 6_451_600.0),
        ("msi", 10.0 * POUND_FORCE, 64_516.0),
    ],
    &[
        ("g/den gf/den gpd", GRAM_PER_DENIER[0], GRAM_PER_DENIER[1]),
        ("cn/tex", 1e4, 1.0),
        ("cn/dtex", 1e5, 1.0),
        ("mn/tex", 1e3, 1.0),
        ("n/tex", 1e6, 1.0),
    ],
    &[("us", 1.0, 1e6), ("ms", 1.0, 1e3), ("s", 1.0, 1.0)],
    &[("deg °", PI, 180.0), ("rad", 1.0, 1.0)],
];

/// A key's name without its unit, and the unit.
pub(in crate::case) fn split_unit(key: &str) -> (&str, Option<&'static Unit>) {
    let found = UNITS.iter().find_map(|(end, unit)| Some((key.strip_suffix(end)?, Some(unit))));
    found.unwrap_or((key, None))
}

/// A key or a column in words, with its unit in brackets.
pub(crate) fn in_words(name: &str) -> String {
    let (name, unit) = match (split_unit(name), name.strip_suffix("_j")) {
        (_, Some(name)) => (name, "J"),
        ((name, unit), _) => (name, unit.map_or("-", |unit| unit.0)),
    };
    format!("{} [{unit}]", name.replace('_', " "))
}

impl Unit {
    pub(in crate::case) fn to_si(&self, value: f64) -> f64 {
        value * self.1 / self.2
    }

    pub(in crate::case) fn of_si(&self, si: f64) -> f64 {
        si * self.2 / self.1
    }

    /// Turns a number of a document into SI units.
    pub(in crate::case) fn convert(&self, value: &mut Value) {
        if let Some(number) = value.as_f64() {
            *value = json!(self.to_si(number));
        }
    }
}

/// A sign in the form of [`QUANTITIES`]: `Yarns per inch`, `1/inch` and `/in` are one.
fn plain(sign: &str) -> String {
    let mut text = sign.to_lowercase().replace("^2", "2").replace("^3", "3").replace("per", "/");
    text.retain(|c| !c.is_whitespace() && c != '·');
    let text = text.replace('²', "2").replace('³', "3").replace(['µ', 'μ'], "u");
    let words = ["yarns", "ends", "picks", "threads", "1"];
    let rest = words.iter().find_map(|word| text.strip_prefix(word).filter(|rest| rest.starts_with('/')));
    rest.unwrap_or(&text).to_owned()
}

/// The units that stand in place of a key's; none of a key whose unit has no others.
fn quantity(unit: Option<&str>) -> &'static [Spelled] {
    let sign = unit.map_or("%".to_owned(), plain);
    QUANTITIES.into_iter().find(|units| spelled(units, &sign).is_some()).unwrap_or(&[])
}

fn spelled<'a>(units: &'a [Spelled], sign: &str) -> Option<&'a Spelled> {
    units.iter().find(|(names, ..)| names.split(' ').any(|name| name == sign))
}

/// Number and unit of a text: `8 in`.
fn split(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    let is_number = |(at, _): &(usize, char)| text[..*at].parse().is_ok_and(f64::is_finite);
    let at = match text.parse::<f64>() {
        Ok(_) => text.len(),
        Err(_) => text.char_indices().rfind(is_number)?.0,
    };
    Some((text[..at].parse().ok().filter(|number: &f64| number.is_finite())?, text[at..].trim()))
}

/// A text with a unit for a key with this one (none: a number without): the number in the key's unit, and the factor, 1 where it is the same.
fn converted(text: &str, unit: Option<&str>) -> Option<(f64, f64)> {
    let (number, sign) = split(text)?;
    let units = quantity(unit);
    let &(_, up, down) = spelled(units, &plain(sign))?;
    let (_, own_up, own_down) = unit.and_then(|own| spelled(units, &plain(own))).copied().unwrap_or(("", 1.0, 1.0));
    let factor = up * own_down / (down * own_up);
    Some((number * factor, factor))
}

/// A text with a unit as the value of a key, by the key's name: a number where the unit is the key's own, else the text; `None` where the
/// unit is of another quantity.
pub fn value_in(key: &str, text: &str) -> Option<Value> {
    let (number, factor) = converted(text, split_unit(key).1.map(|unit| unit.0))?;
    Some(if factor == 1.0 { json!(number) } else { json!(text.trim()) })
}

/// Signs of the units that a value of a key with this one may have, for messages.
pub(in crate::case) fn others(unit: Option<&str>) -> Vec<&'static str> {
    quantity(unit).iter().filter_map(|(names, ..)| names.split(' ').next()).collect()
}

/// Whether a text is a number with something behind it.
pub(in crate::case) fn has_number(text: &str) -> bool {
    split(text).is_some_and(|(_, sign)| !sign.is_empty())
}

/// Puts numbers in the units of their keys in place of texts with units, and the factor of each into the document's sources.
pub(in crate::case) fn without_units(document: &mut Value) {
    let mut notes = Vec::new();
    convert("", &CASE, document, &mut notes);
    let Some(sources) = changes::sources(document).filter(|_| !notes.is_empty()) else { return };
    for (pointer, note) in notes {
        let above = sources.iter().filter(|(above, _)| is_at_or_below(&pointer, above));
        let source = above.max_by_key(|(above, _)| above.len()).and_then(|(_, text)| text.as_str());
        let text = format!("{}; {note}", source.unwrap_or("case file"));
        sources.insert(pointer, Value::from(text));
    }
}

fn convert(pointer: &str, node: &'static Value, value: &mut Value, notes: &mut Vec<(String, String)>) {
    let Value::Object(map) = value else { return };
    for key in keys(node) {
        let Some(inside) = map.get_mut(key.name) else { continue };
        let place = format!("{pointer}/{}", key.name);
        let unit = split_unit(key.name).1.map(|unit| unit.0);
        let is_number = unit.is_some() || key.node["type"] == "number" || key.node["items"]["type"] == "number";
        let mut read = |value: &mut Value| {
            let text = value.as_str().filter(|_| is_number)?.trim().to_owned();
            let (number, factor) = converted(&text, unit)?;
            *value = json!(number);
            let note = || format!("{text}, 1 {} = {}", split(&text).map_or("", |(_, sign)| sign), rounded(factor));
            Some(if factor == 1.0 { text.clone() } else { format!("{} {}", note(), unit.unwrap_or_default()) })
        };
        let found: Vec<String> = match inside {
            Value::Array(items) => items.iter_mut().filter_map(&mut read).collect(),
            _ => read(inside).into_iter().collect(),
        };
        if !found.is_empty() {
            notes.push((place.clone(), found.join("; ").trim_end().to_owned()));
        }
        match inside {
            Value::Array(items) => {
                let items = items.iter_mut().enumerate();
                items.for_each(|(index, item)| convert(&format!("{place}/{index}"), key.node, item, notes));
            }
            inside => convert(&place, key.node, inside, notes),
        }
    }
}

/// A factor to ten digits: exact ones in full, others without the dust of division.
fn rounded(factor: f64) -> String {
    number_text(format!("{factor:.9e}").parse().unwrap_or(factor))
}

/// Adds to a published schema that a number may be a text with a unit.
pub(in crate::case) fn publish(number: &mut Map<String, Value>) {
    if number.get("type") == Some(&json!("number")) {
        number.insert("type".to_owned(), json!(["number", "string"]));
        number.insert("pattern".to_owned(), json!(r"^\s*[-+]?[0-9.]+([eE][-+]?[0-9]+)?\s*[^0-9\s].*$"));
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    /// Every unit against another way to the same number, in the unit of the key.
    #[test]
    fn values_with_units_are_what_they_say() {
        for (text, sign, expected) in [
            ("8 in", "mm", 203.2),
            ("-2ft", "mm", -609.6),
            ("9 mil", "mm", 0.2286),
            ("510 ft/s", "m/s", 155.448),
            ("100 mph", "m/s", 44.704),
            ("360 km/h", "m/s", 100.0),
            ("7000 grains", "g", 453.59237),
            ("16 oz", "g", 453.59237),
            ("9 oz/yd²", "g/m²", 9.0 * 28.349523125 / 0.9144 / 0.9144),
            ("1 lb/ft^2", "g/m²", 453.59237 / 0.3048 / 0.3048),
            ("1 lb/in3", "kg/m³", 0.45359237 / 0.0254 / 0.0254 / 0.0254),
            ("1.44 g/cc", "kg/m³", 1440.0),
            ("110 tex", "denier", 990.0),
            ("1 Yarns per inch", "1/cm", 1.0 / 2.54),
            ("105 ends per 10 cm", "1/cm", 10.5),
            ("1e3 ksi", "MPa", 0.45359237 * 9.80665 / 0.0254 / 0.0254),
            ("12 Msi", "GPa", 12e-3 * 0.45359237 * 9.80665 / 0.0254 / 0.0254),
            ("1 g/den", "cN/tex", 0.980665 * 9.0),
            ("2 N/tex", "cN/tex", 200.0),
            ("90°", "deg", 90.0),
            ("2 ms", "µs", 2000.0),
        ] {
            let (number, _) = converted(text, Some(sign)).unwrap();
            assert!((number / expected - 1.0).abs() < 2e-15, "{text}: {number} for {expected} {sign}");
        }
        assert_eq!(converted("3.6 %", None).unwrap().0, 3.6 / 100.0);
        for (text, sign) in
            [("8", "mm"), ("8 s", "mm"), ("in 8", "mm"), ("inf mm", "mm"), ("8 mm", "g·mm²"), ("", "mm")]
        {
            assert_eq!(converted(text, Some(sign)), None, "{text} {sign}");
        }
        // Every unit of a key stands in a quantity, or has no other.
        let alone: Vec<&str> =
            UNITS.iter().map(|(_, unit)| unit.0).filter(|sign| quantity(Some(sign)).is_empty()).collect();
        assert_eq!(alone, ["mm·N^(1/3)", "rad/s", "g·mm²", "N/m"]);
    }
}
