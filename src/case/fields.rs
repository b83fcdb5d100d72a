//! What a key of the case file is: the one description that reader, schema and report share.

use std::fmt;

use serde_json::{Number, Value};

use super::value::number_text;

/// One key of one object of the case file.
#[derive(Clone, Copy, Debug)]
pub(super) struct CaseKey {
    pub name: &'static str,
    /// One sentence for the schema.
    pub doc: &'static str,
    pub kind: KeyType,
    pub presence: Presence,
    /// The key belongs only where another key of the same object has one of these values.
    pub only: Option<AppliesIf>,
    /// Exactly one key of a group is given; empty: not in a group.
    pub group: &'static str,
    /// Another key that must be given with this one; empty: none.
    pub with: &'static str,
    /// A key that may be given in place of this one; empty: none.
    pub instead: &'static str,
    /// What to say to a value out of range.
    pub help: &'static str,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum KeyType {
    Text,
    Flag,
    Number(Unit, NumberRange),
    /// A whole number, bounds included.
    Whole(u32, u32),
    /// A list of numbers and its shortest and longest length.
    Numbers(Unit, NumberRange, [usize; 2]),
    Word(&'static [&'static str]),
    Object(&'static [CaseKey]),
    WordOrObject(&'static [&'static str], &'static [CaseKey]),
    /// The keys themselves, or `{"file": …}` naming a file with them.
    ObjectOrFile(&'static [CaseKey]),
    /// A list of objects and its shortest and longest length.
    Items(&'static [CaseKey], [usize; 2]),
    NumberOrText(NumberRange),
    /// A number, or a percentage as text.
    NumberOrPercent(NumberRange),
    /// JSON pointers to texts.
    Sources,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Presence {
    Required,
    /// The value used when the key is not given, and where that value comes from.
    Default(Literal, &'static str),
    /// Computed from other keys when not given: how.
    Derived(&'static str),
    /// May be left out: what that means (empty: nothing worth a line in the report).
    Optional(&'static str),
    /// Required, except where another key is that word; then this default and its source.
    RequiredUnless(&'static str, &'static str, Literal, &'static str),
}

#[derive(Clone, Copy, Debug)]
pub(super) struct AppliesIf {
    pub key: &'static str,
    pub values: &'static [&'static str],
}

/// A default value.
#[derive(Clone, Copy, Debug)]
pub(super) enum Literal {
    Number(f64),
    Word(&'static str),
    Flag(bool),
    Numbers(&'static [f64]),
}

impl Literal {
    pub(super) fn value(self) -> Value {
        match self {
            Self::Number(number) => json_number(number),
            Self::Word(word) => Value::from(word),
            Self::Flag(flag) => Value::from(flag),
            Self::Numbers(numbers) => numbers.iter().map(|number| json_number(*number)).collect(),
        }
    }
}

/// A number as people write it: 0 and 155, not 0.0 and 155.0.
pub(super) fn json_number(number: f64) -> Value {
    if number.fract() == 0.0 && number.abs() < 1e15 {
        Value::from(number as i64)
    } else {
        Number::from_f64(number).map_or(Value::Null, Value::Number)
    }
}

/// A unit of the case file: SI = value · numerator / denominator, so that decimal factors round once.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unit {
    pub name: &'static str,
    numerator: f64,
    denominator: f64,
}

impl Unit {
    pub(super) const fn new(name: &'static str, numerator: f64, denominator: f64) -> Self {
        Self { name, numerator, denominator }
    }

    pub(super) fn to_si(self, value: f64) -> f64 {
        value * self.numerator / self.denominator
    }

    pub(super) fn of_si(self, value: f64) -> f64 {
        value * self.denominator / self.numerator
    }
}

/// The values a number may have.
#[derive(Clone, Copy, Debug)]
pub(super) struct NumberRange {
    pub min: f64,
    pub max: f64,
    /// Whether `min` itself is allowed.
    pub min_included: bool,
}

/// min ≤ value ≤ max
pub(super) const fn within(min: f64, max: f64) -> NumberRange {
    NumberRange { min, max, min_included: true }
}

/// min < value ≤ max
pub(super) const fn above(min: f64, max: f64) -> NumberRange {
    NumberRange { min, max, min_included: false }
}

impl NumberRange {
    pub(super) fn contains(self, value: f64) -> bool {
        value <= self.max && if self.min_included { value >= self.min } else { value > self.min }
    }
}

impl fmt::Display for NumberRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bracket = if self.min_included { '[' } else { '(' };
        write!(f, "{bracket}{}, {}]", number_text(self.min), number_text(self.max))
    }
}

/// A key that must be given; the other properties are added by the methods below.
pub(super) const fn key(name: &'static str, kind: KeyType, doc: &'static str) -> CaseKey {
    let presence = Presence::Required;
    CaseKey { name, doc, kind, presence, only: None, group: "", with: "", instead: "", help: "" }
}

pub(super) const fn number(name: &'static str, unit: Unit, range: NumberRange, doc: &'static str) -> CaseKey {
    key(name, KeyType::Number(unit, range), doc)
}

pub(super) const fn word(name: &'static str, words: &'static [&'static str], doc: &'static str) -> CaseKey {
    key(name, KeyType::Word(words), doc)
}

impl CaseKey {
    pub(super) const fn default(mut self, value: f64, source: &'static str) -> Self {
        self.presence = Presence::Default(Literal::Number(value), source);
        self
    }

    pub(super) const fn default_word(mut self, word: &'static str, source: &'static str) -> Self {
        self.presence = Presence::Default(Literal::Word(word), source);
        self
    }

    pub(super) const fn default_list(mut self, list: &'static [f64], source: &'static str) -> Self {
        self.presence = Presence::Default(Literal::Numbers(list), source);
        self
    }

    pub(super) const fn default_false(mut self, source: &'static str) -> Self {
        self.presence = Presence::Default(Literal::Flag(false), source);
        self
    }

    pub(super) const fn derived(mut self, how: &'static str) -> Self {
        self.presence = Presence::Derived(how);
        self
    }

    pub(super) const fn optional(mut self, without: &'static str) -> Self {
        self.presence = Presence::Optional(without);
        self
    }

    pub(super) const fn required_unless(
        mut self,
        (key, word): (&'static str, &'static str),
        value: f64,
        source: &'static str,
    ) -> Self {
        self.presence = Presence::RequiredUnless(key, word, Literal::Number(value), source);
        self
    }

    pub(super) const fn only(mut self, key: &'static str, values: &'static [&'static str]) -> Self {
        self.only = Some(AppliesIf { key, values });
        self
    }

    pub(super) const fn one_of(mut self, group: &'static str) -> Self {
        self.group = group;
        self
    }

    pub(super) const fn with(mut self, key: &'static str) -> Self {
        self.with = key;
        self
    }

    pub(super) const fn or(mut self, key: &'static str) -> Self {
        self.instead = key;
        self
    }

    pub(super) const fn help(mut self, help: &'static str) -> Self {
        self.help = help;
        self
    }

    /// The unit of the value, empty where it has none.
    pub(super) fn unit(&self) -> &'static str {
        match self.kind {
            KeyType::Number(unit, _) | KeyType::Numbers(unit, ..) => unit.name,
            _ => "",
        }
    }

    /// How the value is computed where it is left out, empty where it is not.
    pub(super) fn derivation(&self) -> &'static str {
        if let Presence::Derived(how) = self.presence { how } else { "" }
    }

    /// Whether null says that there is no such object.
    pub(super) fn is_nullable(&self) -> bool {
        matches!((self.kind, self.presence), (KeyType::Object(_), Presence::Optional(without)) if !without.is_empty())
    }

    /// The keys below this one.
    pub(super) fn keys(&self) -> &'static [Self] {
        match self.kind {
            KeyType::Object(keys)
            | KeyType::WordOrObject(_, keys)
            | KeyType::ObjectOrFile(keys)
            | KeyType::Items(keys, _) => keys,
            _ => &[],
        }
    }
}
