//! Units: that of a key, which is the end of its name, and others that a value may bring with it: `"8 in"` for `width_mm`.

use std::f64::consts::PI;

use serde_json::{Value, json};

use super::changes;
use super::error::number_text;
use super::keys::{CASE, keys};
use super::provenance::source;

/// A unit: the end of the names of keys that have it (empty: none has), its sign and other spellings, and SI = value · numerator / denominator,
/// so that decimal factors round once.
pub(super) struct Unit(&'static str, &'static str, f64, f64);

/// Weight of a gram on a yarn of one denier [N·m/kg]: 9.80665e-3 N times 9e6 m/kg.
const GRAM_PER_DENIER: [f64; 2] = [8_825_985.0, 100.0];
/// Pound-force [1e-13 N].
const POUND_FORCE: f64 = 44_482_216_152_605.0;

/// Units of one quantity each. Of several whose end a key has, the first is meant.
const QUANTITIES: [&[Unit]; 17] = [
    &[Unit("", "%", 1.0, 100.0)],
    &[
        Unit("_mm", "mm", 1.0, 1e3),
        Unit("", "cm", 1.0, 1e2),
        Unit("", "m", 1.0, 1.0),
        Unit("", "um", 1.0, 1e6),
        Unit("", "in inch inches", 254.0, 1e4),
        Unit("", "ft foot feet", 3048.0, 1e4),
        Unit("", "mil mils", 254.0, 1e7),
    ],
    &[Unit("_mm_n13", "mm·N^(1/3)", 1.0, 1e3)],
    &[
        Unit("_m_s", "m/s", 1.0, 1.0),
        Unit("", "km/s", 1e3, 1.0),
        Unit("", "km/h", 1e3, 3600.0),
        Unit("", "ft/s fps ft/sec", 3048.0, 1e4),
        Unit("", "mph", 44_704.0, 1e5),
    ],
    &[Unit("_rad_s", "rad/s", 1.0, 1.0)],
    &[
        Unit("_g", "g", 1.0, 1e3),
        Unit("", "kg", 1.0, 1.0),
        Unit("", "mg", 1.0, 1e6),
        Unit("", "gr grain grains", 6_479_891.0, 1e11),
        Unit("", "oz", 28_349_523_125.0, 1e12),
        Unit("", "lb lbs", 45_359_237.0, 1e8),
    ],
    &[Unit("_g_mm2", "g·mm²", 1.0, 1e9)],
    &[
        Unit("_g_m2", "g/m² gsm", 1.0, 1e3),
        Unit("", "kg/m2", 1.0, 1.0),
        Unit("", "oz/yd2", 28_349_523_125.0, 836_127_360_000.0),
        Unit("", "lb/ft2 psf", 45_359_237.0, 9_290_304.0),
    ],
    &[
        Unit("_kg_m3", "kg/m³", 1.0, 1.0),
        Unit("", "g/cm3 g/cc", 1e3, 1.0),
        Unit("", "lb/in3", 45_359_237e4, 16_387_064.0),
    ],
    &[
        Unit("_g_den", "g/den gf/den gpd", GRAM_PER_DENIER[0], GRAM_PER_DENIER[1]),
        Unit("_cn_tex", "cN/tex", 1e4, 1.0),
        Unit("", "cn/dtex", 1e5, 1.0),
        Unit("", "mn/tex", 1e3, 1.0),
        Unit("", "n/tex", 1e6, 1.0),
    ],
    &[Unit("_denier", "denier den", 1.0, 9e6), Unit("_tex", "tex", 1.0, 1e6), Unit("_dtex", "dtex", 1.0, 1e7)],
    &[
        Unit("_per_inch", "1/inch /in", 1e4, 254.0),
        Unit("_per_cm", "1/cm", 100.0, 1.0),
        Unit("", "/10cm", 10.0, 1.0),
        Unit("", "/m", 1.0, 1.0),
    ],
    &[Unit("_per_s", "1/s", 1.0, 1.0)],
    &[
        Unit("_gpa", "GPa", 1e9, 1.0),
        Unit("_mpa", "MPa n/mm2", 1e6, 1.0),
        Unit("", "psi", POUND_FORCE, 6_451_600_000.0),
        Unit("", "ksi", POUND_FORCE, 6_451_600.0),
        Unit("", "msi", 10.0 * POUND_FORCE, 64_516.0),
    ],
    &[Unit("_n_per_m", "N/m", 1.0, 1.0)],
    &[Unit("_us", "µs", 1.0, 1e6), Unit("", "ms", 1.0, 1e3), Unit("", "s", 1.0, 1.0)],
    &[Unit("_deg", "deg °", PI, 180.0), Unit("", "rad", 1.0, 1.0)],
];

/// A key's name without its unit, and the unit.
pub(super) fn split_unit(key: &str) -> (&str, Option<&'static Unit>) {
    let mut of_keys = QUANTITIES.into_iter().flatten().filter(|Unit(end, ..)| !end.is_empty());
    of_keys.find_map(|unit| Some((key.strip_suffix(unit.0)?, Some(unit)))).unwrap_or((key, None))
}

/// A key or a column in words, with its unit in brackets.
pub(crate) fn in_words(name: &str) -> String {
    let (name, unit) = match (split_unit(name), name.strip_suffix("_j")) {
        (_, Some(name)) => (name, "J"),
        ((name, unit), _) => (name, unit.map_or("-", Unit::sign)),
    };
    format!("{} [{unit}]", name.replace('_', " "))
}

