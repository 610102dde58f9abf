//! Symbols and stack sizes of a linked 32-bit little-endian ELF file (`[ELF]`, `[AAELF32]`).
//!
//! A reader of our own, because the `nm` of a PC's binutils does not know a microcontroller's files.

/// A symbol with its place and size.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Symbol {
    pub(crate) name: String,
    pub(crate) address: u32,
    pub(crate) size: u32,
}

/// A linked program.
pub(crate) struct Elf {
    /// Its functions and data, by name.
    pub(crate) symbols: Vec<Symbol>,
    /// Bytes of code and constants.
    pub(crate) flash: u32,
    /// Address and stack of each function, as the compiler wrote them (`.stack_sizes`).
    stacks: Vec<(u32, u32)>,
}

struct Section {
    name: u32,
    kind: u32,
    flags: u32,
    offset: usize,
    size: usize,
    link: usize,
}

impl Elf {
    /// Reads a file's bytes; `None` where it is not such a file.
    pub(crate) fn parse(bytes: &[u8]) -> Option<Self> {
        const SYMBOLS: u32 = 2;
        const ALLOCATED: u32 = 2;
        if bytes.get(..6)? != b"\x7fELF\x01\x01" {
            return None;
        }
        let word = |at: usize| -> Option<u32> {
            Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?))
        };
        let half = |at: usize| -> Option<usize> {
            Some(u16::from_le_bytes(bytes.get(at..at + 2)?.try_into().ok()?).into())
        };
        let table = word(0x20)? as usize;
        let (each, count, names) = (half(0x2e)?, half(0x30)?, half(0x32)?);
        let sections = (0..count)
            .map(|i| {
                let at = table + i * each;
                Some(Section {
                    name: word(at)?,
                    kind: word(at + 4)?,
                    flags: word(at + 8)?,
                    offset: word(at + 16)? as usize,
                    size: word(at + 20)? as usize,
                    link: word(at + 24)? as usize,
                })
            })
            .collect::<Option<Vec<_>>>()?;
        let text = |section: &Section, at: u32| -> Option<String> {
            let from = bytes.get(section.offset + at as usize..)?;
            let end = from.iter().position(|byte| *byte == 0)?;
            Some(String::from_utf8_lossy(&from[..end]).into_owned())
        };
        let mut elf = Self {
            symbols: Vec::new(),
            flash: 0,
            stacks: Vec::new(),
        };
        for section in &sections {
            if section.flags & ALLOCATED != 0 {
                elf.flash += section.size as u32;
            }
            if section.kind == SYMBOLS {
                let strings = sections.get(section.link)?;
                for at in (section.offset..section.offset + section.size).step_by(16) {
                    elf.symbols.push(Symbol {
                        name: text(strings, word(at)?)?,
                        address: word(at + 4)? & !1,
                        size: word(at + 8)?,
                    });
                }
            }
            if text(sections.get(names)?, section.name)? == ".stack_sizes" {
                let mut rest = bytes.get(section.offset..section.offset + section.size)?;
                while let [a, b, c, d, after @ ..] = rest {
                    let address = u32::from_le_bytes([*a, *b, *c, *d]) & !1;
                    let (size, after) = unsigned_leb128(after)?;
                    elf.stacks.push((address, size));
                    rest = after;
                }
            }
        }
        Some(elf)
    }

    /// The symbol of this name.
    pub(crate) fn symbol(&self, name: &str) -> Option<&Symbol> {
        self.symbols.iter().find(|symbol| symbol.name == name)
    }

    /// Stack of a function itself, bytes.
    pub(crate) fn stack(&self, symbol: &Symbol) -> Option<u32> {
        self.stacks
            .iter()
            .find(|(address, _)| *address == symbol.address)
            .map(|(_, size)| *size)
    }

    /// Names that a panic path would bring along.
    pub(crate) fn panics(&self) -> Vec<&str> {
        self.symbols
            .iter()
            .map(|symbol| symbol.name.as_str())
            .filter(|name| name.to_lowercase().contains("panic") && *name != PLANTED)
            .filter(|name| !name.starts_with(".L"))
            .collect()
    }
}

/// The exported function that panics on purpose.
pub(crate) const PLANTED: &str = "sagnac_planted_panic";

fn unsigned_leb128(bytes: &[u8]) -> Option<(u32, &[u8])> {
    let mut value = 0_u32;
    for (i, byte) in bytes.iter().enumerate().take(5) {
        value |= u32::from(byte & 0x7f) << (7 * i);
        if byte & 0x80 == 0 {
            return Some((value, &bytes[i + 1..]));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_of_two_bytes() {
        assert_eq!(unsigned_leb128(&[0xe8, 0x03, 7]), Some((488, &[7][..])));
        assert_eq!(unsigned_leb128(&[0x80]), None);
    }

    #[test]
    fn what_is_no_program_is_refused() {
        assert!(Elf::parse(b"").is_none());
        assert!(Elf::parse(b"\x7fELF\x02\x01").is_none());
    }
}
