//! GTSAM PreintegrationCombinedParams: continuous-time covariances N² and K² times the identity.

use super::Source;
use super::text::{comment, number};
use crate::error::Error;
use sagnac_core::Sensor;

/// Where a model has no run-to-run bias, as the other tools do.
pub(super) const SMALL_BIAS: f64 = 1e-3;

pub(super) fn write(source: &Source) -> Result<String, Error> {
    let mut body = String::new();
    for (sensor, white_key, walk_key) in [
        (
            Sensor::Gyro,
            "setGyroscopeCovariance",
            "setBiasOmegaCovariance",
        ),
        (
            Sensor::Accel,
            "setAccelerometerCovariance",
            "setBiasAccCovariance",
        ),
    ] {
        let white = source.white(sensor)?;
        let walk = source.needed_walk(sensor)?;
        body.push_str(&comment("    #", &white.comment));
        body.push_str(&format!(
            "    params.{white_key}(np.eye(3) * {} ** 2)\n",
            number(white.largest())
        ));
        body.push_str(&comment("    #", &walk.comment));
        body.push_str(&format!(
            "    params.{walk_key}(np.eye(3) * {} ** 2)\n",
            number(walk.largest())
        ));
    }
    let (accel, accel_known) = source.run_to_run(Sensor::Accel);
    let (gyro, gyro_known) = source.run_to_run(Sensor::Gyro);
    let sigma = |value: f64, known: bool| if known { value } else { SMALL_BIAS };
    let accel_sigma = sigma(accel.largest(), accel_known);
    let gyro_sigma = sigma(gyro.largest(), gyro_known);
    body.push_str(&comment(
        "    #",
        &format!("accelerometer {}", accel.comment),
    ));
    body.push_str(&comment("    #", &format!("gyro {}", gyro.comment)));
    body.push_str(&format!(
        "    # gtsam from 4.3 on has it no more\n    if hasattr(params, \"setBiasAccOmegaInit\"):\n        params.setBiasAccOmegaInit(np.diag([{0} ** 2] * 3 + [{1} ** 2] * 3))\n",
        number(accel_sigma),
        number(gyro_sigma)
    ));
    Ok(format!(
        "{}import gtsam\nimport numpy as np\n\n\ndef make_params(gravity=9.80665):\n    # navigation frame z up; use MakeSharedD for z down\n    params = gtsam.PreintegrationCombinedParams.MakeSharedU(gravity)\n{body}    # of the integration itself: small\n    params.setIntegrationCovariance(np.eye(3) * 1.0e-8 ** 2)\n    return params\n",
        comment("#", &source.head())
    ))
}
