//! Vector kernels of the deviations: sums of products and of squared phase differences.
//!
//! Each has a plain form and forms for AVX2 and AVX-512, chosen at run time and tested against
//! the plain one. A sum runs in eight lanes whatever the machine; fused multiplication may move
//! its last digit between machines, threads never do.

#![allow(
    unsafe_code,
    reason = "vector loads of the innermost loops, measured: 3 to 5 times the plain form"
)]

/// Averaging factors that share one pass over the phase.
pub(crate) const GROUP: usize = 4;

/// Σ a_k.
#[inline(always)]
#[allow(
    clippy::inline_always,
    reason = "keeps the vectors of a caller compiled for wider ones"
)]
pub(crate) fn sum(values: &[f64]) -> f64 {
    let mut lanes = [0.0; 8];
    let (chunks, rest) = values.as_chunks::<8>();
    for chunk in chunks {
        for (lane, value) in lanes.iter_mut().zip(chunk) {
            *lane += value;
        }
    }
    for (lane, value) in lanes.iter_mut().zip(rest) {
        *lane += value;
    }
    fold(lanes)
}

/// Σ a_k b_k over slices of one length.
#[inline(always)]
#[allow(
    clippy::inline_always,
    reason = "keeps the vectors of a caller compiled for wider ones"
)]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 8];
    let (a_chunks, a_rest) = a.as_chunks::<8>();
    let (b_chunks, b_rest) = b.as_chunks::<8>();
    for (x, y) in a_chunks.iter().zip(b_chunks) {
        for ((lane, x), y) in lanes.iter_mut().zip(x).zip(y) {
            *lane += x * y;
        }
    }
    for ((lane, x), y) in lanes.iter_mut().zip(a_rest).zip(b_rest) {
        *lane += x * y;
    }
    fold(lanes)
}

/// The sum of eight lanes, in a fixed order.
fn fold(lanes: [f64; 8]) -> f64 {
    let [a, b, c, d, e, f, g, h] = lanes;
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

/// Σ_j (x_{j−m} − 2x_j + x_{j+m})² over j = start…start + count − 1 for one factor.
///
/// # Panics
/// Where j − m or j + m leaves the phase (a mistake of the caller).
pub(crate) fn second_differences(phase: &[f64], start: usize, count: usize, m: usize) -> f64 {
    second_of_slices(
        &phase[start - m..][..count],
        &phase[start..][..count],
        &phase[start + m..][..count],
    )
}

/// Σ (a_k − 2b_k + c_k)² over the length of `center`.
///
/// # Panics
/// Where another slice is shorter (a mistake of the caller).
pub(crate) fn second_of_slices(left: &[f64], center: &[f64], right: &[f64]) -> f64 {
    let (left, right) = (&left[..center.len()], &right[..center.len()]);
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f") {
            // SAFETY: the feature is there; the three slices have one length.
            return unsafe { x86::second_single_512(left, center, right) };
        }
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            // SAFETY: the features are there; the three slices have one length.
            return unsafe { x86::second_single_256(left, center, right) };
        }
    }
    second_plain(left, center, right)
}

/// As [`second_differences`] for [`GROUP`] factors at once: the middle point is read once.
///
/// # Panics
/// Where j − m or j + m leaves the phase (a mistake of the caller).
pub(crate) fn second_differences_group(
    phase: &[f64],
    start: usize,
    count: usize,
    factors: [usize; GROUP],
) -> [f64; GROUP] {
    let center = &phase[start..][..count];
    let left = factors.map(|m| &phase[start - m..][..count]);
    let right = factors.map(|m| &phase[start + m..][..count]);
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f") {
            // SAFETY: the feature is there; all slices have one length.
            return unsafe { x86::second_group_512(left, center, right) };
        }
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            // SAFETY: the features are there; all slices have one length.
            return unsafe { x86::second_group_256(left, center, right) };
        }
    }
    std::array::from_fn(|g| second_plain(left[g], center, right[g]))
}

/// Σ_i (x_{i+3m} − 3x_{i+2m} + 3x_{i+m} − x_i)² over i = start…start + count − 1.
///
/// # Panics
/// Where i + 3m leaves the phase (a mistake of the caller).
pub(crate) fn third_differences(phase: &[f64], start: usize, count: usize, m: usize) -> f64 {
    let at = |k: usize| &phase[start + k * m..][..count];
    third_of_slices([at(0), at(1), at(2), at(3)])
}

