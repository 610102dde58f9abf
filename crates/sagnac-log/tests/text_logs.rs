//! Text logs and numpy arrays: what is read, and what is refused with one sentence.
#![allow(clippy::unwrap_used, reason = "tests")]

use std::fmt::Write as _;
use std::io::Write as _;

use sagnac_log::{Error, Log, ReadOptions, Source, Stamp, WriteFormat, create, read};

const G: f64 = 9.80665;

fn options(columns: &str) -> ReadOptions {
    ReadOptions {
        columns: Some(columns.into()),
        ..ReadOptions::default()
    }
}

fn text(text: &str) -> Result<Log, Error> {
    read(
        Source::memory("a.csv", text.into()),
        &ReadOptions::default(),
    )
}

fn with(text: &str, options: &ReadOptions) -> Result<Log, Error> {
    read(Source::memory("a.csv", text.as_bytes().to_vec()), options)
}

/// Every error has to be one short sentence without full stop; usage errors and data errors are told apart.
fn check_error(result: Result<Log, Error>, usage: bool, part: &str) {
    let e = result.unwrap_err();
    let s = e.to_string();
    assert!(s.contains(part), "`{s}` does not hold `{part}`");
    assert!(!s.ends_with('.') && !s.contains('\n'), "{s}");
    assert!(
        s.chars()
            .next()
            .is_some_and(|c| !c.is_uppercase() || s.starts_with("ROS")),
        "{s}"
    );
    assert_eq!(e.is_usage(), usage, "{s}");
    if !usage {
        assert!(
            e.place().is_some_and(|p| p.starts_with("a.csv")),
            "{s}: {:?}",
            e.place()
        );
    }
}

#[test]
fn own_csv_reads_any_subset_and_order() {
    let log = text("gyro_z [deg/s],time [ms],temperature [K],status,accel_x [g]\n180,10,300,7,1\n90,20,301,8,2\n").unwrap();
    assert_eq!(log.rows, 2);
    assert_eq!(log.channel("gyro_z").unwrap()[0], std::f64::consts::PI);
    assert!((log.channel("temperature").unwrap()[0] - 26.85).abs() < 1e-12);
    assert_eq!(log.channel("status").unwrap(), [7.0, 8.0]);
    assert_eq!(log.channel("accel_x").unwrap()[1], 2.0 * G);
    assert_eq!(log.stamps.get(1), Some(Stamp::Nanoseconds(20_000_000)));
    assert!((log.dt_s().unwrap() - 0.01).abs() < 1e-15);
}

#[test]
fn dialects_are_found() {
    for body in [
        "1,10,20,30\n2,11,21,31\n3,12,22,32\n",
        "1;10;20;30\n2;11;21;31\n3;12;22;32\n",
        "1\t10\t20\t30\n2\t11\t21\t31\n3\t12\t22\t32\n",
        " 1 10  20 30\n 2 11  21 31 \n3 12 22 32",
        "1, 10, 20, 30\r\n2, 11, 21, 31\r\n3, 12, 22, 32\r\n",
        "# made by hand\n1,10,20,30\n% more\n2,11,21,31\n\n3,12,22,32\n",
        "t,a,b,c\n1,10,20,30\n2,11,21,31\n3,12,22,32\n",
        "Fs,100\nLogging Type,1\nt,a,b,c\n1,10,20,30\n2,11,21,31\n3,12,22,32\n",
        "\u{feff}t,a,b,c\n1,10,20,30\n2,11,21,31\n3,12,22,32\n",
        "# t a b c\n1 10 20 30\n2 11 21 31\n3 12 22 32\n",
        "\"t\",\"a, of it\",\"b\",\"c\"\n\"1\",\"10\",20,30\n2,11,21,31\n3,12,22,32\n",
    ] {
        let log = with(body, &options("time=0:s, gyro=1,2,3:rad/s")).unwrap();
        assert_eq!(log.channel("gyro_x").unwrap(), [10.0, 11.0, 12.0], "{body}");
        assert_eq!(log.channel("gyro_z").unwrap(), [30.0, 31.0, 32.0], "{body}");
    }
    let log = with(
        "# t,\"a\"\n1,2\n3,4\n",
        &options("time=t:s, gyro_x=a:rad/s"),
    )
    .unwrap();
    assert_eq!(log.rows, 2);
}

