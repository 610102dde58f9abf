//! Rust: a `no_std` crate of one file, its cases in it, and an example.

use core::fmt::Write as _;

use sagnac_core::{Real, Sensor};

use super::{EmittedFile, Plan, Table, number};

pub(super) fn files<T: Real>(plan: &Plan<T>) -> Vec<EmittedFile> {
    vec![
        EmittedFile {
            name: "sagnac_correct.rs".to_owned(),
            text: source(plan),
        },
        EmittedFile {
            name: "sagnac_correct_example.rs".to_owned(),
            text: example(plan),
        },
    ]
}

fn value<T: Real>(x: T, p: &str) -> String {
    if x.to_f64().is_nan() {
        format!("{p}::NAN")
    } else if x.is_finite() {
        number(x, p)
    } else {
        format!("{p}::INFINITY")
    }
}

fn list<T: Real>(values: &[T], p: &str) -> String {
    let items: Vec<String> = values.iter().map(|x| value(*x, p)).collect();
    format!("[{}]", items.join(", "))
}

fn rows<T: Real>(rows: &[Vec<T>], p: &str) -> String {
    let items: Vec<String> = rows
        .iter()
        .map(|row| format!("    {},\n", list(row, p)))
        .collect();
    format!("[\n{}]", items.concat())
}

fn matrix<T: Real, const N: usize>(m: &[[T; N]], p: &str) -> String {
    rows(&m.iter().map(|row| row.to_vec()).collect::<Vec<_>>(), p)
}

fn source<T: Real>(plan: &Plan<T>) -> String {
    let p = plan.precision;
    let mut out = String::new();
    for line in plan.head() {
        let _ = writeln!(out, "//! {line}");
    }
    let _ = write!(
        out,
        "#![no_std]

const ROUNDS: u32 = {};

/// One reading; `gyro_rate` is the angular acceleration, zero where it is not known.
#[derive(Clone, Copy, Debug)]
pub struct Raw {{
    /// rad/s
    pub gyro: [{p}; 3],
    /// m/s^2
    pub accel: [{p}; 3],
    /// rad/s^2
    pub gyro_rate: [{p}; 3],
    /// degC
    pub temperature: {p},
}}

/// The corrected reading.
#[derive(Clone, Copy, Debug)]
pub struct Corrected {{
    /// rad/s
    pub gyro: [{p}; 3],
    /// m/s^2
    pub accel: [{p}; 3],
    /// 1 gyro saturated, 2 accelerometer saturated, 4 temperature outside the stated range,
    /// 8 outside validity, 16 a value that is needed, or the result, is not finite (the result is NaN).
    pub flags: u32,
}}

",
        plan.inverse.rounds()
    );
    numbers(plan, &mut out);
    helpers(plan, &mut out);
    function(plan, &mut out);
    tests(plan, &mut out);
    out
}

