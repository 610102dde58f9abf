//! The tests that a laboratory knows by name. `[IEEE1293]`, `[IEEE1554]`

use crate::stations::{Station, terms::AXES};

/// A component this small is a rounded zero.
const NOTHING: f64 = 1e-9;

fn along(k: usize, size: f64) -> [f64; 3] {
    let mut out = [0.0; 3];
    out[k] = size;
    out
}

fn sign(x: f64) -> char {
    if x < 0.0 { '-' } else { '+' }
}

/// Each axis up and down: f = +g, −g along x, y, z.
pub fn six_position(gravity_m_s2: f64) -> Vec<Station> {
    (0..6)
        .map(|i| {
            let (k, s) = (i / 2, if i % 2 == 0 { 1.0 } else { -1.0 });
            Station {
                f: along(k, s * gravity_m_s2),
                ..Station::new(&format!("{}{} up", sign(s), AXES[k]))
            }
        })
        .collect()
}

/// Each axis level in turn, the other two turned in steps of 45°.
pub fn tumble24(gravity_m_s2: f64) -> Vec<Station> {
    let mut out = Vec::with_capacity(24);
    for k in 0..3 {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        for step in 0..8 {
            let (sine, cosine) = (f64::from(step) * std::f64::consts::FRAC_PI_4).sin_cos();
            let mut f = [0.0; 3];
            for (axis, part) in [(i, cosine), (j, sine)] {
                let value = gravity_m_s2 * part;
                f[axis] = if value.abs() < NOTHING { 0.0 } else { value };
            }
            out.push(Station {
                f,
                ..Station::new(&format!("{} level, {} deg", AXES[k], 45 * step))
            });
        }
    }
    out
}

/// Each axis up on a rate table: nine rates up to ±`largest_rad_s`.
pub fn rate_table(gravity_m_s2: f64, largest_rad_s: f64) -> Vec<Station> {
    let mut out = Vec::with_capacity(27);
    for k in 0..3 {
        for part in [-1.0, -0.5, -0.25, -0.125, 0.0, 0.125, 0.25, 0.5, 1.0] {
            let w = largest_rad_s * part;
            out.push(Station {
                f: along(k, gravity_m_s2),
                w: along(k, w),
                ..Station::new(
                    &format!("{} up, {:.6} deg/s", AXES[k], w.to_degrees()).replace(".000000", ""),
                )
            });
        }
    }
    out
}

/// Each axis in and out along the arm of a centrifuge at 2, 5 and 10 g.
pub fn centrifuge(gravity_m_s2: f64, radius_m: f64) -> Vec<Station> {
    let mut out = Vec::with_capacity(18);
    for k in 0..3 {
        let i = (k + 1) % 3;
        for s in [1.0, -1.0] {
            for size in [2.0, 5.0, 10.0] {
                let a = size * 9.80665;
                let mut f = along(k, s * a);
                f[i] = gravity_m_s2;
                out.push(Station {
                    f,
                    w: along(i, (a / radius_m).sqrt()),
                    ..Station::new(&format!("{}{} {size} g", sign(s), AXES[k]))
                });
            }
        }
    }
    out
}

/// The six positions at each temperature.
pub fn chamber(gravity_m_s2: f64, temperatures_c: &[f64]) -> Vec<Station> {
    temperatures_c
        .iter()
        .flat_map(|t| {
            six_position(gravity_m_s2)
                .into_iter()
                .map(move |s| Station {
                    label: format!("{}, {t} degC", s.label),
                    temperature_c: Some(*t),
                    ..s
                })
        })
        .collect()
}
