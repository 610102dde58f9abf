"""Reference cases of the forward measurement model, in 50 digits (mpmath).

An implementation of its own of lecture equations (1) and (2) with size effect, g- and
g^2-sensitivity, nonlinearity, asymmetry, temperature polynomials and cross-axis response:
cross products are taken as determinants, powers as powers, nothing is factored as in the
product. It shares no code with it. Every term alone, then all together.

    python tools/model_reference.py > testdata/reference/measurement.csv
"""

import random

from mpmath import mp, mpf

mp.dps = 50
SEED = 20260101  # declared, not searched

# name -> how many numbers, and their size
TERMS = {
    "gyro_bias": (3, 0.05), "accel_bias": (3, 0.5),
    "gyro_bias_temperature": (24, 1e-3), "accel_bias_temperature": (24, 1e-2),
    "gyro_scale": (3, 0.02), "accel_scale": (3, 0.02),
    "gyro_scale_temperature": (24, 1e-4), "accel_scale_temperature": (24, 1e-4),
    "gyro_quadratic": (3, 1e-3), "accel_quadratic": (3, 1e-4),
    "gyro_cubic": (3, 1e-5), "accel_cubic": (3, 1e-6),
    "gyro_asymmetry": (3, 0.02), "accel_asymmetry": (3, 0.02),
    "gyro_misalignment": (6, 0.01), "accel_misalignment": (6, 0.01),
    "gyro_cross_axis": (6, 0.01), "accel_cross_axis": (6, 0.01),
    "g_sensitivity": (9, 1e-4), "g2_sensitivity": (18, 1e-6), "axis_offset": (9, 0.03),
}
OFF = ("xy", "xz", "yx", "yz", "zx", "zy")


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def forward(p, f, w, wdot, theta):
    """Outputs of gyro and accelerometer; p holds lists of mpf, zero where absent."""
    felt = []
    for k in range(3):
        r = p["axis_offset"][3 * k:3 * k + 3]
        felt.append(f[k] + cross(w, cross(w, r))[k] + cross(wdot, r)[k])
    out = {}
    for sensor, u in (("gyro", w), ("accel", felt)):
        y = []
        for k in range(3):
            bias = p[sensor + "_bias"][k]
            scale = p[sensor + "_scale"][k]
            for i in range(8):
                bias += p[sensor + "_bias_temperature"][3 * i + k] * theta ** (i + 1)
                scale += p[sensor + "_scale_temperature"][3 * i + k] * theta ** (i + 1)
            value = bias + u[k] + scale * u[k]
            for e, name in enumerate(OFF):
                if "xyz".index(name[0]) == k:
                    both = p[sensor + "_misalignment"][e] + p[sensor + "_cross_axis"][e]
                    value += both * u["xyz".index(name[1])]
            value += p[sensor + "_quadratic"][k] * u[k] ** 2 + p[sensor + "_cubic"][k] * u[k] ** 3
            value += p[sensor + "_asymmetry"][k] * abs(u[k]) / 2
            if sensor == "gyro":
                value += sum(p["g_sensitivity"][3 * k + j] * f[j] for j in range(3))
                q = [f[0] ** 2, f[1] ** 2, f[2] ** 2, f[0] * f[1], f[0] * f[2], f[1] * f[2]]
                value += sum(p["g2_sensitivity"][6 * k + j] * q[j] for j in range(6))
            y.append(value)
        out[sensor] = y
    return out


def main():
    rng = random.Random(SEED)
    names = list(TERMS)
    print("case," + ",".join(f"{n}_{i}" for n in names for i in range(TERMS[n][0]))
          + ",fx,fy,fz,wx,wy,wz,dx,dy,dz,theta,gx,gy,gz,ax,ay,az")
    for case in [*names, "all", "all", "all", "all", "all", "all", "all", "all"]:
        for _ in range(3):
            p = {}
            for n in names:
                count, size = TERMS[n]
                on = case in (n, "all")
                values = [rng.uniform(-size, size) if on else 0.0 for _ in range(count)]
                if n.endswith("_temperature"):
                    values = [v / 40.0 ** (i // 3) for i, v in enumerate(values)]
                p[n] = values
            f = [rng.uniform(-80, 80) for _ in range(3)]
            w = [rng.uniform(-8, 8) for _ in range(3)]
            d = [rng.uniform(-50, 50) for _ in range(3)]
            theta = float(rng.randrange(-45 * 16, 60 * 16)) / 16  # exact with T0 = 25
            big = {n: [mpf(v) for v in p[n]] for n in names}
            y = forward(big, [mpf(v) for v in f], [mpf(v) for v in w], [mpf(v) for v in d], mpf(theta))
            row = [v for n in names for v in p[n]] + f + w + d + [theta]
            row += [float(v) for v in y["gyro"] + y["accel"]]
            print(case + "," + ",".join(repr(v) for v in row))


if __name__ == "__main__":
    main()
