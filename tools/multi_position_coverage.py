"""Coverage of the 95 % intervals of `sagnac calibrate multi-position` on hand-turned logs of an independent generator.

    python3 tools/multi_position_coverage.py target/release/sagnac 200 [--seed 20261125] [--case 24,14,knocks,walk,earth]

Seeds are seed + 0 ... seed + N - 1 of each case, declared here: 20261125, and 20270101 as the second set. Kinds are
pooled over axes and over both sensors as in calibration.md section 5; with the walk the gyro bias is not judged.
"""

import argparse
import json
import os
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor

import numpy as np

import multi_position_generator as generator

CASES = {
    "24": {"poses": 24},
    "14": {"poses": 14},
    "knocks": {"poses": 20, "knocks": True},
    "walk": {"poses": 24, "walk": 3e-5},
    "earth": {"poses": 24, "latitude": 0.8},
}


def kind(name):
    sensor, term = name.split(".")[:2]
    return f"{sensor}.{term}"


def one(program, seed, settings):
    time, gyro, accel, truth = generator.make(seed, **settings)
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "log.npy")
        generator.write(path, time, gyro, accel)
        call = [program, "calibrate", "multi-position", path, "--format", "json"]
        if "latitude" in settings:
            call += ["--latitude", f"{settings['latitude']} rad", "--gravity", f"{generator.G0} m/s^2"]
        done = subprocess.run(call, capture_output=True, text=True)
    if done.returncode:
        return seed, None, done.stderr, truth
    return seed, json.loads(done.stdout), "", truth


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("sets", type=int)
    parser.add_argument("--seed", type=int, default=20261125)
    parser.add_argument("--case", default=",".join(CASES))
    arguments = parser.parse_args()
    for case in arguments.case.split(","):
        settings = CASES[case]
        inside, total, sigmas, squares = {}, {}, {}, {}
        refused, scaled, wrong = [], {"accel": 0, "gyro": 0}, {}
        drift = earth = 0
        walks = []
        with ThreadPoolExecutor(2) as pool:
            seeds = range(arguments.seed, arguments.seed + arguments.sets)
            for seed, result, error, truth in pool.map(lambda s: one(arguments.program, s, settings), seeds):
                if result is None:
                    refused.append((seed, error.splitlines()[0]))
                    continue
                for p in result["parameters"]:
                    if case == "walk" and p["name"].startswith("gyro.bias"):
                        continue
                    for k in (kind(p["name"]), p["name"].split(".")[1]):
                        total[k] = total.get(k, 0) + 1
                        inside[k] = inside.get(k, 0) + (p["lower"] <= truth[p["name"]] <= p["upper"])
                        sigmas.setdefault(k, []).append(p["sigma"])
                        squares.setdefault(k, []).append(((p["value"] - truth[p["name"]]) / p["sigma"]) ** 2)
                for fit in result["chi2"]:
                    scaled[fit["axis"]] += fit["scaled"]
                wrong[len(result["poses"])] = wrong.get(len(result["poses"]), 0) + 1
                drift += any(result["gyro_drift"]["rate_random_walk"]) if result["gyro_drift"] else 0
                if "walk" in settings:
                    drawn = result["gyro_drift"]
                    walks += [low <= settings["walk"] <= high for rate, (low, high)
                              in zip(drawn["rate_random_walk"], drawn["interval"]) if rate]
                earth += result["gyro_drift"]["earth_rate_counted"] if result["gyro_drift"] else 0
        print(f"{case}: {settings}, {arguments.sets} sets, seeds from {arguments.seed}; refused {len(refused)} {refused[:2]}")
        print(f"  widened accel {scaled['accel']}, gyro {scaled['gyro']}; drift seen {drift}, Earth counted {earth}; "
              f"poses {dict(sorted(wrong.items()))}")
        if walks:
            print(f"  the walk is in {100 * np.mean(walks):.1f} % of its {len(walks)} intervals")
        for k in sorted(total, key=lambda k: ("." not in k, k)):
            print(f"  {k:24} {100 * inside[k] / total[k]:5.1f} % of {total[k]:5}   median sigma {np.median(sigmas[k]):.2e}"
                  f"   rms of error/sigma {np.sqrt(np.mean(squares[k])):.2f}")


if __name__ == "__main__":
    main()