#[test]
fn names_and_label_columns_are_understood() {
    let body = "state,t,\"g:x\",gy\nS,0,1,2\nM,1,3,4\n";
    let log = with(
        body,
        &options("time=t:s, gyro_x=\"g:x\":deg/s, gyro_y=gy:deg/s"),
    )
    .unwrap();
    assert_eq!(log.rows, 2);
    let body = "x_a,1028,-2052.0,1\nx_a,1029,-2059.0,2\n";
    let log = with(body, &options("time=1:ms, accel_x=2:g")).unwrap();
    assert_eq!(log.rows, 2);
    check_error(
        with(body, &options("time=1:ms, accel_x=0:g")),
        false,
        "text",
    );
}

#[test]
fn decimal_commas_are_refused() {
    for body in [
        "t;a\n0;1,5\n1;2,5\n",
        "0,0\t1,5\n0,1\t2,5\n",
        "0,0 1,5\n0,1 2,5\n",
    ] {
        check_error(
            with(body, &options("time=0:s, gyro_x=1:deg/s")),
            false,
            "decimal comma",
        );
    }
}

#[test]
fn counts_increments_and_phases_become_rates() {
    let log = with(
        "2,4\n2,6\n",
        &ReadOptions {
            rate_hz: Some(100.0),
            ..options("gyro_x=0:0.05 deg/s, accel_x=1:125 ug*s")
        },
    )
    .unwrap();
    assert!((log.channel("gyro_x").unwrap()[0] - 0.1f64.to_radians()).abs() < 1e-17);
    assert!((log.channel("accel_x").unwrap()[0] - 4.0 * 125e-6 * G * 100.0).abs() < 1e-15);
    assert!(
        log.layout.notes.iter().any(|n| n.contains("divided by dt")),
        "{:?}",
        log.layout.notes
    );
    let log = with(
        "0,0,1\n1,0.5,1\n2,1.5,1\n3,1.5,1\n",
        &options("time=0:s, angle_x=1:rad, accel_x=2:g"),
    )
    .unwrap();
    assert_eq!(log.channel("gyro_x").unwrap(), [0.5, 1.0, 0.0]);
    assert_eq!(log.rows, 3);
    assert_eq!(log.stamps.get(0), Some(Stamp::Nanoseconds(1_000_000_000)));
    // Without a rate the whole log tells dt.
    let log = text("time [s],gyro_x [deg]\n0,1\n0.5,1\n1,1\n").unwrap();
    assert!((log.channel("gyro_x").unwrap()[2] - 2f64.to_radians()).abs() < 1e-15);
}

#[test]
fn dates_and_long_stamps_lose_nothing() {
    let log = with(
        "2025-06-14 21:17:02+00:00,1\n2025-06-14 21:17:03+00:00,2\n",
        &options("time=0:iso, gyro_x=1:deg/s"),
    )
    .unwrap();
    assert_eq!(
        log.stamps.get(1),
        Some(Stamp::Nanoseconds(1_749_935_823_000_000_000))
    );
    let euroc = "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n1520530308181901469,1,2,3,4,5,6\n1520530308186917469,1,2,3,4,5,9";
    let log = text(euroc).unwrap();
    assert_eq!(log.layout.format, "EuRoC data.csv");
    assert_eq!(
        log.stamps.get(0),
        Some(Stamp::Nanoseconds(1_520_530_308_181_901_469))
    );
    assert_eq!(log.channel("accel_z").unwrap(), [6.0, 9.0]);
    let again = text(&written(&log, WriteFormat::Csv)).unwrap();
    assert_eq!(again.stamps, log.stamps);
}

