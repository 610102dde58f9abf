//! C99: the flags of a sample, 1 to 16 (saturated, outside validity, not finite).

use core::fmt::Write as _;

use sagnac_core::{Output, Real, Sensor};

use super::super::Plan;
use super::lit;

pub(super) fn flags_of<T: Real>(plan: &Plan<T>, out: &mut String) {
    let p = plan.precision;
    let (offset, couples) = (plan.has_offset(), plan.couples());
    out.push_str("\n    /* 16: a value that is needed is not finite */\n");
    for sensor in Sensor::ALL {
        let key = sensor.key();
        let t = if plan.depends_on_temperature(sensor) {
            " && (size_of(raw->temperature) <= REAL_MAX)"
        } else {
            ""
        };
        let _ = writeln!(out, "    {key}_ok = are_numbers(raw->{key}){t};");
    }
    if offset {
        out.push_str("    accel_ok = accel_ok && gyro_ok && are_numbers(tangential);\n");
    }
    if couples {
        out.push_str("    gyro_ok = gyro_ok && accel_ok;\n");
    }
    for (sensor, bit) in [(Sensor::Gyro, 1), (Sensor::Accel, 2)] {
        let key = sensor.key();
        let edges = plan.inverse.saturation(sensor);
        for (axis, edge) in edges.iter().enumerate() {
            if edge.is_finite() {
                let what = match plan.model.triad(sensor).resolution.output {
                    Output::Rate => "range",
                    Output::Increment => "range less one increment",
                };
                let _ = writeln!(
                    out,
                    "    if (size_of(raw->{key}[{axis}]) >= {}) {{\n        flags |= {bit}u; /* {what} */\n    }}",
                    lit(*edge, p)
                );
            }
        }
    }
    out.push_str("\n    /* 8: the solution must stay in the box of the convergence bound */\n");
    let tangential = |u: &str| {
        if offset {
            format!(" && are_within(tangential, {u})")
        } else {
            String::new()
        }
    };
    if let Some(bound) = plan.inverse.bound() {
        let (g, a) = (lit(bound.limit[0], p), lit(bound.limit[1], p));
        let _ = write!(
            out,
            "    if (gyro_ok && !are_within(w, {g})) {{\n        boxed = 0;\n    }}\n    if (accel_ok && !(are_within(sensed, {a}){})) {{\n        boxed = 0;\n    }}\n",
            tangential(&a)
        );
    } else {
        let c = |x: f64| lit(T::from_f64(x), p);
        let size = |sensor: Sensor| {
            if let Some(range) = plan.inverse.range(sensor) {
                lit(range, p)
            } else {
                let key = sensor.key();
                format!(
                    "larger(size_of(raw->{key}[0]), larger(size_of(raw->{key}[1]), size_of(raw->{key}[2])))"
                )
            }
        };
        let terms = plan.inverse.bound_terms();
        let nu = |s: usize, u: &str| {
            let one = |k: usize| {
                format!(
                    "({} * {u} + {} * ({u} * {u}) + {})",
                    lit(terms.quadratic[s][k] + terms.quadratic[s][k], p),
                    lit(T::from_f64(3.0) * terms.cubic[s][k], p),
                    lit(T::HALF * terms.asymmetry[s][k], p)
                )
            };
            format!("larger({}, larger({}, {}))", one(0), one(1), one(2))
        };
        let _ = write!(
            out,
            "    {{
        const real limit_g = {c15} * ({rg} + {bg});
        const real limit_a = {c15} * ({ra} + {ba});
        const real nu_g = {nug};
        const real nu_a = {nua};
        const real lever = limit_g * {ll};
        const real force = {c2} * limit_a + limit_g * limit_g * {lf};
        const real gamma = {g} + {c2} * force * {h};
        const real from_f = force * {g} + force * force * {h};
        const real delta = (from_f > {c0}) ? (from_f / limit_g) : {c0};
        const real q = larger(nu_a / {m1a}, (nu_g + gamma * lever) / {m1g});
        if (!(({mua} + nu_a <= {third}) && ({mug} + nu_g + delta <= {third}) && (q <= {half}))) {{
            boxed = 0;
        }}
        if (gyro_ok && !are_within(w, limit_g)) {{
            boxed = 0;
        }}
        if (accel_ok && !(are_within(sensed, limit_a){tan})) {{
            boxed = 0;
        }}
    }}
",
            c15 = c(1.5),
            c2 = c(2.0),
            c0 = c(0.0),
            half = c(0.5),
            third = lit(T::ONE / T::from_f64(3.0), p),
            rg = size(Sensor::Gyro),
            ra = size(Sensor::Accel),
            bg = lit(terms.bias[0], p),
            ba = lit(terms.bias[1], p),
            nug = nu(0, "limit_g"),
            nua = nu(1, "limit_a"),
            ll = lit(terms.lever_l, p),
            lf = lit(terms.lever_f, p),
            g = lit(terms.g, p),
            h = lit(terms.h, p),
            m1g = lit(T::ONE - terms.mu[0], p),
            m1a = lit(T::ONE - terms.mu[1], p),
            mug = lit(terms.mu[0], p),
            mua = lit(terms.mu[1], p),
            tan = tangential("limit_a"),
        );
    }
    out.push_str("    if (!boxed) {\n        flags |= 8u;\n    }\n");
    out.push_str(
        "
    /* 16 as well where the rounds ran off to infinity */
    gyro_ok = gyro_ok && are_numbers(w);
    accel_ok = accel_ok && are_numbers(f);
    if (!(gyro_ok && accel_ok)) {
        flags |= 16u;
    }
",
    );
}
