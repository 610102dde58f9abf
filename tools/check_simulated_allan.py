"""Allan variance of logs that `sagnac simulate` wrote, by allantools, against the closed forms.

Usage: check_simulated_allan.py PATH_TO_SAGNAC   (needs numpy, scipy, allantools)

Each term alone, 40 declared runs (seed 1, --runs 40) of 400 s at 100 Hz; at every tau >= 2 dt up to a
quarter of the run the mean over runs of the non-overlapping Allan variance must lie within five
standard errors (from the scatter over runs) of theory; flicker is allowed 13 % besides.
"""

import pathlib
import subprocess
import sys
import tempfile

import allantools
import numpy as np

DT, RUNS, LENGTH = 0.01, 40, 400
D, H = np.pi / 180, 3600.0

TERMS = {
    "white": ("angle_random_walk = '0.3 deg/sqrt(h)'", lambda t: (0.3 * D / 60) ** 2 / t, 0),
    "quantization": ("quantization = '10 arcsec'", lambda t: 3 * (10 * D / H) ** 2 / t**2, 0),
    "random_walk": ("rate_random_walk = '15 deg/h/sqrt(h)'", lambda t: (15 * D / H / 60) ** 2 * t / 3, 0),
    "ramp": ("rate_ramp = '100 deg/h/h'", lambda t: (100 * D / H / H) ** 2 * t**2 / 2, 0),
    "gauss_markov": (
        "gauss_markov = [{ sigma = '10 deg/h', correlation_time = '3 s' }]",
        lambda t: 2 * (10 * D / H) ** 2 * 3 / t
        * (1 - 3 / (2 * t) * (3 - 4 * np.exp(-t / 3) + np.exp(-2 * t / 3))),
        1e-6,
    ),
    "flicker": ("", lambda t: 2 * np.log(2) / np.pi * (8 * D / H) ** 2 + 0 * t, 0.13),
}


def main(program):
    failures = 0
    for name, (line, theory, allowance) in TERMS.items():
        with tempfile.TemporaryDirectory() as folder:
            model = pathlib.Path(folder, "m.toml")
            flicker = "[gyro.bias.instability]\ncoefficient = '8 deg/h'\n" if name == "flicker" else ""
            model.write_text(f"schema = 1\nname = 'x'\n[gyro]\n{flicker}[gyro.noise]\n{line}\n")
            subprocess.run(
                [program, "simulate", model, "--rest", f"{LENGTH} s", "--rate", "100Hz", "--seed", "1",
                 "--runs", str(RUNS), "--noise", name, "--quiet", "-o", pathlib.Path(folder, "x.npy")],
                check=True, stdout=subprocess.DEVNULL)
            axes = [np.load(f)[c] for f in sorted(pathlib.Path(folder).glob("x-*.npy"))
                    for c in ("gyro_x [rad/s]", "gyro_y [rad/s]", "gyro_z [rad/s]")]
        taus = DT * np.array([2, 3, 5, 10, 30, 100, 300, 1000, 3000, 10000])
        got = []
        for x in axes:
            t, deviation, _, _ = allantools.adev(x - x.mean(), rate=1 / DT, data_type="freq", taus=taus)
            got.append(deviation**2)
        got = np.array(got)
        error = got.std(axis=0, ddof=1) / np.sqrt(len(axes))
        ratio = got.mean(axis=0) / theory(t)
        bad = np.abs(got.mean(axis=0) - theory(t)) > 5 * error + (allowance + 1e-6) * theory(t)
        failures += bad.sum()
        print(f"{name:13s}", " ".join(f"{r:6.3f}" for r in ratio), "FAIL" if bad.any() else "ok")
    return int(failures > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
