//! C99: header, function, test and example.

use core::fmt::Write as _;

use sagnac_core::{Output, Real, Sensor};

use super::{EmittedFile, Plan, Table, number};

pub(super) fn files<T: Real>(plan: &Plan<T>) -> Vec<EmittedFile> {
    let p = plan.precision;
    let file = |suffix: &str, text| EmittedFile {
        name: format!("sagnac_correct_{p}{suffix}"),
        text,
    };
    vec![
        file(".h", header(plan)),
        file(".c", source(plan)),
        file("_test.c", test(plan)),
        file("_example.c", example(plan)),
    ]
}

fn real(p: &str) -> &'static str {
    if p == "f32" { "float" } else { "double" }
}

fn lit<T: Real>(x: T, p: &str) -> String {
    let text = number(x, p);
    if p == "f32" { format!("{text}f") } else { text }
}

fn list<T: Real>(values: &[T], p: &str) -> String {
    values
        .iter()
        .map(|x| lit(*x, p))
        .collect::<Vec<_>>()
        .join(", ")
}

fn header<T: Real>(plan: &Plan<T>) -> String {
    let (p, real) = (plan.precision, real(plan.precision));
    let up = p.to_uppercase();
    let mut out = String::new();
    for line in plan.head() {
        let _ = writeln!(out, "/* {line} */");
    }
    let _ = write!(
        out,
        "#ifndef SAGNAC_CORRECT_{up}_H
#define SAGNAC_CORRECT_{up}_H

#include <stdint.h>

/* One reading: rad/s, m/s^2, rad/s^2, degC. gyro_rate is the angular acceleration; zero where it is not known. */
typedef struct {{
    {real} gyro[3];
    {real} accel[3];
    {real} gyro_rate[3];
    {real} temperature;
}} sagnac_raw_{p};

/* The corrected reading: rad/s, m/s^2, and the sum of
   1 gyro saturated, 2 accelerometer saturated, 4 temperature outside the stated range,
   8 outside validity, 16 a value that is needed is not finite (the result is NaN). */
typedef struct {{
    {real} gyro[3];
    {real} accel[3];
    uint32_t flags;
}} sagnac_corrected_{p};

void sagnac_correct_{p}(const sagnac_raw_{p} *raw, sagnac_corrected_{p} *out);

#endif
"
    );
    out
}

fn array<T: Real>(out: &mut String, comment: &str, name: &str, values: &[T], p: &str) {
    let _ = writeln!(
        out,
        "/* {comment} */\nstatic const real {name}[{}] = {{{}}};",
        values.len(),
        list(values, p)
    );
}

fn table<T: Real>(out: &mut String, table: &Table<T>, p: &str) {
    let (name, unit) = (&table.name, table.unit);
    if !table.polynomial.is_empty() {
        let flat: Vec<T> = table.polynomial.iter().flatten().copied().collect();
        array(
            out,
            &format!("temperature polynomial, a row (x, y, z) per power from 1, {unit}/K^i"),
            &format!("{name}_polynomial"),
            &flat,
            p,
        );
    }
    if let Some((pieces, _)) = &table.spline {
        let flat: Vec<T> = pieces.iter().flatten().copied().collect();
        array(
            out,
            &format!(
                "temperature spline, a piece: start in degC, then c0, c1, c2, c3 for x, y, z, {unit}/K^i"
            ),
            &format!("{name}_spline"),
            &flat,
            p,
        );
    }
}

fn source<T: Real>(plan: &Plan<T>) -> String {
    let p = plan.precision;
    let mut out = String::new();
    for line in plan.head() {
        let _ = writeln!(out, "/* {line} */");
    }
    let _ = writeln!(
        out,
        "#include \"sagnac_correct_{p}.h\"\n\n#include <float.h>\n\ntypedef {} real;\n#define REAL_MAX {}\n#define ROUNDS {}\n",
        real(p),
        if p == "f32" { "FLT_MAX" } else { "DBL_MAX" },
        plan.inverse.rounds()
    );
    numbers(plan, &mut out);
    helpers(plan, &mut out);
    function(plan, &mut out);
    out
}

