"""The drift of `sagnac drift` against an independent strapdown and independent closed forms.

Usage: check_drift.py PATH_TO_SAGNAC   (needs numpy; about 20 s)

1. Closed forms on the sphere that does not rotate (one source at a time, at rest, vertical held): the covariance's
   RMS along the axis after 10 min and 3 h.
2. A Monte Carlo of our own, on the rotating ellipsoid: 400 runs of a local-level strapdown (quaternion, latitude,
   longitude; nothing is shared with the product) of 10 min at rest with run-to-run biases, white noise and a
   Gauss-Markov process, seed 20240607 declared before the run. The covariance's RMS must lie inside its 99.9 % interval,
   and the program's own Monte Carlo (200 runs, seed 3) inside the combined one.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

D, H, G = np.pi / 180, 3600.0, 9.80665
R_SPHERE = 6_371_000.0
failures = 0


def drift(program, model, *options):
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "m.toml"
        path.write_text('schema = 1\nname = "check"\n' + model)
        out = subprocess.run(
            [program, "drift", str(path), "--format", "json", "--quiet", *options],
            check=True, capture_output=True, text=True)
    return json.loads(out.stdout)


def judge(what, got, low, high):
    global failures
    good = low <= got <= high
    failures += not good
    print(f"{'ok  ' if good else 'FAIL'} {what}: {got:.6g} in {low:.6g} ... {high:.6g}")


def closed_forms(program):
    w = np.sqrt(G / R_SPHERE)
    b, e = 1e-3 * G, 0.1 * D / H
    na, ng = 0.05 / 60, 0.01 * D / 60
    cases = [
        ("accelerometer bias", f'[accel.bias]\nstability = "{b!r} m/s^2"\n', lambda t: b / w**2 * (1 - np.cos(w * t))),
        ("gyro bias", f'[gyro.bias]\nstability = "{e!r} rad/s"\n', lambda t: e * R_SPHERE * (t - np.sin(w * t) / w)),
        ("accelerometer white", f'[accel.noise]\nvelocity_random_walk = "{na!r} m/s/sqrt(s)"\n',
         lambda t: np.sqrt(na**2 / (2 * w**2) * (t - np.sin(2 * w * t) / (2 * w)))),
        ("gyro white", f'[gyro.noise]\nangle_random_walk = "{ng!r} rad/sqrt(s)"\n',
         lambda t: np.sqrt(ng**2 * R_SPHERE**2 * (1.5 * t - 2 * np.sin(w * t) / w + np.sin(2 * w * t) / (4 * w)))),
    ]
    for name, model, form in cases:
        for hours in (1 / 6, 3.0):
            got = drift(program, model, "--earth", "sphere", "--duration", f"{hours * 3600!r} s", "--rate", "20Hz")
            want = form(hours * 3600)
            # The other level axis has the same source: one axis alone is asked.
            judge(f"{name} after {hours:.3g} h / closed form", got["axes"]["north_m"][-1] / want, 0.999, 1.001)


# WGS 84.
A, F, OMEGA = 6_378_137.0, 1 / 298.257223563, 7.292115e-5
E2 = F * (2 - F)


def gravity(lat):
    s2 = np.sin(lat) ** 2
    return 9.7803253359 * (1 + 0.00193185265241 * s2) / np.sqrt(1 - E2 * s2)


def rotate(q, v):
    u, w = q[1:], q[0]
    t = 2 * np.cross(u, v, axis=0)
    return v + w * t + np.cross(u, t, axis=0)


def times(a, b):
    return np.array([
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]])


def turned(phi):
    n = np.sqrt((phi**2).sum(axis=0))
    s = np.where(n > 1e-12, np.sin(n / 2) / np.where(n > 1e-12, n, 1.0), 0.5)
    return np.concatenate([np.cos(n / 2)[None], phi * s])


def navigate(rate, force, dt, steps, runs):
    """Local-level strapdown at height 0; rate(k), force(k) give (3, runs) samples in body = NED at the start."""
    lat = np.full(runs, 45 * D)
    lon = np.zeros(runs)
    v = np.zeros((2, runs))
    q = np.zeros((4, runs))
    q[0] = 1
    for k in range(steps):
        m = A * (1 - E2) / (1 - E2 * np.sin(lat) ** 2) ** 1.5
        n = A / np.sqrt(1 - E2 * np.sin(lat) ** 2)
        earth = OMEGA * np.array([np.cos(lat), np.zeros(runs), -np.sin(lat)])
        moving = np.array([v[1] / n, -v[0] / m, -v[1] * np.tan(lat) / n])
        f = rotate(times(times(turned(-(earth + moving) * dt / 2), q), turned(rate(k) * dt / 2)), force(k))
        v3 = np.array([v[0], v[1], np.zeros(runs)])
        a = f - np.cross(2 * earth + moving, v3, axis=0)
        new = v + a[:2] * dt
        mean = (v + new) / 2
        lat = lat + mean[0] / m * dt
        lon = lon + mean[1] / (n * np.cos(lat)) * dt
        v = new
        q = times(times(turned(-(earth + moving) * dt), q), turned(rate(k) * dt))
        q /= np.sqrt((q**2).sum(axis=0))
    m = A * (1 - E2) / (1 - E2 * np.sin(45 * D) ** 2) ** 1.5
    n = A / np.sqrt(1 - E2 * np.sin(45 * D) ** 2)
    return np.array([(lat - 45 * D) * m, lon * n * np.cos(45 * D)])


def rms_interval(errors, z):
    m = (errors**2).sum(axis=0)
    half = z * m.std() / np.sqrt(m.size)
    return np.sqrt(max(m.mean() - half, 0)), np.sqrt(m.mean() + half)


def monte_carlo(program):
    runs, dt, length = 400, 0.1, 600.0
    steps = round(length / dt)
    rng = np.random.default_rng(20240607)
    bg, ba, ng, na = 10 * D / H, 1e-3 * G, 0.3 * D / 60, 0.05 / 60
    sg, tc = 20 * D / H, 200.0
    truth_w = OMEGA * np.array([np.cos(45 * D), 0, -np.sin(45 * D)])[:, None]
    truth_f = np.array([0, 0, -gravity(45 * D)])[:, None]
    dbg, dba = bg * rng.standard_normal((3, runs)), ba * rng.standard_normal((3, runs))
    state = sg * rng.standard_normal((3, runs))
    decay = np.exp(-dt / tc)
    current = {}

    def rate(k):
        nonlocal state
        if current.get("w", (None,))[0] != k:
            new = decay * state + sg * np.sqrt(1 - decay**2) * rng.standard_normal((3, runs))
            mean = (state + new) / 2
            state = new
            current["w"] = (k, truth_w + dbg + mean + ng / np.sqrt(dt) * rng.standard_normal((3, runs)))
        return current["w"][1]

    def force(k):
        if current.get("f", (None,))[0] != k:
            current["f"] = (k, truth_f + dba + na / np.sqrt(dt) * rng.standard_normal((3, runs)))
        return current["f"][1]

    still = navigate(lambda k: truth_w, lambda k: truth_f, dt, steps, 1)
    ours = navigate(rate, force, dt, steps, runs) - still
    low, high = rms_interval(ours, 3.29)
    model = (
        f'[gyro.bias]\nstability = "{bg!r} rad/s"\n[gyro.noise]\nangle_random_walk = "{ng!r} rad/sqrt(s)"\n'
        f'gauss_markov = [{{ sigma = "{sg!r} rad/s", correlation_time = "{tc!r} s" }}]\n'
        f'[accel.bias]\nstability = "{ba!r} m/s^2"\n[accel.noise]\nvelocity_random_walk = "{na!r} m/s/sqrt(s)"\n')
    common = ("--duration", "10min", "--rate", "10Hz")
    linear = drift(program, model, *common)
    judge("covariance, RMS in our Monte Carlo's 99.9 % interval, m", linear["rms_m"][-1], low, high)
    theirs = drift(program, model, "--method", "monte-carlo", "--runs", "200", "--seed", "3", *common)
    middle, own = np.sqrt((ours**2).sum(axis=0).mean()), theirs["rms_m"][-1]
    half = np.hypot((high - low) / 2, 3.29 / 1.96 * (theirs["rms_ci_m"][-1][1] - theirs["rms_ci_m"][-1][0]) / 2)
    judge("the program's Monte Carlo, RMS beside ours, m", own, middle - half, middle + half)


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    closed_forms(sys.argv[1])
    monte_carlo(sys.argv[1])
    if failures:
        sys.exit(f"{failures} checks failed")


if __name__ == "__main__":
    main()
