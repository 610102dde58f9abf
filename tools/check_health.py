"""False alarms and misses of `sagnac info` on logs drawn here (exact noise of axes.py), one fault each at 1.5 x its threshold.

Usage: check_health.py PATH_TO_SAGNAC [--axes] [--clean N] [--faults N] [--seed S] [--only KIND]

Clean logs are mixtures {N}, {N,B}, {N,B,K}, {Q,N}, {N,Gauss-Markov} on six channels with gravity and a bias; every kind
may be named in at most 1 % of them (one in the short run). Each fault must be found, its span right, in at least 95 %.
The short run has 40 clean logs and 10 a fault; --axes runs 200 and 50. Seeds are declared: log k of a table has
SeedSequence([seed, table, k]), seed 1 unless given.
"""
import argparse
import collections
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

import axes

KINDS = ("gap duplicate backwards jitter nan saturation stuck units motion quantization non_stationary short").split()
COLUMNS = "gyro=1,2,3:rad/s, accel=4,5,6:m/s^2"
LENGTHS = [(20, 600), (50, 400), (100, 240), (100, 720)]  # Hz, s


def mixture(rng, n, dt, level):
    """A mixture of white noise `level` (rad/s/sqrt(Hz)) with terms between invisible and clear."""
    mix = {"N": level}
    kind = rng.integers(5)
    span = n * dt
    if kind in (1, 2):
        mix["B"] = level / np.sqrt(span) * rng.uniform(2, 20)
    if kind == 2:
        mix["K"] = level / span * rng.uniform(2, 30)
    if kind == 3:
        mix["Q"] = level * np.sqrt(dt) * rng.uniform(0.3, 2)
    if kind == 4:
        tc = np.exp(rng.uniform(np.log(20 * dt), np.log(span / 6)))
        mix["GM"] = [(level / np.sqrt(tc) * rng.uniform(0.5, 3), tc)]
    return mix


