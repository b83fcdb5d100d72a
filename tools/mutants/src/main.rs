//! Mutation test of ripstop's kernels.
//!
//! A mutant is the program with one place of its source changed. A test kills it by failing. What no test kills shows what the tests
//! do not see.
//!
//! Compiling the program for every mutant would take days. Here many mutants are compiled at once, into a copy of the source, each
//! behind a switch of its own; a run of the tests turns one of them on. Only tests that reach a mutant are run, quick ones first, until
//! one fails.

mod build;
mod find;
mod mutant;
mod operators;
mod report;
mod rewrite;
mod tests;

use std::collections::HashMap;
use std::error::Error;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Instant;

use clap::Parser;

use mutant::Mutant;
use tests::{Fate, in_parallel, lock};

/// The source that is mutated: kernels, contact, failure, outcome, energy. Directories stand for all files in them.
const FILES: [&str; 13] = [
    "src/kernels",
    "src/solver/failure.rs",
    "src/solver/projectile.rs",
    "src/solver/sweep.rs",
    "src/solver/plies",
    "src/run/outcome.rs",
    "src/solver/energy_balance.rs",
    "src/run/pieces.rs",
    "src/run/deflection.rs",
    "src/model/time_step.rs",
    "src/model/failure_length.rs",
    "src/model/pretension.rs",
    "src/model/ply_type.rs",
];

/// Tests that look at files and words rather than at numbers, by the start of their names.
const SKIP: [&str; 14] = [
    "cli::",
    "docs::",
    "report::",
    "frames::",
    "checkpoint::",
    "objectivity::",
    "case_files::",
    "shaders::",
    "case::",
    "examples::",
    "output::",
    "rooms::",
    "run::checkpoint::",
    "study::",
];

/// Mutation test of ripstop's kernels
#[derive(Parser)]
struct Arguments {
    /// Share of the mutants of every file that is tried, drawn at random
    #[arg(long, default_value_t = 1.0)]
    share: f64,
    /// Seed of the draw
    #[arg(long, default_value_t = 22)]
    seed: u64,
    /// Only mutants whose name has this in it
    #[arg(long)]
    only: Vec<String>,
    /// Takes mutants as killed that are so in the list of killed mutants, `target/mutants/killed`, which every run goes on with
    #[arg(long)]
    again: bool,
    /// Test binaries with the mutants, compiled before; none: they are compiled
    #[arg(long)]
    binary: Vec<PathBuf>,
    /// Tests that compute for longer are left out [s]
    #[arg(long, default_value_t = 2.0)]
    slow: f64,
    /// What the tests of a mutant may compute for together [s]
    #[arg(long, default_value_t = 15.0)]
    allowed: f64,
    /// No mutant is begun after so long [min]; those tried so far are a draw like any other
    #[arg(long, default_value_t = f64::INFINITY)]
    minutes: f64,
    /// Tests at a time
    #[arg(long, default_value_t = 2)]
    jobs: usize,
    /// Lists the mutants and ends
    #[arg(long)]
    list: bool,
    /// Arguments for cargo
    #[arg(last = true)]
    cargo: Vec<String>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let root = tests::root();
    let (drawn, places, all) = draw(&root, &arguments)?;
    eprintln!("{} of {all} mutants", drawn.len());
    if arguments.list {
        drawn.iter().for_each(|mutant| println!("{} [{}]", mutant.name(), mutant.operator));
        return Ok(());
    }
    let cargo =
        if arguments.cargo.is_empty() { vec!["--features=quick-build".to_owned()] } else { arguments.cargo.clone() };
    let built = if arguments.binary.is_empty() {
        build::build(&root, &drawn, &cargo)?
    } else {
        build::built(&root, &arguments.binary)?
    };
    let skip = SKIP.map(str::to_owned);
    let tests = tests::survey(&built, &skip, arguments.slow, arguments.jobs)?;
    let seconds: f64 = tests.iter().map(|test| test.seconds).sum();
    eprintln!("{} tests, {seconds:.0} s", tests.len());
    let killed = root.join("target/mutants/killed");
    let known = if arguments.again { std::fs::read_to_string(&killed)? } else { String::new() };
    let known: HashMap<&str, &str> = known.lines().filter_map(|line| line.split_once('\t')).collect();
    let log = Mutex::new(
        File::options().create(true).append(arguments.again).write(true).truncate(!arguments.again).open(&killed)?,
    );
    let mut numbers: Vec<usize> = (0..drawn.len()).filter(|number| !built.broken.contains(number)).collect();
    numbers.sort_by(|a, b| places[*a].total_cmp(&places[*b]));
    let fates: Mutex<Vec<(usize, Fate)>> = Mutex::new(Vec::new());
    let started = Instant::now();
    in_parallel(arguments.jobs, numbers.len(), |at| {
        let name = drawn[numbers[at]].name();
        let fate = match known.get(name.as_str()) {
            Some(test) => Fate::Killed((*test).to_owned()),
            None if started.elapsed().as_secs_f64() > 60.0 * arguments.minutes => return,
            None => tests::fate(&built, &tests, numbers[at], arguments.allowed),
        };
        eprintln!("{}/{} {name} {fate:?}", at + 1, numbers.len());
        if let (Fate::Killed(test), false) = (&fate, known.contains_key(name.as_str())) {
            let _ = writeln!(lock(&log), "{name}\t{test}");
        }
        lock(&fates).push((numbers[at], fate));
    });
    let mut fates = fates.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
    fates.sort_by_key(|(number, _)| *number);
    let fates: Vec<(&Mutant, Fate)> = fates.into_iter().map(|(number, fate)| (&drawn[number], fate)).collect();
    let reasons = reasons(&root)?;
    let report = report::report(&fates, all, |mutant| reasons.get(&mutant.name()).cloned());
    std::fs::write(root.join("target/mutants/report.md"), &report)?;
    println!("{report}");
    Ok(())
}

