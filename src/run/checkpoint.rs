//! Checkpoints: everything a run needs to go on as if nothing had happened, to the last bit, in one file.
//!
//! ```text
//! magic, format, length of the header │ header │ contents, compressed │ checksum of all before
//! ```
//!
//! The header can be read without a model. The contents are the state of the observer, the animation of the report so far, and one struct
//! of what varies during a run on its backend. What follows from the case is not in it: a checkpoint fits one case only. Frames lie beside
//! the checkpoint, in files of their own.

use std::fs::File;
use std::hash::Hasher as _;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use lz4_flex::frame::{BlockMode, BlockSize, FrameDecoder, FrameEncoder, FrameInfo};
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use twox_hash::XxHash3_64;

use crate::case::{Case, case_hash};
use crate::run::{Options, Precision, Skips};

/// First bytes of the file.
const MAGIC: [u8; 8] = *b"ripstop\x1a";
/// Number of the format: a new one for every change of the contents or their order.
pub const FORMAT: u32 = 11;
/// Bytes before the header.
const START: usize = MAGIC.len() + 8;
/// Bytes of the checksum.
const SUM: usize = 8;
/// Steps of any run at most.
const MAX_STEPS: u64 = 1_000_000_000;
/// Worker threads of any run at most.
const MAX_THREADS: usize = 1024;

/// A run between two steps, which can be saved.
pub trait Checkpointable {
    /// Time of the positions [s].
    fn time(&self) -> f64;
    /// Writes a checkpoint. The header names the run; how far it has come is added. `observer`: state that the observer wants back.
    ///
    /// # Errors
    /// When the writer refuses, or a device was lost.
    fn save(&self, header: &Header, observer: &[u8], to: &mut dyn Write) -> io::Result<()>;
}

/// Identity of a run, and how far it has come.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// Version of the program.
    pub version: String,
    /// Name of the case.
    pub case: String,
    /// Hash of what the case computes.
    pub case_hash: String,
    /// Backend.
    pub backend: BackendId,
    /// Skips of the run.
    pub skips: Skips,
    /// Worker threads asked for; results do not depend on it.
    pub threads: Option<usize>,
    /// Simulated time between checkpoints [s].
    pub every: f64,
    /// Whether `report.html` was asked for.
    pub report: bool,
    /// Steps done.
    pub step: u64,
    /// Time of the positions [s].
    pub time: f64,
    /// Time step [s].
    pub time_step: f64,
    /// Wall time so far.
    pub spent: Spent,
}

/// Backend of a run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum BackendId {
    /// The processor.
    Cpu(Precision),
    /// The graphics adapter of this name.
    Gpu(String),
}

impl BackendId {
    fn new(options: &Options<'_>) -> Self {
        options.device.map_or(Self::Cpu(options.precision), |device| Self::Gpu(device.name().to_owned()))
    }
}

/// Wall time that the parts of a run have taken so far [s].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spent {
    /// Since the command began.
    pub wall: f64,
    /// In the loop.
    pub r#loop: f64,
    /// Part of that spent waiting for the device.
    pub waited: f64,
}

impl Header {
    /// Header of a run that has not begun. `every`: simulated time between checkpoints [s].
    pub fn new(case: &Case, options: &Options<'_>, every: f64) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            case: case.name.clone(),
            case_hash: case_hash(&case.as_run),
            backend: BackendId::new(options),
            skips: options.skips,
            threads: options.threads,
            every,
            report: false,
            step: 0,
            time: 0.0,
            time_step: 0.0,
            spent: Spent::default(),
        }
    }

    /// Whether a run can have come so far: a run that goes on counts through all steps that were done.
    fn is_possible(&self) -> bool {
        let lengths = [self.every, self.time_step].iter().all(|length| length.is_finite() && *length > 0.0);
        lengths
            && self.step <= MAX_STEPS
            && (self.time - self.step as f64 * self.time_step).abs() <= self.time_step
            && self.threads.is_none_or(|threads| threads <= MAX_THREADS)
    }
}

/// Refusal of a file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("error: {path}\n{reason}")]
#[non_exhaustive]
pub struct CheckpointError {
    /// The file.
    pub path: String,
    /// Reason.
    pub reason: CheckpointReason,
}

