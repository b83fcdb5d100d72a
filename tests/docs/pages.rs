//! Pages of Markdown: fenced blocks, links, headings, words in back quotes, generated parts; and their commands, each of which is run, in
//! order, in a folder of its page's own. Blocks below a comment `parsed only: why` take too long or need what is not there: of these the
//! arguments are checked, by `--help` after them. A comment `exit code N` says that the command fails.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use tempfile::TempDir;

use crate::cli::DRIVER_FILES;

const END: &str = "<!-- /generated -->";

/// One page.
pub(super) struct Page {
    /// Path from the root of the repository.
    pub(super) path: PathBuf,
    pub(super) text: String,
}

/// A fenced block.
pub(super) struct Block {
    /// Language it is marked with.
    pub(super) kind: String,
    /// Comment on the line before, or empty.
    pub(super) comment: String,
    pub(super) lines: Vec<String>,
    /// Line of the page where it begins, from 1.
    pub(super) at: usize,
}

/// The README, the table of keys, every page of the book and every decision.
pub(super) fn all() -> Vec<Page> {
    let readme = vec![Page::read(Path::new("README.md"))];
    [readme, pages("docs"), book(), pages("docs/decisions")].into_iter().flatten().collect()
}

/// Every page of the book, the summary too.
pub(super) fn book() -> Vec<Page> {
    pages("docs/src")
}

fn pages(folder: &str) -> Vec<Page> {
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> = files.filter(|path| path.extension().is_some_and(|e| e == "md")).collect();
    files.sort();
    files.iter().map(|path| Page::read(path)).collect()
}

/// Whether pages are to be written anew.
pub(super) fn is_update() -> bool {
    std::env::var("RIPSTOP_UPDATE_DOCS").is_ok_and(|value| value == "1")
}

/// Holds the generated part of that name to what was made, or writes it into its page.
#[track_caller]
pub(crate) fn hold(name: &str, made: &str) {
    let start = format!("<!-- generated: {name} -->\n");
    let mut pages = all();
    pages.retain(|page| page.text.contains(&start));
    let [Page { path, text }] = &pages[..] else { panic!("{name}: in {} pages", pages.len()) };
    let (before, rest) = text.split_once(&start).unwrap();
    let (shown, after) = rest.split_once(END).expect("its end");
    if is_update() {
        return fs::write(path, format!("{before}{start}{}\n{END}{after}", made.trim())).unwrap();
    }
    let differs = shown.trim().lines().zip(made.trim().lines()).find(|(shown, made)| shown != made);
    let advice = "RIPSTOP_UPDATE_DOCS=1 writes it anew";
    assert!(shown.trim() == made.trim(), "{}: not what `{name}` makes; first: {differs:?}; {advice}", path.display());
}

impl Page {
    pub(super) fn read(path: &Path) -> Self {
        let text = fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        Self { path: path.to_owned(), text }
    }

    /// File name.
    pub(super) fn name(&self) -> String {
        self.path.file_name().unwrap().to_str().unwrap().to_owned()
    }

    /// Fenced blocks.
    pub(super) fn blocks(&self) -> Vec<Block> {
        let mut blocks: Vec<Block> = Vec::new();
        let (mut is_open, mut before) = (false, "");
        for (number, line) in self.text.lines().enumerate() {
            match (line.strip_prefix("```"), is_open) {
                (Some(kind), false) => {
                    let comment = before.strip_prefix("<!-- ").and_then(|text| text.strip_suffix(" -->"));
                    let (kind, comment) = (kind.to_owned(), comment.unwrap_or_default().to_owned());
                    blocks.push(Block { kind, comment, lines: Vec::new(), at: number + 1 });
                    is_open = true;
                }
                (Some(_), true) => is_open = false,
                (None, true) => blocks.last_mut().unwrap().lines.push(line.to_owned()),
                (None, false) => {}
            }
            before = line;
        }
        assert!(!is_open, "{}: a block that does not end", self.path.display());
        blocks
    }

    /// Lines outside of fenced blocks, with their numbers from 1.
    fn prose(&self) -> impl Iterator<Item = (usize, &str)> {
        let mut is_open = false;
        let outside = move |(_, line): &(usize, &str)| {
            let fence = line.starts_with("```");
            is_open ^= fence;
            !is_open && !fence
        };
        self.text.lines().enumerate().map(|(at, line)| (at + 1, line)).filter(outside)
    }