#[test]
fn start_end_axes_and_rate_are_applied() {
    let body = "time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s]\n10,1,2,3\n11,4,5,6\n12,7,8,9\n13,1,1,1\n";
    let o = ReadOptions {
        start_s: Some(1.0),
        end_s: Some(3.0),
        axes: Some("x=-y, y=x, z=z".into()),
        ..ReadOptions::default()
    };
    let log = with(body, &o).unwrap();
    assert_eq!(log.rows, 2);
    assert_eq!(log.channel("gyro_x").unwrap(), [-5.0, -8.0]);
    assert_eq!(log.channel("gyro_y").unwrap(), [4.0, 7.0]);
    let late = ReadOptions {
        start_s: Some(100.0),
        ..ReadOptions::default()
    };
    check_error(with(body, &late), false, "no sample lies between");
    let log = with(
        body,
        &ReadOptions {
            rate_hz: Some(50.0),
            ..ReadOptions::default()
        },
    )
    .unwrap();
    assert_eq!(log.dt_s().unwrap(), 0.02);
    let o = ReadOptions {
        start_s: Some(0.02),
        rate_hz: Some(100.0),
        ..options("gyro_x=0:rad/s")
    };
    assert_eq!(
        with("1\n2\n3\n4\n", &o).unwrap().channel("gyro_x").unwrap(),
        [3.0, 4.0]
    );
}

#[test]
fn what_is_wrong_is_one_sentence() {
    let head = "time [s],gyro_x [deg/s]\n";
    check_error(text(""), false, "empty");
    check_error(text("\n\n"), false, "empty");
    check_error(text("# nothing\n"), false, "comments only");
    check_error(text(head), false, "no rows");
    check_error(text("time [s],gyro_x [deg/s]"), false, "no rows");
    check_error(
        text(&format!("{head}0,1\n1,x\n")),
        false,
        "`x` in row 2 is not a number",
    );
    check_error(
        text(&format!("{head}0,1\n1\n")),
        false,
        "row 2 has 1 cell where the header has 2",
    );
    check_error(
        text(&format!("{head}0,1\n1,2,3\n")),
        false,
        "row 2 has 3 cells",
    );
    check_error(text(&format!("{head}0,1\n,2\n")), false, "no time");
    check_error(
        text("time [s],gyro_x [dps2]\n0,1\n"),
        false,
        "the unit of column `gyro_x` is not known",
    );
    check_error(
        text("time [s],gyro_x [m/s]\n0,1\n"),
        false,
        "expected an angular rate",
    );
    check_error(text("time [s],gyro_x\n0,1\n"), false, "unit");
    check_error(
        text("time [s],gyro_x [deg/s],gyro_x [deg/s]\n0,1,2\n"),
        false,
        "two columns are called `gyro_x`",
    );
    check_error(
        text("gx,gy,gz\n1,2,3\n"),
        false,
        "no column of the log is a channel",
    );
    check_error(text("gyro_x [deg/s]\n1\n"), false, "no time and no rate");
    check_error(
        with("1,2\n3,4\n", &options("time=0:s, gyro_x=7:deg/s")),
        false,
        "column 7",
    );
    check_error(
        with("a,b\n3,4\n", &options("time=a:s, gyro_x=c:deg/s")),
        false,
        "no column `c`",
    );
    check_error(
        with("1,2\n3,4\n", &options("time=0:s, gyro_x=1:m")),
        true,
        "expected an angular rate",
    );
    check_error(
        with("1,2\n3,4\n", &options("time=0, gyro_x=1:deg/s")),
        true,
        "unit of `time`",
    );
    check_error(
        with("1,2\n3,4\n", &options("time=0:s")),
        true,
        "no channel besides time",
    );
    check_error(
        with(
            "1,2\n",
            &ReadOptions {
                rate_hz: Some(-1.0),
                ..options("gyro_x=1:deg/s")
            },
        ),
        true,
        "rate",
    );
    check_error(
        with(
            "1,2\n",
            &ReadOptions {
                topic: Some("/imu".into()),
                ..options("gyro_x=1:deg/s")
            },
        ),
        true,
        "topic",
    );
    check_error(
        read(
            Source::memory("a.csv", vec![0, 1, 2, 3, 255]),
            &ReadOptions::default(),
        ),
        false,
        "format is not known",
    );
    check_error(
        read(
            Source::memory("a.csv", (0..=255).cycle().take(9999).collect()),
            &ReadOptions::default(),
        ),
        false,
        "format is not known",
    );
    let cut = Log::dt_s(&text(&format!("{head}5,1\n5,2\n5,3\n")).unwrap()).unwrap_err();
    assert!(cut.to_string().contains("never advances"), "{cut}");
    // |f| near one suggests g.
    let e = with("0,0,0,1\n1,0,0,1.01\n", &options("time=0:s, accel=1,2,3")).unwrap_err();
    assert!(
        e.advice().unwrap().contains("as if in g"),
        "{e} {:?}",
        e.advice()
    );
}

