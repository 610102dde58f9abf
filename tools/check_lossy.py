"""What `characterize` tells of logs with lost samples, against the truth and against the same logs whole.

Usage: check_lossy.py PATH_TO_SAGNAC [--logs N] [--seed S] [--only NAME,…] [--rates 100,50]

A log has six axes, one each of {N}, {N,B} weak and strong, {N,K}, {Q,N}, {N, Gauss-Markov}, exact from their definitions
(axes.py): 100 Hz for 20 min and 50 Hz for 1 h. The samples of a log are the same in every row of the table; what is lost
is single samples by chance (0.5 to 40 %), bursts of 2 to 5 (2 and 10 %), every 50th, as cells that are NaN (each axis
its own) or rows that are missing (all axes at once), and all but every 2nd or 5th cell, which is a slower sensor. A row gives
the mean of N over the truth with its standard error, the share of 95 % intervals (and of limits, apart) of the
terms there that hold them, false terms (detected, not there) of all that are not there, the terms there that are found,
and findings that are false (`step`, `motion`, `warm_up`, `non_stationary`, `filtered`, `line`, `units`).
Stamps are exact but where every 50th row is missing: there they scatter by 0.1 ms, since stamps on a grid of 10 ms alone
are also those of a sensor of 98 Hz, and are taken as such with a sentence.
Log k has SeedSequence([seed, rate, k]) and its losses SeedSequence([seed, rate, k, row]); seed 1 unless given.
"""
import argparse
import collections
import json
import pathlib
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor

import numpy as np

import axes

COLUMNS = "time=0:s, gyro=1,2,3:rad/s, accel=4,5,6:m/s^2"
FALSE = {"step", "motion", "warm_up", "non_stationary", "filtered", "line", "units", "stuck", "saturation"}
LENGTHS = {100: 1200, 50: 3600}
TERMS = {"Q": "quantization", "N": "angle_random_walk", "B": "bias_instability", "K": "rate_random_walk"}


def single(share):
    return lambda rng, n: rng.random(n) < share


def bursts(share):
    def lost(rng, n):
        out = np.zeros(n, bool)
        for k in np.flatnonzero(rng.random(n) < share / 3.5):
            out[k:k + rng.integers(2, 6)] = True
        return out
    return lost


def every(step, phase=None):
    def lost(rng, n):
        out = np.zeros(n, bool)
        out[(rng.integers(step) if phase is None else phase)::step] = True
        return out
    return lost


def thin(step):
    return lambda rng, n: ~every(step)(rng, n)


ROWS = {"whole": (None, None)}
for p in (0.5, 2, 5, 10, 20, 40):
    for form in ("cells", "rows"):
        ROWS[f"single {p} % {form}"] = (single(p / 100), form)
for p in (2, 10):
    for form in ("cells", "rows"):
        ROWS[f"bursts {p} % {form}"] = (bursts(p / 100), form)
for form in ("cells", "rows"):
    ROWS[f"every 50th {form}"] = (every(50), form)
ROWS["1 of 2 cells"] = (thin(2), "cells")
ROWS["1 of 5 cells"] = (thin(5), "cells")


def mixtures(rate):
    n, dt, span = 1e-4, 1 / rate, LENGTHS[rate]
    return [{"N": n}, {"N": n, "B": 15 * n / np.sqrt(span)}, {"N": n, "K": 300 * n / span},
            {"N": n, "Q": n * np.sqrt(dt)}, {"N": n, "GM": [(2 * n / np.sqrt(5.0), 5.0)]},
            {"N": n, "B": 8 * n}]


def draw(seed, rate, k):
    rng = np.random.default_rng(np.random.SeedSequence([seed, rate, k]))
    n = rate * LENGTHS[rate]
    y = np.stack([axes.draw(rng, n, 1 / rate, mix) for mix in mixtures(rate)])
    return y + np.array([1e-3, -2e-3, 3e-3, 0.05, -0.1, 9.8])[:, None]


def ask(program, time, y):
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder, "log.npy")
        np.save(path, np.column_stack([time, y.T]))
        run = subprocess.run([program, "characterize", path, "--format", "json", "--threads", "1", "--columns", COLUMNS],
                             capture_output=True, text=True)
    if run.returncode:
        raise SystemExit(f"{run.args}: {run.stderr}")
    return json.loads(run.stdout)


