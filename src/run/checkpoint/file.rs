//! The file: head, compressed contents, checksum.

use std::fs::File;
use std::hash::Hasher as _;
use std::io::{self, Read, Seek, SeekFrom, Take, Write};
use std::path::{Path, PathBuf};

use bytemuck::Pod;
use lz4_flex::frame::{BlockMode, BlockSize, FrameDecoder, FrameEncoder, FrameInfo};
use serde::{Serialize, de::DeserializeOwned};
use twox_hash::XxHash3_64;

use super::{CheckpointError, CheckpointFault, Header};
use crate::case::Case;
use crate::run::Options;

/// What the file begins with.
const MAGIC: [u8; 8] = *b"ripstop\x1a";
/// Number of the format: a new one for every change of what is in the file, or in which order.
pub const FORMAT: u32 = 10;
/// Bytes of a head at most.
const HEAD: u32 = 1 << 16;
/// Bytes of the checksum.
const SUM: u64 = 8;
/// Says what part of the contents comes first.
const FOLLOWED: &str = "pictures so far";
/// Numbers whose bytes are sorted at once.
const CHUNK: usize = 1 << 14;

/// Writes a checkpoint: the head, what whoever follows the run wants back, and what `contents` puts into it.
///
/// # Errors
/// When the writer refuses.
pub(crate) fn write(
    to: &mut dyn Write,
    head: &Header,
    followed: &[u8],
    contents: impl FnOnce(&mut Writer<'_>) -> io::Result<()>,
) -> io::Result<()> {
    let mut summed = Summed { inner: to, sum: XxHash3_64::new() };
    let head = postcard::to_stdvec(head).map_err(io::Error::other)?;
    summed.write_all(&MAGIC)?;
    summed.write_all(&FORMAT.to_le_bytes())?;
    summed.write_all(&(head.len() as u32).to_le_bytes())?;
    summed.write_all(&head)?;
    let frame = FrameInfo::new().block_size(BlockSize::Max1MB).block_mode(BlockMode::Independent);
    let mut writer = Writer { encoder: FrameEncoder::with_frame_info(frame, summed), sorted: Vec::new() };
    writer.bytes(followed)?;
    contents(&mut writer)?;
    let mut summed = writer.encoder.finish()?;
    let sum = summed.sum.finish();
    summed.write_all(&sum.to_le_bytes())
}

/// Adds up what is written.
struct Summed<'a> {
    inner: &'a mut dyn Write,
    sum: XxHash3_64,
}

impl Write for Summed<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.inner.write(bytes)?;
        self.sum.write(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

/// Takes the contents.
pub(crate) struct Writer<'a> {
    encoder: FrameEncoder<Summed<'a>>,
    sorted: Vec<u8>,
}

impl Writer<'_> {
    /// A value of any size.
    pub(crate) fn value(&mut self, value: &impl Serialize) -> io::Result<()> {
        self.bytes(&postcard::to_stdvec(value).map_err(io::Error::other)?)
    }

    fn bytes(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.encoder.write_all(&(bytes.len() as u64).to_le_bytes())?;
        self.encoder.write_all(bytes)
    }

    /// Numbers whose count the reader knows. Neighbours differ least in their upper bytes, so that bytes of one kind
    /// are put together, which compresses better.
    pub(crate) fn numbers<S: Pod>(&mut self, numbers: &[S]) -> io::Result<()> {
        for chunk in numbers.chunks(CHUNK) {
            self.sorted.clear();
            for byte in bytes_of::<S>() {
                self.sorted.extend(bytemuck::cast_slice::<S, u8>(chunk).iter().skip(byte).step_by(size_of::<S>()));
            }
            self.encoder.write_all(&self.sorted)?;
        }
        Ok(())
    }
}

/// Places of the bytes of a number, the lowest first, whatever the machine.
fn bytes_of<S>() -> impl Iterator<Item = usize> {
    (0..size_of::<S>()).map(|byte| if cfg!(target_endian = "big") { size_of::<S>() - 1 - byte } else { byte })
}

/// A checkpoint that is whole and of this version of the program.
#[derive(Debug)]
pub struct Checkpoint {
    path: PathBuf,
    file: File,
    head: Header,
    /// Where the contents lie.
    contents: std::ops::Range<u64>,
}

impl Checkpoint {
    /// Opens a file and checks all of it.
    ///
    /// # Errors
    /// When it cannot be read, is something else, is damaged, or of another version.
    pub fn open(path: &Path) -> Result<Self, CheckpointError> {
        let failed = |fault| CheckpointError::new(path, fault);
        let mut file = File::open(path).map_err(|error| failed(CheckpointFault::Unreadable(error.to_string())))?;
        let (head, contents) = examine(&mut file).map_err(failed)?;
        if head.version != env!("CARGO_PKG_VERSION") {
            return Err(failed(CheckpointFault::Version(head.version)));
        }
        Ok(Self { path: path.to_owned(), file, head, contents })
    }

    /// What run it is of.
    pub fn head(&self) -> &Header {
        &self.head
    }

