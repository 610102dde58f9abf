//! The MIMU4444 array's binary: big-endian packets AA, number u16, length, time u32, eight IMUs of six i16, checksum.
//!
//! Accelerometer 2048 LSB/g, gyro 16.384 LSB/(°/s); time in ticks of 64 MHz, its wraps counted; checksum u16 the sum of
//! the bytes before it. Source: the array's data description and its checksums.

use std::io::Read;

use super::scan::Scan;
use super::table;
use crate::input::InputBytes;
use crate::map::raw::{Plan, RawLayout, RawReader};
use crate::text::grouped;
use crate::{Block, Error, ReadOptions, Topic};

const PACKET: usize = 106;
const IMUS: usize = 8;

/// True where the first bytes hold packets one after another.
pub(crate) fn recognize(head: &[u8]) -> bool {
    (0..16).any(|at| (0..3).all(|k| head.get(at + k * PACKET..).is_some_and(is_packet)))
}

fn is_packet(bytes: &[u8]) -> bool {
    bytes.len() >= PACKET
        && bytes[0] == 0xAA
        && bytes[3] == 100
        && bytes[..104].iter().map(|&b| u32::from(b)).sum::<u32>() as u16
            == u16::from_be_bytes([bytes[104], bytes[105]])
}

/// A stream of packets as a log of one of its IMUs.
pub(crate) struct Mimu {
    layout: RawLayout,
    scan: Scan,
    imu: usize,
    plan: Plan,
    ticks: Option<i64>,
    number: Option<u16>,
    lost: u64,
    stray: u64,
}

impl Mimu {
    pub(crate) fn open(
        bytes: InputBytes,
        packed: &str,
        options: &ReadOptions,
    ) -> Result<Self, Error> {
        let topics: Vec<Topic> = (1..=IMUS)
            .map(|i| Topic {
                name: i.to_string(),
                kind: "IMU of the array".to_owned(),
                messages: None,
                is_inertial: true,
            })
            .collect();
        let imu = table::choose(&topics, options, "IMU")?;
        let reader: Box<dyn Read + Send> = bytes.into_stream();
        let mut columns = vec![table::column("time", "us")];
        for (word, unit) in [("gyro", GYRO_UNIT), ("accel", ACCEL_UNIT)] {
            columns.extend(["x", "y", "z"].map(|a| table::column(&format!("{word}_{a}"), unit)));
        }
        Ok(Self {
            layout: RawLayout {
                format: format!("MIMU4444 array{packed}"),
                columns,
                has_names: true,
                topic: Some((imu + 1).to_string()),
                topics,
                frame: Some(
                    "the sensor's own; IMUs of the two sides of the board are mirrored".to_owned(),
                ),
                notes: vec![
                    "accelerometer 2048 LSB/g, gyro 16.384 LSB/(deg/s): the device's ranges"
                        .to_owned(),
                ],
                ..RawLayout::default()
            },
            scan: Scan::new(reader),
            imu,
            plan: Plan::default(),
            ticks: None,
            number: None,
            lost: 0,
            stray: 0,
        })
    }
}

/// One count of the gyro: 1/16.384 °/s.
const GYRO_UNIT: &str = "0.06103515625 deg/s";
/// One count of the accelerometer: 1/2048 g.
const ACCEL_UNIT: &str = "0.00048828125 g";

impl RawReader for Mimu {
    fn raw(&self) -> &RawLayout {
        &self.layout
    }

    fn select(&mut self, plan: Plan) -> Result<(), Error> {
        self.plan = plan;
        Ok(())
    }

    fn read_raw(&mut self, block: &mut Block) -> Result<bool, Error> {
        table::begin(block, &self.plan);
        while block.rows < table::ROWS {
            if !self.scan.need(PACKET)? {
                let rest = self.scan.window().len();
                self.stray += rest as u64;
                self.scan.consume(rest);
                self.layout.notes.truncate(1);
                if self.stray > 0 {
                    let n = grouped(self.stray);
                    self.layout
                        .notes
                        .push(format!("{n} bytes belong to no packet and were left out"));
                }
                if self.lost > 0 {
                    let n = grouped(self.lost);
                    self.layout
                        .notes
                        .push(format!("{n} packets are missing by their numbers"));
                }
                break;
            }
            let window = self.scan.window();
            if !is_packet(window) {
                self.scan.consume(1);
                self.stray += 1;
                continue;
            }
            let number = u16::from_be_bytes([window[1], window[2]]);
            if let Some(last) = self.number {
                self.lost += u64::from(number.wrapping_sub(last).wrapping_sub(1));
            }
            self.number = Some(number);
            let now = u32::from_be_bytes([window[4], window[5], window[6], window[7]]);
            let ticks = match self.ticks {
                // The counter wraps every 67.1 s.
                Some(last) => last + i64::from(now.wrapping_sub(last as u32)),
                None => i64::from(now),
            };
            self.ticks = Some(ticks);
            let value = |k: usize| {
                let at = 8 + self.imu * 12 + 2 * k;
                f64::from(i16::from_be_bytes([window[at], window[at + 1]]))
            };
            let row = [value(3), value(4), value(5), value(0), value(1), value(2)];
            table::push(block, &self.plan, ticks / 64, &row);
            self.scan.consume(PACKET);
        }
        Ok(block.rows > 0)
    }
}
