//! Files with a checksum: a fuzzer that does not know it would never come behind it.

use std::hash::Hasher as _;
use std::io::{Read as _, Write as _};

use lz4_flex::frame::{FrameDecoder, FrameEncoder};
use twox_hash::XxHash3_64;

/// Bytes before the head: what the file begins with, the number of the format, the length of the head.
const START: usize = 16;
/// Bytes of the checksum.
const SUM: usize = 8;

/// What a checkpoint holds, unpacked.
#[derive(Clone)]
pub(crate) struct Plain {
    start: [u8; 12],
    head: Vec<u8>,
    contents: Vec<u8>,
}

impl Plain {
    /// Unpacks a file that is whole.
    pub(crate) fn of(file: &[u8]) -> Self {
        let length = u32::from_le_bytes(file[12..START].try_into().expect("four bytes")) as usize;
        let mut contents = Vec::new();
        FrameDecoder::new(&file[START + length..file.len() - SUM]).read_to_end(&mut contents).expect("a whole file");
        let start = file[..12].try_into().expect("twelve bytes");
        Self { start, head: file[START..START + length].to_vec(), contents }
    }

    /// Packs it again, with a checksum that holds.
    pub(crate) fn seal(&self) -> Vec<u8> {
        let mut file = [&self.start[..], &(self.head.len() as u32).to_le_bytes(), &self.head].concat();
        let mut encoder = FrameEncoder::new(Vec::new());
        encoder.write_all(&self.contents).expect("memory");
        file.extend(encoder.finish().expect("memory"));
        let mut sum = XxHash3_64::new();
        sum.write(&file);
        file.extend(sum.finish().to_le_bytes());
        file
    }

    /// Makes changes: each has a byte that says what, a place, a count and as many bytes.
    pub(crate) fn edited(mut self, mut edits: &[u8]) -> Self {
        while let [what, low, high, count, rest @ ..] = edits {
            let count = usize::from(count & 31);
            let new = &rest[..count.min(rest.len())];
            edits = &rest[new.len()..];
            let part = if what & 1 == 0 { &mut self.contents } else { &mut self.head };
            let place = usize::from(u16::from_le_bytes([*low, *high]));
            let place = if what & 2 == 0 { place } else { part.len().saturating_sub(place) };
            let at = place.min(part.len());
            let end = (at + count).min(part.len());
            match (what >> 2) & 3 {
                0 => part.splice(at..(at + new.len()).min(part.len()), new.iter().copied()).for_each(drop),
                1 => part.splice(at..at, new.iter().copied()).for_each(drop),
                2 => part.splice(at..end, []).for_each(drop),
                _ => part[at..end].iter_mut().for_each(|byte| *byte ^= 1 << (what >> 5)),
            }
        }
        self
    }
}
