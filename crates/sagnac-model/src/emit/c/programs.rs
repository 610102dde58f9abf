//! C99: the programs around the function: its test on stored cases, and an example.

use core::fmt::Write as _;

use sagnac_core::Real;

use super::super::{Plan, number};
use super::{lit, real};

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

pub(super) fn test<T: Real>(plan: &Plan<T>) -> String {
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

pub(super) fn example<T: Real>(plan: &Plan<T>) -> String {
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
