"""Coverage of the curves of `sagnac calibrate thermal` on sweeps of an independent generator.

    python3 tools/thermal_coverage.py target/release/sagnac 90 [--seed 20261125]

Down, up and half down again over 70 to 100 K in 60 to 80 min at 2 Hz; b a cubic, or a smooth function that is no
polynomial, h of order 0 to 2 or none; white noise, and in every third log a random walk. Each curve is judged at nine
temperatures of the swept range; seeds are seed ... seed + N - 1, declared here: 20261125, and 20270101 as the second set.
"""

import argparse
import json
import os
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor

import numpy as np

AXES = [f"{s}_{a}" for s in ("gyro", "accel") for a in "xyz"]


def temperature(rng):
    low, high = rng.uniform(-30, -10), rng.uniform(55, 75)
    start = rng.uniform(low + 20, high - 10)
    stops = [start, low, high, rng.uniform(low + 20, high - 15)]
    parts = []
    for a, b in zip(stops, stops[1:]):
        n = int(abs(b - a) * rng.uniform(30, 45))
        s = np.linspace(0, 1, n, endpoint=False)
        parts.append(a + (b - a) * (s + 0.03 * np.sin(2 * np.pi * s)))
    t = np.concatenate(parts)
    sign = np.concatenate([np.full(len(p), np.sign(b - a)) for p, a, b in zip(parts, stops, stops[1:])])
    return t, sign


def make(seed):
    rng = np.random.default_rng(seed)
    t, sign = temperature(rng)
    u = (t - 25) / 50
    columns, truths = {}, {}
    for axis in AXES:
        scale = 2e-3 if axis.startswith("gyro") else 5e-2
        noise = scale * rng.uniform(0.05, 0.3)
        c = rng.normal(0, scale, 4) * np.array([1, 1, 0.5, 0.3])
        wave = scale * 0.3 * rng.normal() if rng.uniform() < 0.3 else 0.0
        h = rng.normal(0, 0.3 * scale, 3) * (rng.uniform() < 0.7) * (np.arange(3) <= rng.integers(0, 3))

        def curve(v, c=c, wave=wave):
            return c[0] + c[1] * v + c[2] * v**2 + c[3] * v**3 + wave * np.sin(4 * v)

        y = curve(u) + 0.5 * sign * (h[0] + h[1] * u + h[2] * u**2)
        y = y + rng.normal(0, noise, len(t))
        if seed % 3 == 0:
            y = y + np.cumsum(rng.normal(0, noise * 0.004, len(t)))
        columns[axis] = y
        truths[axis] = curve
    return t, columns, truths


def one(program, seed):
    t, columns, truths = make(seed)
    names = ["time [s]"] + [f"{a} [rad/s]" for a in AXES[:3]] + [f"{a} [m/s^2]" for a in AXES[3:]] + ["temperature [degC]"]
    data = np.zeros(len(t), dtype=[(n, "<f8") for n in names])
    for n, c in zip(names, [np.arange(1, len(t) + 1) * 0.5, *[columns[a] for a in AXES], t]):
        data[n] = c
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "log.npy")
        np.save(path, data)
        done = subprocess.run([program, "calibrate", "thermal", path, "--format", "json"], capture_output=True, text=True)
    return seed, (json.loads(done.stdout) if done.returncode == 0 else None), done.stderr, truths


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("sets", type=int)
    parser.add_argument("--seed", type=int, default=20261125)
    arguments = parser.parse_args()
    inside, total, orders = {}, {}, {}
    with ThreadPoolExecutor(2) as pool:
        seeds = range(arguments.seed, arguments.seed + arguments.sets)
        for seed, result, error, truths in pool.map(lambda s: one(arguments.program, s), seeds):
            if result is None:
                print("refused", seed, error.splitlines()[0])
                continue
            for c in result["curves"]:
                if c["kind"] != "bias":
                    continue
                t = np.array(c["temperature"])
                for i in np.linspace(0, len(t) - 1, 11).round().astype(int)[1:-1]:
                    truth = truths[c["axis"]]((t[i] - 25) / 50)
                    key = ("walk" if seed % 3 == 0 else "white") + " " + c["form"]
                    for k in (key, "all"):
                        total[k] = total.get(k, 0) + 1
                        inside[k] = inside.get(k, 0) + (c["lower"][i] <= truth <= c["upper"][i])
                orders[c["form"], c["order"]] = orders.get((c["form"], c["order"]), 0) + 1
    for k in sorted(total):
        print(f"{k:20} {100 * inside[k] / total[k]:5.1f} % of {total[k]}")
    print(dict(sorted(orders.items())))


if __name__ == "__main__":
    main()