fn numbers<T: Real>(plan: &Plan<T>, out: &mut String) {
    let p = plan.precision;
    for sensor in Sensor::ALL {
        let (key, up) = (sensor.key(), sensor.key().to_uppercase());
        let unit = if sensor == Sensor::Gyro {
            "rad/s"
        } else {
            "m/s^2"
        };
        let triad = plan.model.triad(sensor);
        let _ = writeln!(
            out,
            "/// {key} bias at T0, {unit}: x, y, z.\nconst {up}_BIAS: [{p}; 3] = {};",
            list(&triad.bias.fixed, p)
        );
        if plan.has_scale_table(sensor) {
            let _ = writeln!(
                out,
                "/// {key} I + M at T0: scale factor, misalignment, cross-axis response.\nconst {up}_GAIN: [[{p}; 3]; 3] = {};",
                matrix(&plan.gain(sensor), p)
            );
        } else {
            let _ = writeln!(
                out,
                "/// {key} inverse of I + M: scale factor, misalignment, cross-axis response.\nconst {up}_INVERSE: [[{p}; 3]; 3] = {};",
                matrix(&plan.inverse.inverse(sensor), p)
            );
        }
        if plan.is_nonlinear(sensor) {
            let n = &triad.nonlinearity;
            let (u2, u3) = if sensor == Sensor::Gyro {
                ("s/rad", "s^2/rad^2")
            } else {
                ("s^2/m", "s^4/m^2")
            };
            let _ = writeln!(
                out,
                "/// {key} quadratic k2, {u2}.\nconst {up}_QUADRATIC: [{p}; 3] = {};\n/// {key} cubic k3, {u3}.\nconst {up}_CUBIC: [{p}; 3] = {};\n/// {key} asymmetry a, a fraction.\nconst {up}_ASYMMETRY: [{p}; 3] = {};",
                list(&n.quadratic, p),
                list(&n.cubic, p),
                list(&triad.asymmetry.difference, p)
            );
        }
        for kind in 0..2 {
            if let Some(table) = plan.table(sensor, kind) {
                let name = table.name.to_uppercase();
                if !table.polynomial.is_empty() {
                    let _ = writeln!(
                        out,
                        "/// Temperature polynomial, a row (x, y, z) per power from 1, {}/K^i.\nconst {name}_POLYNOMIAL: [[{p}; 3]; {}] = {};",
                        table.unit,
                        table.polynomial.len(),
                        matrix(&table.polynomial, p)
                    );
                }
                if let Some((pieces, _)) = &table.spline {
                    let _ = writeln!(
                        out,
                        "/// Temperature spline, a piece: start in degC, then c0, c1, c2, c3 for x, y, z, {}/K^i.\nconst {name}_SPLINE: [[{p}; 13]; {}] = {};",
                        table.unit,
                        pieces.len(),
                        rows(pieces, p)
                    );
                }
            }
        }
    }
    if plan.has_g() {
        let _ = writeln!(
            out,
            "/// g-sensitivity, (rad/s)/(m/s^2), row = gyro axis.\nconst G_SENSITIVITY: [[{p}; 3]; 3] = {};",
            matrix(&plan.model.gyro_g_sensitivity.matrix, p)
        );
    }
    if plan.has_h() {
        let _ = writeln!(
            out,
            "/// g^2-sensitivity, (rad/s)/(m/s^2)^2, columns xx yy zz xy xz yz.\nconst G2_SENSITIVITY: [[{p}; 6]; 3] = {};",
            matrix(&plan.model.gyro_g2_sensitivity.matrix, p)
        );
    }
    if plan.has_offset() {
        let _ = writeln!(
            out,
            "/// Positions of the accelerometers x, y, z from the IMU centre, m.\nconst AXIS_OFFSET: [[{p}; 3]; 3] = {};",
            matrix(&plan.model.accel_axis_offset.position, p)
        );
    }
    if plan.has_polynomial() {
        let _ = writeln!(
            out,
            "/// Reference temperature T0, degC.\nconst REFERENCE_TEMPERATURE: {p} = {};",
            number(plan.model.reference_temperature_c, p)
        );
    }
    out.push('\n');
}

fn helpers<T: Real>(plan: &Plan<T>, out: &mut String) {
    let p = plan.precision;
    let _ = write!(
        out,
        "fn size_of(x: {p}) -> {p} {{
    if x < 0.0 {{ -x }} else {{ x }}
}}

fn are_within(v: [{p}; 3], limit: {p}) -> bool {{
    size_of(v[0]) <= limit && size_of(v[1]) <= limit && size_of(v[2]) <= limit
}}

fn apply(m: &[[{p}; 3]; 3], v: [{p}; 3]) -> [{p}; 3] {{
    let row = |r: &[{p}; 3]| r[0] * v[0] + r[1] * v[1] + r[2] * v[2];
    [row(&m[0]), row(&m[1]), row(&m[2])]
}}

