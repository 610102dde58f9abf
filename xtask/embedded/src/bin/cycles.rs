//! Counts the instructions of one correction on a Cortex-M4 (QEMU's board mps2-an386), and its stack.
//!
//! QEMU with `-icount shift=0` runs one instruction a nanosecond; the board's SysTick counts
//! 25 MHz, so that one tick is 40 instructions. `[ARMv7-M]`.
#![no_std]
#![no_main]
#![allow(unsafe_code, reason = "a program without a system under it")]

use core::arch::{asm, global_asm};
use core::hint::black_box;
use core::panic::PanicInfo;

use sagnac_core::{Compensation, Measurement, Reading, Real, SensorModel, Truth};

#[path = "../../../../crates/sagnac-core/tests/common/models.rs"]
mod models;

const SAMPLES: u32 = 200;
const INSTRUCTIONS_PER_TICK: u32 = 40;

global_asm!(
    ".section .vectors, \"a\"",
    ".word stack_top",
    ".word {main}",
    main = sym main,
);

/// Writes a text on the emulator's console (semihosting call 4).
fn say(text: &[u8]) {
    // SAFETY: the text ends with a zero, and the emulator only reads it.
    unsafe {
        asm!("bkpt 0xab", inout("r0") 4 => _, in("r1") text.as_ptr());
    }
}

fn leave(code: u32) -> ! {
    let block = [0x2_0026, code];
    loop {
        // SAFETY: SYS_EXIT_EXTENDED reads two words and does not come back.
        unsafe {
            asm!("bkpt 0xab", in("r0") 0x20, in("r1") block.as_ptr());
        }
    }
}

fn say_number(number: u32) {
    let mut digits = [0_u8; 12];
    let (mut rest, mut at) = (number, 10);
    loop {
        digits[at] = b'0' + (rest % 10) as u8;
        rest /= 10;
        if rest == 0 {
            break;
        }
        at -= 1;
    }
    say(&digits[at..]);
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    say(b"panic\n\0");
    leave(1)
}

const SYSTICK: *mut u32 = 0xE000_E010 as *mut u32;

fn ticks() -> u32 {
    // SAFETY: SYST_CVR of ARMv7-M counts down from 2²⁴ − 1.
    0x00ff_ffff - unsafe { SYSTICK.add(2).read_volatile() }
}

unsafe extern "C" {
    static mut stack_bottom: u32;
}

const PAINT: u32 = 0x5a5a_a5a5;

/// Bytes of stack below the caller that a call has touched.
#[inline(never)]
fn stack_of(call: &mut dyn FnMut()) -> u32 {
    let here: u32;
    // SAFETY: reads the stack pointer; the words well below it belong to nobody.
    unsafe {
        asm!("mov {}, sp", out(reg) here);
        let mut at = &raw mut stack_bottom;
        while (at as u32) < here - 64 {
            at.write_volatile(PAINT);
            at = at.add(1);
        }
    }
    call();
    // SAFETY: as above.
    unsafe {
        let mut at = &raw mut stack_bottom;
        while (at as u32) < here && at.read_volatile() == PAINT {
            at = at.add(1);
        }
        here - at as u32
    }
}

fn measure<T: Real>(name: &[u8], model: &SensorModel<f64>) {
    let model = model.convert::<T>();
    let Ok(inverse) = Compensation::new(&model, T::from_f64(0.005)) else {
        say(b"the model has no inverse\n\0");
        leave(1)
    };
    let of = |v: [f64; 3]| v.map(T::from_f64);
    let raw: Reading<T> = Measurement::new(&model).corrupt(&Truth {
        specific_force: of([1.0, -2.0, -9.5]),
        angular_rate: of([0.3, -0.2, 2.0]),
        angular_acceleration: of([0.1, 0.2, -0.3]),
        temperature_c: T::from_f64(31.0),
    });
    let start = ticks();
    for _ in 0..SAMPLES {
        black_box(black_box(&inverse).correct(black_box(&raw)));
    }
    let instructions = (ticks() - start) * INSTRUCTIONS_PER_TICK / SAMPLES;
    let stack = stack_of(&mut || {
        black_box(black_box(&inverse).correct(black_box(&raw)));
    });
    say(name);
    for (before, number) in [
        (&b" rounds=\0"[..], inverse.rounds()),
        (&b" instructions=\0"[..], instructions),
        (&b" stack_bytes=\0"[..], stack),
        (&b" model_bytes=\0"[..], size_of::<Compensation<T>>() as u32),
    ] {
        say(before);
        say_number(number);
    }
    say(b"\n\0");
}

extern "C" fn main() -> ! {
    // SAFETY: CPACR switches the floating-point unit on; SysTick counts without interrupts.
    unsafe {
        let cpacr = 0xE000_ED88 as *mut u32;
        cpacr.write_volatile(cpacr.read_volatile() | 0xf << 20);
        asm!("dsb", "isb");
        SYSTICK.add(1).write_volatile(0x00ff_ffff);
        SYSTICK.add(2).write_volatile(0);
        SYSTICK.write_volatile(0b101);
    }
    run()
}

#[inline(never)]
fn run() -> ! {
    measure::<f32>(b"example f32\0", &models::example());
    measure::<f64>(b"example f64\0", &models::example());
    measure::<f32>(b"consumer f32\0", &models::consumer());
    measure::<f64>(b"consumer f64\0", &models::consumer());
    leave(0)
}
