//! Page of Markdown: fenced blocks, links, headings, words in back quotes, generated parts.

use std::fs;
use std::path::{Path, PathBuf};

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
