//! A page of Markdown, as far as tests look into it: fenced blocks, links, headings, words in back quotes.

use std::fs;
use std::path::{Path, PathBuf};

/// One page.
pub(super) struct Page {
    /// From the root of the repository.
    pub(super) path: PathBuf,
    pub(super) text: String,
}

/// A fenced block.
#[derive(Debug, PartialEq)]
pub(super) struct Block {
    /// What it is marked as.
    pub(super) kind: String,
    /// The comment on the line before, empty: none.
    pub(super) comment: String,
    pub(super) lines: Vec<String>,
    /// Line of the page where it begins, from 1.
    pub(super) at: usize,
}

/// The README, every page of the book and every decision.
pub(super) fn all() -> Vec<Page> {
    let mut pages = vec![Page::read(Path::new("README.md"))];
    pages.extend(book());
    pages.extend(folder("docs/decisions"));
    pages
}

/// Every page of the book, the summary too.
pub(super) fn book() -> Vec<Page> {
    folder("docs/src")
}

/// Pages of a folder, by name.
fn folder(path: &str) -> Vec<Page> {
    let files = fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> =
        files.filter(|path| path.extension().is_some_and(|extension| extension == "md")).collect();
    files.sort();
    files.iter().map(|path| Page::read(path)).collect()
}

impl Page {
    pub(super) fn read(path: &Path) -> Self {
        let text = fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        Self { path: path.to_owned(), text }
    }

    /// Its file name.
    pub(super) fn name(&self) -> String {
        self.path.file_name().unwrap().to_str().unwrap().to_owned()
    }

    /// Its fenced blocks.
    pub(super) fn blocks(&self) -> Vec<Block> {
        let mut blocks: Vec<Block> = Vec::new();
        let mut is_open = false;
        let mut before = "";
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
        let mut links = Vec::new();
        for (at, line) in self.prose() {
            let targets = line.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(target, _)| target);
            links.extend(targets.filter(|target| !target.contains("://")).map(|target| (target.to_owned(), at)));
        }
        links
    }

    /// What stands in back quotes, each with its line.
    pub(super) fn quoted(&self) -> Vec<(String, usize)> {
        let words = |(at, line): (usize, &str)| {
            line.split('`').skip(1).step_by(2).map(|word| (word.to_owned(), at)).collect::<Vec<_>>()
        };
        self.prose().flat_map(words).collect()
    }

    /// Names of its headings in links, as mdBook and GitHub make them.
    pub(super) fn anchors(&self) -> Vec<String> {
        let headings = self.prose().filter_map(|(_, line)| line.strip_prefix('#'));
        let anchor = |heading: &str| {
            let letters = heading.trim_start_matches('#').trim().to_lowercase();
            letters.chars().filter(|c| c.is_alphanumeric() || "_- ".contains(*c)).collect::<String>().replace(' ', "-")
        };
        headings.map(anchor).collect()
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

#[test]
fn a_page_is_taken_apart() {
    let text = "# One\n\n<!-- long -->\n```sh\nripstop [x](y)\n```\n[a](b.md#c), `d e` and [w](https://x.y)\n## T.wo-3\n\n| k | v |\n|---|---|\n| `a` | 1 |\n";
    let page = Page { path: "p.md".into(), text: text.to_owned() };
    let block = Block { kind: "sh".into(), comment: "long".into(), lines: vec!["ripstop [x](y)".into()], at: 4 };
    assert_eq!(page.blocks(), [block]);
    assert_eq!(page.links(), [("b.md#c".to_owned(), 7)]);
    assert_eq!(page.quoted()[0], ("d e".to_owned(), 7));
    assert_eq!(page.anchors(), ["one", "two-3"]);
    assert_eq!(page.first_cells("T.wo-3"), ["a"]);
}