/// Reason why no run goes on from a file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CheckpointReason {
    /// It cannot be read, for this reason.
    #[error("  expected: a checkpoint that can be read\n  found: {0}\n  help: see whether the file is there")]
    Unreadable(String),
    /// It is something else.
    #[error("  expected: a checkpoint of ripstop\n  found: another kind of file\n  help: run the case again")]
    Foreign,
    /// It has the format of this number.
    #[error("  expected: a checkpoint of format {own}\n  found: format {0}\n  help: resume with the version of ripstop that wrote it, or run the case again", own = FORMAT)]
    Format(u32),
    /// Its checksum does not hold: bits have changed, or the end is missing.
    #[error(
        "  expected: a checkpoint whose checksum holds\n  found: one that is damaged or cut short\n  help: run the case again"
    )]
    Damaged,
    /// It was written by this version of the program.
    #[error("  expected: a checkpoint of ripstop {own}\n  found: one of ripstop {0}\n  help: resume with ripstop {0}, or run the case again", own = env!("CARGO_PKG_VERSION"))]
    Version(String),
    /// It belongs to a case of another hash.
    #[error(
        "  expected: the case that the run began with (case_hash {checkpoint})\n  found: one that computes something else (case_hash {case})\n  help: undo the change of the case, or run it anew with `ripstop run`"
    )]
    Case {
        /// Hash of the checkpoint.
        checkpoint: String,
        /// Hash of the case at hand.
        case: String,
    },
    /// It is of a run on another backend or in another precision than this one.
    #[error(
        "  expected: the backend and precision that the run began with\n  found: {0}\n  help: let `ripstop resume` choose it"
    )]
    Backend(String),
    /// This part of its contents does not fit the model of the case.
    #[error(
        "  expected: contents that fit the model of the case\n  found: {0} that do not\n  help: run the case again"
    )]
    Contents(&'static str),
}

/// Writes a checkpoint.
///
/// # Errors
/// When the writer refuses.
pub(super) fn write(to: &mut dyn Write, header: &Header, observer: &[u8], state: &impl Serialize) -> io::Result<()> {
    let header = postcard::to_stdvec(header).map_err(io::Error::other)?;
    let mut file = [&MAGIC[..], &FORMAT.to_le_bytes(), &(header.len() as u32).to_le_bytes(), &header].concat();
    let blocks = FrameInfo::new().block_size(BlockSize::Max1MB).block_mode(BlockMode::Independent);
    let mut encoder = FrameEncoder::with_frame_info(blocks, &mut file);
    postcard::to_io(observer, &mut encoder).map_err(io::Error::other)?;
    postcard::to_io(state, &mut encoder).map_err(io::Error::other)?;
    encoder.finish()?;
    let sum = checksum(&[&file]);
    to.write_all(&file)?;
    to.write_all(&sum.to_le_bytes())
}

fn checksum(parts: &[&[u8]]) -> u64 {
    let mut sum = XxHash3_64::new();
    parts.iter().for_each(|part| sum.write(part));
    sum.finish()
}

/// A checkpoint that is whole and of this version of the program.
#[derive(Debug)]
pub struct Checkpoint {
    path: PathBuf,
    header: Header,
    /// Compressed.
    contents: Vec<u8>,
}

impl Checkpoint {
    /// Opens a file and checks all of it.
    ///
    /// # Errors
    /// When it cannot be read, is something else, is damaged, or of another version.
    pub fn open(path: &Path) -> Result<Self, CheckpointError> {
        let opened = File::open(path).map_err(unreadable).and_then(read);
        let (header, contents) =
            opened.map_err(|reason| CheckpointError { path: path.display().to_string(), reason })?;
        Ok(Self { path: path.to_owned(), header, contents })
    }

    /// Identity of the run, and how far it has come.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// State that the observer wants back.
    ///
    /// # Errors
    /// When the contents cannot be read.
    pub fn observer_state(&self) -> Result<Vec<u8>, CheckpointError> {
        let state = || {
            let contents = self.unpacked()?;
            postcard::take_from_bytes(&contents).map(|(state, _)| state).map_err(|_| PICTURES)
        };
        state().map_err(|reason| self.refused(reason))
    }

