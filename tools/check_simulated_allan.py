"""Allan variance and spectrum of logs that `sagnac simulate` wrote, against the closed forms.

Usage: check_simulated_allan.py PATH_TO_SAGNAC [FIRST_SEED]   (needs numpy, scipy, allantools)

Each random term alone, their sum, and both kinds of rounding; 40 declared runs (seed 1 unless given, --runs 40)
of 400 s at 100 Hz, three axes. At every tau from 2 dt to a quarter of the run the mean over runs of the Allan
variance, and at twenty frequencies the mean of Welch's density, must lie within five standard errors (from the
scatter over axes and runs) of theory. Flicker is allowed 13 % of variance and 0.5 dB of density besides. The
draws of 400 runs must have the stated sigma within five of its standard errors. A sinusoid is a line and a ramp
has no density: they are judged by their Allan variance alone.
"""

import pathlib
import subprocess
import sys
import tempfile

import allantools
import numpy as np
from scipy.signal import welch

DT, RUNS, LENGTH = 0.01, 40, 400
D, H = np.pi / 180, 3600.0
AXES = ("gyro_x [rad/s]", "gyro_y [rad/s]", "gyro_z [rad/s]")
SEGMENT = 4096


def sampled(density):
    """PSD of interval means taken every DT: averaging and aliasing of a process's own PSD."""

    def of(f):
        j = np.arange(-400, 401)[:, None]
        g = f[None, :] + j / DT
        return (density(g) * np.sinc(g * DT) ** 2).sum(axis=0)

    return of


def gauss_markov(sigma, tc):
    allan = lambda t: 2 * sigma**2 * tc / t * (1 - tc / (2 * t) * (3 - 4 * np.exp(-t / tc) + np.exp(-2 * t / tc)))
    return allan, sampled(lambda f: 2 * sigma**2 * tc / (1 + (2 * np.pi * f * tc) ** 2))


def resonance(sigma, fr, zeta):
    w = 2 * np.pi * fr
    root = np.sqrt(1 - zeta**2)
    lam = w * (zeta - 1j * root)
    v = lambda u: 2 * sigma**2 * np.real((1 - 1j * zeta / root) * (u / lam - (1 - np.exp(-lam * u)) / lam**2))
    allan = lambda t: (4 * v(t) - v(2 * t)) / (2 * t**2)
    psd = lambda f: sigma**2 * 4 * zeta * w**3 / ((w**2 - (2 * np.pi * f) ** 2) ** 2 + (2 * zeta * w * 2 * np.pi * f) ** 2)
    return allan, sampled(psd)


N, Q, K, R, B = 0.3 * D / 60, 10 * D / H, 15 * D / H / 60, 100 * D / H / H, 8 * D / H
A, F0 = 0.02 * D, 3.137
LSB_RATE = N / np.sqrt(DT)
LSB_ANGLE = N * np.sqrt(DT) / 0.6

# name: (lines of [gyro.noise], Allan variance, PSD of the samples or None)
TERMS = {
    "white": ("angle_random_walk = '0.3 deg/sqrt(h)'", lambda t: N**2 / t, lambda f: N**2 + 0 * f),
    "quantization": (
        "quantization = '10 arcsec'", lambda t: 3 * Q**2 / t**2, lambda f: 4 * Q**2 / DT * np.sin(np.pi * f * DT) ** 2),
    "random_walk": (
        "rate_random_walk = '15 deg/h/sqrt(h)'", lambda t: K**2 * t / 3, sampled(lambda f: (K / (2 * np.pi * f)) ** 2)),
    "ramp": ("rate_ramp = '100 deg/h/h'", lambda t: R**2 * t**2 / 2, None),
    "gauss_markov": (
        "gauss_markov = [{ sigma = '10 deg/h', correlation_time = '3 s' }]", *gauss_markov(10 * D / H, 3.0)),
    "resonance": (
        "resonances = [{ sigma = '0.02 deg/s', frequency = '7 Hz', damping = 0.1 }]", *resonance(0.02 * D, 7.0, 0.1)),
    "sinusoid": (
        f"sinusoids = [{{ amplitude = '0.02 deg/s', frequency = '{F0} Hz' }}]",
        lambda t: A**2 * (np.sin(np.pi * F0 * t) ** 2 / (np.pi * F0 * t)) ** 2, None),
    "flicker": (
        "", lambda t: 2 * np.log(2) / np.pi * B**2 + 0 * t, sampled(lambda f: B**2 / (2 * np.pi * np.abs(f)))),
}


