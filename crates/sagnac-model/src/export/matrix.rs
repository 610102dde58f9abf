//! 3×3 matrices: product, inverse, and the factors of A = L·Q, L lower triangular with positive diagonal, Q a rotation.

pub(crate) type Matrix = [[f64; 3]; 3];

pub(crate) const IDENTITY: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

pub(crate) fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let mut c = [[0.0; 3]; 3];
    for (i, row) in c.iter_mut().enumerate() {
        for (j, value) in row.iter_mut().enumerate() {
            *value = (0..3).map(|k| a[i][k] * b[k][j]).sum();
        }
    }
    c
}

pub(crate) fn apply(a: &Matrix, v: [f64; 3]) -> [f64; 3] {
    a.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

pub(crate) fn transposed(a: &Matrix) -> Matrix {
    let mut t = [[0.0; 3]; 3];
    for (i, row) in a.iter().enumerate() {
        for (j, value) in row.iter().enumerate() {
            t[j][i] = *value;
        }
    }
    t
}

/// A⁻¹; none where A is singular.
pub(crate) fn inverse(a: &Matrix) -> Option<Matrix> {
    let minor = |i: usize, j: usize| {
        let [r, s] = [(i + 1) % 3, (i + 2) % 3];
        let [c, d] = [(j + 1) % 3, (j + 2) % 3];
        a[r][c] * a[s][d] - a[r][d] * a[s][c]
    };
    let determinant: f64 = (0..3).map(|j| a[0][j] * minor(0, j)).sum();
    if !(determinant.is_finite() && determinant.abs() > 1e-12) {
        return None;
    }
    let mut inverse = [[0.0; 3]; 3];
    for (i, row) in inverse.iter_mut().enumerate() {
        for (j, value) in row.iter_mut().enumerate() {
            *value = minor(j, i) / determinant;
        }
    }
    Some(inverse)
}

/// L and Q of A = L·Q by Gram–Schmidt on the rows; none where A is singular or mirrors.
pub(crate) fn lower_and_rotation(a: &Matrix) -> Option<(Matrix, Matrix)> {
    let mut lower = [[0.0; 3]; 3];
    let mut rotation: Matrix = [[0.0; 3]; 3];
    for i in 0..3 {
        let mut rest = a[i];
        // Twice is enough: the second pass removes what rounding left.
        for _ in 0..2 {
            for j in 0..i {
                let along: f64 = (0..3).map(|k| rest[k] * rotation[j][k]).sum();
                lower[i][j] += along;
                for k in 0..3 {
                    rest[k] -= along * rotation[j][k];
                }
            }
        }
        let length = rest.iter().map(|x| x * x).sum::<f64>().sqrt();
        if !(length.is_finite() && length > 1e-9) {
            return None;
        }
        lower[i][i] = length;
        rotation[i] = rest.map(|x| x / length);
    }
    let [x, y, z] = rotation;
    let cross = [
        x[1] * y[2] - x[2] * y[1],
        x[2] * y[0] - x[0] * y[2],
        x[0] * y[1] - x[1] * y[0],
    ];
    let handed: f64 = (0..3).map(|k| cross[k] * z[k]).sum();
    (handed > 0.0).then_some((lower, rotation))
}

/// The angle of a rotation [rad].
pub(crate) fn angle(q: &Matrix) -> f64 {
    let sine = [q[2][1] - q[1][2], q[0][2] - q[2][0], q[1][0] - q[0][1]];
    let twice_sine = sine.iter().map(|x| x * x).sum::<f64>().sqrt();
    let twice_cosine = q[0][0] + q[1][1] + q[2][2] - 1.0;
    twice_sine.atan2(twice_cosine)
}

#[cfg(test)]
mod tests {
    use super::{angle, inverse, lower_and_rotation, product};

    #[test]
    fn factors_multiply_back() {
        let a = [
            [1.01, 0.002, -0.003],
            [0.004, 0.99, 0.001],
            [-0.002, 0.005, 1.003],
        ];
        let Some((l, q)) = lower_and_rotation(&a) else {
            panic!("regular")
        };
        let back = product(&l, &q);
        let Some(inverse) = inverse(&a) else {
            panic!("regular")
        };
        let one = product(&a, &inverse);
        for i in 0..3 {
            for j in 0..3 {
                assert!((back[i][j] - a[i][j]).abs() < 1e-15);
                assert!((one[i][j] - f64::from(u8::from(i == j))).abs() < 1e-15);
                if j > i {
                    assert_eq!(l[i][j], 0.0);
                }
            }
        }
        assert!(angle(&q) > 1e-3 && angle(&q) < 1e-2);
        assert!(lower_and_rotation(&[[0.0; 3]; 3]).is_none());
    }
}
