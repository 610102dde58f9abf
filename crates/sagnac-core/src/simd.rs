//! Runs a kernel in the widest vectors that the processor at hand has.
//!
//! The same source is compiled for several instruction sets; which one runs is found out
//! once, when the program runs. Only plain IEEE 754 operations are used, never fused ones,
//! so that all of them give the same bits. Without the feature `simd` (or on other
//! processors) the kernel runs as it was compiled for the target.

/// A piece of work without a result, in which all is marked `#[inline(always)]`.
pub trait Kernel {
    /// Does the work; to be marked `#[inline(always)]`.
    fn run(self);
}

/// Runs the kernel in the widest vectors there are.
#[cfg(all(feature = "simd", target_arch = "x86_64"))]
#[inline]
pub fn dispatch<K: Kernel>(kernel: K) {
    #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx2,fma,bmi1,bmi2")]
    fn avx512<K: Kernel>(kernel: K) {
        kernel.run();
    }
    #[target_feature(enable = "avx2,fma,bmi1,bmi2")]
    fn avx2<K: Kernel>(kernel: K) {
        kernel.run();
    }
    let has_avx2 = std::is_x86_feature_detected!("avx2")
        && std::is_x86_feature_detected!("fma")
        && std::is_x86_feature_detected!("bmi1")
        && std::is_x86_feature_detected!("bmi2");
    if has_avx2
        && std::is_x86_feature_detected!("avx512f")
        && std::is_x86_feature_detected!("avx512vl")
        && std::is_x86_feature_detected!("avx512dq")
        && std::is_x86_feature_detected!("avx512bw")
    {
        #[allow(
            unsafe_code,
            reason = "a measured kernel, tested against the plain one"
        )]
        // SAFETY: the features were found on this processor just above.
        unsafe {
            avx512(kernel);
        }
    } else if has_avx2 {
        #[allow(
            unsafe_code,
            reason = "a measured kernel, tested against the plain one"
        )]
        // SAFETY: the features were found on this processor just above.
        unsafe {
            avx2(kernel);
        }
    } else {
        kernel.run();
    }
}

/// Runs the kernel as compiled for the target.
#[cfg(not(all(feature = "simd", target_arch = "x86_64")))]
#[inline]
pub fn dispatch<K: Kernel>(kernel: K) {
    kernel.run();
}