fn numbers<T: Real>(plan: &Plan<T>, out: &mut String) {
    let p = plan.precision;
    for sensor in Sensor::ALL {
        let (key, unit) = (
            sensor.key(),
            if sensor == Sensor::Gyro {
                "rad/s"
            } else {
                "m/s^2"
            },
        );
        let triad = plan.model.triad(sensor);
        array(
            out,
            &format!("{key} bias at T0, {unit}: x, y, z"),
            &format!("{key}_bias"),
            &triad.bias.fixed,
            p,
        );
        if plan.has_scale_table(sensor) {
            let flat: Vec<T> = plan.gain(sensor).iter().flatten().copied().collect();
            array(
                out,
                &format!("{key} I + M at T0: scale factor, misalignment, cross-axis response"),
                &format!("{key}_gain"),
                &flat,
                p,
            );
        } else {
            let flat: Vec<T> = plan
                .inverse
                .inverse(sensor)
                .iter()
                .flatten()
                .copied()
                .collect();
            array(
                out,
                &format!("{key} inverse of I + M: scale factor, misalignment, cross-axis response"),
                &format!("{key}_inverse"),
                &flat,
                p,
            );
        }
        if plan.is_nonlinear(sensor) {
            let n = &triad.nonlinearity;
            let (u2, u3) = if sensor == Sensor::Gyro {
                ("s/rad", "s^2/rad^2")
            } else {
                ("s^2/m", "s^4/m^2")
            };
            array(
                out,
                &format!("{key} quadratic k2, {u2}"),
                &format!("{key}_quadratic"),
                &n.quadratic,
                p,
            );
            array(
                out,
                &format!("{key} cubic k3, {u3}"),
                &format!("{key}_cubic"),
                &n.cubic,
                p,
            );
            array(
                out,
                &format!("{key} asymmetry a, a fraction"),
                &format!("{key}_asymmetry"),
                &triad.asymmetry.difference,
                p,
            );
        }
        for kind in 0..2 {
            if let Some(of) = plan.table(sensor, kind) {
                table(out, of, p);
            }
        }
    }
    if plan.has_g() {
        let flat: Vec<T> = plan
            .model
            .gyro_g_sensitivity
            .matrix
            .iter()
            .flatten()
            .copied()
            .collect();
        array(
            out,
            "g-sensitivity, (rad/s)/(m/s^2), row = gyro axis",
            "g_sensitivity",
            &flat,
            p,
        );
    }
    if plan.has_h() {
        let flat: Vec<T> = plan
            .model
            .gyro_g2_sensitivity
            .matrix
            .iter()
            .flatten()
            .copied()
            .collect();
        array(
            out,
            "g^2-sensitivity, (rad/s)/(m/s^2)^2, columns xx yy zz xy xz yz",
            "g2_sensitivity",
            &flat,
            p,
        );
    }
    if plan.has_offset() {
        let flat: Vec<T> = plan
            .model
            .accel_axis_offset
            .position
            .iter()
            .flatten()
            .copied()
            .collect();
        array(
            out,
            "positions of the accelerometers x, y, z from the IMU centre, m",
            "axis_offset",
            &flat,
            p,
        );
    }
    let t0 = plan.model.reference_temperature_c;
    if plan.has_polynomial() {
        let _ = writeln!(
            out,
            "/* reference temperature T0, degC */\nstatic const real reference_temperature = {};",
            lit(t0, p)
        );
    }
    out.push('\n');
}