#[test]
fn missing_values_and_infinities_are_kept_as_such() {
    let log = text("time [s],gyro_x [rad/s]\n0,\n1,nan\n2,-inf\n3,1\n").unwrap();
    let x = log.channel("gyro_x").unwrap();
    assert!(x[0].is_nan() && x[1].is_nan() && x[2] == f64::NEG_INFINITY && x[3] == 1.0);
}

#[test]
fn rows_are_counted_over_chunks_and_threads() {
    let mut body = String::from("time [s],gyro_x [deg/s]\n");
    for k in 0..100_000 {
        let _ = writeln!(body, "{k}.5,{}.25", k % 77);
    }
    for threads in [1, 2, 4] {
        let o = ReadOptions {
            threads,
            ..ReadOptions::default()
        };
        let log = with(&body, &o).unwrap();
        assert_eq!(log.rows, 100_000);
        assert_eq!(log.stamps.get(99_999).unwrap().seconds(), 99_999.5);
        let bad = body.clone() + "7\n";
        let e = with(&bad, &o).unwrap_err();
        assert_eq!(
            e.to_string(),
            "row 100 001 has 1 cell where the header has 2"
        );
        assert_eq!(e.place().unwrap(), "a.csv, line 100 002");
    }
}

#[test]
fn packed_text_is_read_and_cut_text_refused() {
    let body = b"time [s],gyro_x [rad/s]\n0,1\n1,2\n2,3\n".to_vec();
    let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::new(6));
    gz.write_all(&body).unwrap();
    let gz = gz.finish().unwrap();
    let log = read(Source::memory("a.csv", gz.clone()), &ReadOptions::default()).unwrap();
    assert_eq!(
        (log.rows, log.layout.format.as_str()),
        (3, "CSV with a header, gzip")
    );
    check_error(
        read(
            Source::memory("a.csv", gz[..gz.len() - 5].to_vec()),
            &ReadOptions::default(),
        ),
        false,
        "cut off",
    );
    let zst = zstd::encode_all(&body[..], 3).unwrap();
    assert_eq!(
        read(
            Source::memory("a.csv", zst.clone()),
            &ReadOptions::default()
        )
        .unwrap()
        .rows,
        3
    );
    check_error(
        read(
            Source::memory("a.csv", zst[..zst.len() - 3].to_vec()),
            &ReadOptions::default(),
        ),
        false,
        "zstd",
    );
}

fn npy(descr: &str, fortran: bool, shape: &str, data: &[u8]) -> Vec<u8> {
    let order = if fortran { "True" } else { "False" };
    let dict = format!("{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}\n");
    let mut out = b"\x93NUMPY\x01\x00".to_vec();
    out.extend((dict.len() as u16).to_le_bytes());
    out.extend(dict.as_bytes());
    out.extend(data);
    out
}