def tell(program, seed, rate, k, name):
    lost, form = ROWS[name]
    y = draw(seed, rate, k)
    n = y.shape[1]
    time = np.arange(n) / rate
    rng = np.random.default_rng(np.random.SeedSequence([seed, rate, k, list(ROWS).index(name)]))
    if form == "cells":
        for axis in y:
            axis[lost(rng, n)] = np.nan
    elif form == "rows":
        keep = ~lost(rng, n)
        if name.startswith("every"):
            time = np.round(time + rng.normal(0, 1e-4, n), 6)
        time, y = time[keep], y[:, keep]
    if name.startswith("1 of"):
        # A slower sensor's samples are means over its own interval.
        step = int(name.split()[2])
        for axis, clean in zip(y, draw(seed, rate, k)):
            first = int(np.flatnonzero(np.isfinite(axis))[0])
            means = clean[:n // step * step].reshape(-1, step).mean(1)
            axis[:] = np.nan
            axis[first::step] = means
    return ask(program, time, y)


def judge(out, rate):
    """Ratios of N, and counts of (held, asked) by what."""
    ratios, counts, notes = [], collections.Counter(), collections.Counter()
    for axis, mix in zip(out["axes"], mixtures(rate)):
        terms = axis["terms"]
        for key, word in TERMS.items():
            term = terms.get(word) or terms[word.replace("angle", "velocity").replace("rate_random", "acceleration_random")]
            found = term["status"] == "detected"
            truth = mix.get(key)
            if truth is None:
                counts["absent"] += 1
                if found:
                    counts["false"] += 1
                    notes[f"{key} in {'+'.join(mix)}"] += 1
            elif found:
                counts["found"] += 1
                counts["asked"] += 1
                counts["held"] += term["lower"] <= truth <= term["upper"]
                counts["found " + key] += 1
                counts["held " + key] += term["lower"] <= truth <= term["upper"]
                if key == "N":
                    ratios.append(term["value"] / truth)
            elif term["upper"] is not None:
                counts["limits"] += 1
                counts["limits held"] += truth <= term["upper"]
            counts["there"] += truth is not None
        gm = [g for g in terms["gauss_markov"] if g["sigma"]["status"] == "detected"]
        truth = mix.get("GM", [])
        counts["absent"] += not truth
        counts["there"] += len(truth)
        if gm and not truth:
            counts["false"] += 1
            notes["GM in " + "+".join(mix)] += 1
        for sigma, tc in truth:
            if gm:
                counts["found"] += 1
                best = min(gm, key=lambda g: abs(np.log(g["correlation_time"]["value"] / tc)))
                for got, want in ((best["sigma"], sigma), (best["correlation_time"], tc)):
                    counts["asked"] += 1
                    counts["held"] += got["lower"] <= want <= got["upper"]
    for issue in out["log"]["issues"]:
        if issue["kind"] in FALSE:
            counts["findings"] += 1
            notes[issue["kind"] + " " + str(issue["channel"])] += 1
    return ratios, counts, notes


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--logs", type=int, default=8)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", help="rows whose name begins with one of these")
    parser.add_argument("--rates", default="100,50")
    parser.add_argument("--threads", type=int, default=2)
    options = parser.parse_args()
    program = pathlib.Path(options.program).resolve()
    names = [n for n in ROWS if not options.only or n.startswith(tuple(options.only.split(",")))]
    print("| lost | rate | N over truth | intervals that hold | of N | limits that hold | found | false terms | false findings |")
    print("|---|---|---|---|---|---|---|---|---|")
    for name in names:
        for rate in map(int, options.rates.split(",")):
            with ThreadPoolExecutor(options.threads) as pool:
                outs = list(pool.map(lambda k: judge(tell(program, options.seed, rate, k, name), rate), range(options.logs)))
            ratios = np.concatenate([o[0] for o in outs])
            counts, notes = collections.Counter(), collections.Counter()
            for _, c, m in outs:
                counts.update(c)
                notes.update(m)
            error = ratios.std(ddof=1) / np.sqrt(len(ratios))
            share = lambda a, b: f"{counts[a]}/{counts[b]} ({100 * counts[a] / max(counts[b], 1):.1f} %)"
            print(f"| {name} | {rate} Hz | {ratios.mean():.4f} ± {error:.4f} | {share('held', 'asked')} | "
                  f"{share('held N', 'found N')} | {counts['limits held']}/{counts['limits']} | {counts['found']}/{counts['there']} | "
                  f"{counts['false']}/{counts['absent']} | {counts['findings']} |", flush=True)
            if notes:
                print("  " + ", ".join(f"{k}: {v}" for k, v in notes.most_common(6)), flush=True)


if __name__ == "__main__":
    main()
