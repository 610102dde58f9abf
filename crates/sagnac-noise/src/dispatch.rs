//! One body of plain arithmetic, compiled for several vector widths and chosen at run time.
//!
//! The body has no fused multiply–add and no reordering, so that every version gives the same bits.

/// Defines `fn $name(args)` that calls the `#[inline(always)]` function `$body` compiled for the
/// widest vectors of this processor.
macro_rules! dispatch {
    ($(#[$meta:meta])* $vis:vis fn $name:ident($($arg:ident: $ty:ty),* $(,)?) = $body:ident;) => {
        $(#[$meta])*
        #[inline]
        $vis fn $name($($arg: $ty),*) {
            #[cfg(all(feature = "std", target_arch = "x86_64"))]
            {
                #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw")]
                fn wide($($arg: $ty),*) {
                    $body($($arg),*);
                }
                #[target_feature(enable = "avx2")]
                fn medium($($arg: $ty),*) {
                    $body($($arg),*);
                }
                if std::is_x86_feature_detected!("avx512f")
                    && std::is_x86_feature_detected!("avx512dq")
                    && std::is_x86_feature_detected!("avx512vl")
                    && std::is_x86_feature_detected!("avx512bw")
                {
                    #[allow(unsafe_code, reason = "measured kernel: 2 to 4 times the portable speed")]
                    // SAFETY: the processor has just been asked for these features.
                    unsafe {
                        wide($($arg),*);
                    }
                    return;
                }
                if std::is_x86_feature_detected!("avx2") {
                    #[allow(unsafe_code, reason = "measured kernel: 2 times the portable speed")]
                    // SAFETY: the processor has just been asked for this feature.
                    unsafe {
                        medium($($arg),*);
                    }
                    return;
                }
            }
            $body($($arg),*);
        }
    };
}

pub(crate) use dispatch;
