//! `frames.pvd` and its series of `.vtu` files: XML with the numbers appended, compressed by zlib.
//!
//! <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>

use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

use flate2::{Compression, write::ZlibEncoder};
use tempfile::TempDir;

use super::earlier::SERIES;
use super::parts::{Array, PartArray, PartFrame, PartGrid};

const BYTE_ORDER: &str = if cfg!(target_endian = "big") { "BigEndian" } else { "LittleEndian" };

/// A series in the making, in a folder of its own.
pub(super) struct VtuSeries {
    folder: TempDir,
    grids: Vec<Fixed>,
    /// Names of the files.
    pub(super) names: Vec<String>,
    /// The lines of the `.pvd` file.
    entries: String,
    frames: usize,
}

/// What all files of a part have in common, compressed.
struct Fixed {
    name: &'static str,
    points: usize,
    cells: usize,
    corners: Vec<u8>,
    ends: Vec<u8>,
    kinds: Vec<u8>,
    /// Name and numbers of the arrays that do not change; of cells.
    arrays: Vec<(&'static str, Vec<u8>)>,
}

impl VtuSeries {
    /// A series in a new folder.
    pub(super) fn create(folder: TempDir, grids: &[PartGrid]) -> io::Result<Self> {
        let fixed = |grid: &PartGrid| {
            let arrays = grid.fixed.iter().map(|array| Ok((array.name, block(array.numbers.bytes())?)));
            Ok(Fixed {
                name: grid.name,
                points: grid.points,
                cells: grid.cells(),
                corners: block(bytemuck::cast_slice(&grid.corners))?,
                ends: block(bytemuck::cast_slice(&grid.ends))?,
                kinds: block(&grid.kinds)?,
                arrays: arrays.collect::<io::Result<_>>()?,
            })
        };
        let grids = grids.iter().map(fixed).collect::<io::Result<_>>()?;
        Ok(Self { folder, grids, names: Vec::new(), entries: String::new(), frames: 0 })
    }

    /// Where the files are.
    pub(super) fn path(&self) -> &Path {
        self.folder.path()
    }

    /// The files of a frame, one for each part.
    pub(super) fn pack(&self, time_us: f64, parts: &[PartFrame]) -> io::Result<Vec<Vec<u8>>> {
        let file = |(fixed, part)| {
            let mut file = Vec::new();
            write_part(&mut file, time_us, fixed, part).map(|()| file)
        };
        self.grids.iter().zip(parts).map(file).collect()
    }

    /// Adds a frame: what [`Self::pack`] made of it.
    pub(super) fn add(&mut self, time_us: f64, files: &[Vec<u8>]) -> io::Result<()> {
        for (number, (fixed, contents)) in self.grids.iter().zip(files).enumerate() {
            let name = file_name(fixed.name, self.frames);
            let mut file = File::create(self.folder.path().join(&name))?;
            file.write_all(contents)?;
            file.sync_data()?;
            let part = fixed.name;
            let _ = writeln!(
                self.entries,
                "<DataSet timestep=\"{time_us}\" part=\"{number}\" name=\"{part}\" file=\"{SERIES}/{name}\"/>"
            );
            self.names.push(name);
        }
        self.frames += 1;
        Ok(())
    }

    /// The text of the `.pvd` file.
    pub(super) fn collection(&self) -> String {
        format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"{BYTE_ORDER}\">\n\
             <!-- time in µs -->\n<Collection>\n{}</Collection>\n</VTKFile>\n",
            self.entries
        )
    }
}

fn file_name(part: &str, frame: usize) -> String {
    format!("{part}_{frame:04}.vtu")
}

/// The header and the compressed bytes of an array, which is one block.
fn block(bytes: &[u8]) -> io::Result<Vec<u8>> {
    let mut encoder = ZlibEncoder::new(vec![0; 32], Compression::fast());
    encoder.write_all(bytes)?;
    let mut out = encoder.finish()?;
    // Blocks, bytes of a block, of the last one if that is shorter, and compressed.
    let header = [u64::from(!bytes.is_empty()), bytes.len() as u64, 0, (out.len() - 32) as u64];
    out[..32].copy_from_slice(bytemuck::cast_slice(&header));
    if bytes.is_empty() {
        out.truncate(24);
    }
    Ok(out)
}

/// The numbers that follow the XML, and the elements that speak of them.
#[derive(Default)]
struct Appended<'a> {
    blocks: Vec<std::borrow::Cow<'a, [u8]>>,
    offset: usize,
}

impl<'a> Appended<'a> {
    fn element(&mut self, kind: &str, name: &str, components: usize, block: std::borrow::Cow<'a, [u8]>) -> String {
        let offset = self.offset;
        self.offset += block.len();
        self.blocks.push(block);
        format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"appended\" offset=\"{offset}\"/>\n"
        )
    }

    fn array(&mut self, array: &Array) -> io::Result<String> {
        let kind = match array.numbers {
            PartArray::Float(_) => "Float32",
            PartArray::Byte(_) => "UInt8",
        };
        Ok(self.element(kind, array.name, array.components, block(array.numbers.bytes())?.into()))
    }

    fn arrays(&mut self, arrays: &[Array]) -> io::Result<String> {
        arrays.iter().map(|array| self.array(array)).collect()
    }
}

fn write_part(file: &mut impl Write, time_us: f64, fixed: &Fixed, part: &PartFrame) -> io::Result<()> {
    let mut appended = Appended::default();
    let points = appended.array(&part.points)?;
    let cells = [
        ("Int64", "connectivity", &fixed.corners),
        ("Int64", "offsets", &fixed.ends),
        ("UInt8", "types", &fixed.kinds),
    ];
    let cells: String =
        cells.into_iter().map(|(kind, name, block)| appended.element(kind, name, 1, block.into())).collect();
    let of_points = appended.arrays(&part.of_points)?;
    let unchanging = fixed.arrays.iter();
    let mut of_cells: String =
        unchanging.map(|(name, block)| appended.element("UInt8", name, 1, block.into())).collect();
    of_cells += &appended.arrays(&part.of_cells)?;
    write!(
        file,
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"{BYTE_ORDER}\" \
         header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n<UnstructuredGrid>\n<FieldData>\n\
         <DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{time_us}</DataArray>\n\
         </FieldData>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n<Points>\n{points}</Points>\n<Cells>\n{cells}</Cells>\n\
         <PointData>\n{of_points}</PointData>\n<CellData>\n{of_cells}</CellData>\n</Piece>\n</UnstructuredGrid>\n\
         <AppendedData encoding=\"raw\">\n_",
        fixed.points, fixed.cells
    )?;
    appended.blocks.iter().try_for_each(|block| file.write_all(block))?;
    file.write_all(b"\n</AppendedData>\n</VTKFile>\n")
}
