"""Coverage of the 95 % intervals of `sagnac calibrate stations`, data by an independent generator.

output = u' + b + M u' + G f, u' = f + w x (w x r) + wdot x r; noise of stated standard error; levelling errors of
0.5 deg in the hand-held six positions; `all` has every term. Seeds 1 … N are declared here and used once; another
first seed may be given.

    python3 tools/stations_coverage.py target/release/sagnac 200 [FIRST]
"""

import json
import math
import random
import subprocess
import sys
import tempfile

G = 9.80665


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(k, size):
    v = [0.0, 0.0, 0.0]
    v[k] = size
    return v


def stations(kind):
    faces = [(unit(k, s * G), [0.0] * 3, [0.0] * 3) for k in range(3) for s in (1, -1)]
    if kind == "six":
        return faces
    tumble = []
    for k in range(3):
        for i in range(8):
            a = i * math.pi / 4
            f = [0.0, 0.0, 0.0]
            f[(k + 1) % 3], f[(k + 2) % 3] = G * math.cos(a), G * math.sin(a)
            tumble.append((f, [0.0] * 3, [0.0] * 3))
    if kind == "tumble":
        return tumble
    if kind == "all":
        # Sixty stations of any direction, up to 4 g, any rate, any temperature; the same for every set.
        rng = random.Random("stations of all terms")
        out = []
        for i in range(60):
            d = [rng.gauss(0, 1) for _ in range(3)]
            size = G * (4.0 if i % 3 == 0 else 1.0) / math.sqrt(sum(x * x for x in d))
            w = [rng.uniform(-5, 5) for _ in range(3)]
            wdot = [rng.uniform(-20, 20) for _ in range(3)]
            out.append(([size * x for x in d], w, wdot, rng.uniform(-20, 60)))
        return out
    r = math.radians(300)
    spins = [(unit(k, G), unit(k, s * r), [0.0] * 3) for k in range(3) for s in (-1, -0.5, 0.5, 1)]
    swings = [(unit(k, G), [0.0] * 3, unit(k, s * 40.0)) for k in range(3) for s in (1, -1)]
    return tumble + spins + swings


def draw(rng):
    t = {}
    for k, a in enumerate("xyz"):
        t[f"accel.bias.{a}"] = rng.gauss(0, 0.05)
        t[f"gyro.bias.{a}"] = rng.gauss(0, 0.01)
        for s in ("accel", "gyro"):
            t[f"{s}.scale_factor.{a}"] = rng.gauss(0, 0.003)
            for b in "xyz":
                if a != b:
                    t[f"{s}.misalignment.{a}{b}"] = rng.gauss(0, 0.003)
        for b in "xyz":
            t[f"gyro.g_sensitivity.{a}{b}"] = rng.gauss(0, 2e-5)
            t[f"accel.axis_offset.{a}{b}"] = rng.gauss(0, 0.01)
        for s, unit_size in (("accel", G), ("gyro", 1.0)):
            t[f"{s}.bias.temperature.1.{a}"] = rng.gauss(0, 2e-4)
            t[f"{s}.scale_factor.temperature.1.{a}"] = rng.gauss(0, 5e-5)
            t[f"{s}.scale_factor.quadratic.{a}"] = rng.gauss(0, 3e-4) / unit_size
            t[f"{s}.scale_factor.cubic.{a}"] = rng.gauss(0, 1e-4) / unit_size**2
            t[f"{s}.scale_factor.asymmetry.{a}"] = rng.gauss(0, 1e-3)
        for p in PRODUCTS:
            t[f"gyro.g2_sensitivity.{a}.{p}"] = rng.gauss(0, 1e-6)
    return t


PRODUCTS = ("xx", "yy", "zz", "xy", "xz", "yz")


def curved(t, sensor, a, u, warmth, everything):
    """Temperature and nonlinearity of one axis, output units."""
    if not everything:
        return 0.0
    out = t[f"{sensor}.bias.temperature.1.{a}"] * warmth + t[f"{sensor}.scale_factor.temperature.1.{a}"] * warmth * u
    out += t[f"{sensor}.scale_factor.quadratic.{a}"] * u**2 + t[f"{sensor}.scale_factor.cubic.{a}"] * u**3
    return out + 0.5 * t[f"{sensor}.scale_factor.asymmetry.{a}"] * abs(u)


