//! The panels of `calibrate thermal`: each axis against temperature, every branch a line of its own, and its residuals.

use sagnac_calibrate::thermal::{BinMean, Curve, Kind, channel};
use sagnac_report::plots::{ChartCurve, Color, CurveChart, Figure, axis_title};
use sagnac_report::text::significant;

use super::text::{degrees, shown};
use crate::calibrate::sheet::page_unit;

/// A line for each branch, along its temperature; the one of each direction that reaches the highest is named.
fn branches(curve: &Curve, value: impl Fn(&BinMean) -> f64) -> Vec<ChartCurve> {
    let mut numbers: Vec<usize> = curve.bins.iter().map(|b| b.branch).collect();
    numbers.sort_unstable();
    numbers.dedup();
    let mut lines: Vec<(bool, Vec<&BinMean>)> = numbers
        .into_iter()
        .filter_map(|number| {
            let mut bins: Vec<&BinMean> =
                curve.bins.iter().filter(|b| b.branch == number).collect();
            bins.sort_by(|a, b| a.temperature_c.total_cmp(&b.temperature_c));
            Some((bins.first()?.is_heating, bins))
        })
        .collect();
    let end = |bins: &[&BinMean]| bins.last().map_or(f64::NEG_INFINITY, |b| b.temperature_c);
    lines.sort_by(|a, b| end(&b.1).total_cmp(&end(&a.1)));
    let mut named = [false; 2];
    lines
        .into_iter()
        .map(|(is_heating, bins)| {
            let is_first = !std::mem::replace(&mut named[usize::from(is_heating)], true);
            let word = if is_heating { "heating" } else { "cooling" };
            ChartCurve {
                label: if is_first { word } else { "" }.to_owned(),
                color: Color::Data,
                x: bins.iter().map(|b| b.temperature_c).collect(),
                y: bins.iter().map(|b| value(b)).collect(),
                dashed: !is_heating,
                ..ChartCurve::default()
            }
        })
        .collect()
}

/// The curve of one axis with its band, heating and cooling beside it.
pub(super) fn curve_figure(curve: &Curve) -> Figure {
    let (unit, factor) = shown(curve);
    let scaled = |v: &[f64]| -> Vec<f64> { v.iter().map(|v| v * factor).collect() };
    let name = channel(curve.sensor, curve.axis);
    let word = match curve.kind {
        Kind::Bias => "output",
        Kind::ScaleFactor => "scale factor",
    };
    let mut curves = vec![ChartCurve {
        label: "middle".to_owned(),
        color: Color::Fit,
        x: curve.temperature_c.clone(),
        y: scaled(&curve.value),
        lower: scaled(&curve.lower),
        upper: scaled(&curve.upper),
        series: "fit".to_owned(),
        ..ChartCurve::default()
    }];
    if curve.kind == Kind::Bias {
        curves.extend(branches(curve, |b| b.value * factor));
    }
    let chart = CurveChart {
        id: format!("thermal-{name}-{}", curve.kind.key()),
        title: format!("{} against temperature", axis_title(&name)),
        x_title: "temperature, °C".to_owned(),
        y_title: format!("{word}, {}", page_unit(unit)),
        x_log: false,
        y_log: false,
        curves,
        width: 360.0,
        height: 270.0,
        ..CurveChart::default()
    };
    let rest = curve.hysteresis.map_or(String::new(), |h| {
        format!(
            ": heating − cooling at most {} {} at {} °C",
            significant(h.largest * factor, 2),
            page_unit(unit),
            degrees(h.at_c).replace('-', "−")
        )
    });
    Figure::new(
        "thermal-curve",
        &name,
        &axis_title(&name),
        &rest,
        chart.draw(),
    )
}

/// What the curve with its hysteresis leaves of every bin.
pub(super) fn residual_figure(curve: &Curve) -> Figure {
    let (unit, factor) = shown(curve);
    let name = channel(curve.sensor, curve.axis);
    let chart = CurveChart {
        id: format!("thermal-residual-{name}"),
        title: format!("Residuals of {} against temperature", axis_title(&name)),
        x_title: "temperature, °C".to_owned(),
        y_title: format!("residual, {}", page_unit(unit)),
        x_log: false,
        y_log: false,
        curves: branches(curve, |b| b.residual * factor),
        width: 360.0,
        height: 210.0,
        ..CurveChart::default()
    };
    let rms = (curve
        .bins
        .iter()
        .map(|b| b.residual * b.residual)
        .sum::<f64>()
        / curve.bins.len().max(1) as f64)
        .sqrt();
    Figure::new(
        "calibration-residuals",
        &name,
        &axis_title(&name),
        &format!(
            ", each bin less the curve and half its hysteresis: {} {} rms",
            significant(rms * factor, 2),
            page_unit(unit)
        ),
        chart.draw(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use sagnac_core::Sensor;

    #[test]
    fn every_branch_is_a_line_of_its_own() {
        let bin = |branch: usize, is_heating: bool, temperature_c: f64, value: f64| BinMean {
            branch,
            is_heating,
            temperature_c,
            value,
            residual: 0.0,
            residual_single: 0.0,
        };
        // Two cooling branches, a unit apart, that share the temperatures from 40 to 50.
        let mut bins: Vec<BinMean> = (0..50).map(|t| bin(0, false, f64::from(t), 0.0)).collect();
        bins.extend((0..70).map(|t| bin(1, true, f64::from(t), 2.0)));
        bins.extend((40..70).map(|t| bin(2, false, f64::from(t), 1.0)));
        bins.sort_by(|a, b| a.temperature_c.total_cmp(&b.temperature_c));
        let curve = Curve {
            sensor: Sensor::Gyro,
            axis: 0,
            kind: Kind::Bias,
            is_spline: false,
            order: 0,
            temperature_c: vec![0.0, 70.0],
            value: vec![1.0; 2],
            sigma: vec![0.1; 2],
            lower: vec![0.8; 2],
            upper: vec![1.2; 2],
            heating_minus_cooling: None,
            hysteresis: None,
            cv_rms: Vec::new(),
            cv_rms_spline: Vec::new(),
            residual_rms: 0.0,
            residual_rms_single: 0.0,
            correlation: 0.0,
            bins,
        };
        let lines = branches(&curve, |b| b.value);
        assert_eq!(lines.len(), 3);
        for line in &lines {
            assert!(line.y.windows(2).all(|w| w[0] == w[1]), "{:?}", line.y);
        }
        let named = |word: &str| lines.iter().filter(|l| l.label == word).count();
        assert_eq!((named("cooling"), named("heating")), (1, 1));
    }
}
