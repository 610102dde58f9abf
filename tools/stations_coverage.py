"""Coverage of the 95 % intervals of `sagnac calibrate stations`, data by an independent generator.

output = u' + b + M u' + G f, u' = f + w x (w x r) + wdot x r; noise of stated standard error; levelling errors of
0.5 deg in the hand-held six positions. Seeds 1 … N are declared here and used once.

    python3 tools/stations_coverage.py target/release/sagnac 200
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
    return t


def outputs(t, f, w, wdot, rng, se):
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
    lines = [",".join(names)]
    for f, w, wdot in stations(kind):
        true = list(f)
        if tilt:
            k = max(range(3), key=lambda i: abs(f[i]))
            e = [rng.gauss(0, tilt) if i != k else 0.0 for i in range(3)]
            n = math.sqrt(1 + sum(x * x for x in e))
            true = [(f[i] if i == k else G * e[i]) / n for i in range(3)]
        accel, gyro = outputs(t, true, w, wdot, rng, se)
        row = list(f) + list(w) + list(wdot) + accel + gyro
        if with_se:
            row += [se[0]] * 3 + [se[1]] * 3
        lines.append(",".join(repr(x) for x in row))
    return "\n".join(lines) + "\n", tilt


def main():
    program, sets = sys.argv[1], int(sys.argv[2])
    for kind, with_se in (("six", True), ("tumble", True), ("tumble", False), ("rates", True), ("rates", False)):
        inside, total = {}, {}
        for seed in range(1, sets + 1):
            rng = random.Random(f"{kind} {with_se} {seed}")
            t = draw(rng)
            text, tilt = table(kind, rng, t, with_se)
            with tempfile.NamedTemporaryFile("w", suffix=".csv") as file:
                file.write(text)
                file.flush()
                command = [program, "calibrate", "stations", file.name, "--format", "json", f"--tilt={tilt!r}rad"]
                result = json.loads(subprocess.run(command, capture_output=True, check=True).stdout)
            for p in result["parameters"]:
                group = ".".join(p["name"].split(".")[:-1])
                total[group] = total.get(group, 0) + 1
                inside[group] = inside.get(group, 0) + (p["lower"] <= t[p["name"]] <= p["upper"])
        print(f"{kind}, standard errors {'given' if with_se else 'not given'}, {sets} sets")
        for group, n in sorted(total.items()):
            print(f"  {group:24} {100 * inside[group] / n:5.1f} % of {n}")


if __name__ == "__main__":
    main()
