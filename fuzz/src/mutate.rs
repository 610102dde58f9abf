//! Damage to a file: bits, bytes, numbers that readers stumble over, pieces lost, doubled and mixed, cuts.

/// splitmix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }
}

const NUMBERS: [u64; 16] = [
    0,
    1,
    2,
    0x7F,
    0x80,
    0xFF,
    0x7FFF,
    0xFFFF,
    0x1_0000,
    0x7FFF_FFFF,
    0x8000_0000,
    0xFFFF_FFFF,
    0x1_0000_0000,
    i64::MAX as u64,
    1 << 63,
    u64::MAX,
];

/// Input `k` of a run: a seed with one to eight faults; every 64th is whole.
pub(crate) fn input(seeds: &[Vec<u8>], seed: u64, k: u64) -> Vec<u8> {
    let mut random = Random(seed ^ k.wrapping_mul(0xD6E8_FEB8_6659_FD93));
    let mut bytes = seeds[random.below(seeds.len())].clone();
    if k.is_multiple_of(64) {
        return bytes;
    }
    for _ in 0..=random.below(8) {
        if bytes.is_empty() {
            return bytes;
        }
        let at = random.below(bytes.len());
        let longest = 1 << random.below(9);
        let n = 1 + random.below(longest);
        let end = (at + n).min(bytes.len());
        match random.below(12) {
            0..3 => bytes[at] ^= 1 << random.below(8),
            3 => bytes[at] = random.next() as u8,
            4..8 => {
                let number = NUMBERS[random.below(NUMBERS.len())];
                let width = 1 << random.below(4);
                let mut raw = number.to_le_bytes();
                if random.below(3) == 0 {
                    raw[..width].reverse();
                }
                for (to, from) in bytes[at..].iter_mut().zip(&raw[..width]) {
                    *to = *from;
                }
            }
            8 => {
                bytes.drain(at..end);
            }
            9 => {
                let piece = bytes[at..end].to_vec();
                bytes.splice(at..at, piece);
            }
            10 => {
                let other = &seeds[random.below(seeds.len())];
                let from = random.below(other.len());
                let piece = other[from..(from + n).min(other.len())].to_vec();
                let end = (at + piece.len()).min(bytes.len());
                bytes.splice(at..end, piece);
            }
            _ if random.below(4) == 0 => bytes.truncate(at),
            _ => bytes[at] = bytes[at].wrapping_add(1),
        }
    }
    bytes
}