def outputs(t, f, w, wdot, rng, se, warmth=0.0, everything=False):
    gyro, accel, inputs = [], [], []
    for a in "xyz":
        r = [t[f"accel.axis_offset.{a}{b}"] for b in "xyz"]
        size = [p + q for p, q in zip(cross(w, cross(w, r)), cross(wdot, r))]
        inputs.append(f["xyz".index(a)] + size["xyz".index(a)])
    for k, a in enumerate("xyz"):
        va, vg = t[f"accel.bias.{a}"], t[f"gyro.bias.{a}"]
        for j, b in enumerate("xyz"):
            if b == a:
                ma, mg = t[f"accel.scale_factor.{a}"], t[f"gyro.scale_factor.{a}"]
            else:
                ma, mg = t[f"accel.misalignment.{a}{b}"], t[f"gyro.misalignment.{a}{b}"]
            va += (ma + (a == b)) * inputs[j]
            vg += (mg + (a == b)) * w[j] + t[f"gyro.g_sensitivity.{a}{b}"] * f[j]
        va += curved(t, "accel", a, inputs[k], warmth, everything)
        vg += curved(t, "gyro", a, w[k], warmth, everything)
        if everything:
            for p in PRODUCTS:
                vg += t[f"gyro.g2_sensitivity.{a}.{p}"] * f["xyz".index(p[0])] * f["xyz".index(p[1])]
        accel.append(va + rng.gauss(0, se[0]))
        gyro.append(vg + rng.gauss(0, se[1]))
    return accel, gyro


def table(kind, rng, t, with_se):
    se = (1e-3, 1e-4)
    tilt = math.radians(0.5) if kind == "six" else 0.0
    names = ["f_x [m/s^2]", "f_y [m/s^2]", "f_z [m/s^2]", "w_x [rad/s]", "w_y [rad/s]", "w_z [rad/s]"]
    names += ["wdot_x [rad/s^2]", "wdot_y [rad/s^2]", "wdot_z [rad/s^2]"]
    names += [f"accel_{a} [m/s^2]" for a in "xyz"] + [f"gyro_{a} [rad/s]" for a in "xyz"]
    if with_se:
        names += [f"accel_{a}_se [m/s^2]" for a in "xyz"] + [f"gyro_{a}_se [rad/s]" for a in "xyz"]
    everything = kind == "all"
    if everything:
        names.append("temperature [degC]")
    lines = [",".join(names)]
    for f, w, wdot, *rest in stations(kind):
        true = list(f)
        if tilt:
            k = max(range(3), key=lambda i: abs(f[i]))
            e = [rng.gauss(0, tilt) if i != k else 0.0 for i in range(3)]
            n = math.sqrt(1 + sum(x * x for x in e))
            true = [(f[i] if i == k else G * e[i]) / n for i in range(3)]
        warmth = rest[0] - 25.0 if rest else 0.0
        accel, gyro = outputs(t, true, w, wdot, rng, se, warmth, everything)
        row = list(f) + list(w) + list(wdot) + accel + gyro
        if with_se:
            row += [se[0]] * 3 + [se[1]] * 3
        row += rest
        lines.append(",".join(repr(x) for x in row))
    return "\n".join(lines) + "\n", tilt


def main():
    program, sets = sys.argv[1], int(sys.argv[2])
    first = int(sys.argv[3]) if len(sys.argv) > 3 else 1
    pooled = {}
    for kind, with_se in (("six", True), ("tumble", True), ("tumble", False), ("rates", True), ("rates", False), ("all", True),
                          ("all", False)):
        inside, total = {}, {}
        for seed in range(first, first + sets):
            rng = random.Random(f"{kind} {with_se} {seed}")
            t = draw(rng)
            text, tilt = table(kind, rng, t, with_se)
            with tempfile.NamedTemporaryFile("w", suffix=".csv") as file:
                file.write(text)
                file.flush()
                command = [program, "calibrate", "stations", file.name, "--format", "json", f"--tilt={tilt!r}rad",
                           "--terms", "all" if kind == "all" else "default"]
                result = json.loads(subprocess.run(command, capture_output=True, check=True).stdout)
            for p in result["parameters"]:
                group = ".".join(p["name"].split(".")[:-1])
                total[group] = total.get(group, 0) + 1
                inside[group] = inside.get(group, 0) + (p["lower"] <= t[p["name"]] <= p["upper"])
        print(f"{kind}, standard errors {'given' if with_se else 'not given'}, {sets} sets")
        for group, n in sorted(total.items()):
            print(f"  {group:32} {100 * inside[group] / n:5.1f} % of {n}")
            hit = pooled.setdefault(kind_of(group), [0, 0])
            hit[0] += inside[group]
            hit[1] += n
    print("kinds of parameters pooled over tables")
    for name, (hit, n) in sorted(pooled.items()):
        print(f"  {name:32} {100 * hit / n:5.1f} % of {n}")


def kind_of(group):
    for word in ("temperature", "axis_offset", "g_sensitivity", "g2_sensitivity", "misalignment"):
        if word in group:
            return word
    return "nonlinearity" if group.split(".")[-1] in ("quadratic", "cubic", "asymmetry") else group.split(".")[1]


if __name__ == "__main__":
    main()
