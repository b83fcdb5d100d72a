use std::io::Write as _;

use super::*;
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::record::Field;

#[test]
fn a_table_reads_back_with_its_types_and_units() {
    let csv = "shot,velocity_m_s,offset_x_mm,outcome,reason,/pack/edges\n0,180.25,,stopped,\"a, b\",free\n1,200,-1e-3,failed,,clamped\n";
    let bytes = table(csv).unwrap_or_else(|error| unreachable!("{error}"));
    let mut file = tempfile::tempfile().unwrap_or_else(|error| unreachable!("{error}"));
    assert!(file.write_all(&bytes).is_ok());
    let reader = SerializedFileReader::new(file).unwrap_or_else(|error| unreachable!("{error}"));
    let metadata = reader.metadata().file_metadata();
    let units = metadata.key_value_metadata().and_then(|all| all.iter().find(|pair| pair.key == "units"));
    let units = units.and_then(|pair| pair.value.clone());
    assert_eq!(units.as_deref(), Some(r#"{"offset_x_mm":"mm","shot":"1","velocity_m_s":"m/s"}"#));
    let rows: Vec<_> = reader.get_row_iter(None).into_iter().flatten().flatten().collect();
    let cell = |row: usize, column: usize| rows[row].get_column_iter().nth(column).map(|(_, field)| field.clone());
    assert_eq!((rows.len(), cell(0, 0), cell(1, 1)), (2, Some(Field::Long(0)), Some(Field::Double(200.0))));
    assert_eq!([cell(0, 2), cell(1, 2)], [Some(Field::Null), Some(Field::Double(-1e-3))]);
    assert_eq!(cell(0, 4), Some(Field::Str("a, b".to_owned())));
    assert_eq!([cell(1, 4), cell(1, 5)], ["", "clamped"].map(|word| Some(Field::Str(word.to_owned()))));
}

#[test]
fn names_end_in_their_units() {
    let of = ["v50_m_s", "absorbed_energy_j", "/fabric/warp/linear_density_denier", "warp_crimp", "yaw_deg"];
    assert_eq!(of.map(unit), ["m/s", "J", "denier", "1", "°"]);
    // A longer end is not taken for a shorter one.
    for (n, (end, _)) in UNITS.iter().enumerate() {
        assert!(UNITS[..n].iter().all(|(before, _)| !end.ends_with(before)), "{end}");
    }
}