def simulate(program, folder, model, noise, seed, options=("--rest", f"{LENGTH} s"), runs=RUNS):
    path = pathlib.Path(folder, "m.toml")
    path.write_text("schema = 1\nname = 'x'\nsample_rate = '100 Hz'\n" + model)
    subprocess.run(
        [program, "simulate", path, *options, "--seed", str(seed), "--runs", str(runs), "--noise", noise, "--quiet",
         "-o", pathlib.Path(folder, "x.npy")],
        check=True, stdout=subprocess.DEVNULL)
    return [np.load(f) for f in sorted(pathlib.Path(folder).glob("x-*.npy"))]


def judge(label, got, theory, allowance):
    """Mean over axes and runs against theory; prints the ratios, returns how many are off."""
    error = got.std(axis=0, ddof=1) / np.sqrt(len(got))
    off = np.abs(got.mean(axis=0) - theory) > 5 * error + (allowance + 1e-6) * theory
    ratio = got.mean(axis=0) / theory
    print(f"{label:30s} {ratio.min():6.3f} … {ratio.max():6.3f}", "FAIL" if off.any() else "ok")
    return int(off.sum())


def examine(label, logs, allan, density, flicker):
    axes = [log[name] for log in logs for name in AXES]
    taus = DT * np.array([2, 3, 5, 10, 30, 100, 300, 1000, 3000, 10000])
    variances = []
    for x in axes:
        t, deviation, _, _ = allantools.adev(x - x.mean(), rate=1 / DT, data_type="freq", taus=taus)
        variances.append(deviation**2)
    off = judge(f"{label}, Allan variance", np.array(variances), allan(t), 0.13 if flicker else 0)
    if density is not None:
        f, _ = welch(axes[0], 1 / DT, nperseg=SEGMENT)
        at = np.unique(np.round(np.geomspace(8, SEGMENT // 2 - 2, 20)).astype(int))
        # Two-sided from one-sided; the smooth spectrum is weighted by the window as the estimate is.
        got = np.array([welch(x, 1 / DT, nperseg=SEGMENT, detrend="linear")[1][at] / 2 for x in axes])
        window = np.abs(np.fft.fft(np.hanning(SEGMENT + 1)[:-1], SEGMENT * 8)) ** 2
        fine = (np.arange(-40, 41) / 8)[None, :]
        weight = window[np.arange(-40, 41) % (SEGMENT * 8)]
        grid = np.abs((at[:, None] + fine) / (SEGMENT * DT))
        theory = (density(grid.ravel()).reshape(grid.shape) * weight).sum(axis=1) / weight.sum()
        off += judge(f"{label}, density", got, theory, 10**0.05 - 1 if flicker else 0)
    return off


def draws(program, seed):
    """Bias, scale factor and misalignment of 400 runs, seen through four known rates."""
    with tempfile.TemporaryDirectory() as folder:
        truth = pathlib.Path(folder, "truth.csv")
        rows = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
        truth.write_text("time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s]\n" + "".join(
            f"{(k + 1) * DT},{x},{y},{z}\n" for k, (x, y, z) in enumerate(rows)))
        model = ("[gyro.bias]\nstability = '20 deg/h'\n[gyro.scale_factor]\nstability = '100 ppm'\n"
                 "[gyro.misalignment]\nstability = '0.05 mrad'\n")
        logs = simulate(program, folder, model, "stability", seed, ("--inputs", str(truth)), 400)
    y = np.array([[log[name] for name in AXES] for log in logs])  # run, axis, row
    bias = y[:, :, 0]
    gain = y[:, :, 1:] - bias[:, :, None] - np.eye(3)
    values = {("bias", k): bias[:, k] / (20 * D / H) for k in range(3)}
    values |= {(j, k): gain[:, j, k] / (1e-4 if j == k else 5e-5) for j in range(3) for k in range(3)}
    off = 0
    stack = np.array(list(values.values()))
    n = stack.shape[1]
    # sigma of a sample variance is sqrt(2/n); of a mean and of a correlation 1/sqrt(n).
    off += (np.abs((stack**2).mean(axis=1) - 1) > 5 * np.sqrt(2 / n)).sum()
    off += (np.abs(stack.mean(axis=1)) > 5 / np.sqrt(n)).sum()
    correlation = np.corrcoef(stack) - np.eye(len(stack))
    off += (np.abs(correlation) > 5 / np.sqrt(n)).sum()
    spread = np.sqrt((stack**2).mean(axis=1))
    print(f"{'draws over 400 runs, sigma':30s} {spread.min():6.3f} … {spread.max():6.3f}", "FAIL" if off else "ok")
    return int(off)


def main(program, seed):
    failures = 0
    flicker_table = "[gyro.bias.instability]\ncoefficient = '8 deg/h'\n"
    for name, (line, allan, density) in TERMS.items():
        with tempfile.TemporaryDirectory() as folder:
            table = flicker_table if name == "flicker" else ""
            logs = simulate(program, folder, f"{table}[gyro.noise]\n{line}\n", name, seed)
            failures += examine(name, logs, allan, density, name == "flicker")
    with tempfile.TemporaryDirectory() as folder:
        lines = "\n".join(line for line, _, _ in TERMS.values())
        logs = simulate(program, folder, f"{flicker_table}[gyro.noise]\n{lines}\n", "all", seed)
        failures += examine("all terms", logs, lambda t: sum(term[1](t) for term in TERMS.values()), None, True)
        names = ",".join(name for name, term in TERMS.items() if term[2] is not None)
    with tempfile.TemporaryDirectory() as folder:
        logs = simulate(program, folder, f"{flicker_table}[gyro.noise]\n{lines}\n", names, seed)
        parts = [term for term in TERMS.values() if term[2] is not None]
        failures += examine("all terms with a density", logs, lambda t: sum(term[1](t) for term in parts),
                            lambda f: sum(term[2](f) for term in parts), True)
    white = "[gyro.noise]\nangle_random_walk = '0.3 deg/sqrt(h)'\n"
    with tempfile.TemporaryDirectory() as folder:
        # The noise is one count (1 sigma); at half a count the rule errs by up to 2 %, which would be seen here.
        model = f"[gyro]\nresolution = '{float(LSB_RATE / D)!r} deg/s'\n" + white
        more = LSB_RATE**2 * DT / 12
        logs = simulate(program, folder, model, "white", seed)
        failures += examine("white, rate rounded", logs, lambda t: (N**2 + more) / t, None, False)
    with tempfile.TemporaryDirectory() as folder:
        model = f"[gyro]\nresolution = '{float(LSB_ANGLE / D * 3600)!r} arcsec'\noutput = 'increment'\n" + white
        logs = simulate(program, folder, model, "white", seed)
        failures += examine("white, increment rounded", logs,
                            lambda t: N**2 / t + LSB_ANGLE**2 / 4 / t**2,
                            lambda f: N**2 + 4 * LSB_ANGLE**2 / 12 / DT * np.sin(np.pi * f * DT) ** 2, False)
    failures += draws(program, seed)
    print(f"{failures} values off")
    return int(failures > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 1))
