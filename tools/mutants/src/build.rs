//! A copy of the source tree with many mutants in it, compiled.

use std::collections::BTreeSet;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::mutant::Mutant;
use crate::rewrite::{Rewritten, rewrite, switch};

/// What of the tree the tests read.
const NEEDED: [&str; 12] = [
    "src",
    "tests",
    "benches",
    "cases",
    "shaders",
    "docs",
    "examples",
    "Cargo.toml",
    "Cargo.lock",
    "README.md",
    "CHANGELOG.md",
    ".ci",
];

/// Numbers of the mutants that do not compile, in the copy.
const BROKEN: &str = "broken";

/// The tests, compiled with the mutants.
pub struct Built {
    /// Root of the copy.
    pub tree: PathBuf,
    /// Test binaries.
    pub binaries: Vec<PathBuf>,
    /// Numbers of the mutants that do not compile.
    pub broken: BTreeSet<usize>,
}

/// Copies the tree, puts the mutants into it, leaves out those that do not compile, compiles the tests.
pub fn build(root: &Path, mutants: &[Mutant], arguments: &[String]) -> Result<Built, Box<dyn Error>> {
    let tree = root.join("target/mutants/tree");
    std::fs::create_dir_all(&tree)?;
    let mutated: BTreeSet<PathBuf> = mutants.iter().map(|mutant| tree.join(&mutant.file)).collect();
    let (lib, module) = (tree.join("src/lib.rs"), tree.join("src/mutant.rs"));
    for part in NEEDED {
        copy(&root.join(part), &tree.join(part), &|path| mutated.contains(path) || *path == lib || *path == module)?;
    }
    let text = std::fs::read_to_string(root.join("src/lib.rs"))?;
    put(&lib, (text + "\n#[allow(missing_docs)]\npub mod mutant;\n").as_bytes())?;
    put(&module, switch(mutants.len()).as_bytes())?;
    let mut broken = BTreeSet::new();
    loop {
        let files = write(root, &tree, mutants, &broken)?;
        let messages = cargo(&tree, root, &["check", "--profile", "release", "--lib"], arguments)?;
        let found = culprits(&messages, &files);
        if found.errors == 0 {
            break;
        }
        if found.mutants.is_empty() {
            return Err(format!("{} errors that no mutant explains: {}", found.errors, found.first).into());
        }
        eprintln!("{} mutants do not compile: {:?}", found.mutants.len(), found.mutants);
        broken.extend(found.mutants);
    }
    let list: Vec<String> = broken.iter().map(ToString::to_string).collect();
    std::fs::write(tree.join(BROKEN), list.join("\n"))?;
    eprintln!("compiling {} mutants", mutants.len() - broken.len());
    let messages = cargo(&tree, root, &["test", "--release", "--no-run", "--lib", "--test", "suite"], arguments)?;
    let binaries: Vec<PathBuf> = messages.iter().filter_map(|m| m["executable"].as_str()).map(PathBuf::from).collect();
    let binaries: Vec<_> =
        binaries.into_iter().filter(|path| path.parent().is_some_and(|p| p.ends_with("deps"))).collect();
    if binaries.len() != 2 {
        return Err(format!("expected two test binaries, found {binaries:?}").into());
    }
    Ok(Built { tree, binaries, broken })
}

/// What was compiled before: test binaries, and which mutants they lack.
pub fn built(root: &Path, binaries: &[PathBuf]) -> Result<Built, Box<dyn Error>> {
    let tree = root.join("target/mutants/tree");
    let list = std::fs::read_to_string(tree.join(BROKEN))?;
    let broken = list.lines().map(str::parse).collect::<Result<_, _>>()?;
    let binaries = binaries.iter().map(|path| path.canonicalize()).collect::<Result<_, _>>()?;
    Ok(Built { tree, binaries, broken })
}

/// Writes the files that hold mutants.
fn write(
    root: &Path,
    tree: &Path,
    mutants: &[Mutant],
    broken: &BTreeSet<usize>,
) -> Result<Vec<(String, Rewritten)>, Box<dyn Error>> {
    let files: BTreeSet<&String> = mutants.iter().map(|mutant| &mutant.file).collect();
    let mut out = Vec::new();
    for file in files {
        let of_file = mutants.iter().enumerate().filter(|(n, m)| m.file == *file && !broken.contains(n));
        let rewritten = rewrite(&std::fs::read_to_string(root.join(file))?, &of_file.collect::<Vec<_>>());
        put(&tree.join(file), rewritten.text.as_bytes())?;
        out.push((file.clone(), rewritten));
    }
    Ok(out)
}

