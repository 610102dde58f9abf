//! The core without std: links on this machine, and for a Cortex-M4 without a panic path.
//!
//! The microcontroller's part needs Debian's `rustc-web`, `cargo-web` and `rust-web-src`, which can
//! build `core` itself; the linker is the installed toolchain's `rust-lld`. QEMU counts instructions.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::elf::{Elf, PLANTED};
use crate::steps::{self, root};

const FOLDER: &str = "xtask/embedded";
const TARGET: &str = "thumbv7em-none-eabihf";
/// What a flight computer calls; none of it may be able to panic.
const EXPORTED: [&str; 6] = [
    "sagnac_correct_f32",
    "sagnac_correct_f64",
    "sagnac_corrupt_f32",
    "sagnac_corrupt_f64",
    "sagnac_prepare_f32",
    "sagnac_prepare_f64",
];

/// Builds core and noise with a panic handler of their own, then the Cortex-M4's object.
pub(crate) fn run() -> Result<(), String> {
    host()?;
    if let Err(why) = packages() {
        println!("   the Cortex-M4 is left out, its compiler cannot be installed: {why}");
        return Ok(());
    }
    cortex_m4()
}

/// With std in it there would be two panic handlers, and nothing would build.
fn host() -> Result<(), String> {
    let mut cargo = Command::new("cargo");
    cargo
        .args(["build", "--release", "--quiet", "--features", "noise"])
        .args(["--manifest-path", &format!("{FOLDER}/Cargo.toml")])
        .env("CARGO_TARGET_DIR", target());
    steps::check(&mut cargo)?;
    println!("   core and noise link without std and heap");
    Ok(())
}

fn target() -> PathBuf {
    root().join("target/embedded")
}

fn packages() -> Result<(), String> {
    let sources = Path::new("/usr/lib/rustlib/src/rust/library/core");
    if !(Path::new("/usr/bin/rustc").exists()
        && Path::new("/usr/bin/cargo").exists()
        && sources.exists())
    {
        steps::debian(
            "rustc-web",
            &[
                "--no-install-recommends",
                "rustc-web",
                "cargo-web",
                "rust-web-src",
            ],
        )?;
    }
    Ok(())
}

/// The installed toolchain's linker.
fn linker() -> Result<PathBuf, String> {
    let output = |args: &[&str]| -> Result<String, String> {
        let out = Command::new("rustc")
            .args(args)
            .output()
            .map_err(|error| format!("rustc: {error}"))?;
        Ok(String::from_utf8_lossy(&out.stdout).trim().to_owned())
    };
    let sysroot = output(&["--print", "sysroot"])?;
    let host = output(&["--print", "host-tuple"])?;
    let path = Path::new(&sysroot)
        .join("lib/rustlib")
        .join(host)
        .join("bin/rust-lld");
    if path.exists() {
        Ok(path)
    } else {
        Err(format!("no linker at {}", path.display()))
    }
}

/// Debian's cargo on the small program, with `core` built for the target.
fn build(linker: &Path, args: &[&str], last: &[String]) -> Result<(), String> {
    let mut cargo = Command::new("/usr/bin/cargo");
    cargo
        .args(["rustc", "--release", "--quiet", "--target", TARGET])
        .arg("-Zbuild-std=core")
        .args(["--manifest-path", &format!("{FOLDER}/Cargo.toml")])
        .args(args)
        .arg("--")
        .args(last)
        // What the outer cargo set for itself.
        .env_remove("RUSTUP_TOOLCHAIN")
        .env_remove("CARGO")
        .env_remove("RUSTDOC")
        .env("RUSTC", "/usr/bin/rustc")
        .env("RUSTC_BOOTSTRAP", "1")
        .env("RUSTFLAGS", "-Zemit-stack-sizes")
        .env("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER", linker)
        .env("CARGO_TARGET_DIR", target().join("arm"));
    steps::check(&mut cargo)
}

fn cortex_m4() -> Result<(), String> {
    let linker = linker()?;
    let folder = target().join("arm").join(TARGET).join("release");
    build(&linker, &["--lib", "--features", "no-panic"], &[])?;
    let archive = folder.join("libsagnac_embedded.a");
    println!("   {TARGET}, opt-level 3: linked alone, unreachable parts dropped");
    println!("   function              own bytes   with what it calls   own stack");
    for name in EXPORTED {
        let elf = link(&linker, &archive, &folder, name)?
            .map_err(|why| format!("{name} has a panic path (or misses a symbol):\n{why}"))?;
        let found = elf.panics();
        if !found.is_empty() {
            return Err(format!("{name} holds {}", found.join(", ")));
        }
        let symbol = elf
            .symbol(name)
            .ok_or_else(|| format!("{name} is not in its own program"))?;
        let stack = elf
            .stack(symbol)
            .map_or_else(|| "?".to_owned(), |bytes| bytes.to_string());
        println!(
            "   {name:<22} {:>8} {:>20} {stack:>11}",
            symbol.size, elf.flash
        );
    }
    // The check itself must be able to fail.
    if link(&linker, &archive, &folder, PLANTED)?.is_ok() {
        return Err("a panic path made on purpose was not noticed".to_owned());
    }
    println!("   no panic symbol in any of them; the one made on purpose is found");
    cycles(&linker, &folder)
}

/// Links one function alone; the inner error is the linker's.
fn link(
    linker: &Path,
    archive: &Path,
    folder: &Path,
    name: &str,
) -> Result<Result<Elf, String>, String> {
    let program = folder.join(format!("{name}.elf"));
    let out = Command::new(linker)
        .args(["-flavor", "gnu", "--gc-sections", "-e", name, "-u", name])
        .arg(archive)
        .arg("-o")
        .arg(&program)
        .output()
        .map_err(|error| format!("{}: {error}", linker.display()))?;
    if !out.status.success() {
        return Ok(Err(String::from_utf8_lossy(&out.stderr).into_owned()));
    }
    let bytes = std::fs::read(&program).map_err(|e| format!("{}: {e}", program.display()))?;
    Elf::parse(&bytes)
        .map(Ok)
        .ok_or_else(|| format!("{} is no 32-bit ELF file", program.display()))
}

/// Instructions and stack of one correction, on QEMU's Cortex-M4 board.
fn cycles(linker: &Path, folder: &Path) -> Result<(), String> {
    const EMULATOR: &str = "qemu-system-arm";
    if let Err(why) = steps::debian(EMULATOR, &["--no-install-recommends", EMULATOR]) {
        println!("   instructions are not counted: {why}");
        return Ok(());
    }
    let script = root().join(FOLDER).join("cycles.ld");
    build(
        linker,
        &["--bin", "cycles", "--features", "cycles"],
        &[format!("-Clink-arg=-T{}", script.display())],
    )?;
    println!("   on {EMULATOR} -M mps2-an386, a sample:");
    steps::check(
        Command::new("timeout")
            .args(["60", EMULATOR, "-M", "mps2-an386", "-nographic"])
            .args(["-icount", "shift=0"])
            .args(["-semihosting-config", "enable=on,target=native"])
            .arg("-kernel")
            .arg(folder.join("cycles")),
    )
}