class Drawn:
    def __init__(self, rng, length=None):
        rate, span = LENGTHS[rng.integers(len(LENGTHS))] if length is None else length
        self.rng, self.dt, self.n = rng, 1 / rate, round(rate * span)
        self.unit, self.rate = "s", None
        self.time = 100 + self.dt * np.arange(1, self.n + 1)
        mean = list(rng.normal(0, 5e-3, 3)) + [0.05, -0.1, 9.8]
        self.noise = np.stack([axes.draw(rng, self.n, self.dt, mixture(rng, self.n, self.dt, level))
                               for level in [1e-4] * 3 + [1e-3] * 3])
        self.y = self.noise + np.array(mean)[:, None]

    def sigma_w(self, c):
        return 1.4826 * np.median(np.abs(np.diff(self.y[c]))) / np.sqrt(2)

    def averages(self, c):
        size = max(round(1 / self.dt), 50)
        m = self.y[c][: self.n // size * size].reshape(-1, size)
        return size, m.mean(1), m.std(1)

    def sigma_a(self, c):
        return 1.4826 * np.median(np.abs(np.diff(self.averages(c)[1]))) / np.sqrt(2)

    def somewhere(self, length=1):
        return int(self.rng.integers(self.n // 10, self.n - self.n // 10 - length))

    def ask(self, program, folder):
        path = pathlib.Path(folder, "log.npy")
        np.save(path, np.column_stack([self.time, self.y.T]))
        run = subprocess.run(
            [program, "info", path, "--format", "json", "--columns", f"time=0:{self.unit}, {COLUMNS}"],
            capture_output=True, text=True)
        if run.returncode:
            raise SystemExit(f"{run.args}: {run.stderr}")
        return json.loads(run.stdout)["issues"]


# A fault changes the log and returns channel (None: any), start and end of what must be found, and the slack in seconds.

def gap(log):
    k = log.somewhere()
    log.time[k:] += 1.25 * log.dt
    return "time", log.time[k - 1], log.time[k], log.dt


def duplicate(log):
    k = log.somewhere()
    log.time[k] = log.time[k - 1]
    return "time", log.time[k], log.time[k], 1.5 * log.dt


def backwards(log):
    k = log.somewhere()
    log.time[k:] -= 2.5 * log.dt
    return "time", log.time[k], log.time[k], 2 * log.dt


def wrap(log):
    k = log.somewhere()
    count = np.round((np.arange(log.n) - k) * log.dt * 1e6).astype(np.int64) + 2**32
    log.time, log.unit = (count % 2**32).astype(float), "us"
    at = (count[k] / 1e6, count[k] / 1e6)
    return "time", *at, 2 * log.dt


def jitter(log):
    if log.rng.random() < 0.5:
        log.time += 0.075 / np.sqrt(2) * log.dt * log.rng.standard_normal(log.n)
    else:
        # A late stamp makes two steps off: 1.5 % of the steps by 30 %.
        late = log.rng.random(log.n) < 0.0075 * 1.02
        late[0] = late[-1] = False
        log.time[late] += 0.3 * log.dt
    return "time", log.time[0], log.time[-1], 2 * log.dt


def nan(log):
    c, k = log.rng.integers(6), log.somewhere()
    log.y[c, k] = log.rng.choice([np.nan, np.inf, -np.inf])
    return NAMES[c], log.time[k], log.time[k], 1.5 * log.dt


def saturation(log):
    c, a = log.rng.integers(6), log.somewhere(30)
    side = log.rng.choice([-1, 1])
    far = np.median(log.y[c]) + side * 4.5 * log.sigma_w(c)
    largest = side * np.max(side * log.y[c]) + side * 0.01 * log.sigma_w(c)
    limit = side * max(side * far, side * largest)
    log.y[c, a : a + 5] = limit
    log.y[c, a + 8 : a + 11] = limit
    return NAMES[c], log.time[a], log.time[a + 10], 1.5 * log.dt


def stuck(log):
    c, a = log.rng.integers(6), log.somewhere(30)
    log.y[c, a : a + 30] = log.y[c, a]
    return NAMES[c], log.time[a], log.time[a + 29], 1.5 * log.dt


def units(log):
    kind = log.rng.integers(4)
    if kind == 0:
        log.y[3:] *= 1.12
    elif kind == 1:
        log.y[3:] *= 0.88
    elif kind == 2:
        log.y[3:] /= 9.80665
    else:
        log.y[0] += 7.5
    return None, log.time[0], log.time[-1], 2 * log.dt


def motion(log):
    kind = log.rng.integers(3)
    size, _, scatter = log.averages(0)
    a = log.somewhere(2 * size)
    part = slice(a, a + 2 * size)
    first = 3 * log.rng.integers(2)
    channels = [first] if kind == 1 else first + log.rng.permutation(3)[:2]
    for c in channels:
        if kind == 2:
            std = np.median(log.averages(c)[2])
            log.y[c, part] += np.sqrt(4.5**2 - 1) * std * log.rng.standard_normal(2 * size)
        else:
            log.y[c, part] += log.rng.choice([-1, 1]) * 12 * log.sigma_a(c)
    return None, log.time[a], log.time[a + 2 * size - 1], 1.05 * size * log.dt


def quantization(log):
    c = log.rng.integers(6)
    lsb = log.sigma_w(c) / 1.0
    log.y[c] = lsb * np.round(log.y[c] / lsb)
    return NAMES[c], log.time[0], log.time[-1], 2 * log.dt


def non_stationary(log):
    c = log.rng.integers(6)
    length = round(0.15 * log.n)
    factor = max(1.15, 1 + 9 * np.sqrt(0.75 / length + 0.75 / log.n))
    a = int(log.rng.integers(0, log.n - length))
    log.y[c, a : a + length] += (factor - 1) * log.noise[c, a : a + length]
    return NAMES[c], log.time[a], log.time[a + length - 1], 0.06 * log.n * log.dt


def short(log):
    n = 42 if log.rng.random() < 0.5 else round(66 / log.dt)
    log.n, log.time, log.y = n, log.time[:n], log.y[:, :n]
    return None, log.time[0], log.time[-1], 2 * log.dt


NAMES = ["gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z"]
FAULTS = [gap, duplicate, backwards, wrap, jitter, nan, saturation, stuck, units, motion, quantization,
          non_stationary, short]


def judge(issues, kind, want):
    """found, and found with the right span."""
    channel, start, end, slack = want
    hits = [i for i in issues if i["kind"] == kind and (channel is None or i["channel"] == channel)]
    if not hits:
        return False, False
    a, b = min(i["start_s"] for i in hits), max(i["end_s"] for i in hits)
    return True, bool(abs(a - start) <= slack + 1e-9 and abs(b - end) <= slack + 1e-9)


def main():
    p = argparse.ArgumentParser()
    p.add_argument("program")
    p.add_argument("--axes", action="store_true")
    p.add_argument("--clean", type=int)
    p.add_argument("--faults", type=int)
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--only")
    p.add_argument("--verbose", action="store_true")
    o = p.parse_args()
    clean = o.clean if o.clean is not None else 200 if o.axes else 40
    many = o.faults if o.faults is not None else 50 if o.axes else 10
    failed = False
    with tempfile.TemporaryDirectory() as folder:
        named = collections.Counter()
        for k in range(clean):
            log = Drawn(np.random.default_rng([o.seed, 0, k]))
            issues = log.ask(o.program, folder)
            named.update({i["kind"] for i in issues})
            if o.verbose and issues:
                print(f"  clean {k} ({log.n} x {log.dt} s):", [(i["kind"], i["channel"], i["text"]) for i in issues])
        allowed = max(clean // 100, 1)
        for kind in KINDS:
            if named[kind] > allowed:
                failed = True
        print(f"clean: falsely named in {clean} logs:", dict(named) or "none")
        for t, fault in enumerate(FAULTS, 1):
            if o.only and fault.__name__ != o.only:
                continue
            found = right = 0
            kind = "backwards" if fault is wrap else fault.__name__
            for k in range(many):
                rng = np.random.default_rng([o.seed, t, k])
                log = Drawn(rng, (100, 720) if fault is non_stationary else None)
                want = fault(log)
                issues = log.ask(o.program, folder)
                a, b = judge(issues, kind, want)
                found, right = found + a, right + b
                if o.verbose and not b:
                    print(f"  {fault.__name__} {k}: want {want}",
                          [(i["kind"], i["channel"], i["start_s"], i["end_s"]) for i in issues])
            bad = min(found, right) < 0.95 * many - (1 if many < 20 else 0)
            failed |= bad
            print(f"{fault.__name__:15s} found {found}/{many}, span right {right}/{many}", "FAIL" if bad else "")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