/// The mutants that may be tried; the place of each in the order drawn for its file, over the number of mutants there; and how many
/// mutants there are.
fn draw(root: &Path, arguments: &Arguments) -> Result<(Vec<Mutant>, Vec<f64>, usize), Box<dyn Error>> {
    let mut files = Vec::new();
    for name in FILES {
        sources(root, &root.join(name), &mut files)?;
    }
    files.sort();
    files.dedup();
    let (mut drawn, mut places, mut all) = (Vec::new(), Vec::new(), 0);
    for file in files {
        let of_file = find::mutants(&file, &std::fs::read_to_string(root.join(&file))?)?;
        all += of_file.len();
        let mut ranks: Vec<u64> = of_file.iter().map(|mutant| mutant.rank(arguments.seed)).collect();
        ranks.sort_unstable();
        let count = ranks.len() as f64;
        for mutant in of_file {
            let at = ranks.partition_point(|rank| *rank < mutant.rank(arguments.seed)) as f64;
            let name = mutant.name();
            let named = arguments.only.is_empty() || arguments.only.iter().any(|part| name.contains(part));
            if named && at < arguments.share * count {
                drawn.push(mutant);
                places.push(at / count);
            }
        }
    }
    Ok((drawn, places, all))
}

/// Source files below a path, from the root of the repository.
fn sources(root: &Path, path: &Path, out: &mut Vec<String>) -> Result<(), Box<dyn Error>> {
    if path.is_dir() {
        for entry in std::fs::read_dir(path)? {
            sources(root, &entry?.path(), out)?;
        }
    } else {
        let name: PathBuf = path.strip_prefix(root)?.to_owned();
        let name = name.to_string_lossy().replace('\\', "/");
        if name.ends_with(".rs") && !name.ends_with("_tests.rs") {
            out.push(name);
        }
    }
    Ok(())
}

/// What defends a mutant, by its name: `tests/mutants.md` has a heading for every reason, and below it the mutants.
fn reasons(root: &Path) -> Result<HashMap<String, String>, Box<dyn Error>> {
    let path = root.join("tests/mutants.md");
    let text = if path.exists() { std::fs::read_to_string(path)? } else { String::new() };
    let (mut out, mut reason) = (HashMap::new(), String::new());
    for line in text.lines() {
        if let Some(heading) = line.strip_prefix("## ") {
            reason = heading.to_owned();
        } else if let Some(name) = line.strip_prefix("- ") {
            out.insert(name.to_owned(), reason.clone());
        }
    }
    Ok(out)
}
