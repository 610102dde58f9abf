//! Three-vectors, rotation matrices and quaternions, C = [columns are the body axes]; quaternions scalar-first
//! (model.md §1). Rotation vectors and matrices are linked by Rodrigues' formula C = I + sin φ [u×] + (1 − cos φ)[u×]²
//! \[TITTERTON\].

/// A vector.
pub type Vec3 = [f64; 3];
/// A matrix, row by row.
pub type Mat3 = [[f64; 3]; 3];

/// The unit matrix.
pub const IDENTITY: Mat3 = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// a + b.
#[inline]
pub fn add(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// a − b.
#[inline]
pub fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// k·a.
#[inline]
pub fn scale(k: f64, a: Vec3) -> Vec3 {
    [k * a[0], k * a[1], k * a[2]]
}

/// a + k·b.
#[inline]
pub fn axpy(a: Vec3, k: f64, b: Vec3) -> Vec3 {
    [a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2]]
}

/// a·b.
#[inline]
pub fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a × b.
#[inline]
pub fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// |a|.
#[inline]
pub fn norm(a: Vec3) -> f64 {
    dot(a, a).sqrt()
}

/// M·a.
#[inline]
pub fn mul_vec(m: &Mat3, a: Vec3) -> Vec3 {
    [dot(m[0], a), dot(m[1], a), dot(m[2], a)]
}

/// Mᵀ·a.
#[inline]
pub fn mul_vec_t(m: &Mat3, a: Vec3) -> Vec3 {
    [
        m[0][0] * a[0] + m[1][0] * a[1] + m[2][0] * a[2],
        m[0][1] * a[0] + m[1][1] * a[1] + m[2][1] * a[2],
        m[0][2] * a[0] + m[1][2] * a[1] + m[2][2] * a[2],
    ]
}

/// A·B.
#[inline]
pub fn mul(a: &Mat3, b: &Mat3) -> Mat3 {
    [mul_vec_t(b, a[0]), mul_vec_t(b, a[1]), mul_vec_t(b, a[2])]
}

/// Mᵀ.
#[inline]
pub fn transpose(m: &Mat3) -> Mat3 {
    [
        [m[0][0], m[1][0], m[2][0]],
        [m[0][1], m[1][1], m[2][1]],
        [m[0][2], m[1][2], m[2][2]],
    ]
}

/// The matrix with the given columns.
#[inline]
pub fn from_columns(x: Vec3, y: Vec3, z: Vec3) -> Mat3 {
    [[x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]]
}