/// Runs cargo in the copy; its messages.
fn cargo(tree: &Path, root: &Path, command: &[&str], arguments: &[String]) -> Result<Vec<Value>, Box<dyn Error>> {
    let output = Command::new("cargo")
        .current_dir(tree)
        // Not `target`: cargo takes what it finds there for the program itself.
        .env("CARGO_TARGET_DIR", root.join("target/mutants/build"))
        .args(command)
        .args(arguments)
        .args(["--message-format=json", "--quiet"])
        .stderr(Stdio::inherit())
        .output()?;
    let text = String::from_utf8(output.stdout)?;
    Ok(text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect())
}

struct Culprits {
    errors: usize,
    first: String,
    mutants: BTreeSet<usize>,
}

/// The mutants that the compiler's errors point at: by what is written for them alone, else by what
/// they may stand for, else by what holds them.
fn culprits(messages: &[Value], files: &[(String, Rewritten)]) -> Culprits {
    let mut found = Culprits { errors: 0, first: String::new(), mutants: BTreeSet::new() };
    for message in messages.iter().map(|message| &message["message"]).filter(|m| m["level"] == "error") {
        let mut spans = Vec::new();
        spans_of(message, &mut spans);
        if spans.is_empty() {
            continue; // "aborting due to …"
        }
        found.errors += 1;
        if found.first.is_empty() {
            found.first = message["rendered"].as_str().unwrap_or_default().to_owned();
        }
        let (mut own, mut around, mut inside) = (BTreeSet::new(), None, BTreeSet::new());
        for (file, start, end) in spans {
            let Some((_, rewritten)) = files.iter().find(|(name, _)| *name == file) else { continue };
            for place in &rewritten.places {
                let holds = |range: &std::ops::Range<usize>| range.start <= start && end <= range.end;
                if holds(&place.own) {
                    own.insert(place.mutant);
                } else if holds(&place.all) && around.is_none_or(|(size, _)| place.all.len() < size) {
                    around = Some((place.all.len(), place.mutant));
                } else if start <= place.all.start && place.all.end <= end {
                    inside.insert(place.mutant);
                }
            }
        }
        if own.is_empty() {
            own.extend(around.map(|(_, mutant)| mutant));
        }
        if own.is_empty() {
            own = inside;
        }
        found.mutants.extend(own);
    }
    found
}

/// File, start and end of all that a message points at, in macros too.
fn spans_of(message: &Value, out: &mut Vec<(String, usize, usize)>) {
    let spans = message["spans"].as_array().into_iter().flatten();
    for span in spans {
        let mut span = span;
        loop {
            let number = |key: &str| span[key].as_u64().unwrap_or(0) as usize;
            out.push((span["file_name"].as_str().unwrap_or("").to_owned(), number("byte_start"), number("byte_end")));
            if span["expansion"].is_null() {
                break;
            }
            span = &span["expansion"]["span"];
        }
    }
    for child in message["children"].as_array().into_iter().flatten() {
        spans_of(child, out);
    }
}

/// Makes `to` a copy of `from`, but for what `keep` says.
fn copy(from: &Path, to: &Path, keep: &impl Fn(&PathBuf) -> bool) -> Result<(), Box<dyn Error>> {
    if !from.is_dir() {
        return if keep(&to.to_owned()) { Ok(()) } else { put(to, &std::fs::read(from)?) };
    }
    std::fs::create_dir_all(to)?;
    for entry in std::fs::read_dir(to)? {
        let entry = entry?;
        if !from.join(entry.file_name()).exists() && !keep(&entry.path()) {
            if entry.path().is_dir() {
                std::fs::remove_dir_all(entry.path())?
            } else {
                std::fs::remove_file(entry.path())?
            }
        }
    }
    for entry in std::fs::read_dir(from)? {
        let name = entry?.file_name();
        copy(&from.join(&name), &to.join(&name), keep)?;
    }
    Ok(())
}

/// Writes a file if it has changed: by the times of files cargo tells what to compile.
fn put(path: &Path, bytes: &[u8]) -> Result<(), Box<dyn Error>> {
    if std::fs::read(path).ok().as_deref() != Some(bytes) {
        std::fs::write(path, bytes)?;
    }
    Ok(())
}