"
    );
    if plan.has_scale_table(Sensor::Gyro) || plan.has_scale_table(Sensor::Accel) {
        let _ = write!(
            out,
            "/// Inverse by cofactors.
fn invert(m: &[[{p}; 3]; 3]) -> [[{p}; 3]; 3] {{
    let cross = |a: [{p}; 3], b: [{p}; 3]| {{
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    }};
    let (c0, c1, c2) = (cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1]));
    let r = 1.0 / (m[0][0] * c0[0] + m[0][1] * c0[1] + m[0][2] * c0[2]);
    [
        [c0[0] * r, c1[0] * r, c2[0] * r],
        [c0[1] * r, c1[1] * r, c2[1] * r],
        [c0[2] * r, c1[2] * r, c2[2] * r],
    ]
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
            "/// x held between two ends; NaN stays NaN.
fn hold(x: {p}, low: {p}, high: {p}) -> {p} {{
    if x < low {{
        low
    }} else if x > high {{
        high
    }} else {{
        x
    }}
}}

"
        );
    }
    if plan.has_polynomial() {
        let _ = write!(
            out,
            "/// Adds the sum of c_i theta^i, i from 1.
fn add_polynomial(rows: &[[{p}; 3]], theta: {p}, to: &mut [{p}; 3]) {{
    for (k, to) in to.iter_mut().enumerate() {{
        let mut sum = 0.0;
        for row in rows.iter().rev() {{
            sum = (sum + row[k]) * theta;
        }}
        *to += sum;
    }}
}}

"
        );
    }
    if plan.has_spline() {
        let _ = write!(
            out,
            "/// Adds the cubic piece in which t lies.
fn add_spline(pieces: &[[{p}; 13]], t: {p}, to: &mut [{p}; 3]) {{
    let mut piece = &pieces[0];
    for next in &pieces[1..] {{
        if next[0] <= t {{
            piece = next;
        }}
    }}
    let u = t - piece[0];
    for (k, to) in to.iter_mut().enumerate() {{
        *to += piece[1 + k] + u * (piece[4 + k] + u * (piece[7 + k] + u * piece[10 + k]));
    }}
}}

"
        );
    }
    if plan.is_nonlinear(Sensor::Gyro) || plan.is_nonlinear(Sensor::Accel) {
        let _ = write!(
            out,
            "/// k2 u^2 + k3 u^3 + a |u| / 2
fn nonlinear(u: {p}, k2: {p}, k3: {p}, a: {p}) -> {p} {{
    (k2 * (u * u) + k3 * (u * u) * u) + 0.5 * a * size_of(u)
}}

"
        );
    }
    if plan.inverse.bound().is_none() {
        let _ = write!(
            out,
            "fn larger(a: {p}, b: {p}) -> {p} {{
    if a > b {{ a }} else {{ b }}
}}

"
        );
    }
}

fn add_table<T: Real>(out: &mut String, table: &Table<T>, to: &str, p: &str) {
    let name = table.name.to_uppercase();
    out.push_str("    {\n");
    if let Some([low, high]) = table.range {
        let (low, high) = (number(low, p), number(high, p));
        let _ = write!(
            out,
            "        let t = hold(raw.temperature, {low}, {high});\n        if raw.temperature < {low} || raw.temperature > {high} {{\n            flags |= 4;\n        }}\n"
        );
    } else {
        out.push_str("        let t = raw.temperature;\n        if t < -40.0 || t > 85.0 {\n            flags |= 8;\n        }\n");
    }
    if !table.polynomial.is_empty() {
        let _ = writeln!(
            out,
            "        add_polynomial(&{name}_POLYNOMIAL, t - REFERENCE_TEMPERATURE, &mut {to});"
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
            "        add_spline(&{name}_SPLINE, hold(t, {}, {}), &mut {to});",
            number(start, p),
            number(*end, p)
        );
    }
    out.push_str("    }\n");
}

