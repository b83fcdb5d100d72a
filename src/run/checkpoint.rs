//! Checkpoints: everything a run needs to go on as if nothing had happened, to the last bit, in one file.
//!
//! ```text
//! magic, format │ header, state of the observer, state of the run: compressed │ checksum of all before
//! ```
//!
//! The header can be read without a model. The observer is the animation of the report so far, the run one struct of what varies on its
//! backend. What follows from the case is not in it: a checkpoint fits one case only. Frames lie beside the checkpoint, in files of
//! their own.

use std::fs;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use lz4_flex::frame::{BlockMode, BlockSize, FrameDecoder, FrameEncoder, FrameInfo};
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use twox_hash::XxHash3_64;

use crate::case::{Case, CaseError, case_hash};
use crate::run::{Options, Precision, RunError, Skips};

/// First bytes of the file.
const MAGIC: [u8; 8] = *b"ripstop\x1a";
/// Number of the format: a new one for every change of the contents or their order.
pub const FORMAT: u32 = 16;
/// Bytes of the checksum.
const SUM: usize = 8;
/// Advice where there is no other.
const AGAIN: &str = "run the case again";
/// A run between two steps, which can be saved.
pub trait Checkpointable {
    /// Time of the positions that the next step begins from, and time step [s].
    fn clock(&self) -> [f64; 2];
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
    /// Wall time so far, since the command began [s].
    pub wall_seconds: f64,
    /// Part of it in the loop [s].
    pub loop_seconds: f64,
}

/// Backend of a run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum BackendId {
    /// The processor.
    Cpu(Precision),
    /// The graphics adapter of this name.
    Gpu(String),
}

impl Header {
    /// Header of a run that has not begun. `every`: simulated time between checkpoints [s].
    pub fn new(case: &Case, options: &Options<'_>, every: f64) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            case: case.name.clone(),
            case_hash: case_hash(&case.as_run),
            backend: options
                .device
                .map_or(BackendId::Cpu(options.precision), |device| BackendId::Gpu(device.name().to_owned())),
            skips: options.skips,
            threads: options.threads,
            every,
            report: false,
            step: 0,
            time: 0.0,
            time_step: 0.0,
            wall_seconds: 0.0,
            loop_seconds: 0.0,
        }
    }
}

/// Writes a checkpoint.
///
/// # Errors
/// When the writer refuses.
pub(super) fn write(to: &mut dyn Write, header: &Header, observer: &[u8], state: &impl Serialize) -> io::Result<()> {
    let mut file = [&MAGIC[..], &FORMAT.to_le_bytes()].concat();
    let blocks = FrameInfo::new().block_size(BlockSize::Max1MB).block_mode(BlockMode::Independent);
    let mut encoder = FrameEncoder::with_frame_info(blocks, &mut file);
    postcard::to_io(&(header, observer, state), &mut encoder).map_err(io::Error::other)?;
    encoder.finish()?;
    file.extend(XxHash3_64::oneshot(&file).to_le_bytes());
    to.write_all(&file)
}

/// A checkpoint that is whole and of this version of the program.
#[derive(Debug)]
pub struct Checkpoint {
    path: PathBuf,
    /// Identity of the run, and how far it has come.
    pub header: Header,
    /// State that the observer wants back.
    pub observer: Vec<u8>,
    /// State of the run.
    state: Vec<u8>,
}

impl Checkpoint {
    /// Opens a file and checks all of it.
    ///
    /// # Errors
    /// When it cannot be read, is something else, is damaged, or of another version.
    pub fn open(path: &Path) -> Result<Self, CaseError> {
        let refused = |expected: &str, found: &str, help: &str| Err(CaseError::of_path(path, expected, found, help));
        let unread = |error| CaseError::of_path(path, "a checkpoint that can be read", error, AGAIN);
        let bytes = fs::read(path).map_err(unread)?;
        let format = bytes.strip_prefix(&MAGIC).and_then(|rest| rest.split_first_chunk());
        let Some((format, rest)) = format.map(|(format, rest)| (u32::from_le_bytes(*format), rest)) else {
            return refused("a checkpoint of ripstop", "another kind of file", AGAIN);
        };
        if format != FORMAT {
            let help = "resume with the version of ripstop that wrote it, or run the case again";
            return refused(&format!("a checkpoint of format {FORMAT}"), &format!("format {format}"), help);
        }
        let sound = rest
            .split_last_chunk::<SUM>()
            .filter(|(_, sum)| XxHash3_64::oneshot(&bytes[..bytes.len() - SUM]) == u64::from_le_bytes(**sum));
        let Some((packed, _)) = sound else {
            return refused("a checkpoint whose checksum holds", "one that is damaged or cut short", AGAIN);
        };
        let mut contents = Vec::new();
        // LZ4 expands at most 255 times, so that no file asks for memory without bound.
        let unpacked = FrameDecoder::new(packed).read_to_end(&mut contents);
        let parts = postcard::take_from_bytes::<(Header, Vec<u8>)>(&contents).ok().filter(|_| unpacked.is_ok());
        let ((header, observer), state) = parts.ok_or_else(|| unfit(path))?;
        let (own, other) = (env!("CARGO_PKG_VERSION"), &header.version);
        if other != own {
            let help = format!("resume with ripstop {other}, or run the case again");
            return refused(&format!("a checkpoint of ripstop {own}"), &format!("one of ripstop {other}"), &help);
        }
        Ok(Self { path: path.to_owned(), state: state.to_vec(), header, observer })
    }

    /// State of a run of this case on this backend.
    ///
    /// # Errors
    /// When the checkpoint is one of another run.
    pub(super) fn state<T: DeserializeOwned>(&self, case: &Case, backend: &BackendId) -> Result<T, RunError> {
        self.check_case(case).map_err(RunError::Checkpoint)?;
        if self.header.backend != *backend {
            let found = match backend {
                BackendId::Cpu(precision) => format!("cpu, {}", precision.name()),
                BackendId::Gpu(adapter) => format!("gpu, {adapter}"),
            };
            let expected = "the backend and precision that the run began with";
            let refused = CaseError::of_path(&self.path, expected, found, "let `ripstop resume` choose it");
            return Err(RunError::Checkpoint(refused));
        }
        postcard::from_bytes(&self.state).map_err(|_| RunError::Checkpoint(unfit(&self.path)))
    }

    /// Checks that a run of this case can go on from here.
    ///
    /// # Errors
    /// When the case computes something else.
    pub fn check_case(&self, case: &Case) -> Result<(), CaseError> {
        let (checkpoint, case) = (&self.header.case_hash, case_hash(&case.as_run));
        if *checkpoint != case {
            let expected = format!("the case that the run began with (case_hash {checkpoint})");
            let found = format!("one that computes something else (case_hash {case})");
            let help = "undo the change of the case, or run it anew with `ripstop run`";
            return Err(CaseError::of_path(&self.path, expected, found, help));
        }
        Ok(())
    }
}

/// Refusal of contents that are none.
fn unfit(path: &Path) -> CaseError {
    CaseError::of_path(path, "contents of a run", "others", AGAIN)
}
