"""What other ways get on the very same axes as fidelity.py: read-off, weighted log-log fit. Prints a Markdown table.

Read-off (allantools oadev): N at tau = 1 s, B at the minimum over 0.664, K at tau = 3 s of the curve: the usual recipe.
Log-log fit: non-negative least squares of the octave Allan variances on Q, N, B, K, weights n/m over the variance squared.
usage: peers.py [--axes N] [--seed S]
"""
import argparse
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


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--axes", type=int, default=60)
    parser.add_argument("--seed", type=int, default=DECLARED_SEEDS[0])
    a = parser.parse_args()
    names = [n for s in SETS.values() for n in s]
    print("| mixture | term | read-off: bias %, RMSE/bound | log-log fit: bias %, RMSE/bound |\n|---|---|---|---|")
    for name in ["N", "NB", "NBK", "QN", "NGM"]:
        (n, dt), mix = SETS["basic"][name]
        rng = np.random.default_rng([a.seed, names.index(name)])
        got = {"read": [], "fit": []}
        for _ in range(a.axes):
            tau, dev = octaves(draw(rng, n, dt, mix), dt)
            got["read"].append(read_off(tau, dev))
            got["fit"].append(log_log(tau, dev, n, dt))
        b = bounds(mix, n, dt)
        for term in "QNBK":
            if not mix.get(term):
                invented = 100 * np.mean([g[term] > 0 for g in got["fit"]])
                print(f"| {name} | {term} (absent) | {'always named' if term in 'BK' else 'not asked'} | above zero in {invented:.0f} % |")
                continue
            cells = []
            for way in ("read", "fit"):
                rel = np.array([g[term] / mix[term] - 1 for g in got[way] if term in g])
                cells.append(f"{100*rel.mean():+.1f}, {np.sqrt((rel**2).mean())/b[term]:.2f}" if len(rel) else "not asked")
            print(f"| {name} | {term} | {cells[0]} | {cells[1]} |")