fn function<T: Real>(plan: &Plan<T>, out: &mut String) {
    let p = plan.precision;
    let (offset, couples) = (plan.has_offset(), plan.couples());
    let (n_g, n_a) = (
        plan.is_nonlinear(Sensor::Gyro),
        plan.is_nonlinear(Sensor::Accel),
    );
    let _ = write!(
        out,
        "/// The corrected reading.\npub fn correct(raw: &Raw) -> Corrected {{\n    let mut flags = 0;\n"
    );
    for sensor in Sensor::ALL {
        let (key, up) = (sensor.key(), sensor.key().to_uppercase());
        if let Some(table) = plan.table(sensor, 0) {
            let _ = writeln!(out, "    let mut bias_{key} = {up}_BIAS;");
            add_table(out, table, &format!("bias_{key}"), p);
        } else {
            let _ = writeln!(out, "    let bias_{key} = {up}_BIAS;");
        }
        if let Some(table) = plan.table(sensor, 1) {
            let _ = writeln!(out, "    let mut scale_{key} = [0.0; 3];");
            add_table(out, table, &format!("scale_{key}"), p);
            let _ = write!(
                out,
                "    let mut gain_{key} = {up}_GAIN;\n    gain_{key}[0][0] += scale_{key}[0];\n    gain_{key}[1][1] += scale_{key}[1];\n    gain_{key}[2][2] += scale_{key}[2];\n    let inverse_{key} = invert(&gain_{key});\n"
            );
        } else {
            let _ = writeln!(out, "    let inverse_{key} = {up}_INVERSE;");
        }
    }
    if !(plan.depends_on_temperature(Sensor::Gyro) || plan.depends_on_temperature(Sensor::Accel))
        && let Some([low, high]) = plan.model.temperature_range_c
    {
        let _ = writeln!(
            out,
            "    if raw.temperature < {} || raw.temperature > {} {{\n        flags |= 4;\n    }}",
            number(low, p),
            number(high, p)
        );
    }
    out.push_str(
        "
    // The bias comes off before the inverse matrix.
    let minus = |a: [REAL; 3], b: [REAL; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let centered_g = minus(raw.gyro, bias_gyro);
    let centered_a = minus(raw.accel, bias_accel);
"
        .replace("REAL", p)
        .as_str(),
    );
    let is_iterated = n_g || couples || n_a || offset;
    let _ = writeln!(
        out,
        "    let {}w = apply(&inverse_gyro, centered_g);",
        if n_g || couples { "mut " } else { "" }
    );
    let _ = writeln!(
        out,
        "    let {}sensed = apply(&inverse_accel, centered_a);",
        if n_a { "mut " } else { "" }
    );
    if offset {
        out.push_str(
            "    let (r, wdot) = (&AXIS_OFFSET, raw.gyro_rate);
    let tangential = [
        wdot[1] * r[0][2] - wdot[2] * r[0][1],
        wdot[2] * r[1][0] - wdot[0] * r[1][2],
        wdot[0] * r[2][1] - wdot[1] * r[2][0],
    ];
",
        );
    }
    if is_iterated {
        out.push_str("    let mut f = sensed;\n    for _ in 0..ROUNDS {\n");
        if n_a {
            out.push_str(
                "        let mut rest = centered_a;
        for k in 0..3 {
            rest[k] -= nonlinear(sensed[k], ACCEL_QUADRATIC[k], ACCEL_CUBIC[k], ACCEL_ASYMMETRY[k]);
        }
        sensed = apply(&inverse_accel, rest);
",
            );
        }
        if offset {
            out.push_str(
                "        // Size effect: w x (w x r_k) + wdot x r_k, component k.
        let square = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
        for k in 0..3 {
            let along = w[0] * r[k][0] + w[1] * r[k][1] + w[2] * r[k][2];
            f[k] = sensed[k] - ((w[k] * along - square * r[k][k]) + tangential[k]);
        }
",
            );
        } else {
            out.push_str("        f = sensed;\n");
        }
        if couples || n_g {
            out.push_str("        let mut rest = centered_g;\n        for k in 0..3 {\n");
            if plan.has_g() {
                out.push_str("            let g = &G_SENSITIVITY[k];\n            rest[k] -= g[0] * f[0] + g[1] * f[1] + g[2] * f[2];\n");
            }
            if plan.has_h() {
                let terms = plan.g2_terms("            ");
                let _ = write!(out, "            let h = &G2_SENSITIVITY[k];\n{terms}");
            }
            if n_g {
                out.push_str("            rest[k] -= nonlinear(w[k], GYRO_QUADRATIC[k], GYRO_CUBIC[k], GYRO_ASYMMETRY[k]);\n");
            }
            out.push_str("        }\n        w = apply(&inverse_gyro, rest);\n");
        }
        out.push_str("    }\n");
    } else {
        // ROUNDS is still part of what the file says of itself.
        out.push_str("    let _ = ROUNDS;\n    let f = sensed;\n");
    }
    flags_of(plan, out);
    let _ = write!(
        out,
        "    Corrected {{
        gyro: if gyro_ok {{ w }} else {{ [{p}::NAN; 3] }},
        accel: if accel_ok {{ f }} else {{ [{p}::NAN; 3] }},
        flags,
    }}
}}
"
    );
}