#[test]
fn numpy_arrays_are_read() {
    let o = |rate| ReadOptions {
        rate_hz: Some(rate),
        ..options("gyro_x=0:rad/s, gyro_y=1:rad/s")
    };
    let c: Vec<u8> = [1.0_f64, 2.0, 3.0, 4.0, 5.0, 6.0]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let log = read(
        Source::memory("a.npy", npy("'<f8'", false, "(3, 2)", &c)),
        &o(10.0),
    )
    .unwrap();
    assert_eq!(
        (
            log.channel("gyro_x").unwrap(),
            log.channel("gyro_y").unwrap()
        ),
        (&[1.0, 3.0, 5.0][..], &[2.0, 4.0, 6.0][..])
    );
    for stream in [false, true] {
        let bytes = npy(
            "'>i2'",
            true,
            "(3, 2)",
            &[0, 1, 0, 2, 0, 3, 255, 255, 0, 5, 0, 6],
        );
        let source = if stream {
            Source::stream("a.npy", std::io::Cursor::new(bytes))
        } else {
            Source::memory("a.npy", bytes)
        };
        let log = read(source, &o(10.0)).unwrap();
        assert_eq!(
            (
                log.channel("gyro_x").unwrap(),
                log.channel("gyro_y").unwrap()
            ),
            (&[1.0, 2.0, 3.0][..], &[-1.0, 5.0, 6.0][..])
        );
    }
    check_error(
        read(
            Source::memory("a.csv", npy("'<f8'", false, "(1000000000000, 2)", &c)),
            &o(10.0),
        ),
        false,
        "promises 1 000 000 000 000 rows",
    );
    let stream = Source::stream(
        "a.csv",
        std::io::Cursor::new(npy("'<f8'", false, "(1000000000000, 2)", &c)),
    );
    check_error(
        read(stream, &o(10.0)),
        false,
        "promises 1 000 000 000 000 rows",
    );
    check_error(
        read(
            Source::memory("a.csv", npy("'<f8'", false, "(0, 2)", &[])),
            &o(10.0),
        ),
        false,
        "no rows",
    );
    check_error(
        read(
            Source::memory("a.csv", npy("'<c16'", false, "(3, 2)", &c)),
            &o(10.0),
        ),
        false,
        "type `<c16`",
    );
    check_error(
        read(Source::memory("a.csv", b"\x93NUMPY\x01".to_vec()), &o(10.0)),
        false,
        "cut off",
    );
    let one = read(
        Source::memory("a.npy", npy("'<f8'", false, "(6,)", &c)),
        &ReadOptions {
            rate_hz: Some(1.0),
            ..options("gyro_x=0:rad/s")
        },
    )
    .unwrap();
    assert_eq!(one.rows, 6);
}

/// What the writer makes of a log, as text (or bytes read as Latin-1).
fn written(log: &Log, format: WriteFormat) -> String {
    bytes(log, format).iter().map(|&b| b as char).collect()
}

fn bytes(log: &Log, format: WriteFormat) -> Vec<u8> {
    let file = tempfile::tempfile().unwrap();
    let mut writer = create(format, Box::new(file.try_clone().unwrap()), &log.layout).unwrap();
    for block in log.blocks() {
        writer.write_block(&block).unwrap();
    }
    writer.finish().unwrap();
    let mut out = Vec::new();
    let mut file = file;
    std::io::Seek::rewind(&mut file).unwrap();
    std::io::Read::read_to_end(&mut file, &mut out).unwrap();
    out
}

