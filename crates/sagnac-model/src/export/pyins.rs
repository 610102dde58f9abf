//! pyins: EstimationModel(bias_sd, noise, bias_walk, scale_misal_sd) and Parameters(transform, bias, noise, bias_walk), SI.

use super::Source;
use super::text::{comment, list, nested};
use crate::error::Error;
use sagnac_core::Sensor;

pub(super) fn write(source: &Source) -> Result<String, Error> {
    let mut text = comment("#", &source.head());
    text.push_str("from pyins.inertial_sensor import EstimationModel, Parameters\n");
    for (sensor, name) in [(Sensor::Gyro, "gyro"), (Sensor::Accel, "accel")] {
        let white = source.white(sensor)?;
        let walk = source.walk(sensor);
        let (bias_sd, known) = source.run_to_run(sensor);
        let stability = source.model.stability(sensor);
        let mut scale_misal = [[0.0; 3]; 3];
        for (element, (row, column)) in [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)]
            .into_iter()
            .enumerate()
        {
            scale_misal[row][column] = stability.misalignment[element];
        }
        for (axis, row) in scale_misal.iter_mut().enumerate() {
            row[axis] = stability.scale_factor[axis];
        }
        let bias = source.fixed_bias(sensor);
        text.push('\n');
        for note in [&bias_sd.comment, &white.comment, &walk.comment] {
            text.push_str(&comment("#", note));
        }
        if !known && walk.largest() > 0.0 {
            text.push_str(
                "# pyins needs bias_sd above zero for a bias walk: state the run-to-run bias\n",
            );
        }
        text.push_str(&format!(
            "{name}_model = EstimationModel(\n    bias_sd={},\n    noise={},\n    bias_walk={},\n    scale_misal_sd={},\n)\n",
            list(&bias_sd.axes),
            list(&white.axes),
            list(&walk.axes),
            nested(&scale_misal)
        ));
        text.push_str(&comment(
            "#",
            &format!("reading = transform x + bias + noise; {}", bias.comment),
        ));
        text.push_str(&format!(
            "{name}_parameters = Parameters(\n    transform={},\n    bias={},\n    noise={},\n    bias_walk={},\n)\n",
            nested(&source.matrix(sensor)),
            list(&bias.axes),
            list(&white.axes),
            list(&walk.axes)
        ));
    }
    Ok(text)
}
