"""Coverage of the chi-square intervals of `allan` at every averaging time, on axes drawn by axes.py.

Usage: check_intervals.py PATH_TO_SAGNAC [--logs N] [--samples N] [--seed S]

Six axes a log of one noise alone: white phase (Q), white (N), flicker (B), random walk (K); `adev`, `oadev`, `hdev` (and
`mdev` of N) at octaves. The truth is the exact variance of interval means: 3Q^2/tau^2, N^2/tau, (2 ln2/pi) B^2, K^2 tau/3;
Hadamard (10/3)Q^2/tau^2, N^2/tau, ln(256/27)/(2 pi) B^2, K^2 tau/6; modified N^2 (m^2 + 1)/(2 m^2 tau). The noise type is the
one that the program finds, so that what a wrong one costs is in the figures. Each row must cover in at least 93 %, each
averaging time in at least 90 %, and no row but those of Q in more than 97.5 %: quantization is uniform, not Gaussian, and
its squares scatter less. Log k of a row has SeedSequence([seed, row, k]), seed 1 unless given.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

import axes

DT = 0.01
PI = np.pi
LAWS = {
    "adev": {"Q": lambda t: 3 / t**2, "N": lambda t: 1 / t, "B": lambda t: 2 * np.log(2) / PI + 0 * t, "K": lambda t: t / 3},
    "hdev": {"Q": lambda t: 10 / 3 / t**2, "N": lambda t: 1 / t, "B": lambda t: np.log(256 / 27) / (2 * PI) + 0 * t,
             "K": lambda t: t / 6},
    "mdev": {"N": lambda t: (1 + (DT / t) ** 2) / (2 * t)},
}
LAWS["oadev"] = LAWS["adev"]


def main():
    p = argparse.ArgumentParser()
    p.add_argument("program")
    p.add_argument("--logs", type=int, default=100)
    p.add_argument("--samples", type=int, default=4096)
    p.add_argument("--seed", type=int, default=1)
    o = p.parse_args()
    failed = False
    print(f"{6 * o.logs} axes of {o.samples} samples a row, seed {o.seed}: covered in %")
    rows = [(kind, term) for kind in ("adev", "oadev", "hdev", "mdev") for term in LAWS[kind]]
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder, "log.npy")
        for row, (kind, term) in enumerate(rows):
            covered = 0
            for k in range(o.logs):
                rng = np.random.default_rng([o.seed, row, k])
                np.save(path, np.column_stack([axes.draw(rng, o.samples, DT, {term: 1.0}) for _ in range(6)]))
                run = subprocess.run([o.program, "allan", path, "--rate", "100Hz", "--columns",
                                      "gyro=0,1,2:rad/s, accel=3,4,5:m/s^2", "--deviation", kind, "--taus", "octave",
                                      "--format", "json", "--threads", "1"], capture_output=True, text=True, check=True)
                curves = json.loads(run.stdout)["axes"]
                tau = np.array(curves[0]["tau_s"])
                truth = np.sqrt(LAWS[kind][term](tau))
                inside = [(np.array(c["lower"]) <= truth) & (truth <= np.array(c["upper"])) for c in curves]
                covered = covered + np.sum(inside, axis=0)
            share = 100 * covered / (6 * o.logs)
            bad = share.mean() < 93 or share.min() < 90 or (term != "Q" and share.mean() > 97.5)
            failed |= bad
            print(f"{kind:6s} {term}  all {share.mean():5.1f}  by tau {' '.join(f'{s:.0f}' for s in share)}",
                  "FAIL" if bad else "", flush=True)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
