"""What tables of stations determine, computed apart from the product: rank and null space with numpy.

For each table the design of every axis is written from the equations of the measurement model (cross products, not
the rows of Ω), groups enter in the order of the contract, and what is estimated, available and unobservable is
compared by name with `sagnac calibrate stations --format json`.

    python3 tools/null_space.py target/release/sagnac
"""

import json
import math
import subprocess
import sys
import tempfile

import numpy as np

G, SE = 9.80665, {"accel": 5e-4, "gyro": 2e-5}
E = np.eye(3)
PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def tables():
    rest = lambda f: (np.array(f, float), np.zeros(3), np.zeros(3), None)
    six = [rest(s * G * E[k]) for k in range(3) for s in (1, -1)]
    tumble = [rest(G * (math.cos(a) * E[(k + 1) % 3] + math.sin(a) * E[(k + 2) % 3])) for k in range(3) for a in np.arange(8) * np.pi / 4]
    tumble = [(np.where(np.abs(f) < 1e-9, 0, f), *r) for f, *r in tumble]
    turn = lambda k, w: (G * E[k], w * E[k], np.zeros(3), None)
    rates = [turn(k, math.radians(200) * x) for k in range(3) for x in (-1, -0.5, -0.25, -0.125, 0, 0.125, 0.25, 0.5, 1)]
    one_axis = [turn(2, math.radians(x)) for x in (-100, -50, -20, 0, 20, 50, 100)]
    arm = []
    for k in range(3):
        for s in (1, -1):
            for a in (2, 5, 10):
                i = (k + 1) % 3
                arm.append((s * a * 9.80665 * E[k] + G * E[i], math.sqrt(a * 9.80665) * E[i], np.zeros(3), None))
    chamber = [(f, w, d, t) for t in (-20.0, 0.0, 20.0, 40.0, 60.0) for f, w, d, _ in six]
    swings = [(G * E[k], np.zeros(3), s * 40 * E[k], None) for k in range(3) for s in (1, -1)]
    spins = [turn(k, s * math.radians(300)) for k in range(3) for s in (1, -1)]
    rng = np.random.default_rng(1)
    unit = lambda v: v / np.linalg.norm(v)
    wild = [(G * rng.uniform(1, 4) * unit(rng.normal(size=3)), rng.uniform(-5, 5, 3), rng.uniform(-20, 20, 3), rng.uniform(-20, 60)) for _ in range(60)]
    plane = [rest(G * np.array([math.cos(a), math.sin(a), 0])) for a in np.arange(12) * np.pi / 6 + 0.1]
    return {
        "six positions": (six, "default"), "one face": ([six[5]] * 6, "bias"),
        "three faces": ([six[5], six[5], six[0], six[3]], "default"), "x level": (tumble[:8], "default"),
        "tumble24": (tumble, "default"), "one-axis rate table": (one_axis, "default"), "rate-table": (rates, "default"),
        "centrifuge": (arm, "default"), "chamber": (chamber, "default"), "faces, spins, swings": (six + spins + swings, "default"),
        "tumble24 + rate-table": (tumble + rates, "default"), "sixty at random, all terms": (wild, "all"),
        "all poses in a plane": (plane, "default"), "tumble24 + quadratic": (tumble, "+quadratic"),
    }


def columns(sensor, k, rows):
    """(group, name, column, plausible size) of every term, at r = 0."""
    a = "xyz"[k]
    f, w, d = (np.array([r[i] for r in rows]) for i in range(3))
    warmth = np.array([0.0 if r[3] is None else r[3] - 25 for r in rows])
    u = f if sensor == "accel" else w
    uk, reach, hot = u[:, k], np.abs(u[:, k]).max(), np.abs(warmth).max()
    inf = lambda x, y: x / y if y else math.inf
    out = [("bias", f"{sensor}.bias.{a}", np.ones(len(rows)), math.inf), ("scale_factor", f"{sensor}.scale_factor.{a}", uk, 0.05)]
    out += [("misalignment", f"{sensor}.misalignment.{a}{'xyz'[j]}", u[:, j], 0.05) for j in range(3) if j != k]
    out.append(("bias.temperature", f"{sensor}.bias.temperature.1.{a}", warmth, inf(0.5 if sensor == "accel" else 0.05, hot)))
    if sensor == "gyro":
        out += [("g_sensitivity", f"gyro.g_sensitivity.{a}{'xyz'[j]}", f[:, j], 1e-3) for j in range(3)]
    else:
        for j in range(3):
            size = np.cross(w, np.cross(w, E[j])) + np.cross(d, E[j])
            out.append(("axis_offset", f"accel.axis_offset.{a}{'xyz'[j]}", size[:, k], 0.1))
    out.append(("scale_factor.temperature", f"{sensor}.scale_factor.temperature.1.{a}", warmth * uk, inf(0.02, hot)))
    out.append(("quadratic", f"{sensor}.scale_factor.quadratic.{a}", uk**2, inf(0.02, reach)))
    out.append(("asymmetry", f"{sensor}.scale_factor.asymmetry.{a}", np.abs(uk) / 2, 0.02))
    out.append(("cubic", f"{sensor}.scale_factor.cubic.{a}", uk**3, inf(0.02, reach**2)))
    if sensor == "gyro":
        out += [("g2_sensitivity", f"gyro.g2_sensitivity.{a}.{'xyz'[i]}{'xyz'[j]}", f[:, i] * f[:, j], 1e-4) for i, j in PAIRS]
    return out


