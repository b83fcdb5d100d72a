//! Tables as Parquet, for those who read thousands of shots: the same cells as in the CSV table beside it, with their types, and units in the
//! metadata of the file. Only with the feature `parquet`.

use std::collections::BTreeMap;
use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::{ParquetError, Result};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;

use super::{Folder, OutputError};

/// Columns of whole numbers.
const WHOLE: [&str; 10] =
    ["point", "shot", "shots", "failed", "non_monotone", "perforated", "count", "failed_warp", "failed_weft", "steps"];
/// Columns of words.
const WORDS: [&str; 3] = ["outcome", "trust", "reason"];
/// Ends of names, and the units that they stand for; the longer ones first.
const UNITS: [(&str, &str); 22] = [
    ("_mm_n13", "mm·N^(1/3)"),
    ("_per_inch", "1/inch"),
    ("_n_per_m", "N/m"),
    ("_kg_m3", "kg/m³"),
    ("_per_cm", "1/cm"),
    ("_denier", "denier"),
    ("_g_m2", "g/m²"),
    ("_rad_s", "rad/s"),
    ("_dtex", "dtex"),
    ("_tex", "tex"),
    ("_m_s", "m/s"),
    ("_gpa", "GPa"),
    ("_mpa", "MPa"),
    ("_deg", "°"),
    ("_mm", "mm"),
    ("_us", "µs"),
    ("_kg", "kg"),
    ("_g", "g"),
    ("_j", "J"),
    ("_n", "N"),
    ("_m", "m"),
    ("_s", "s"),
];
/// The unit of what has none.
const NONE: &str = "1";

/// Cells of a column; an empty cell holds nothing.
#[derive(Debug)]
enum Cells {
    Whole(Vec<Option<i64>>),
    Numbers(Vec<Option<f64>>),
    Words(Vec<Option<ByteArray>>),
}

/// Writes a table of results a second time, as Parquet.
///
/// # Errors
/// When the disk refuses.
pub(crate) fn put(folder: &Folder, name: &str, csv: &str) -> std::result::Result<(), OutputError> {
    let failed = |error: ParquetError| OutputError::new(&folder.path().join(name), "a table", error);
    folder.put(&[(name, table(csv).map_err(failed)?)], &[]).map(drop)
}

/// The bytes of a file with the cells of a CSV table.
fn table(csv: &str) -> Result<Vec<u8>> {
    let mut reader = csv::ReaderBuilder::new().from_reader(csv.as_bytes());
    let other = |error: csv::Error| ParquetError::External(Box::new(error));
    let names: Vec<String> = reader.headers().map_err(other)?.iter().map(str::to_owned).collect();
    let records = reader.records().collect::<std::result::Result<Vec<_>, _>>().map_err(other)?;
    let column = |(n, name): (usize, &String)| {
        Cells::new(name, &records.iter().map(|record| record.get(n).unwrap_or_default()).collect::<Vec<_>>())
    };
    let columns: Vec<Cells> = names.iter().enumerate().map(column).collect();
    let fields = names.iter().zip(&columns).map(|(name, cells)| cells.field(name).map(Arc::new));
    let schema = Type::group_type_builder("table").with_fields(fields.collect::<Result<_>>()?).build()?;
    let numbers = names.iter().zip(&columns).filter(|(_, cells)| !matches!(cells, Cells::Words(_)));
    let units: BTreeMap<&str, &str> = numbers.map(|(name, _)| (name.as_str(), unit(name))).collect();
    let units = serde_json::to_string(&units).map_err(|error| ParquetError::External(Box::new(error)))?;
    let metadata = [("units", units), ("ripstop", env!("CARGO_PKG_VERSION").to_owned())];
    let metadata = metadata.map(|(key, value)| KeyValue::new(key.to_owned(), value)).to_vec();
    let properties = WriterProperties::builder().set_key_value_metadata(Some(metadata)).build();
    let mut bytes = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut bytes, Arc::new(schema), Arc::new(properties))?;
    let mut rows = writer.next_row_group()?;
    for cells in &columns {
        match cells {
            Cells::Whole(cells) => write::<Int64Type>(&mut rows, cells)?,
            Cells::Numbers(cells) => write::<DoubleType>(&mut rows, cells)?,
            Cells::Words(cells) => write::<ByteArrayType>(&mut rows, cells)?,
        }
    }
    rows.close()?;
    writer.close()?;
    Ok(bytes)
}

fn unit(name: &str) -> &'static str {
    UNITS.iter().find(|(end, _)| name.ends_with(end)).map_or(NONE, |(_, unit)| unit)
}

/// The next column of a group of rows.
fn write<T: DataType>(rows: &mut SerializedRowGroupWriter<'_, &mut Vec<u8>>, cells: &[Option<T::T>]) -> Result<()> {
    let Some(mut column) = rows.next_column()? else { return Ok(()) };
    let filled: Vec<i16> = cells.iter().map(|cell| i16::from(cell.is_some())).collect();
    let values: Vec<T::T> = cells.iter().flatten().cloned().collect();
    column.typed::<T>().write_batch(&values, Some(&filled), None)?;
    column.close()
}

impl Cells {
    fn new(name: &str, cells: &[&str]) -> Self {
        let words = || Self::Words(cells.iter().map(|cell| Some(ByteArray::from(*cell))).collect());
        if WORDS.contains(&name) {
            return words();
        }
        if WHOLE.contains(&name) {
            return Self::Whole(cells.iter().map(|cell| cell.parse().ok()).collect());
        }
        // A key that is varied may have words for values.
        let number = |cell: &&str| if cell.is_empty() { Some(None) } else { cell.parse().ok().map(Some) };
        cells.iter().map(number).collect::<Option<Vec<_>>>().map_or_else(words, Self::Numbers)
    }

    fn field(&self, name: &str) -> Result<Type> {
        let (physical, logical) = match self {
            Self::Whole(_) => (Physical::INT64, None),
            Self::Numbers(_) => (Physical::DOUBLE, None),
            Self::Words(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        };
        let builder = Type::primitive_type_builder(name, physical).with_repetition(Repetition::OPTIONAL);
        builder.with_logical_type(logical).build()
    }
}

#[cfg(test)]
#[path = "parquet_tests.rs"]
mod tests;