fn helpers<T: Real>(plan: &Plan<T>, out: &mut String) {
    let p = plan.precision;
    let zero = lit(T::ZERO, p);
    let _ = write!(
        out,
        "static real size_of(real x)
{{
    return (x < {zero}) ? -x : x;
}}

static int are_numbers(const real v[3])
{{
    return (size_of(v[0]) <= REAL_MAX) && (size_of(v[1]) <= REAL_MAX) && (size_of(v[2]) <= REAL_MAX);
}}

static int are_within(const real v[3], real limit)
{{
    return (size_of(v[0]) <= limit) && (size_of(v[1]) <= limit) && (size_of(v[2]) <= limit);
}}

/* m v, m row by row */
static void apply(const real m[9], const real v[3], real result[3])
{{
    int k;
    for (k = 0; k < 3; k++) {{
        result[k] = m[3 * k] * v[0] + m[3 * k + 1] * v[1] + m[3 * k + 2] * v[2];
    }}
}}

"
    );
    if plan.has_scale_table(Sensor::Gyro) || plan.has_scale_table(Sensor::Accel) {
        let one = lit(T::ONE, p);
        let _ = write!(
            out,
            "/* inverse of a 3x3 matrix by cofactors */
static void invert(const real m[9], real result[9])
{{
    const real c0 = m[4] * m[8] - m[5] * m[7];
    const real c1 = m[5] * m[6] - m[3] * m[8];
    const real c2 = m[3] * m[7] - m[4] * m[6];
    const real r = {one} / (m[0] * c0 + m[1] * c1 + m[2] * c2);
    result[0] = c0 * r;
    result[1] = (m[7] * m[2] - m[8] * m[1]) * r;
    result[2] = (m[1] * m[5] - m[2] * m[4]) * r;
    result[3] = c1 * r;
    result[4] = (m[8] * m[0] - m[6] * m[2]) * r;
    result[5] = (m[2] * m[3] - m[0] * m[5]) * r;
    result[6] = c2 * r;
    result[7] = (m[6] * m[1] - m[7] * m[0]) * r;
    result[8] = (m[0] * m[4] - m[1] * m[3]) * r;
}}

"
        );
    }
    if plan
        .all_tables()
        .any(|t| t.range.is_some() || t.spline.is_some())
    {
        let _ = write!(
            out,
            "/* x held between two ends; NaN stays NaN */
static real hold(real x, real low, real high)
{{
    if (x < low) {{
        return low;
    }}
    return (x > high) ? high : x;
}}

"
        );
    }
    if plan.has_polynomial() {
        let _ = write!(
            out,
            "/* adds sum_i c_i theta^i for x, y, z, i from 1 */
static void add_polynomial(const real *c, int order, real theta, real to[3])
{{
    int i;
    int k;
    for (k = 0; k < 3; k++) {{
        real sum = {zero};
        for (i = order - 1; i >= 0; i--) {{
            sum = (sum + c[3 * i + k]) * theta;
        }}
        to[k] += sum;
    }}
}}

"
        );
    }
    if plan.has_spline() {
        let _ = write!(
            out,
            "/* adds the cubic piece in which t lies; a piece has 13 numbers */
static void add_spline(const real *pieces, int count, real t, real to[3])
{{
    const real *piece = pieces;
    int i;
    int k;
    for (i = 1; i < count; i++) {{
        if (pieces[13 * i] <= t) {{
            piece = &pieces[13 * i];
        }}
    }}
    for (k = 0; k < 3; k++) {{
        const real u = t - piece[0];
        to[k] += piece[1 + k] + u * (piece[4 + k] + u * (piece[7 + k] + u * piece[10 + k]));
    }}
}}

"
        );
    }
    if plan.is_nonlinear(Sensor::Gyro) || plan.is_nonlinear(Sensor::Accel) {
        let half = lit(T::HALF, p);
        let _ = write!(
            out,
            "/* k2 u^2 + k3 u^3 + a |u| / 2 */
static real nonlinear(real u, real k2, real k3, real a)
{{
    return (k2 * (u * u) + k3 * (u * u) * u) + {half} * a * size_of(u);
}}

"
        );
    }
    if plan.inverse.bound().is_none() {
        let _ = write!(
            out,
            "static real larger(real a, real b)
{{
    return (a > b) ? a : b;
}}

"
        );
    }
}

