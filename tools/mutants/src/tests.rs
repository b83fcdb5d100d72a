//! The tests: what they reach, how long they take, and whether a mutant makes one fail.

use std::collections::BTreeSet;
use std::error::Error;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};
use std::time::{Duration, Instant};

use crate::build::Built;

/// A test that passes without a mutant.
pub struct Test {
    /// Its binary.
    pub binary: usize,
    /// Its name.
    pub name: String,
    /// How long it computes [s].
    pub seconds: f64,
    /// Numbers of the mutants it reaches.
    pub reaches: BTreeSet<usize>,
    /// Mutants it has killed: what has killed many is tried first.
    pub kills: AtomicUsize,
}

/// What became of a mutant.
#[derive(Clone, Debug, PartialEq)]
pub enum Fate {
    /// This test failed.
    Killed(String),
    /// The tests took far too long.
    TimedOut,
    /// Tests reach it, none fails.
    Survived,
    /// No test reaches it.
    Unreached,
}

/// Runs every test alone, without a mutant. Leaves out what is in `skip`, what computes for longer than `limit` [s], and what fails.
pub fn survey(built: &Built, skip: &[String], limit: f64, jobs: usize) -> Result<Vec<Test>, Box<dyn Error>> {
    let mut names = Vec::new();
    for (binary, path) in built.binaries.iter().enumerate() {
        let output = Command::new(path).current_dir(&built.tree).args(["--list", "--format=terse"]).output()?;
        for line in String::from_utf8(output.stdout)?.lines() {
            if let Some(name) = line.strip_suffix(": test")
                && !skip.iter().any(|skip| name.starts_with(skip.as_str()))
            {
                names.push((binary, name.to_owned()));
            }
        }
    }
    let tests = Mutex::new(Vec::new());
    in_parallel(jobs, names.len(), |at| {
        let (binary, name) = &names[at];
        let seen = built.tree.join(format!("seen-{at}"));
        let (failure, seconds) = attempt(built, *binary, &[name], &[("MUTANTS_SEEN", &seen.to_string_lossy())], limit);
        let bytes = std::fs::read(&seen).unwrap_or_default();
        let _ = std::fs::remove_file(&seen);
        match failure {
            Attempt::Passed => {}
            Attempt::TimedOut => return eprintln!("left out, slow: {name}"),
            Attempt::Failed(_) => return eprintln!("left out, fails without a mutant: {name}"),
        }
        let numbers = bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize);
        let test = Test {
            binary: *binary,
            name: name.clone(),
            seconds,
            reaches: numbers.collect(),
            kills: AtomicUsize::new(0),
        };
        lock(&tests).push(test);
    });
    Ok(tests.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner()))
}

/// Runs the tests that reach a mutant, those first that take little and have killed many, as many as take no longer than `allowed` [s].
pub fn fate(built: &Built, tests: &[Test], mutant: usize, allowed: f64) -> Fate {
    let mut reaching: Vec<&Test> = tests.iter().filter(|test| test.reaches.contains(&mutant)).collect();
    if reaching.is_empty() {
        return Fate::Unreached;
    }
    let cost = |test: &Test| (test.seconds + 0.02) / (1.0 + test.kills.load(Relaxed) as f64);
    reaching.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
    let number = mutant.to_string();
    let mut total = 0.0;
    reaching.retain(|test| {
        total += test.seconds;
        total <= allowed
    });
    let mut batch: Vec<&Test> = Vec::new();
    let mut budget = 0.2;
    let mut rest = reaching.into_iter().peekable();
    while let Some(test) = rest.next() {
        batch.push(test);
        let same = rest.peek().is_some_and(|next| next.binary == test.binary);
        let spent: f64 = batch.iter().map(|test| test.seconds).sum();
        if same && spent < budget {
            continue;
        }
        budget *= 1.5;
        let names: Vec<&String> = batch.iter().map(|test| &test.name).collect();
        match attempt(built, test.binary, &names, &[("MUTANT", &number)], 3.0 + 5.0 * spent).0 {
            Attempt::Passed => {}
            Attempt::TimedOut => return Fate::TimedOut,
            Attempt::Failed(name) => {
                if let Some(killer) = batch.iter().find(|test| test.name == name) {
                    killer.kills.fetch_add(1, Relaxed);
                }
                return Fate::Killed(name);
            }
        }
        batch.clear();
    }
    Fate::Survived
}

enum Attempt {
    Passed,
    Failed(String),
    TimedOut,
}

/// Runs tests of a binary one after the other until one fails, for so long [s] of computing at most; and how long they took.
fn attempt(built: &Built, binary: usize, names: &[&String], variables: &[(&str, &str)], limit: f64) -> (Attempt, f64) {
    let mut command = Command::new(&built.binaries[binary]);
    command.current_dir(&built.tree).arg("--exact").args(names).arg("--test-threads=1");
    command.envs(variables.iter().copied()).env("RAYON_NUM_THREADS", "2").env("VK_DRIVER_FILES", "/dev/null");
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null());
    let Ok(mut child) = command.spawn() else { return (Attempt::Failed("does not start".to_owned()), 0.0) };
    let Some(output) = child.stdout.take() else { return (Attempt::Failed("has no output".to_owned()), 0.0) };
    let started = Instant::now();
    let id = child.id();
    let child = Mutex::new(child);
    let (ended, late) = (AtomicBool::new(false), AtomicBool::new(false));
    let (mut failed, mut done, mut current) = (None, false, String::new());
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !ended.load(Relaxed) {
                let wall = started.elapsed().as_secs_f64();
                if computed(id).unwrap_or(wall) > limit || wall > 60.0 + 30.0 * limit {
                    late.store(true, Relaxed);
                    let _ = lock(&child).kill();
                    break;
                }
                std::thread::sleep(Duration::from_millis(10));
            }
        });
        for line in BufReader::new(output).lines().map_while(Result::ok) {
            done |= line.starts_with("test result: ok");
            if let Some(name) = line.strip_prefix("test ").and_then(|line| line.split(" ... ").next()) {
                current = name.trim_end_matches(" - should panic").to_owned();
                if line.ends_with("FAILED") {
                    failed = Some(current.clone());
                    break;
                }
            }
        }
        ended.store(true, Relaxed);
    });
    let seconds = computed(id).unwrap_or_else(|| started.elapsed().as_secs_f64());
    let mut child = child.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
    let _ = child.kill();
    let _ = child.wait();
    let result = match failed {
        Some(name) => Attempt::Failed(name),
        None if late.load(Relaxed) => Attempt::TimedOut,
        None if done => Attempt::Passed,
        // The process died.
        None => Attempt::Failed(format!("after {current}")),
    };
    (result, seconds)
}

/// How long a process has computed [s], where Linux tells: other processes do not count.
fn computed(process: u32) -> Option<f64> {
    let line = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    let fields: Vec<&str> = line.rsplit(')').next()?.split_whitespace().collect();
    let ticks = |at: usize| fields.get(at)?.parse::<f64>().ok();
    Some((ticks(11)? + ticks(12)?) / 100.0)
}

/// Calls `work` with every number below `count`, so many at a time.
pub fn in_parallel(jobs: usize, count: usize, work: impl Fn(usize) + Sync) {
    let next = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..jobs {
            scope.spawn(|| {
                loop {
                    let at = next.fetch_add(1, Relaxed);
                    if at >= count {
                        break;
                    }
                    work(at);
                }
            });
        }
    });
}

pub fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

/// Root of the repository that holds this crate.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap_or_else(|_| PathBuf::from("."))
}