    /// What whoever followed the run wanted back.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn observer_state(&self) -> Result<Vec<u8>, CheckpointError> {
        self.reader().and_then(|mut reader| reader.bytes(FOLLOWED)).map_err(|fault| self.error(fault))
    }

    /// Reads the contents: whatever is left over, or missing, does not fit.
    ///
    /// # Errors
    /// When `read` finds that they do not fit.
    pub(crate) fn contents<T>(
        &self,
        read: impl FnOnce(&mut Reader<'_>) -> Result<T, CheckpointFault>,
    ) -> Result<T, CheckpointError> {
        let open = || {
            let mut reader = self.reader()?;
            reader.bytes(FOLLOWED)?;
            let value = read(&mut reader)?;
            reader.end()?;
            Ok(value)
        };
        open().map_err(|fault| self.error(fault))
    }

    fn reader(&self) -> Result<Reader<'_>, CheckpointFault> {
        let mut file = &self.file;
        file.seek(SeekFrom::Start(self.contents.start)).map_err(unreadable)?;
        let compressed = file.take(self.contents.end - self.contents.start);
        Ok(Reader { decoder: FrameDecoder::new(compressed), sorted: Vec::new() })
    }

    /// Whether a run of this case can go on from here.
    ///
    /// # Errors
    /// When the case computes something else.
    pub fn check_case(&self, case: &Case) -> Result<(), CheckpointError> {
        self.head.check_case(case).map_err(|fault| self.error(fault))
    }

    /// Whether a run with these options can.
    ///
    /// # Errors
    /// When something else would compute it.
    pub(crate) fn check_options(&self, options: &Options<'_>) -> Result<(), CheckpointError> {
        self.head.check_options(options).map_err(|fault| self.error(fault))
    }

    fn error(&self, fault: CheckpointFault) -> CheckpointError {
        CheckpointError::new(&self.path, fault)
    }
}

fn unreadable(error: io::Error) -> CheckpointFault {
    CheckpointFault::Unreadable(error.to_string())
}

/// The head of a file, and where its contents lie, once all of it was found to be sound.
fn examine(file: &mut File) -> Result<(Header, std::ops::Range<u64>), CheckpointFault> {
    let length = file.metadata().map_err(unreadable)?.len();
    let start = (MAGIC.len() + 8) as u64;
    let mut magic = [0; MAGIC.len()];
    if length < start || file.read_exact(&mut magic).is_err() || magic != MAGIC {
        return Err(CheckpointFault::Foreign);
    }
    let mut word = || {
        let mut word = [0; 4];
        file.read_exact(&mut word).map_err(unreadable).map(|()| u32::from_le_bytes(word))
    };
    let (format, head_length) = (word()?, word()?);
    if format != FORMAT {
        return Err(CheckpointFault::Format(format));
    }
    let body = start + u64::from(head_length);
    if head_length > HEAD || body + SUM > length || !is_whole(file, length).map_err(unreadable)? {
        return Err(CheckpointFault::Damaged);
    }
    let mut head = vec![0; head_length as usize];
    file.seek(SeekFrom::Start(start)).and_then(|_| file.read_exact(&mut head)).map_err(unreadable)?;
    let head = postcard::from_bytes(&head).map_err(|_| CheckpointFault::Contents("words of the head"))?;
    Ok((head, body..length - SUM))
}

/// Whether the checksum at the end holds.
fn is_whole(file: &mut File, length: u64) -> io::Result<bool> {
    file.rewind()?;
    let mut sum = XxHash3_64::new();
    let mut buffer = vec![0; 1 << 16];
    let mut left = length - SUM;
    while left > 0 {
        let part = &mut buffer[..left.min(1 << 16) as usize];
        file.read_exact(part)?;
        sum.write(part);
        left -= part.len() as u64;
    }
    let mut stated = [0; SUM as usize];
    file.read_exact(&mut stated)?;
    Ok(u64::from_le_bytes(stated) == sum.finish())
}

/// Gives the contents in the order in which they were put in.
pub(crate) struct Reader<'a> {
    decoder: FrameDecoder<Take<&'a File>>,
    sorted: Vec<u8>,
}

impl Reader<'_> {
    /// A value of any size.
    pub(crate) fn value<T: DeserializeOwned>(&mut self, what: &'static str) -> Result<T, CheckpointFault> {
        match postcard::take_from_bytes(&self.bytes(what)?) {
            Ok((value, [])) => Ok(value),
            _ => Err(CheckpointFault::Contents(what)),
        }
    }

    /// Bytes of any number; memory for them is taken as they come in.
    fn bytes(&mut self, what: &'static str) -> Result<Vec<u8>, CheckpointFault> {
        let mut length = [0; 8];
        self.decoder.read_exact(&mut length).map_err(|_| CheckpointFault::Contents(what))?;
        let length = u64::from_le_bytes(length);
        let mut bytes = Vec::new();
        match self.decoder.by_ref().take(length).read_to_end(&mut bytes) {
            Ok(read) if read as u64 == length => Ok(bytes),
            _ => Err(CheckpointFault::Contents(what)),
        }
    }

    /// As many numbers as there is room for.
    pub(crate) fn numbers<S: Pod>(&mut self, numbers: &mut [S], what: &'static str) -> Result<(), CheckpointFault> {
        for chunk in numbers.chunks_mut(CHUNK) {
            self.sorted.resize(size_of_val(chunk), 0);
            self.decoder.read_exact(&mut self.sorted).map_err(|_| CheckpointFault::Contents(what))?;
            let count = chunk.len();
            let bytes = bytemuck::cast_slice_mut::<S, u8>(chunk);
            for (byte, sorted) in bytes_of::<S>().zip(self.sorted.chunks_exact(count)) {
                bytes.iter_mut().skip(byte).step_by(size_of::<S>()).zip(sorted).for_each(|(to, from)| *to = *from);
            }
        }
        Ok(())
    }

    /// Nothing is left.
    fn end(&mut self) -> Result<(), CheckpointFault> {
        match self.decoder.read(&mut [0]) {
            Ok(0) => Ok(()),
            _ => Err(CheckpointFault::Contents("more numbers")),
        }
    }
}