fn flags_of<T: Real>(plan: &Plan<T>, out: &mut String) {
    let p = plan.precision;
    let (offset, couples) = (plan.has_offset(), plan.couples());
    out.push_str("\n    // 16: a value that is needed is not finite.\n");
    for sensor in Sensor::ALL {
        let key = sensor.key();
        let t = if plan.depends_on_temperature(sensor) {
            format!(" && size_of(raw.temperature) <= {p}::MAX")
        } else {
            String::new()
        };
        let _ = writeln!(
            out,
            "    let {key}_ok = are_within(raw.{key}, {p}::MAX){t};"
        );
    }
    if offset {
        let _ = writeln!(
            out,
            "    let accel_ok = accel_ok && gyro_ok && are_within(tangential, {p}::MAX);"
        );
    }
    if couples {
        out.push_str("    let gyro_ok = gyro_ok && accel_ok;\n");
    }
    for (sensor, bit) in [(Sensor::Gyro, 1), (Sensor::Accel, 2)] {
        let key = sensor.key();
        for (axis, edge) in plan.inverse.saturation(sensor).iter().enumerate() {
            if edge.is_finite() {
                let _ = writeln!(
                    out,
                    "    if size_of(raw.{key}[{axis}]) >= {} {{\n        flags |= {bit};\n    }}",
                    number(*edge, p)
                );
            }
        }
    }
    out.push_str("\n    // 8: the solution must stay in the box of the convergence bound.\n");
    let tangential = if offset {
        " && are_within(tangential, limit_a)"
    } else {
        ""
    };
    if let Some(bound) = plan.inverse.bound() {
        let _ = writeln!(
            out,
            "    let (limit_g, limit_a) = ({}, {});\n    let mut boxed = true;",
            number(bound.limit[0], p),
            number(bound.limit[1], p)
        );
    } else {
        let c = |x: T| number(x, p);
        let size = |sensor: Sensor| {
            if let Some(range) = plan.inverse.range(sensor) {
                number(range, p)
            } else {
                let key = sensor.key();
                format!(
                    "larger(size_of(raw.{key}[0]), larger(size_of(raw.{key}[1]), size_of(raw.{key}[2])))"
                )
            }
        };
        let terms = plan.inverse.bound_terms();
        let nu = |s: usize, u: &str| {
            let one = |k: usize| {
                format!(
                    "{} * {u} + {} * ({u} * {u}) + {}",
                    c(terms.quadratic[s][k] + terms.quadratic[s][k]),
                    c(T::from_f64(3.0) * terms.cubic[s][k]),
                    c(T::HALF * terms.asymmetry[s][k])
                )
            };
            format!("larger({}, larger({}, {}))", one(0), one(1), one(2))
        };
        let _ = write!(
            out,
            "    let limit_g = 1.5 * ({rg} + {bg});
    let limit_a = 1.5 * ({ra} + {ba});
    let nu_g = {nug};
    let nu_a = {nua};
    let lever = limit_g * {ll};
    let force = 2.0 * limit_a + limit_g * limit_g * {lf};
    let gamma = {g} + 2.0 * force * {h};
    let from_f = force * {g} + force * force * {h};
    let delta = if from_f > 0.0 {{ from_f / limit_g }} else {{ 0.0 }};
    let q = larger(nu_a / {m1a}, (nu_g + gamma * lever) / {m1g});
    let mut boxed = {mua} + nu_a <= {third} && {mug} + nu_g + delta <= {third} && q <= 0.5;
",
            rg = size(Sensor::Gyro),
            ra = size(Sensor::Accel),
            bg = c(terms.bias[0]),
            ba = c(terms.bias[1]),
            nug = nu(0, "limit_g"),
            nua = nu(1, "limit_a"),
            ll = c(terms.lever_l),
            lf = c(terms.lever_f),
            g = c(terms.g),
            h = c(terms.h),
            m1g = c(T::ONE - terms.mu[0]),
            m1a = c(T::ONE - terms.mu[1]),
            mug = c(terms.mu[0]),
            mua = c(terms.mu[1]),
            third = c(T::ONE / T::from_f64(3.0)),
        );
    }
    let _ = write!(
        out,
        "    boxed = boxed && (!gyro_ok || are_within(w, limit_g));
    boxed = boxed && (!accel_ok || (are_within(sensed, limit_a){tangential}));
    if !boxed {{
        flags |= 8;
    }}

    // 16 as well where the rounds ran off to infinity.
    let gyro_ok = gyro_ok && are_within(w, {p}::MAX);
    let accel_ok = accel_ok && are_within(f, {p}::MAX);
    if !(gyro_ok && accel_ok) {{
        flags |= 16;
    }}
"
    );
}