/// One table added to `to` at the temperature of the reading, with its flag.
fn add_table<T: Real>(out: &mut String, table: &Table<T>, to: &str, p: &str) {
    let name = &table.name;
    out.push_str("    {\n");
    if let Some([low, high]) = table.range {
        let (low, high) = (lit(low, p), lit(high, p));
        let _ = writeln!(
            out,
            "        const real t = hold(raw->temperature, {low}, {high});"
        );
        let _ = writeln!(
            out,
            "        if ((raw->temperature < {low}) || (raw->temperature > {high})) {{\n            flags |= 4u;\n        }}"
        );
    } else {
        let (low, high) = (lit(T::from_f64(-40.0), p), lit(T::from_f64(85.0), p));
        let _ = writeln!(out, "        const real t = raw->temperature;");
        let _ = writeln!(
            out,
            "        if ((t < {low}) || (t > {high})) {{\n            flags |= 8u;\n        }}"
        );
    }
    if !table.polynomial.is_empty() {
        let _ = writeln!(
            out,
            "        add_polynomial({name}_polynomial, {}, t - reference_temperature, {to});",
            table.polynomial.len()
        );
    }
    if let Some((pieces, end)) = &table.spline {
        let start = pieces
            .first()
            .and_then(|row| row.first())
            .copied()
            .unwrap_or(T::ZERO);
        let _ = writeln!(
            out,
            "        add_spline({name}_spline, {}, hold(t, {}, {}), {to});",
            pieces.len(),
            lit(start, p),
            lit(*end, p)
        );
    }
    out.push_str("    }\n");
}

