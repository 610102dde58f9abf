"""What other ways get on the very same axes as fidelity.py. Prints a Markdown table.

read-off           allantools oadev: N at tau = 1 s, B at the minimum over 0.664, K at tau = 3 s: the usual recipe
log-log fit        non-negative least squares of the octave Allan variances on Q, N, B, K, weights n/m over variance squared
allan, allan-tools the crates give deviations alone; the same read-off on their curves (peers/, built apart)
analyzer           allan-variance-analyzer's own variances (0.1 s … 1000 s by 0.1 s) and its own fits: N a line of slope -1/2
                   below 10 s, B the minimum over 0.664, K a line of slope 1/2; its first axes alone, since it is slow
sagnac             the built example fit_axes: what it names, the value of a term that it does not name left out
usage: peers.py [--axes N] [--seed S] [--program FIT_AXES] [--crates PROGRAM] [--analyzer AXES] [--only NAMES]
"""
import argparse
import json
import subprocess
import time
import allantools
import numpy as np
from scipy.optimize import nnls
from axes import bounds, draw
from fidelity import DECLARED_SEEDS, SETS


def octaves(y, dt):
    m = 2 ** np.arange(int(np.log2(len(y) / 8)) + 1)
    tau, dev, _, _ = allantools.oadev(y, 1 / dt, "freq", m * dt)
    return tau, dev


def read_off(tau, dev):
    at = lambda t: float(np.exp(np.interp(np.log(t), np.log(tau), np.log(dev))))
    return {"N": at(1.0), "B": float(dev.min() / 0.6642825), "K": at(3.0)}


def log_log(tau, dev, n, dt):
    v = dev**2
    shapes = np.array([3 / tau**2, 1 / tau, 2 * np.log(2) / np.pi + 0 * tau, tau / 3]).T
    w = np.sqrt(n * dt / tau) / v
    x, _ = nnls(shapes * w[:, None], v * w)
    return dict(zip("QNBK", np.sqrt(x)))


class Program:
    """A program that takes axes from its input and answers a line each."""

    def __init__(self, *command):
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def ask(self, y):
        self.process.stdin.write(y.astype("<f8").tobytes())
        self.process.stdin.flush()
        return self.process.stdout.readline()


class Sagnac(Program):
    def estimate(self, y):
        axis = json.loads(self.ask(y))
        return {t: axis[t]["value"] for t in "QNBK" if axis[t]["status"] == "detected"}


class Crate(Program):
    def estimate(self, y):
        pairs = [p.split(b":") for p in self.ask(y).split()]
        tau, dev = np.array(pairs, dtype=float).T
        return read_off(tau, dev)


def analyzer(axes, dt):
    """Six axes at once, as it is made for; its fits on three of them at a time."""
    from allan_variance_analyzer.analysis import compute_bias_instability, compute_rate_random_walk, compute_white_noise_params
    from allan_variance_analyzer.statistics import compute_allan_variances

    periods = np.arange(0.1, 1000, step=0.1)
    dev = np.sqrt(compute_allan_variances(np.array(axes).T, periods, measure_rate=1 / dt))
    out = []
    for three in (dev[:, :3], dev[:, 3:]):
        n, _ = compute_white_noise_params(periods, three, int(np.argmin(abs(periods - 10))))
        k, _ = compute_rate_random_walk(periods, three)
        b, _ = compute_bias_instability(three)
        out += [{"N": n[i], "B": b[i] / 0.6642825, "K": k[i]} for i in range(3)]
    return out


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--axes", type=int, default=60)
    parser.add_argument("--seed", type=int, default=DECLARED_SEEDS[0])
    parser.add_argument("--only", default="N,NB,NBK,QN,NGM")
    parser.add_argument("--program", default="")
    parser.add_argument("--crates", default="")
    parser.add_argument("--analyzer", default="", help="mixtures in which six axes go to allan-variance-analyzer")
    a = parser.parse_args()
    names = [n for s in SETS.values() for n in s]
    # Mean error in per cent and RMSE over the bound; of an absent term in how many axes it is named.
    headed = None
    for name in a.only.split(","):
        (n, dt), mix = next(s[name] for s in SETS.values() if name in s)
        rng = np.random.default_rng([a.seed, names.index(name)])
        ways = {"read-off": [], "log-log fit": []}
        programs = {"sagnac": Sagnac(a.program, repr(dt), str(n))} if a.program else {}
        if a.crates:
            programs |= {w: Crate(a.crates, w, repr(dt), str(n)) for w in ("allan", "allan-tools")}
        seconds = dict.fromkeys(list(ways) + list(programs), 0.0)
        first = []
        for _ in range(a.axes):
            y = draw(rng, n, dt, mix)
            if len(first) < 6:
                first.append(y)
            start = time.process_time()
            tau, dev = octaves(y, dt)
            shared = time.process_time() - start
            ways["read-off"].append(read_off(tau, dev))
            ways["log-log fit"].append(log_log(tau, dev, n, dt))
            seconds["read-off"] += shared
            seconds["log-log fit"] += shared
            for w, program in programs.items():
                start = time.time()
                ways.setdefault(w, []).append(program.estimate(y))
                seconds[w] += time.time() - start
        if name in a.analyzer.split(","):
            start = time.process_time()
            ways["analyzer (6 axes)"] = analyzer(first, dt)
            seconds["analyzer (6 axes)"] = time.process_time() - start
        if list(ways) != headed:
            headed = list(ways)
            print(f"| mixture | term | {' | '.join(headed)} |\n|{'---|' * (2 + len(headed))}", flush=True)
        b = bounds({k: v for k, v in mix.items() if k in "QNBK" or k == "GM"}, n, dt)
        for term in "QNBK":
            cells = []
            for way, got in ways.items():
                values = np.array([g[term] for g in got if term in g])
                if way == "sagnac" and not mix.get(term):
                    cells.append(f"named in {100 * len(values) / len(got):.0f} %")
                elif not len(values):
                    cells.append("not asked")
                elif not mix.get(term):
                    cells.append(f"named in {100 * np.mean(values > 0):.0f} %")
                else:
                    rel = values / mix[term] - 1
                    cells.append(f"{100 * rel.mean():+.1f} %, {np.sqrt((rel**2).mean()) / b[term]:.2f}")
            print(f"| {name} | {term}{'' if mix.get(term) else ' (absent)'} | {' | '.join(cells)} |", flush=True)
        each = " | ".join(f"{1000 * seconds[w] / len(got):.0f}" for w, got in ways.items())
        print(f"| {name} | ms an axis | {each} |", flush=True)