fn tests<T: Real>(plan: &Plan<T>, out: &mut String) {
    let p = plan.precision;
    let _ = write!(
        out,
        "
#[cfg(test)]
mod tests {{
    use super::{{correct, Corrected, Raw}};

    struct Case {{
        raw: Raw,
        wanted: Corrected,
        scale: [{p}; 2],
    }}

    fn is_near(got: [{p}; 3], wanted: [{p}; 3], scale: {p}) -> bool {{
        (0..3).all(|k| {{
            if wanted[k].is_nan() {{
                got[k].is_nan()
            }} else {{
                (f64::from(got[k]) - f64::from(wanted[k])).abs() <= {} * f64::from(scale)
            }}
        }})
    }}

    #[test]
    fn stored_cases_come_back() {{
        for case in CASES {{
            let got = correct(&case.raw);
            assert_eq!(got.flags, case.wanted.flags, \"{{:?}}\", case.raw);
            assert!(is_near(got.gyro, case.wanted.gyro, case.scale[0]), \"{{:?}}\", case.raw);
            assert!(is_near(got.accel, case.wanted.accel, case.scale[1]), \"{{:?}}\", case.raw);
        }}
    }}

    const CASES: [Case; {}] = [
",
        number(plan.allowed, "f64"),
        plan.cases.len()
    );
    for case in &plan.cases {
        let _ = write!(
            out,
            "        Case {{
            raw: Raw {{
                gyro: {},
                accel: {},
                gyro_rate: {},
                temperature: {},
            }},
            wanted: Corrected {{
                gyro: {},
                accel: {},
                flags: {},
            }},
            scale: {},
        }},
",
            list(&case.raw.gyro, p),
            list(&case.raw.accel, p),
            list(&case.raw.gyro_rate, p),
            value(case.raw.temperature_c, p),
            list(&case.gyro, p),
            list(&case.accel, p),
            case.flags,
            list(&case.scale, p),
        );
    }
    out.push_str("    ];\n}\n");
}

fn example<T: Real>(plan: &Plan<T>) -> String {
    format!(
        "//! Corrects one reading and prints it.

use sagnac_correct::{{correct, Raw}};

fn main() {{
    let raw = Raw {{
        gyro: [0.1, -0.05, 0.02],
        accel: [0.3, -0.2, -9.8],
        gyro_rate: [0.0; 3],
        temperature: {},
    }};
    let out = correct(&raw);
    println!(\"gyro  {{:?}} rad/s\", out.gyro);
    println!(\"accel {{:?}} m/s^2\", out.accel);
    println!(\"flags {{}}\", out.flags);
}}
",
        number(plan.model.reference_temperature_c, plan.precision)
    )
}
