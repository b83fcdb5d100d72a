//! The keys of the case file as pages of documentation show them, from the table that the reader uses.

use std::ptr;

use super::fields::{CaseKey, KeyType, Literal, NumberRange, Presence};
use super::table;
use super::value::number_text;
use super::words::aliases;
use crate::markdown;

/// Every key of the case file in Markdown: one table for each object, with the pointers where it stands.
pub fn reference() -> String {
    let mut objects = vec![(String::new(), table::CASE)];
    collect("", table::CASE, &mut objects);
    let mut seen: Vec<&[CaseKey]> = Vec::new();
    let mut out = String::new();
    for (_, keys) in &objects {
        if seen.iter().any(|other| ptr::eq(*other, *keys)) {
            continue;
        }
        seen.push(keys);
        let places = objects.iter().filter(|(_, other)| ptr::eq(*other, *keys));
        let places: Vec<String> = places.map(|(pointer, _)| format!("`{pointer}`")).collect();
        let title = if places == ["``"] { "The whole case".to_owned() } else { places.join(", ") };
        let rows = keys.iter().map(|key| vec![format!("`{}`", key.name), value(key), default(key), meaning(key)]);
        out += &format!("\n## {title}\n\n{}", markdown::table(&["key", "value", "if left out", "meaning"], rows));
    }
    out.trim_start().to_owned()
}

/// Every object below, with its pointer; `N` stands for the place in a list.
fn collect(prefix: &str, keys: &'static [CaseKey], objects: &mut Vec<(String, &'static [CaseKey])>) {
    for key in keys.iter().filter(|key| !key.keys().is_empty()) {
        let list = if matches!(key.kind, KeyType::Items(..)) { "/N" } else { "" };
        let pointer = format!("{prefix}/{}{list}", key.name);
        // A fabric inside a layup is described where the case's fabric is.
        let is_known = objects.iter().any(|(_, known)| ptr::eq(*known, key.keys()));
        objects.push((pointer.clone(), key.keys()));
        if !is_known {
            collect(&pointer, key.keys(), objects);
        }
    }
}

/// What may stand there.
fn value(key: &CaseKey) -> String {
    let unit = if key.unit().is_empty() { String::new() } else { format!(" [{}]", key.unit()) };
    match key.kind {
        KeyType::Text => "text".to_owned(),
        KeyType::Flag => "`true` or `false`".to_owned(),
        KeyType::Number(_, range) => format!("number{unit}, {}", span(range)),
        KeyType::Whole(min, max) => format!("whole number, {min} to {max}"),
        KeyType::Numbers(_, range, [min, max]) if min == max => format!("{min} numbers{unit}, {}", span(range)),
        KeyType::Numbers(_, range, [_, max]) => format!("up to {max} numbers{unit}, {}", span(range)),
        KeyType::Word(words) => all(words),
        KeyType::Object(_) => "object".to_owned(),
        KeyType::WordOrObject(words, _) => format!("{}, or an object", all(words)),
        KeyType::ObjectOrFile(_) => "object, or `{\"file\": …}`".to_owned(),
        KeyType::Items(_, [_, max]) => format!("list of up to {max} objects"),
        KeyType::NumberOrText(_) => "number or text".to_owned(),
        KeyType::NumberOrPercent(_) => "number, or text such as `\"1%\"`".to_owned(),
        KeyType::Sources => "object of texts".to_owned(),
    }
}

fn span(range: NumberRange) -> String {
    let [min, max] = [range.min, range.max].map(number_text);
    if range.min_included { format!("{min} to {max}") } else { format!("above {min}, to {max}") }
}

/// Words, and what else is read as one of them.
fn all(words: &[&'static str]) -> String {
    let quoted = words.iter().flat_map(|word| std::iter::once(*word).chain(aliases(word)));
    quoted.map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", ")
}

fn default(key: &CaseKey) -> String {
    match key.presence {
        Presence::Required if !key.group.is_empty() => "**one of the group**".to_owned(),
        Presence::Required => "**required**".to_owned(),
        Presence::Default(literal, source) => format!("{}: {source}", literal_text(literal)),
        Presence::Derived(how) => how.to_owned(),
        Presence::Optional("") => String::new(),
        Presence::Optional(without) => without.to_owned(),
        Presence::RequiredUnless(other, word, ..) => {
            let instead = if key.instead.is_empty() { String::new() } else { format!(", or `{}`", key.instead) };
            format!("**required**{instead}, unless `{other}` is `{word}`")
        }
    }
}

fn literal_text(literal: Literal) -> String {
    match literal {
        Literal::Word(word) => format!("`{word}`"),
        other => format!("`{}`", other.value()),
    }
}

fn meaning(key: &CaseKey) -> String {
    let mut text = key.doc.to_owned();
    if let Some(only) = key.only {
        text += &format!(" Only with `{}`: {}.", only.key, all(only.values));
    }
    if !key.group.is_empty() {
        text += &format!(" Exactly one gives the {}.", key.group);
    }
    if !key.with.is_empty() {
        text += &format!(" Only together with `{}`.", key.with);
    }
    text
}

#[cfg(test)]
#[path = "reference_tests.rs"]
mod tests;