/// R_z(ψ) R_y(θ) R_x(φ) from the (cosine, sine) of yaw, pitch and roll.
#[inline]
pub fn from_yaw_pitch_roll(
    (cy, sy): (f64, f64),
    (cp, sp): (f64, f64),
    (cr, sr): (f64, f64),
) -> Mat3 {
    [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
}

/// (roll, pitch, yaw) in rad of a ZYX matrix; roll 0 where pitch is ±90°.
pub fn to_roll_pitch_yaw(m: &Mat3) -> Vec3 {
    let cp = m[2][1].hypot(m[2][2]);
    if cp < 1e-12 {
        return [0.0, (-m[2][0]).atan2(cp), (-m[0][1]).atan2(m[1][1])];
    }
    [
        m[2][1].atan2(m[2][2]),
        (-m[2][0]).atan2(cp),
        m[1][0].atan2(m[0][0]),
    ]
}

/// The rotation matrix of a rotation vector, rad (Rodrigues).
pub fn from_rotation_vector(v: Vec3) -> Mat3 {
    let angle_sq = dot(v, v);
    let angle = angle_sq.sqrt();
    let (s, c) = if angle < 1e-3 {
        (
            1.0 - angle_sq / 6.0 * (1.0 - angle_sq / 20.0),
            0.5 - angle_sq / 24.0 * (1.0 - angle_sq / 30.0),
        )
    } else {
        let half = (0.5 * angle).sin() / angle;
        (angle.sin() / angle, 2.0 * half * half)
    };
    let [x, y, z] = v;
    [
        [
            1.0 - c * (y * y + z * z),
            c * x * y - s * z,
            c * x * z + s * y,
        ],
        [
            c * x * y + s * z,
            1.0 - c * (x * x + z * z),
            c * y * z - s * x,
        ],
        [
            c * x * z - s * y,
            c * y * z + s * x,
            1.0 - c * (x * x + y * y),
        ],
    ]
}

/// The rotation vector of a matrix, rad, for angles below π.
pub fn to_rotation_vector(m: &Mat3) -> Vec3 {
    let q = to_quaternion(m);
    let v = [q[1], q[2], q[3]];
    let s = norm(v);
    if s < 1e-300 {
        return [0.0; 3];
    }
    let angle = 2.0 * s.atan2(q[0]);
    scale(angle / s, v)
}

/// The unit quaternion [w, x, y, z], w ≥ 0, of a rotation matrix (Shepperd's choice of the largest element).
pub fn to_quaternion(m: &Mat3) -> [f64; 4] {
    let trace = m[0][0] + m[1][1] + m[2][2];
    let candidates = [trace, m[0][0], m[1][1], m[2][2]];
    let mut best = 0;
    for i in 1..4 {
        if candidates[i] > candidates[best] {
            best = i;
        }
    }
    let q = match best {
        0 => [
            1.0 + trace,
            m[2][1] - m[1][2],
            m[0][2] - m[2][0],
            m[1][0] - m[0][1],
        ],
        1 => [
            m[2][1] - m[1][2],
            1.0 + 2.0 * m[0][0] - trace,
            m[0][1] + m[1][0],
            m[0][2] + m[2][0],
        ],
        2 => [
            m[0][2] - m[2][0],
            m[0][1] + m[1][0],
            1.0 + 2.0 * m[1][1] - trace,
            m[1][2] + m[2][1],
        ],
        _ => [
            m[1][0] - m[0][1],
            m[0][2] + m[2][0],
            m[1][2] + m[2][1],
            1.0 + 2.0 * m[2][2] - trace,
        ],
    };
    let n = (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]).sqrt();
    let k = if q[0] < 0.0 { -1.0 / n } else { 1.0 / n };
    [k * q[0], k * q[1], k * q[2], k * q[3]]
}

/// The rotation matrix of a quaternion [w, x, y, z] of any length but zero.
pub fn from_quaternion(q: [f64; 4]) -> Mat3 {
    let [w, x, y, z] = q;
    let k = 2.0 / (w * w + x * x + y * y + z * z);
    [
        [
            1.0 - k * (y * y + z * z),
            k * (x * y - w * z),
            k * (x * z + w * y),
        ],
        [
            k * (x * y + w * z),
            1.0 - k * (x * x + z * z),
            k * (y * z - w * x),
        ],
        [
            k * (x * z - w * y),
            k * (y * z + w * x),
            1.0 - k * (x * x + y * y),
        ],
    ]
}

/// The quaternion product p·q: first q, then p.
#[inline]
pub fn quaternion_product(p: [f64; 4], q: [f64; 4]) -> [f64; 4] {
    [
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conversions_agree() {
        for v in [
            [0.3, -0.2, 0.9],
            [3.0, 0.1, 0.05],
            [-0.01, 2.9, 0.3],
            [0.1, 0.2, 3.1],
            [1e-6, -2e-6, 3e-7],
        ] {
            let m = from_rotation_vector(v);
            let from_q = from_quaternion(to_quaternion(&m));
            let [roll, pitch, yaw] = to_roll_pitch_yaw(&m);
            let from_angles = from_yaw_pitch_roll(
                (yaw.cos(), yaw.sin()),
                (pitch.cos(), pitch.sin()),
                (roll.cos(), roll.sin()),
            );
            let back = to_rotation_vector(&m);
            for i in 0..3 {
                // Each conversion is a dozen roundings of numbers of at most 3.
                assert!((back[i] - v[i]).abs() < 1e-14);
                for j in 0..3 {
                    assert!((from_q[i][j] - m[i][j]).abs() < 1e-14);
                    assert!((from_angles[i][j] - m[i][j]).abs() < 1e-14);
                }
            }
        }
    }

    #[test]
    fn product_of_quaternions_is_product_of_matrices() {
        let (a, b) = (
            from_rotation_vector([0.3, -0.2, 0.9]),
            from_rotation_vector([-1.0, 0.4, 0.2]),
        );
        let m = from_quaternion(quaternion_product(to_quaternion(&a), to_quaternion(&b)));
        let want = mul(&a, &b);
        for i in 0..3 {
            for j in 0..3 {
                assert!((m[i][j] - want[i][j]).abs() < 1e-14);
            }
        }
    }
}
