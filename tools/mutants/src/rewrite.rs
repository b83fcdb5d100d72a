//! Rewrites a file so that it holds many mutants, of which a variable of the environment wakes one.

use std::ops::Range;

use crate::mutant::{Edit, Mutant};

/// A rewritten file, and where in it each mutant stands.
pub struct Rewritten {
    /// Source.
    pub text: String,
    /// Where the mutants stand.
    pub places: Vec<Place>,
}

/// Where a mutant stands in a rewritten file.
pub struct Place {
    /// Number of the mutant.
    pub mutant: usize,
    /// What is written for it alone [bytes].
    pub own: Range<usize>,
    /// That and the expression it may stand for [bytes].
    pub all: Range<usize>,
}

/// A piece of text that goes into the source.
struct Insertion {
    /// Byte of the source before which it goes.
    at: usize,
    /// Ends go before starts; of ends the inner ones first, of starts the outer ones.
    order: (u8, isize, isize),
    text: String,
    mutant: usize,
    /// The mutant's own part of the text; `None` at the end of what it stands for.
    own: Option<Range<usize>>,
}

/// `mutants`: of this file, in the order of the source, with their numbers.
pub fn rewrite(source: &str, mutants: &[(usize, &Mutant)]) -> Rewritten {
    let mut insertions = Vec::new();
    for (visit, (mutant, Mutant { edit, .. })) in mutants.iter().enumerate() {
        let (visit, mutant) = (visit as isize, *mutant);
        let mut around = |range: &Range<usize>, open: String, own: Range<usize>, close: &str| {
            let size = range.len() as isize;
            let start = Insertion { at: range.start, order: (1, -size, visit), text: open, mutant, own: Some(own) };
            let order = (0, size, -visit);
            let end = Insertion { at: range.end, order, text: close.to_owned(), mutant, own: None };
            insertions.extend([start, end]);
        };
        match edit {
            Edit::Instead { range, other } => {
                let head = format!("(if crate::mutant::on({mutant}) {{ ");
                let own = head.len()..head.len() + other.len();
                around(range, format!("{head}{other} }} else {{ "), own, " })");
            }
            Edit::LeaveOut(range) => {
                let open = format!("if !crate::mutant::on({mutant}) {{ ");
                let own = 0..open.len();
                around(range, open, own, " }");
            }
            Edit::GiveAtOnce { at, value } => {
                let text = format!(" if crate::mutant::on({mutant}) {{ return {value}; }}");
                let own = Some(0..text.len());
                insertions.push(Insertion { at: *at, order: (0, 0, visit), text, mutant, own });
            }
        }
    }
    insertions.sort_by_key(|insertion| (insertion.at, insertion.order));
    let mut out = Rewritten { text: String::new(), places: Vec::new() };
    let mut from = 0;
    for Insertion { at, text, mutant, own, .. } in insertions {
        out.text.push_str(&source[from..at]);
        let start = out.text.len();
        out.text.push_str(&text);
        let end = out.text.len();
        match own {
            Some(own) => {
                let own = start + own.start..start + own.end;
                out.places.push(Place { mutant, own, all: start..end });
            }
            None => out.places.iter_mut().filter(|place| place.mutant == mutant).for_each(|place| place.all.end = end),
        }
        from = at;
    }
    out.text.push_str(&source[from..]);
    out
}

/// The module that wakes a mutant: a byte for each, not yet known, asleep or awake. Code that asks pays a load and a branch.
pub fn switch(count: usize) -> String {
    format!(
        r#"//! Which mutant is awake.
use std::io::Write;
use std::sync::OnceLock;
use std::sync::atomic::{{AtomicU8, Ordering::Relaxed}};

static STATE: [AtomicU8; {count}] = [const {{ AtomicU8::new(2) }}; {count}];
static AWAKE: OnceLock<Option<usize>> = OnceLock::new();
static SEEN: OnceLock<Option<std::fs::File>> = OnceLock::new();

/// Whether this mutant is awake.
#[inline(always)]
pub fn on(mutant: usize) -> bool {{
    match STATE[mutant].load(Relaxed) {{
        0 => false,
        state => state == 1 || first(mutant),
    }}
}}

#[cold]
#[inline(never)]
fn first(mutant: usize) -> bool {{
    let awake = AWAKE.get_or_init(|| std::env::var("MUTANT").ok().and_then(|number| number.parse().ok()));
    let seen = SEEN.get_or_init(|| {{
        let path = std::env::var_os("MUTANTS_SEEN")?;
        std::fs::OpenOptions::new().create(true).append(true).open(path).ok()
    }});
    if let Some(mut file) = seen.as_ref() {{
        let _ = file.write_all(&(mutant as u32).to_le_bytes());
    }}
    let is = *awake == Some(mutant);
    STATE[mutant].store(u8::from(is), Relaxed);
    is
}}
"#
    )
}