fn function<T: Real>(plan: &Plan<T>, out: &mut String) {
    let p = plan.precision;
    let zero = lit(T::ZERO, p);
    let (offset, couples) = (plan.has_offset(), plan.couples());
    let (n_g, n_a) = (
        plan.is_nonlinear(Sensor::Gyro),
        plan.is_nonlinear(Sensor::Accel),
    );
    let _ = write!(
        out,
        "void sagnac_correct_{p}(const sagnac_raw_{p} *raw, sagnac_corrected_{p} *out)\n{{\n    uint32_t flags = 0u;\n    real centered_g[3];\n    real centered_a[3];\n    real sensed[3]; /* f', the specific force where the accelerometers sit */\n    real w[3];\n    real f[3];\n"
    );
    if offset {
        out.push_str("    real tangential[3];\n");
    }
    for sensor in Sensor::ALL {
        let key = sensor.key();
        let _ = writeln!(
            out,
            "    real bias_{key}[3] = {{{key}_bias[0], {key}_bias[1], {key}_bias[2]}};"
        );
        if plan.has_scale_table(sensor) {
            let _ = writeln!(
                out,
                "    real scale_{key}[3] = {{{zero}, {zero}, {zero}}};\n    real gain_{key}[9];\n    real inverse_{key}[9];"
            );
        } else {
            let _ = writeln!(out, "    const real *const inverse_{key} = {key}_inverse;");
        }
    }
    if n_g || couples || n_a {
        out.push_str("    real rest[3];\n");
    }
    if n_g || couples || n_a || offset {
        out.push_str("    int k;\n    int round;\n    int gyro_ok;\n    int accel_ok;\n    int boxed = 1;\n\n");
    } else {
        // One round without coupling is the start itself.
        out.push_str("    int k;\n    int gyro_ok;\n    int accel_ok;\n    int boxed = 1;\n\n");
    }
    out.push_str("    /* bias and scale factor at this temperature */\n");
    for sensor in Sensor::ALL {
        let key = sensor.key();
        if let Some(table) = plan.table(sensor, 0) {
            add_table(out, table, &format!("bias_{key}"), p);
        }
        if let Some(table) = plan.table(sensor, 1) {
            add_table(out, table, &format!("scale_{key}"), p);
            let _ = write!(
                out,
                "    for (k = 0; k < 9; k++) {{\n        gain_{key}[k] = {key}_gain[k];\n    }}\n    for (k = 0; k < 3; k++) {{\n        gain_{key}[4 * k] += scale_{key}[k];\n    }}\n    invert(gain_{key}, inverse_{key});\n"
            );
        }
    }
    if !(plan.depends_on_temperature(Sensor::Gyro) || plan.depends_on_temperature(Sensor::Accel))
        && let Some([low, high]) = plan.model.temperature_range_c
    {
        let _ = writeln!(
            out,
            "    if ((raw->temperature < {}) || (raw->temperature > {})) {{\n        flags |= 4u;\n    }}",
            lit(low, p),
            lit(high, p)
        );
    }
    let _ = write!(
        out,
        "\n    /* the bias comes off before the inverse matrix */\n    for (k = 0; k < 3; k++) {{\n        centered_g[k] = raw->gyro[k] - bias_gyro[k];\n        centered_a[k] = raw->accel[k] - bias_accel[k];\n    }}\n    apply(inverse_gyro, centered_g, w);\n    apply(inverse_accel, centered_a, sensed);\n"
    );
    if offset {
        out.push_str("    tangential[0] = raw->gyro_rate[1] * axis_offset[2] - raw->gyro_rate[2] * axis_offset[1];
    tangential[1] = raw->gyro_rate[2] * axis_offset[3] - raw->gyro_rate[0] * axis_offset[5];
    tangential[2] = raw->gyro_rate[0] * axis_offset[7] - raw->gyro_rate[1] * axis_offset[6];
");
    }
    if n_g || couples || n_a || offset {
        out.push_str("\n    for (round = 0; round < ROUNDS; round++) {\n");
        if n_a {
            out.push_str("        for (k = 0; k < 3; k++) {
            rest[k] = centered_a[k] - nonlinear(sensed[k], accel_quadratic[k], accel_cubic[k], accel_asymmetry[k]);
        }
        apply(inverse_accel, rest, sensed);
");
        }
        if offset {
            out.push_str(
                "        {
            /* size effect: w x (w x r_k) + wdot x r_k, component k */
            const real square = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
            for (k = 0; k < 3; k++) {
                const real *r = &axis_offset[3 * k];
                const real along = w[0] * r[0] + w[1] * r[1] + w[2] * r[2];
                f[k] = sensed[k] - ((w[k] * along - square * r[k]) + tangential[k]);
            }
        }
",
            );
        } else {
            out.push_str(
                "        for (k = 0; k < 3; k++) {\n            f[k] = sensed[k];\n        }\n",
            );
        }
        if couples || n_g {
            out.push_str(
                "        for (k = 0; k < 3; k++) {\n            rest[k] = centered_g[k];\n",
            );
            if plan.has_g() {
                out.push_str("            rest[k] -= g_sensitivity[3 * k] * f[0] + g_sensitivity[3 * k + 1] * f[1] + g_sensitivity[3 * k + 2] * f[2];\n");
            }
            if plan.has_h() {
                out.push_str(
                    "            {
                const real *h = &g2_sensitivity[6 * k];
                rest[k] -= h[0] * (f[0] * f[0]) + h[1] * (f[1] * f[1]) + h[2] * (f[2] * f[2]);
                rest[k] -= h[3] * (f[0] * f[1]) + h[4] * (f[0] * f[2]) + h[5] * (f[1] * f[2]);
            }
",
                );
            }
            if n_g {
                out.push_str("            rest[k] -= nonlinear(w[k], gyro_quadratic[k], gyro_cubic[k], gyro_asymmetry[k]);\n");
            }
            out.push_str("        }\n        apply(inverse_gyro, rest, w);\n");
        }
        out.push_str("    }\n");
    } else {
        out.push_str("    for (k = 0; k < 3; k++) {\n        f[k] = sensed[k];\n    }\n");
    }
    flags_of(plan, out);
    let _ = write!(
        out,
        "    for (k = 0; k < 3; k++) {{
        out->gyro[k] = gyro_ok ? w[k] : ({zero} / {zero});
        out->accel[k] = accel_ok ? f[k] : ({zero} / {zero});
    }}
    out->flags = flags;
}}
"
    );
}

fn flags_of<T: Real>(plan: &Plan<T>, out: &mut String) {
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
    out.push_str("    if (!(gyro_ok && accel_ok)) {\n        flags |= 16u;\n    }\n");
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
}

fn value<T: Real>(x: T, p: &str) -> String {
    if x.to_f64().is_nan() {
        "NOT_A_NUMBER".to_owned()
    } else if x.is_finite() {
        lit(x, p)
    } else {
        "INFINITE".to_owned()
    }
}

fn values<T: Real>(v: &[T], p: &str) -> String {
    v.iter()
        .map(|x| value(*x, p))
        .collect::<Vec<_>>()
        .join(", ")
}

