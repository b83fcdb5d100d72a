//! What became of the mutants: a table by file, and the survivors.

use std::collections::BTreeMap;
use std::fmt::Write;

use crate::mutant::Mutant;
use crate::tests::Fate;

/// Mutants of a file by what became of them.
#[derive(Default)]
struct Counts {
    mutants: usize,
    killed: usize,
    timed_out: usize,
    unreached: usize,
    defended: usize,
    survived: usize,
}

impl Counts {
    fn add(&mut self, fate: &Fate, defended: bool) {
        self.mutants += 1;
        match fate {
            Fate::Killed(_) => self.killed += 1,
            Fate::TimedOut => self.timed_out += 1,
            Fate::Survived | Fate::Unreached if defended => self.defended += 1,
            Fate::Survived => self.survived += 1,
            Fate::Unreached => self.unreached += 1,
        }
    }

    fn row(&self, name: &str) -> String {
        let Self { mutants, killed, timed_out, unreached, defended, survived } = self;
        let score = 100.0 * (killed + timed_out) as f64 / *mutants as f64;
        format!(
            "| {name} | {mutants} | {killed} | {timed_out} | {defended} | {survived} | {unreached} | {score:.1} |\n"
        )
    }
}

/// Bounds of a share of which `part` of `whole` were found, with 95 % confidence (Wilson).
fn interval(part: usize, whole: usize) -> [f64; 2] {
    let (n, p, z) = (whole as f64, part as f64 / whole as f64, 1.96);
    let (middle, half) = (p + z * z / (2.0 * n), z * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt());
    [(middle - half) / (1.0 + z * z / n), (middle + half) / (1.0 + z * z / n)]
}

/// The report, as Markdown. `reasons`: what defends a survivor.
pub fn report(fates: &[(&Mutant, Fate)], of: usize, reasons: impl Fn(&Mutant) -> Option<String>) -> String {
    let mut files: BTreeMap<&str, Counts> = BTreeMap::new();
    let mut sum = Counts::default();
    let mut rest = String::new();
    for (mutant, fate) in fates {
        let reason = reasons(mutant);
        files.entry(&mutant.file).or_default().add(fate, reason.is_some());
        sum.add(fate, reason.is_some());
        if matches!(fate, Fate::Survived | Fate::Unreached) {
            let why = reason.map_or_else(|| format!("{fate:?}"), |reason| format!("defended: {reason}"));
            let _ = writeln!(rest, "- {}  (line {}, {}; {why})", mutant.name(), mutant.line, mutant.operator);
        }
    }
    let caught = sum.killed + sum.timed_out;
    let [low, high] = interval(caught, sum.mutants).map(|bound| 100.0 * bound);
    let mut out = String::from("| file | mutants | killed | timed out | defended | survived | unreached | score % |\n");
    out += "|---|---|---|---|---|---|---|---|\n";
    files.iter().for_each(|(name, counts)| out += &counts.row(name));
    out += &sum.row("all");
    let score = 100.0 * caught as f64 / sum.mutants as f64;
    let but = 100.0 * caught as f64 / (sum.mutants - sum.defended) as f64;
    let _ = writeln!(
        out,
        "\n{} of {of} mutants. Score {score:.1} % ({low:.1} to {high:.1} %, 95 % confidence).",
        sum.mutants
    );
    let _ = writeln!(out, "Without those that are defended: {but:.1} %.\n\nNot killed:\n\n{rest}");
    out
}