def determine(sensor, rows, terms):
    late = {"quadratic", "asymmetry", "cubic", "g2_sensitivity"}
    spread = [r[3] for r in rows if r[3] is not None]
    warm = bool(spread) and max(spread) - min(spread) >= 5

    def asked(group):
        if terms in ("all", "bias"):
            return terms == "all" or group == "bias"
        return group == terms[1:] or not (group in late or ("temperature" in group and not warm))

    result = {"estimated": set(), "available": set(), "unobservable": set()}
    for k in range(3):
        all_columns = columns(sensor, k, rows)
        groups = list(dict.fromkeys(c[0] for c in all_columns))
        admitted = np.zeros((len(rows), 0))
        for wanted in (True, False):
            for group in (g for g in groups if asked(g) == wanted):
                live = []
                for _, name, column, size in (c for c in all_columns if c[0] == group):
                    norm = np.linalg.norm(column) / SE[sensor]
                    if norm == 0:
                        result["unobservable"].add(name)
                    else:
                        live.append((name, column / SE[sensor] / norm, norm, size))
                if not live:
                    continue
                x = np.array([c[1] for c in live]).T
                q = np.linalg.qr(admitted)[0] if admitted.shape[1] else np.zeros((len(rows), 0))
                rest = x - q @ (q.T @ x)
                rest = rest - q @ (q.T @ rest)
                _, s, vt = np.linalg.svd(np.vstack([rest, np.zeros((rest.shape[1], rest.shape[1]))]), full_matrices=False)
                null = np.sqrt((vt[s < 1e-6] ** 2).sum(axis=0)) > 1e-4
                good = [i for i in range(len(live)) if not null[i]]
                result["unobservable"] |= {live[i][0] for i in range(len(live)) if null[i]}
                if not good:
                    continue
                sigma = np.sqrt(np.diag(np.linalg.inv(rest[:, good].T @ rest[:, good])))
                for i, sd in zip(good, sigma):
                    name, _, norm, size = live[i]
                    if sd / norm > size / 3:
                        result["unobservable"].add(name)
                    else:
                        result["estimated" if wanted else "available"].add(name)
                        admitted = np.column_stack([admitted, x[:, i]])
        full = np.array([c[2] / max(np.linalg.norm(c[2]), 1e-300) for c in all_columns]).T
        assert admitted.shape[1] <= np.linalg.matrix_rank(full, tol=1e-6)
    return result


def main():
    program, wrong = sys.argv[1], 0
    for name, (rows, terms) in tables().items():
        head = [f"f_{a} [m/s^2]" for a in "xyz"] + [f"w_{a} [rad/s]" for a in "xyz"] + [f"wdot_{a} [rad/s^2]" for a in "xyz"]
        head += [f"accel_{a} [m/s^2]" for a in "xyz"] + [f"gyro_{a} [rad/s]" for a in "xyz"]
        head += [f"accel_{a}_se [m/s^2]" for a in "xyz"] + [f"gyro_{a}_se [rad/s]" for a in "xyz"]
        warm = rows[0][3] is not None
        lines = [",".join(head + ["temperature [degC]"] * warm)]
        for f, w, d, t in rows:
            cells = [*f, *w, *d, *f, *w] + [SE["accel"]] * 3 + [SE["gyro"]] * 3 + [t] * warm
            lines.append(",".join(repr(float(c)) for c in cells))
        with tempfile.NamedTemporaryFile("w", suffix=".csv") as file:
            file.write("\n".join(lines) + "\n")
            file.flush()
            command = [program, "calibrate", "stations", file.name, "--terms", terms, "--format", "json"]
            found = json.loads(subprocess.run(command, capture_output=True, check=True).stdout)
        got = {
            "estimated": {p["name"] for p in found["parameters"]}, "unobservable": set(found["unobservable"]),
            "available": {a if isinstance(a, str) else a["name"] for a in found["available"]},
        }
        want = {key: set() for key in got}
        for sensor in ("accel", "gyro"):
            for key, names in determine(sensor, rows, terms).items():
                want[key] |= names
        counts = " / ".join(str(len(want[key])) for key in ("estimated", "available", "unobservable"))
        bad = {key: sorted(want[key] ^ got[key]) for key in got if want[key] != got[key]}
        wrong += bool(bad)
        print(f"{name:28} {counts:16} {'as numpy says' if not bad else bad}")
    sys.exit(wrong > 0)


if __name__ == "__main__":
    main()
