//! The core as a flight computer has it: no std, no heap, a panic handler of its own.
#![no_std]
#![allow(
    unsafe_code,
    reason = "exported functions are named for the linker; nothing else is unsafe"
)]

use core::panic::PanicInfo;

use sagnac_core::{
    Compensation, CompensationError, Corrected, Measurement, Reading, SensorModel, Truth,
};

/// With std there would be two of these, which the compiler refuses (E0152).
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    #[cfg(feature = "no-panic")]
    {
        unsafe extern "C" {
            safe fn sagnac_a_panic_can_be_reached() -> !;
        }
        sagnac_a_panic_can_be_reached()
    }
    #[cfg(not(feature = "no-panic"))]
    loop {}
}

macro_rules! exported {
    ($real:ty, $prepare:ident, $correct:ident, $corrupt:ident) => {
        /// Makes the inverse of a model ready: once, when the program starts.
        ///
        /// # Errors
        /// Those of [`Compensation::new`].
        #[unsafe(no_mangle)]
        pub fn $prepare(
            model: &SensorModel<$real>,
            dt_s: $real,
        ) -> Result<Compensation<$real>, CompensationError> {
            Compensation::new(model, dt_s)
        }

        /// Corrects one reading.
        #[unsafe(no_mangle)]
        pub fn $correct(
            inverse: &Compensation<$real>,
            raw: &Reading<$real>,
            out: &mut Corrected<$real>,
        ) {
            *out = inverse.correct(raw);
        }

        /// The forward model of one sample.
        #[unsafe(no_mangle)]
        pub fn $corrupt(
            forward: &Measurement<$real>,
            truth: &Truth<$real>,
            out: &mut Reading<$real>,
        ) {
            *out = forward.corrupt(truth);
        }
    };
}

exported!(
    f32,
    sagnac_prepare_f32,
    sagnac_correct_f32,
    sagnac_corrupt_f32
);
exported!(
    f64,
    sagnac_prepare_f64,
    sagnac_correct_f64,
    sagnac_corrupt_f64
);

/// Adds the next frame of white noise and of a random walk.
#[cfg(feature = "noise")]
#[unsafe(no_mangle)]
pub fn sagnac_noise_frame(
    white: &mut sagnac_noise::WhiteGenerator,
    walk: &mut sagnac_noise::RandomWalkGenerator,
    flicker: &mut sagnac_noise::FlickerGenerator,
    frame: &mut sagnac_noise::Frame,
    scratch: &mut sagnac_noise::Scratch,
) {
    use sagnac_noise::Generator as _;
    white.add_frame(frame, scratch);
    walk.add_frame(frame, scratch);
    flicker.add_frame(frame, scratch);
}

/// A panic path on purpose: the check of symbols must find this one.
#[unsafe(no_mangle)]
pub fn sagnac_planted_panic(numbers: &[f32], at: usize) -> f32 {
    numbers[at]
}
