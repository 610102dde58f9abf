//! The readers and what they begin with.

use std::io::{Cursor, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use sagnac_log::{Folder, ReadOptions, ReadSeek, Source, WriteFormat, create};

/// Real files are cut to this: small inputs are many inputs.
const HEAD: usize = 24 << 10;

/// A reader, its seeds and its options.
pub(crate) struct Reader {
    pub(crate) name: &'static str,
    pub(crate) seeds: Vec<Vec<u8>>,
    pub(crate) options: ReadOptions,
    pub(crate) source: fn(Vec<u8>) -> Source,
}

fn file(bytes: Vec<u8>) -> Source {
    Source::memory("input", bytes)
}

fn pipe(bytes: Vec<u8>) -> Source {
    Source::stream("input", Cursor::new(bytes))
}

/// A KITTI folder of three samples, whose text the input is: dates before the first empty line, samples after it.
fn folder(bytes: Vec<u8>) -> Source {
    Source::folder("input", Oxts(bytes))
}

struct Oxts(Vec<u8>);

impl Folder for Oxts {
    fn names(&self) -> std::io::Result<Vec<String>> {
        let mut names: Vec<String> = (0..3).map(|k| format!("data/{k:010}.txt")).collect();
        names.push("timestamps.txt".to_owned());
        Ok(names)
    }

    fn open(&self, name: &str) -> std::io::Result<Box<dyn ReadSeek>> {
        let half = self.0.len() / 2;
        let bytes = if name.starts_with("data/") {
            &self.0[half..]
        } else {
            &self.0[..half]
        };
        Ok(Box::new(Cursor::new(bytes.to_vec())))
    }
}

#[derive(Clone, Default)]
struct Shared(Arc<Mutex<Cursor<Vec<u8>>>>);

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().map_or(Ok(0), |mut c| c.write(bytes))
    }
    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl Seek for Shared {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        self.0.lock().map_or(Ok(0), |mut c| c.seek(to))
    }
}

const CSV: &str = "time [s],gyro_x [rad/s],gyro_y [deg/s],gyro_z [rad/s],accel_x [g],accel_y [m/s^2],accel_z [m/s^2],temperature [degC]\n";

fn csv() -> Vec<u8> {
    let mut text = CSV.to_owned();
    for k in 0..20 {
        let t = f64::from(k) * 0.01;
        text += &format!("{t},{k},-{k}.5,1e-{k},0.1,-9.8,9.80665,25.{k}\n");
    }
    text.into_bytes()
}

/// The log of [`csv`] as one of our writers writes it.
fn written(format: WriteFormat) -> Option<Vec<u8>> {
    let log = sagnac_log::read(file(csv()), &ReadOptions::default()).ok()?;
    let out = Shared::default();
    let mut writer = create(format, Box::new(out.clone()), &log.layout).ok()?;
    for block in log.blocks() {
        writer.write_block(&block).ok()?;
    }
    writer.finish().ok()?;
    let bytes = out.0.lock().ok()?.get_ref().clone();
    Some(bytes)
}

fn mimu() -> Vec<u8> {
    let mut out = Vec::new();
    for k in 0..20_u16 {
        let mut packet = vec![0xAA];
        packet.extend(k.to_be_bytes());
        packet.push(100);
        packet.extend((u32::from(k) * 64_000).to_be_bytes());
        packet.extend((0..96_u16).map(|i| (i * k) as u8));
        let sum = packet.iter().map(|&b| u32::from(b)).sum::<u32>() as u16;
        packet.extend(sum.to_be_bytes());
        out.extend(packet);
    }
    out
}

fn gzip(bytes: &[u8]) -> Option<Vec<u8>> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(bytes).ok()?;
    encoder.finish().ok()
}

/// Files below a folder whose names end so, cut to a head.
fn files(folder: &Path, ends: &[&str], head: usize, out: &mut Vec<Vec<u8>>) {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    let mut paths: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            files(&path, ends, head, out);
        } else if ends.iter().any(|e| path.to_string_lossy().ends_with(e))
            && let Ok(mut bytes) = std::fs::read(&path)
        {
            bytes.truncate(head);
            out.push(bytes);
        }
    }
}

/// MCAP files, and each without the checksums of its chunks: a mutated chunk is not left out for its sum alone.
fn unchecked(mut files: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
    for k in 0..files.len() {
        let mut bytes = files[k].clone();
        let mut at = 8;
        while let Some(length) = bytes.get(at + 1..at + 9).and_then(|b| b.first_chunk()) {
            let length = u64::from_le_bytes(*length) as usize;
            if bytes[at] == 6
                && let Some(sum) = bytes.get_mut(at + 33..at + 37)
            {
                sum.fill(0);
            }
            at = at.saturating_add(length).saturating_add(9);
            if at >= bytes.len() {
                break;
            }
        }
        files.push(bytes);
    }
    files
}