    /// Targets of links and pictures within the repository, each with its line.
    pub(super) fn links(&self) -> Vec<(String, usize)> {
        let targets = |(at, line): (usize, &str)| -> Vec<(String, usize)> {
            let targets = line.split("](").skip(1).filter_map(|rest| rest.split_once(')'));
            targets.filter(|(to, _)| !to.contains("://")).map(|(to, _)| (to.to_owned(), at)).collect()
        };
        self.prose().flat_map(targets).collect()
    }

    /// Words in back quotes, each with its line.
    pub(super) fn quoted(&self) -> Vec<(String, usize)> {
        let words = |(at, line): (usize, &str)| {
            line.split('`').skip(1).step_by(2).map(|word| (word.to_owned(), at)).collect::<Vec<_>>()
        };
        self.prose().flat_map(words).collect()
    }

    /// Names of the headings in links, as mdBook and GitHub make them.
    pub(super) fn anchors(&self) -> Vec<String> {
        let anchor = |heading: &str| {
            let letters = heading.trim_start_matches('#').trim().to_lowercase();
            letters.chars().filter(|c| c.is_alphanumeric() || "_- ".contains(*c)).collect::<String>().replace(' ', "-")
        };
        self.prose().filter_map(|(_, line)| line.strip_prefix('#')).map(anchor).collect()
    }

    /// First cells of the table below a heading, without back quotes.
    pub(super) fn first_cells(&self, heading: &str) -> Vec<String> {
        let from = self.text.lines().skip_while(|line| line.trim_start_matches('#').trim() != heading).skip(1);
        let rows = from.skip_while(|line| !line.starts_with('|')).take_while(|line| line.starts_with('|'));
        let cells = rows.skip(2).map(|row| row.split('|').nth(1).unwrap().trim().trim_matches('`').to_owned());
        let cells: Vec<String> = cells.collect();
        assert!(!cells.is_empty(), "{}: no table below {heading:?}", self.path.display());
        cells
    }
}

/// Other lines that a block may have.
const OTHERS: [&str; 3] = ["cargo install --path .", "cargo test --release", "mdbook serve docs"];
/// Lines that differ from run to run, up to here.
const VARYING: [&str; 2] = ["  wall time  ", "  on  "];
/// Lines left out.
const LEFT_OUT: &str = "…";
/// The picture of the first shot: where it stands in the book, and where the README's first command leaves it.
const PICTURE: [&str; 2] = ["docs/src/shot.svg", "out/s728-4ply-91/shot.svg"];

/// A line of a shell that finds the program, and no graphics adapter.
pub(super) fn program(line: &str) -> Command {
    let folder = Path::new(env!("CARGO_BIN_EXE_ripstop")).parent().unwrap();
    let others = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths([folder.to_owned()].into_iter().chain(std::env::split_paths(&others))).unwrap();
    let mut command = Command::new("sh");
    command.args(["-c", line]).env("PATH", path).stdin(Stdio::null());
    command.envs(DRIVER_FILES.map(|name| (name, "/nowhere/at/all"))).env("NODEVICE_SELECT", "1");
    command
}

/// The folder of a page: empty but for the cases.
struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        let folder = TempDir::new().unwrap();
        let cases = folder.path().join("cases");
        for name in ["", "fabrics", "verify"] {
            fs::create_dir_all(cases.join(name)).unwrap();
            for entry in fs::read_dir(Path::new("cases").join(name)).unwrap().map(|entry| entry.unwrap()) {
                if entry.path().is_file() {
                    fs::copy(entry.path(), cases.join(name).join(entry.file_name())).unwrap();
                }
            }
        }
        Self(folder)
    }

    fn run(&self, line: &str) -> Output {
        program(line).current_dir(self.0.path()).output().unwrap()
    }

    /// Does what a page says.
    fn follow(&self, page: &Page) -> usize {
        let blocks = page.blocks();
        let blocks: Vec<&Block> = blocks.iter().filter(|block| ["sh", "console"].contains(&&*block.kind)).collect();
        let mut count = 0;
        for block in blocks {
            for (line, shown) in lines(block) {
                let place = format!("{}:{}: {line}", page.path.display(), block.at);
                self.check(&line, &shown, &block.comment, &place);
                count += 1;
            }
        }
        count
    }

    fn check(&self, line: &str, shown: &[&str], comment: &str, place: &str) {
        if OTHERS.iter().any(|other| line.starts_with(other)) {
            return;
        }
        assert!(line.starts_with("ripstop "), "{place}: not a command of this program");
        if comment.starts_with("parsed only: ") {
            return assert_eq!(parse(line), Ok(()), "{place}");
        }
        let code: i32 = comment.strip_prefix("exit code ").map_or(0, |code| code.parse().unwrap());
        let (answers, shown) = typed(shown, line.contains(" --from-sheet"));
        fs::write(self.0.path().join("answers"), answers).unwrap();
        let output = self.run(&format!("{line} < answers"));
        let [stdout, stderr] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
        assert_eq!(output.status.code(), Some(code), "{place}\n{stdout}\n{stderr}");
        if !shown.is_empty() {
            let got = if code == 0 { stdout } else { stderr };
            let shown: Vec<&str> = shown.iter().map(String::as_str).collect();
            assert_eq!(compare(&shown, &got), Ok(()), "{place}\n{got}");
        }
    }
}

