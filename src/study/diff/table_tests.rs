#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
use super::*;

fn table_of(text: &str) -> TimeSeries {
    read(text.as_bytes(), &[]).unwrap()
}

fn error(text: &str) -> StudyError {
    read(text.as_bytes(), &[]).unwrap_err()
}

#[test]
fn all_usual_forms_of_csv_are_the_same_table() {
    let plain = table_of("time_us,velocity_m_s,gauge 1\n0,155,1\n0.5,154.5,\n1,-1e-3,3\n");
    assert_eq!(plain.times, [0.0, 0.5, 1.0]);
    assert_eq!(
        plain.columns[0],
        TableColumn { name: "projectile_velocity_m_s".into(), values: vec![155.0, 154.5, -1e-3] }
    );
    assert_eq!(plain.points(&plain.columns[1]), [[0.0, 1.0], [1.0, 3.0]]);
    assert_eq!(plain.notes.len(), 1, "{:?}", plain.notes);
    let others = [
        "\u{feff}time_us,velocity_m_s,gauge 1\r\n0,155,1\r\n0.5,154.5,\r\n1,-1e-3,3",
        "\u{feff}# a, b, c, d\n\n\"Time (ms)\";\"Velocity [m/s]\"; \"gauge 1\"\n0;155;1\n\n5e-4; 154.5;NaN\n# done\n1e-3;-1e-3;\"3\"\n;;\n",
        "time_s\tvelocity_km_s\tgauge 1\r0\t.155\t1\r5e-7\t0.1545\t\r1e-6\t-1e-6\t3\r",
    ];
    for text in others {
        let table = table_of(text);
        assert_eq!(table.columns[0].name, plain.columns[0].name);
        let both = |table: &TimeSeries| [table.times.clone(), table.columns[0].values.clone()].concat();
        for (a, b) in both(&table).iter().zip(both(&plain)) {
            assert!((a - b).abs() < 1e-12, "{a} {b} in {text}");
        }
        assert_eq!(table.points(&table.columns[1]).len(), 2, "{text}");
    }
}

#[test]
fn each_damage_is_named_with_its_line() {
    let cases = [
        ("", "", "an empty file"),
        ("\u{feff}# only words\n", "", "an empty file"),
        ("time_us,v\n", "", "a heading alone"),
        ("0,155\n1,150\n", "line 1", "\"0\", \"155\""),
        ("a,b\n1,2\n", "line 1", "\"a\", \"b\""),
        ("time_us,time_ms\n1,2\n", "line 1", "\"time_us\", \"time_ms\""),
        ("time_us,v,v\n1,2,3\n", "line 1", "\"v\" twice"),
        ("time_us,velocity_m_s,velocity_km_s\n1,2,3\n", "line 1", "\"velocity_m_s\", \"velocity_km_s\""),
        ("# x\n\ntime_us,v\n0,1\n# y\n\n1,2,3\n", "line 7", "3"),
        ("time_us,v\n0,1\n1\n", "line 3", "1"),
        ("time_us,velocity_m_s\nus,m/s\n0,1\n", "line 2, column \"time_us\"", "\"us\""),
        ("time_us;velocity_m_s\n0;1\n1;155,5\n", "line 3, column \"velocity_m_s\"", "\"155,5\""),
        ("time_us;v\n0;1\n1;155,5\n", "line 3, column \"v\"", "\"155,5\""),
        ("time_us,v\n0,1\n\n0,2\n", "line 4, column \"time_us\"", "0 µs"),
        ("time_us,v\r\n0,1\r\n0,2\r\n", "line 3, column \"time_us\"", "0 µs"),
        ("time_us,v\n1,1\n0.5,2\n", "line 3, column \"time_us\"", "0.5 µs"),
        ("time_us,v\n0,1\n,2\n", "line 3, column \"time_us\"", "none"),
        ("time_us,v\n0,1\nNaN,2\n", "line 3, column \"time_us\"", "none"),
        ("time_us,v\n0,1\ninf,2\n", "line 3, column \"time_us\"", "inf"),
        ("time_us,v\n0,1\n1,-inf\n", "line 3, column \"v\"", "\"-inf\""),
        ("time_us,v\n0,1\n1,1e101\n", "line 3, column \"v\"", "\"1e101\""),
        ("time_us,v\n0,1\n1,2\0\n", "line 3", "the byte 0x00"),
    ];
    for (text, place, found) in cases {
        let error = error(text);
        assert_eq!((error.place.as_str(), error.found.as_str()), (place, found), "{text:?}");
        assert!(!error.help.is_empty());
    }
    assert!(error("time_us;v\n0;1\n1;155,5\n").help.contains("decimal point"));
    assert!(error("time_us,v\n0,1,5\n").help.contains("decimal point"));
    assert_eq!(read(b"time_us,v\n0,\xff", &[]).unwrap_err().found, "the byte 0xFF");
}

#[test]
fn a_column_of_words_is_left_out_and_said() {
    let table = table_of("time_us,v,remark\n0,1,trigger\n1,2,\n");
    assert_eq!(table.columns.len(), 1);
    assert_eq!(table.notes, ["column \"remark\" is left out: line 2 holds \"trigger\""]);
}

#[test]
fn a_heading_over_two_lines_is_one() {
    let table = table_of("\"Time\n(ms)\",\"a\u{1b}  gauge\"\n0,1\n1,2\n");
    assert_eq!((table.times.as_slice(), table.columns[0].name.as_str()), (&[0.0, 1e3][..], "a gauge"));
    let error = error("\"Time\n(ms)\",v\n0,1\n0,2\n");
    assert_eq!(error.place, "line 4, column \"Time (ms)\"");
}

#[test]
fn size_is_bounded() {
    let wide = format!("time_us{}\n", ",x".repeat(MAX_COLUMNS));
    assert_eq!(error(&wide).found, (MAX_COLUMNS + 1).to_string());
    let long: String = (0..=MAX_ROWS).map(|n| format!("{n}\n")).collect();
    assert_eq!(error(&format!("time_us\n{long}")).place, format!("line {}", MAX_ROWS + 2));
}