/// All readers with their seeds.
pub(crate) fn readers() -> Vec<Reader> {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("../testdata");
    let real = std::env::var_os("SAGNAC_DATA").map(|root| Path::new(&root).join("formats"));
    let found = |ends: &[&str], more: Vec<Option<Vec<u8>>>| {
        let mut out: Vec<Vec<u8>> = more.into_iter().flatten().collect();
        files(&own, ends, usize::MAX, &mut out);
        if let Some(real) = &real {
            files(real, ends, HEAD, &mut out);
        }
        out
    };
    let options = |columns: &str| ReadOptions {
        columns: (!columns.is_empty()).then(|| columns.to_owned()),
        any_topic: true,
        threads: 1,
        ..ReadOptions::default()
    };
    let triads = "time=t:s, gyro=gyr:rad/s, accel=acc:m/s^2";
    let paths = "time=t:s, gyro=imu/gyr:rad/s, accel=imu/acc:m/s^2";
    let fields = "time=imu.t:s, gyro=imu.raw.gyr:rad/s, accel=imu.raw.acc:m/s^2";
    let text = [
        "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n1403636579758555392,-0.1,0.1,0.02,8.2,-0.03,-3.3\n1403636579763555584,-0.1,0.1,0.02,8.1,-0.04,-3.2\n",
        "preamble\n# comment\ntime [us];gyro_x [deg/s];accel_z [g]\n0;1.5;0.99\n5000;1.25;1.01\n",
    ];
    let text = text.map(|t| Some(t.as_bytes().to_vec()));
    let by_index = "time=0:s, gyro=1,2,3:rad/s, accel=4,5,6:g";
    let kitti = "2011-09-26 13:02:25.594360375\n2011-09-26 13:02:25.604360375\n2011-09-26 13:02:25.614360375\n                                          ";
    let sample = "49.01 8.43 116.4 0.03 0.009 -2.6 -6.8 -11.2 13.1 -0.1 -0.03 -0.4 0.04 10.2 -0.4 0.1 10.2 0.009 -0.02 -0.01 0 0 0 0.1 0.1 4 11 5 1 1";
    let reader = |name, columns: &str, seeds: Vec<Vec<u8>>, source: fn(Vec<u8>) -> Source| Reader {
        name,
        seeds,
        options: options(columns),
        source,
    };
    let [a, b] = text.clone();
    vec![
        reader("csv", "", found(&[], vec![Some(csv()), a, b]), file),
        reader(
            "csv by index",
            by_index,
            found(&["gx3_35.csv", "1hz.csv"], vec![Some(csv())]),
            file,
        ),
        reader("csv.gz", "", found(&[], vec![gzip(&csv())]), file),
        reader(
            "csv.zst",
            "",
            found(&[], vec![zstd::encode_all(csv().as_slice(), 1).ok()]),
            file,
        ),
        reader("npy", "", found(&[], vec![written(WriteFormat::Npy)]), file),
        reader("npz", "", found(&[], vec![written(WriteFormat::Npz)]), file),
        reader(
            "bag",
            "",
            found(&[".bag"], vec![written(WriteFormat::Bag)]),
            file,
        ),
        reader("bag, pipe", "", found(&[".bag"], vec![]), pipe),
        reader(
            "mcap",
            "",
            unchecked(found(&[".mcap"], vec![written(WriteFormat::Mcap)])),
            file,
        ),
        reader("mcap, pipe", "", found(&[".mcap"], vec![]), pipe),
        reader("db3", "", found(&[".db3"], vec![]), file),
        reader("ulog", "", found(&[".ulg"], vec![]), file),
        reader("dataflash", "", found(&[".bin", ".BIN"], vec![]), file),
        reader("mimu4444", "", found(&[], vec![Some(mimu())]), file),
        reader(
            "kitti",
            "",
            found(&[], vec![Some(format!("{kitti}{sample}").into_bytes())]),
            folder,
        ),
        reader(
            "mat",
            triads,
            found(&["plain.mat", "packed.mat", "big.mat"], vec![]),
            file,
        ),
        reader(
            "mat structs",
            fields,
            found(&["struct.mat", "struct_packed.mat"], vec![]),
            file,
        ),
        reader(
            "parquet",
            triads,
            found(&["snappy.parquet", "zstd.parquet", "v2.parquet"], vec![]),
            file,
        ),
        reader(
            "arrow",
            triads,
            found(&["plain.arrow", "lz4.arrow", "zstd.arrows"], vec![]),
            file,
        ),
        reader(
            "arrow lists",
            "time=time:s, gyro=gyr:rad/s, accel=gyr_x,gyr_y,gyr_z:m/s^2",
            found(&["lists.arrow"], vec![]),
            file,
        ),
        reader("hdf5", paths, found(&[".h5"], vec![]), file),
    ]
}