impl Unit {
    pub(super) fn sign(&self) -> &'static str {
        self.1.split(' ').next().unwrap_or_default()
    }

    pub(super) fn to_si(&self, value: f64) -> f64 {
        value * self.2 / self.3
    }

    pub(super) fn of_si(&self, si: f64) -> f64 {
        si * self.3 / self.2
    }

    /// Turns a number of a document into SI units.
    pub(super) fn convert(&self, value: &mut Value) {
        if let Some(number) = value.as_f64() {
            *value = json!(self.to_si(number));
        }
    }
}

/// A sign in the form in which signs are compared: `Yarns per inch` and `1/inch` are one.
fn plain(sign: &str) -> String {
    let mut text = sign.to_lowercase().replace("^2", "2").replace("^3", "3").replace("per", "/");
    text.retain(|c| !c.is_whitespace() && c != '·');
    let text = text.replace('²', "2").replace('³', "3").replace(['µ', 'μ'], "u");
    let words = ["yarns", "ends", "picks", "threads", "1"];
    let rest = words.iter().find_map(|word| text.strip_prefix(word).filter(|rest| rest.starts_with('/')));
    rest.unwrap_or(&text).to_owned()
}

/// The units that may stand in place of one, its own among them; of a number without a unit, per cent.
fn quantity(sign: Option<&str>) -> &'static [Unit] {
    QUANTITIES.into_iter().find(|units| spelled(units, sign.unwrap_or("%")).is_some()).unwrap_or(&[])
}

fn spelled<'a>(units: &'a [Unit], sign: &str) -> Option<&'a Unit> {
    let sign = plain(sign);
    units.iter().find(|Unit(_, names, ..)| names.split(' ').any(|name| plain(name) == sign))
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
    let Unit(.., up, down) = spelled(units, sign)?;
    let [own_up, own_down] = unit.and_then(|own| spelled(units, own)).map_or([1.0; 2], |own| [own.2, own.3]);
    let factor = up * own_down / (down * own_up);
    Some((number * factor, factor))
}

/// A text with a unit as the value of a key, by the key's name: a number where the unit is the key's own, else the text; `None` where the
/// unit is of another quantity.
pub fn value_in(key: &str, text: &str) -> Option<Value> {
    let (number, factor) = converted(text, split_unit(key).1.map(Unit::sign))?;
    Some(if factor == 1.0 { json!(number) } else { json!(text.trim()) })
}

/// Signs of the units that a value of a key with this one may have, for messages.
pub(super) fn others(unit: Option<&str>) -> Vec<String> {
    quantity(unit).iter().map(|unit| plain(unit.sign())).collect()
}

/// Whether a text is a number with something behind it.
pub(super) fn has_number(text: &str) -> bool {
    split(text).is_some_and(|(_, sign)| !sign.is_empty())
}

/// Puts the words of the case file in place of others for them, and numbers in the units of their keys in place of texts with units, the
/// factor of each into the document's sources.
pub(super) fn without_units(document: &mut Value) {
    let mut notes = Vec::new();
    convert("", &CASE, None, document, &mut notes);
    let Some(sources) = changes::sources(document).filter(|_| !notes.is_empty()) else { return };
    for (pointer, note) in notes {
        let text = format!("{}; {note}", source(sources, &pointer).unwrap_or("case file"));
        sources.insert(pointer, Value::from(text));
    }
}

/// Conversion of a value whose key has this unit; `notes`: pointers of keys, and what stood there.
fn convert(
    place: &str,
    node: &'static Value,
    unit: Option<&str>,
    value: &mut Value,
    notes: &mut Vec<(String, String)>,
) {
    match value {
        Value::Object(map) => {
            for key in keys(node) {
                let (place, unit) = (format!("{place}/{}", key.name), split_unit(key.name).1.map(Unit::sign));
                map.get_mut(key.name).into_iter().for_each(|inside| convert(&place, key.node, unit, inside, notes));
            }
        }
        Value::Array(items) => {
            for (index, item) in items.iter_mut().enumerate() {
                let place = if item.is_object() { &format!("{place}/{index}") } else { place };
                convert(place, &node["items"], unit, item, notes);
            }
        }
        Value::String(word) if node["aliases"].get(&**word).is_some() => *value = node["aliases"][&**word].clone(),
        Value::String(text) if unit.is_some() || node["type"] == "number" => {
            let text = text.trim();
            let (Some((number, factor)), Some((_, sign))) = (converted(text, unit), split(text)) else { return };
            let note = match factor {
                1.0 => text.to_owned(),
                _ => {
                    format!("{text}, 1 {sign} = {} {}", rounded(factor), unit.unwrap_or_default()).trim_end().to_owned()
                }
            };
            match notes.last_mut().filter(|(last, _)| last == place) {
                Some((_, all)) => *all += &format!("; {note}"),
                None => notes.push((place.to_owned(), note)),
            }
            *value = json!(number);
        }
        _ => {}
    }
}

/// A factor to ten digits: exact ones in full, others without the dust of division.
fn rounded(factor: f64) -> String {
    number_text(format!("{factor:.9e}").parse().unwrap_or(factor))
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
    }
}
