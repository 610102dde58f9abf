//! Three-vectors and 3×3 matrices as plain arrays, written out so that loops over lanes
//! of samples become vector instructions.

use crate::Real;

/// A vector in body axes.
pub type Vector<T> = [T; 3];
/// A 3×3 matrix, row by row.
pub type Matrix<T> = [[T; 3]; 3];

/// a·b.
#[inline(always)]
pub fn dot<T: Real>(a: Vector<T>, b: Vector<T>) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a × b.
#[inline(always)]
pub fn cross<T: Real>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// a + b.
#[inline(always)]
pub fn add<T: Real>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// a − b.
#[inline(always)]
pub fn sub<T: Real>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// m·v.
#[inline(always)]
pub fn apply<T: Real>(m: &Matrix<T>, v: Vector<T>) -> Vector<T> {
    [dot(m[0], v), dot(m[1], v), dot(m[2], v)]
}

/// The inverse of a 3×3 matrix by cofactors, and its determinant.
///
/// A singular matrix gives elements that are not finite, and the determinant 0.
#[inline(always)]
pub fn inverse<T: Real>(m: &Matrix<T>) -> (Matrix<T>, T) {
    let c0 = cross(m[1], m[2]);
    let c1 = cross(m[2], m[0]);
    let c2 = cross(m[0], m[1]);
    let determinant = dot(m[0], c0);
    let r = T::ONE / determinant;
    (
        [
            [c0[0] * r, c1[0] * r, c2[0] * r],
            [c0[1] * r, c1[1] * r, c2[1] * r],
            [c0[2] * r, c1[2] * r, c2[2] * r],
        ],
        determinant,
    )
}

/// The largest of |v_k|.
#[inline(always)]
pub fn norm_inf<T: Real>(v: Vector<T>) -> T {
    v[0].abs().larger(v[1].abs().larger(v[2].abs()))
}

/// Whether all elements off the diagonal are zero.
pub(crate) fn is_diagonal<T: Real>(m: &Matrix<T>) -> bool {
    let off = [m[0][1], m[0][2], m[1][0], m[1][2], m[2][0], m[2][1]];
    off.iter().all(|x| *x == T::ZERO)
}

/// Sample i of three channels.
#[inline(always)]
pub(crate) fn take<T: Real, const N: usize>(from: &[[T; N]; 3], i: usize) -> Vector<T> {
    [from[0][i], from[1][i], from[2][i]]
}

/// Sample i of three channels that lie apart.
#[inline(always)]
pub(crate) fn take_from<T: Real, const N: usize>(from: [&[T; N]; 3], i: usize) -> Vector<T> {
    [from[0][i], from[1][i], from[2][i]]
}

/// The matrix of sample i.
#[inline(always)]
pub(crate) fn take_matrix<T: Real, const N: usize>(from: &[[[T; N]; 3]; 3], i: usize) -> Matrix<T> {
    [take(&from[0], i), take(&from[1], i), take(&from[2], i)]
}

/// Writes sample i of three channels.
#[inline(always)]
pub(crate) fn put<T: Real, const N: usize>(to: &mut [[T; N]; 3], i: usize, v: Vector<T>) {
    to[0][i] = v[0];
    to[1][i] = v[1];
    to[2][i] = v[2];
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_undoes_the_matrix() {
        let m = [
            [1.01_f64, 0.02, -0.03],
            [0.01, 0.98, 0.02],
            [-0.015, 0.03, 1.1],
        ];
        let (i, d) = inverse(&m);
        assert!(d > 1.0);
        let v = [1.0, -2.0, 3.0];
        let back = apply(&i, apply(&m, v));
        for k in 0..3 {
            assert!((back[k] - v[k]).abs() < 1e-15 * 8.0);
        }
        assert_eq!(
            inverse(&[[1.0, 2.0, 3.0], [2.0, 4.0, 6.0], [0.0, 1.0, 1.0]]).1,
            0.0
        );
    }
}
