//! C99: header and function; the flags, and the programs around it, in files of their own.

use core::fmt::Write as _;

use sagnac_core::{Real, Sensor};

use super::{EmittedFile, Plan, Table, number};
use flags::flags_of;
use programs::{example, test};

mod flags;
mod programs;

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

#ifdef __cplusplus
extern \"C\" {{
#endif

/* One reading: rad/s, m/s^2, rad/s^2, degC. gyro_rate is the angular acceleration; zero where it is not known. */
typedef struct {{
    {real} gyro[3];
    {real} accel[3];
    {real} gyro_rate[3];
    {real} temperature;
}} sagnac_raw_{p};

/* The corrected reading: rad/s, m/s^2, and the sum of
   1 gyro saturated, 2 accelerometer saturated, 4 temperature outside the stated range,
   8 outside validity, 16 a value that is needed, or the result, is not finite (the result is NaN). */
typedef struct {{
    {real} gyro[3];
    {real} accel[3];
    uint32_t flags;
}} sagnac_corrected_{p};

void sagnac_correct_{p}(const sagnac_raw_{p} *raw, sagnac_corrected_{p} *out);

#ifdef __cplusplus
}}
#endif

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
                let terms = plan.g2_terms("                ");
                let _ = write!(
                    out,
                    "            {{\n                const real *h = &g2_sensitivity[6 * k];\n{terms}            }}\n"
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