fn test<T: Real>(plan: &Plan<T>) -> String {
    let p = plan.precision;
    let real = real(p);
    let mut out = String::new();
    for line in plan.head() {
        let _ = writeln!(out, "/* {line} */");
    }
    let _ = write!(
        out,
        "/* Stored cases: what went in comes back, or what is flagged is flagged. */
#include \"sagnac_correct_{p}.h\"

#include <math.h>
#include <stdio.h>

#define NOT_A_NUMBER (({real})NAN)
#define INFINITE (({real})INFINITY)
/* allowed error, relative to the largest of input, output and bias */
#define ALLOWED {}

typedef struct {{
    sagnac_raw_{p} raw;
    sagnac_corrected_{p} wanted;
    {real} scale[2];
}} test_case;

static const test_case cases[] = {{
",
        number(plan.allowed, "f64")
    );
    for case in &plan.cases {
        let _ = writeln!(
            out,
            "    {{{{{{{}}}, {{{}}}, {{{}}}, {}}},\n     {{{{{}}}, {{{}}}, {}u}}, {{{}}}}},",
            values(&case.raw.gyro, p),
            values(&case.raw.accel, p),
            values(&case.raw.gyro_rate, p),
            value(case.raw.temperature_c, p),
            values(&case.gyro, p),
            values(&case.accel, p),
            case.flags,
            values(&case.scale, p),
        );
    }
    let _ = write!(
        out,
        "}};

static double error_of({real} got, {real} wanted, {real} scale)
{{
    if ((wanted != wanted) || (got != got)) {{
        return ((wanted != wanted) && (got != got)) ? 0.0 : 1.0;
    }}
    return fabs((double)got - (double)wanted) / (double)scale;
}}

int main(void)
{{
    const int count = (int)(sizeof cases / sizeof cases[0]);
    double largest = 0.0;
    int wrong_flags = 0;
    int i;
    int k;
    for (i = 0; i < count; i++) {{
        sagnac_corrected_{p} got;
        sagnac_correct_{p}(&cases[i].raw, &got);
        for (k = 0; k < 3; k++) {{
            const double of_gyro = error_of(got.gyro[k], cases[i].wanted.gyro[k], cases[i].scale[0]);
            const double of_accel = error_of(got.accel[k], cases[i].wanted.accel[k], cases[i].scale[1]);
            largest = (of_gyro > largest) ? of_gyro : largest;
            largest = (of_accel > largest) ? of_accel : largest;
        }}
        if (got.flags != cases[i].wanted.flags) {{
            wrong_flags++;
            printf(\"case %d: flags %u, wanted %u\\n\", i, (unsigned)got.flags, (unsigned)cases[i].wanted.flags);
        }}
    }}
    printf(\"%d cases, largest error %.3g of the scale (allowed %.3g)\\n\", count, largest, ALLOWED);
    return ((largest <= ALLOWED) && (wrong_flags == 0)) ? 0 : 1;
}}
"
    );
    out
}

fn example<T: Real>(plan: &Plan<T>) -> String {
    let p = plan.precision;
    let c = |x: f64| lit(T::from_f64(x), p);
    format!(
        "/* Corrects one reading and prints it. */
#include \"sagnac_correct_{p}.h\"

#include <stdio.h>

int main(void)
{{
    const sagnac_raw_{p} raw = {{
        {{{}, {}, {}}},  /* rad/s */
        {{{}, {}, {}}},  /* m/s^2 */
        {{{zero}, {zero}, {zero}}},  /* rad/s^2 */
        {}  /* degC */
    }};
    sagnac_corrected_{p} out;
    sagnac_correct_{p}(&raw, &out);
    printf(\"gyro  %.9g %.9g %.9g rad/s\\n\", (double)out.gyro[0], (double)out.gyro[1], (double)out.gyro[2]);
    printf(\"accel %.9g %.9g %.9g m/s^2\\n\", (double)out.accel[0], (double)out.accel[1], (double)out.accel[2]);
    printf(\"flags %u\\n\", (unsigned)out.flags);
    return 0;
}}
",
        c(0.1),
        c(-0.05),
        c(0.02),
        c(0.3),
        c(-0.2),
        c(-9.8),
        lit(plan.model.reference_temperature_c, p),
        zero = c(0.0),
    )
}