    /// State of the run; whatever is left over, or missing, does not fit. `restore` puts it into its place, or finds that it does not fit.
    ///
    /// # Errors
    /// When the contents do not fit.
    pub(super) fn state<T: DeserializeOwned>(
        &self,
        restore: impl FnOnce(T) -> Result<(), &'static str>,
    ) -> Result<(), CheckpointError> {
        let read = || {
            let contents = self.unpacked()?;
            let (_, rest) = postcard::take_from_bytes::<&[u8]>(&contents).map_err(|_| PICTURES)?;
            match postcard::take_from_bytes(rest) {
                Ok((state, [])) => restore(state).map_err(CheckpointReason::Contents),
                _ => Err(CheckpointReason::Contents("numbers")),
            }
        };
        read().map_err(|reason| self.refused(reason))
    }

    /// The contents. LZ4 expands at most 255 times, so that no file asks for memory without bound.
    fn unpacked(&self) -> Result<Vec<u8>, CheckpointReason> {
        let mut contents = Vec::new();
        let read = FrameDecoder::new(&self.contents[..]).read_to_end(&mut contents);
        read.map_err(|_| CheckpointReason::Contents("bytes"))?;
        Ok(contents)
    }

    /// Checks that a run of this case can go on from here.
    ///
    /// # Errors
    /// When the case computes something else.
    pub fn check_case(&self, case: &Case) -> Result<(), CheckpointError> {
        let (checkpoint, case) = (&self.header.case_hash, case_hash(&case.as_run));
        if *checkpoint != case {
            return Err(self.refused(CheckpointReason::Case { checkpoint: checkpoint.clone(), case }));
        }
        let possible = self.header.is_possible();
        if possible { Ok(()) } else { Err(self.refused(CheckpointReason::Contents("steps and times of the header"))) }
    }

    /// Checks that a run with these options can go on from here.
    ///
    /// # Errors
    /// When another backend or precision would compute it.
    pub(super) fn check_options(&self, options: &Options<'_>) -> Result<(), CheckpointError> {
        let backend = BackendId::new(options);
        if backend == self.header.backend {
            return Ok(());
        }
        let words = match backend {
            BackendId::Cpu(precision) => format!("cpu, {}", precision.name()),
            BackendId::Gpu(adapter) => format!("gpu, {adapter}"),
        };
        Err(self.refused(CheckpointReason::Backend(words)))
    }

    fn refused(&self, reason: CheckpointReason) -> CheckpointError {
        CheckpointError { path: self.path.display().to_string(), reason }
    }
}

/// State of the observer, which comes first in the contents.
const PICTURES: CheckpointReason = CheckpointReason::Contents("pictures so far");

fn unreadable(error: io::Error) -> CheckpointReason {
    CheckpointReason::Unreadable(error.to_string())
}

/// Header and contents of a file that is sound.
fn read(mut file: File) -> Result<(Header, Vec<u8>), CheckpointReason> {
    let mut start = [0; START];
    if file.read_exact(&mut start).is_err() || start[..MAGIC.len()] != MAGIC {
        return Err(CheckpointReason::Foreign);
    }
    let word = |at: usize| u32::from_le_bytes([0, 1, 2, 3].map(|byte| start[at + byte]));
    let (format, length) = (word(MAGIC.len()), word(MAGIC.len() + 4) as usize);
    if format != FORMAT {
        return Err(CheckpointReason::Format(format));
    }
    let mut rest = Vec::new();
    file.read_to_end(&mut rest).map_err(unreadable)?;
    let Some((body, sum)) = rest.split_last_chunk::<SUM>() else { return Err(CheckpointReason::Damaged) };
    if length > body.len() || checksum(&[&start, body]) != u64::from_le_bytes(*sum) {
        return Err(CheckpointReason::Damaged);
    }
    let (header, contents) = body.split_at(length);
    let header: Header = postcard::from_bytes(header).map_err(|_| CheckpointReason::Contents("words of the header"))?;
    if header.version != env!("CARGO_PKG_VERSION") {
        return Err(CheckpointReason::Version(header.version));
    }
    Ok((header, contents.to_vec()))
}