/// The commands of a block, each with what is shown of its output.
fn lines(block: &Block) -> Vec<(String, Vec<&str>)> {
    let mut all: Vec<(String, Vec<&str>)> = Vec::new();
    for line in &block.lines {
        let command = if block.kind == "console" { line.strip_prefix("$ ") } else { Some(&**line) };
        match command {
            Some("") => {}
            Some(command) => all.push((command.replace("cargo run --release -- ", "ripstop "), Vec::new())),
            None => all.last_mut().expect("a command before its output").1.push(line),
        }
    }
    all
}

/// Answers typed behind questions, and what is printed where answers come from a file: questions follow each other in one line.
fn typed(shown: &[&str], asks: bool) -> (String, Vec<String>) {
    let (mut answers, mut printed, mut questions) = (String::new(), Vec::new(), String::new());
    for line in shown {
        match line.split_once("):").filter(|_| asks) {
            Some((question, answer)) => {
                answers += &format!("{}\n", answer.trim());
                questions += &format!("{question}): ");
            }
            None => printed.push(std::mem::take(&mut questions) + line),
        }
    }
    (answers, printed)
}

/// Whether the program takes these arguments, without doing anything.
fn parse(line: &str) -> Result<(), String> {
    let output = program(&format!("{line} --help")).output().unwrap();
    let help = String::from_utf8_lossy(&output.stdout).contains("Usage: ripstop ");
    if output.status.success() && help { Ok(()) } else { Err(String::from_utf8_lossy(&output.stderr).into_owned()) }
}

/// Whether the lines shown are those got, but for what is left out.
fn compare(shown: &[&str], got: &str) -> Result<(), String> {
    let cut = |line: &str| {
        VARYING.iter().find(|start| line.starts_with(**start)).map_or(line, |start| *start).to_owned() + "\n"
    };
    let got: String = got.lines().map(cut).collect();
    let parts = shown.split(|line| *line == LEFT_OUT).map(|part| part.iter().map(|line| cut(line)).collect());
    let parts: Vec<String> = parts.collect();
    let (mut rest, last) = (got.as_str(), parts.len() - 1);
    for (number, part) in parts.iter().enumerate() {
        let place = match number {
            0 => rest.starts_with(part).then_some(0),
            number if number == last => rest.ends_with(part).then(|| rest.len() - part.len()),
            _ => rest.find(part),
        };
        rest = &rest[place.ok_or_else(|| format!("not in the output, or not there:\n{part}"))? + part.len()..];
    }
    if last == 0 && !rest.is_empty() { Err(format!("there is more:\n{rest}")) } else { Ok(()) }
}

/// Two shots, as users see them: a few seconds.
#[test]
fn the_commands_of_the_readme_do_what_it_says_and_draw_its_picture() {
    let folder = Folder::new();
    assert!(folder.follow(&Page::read(Path::new("README.md"))) >= 6);
    let [shown, drawn] = PICTURE;
    let drawn = fs::read_to_string(folder.0.path().join(drawn)).unwrap();
    if is_update() {
        return fs::write(shown, drawn).unwrap();
    }
    assert!(fs::read_to_string(shown).unwrap() == drawn, "{shown}: RIPSTOP_UPDATE_DOCS=1 writes it anew");
}

/// Two shots of four plies: some seconds.
#[test]
fn the_tutorial_is_what_happens() {
    assert!(Folder::new().follow(&Page::read(Path::new("docs/src/tutorial.md"))) >= 8);
}

/// A handful of shots, as users see them: a few seconds.
#[test]
fn the_commands_of_other_pages_do_what_they_say() {
    let pages = book();
    let others = pages.iter().filter(|page| page.name() != "tutorial.md");
    assert!(others.map(|page| Folder::new().follow(page)).sum::<usize>() >= 15);
}