#[test]
fn what_is_written_reads_back_to_the_same_bits() {
    let mut body =
        String::from("time [s],gyro_x [rad/s],accel_z [m/s^2],temperature [degC],pressure [hPa]\n");
    let mut x: u64 = 88_172_645_463_325_252;
    for k in 0..5000 {
        let mut next = || {
            x ^= x << 13;
            x ^= x >> 7;
            x ^= x << 17;
            f64::from_bits((x & 0x000F_FFFF_FFFF_FFFF) | ((1000 + x % 60) << 52))
        };
        let (a, b, c, d) = (next(), next(), next(), next());
        let _ = writeln!(body, "{},{a:e},{b},{c},{d}", f64::from(k) / 3.0);
    }
    let log = text(&body).unwrap();
    for format in [
        WriteFormat::Csv,
        WriteFormat::CsvGzip,
        WriteFormat::CsvZstd,
        WriteFormat::Npy,
    ] {
        let again = read(
            Source::memory("b", bytes(&log, format)),
            &ReadOptions::default(),
        )
        .unwrap();
        assert_eq!(again.columns, log.columns, "{format:?}");
        assert_eq!(again.layout.channels, log.layout.channels);
        for k in 0..log.rows {
            assert_eq!(
                again.stamps.get(k).unwrap().seconds(),
                log.stamps.get(k).unwrap().seconds()
            );
        }
    }
}

#[test]
fn numpy_times_count_from_the_first_sample_where_f64_would_lose() {
    let log =
        text("time [ns],gyro_x [rad/s]\n1520530308181901469,1\n1520530308186917470,2\n").unwrap();
    let again = read(
        Source::memory("b", bytes(&log, WriteFormat::Npy)),
        &ReadOptions::default(),
    )
    .unwrap();
    assert_eq!(again.stamps.get(0).unwrap().seconds(), 0.0);
    assert!((again.stamps.get(1).unwrap().seconds() - 0.005016001).abs() < 1e-12);
}

#[test]
fn rows_that_end_by_a_comma_have_no_further_column() {
    let rows: String = (0..600).map(|k| format!("{k},{k},\n")).collect();
    let log = text(&format!("time [s],gyro_x [rad/s],\n{rows}")).unwrap();
    assert_eq!(log.layout.channels.len(), 1);
    // A column with a name, or with a value, is one.
    for (head, row) in [
        ("time [s],gyro_x [rad/s],flag", "0,1,"),
        ("time [s],gyro_x [rad/s],", "0,1,2"),
    ] {
        let log = text(&format!("{head}\n{row}\n1,1,\n")).unwrap();
        assert_eq!(log.layout.channels.len(), 2, "{head}");
    }
}

#[test]
fn capitals_are_read_with_units_and_told_without() {
    let log = text("Time [s],Gyro_X [rad/s],GYRO_Y [rad/s]\n0,1,2\n1,3,4\n").unwrap();
    assert_eq!(log.channel("gyro_y").unwrap(), [2.0, 4.0]);
    assert_eq!(log.stamps.len(), 2);
    for (head, hint) in [
        (
            "Time,gyro_x [rad/s]",
            "column `Time` with its unit, time [s]",
        ),
        ("Time,Gyro_X", "--columns 'time=0:s"),
    ] {
        let error = text(&format!("{head}\n0,1\n1,2\n")).unwrap_err();
        let advice = error.advice().unwrap();
        assert!(advice.contains(hint), "{error}: {advice}");
    }
}

#[test]
fn a_log_without_rows_is_named() {
    check_error(
        text("time [s],gyro_x [rad/s]\n\n"),
        false,
        "the log has no samples",
    );
}

#[test]
fn a_transposed_array_is_told() {
    let data = vec![0_u8; 8 * 6 * 400];
    let options = ReadOptions {
        rate_hz: Some(100.0),
        ..options("gyro=0,1,2:rad/s")
    };
    let file = |shape: &str| Source::memory("a.npy", npy("'<f8'", false, shape, &data));
    let error = read(file("(6, 400)"), &options).unwrap_err();
    assert!(error.advice().unwrap().contains("save array.T"), "{error}");
    assert_eq!(read(file("(400, 6)"), &options).unwrap().rows, 400);
}