/// Σ (d_k − 3c_k + 3b_k − a_k)² over slices of one length.
///
/// # Panics
/// Where they have not (a mistake of the caller).
pub(crate) fn third_of_slices(points: [&[f64]; 4]) -> f64 {
    let points = points.map(|p| &p[..points[0].len()]);
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f") {
            // SAFETY: the feature is there; the four slices have one length.
            return unsafe { x86::third_512(points) };
        }
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            // SAFETY: the features are there; the four slices have one length.
            return unsafe { x86::third_256(points) };
        }
    }
    third_plain(points)
}

/// The plain form of [`second_differences`].
fn second_plain(left: &[f64], center: &[f64], right: &[f64]) -> f64 {
    let mut lanes = [0.0; 8];
    for ((a, b), c) in left.chunks(8).zip(center.chunks(8)).zip(right.chunks(8)) {
        for (((lane, a), b), c) in lanes.iter_mut().zip(a).zip(b).zip(c) {
            let difference = (a + c) - 2.0 * b;
            *lane += difference * difference;
        }
    }
    fold(lanes)
}

/// The plain form of [`third_differences`].
fn third_plain(points: [&[f64]; 4]) -> f64 {
    let mut lanes = [0.0; 8];
    let [p0, p1, p2, p3] = points;
    for (((a, b), c), d) in p0
        .chunks(8)
        .zip(p1.chunks(8))
        .zip(p2.chunks(8))
        .zip(p3.chunks(8))
    {
        for ((((lane, a), b), c), d) in lanes.iter_mut().zip(a).zip(b).zip(c).zip(d) {
            let difference = (d - a) + 3.0 * (b - c);
            *lane += difference * difference;
        }
    }
    fold(lanes)
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    //! The same sums with the vectors of x86-64.

    use std::arch::x86_64::{
        __m256d, __m512d, _mm256_add_pd, _mm256_fmadd_pd, _mm256_loadu_pd, _mm256_set1_pd,
        _mm256_setzero_pd, _mm256_storeu_pd, _mm256_sub_pd, _mm512_add_pd, _mm512_fmadd_pd,
        _mm512_loadu_pd, _mm512_set1_pd, _mm512_setzero_pd, _mm512_storeu_pd, _mm512_sub_pd,
    };

    use super::{GROUP, fold, second_plain, third_plain};

    #[target_feature(enable = "avx512f")]
    fn lanes_512(vector: __m512d) -> f64 {
        let mut lanes = [0.0; 8];
        // SAFETY: the array holds eight numbers.
        unsafe { _mm512_storeu_pd(lanes.as_mut_ptr(), vector) };
        fold(lanes)
    }

    #[target_feature(enable = "avx2,fma")]
    fn lanes_256(low: __m256d, high: __m256d) -> f64 {
        let mut lanes = [0.0; 8];
        // SAFETY: the array holds two times four numbers.
        unsafe {
            _mm256_storeu_pd(lanes.as_mut_ptr(), low);
            _mm256_storeu_pd(lanes.as_mut_ptr().add(4), high);
        }
        fold(lanes)
    }

    /// # Safety
    /// All slices must have the length of `center`.
    #[target_feature(enable = "avx512f")]
    pub(super) unsafe fn second_group_512(
        left: [&[f64]; GROUP],
        center: &[f64],
        right: [&[f64]; GROUP],
    ) -> [f64; GROUP] {
        let whole = center.len() / 8 * 8;
        let mut sums = [_mm512_setzero_pd(); GROUP];
        let minus_two = _mm512_set1_pd(-2.0);
        let mut k = 0;
        while k < whole {
            // SAFETY: k + 8 ≤ whole ≤ the length of every slice.
            unsafe {
                let middle = _mm512_loadu_pd(center.as_ptr().add(k));
                for g in 0..GROUP {
                    let ends = _mm512_add_pd(
                        _mm512_loadu_pd(left[g].as_ptr().add(k)),
                        _mm512_loadu_pd(right[g].as_ptr().add(k)),
                    );
                    let difference = _mm512_fmadd_pd(minus_two, middle, ends);
                    sums[g] = _mm512_fmadd_pd(difference, difference, sums[g]);
                }
            }
            k += 8;
        }
        std::array::from_fn(|g| {
            lanes_512(sums[g])
                + second_plain(&left[g][whole..], &center[whole..], &right[g][whole..])
        })
    }

    /// # Safety
    /// All slices must have the length of `center`.
    #[target_feature(enable = "avx512f")]
    pub(super) unsafe fn second_single_512(left: &[f64], center: &[f64], right: &[f64]) -> f64 {
        let whole = center.len() / 8 * 8;
        let mut sums = _mm512_setzero_pd();
        let minus_two = _mm512_set1_pd(-2.0);
        let mut k = 0;
        while k < whole {
            // SAFETY: k + 8 ≤ whole ≤ the length of every slice.
            unsafe {
                let ends = _mm512_add_pd(
                    _mm512_loadu_pd(left.as_ptr().add(k)),
                    _mm512_loadu_pd(right.as_ptr().add(k)),
                );
                let middle = _mm512_loadu_pd(center.as_ptr().add(k));
                let difference = _mm512_fmadd_pd(minus_two, middle, ends);
                sums = _mm512_fmadd_pd(difference, difference, sums);
            }
            k += 8;
        }
        lanes_512(sums) + second_plain(&left[whole..], &center[whole..], &right[whole..])
    }

    /// # Safety
    /// All slices must have the length of `center`.
    #[target_feature(enable = "avx2,fma")]
    pub(super) unsafe fn second_group_256(
        left: [&[f64]; GROUP],
        center: &[f64],
        right: [&[f64]; GROUP],
    ) -> [f64; GROUP] {
        let whole = center.len() / 8 * 8;
        let mut sums = [[_mm256_setzero_pd(); 2]; GROUP];
        let minus_two = _mm256_set1_pd(-2.0);
        let mut k = 0;
        while k < whole {
            for half in 0..2 {
                let at = k + 4 * half;
                // SAFETY: at + 4 ≤ whole ≤ the length of every slice.
                unsafe {
                    let middle = _mm256_loadu_pd(center.as_ptr().add(at));
                    for g in 0..GROUP {
                        let ends = _mm256_add_pd(
                            _mm256_loadu_pd(left[g].as_ptr().add(at)),
                            _mm256_loadu_pd(right[g].as_ptr().add(at)),
                        );
                        let difference = _mm256_fmadd_pd(minus_two, middle, ends);
                        sums[g][half] = _mm256_fmadd_pd(difference, difference, sums[g][half]);
                    }
                }
            }
            k += 8;
        }
        std::array::from_fn(|g| {
            lanes_256(sums[g][0], sums[g][1])
                + second_plain(&left[g][whole..], &center[whole..], &right[g][whole..])
        })
    }

    /// # Safety
    /// All slices must have the length of `center`.
    #[target_feature(enable = "avx2,fma")]
    pub(super) unsafe fn second_single_256(left: &[f64], center: &[f64], right: &[f64]) -> f64 {
        let whole = center.len() / 8 * 8;
        let mut sums = [_mm256_setzero_pd(); 2];
        let minus_two = _mm256_set1_pd(-2.0);
        let mut k = 0;
        while k < whole {
            for (half, sum) in sums.iter_mut().enumerate() {
                let at = k + 4 * half;
                // SAFETY: at + 4 ≤ whole ≤ the length of every slice.
                unsafe {
                    let ends = _mm256_add_pd(
                        _mm256_loadu_pd(left.as_ptr().add(at)),
                        _mm256_loadu_pd(right.as_ptr().add(at)),
                    );
                    let middle = _mm256_loadu_pd(center.as_ptr().add(at));
                    let difference = _mm256_fmadd_pd(minus_two, middle, ends);
                    *sum = _mm256_fmadd_pd(difference, difference, *sum);
                }
            }
            k += 8;
        }
        lanes_256(sums[0], sums[1])
            + second_plain(&left[whole..], &center[whole..], &right[whole..])
    }

    /// # Safety
    /// The four slices must have one length.
    #[target_feature(enable = "avx512f")]
    pub(super) unsafe fn third_512(points: [&[f64]; 4]) -> f64 {
        let whole = points[0].len() / 8 * 8;
        let mut sums = _mm512_setzero_pd();
        let three = _mm512_set1_pd(3.0);
        let mut k = 0;
        while k < whole {
            // SAFETY: k + 8 ≤ whole ≤ the length of every slice.
            unsafe {
                let outer = _mm512_sub_pd(
                    _mm512_loadu_pd(points[3].as_ptr().add(k)),
                    _mm512_loadu_pd(points[0].as_ptr().add(k)),
                );
                let inner = _mm512_sub_pd(
                    _mm512_loadu_pd(points[1].as_ptr().add(k)),
                    _mm512_loadu_pd(points[2].as_ptr().add(k)),
                );
                let difference = _mm512_fmadd_pd(three, inner, outer);
                sums = _mm512_fmadd_pd(difference, difference, sums);
            }
            k += 8;
        }
        lanes_512(sums) + third_plain(points.map(|p| &p[whole..]))
    }

    /// # Safety
    /// The four slices must have one length.
    #[target_feature(enable = "avx2,fma")]
    pub(super) unsafe fn third_256(points: [&[f64]; 4]) -> f64 {
        let whole = points[0].len() / 8 * 8;
        let mut sums = [_mm256_setzero_pd(); 2];
        let three = _mm256_set1_pd(3.0);
        let mut k = 0;
        while k < whole {
            for (half, sum) in sums.iter_mut().enumerate() {
                let at = k + 4 * half;
                // SAFETY: at + 4 ≤ whole ≤ the length of every slice.
                unsafe {
                    let outer = _mm256_sub_pd(
                        _mm256_loadu_pd(points[3].as_ptr().add(at)),
                        _mm256_loadu_pd(points[0].as_ptr().add(at)),
                    );
                    let inner = _mm256_sub_pd(
                        _mm256_loadu_pd(points[1].as_ptr().add(at)),
                        _mm256_loadu_pd(points[2].as_ptr().add(at)),
                    );
                    let difference = _mm256_fmadd_pd(three, inner, outer);
                    *sum = _mm256_fmadd_pd(difference, difference, *sum);
                }
            }
            k += 8;
        }
        lanes_256(sums[0], sums[1]) + third_plain(points.map(|p| &p[whole..]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn phase(count: usize) -> Vec<f64> {
        let mut x = 0.0;
        (0..count)
            .map(|k| {
                x += (k * 7919 % 1000) as f64 / 1000.0 - 0.4995;
                x
            })
            .collect()
    }

    fn assert_close(got: f64, want: f64) {
        // A few hundred roundings of fused against plain multiplication.
        assert!((got - want).abs() <= 1e-13 * want.abs(), "{got} {want}");
    }

    #[test]
    fn vectors_equal_the_plain_form_at_any_length() {
        let x = phase(400);
        for count in (0..40).chain([100, 137]) {
            for m in [1, 5, 60] {
                let second = second_plain(
                    &x[70 - m..][..count],
                    &x[70..][..count],
                    &x[70 + m..][..count],
                );
                assert_close(second_differences(&x, 70, count, m), second);
                let group = second_differences_group(&x, 70, count, [m, 1, 2, 3]);
                assert_close(group[0], second);
                assert_close(group[3], second_differences(&x, 70, count, 3));
                let third = third_plain([0, 1, 2, 3].map(|k| &x[70 + k * m..][..count]));
                assert_close(third_differences(&x, 70, count, m), third);
            }
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[test]
    fn the_narrower_vectors_agree_too() {
        if !(is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")) {
            return;
        }
        let x = phase(400);
        for count in [0, 1, 7, 8, 9, 64, 131] {
            let (left, center, right) = (&x[60..][..count], &x[70..][..count], &x[80..][..count]);
            let want = second_plain(left, center, right);
            // SAFETY: AVX2 and FMA are there, the slices have one length.
            unsafe {
                assert_close(x86::second_single_256(left, center, right), want);
                let group = x86::second_group_256([left; 4], center, [right; 4]);
                assert_close(group[2], want);
                let points = [left, center, right, &x[90..][..count]];
                assert_close(x86::third_256(points), third_plain(points));
            }
        }
    }

    #[test]
    fn sums_and_products_are_those_of_a_loop() {
        let x = phase(1003);
        let plain: f64 = x.iter().sum();
        assert!((sum(&x) - plain).abs() < 1e-9);
        let plain: f64 = x.windows(2).map(|w| w[0] * w[1]).sum();
        assert_close(dot(&x[..1002], &x[1..]), plain);
    }
}
