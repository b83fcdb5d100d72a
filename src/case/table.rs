//! Every key of the case file: name, unit, range, default with its source, and meaning.

use super::Along;
use super::fabric_keys::FABRIC;
use super::fields::{CaseKey, KeyType, key, number, within, word};
use super::pack_keys::PACK;
use super::pointer::index;
use super::projectile_keys::PROJECTILE;
use super::solver_keys::SOLVER;
use super::units::{NONE, US};
use super::variability_keys::VARIABILITY;
use super::words::Word;

pub(super) static CASE: &[CaseKey] = &[
    key(
        "$schema",
        KeyType::Text,
        "The JSON Schema of case files, for editors; ripstop writes one with `ripstop schema`.",
    )
    .optional(""),
    key("title", KeyType::Text, "What the case is, for people."),
    key(
        "fabric",
        KeyType::ObjectOrFile(FABRIC),
        "The fabric of every ply that pack.layup gives no other; a file is named relative to the case's folder.",
    ),
    key("pack", KeyType::Object(PACK), "Plies, size, edges and initial state."),
    key("projectile", KeyType::Object(PROJECTILE), "What strikes the pack; null or absent: nothing does.")
        .optional("nothing strikes the pack"),
    key(
        "variability",
        KeyType::Object(VARIABILITY),
        "What varies from shot to shot; nothing does in a case that names no shot.",
    )
    .optional(""),
    key("solver", KeyType::Object(SOLVER), "Time integration.").optional(""),
    key("output", KeyType::Object(OUTPUT), "What is written and how often.").optional(""),
    key("expect", KeyType::Items(EXPECT, [0, 1000]), "Statements about the result that the run checks.").optional(""),
    key(
        "sources",
        KeyType::Sources,
        "Where values come from: JSON pointer of a value or of an object around it, and text; \
        a text that begins with \"assumed\" marks its values as assumed.",
    )
    .optional(""),
    key("notes", KeyType::Text, "Remarks for people.").optional(""),
];

static OUTPUT: &[CaseKey] = &[
    number("history_interval_us", US, within(1e-6, 1e9), "Interval of history.csv, at most end_time_us.")
        .default(0.5, "a few hundred rows for a shot"),
    key("frames", KeyType::Whole(0, 10_000), "Frames for ParaView, evenly from impact to the end of the run.")
        .default(0.0, "none asked for"),
    key(
        "profile_times_us",
        KeyType::Numbers(US, within(0.0, 1e9), [0, 1000]),
        "Times of deflection profiles, ascending.",
    )
    .default_list(&[], "none asked for"),
    word("profile_along", Along::WORDS, "Direction of the profiles, through the point of impact.")
        .default_word("warp", "the first axis"),
];

static EXPECT: &[CaseKey] = &[
    key("quantity", KeyType::Text, "A name of summary.json, a column of history.csv, or a measured wave quantity."),
    key("value", KeyType::NumberOrText(within(-1e15, 1e15)), "The expected number or word.").optional(""),
    number("min", NONE, within(-1e15, 1e15), "Least value; instead of value.").optional(""),
    number("max", NONE, within(-1e15, 1e15), "Largest value; instead of value.").optional(""),
    key(
        "tolerance",
        KeyType::NumberOrPercent(within(0.0, 1e15)),
        "Allowed difference from a number, absolute or \"1%\".",
    )
    .optional(""),
    number("at_us", US, within(0.0, 1e9), "Time at which the quantity is read.").optional(""),
    key("between_us", KeyType::Numbers(US, within(0.0, 1e9), [2, 2]), "Interval of a measured speed or frequency.")
        .optional(""),
    key("source", KeyType::Text, "Where the statement comes from."),
    key("known_difference", KeyType::Text, "Why the statement is known not to hold: shown, and no failure.")
        .optional(""),
];

/// The key that a JSON pointer names, whether or not a document has it.
pub(super) fn lookup(pointer: &str) -> Option<&'static CaseKey> {
    let mut keys = CASE;
    let mut found: Option<&CaseKey> = None;
    // The keys of a list's items, where the next part is an index.
    let mut items: Option<&'static [CaseKey]> = None;
    for part in pointer.strip_prefix('/')?.split('/') {
        if let Some(of_item) = items.take()
            && index(part).is_some()
        {
            keys = of_item;
            continue;
        }
        let key = keys.iter().find(|key| key.name == part)?;
        (keys, items) = match key.kind {
            KeyType::Items(of_item, _) => (&[] as &[CaseKey], Some(of_item)),
            _ => (key.keys(), None),
        };
        found = Some(key);
    }
    found
}

/// Where a pointer stands in the order of this table: the place of each of its parts.
pub(super) fn order(pointer: &str) -> Vec<usize> {
    let mut keys = CASE;
    pointer
        .split('/')
        .skip(1)
        .map(|part| {
            let place = keys.iter().position(|key| key.name == part);
            keys = place.map_or(keys, |place| keys[place].keys());
            place.or_else(|| part.parse().ok()).unwrap_or(usize::MAX)
        })
        .collect()
}

/// Every pointer of the table; those below a list are left out.
pub(super) fn pointers() -> Vec<String> {
    let mut pointers = Vec::new();
    collect("", CASE, &mut pointers);
    pointers
}

fn collect(prefix: &str, keys: &[CaseKey], pointers: &mut Vec<String>) {
    for key in keys {
        let pointer = format!("{prefix}/{}", key.name);
        if !matches!(key.kind, KeyType::Items(..)) {
            collect(&pointer, key.keys(), pointers);
        }
        pointers.push(pointer);
    }
}

#[cfg(test)]
#[path = "table_tests.rs"]
mod tests;
