//! The attitude that a run starts with: the truth's, turned by a drawn error, or by what 600 s at rest with the run's own
//! sensor give (navigation.md §3.4).

use super::Request;
use super::truth::Channels;
use super::unit::{BLOCK, EMPTY, Scratch, Unit};
use crate::attitude::{Vec3, from_rotation_vector, mul, mul_vec, mul_vec_t, transpose};
use crate::covariance::SELF_ALIGNMENT_S;
use crate::drift::Alignment;
use crate::strapdown::State;
use sagnac_core::Compensation;
use sagnac_noise::{Purpose, StreamKey};

/// The attitude that a run starts with.
pub(super) fn aligned(
    request: &Request<'_>,
    run: u32,
    unit: &mut Unit,
    truth: &State,
    correct: Option<&Compensation<f64>>,
    temperature_c: f64,
    scratch: &mut Scratch,
) -> crate::attitude::Mat3 {
    let earth = request.trajectory.earth();
    let place = earth.place(truth.position_e);
    let e_from_n = place.e_from_n();
    let key = StreamKey {
        seed: request.seed,
        run,
        sensor: 0,
        axis: 0,
    };
    let epsilon_n: Vec3 = match request.setting.alignment {
        Alignment::Perfect => return truth.e_from_b,
        Alignment::Given {
            roll_rad,
            pitch_rad,
            heading_rad,
        } => {
            let n_from_b = mul(&transpose(&e_from_n), &truth.e_from_b);
            let (s, c) = n_from_b[1][0].atan2(n_from_b[0][0]).sin_cos();
            let draw = |i: u32, sigma: f64| sigma * key.draw(Purpose::Other, 10 + i);
            let (roll, pitch, heading) =
                (draw(0, roll_rad), draw(1, pitch_rad), draw(2, heading_rad));
            [c * roll - s * pitch, s * roll + c * pitch, heading]
        }
        Alignment::SelfAligned => {
            // 600 s of samples at rest in the start attitude, with the run's own sensor.
            let gravity = earth.gravity_e(&place);
            let force = mul_vec_t(&truth.e_from_b, gravity.map(|g| -g));
            let rate = mul_vec_t(&truth.e_from_b, [0.0, 0.0, earth.rate_rad_s()]);
            let still = Channels {
                force: force.map(|f| vec![f; BLOCK]),
                rate: rate.map(|w| vec![w; BLOCK]),
                rate_dot: [0.0; 3].map(|z: f64| vec![z; BLOCK]),
                temperature: vec![temperature_c; BLOCK],
                vertical: vec![[0.0; 2]; BLOCK],
            };
            let total = (SELF_ALIGNMENT_S / request.setting.dt_s).round() as usize;
            let (mut sum, mut corrected) = ([0.0; 6], EMPTY);
            let mut done = 0;
            while done < total {
                let n = BLOCK.min(total - done);
                let dt_s = request.setting.dt_s;
                unit.block(&still, 0, n, correct, dt_s, true, scratch, &mut corrected);
                for c in 0..6 {
                    sum[c] += corrected[c][..n].iter().sum::<f64>();
                }
                done += n;
            }
            let mean = sum.map(|s| s / total as f64);
            let to_n = |v: Vec3| mul_vec_t(&e_from_n, mul_vec(&truth.e_from_b, v));
            let f = to_n([mean[3] - force[0], mean[4] - force[1], mean[5] - force[2]]);
            let w = to_n([mean[0] - rate[0], mean[1] - rate[1], mean[2] - rate[2]]);
            let g = crate::attitude::norm(gravity);
            let latitude = place.latitude_rad();
            [
                -f[1] / g,
                f[0] / g,
                -w[1] / (earth.rate_rad_s() * latitude.cos()) + f[1] / g * latitude.tan(),
            ]
        }
    };
    mul(
        &from_rotation_vector(mul_vec(&e_from_n, epsilon_n)),
        &truth.e_from_b,
    )
}
