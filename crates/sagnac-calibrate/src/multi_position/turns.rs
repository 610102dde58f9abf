//! Turns between rests: the rotation that the gyro saw, and how it depends on the gyro's parameters.
//!
//! R = Π exp(−[φ_k×]), φ_k = Δθ_k + Δθ_{k−1} × Δθ_k / 12, Δθ = dt (I+M)⁻¹(gyro − b − G f̂). `[SAVAGE1998]`.

use nalgebra::{Matrix3, Vector3};

use super::Recording;
use super::accel;

/// Samples of a turn: those after one rest up to the first used sample of the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Turn {
    /// The rest before it; the next one is after it.
    pub(super) rest: usize,
    pub(super) first: usize,
    pub(super) end: usize,
}

/// What an integration gives.
#[derive(Clone, Debug)]
pub(super) struct Swept {
    /// Coordinates after the turn from those before.
    pub(super) rotation: Matrix3<f64>,
    /// Σ P_k dt: angle at the end by a constant rate in body axes.
    pub(super) bias: Matrix3<f64>,
    /// Σ P_k dt ω̂_j.
    pub(super) rate: [Matrix3<f64>; 3],
    /// Σ P_k dt f̂_j.
    pub(super) force: [Matrix3<f64>; 3],
    /// Σ P_k diag(σ dt)² P_kᵀ for output noise of unit size on each axis, through (I+M)⁻¹.
    pub(super) noise: Matrix3<f64>,
}

/// The gyro's parameters as the integration takes them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Correction {
    pub(super) bias: Vector3<f64>,
    pub(super) inverse: Matrix3<f64>,
    pub(super) g: Matrix3<f64>,
    /// Standard deviation of a gyro sample.
    pub(super) sigma: [f64; 3],
}

/// [v×].
pub(super) fn cross(v: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -v.z, v.y, v.z, 0.0, -v.x, -v.y, v.x, 0.0)
}

/// exp(−[φ×]).
fn backward(phi: &Vector3<f64>) -> Matrix3<f64> {
    let square = phi.norm_squared();
    let (a, b) = if square < 1e-4 {
        (
            1.0 - square / 6.0 * (1.0 - square / 20.0),
            0.5 - square / 24.0 * (1.0 - square / 30.0),
        )
    } else {
        let angle = square.sqrt();
        (angle.sin() / angle, (1.0 - angle.cos()) / square)
    };
    let k = cross(phi);
    Matrix3::identity() - k * a + k * k * b
}

/// Integrates samples `first..end` of rates and forces; `at(k)` gives both of sample k.
pub(super) fn sweep(
    samples: impl Iterator<Item = (Vector3<f64>, Vector3<f64>)>,
    correction: &Correction,
    dt_s: f64,
) -> Swept {
    let mut r = Matrix3::<f64>::identity();
    let mut last: Option<Vector3<f64>> = None;
    let mut bias = Matrix3::zeros();
    let mut rate = [Matrix3::zeros(); 3];
    let mut force = [Matrix3::zeros(); 3];
    let mut noise = Matrix3::zeros();
    let spread = correction.inverse
        * Matrix3::from_diagonal(&Vector3::from(correction.sigma.map(|s| s * dt_s)));
    for (output, f) in samples {
        let w = correction.inverse * (output - correction.bias - correction.g * f);
        let angle = w * dt_s;
        let phi = match &last {
            Some(before) => angle + before.cross(&angle) / 12.0,
            None => angle,
        };
        last = Some(angle);
        let next = backward(&phi) * r;
        // To the frame before the turn, by the attitude in the middle of the sample.
        let middle = (r + next).transpose() * (0.5 * dt_s);
        bias += middle;
        for j in 0..3 {
            rate[j] += middle * w[j];
            force[j] += middle * f[j];
        }
        let column = middle * spread / dt_s;
        noise += column * column.transpose();
        r = next;
    }
    Swept {
        rotation: r,
        bias: r * bias,
        rate: rate.map(|m| r * m),
        force: force.map(|m| r * m),
        noise: r * noise * r.transpose(),
    }
}

/// The samples of a turn: gyro output, and specific force by the accelerometer's estimate.
pub(super) fn samples<'a>(
    recording: &'a Recording<'a>,
    gyro: &'a [&'a [f64]; 3],
    turn: Turn,
    inverse: Matrix3<f64>,
    state: accel::State,
) -> impl Iterator<Item = (Vector3<f64>, Vector3<f64>)> + 'a {
    let bias = state.bias();
    (turn.first..turn.end).map(move |k| {
        let out = |axes: &[&[f64]; 3]| Vector3::new(axes[0][k], axes[1][k], axes[2][k]);
        (out(gyro), inverse * (out(&recording.accel) - bias))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn still() -> Correction {
        Correction {
            bias: Vector3::zeros(),
            inverse: Matrix3::identity(),
            g: Matrix3::zeros(),
            sigma: [1.0; 3],
        }
    }

    #[test]
    fn a_quarter_turn_about_z_takes_x_to_minus_y_in_body_axes() {
        let rate = Vector3::new(0.0, 0.0, std::f64::consts::FRAC_PI_2);
        let swept = sweep((0..100).map(|_| (rate, Vector3::zeros())), &still(), 0.01);
        let u = swept.rotation * Vector3::x();
        assert!((u + Vector3::y()).norm() < 1e-12, "{u}");
    }

    #[test]
    fn the_derivatives_are_those_of_differences() {
        let samples: Vec<(Vector3<f64>, Vector3<f64>)> = (0..150)
            .map(|k| {
                let t = f64::from(k) * 0.01;
                let w = Vector3::new((3.0 * t).sin(), 0.7 * t, (2.0 * t).cos());
                (w, Vector3::new(t, 1.0 - t, 9.0))
            })
            .collect();
        let swept = sweep(samples.iter().copied(), &still(), 0.01);
        let u = Vector3::new(0.3, -0.5, 0.8);
        for j in 0..3 {
            let mut moved = still();
            moved.bias[j] = 1e-6;
            let other = sweep(samples.iter().copied(), &moved, 0.01);
            // A bias taken out turns the other way: δ(Ru) = −[Ru×] Σ P dt δb.
            let slope = (other.rotation - swept.rotation) * u / 1e-6;
            let predicted = -(cross(&(swept.rotation * u)) * swept.bias.column(j));
            // The attitude in the middle of a 10 ms sample is taken from its ends: 1e-4 of the slope.
            assert!(
                (slope - predicted).norm() < 1e-3 * slope.norm(),
                "{slope} {predicted}"
            );
        }
    }
}
