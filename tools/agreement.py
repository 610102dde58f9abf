"""AGREEMENT.md: the covariance beside the Monte Carlo of the built program, sensors x trajectories.

Usage: agreement.py PATH_TO_SAGNAC [--runs 200] [--first-seed 4000] > AGREEMENT.md   (no packages needed)

Every cell has a seed of its own, the first plus its place, declared by the command; nothing is rerun. A case is
outside where the covariance's RMS or CEP at the end is outside the Monte Carlo's 95 % interval; the 99.9 % interval of
the RMS is that of navigation.md section 3.1 (3.29 for 1.96). Cases whose errors leave the linear range
("valid": false) are shown and not judged.
"""

import argparse
import concurrent.futures
import datetime
import json
import math
import platform
import subprocess

SENSORS = ["HG9900", "HG5700-AA01", "LN-200S", "STIM300", "STIM377H", "iIMU-FSAS", "HG4930", "ADIS16495-1",
           "ADIS16470", "VN-100"]
TRAJECTORIES = ["rest", "drive", "flight", "walking"]
LENGTH = "5min"


def run(program, sensor, trajectory, seed, runs):
    out = subprocess.run(
        [program, "drift", f"catalog:{sensor}", "--trajectory", trajectory, "--duration", LENGTH, "--rate", "100Hz",
         "--method", "monte-carlo", "--runs", str(runs), "--seed", str(seed), "--format", "json", "--quiet"],
        check=True, capture_output=True, text=True)
    mc = json.loads(out.stdout)
    out = subprocess.run(
        [program, "drift", f"catalog:{sensor}", "--trajectory", trajectory, "--duration", LENGTH, "--rate", "100Hz",
         "--format", "json", "--quiet"],
        check=True, capture_output=True, text=True)
    return json.loads(out.stdout), mc


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--first-seed", type=int, default=4000)
    arguments = parser.parse_args()
    cases = [(s, t) for s in SENSORS for t in TRAJECTORIES]
    with concurrent.futures.ThreadPoolExecutor(1) as pool:
        found = list(pool.map(
            lambda c: run(arguments.program, *c[1], arguments.first_seed + c[0], arguments.runs), enumerate(cases)))
    print("# Do the covariance and the Monte Carlo agree?\n")
    print(f"{datetime.date.today()}, {platform.machine()}; `python3 tools/agreement.py target/release/sagnac "
          f"--runs {arguments.runs} --first-seed {arguments.first_seed}`.\n")
    print(f"{LENGTH} at 100 Hz from 45 N, perfect start attitude, height held; case k has seed "
          f"{arguments.first_seed} + k, none was run twice. Metres; intervals 95 %.\n")
    print("| k | sensor | trajectory | RMS, covariance | RMS, runs | interval | CEP, covariance | CEP, runs | interval | |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    judged, outside, far = 0, [], []
    for k, ((sensor, trajectory), (linear, runs)) in enumerate(zip(cases, found)):
        words = []
        # Both must call the errors small for linear numbers to be judged.
        valid = linear["valid"] and runs["valid"]
        if not valid:
            words.append("beyond the linear range: not judged")
        for name in ("rms", "cep"):
            x, (low, high) = linear[f"{name}_m"][-1], runs[f"{name}_ci_m"][-1]
            if valid:
                judged += 1
            if valid and not low <= x <= high:
                words.append(f"{name.upper()} outside")
                outside.append(f"{k} ({sensor}, {trajectory}, {name.upper()})")
        if valid:
            m2 = runs["rms_m"][-1] ** 2
            half = 3.29 / 1.96 * (runs["rms_ci_m"][-1][1] ** 2 - m2)
            low, high = math.sqrt(max(m2 - half, 0)), math.sqrt(m2 + half)
            if not low <= linear["rms_m"][-1] <= high:
                far.append(f"{k} ({sensor}, {trajectory})")
        row = [str(k), sensor, trajectory]
        for name in ("rms", "cep"):
            low, high = runs[f"{name}_ci_m"][-1]
            row += [f"{linear[f'{name}_m'][-1]:.4g}", f"{runs[f'{name}_m'][-1]:.4g}", f"{low:.4g} … {high:.4g}"]
        print("| " + " | ".join(row + ["; ".join(words)]) + " |")
    print(f"\n{judged - len(outside)} of {judged} figures are inside their 95 % interval "
          f"({0.95 * judged:.1f} would be expected). Outside: {'; '.join(outside) or 'none'}.")
    print(f"Outside the 99.9 % interval of the RMS: {'; '.join(far) or 'none'}.")


if __name__ == "__main__":
    main()
