"""Bias, coverage, efficiency and selection of the joint estimate against known truth.

usage: fidelity.py PROGRAM [--axes N] [--seed S] [--only NAME] [--set basic|wide|weak|corners|warm_up|quantized|hidden|lines] [--json F] [--minutes M]
PROGRAM is the built example `fit_axes`. Every mixture draws from its own declared stream default_rng([seed, number]).
"""
import argparse
import json
import subprocess
import sys
import time
import numpy as np
from axes import bounds, clearness, draw, temperature

# Declared before the first run with them, on 25 November 2026: the seeds of FIDELITY.md's first two tables.
DECLARED_SEEDS = (20261201, 20261202)
# Declared before the first run with it, on 25 November 2026: the seed of the table of thousands of axes.
LONG_SEED = 20261210
# Declared before the first run with it, on 1 December 2026: the seed of short processes, weak Q, lines beside K, temperatures.
SHORT_SEED = 20261401
H = 180_000, 0.02  # 1 h at 50 Hz
SETS = {
    "basic": {
        "N": (H, {"N": 1}),
        "NB": (H, {"N": 1, "B": 0.3}),
        "NBK": (H, {"N": 1, "B": 0.3, "K": 0.06}),
        "QN": (H, {"Q": 0.05, "N": 1}),
        "NGM": (H, {"N": 1, "GM": [(0.8, 5)]}),
    },
    "wide": {
        "NK": (H, {"N": 1, "K": 0.03}),
        "QNBK": (H, {"Q": 0.05, "N": 1, "B": 0.3, "K": 0.08}),
        "NR": (H, {"N": 1, "R": 5e-4}),
        "NBGM": (H, {"N": 1, "B": 0.3, "GM": [(1, 2)]}),
        "N2GM": (H, {"N": 1, "GM": [(2, 0.5), (0.8, 30)]}),
        "Nline": (H, {"N": 1, "B": 0.3, "line": [(0.25, 3.3)]}),
        "NBKR": (H, {"N": 1, "B": 0.3, "K": 0.06, "R": 2e-3}),
    },
    "weak": {
        "NB_weak": (H, {"N": 1, "B": 0.06}),
        "NK_weak": (H, {"N": 1, "K": 0.004}),
        "NBK_weak": (H, {"N": 1, "B": 0.15, "K": 0.01}),
        "NGM_weak": (H, {"N": 1, "GM": [(0.25, 20)]}),
        "NB_15": (H, {"N": 1, "B": 0.15}),
        "NK_12": (H, {"N": 1, "K": 0.012}),
    },
    "corners": {
        "NBK_25Hz_10min": ((15_000, 0.04), {"N": 1, "B": 0.8, "K": 0.3}),
        "QN_25Hz_10min": ((15_000, 0.04), {"Q": 0.08, "N": 1}),
        "NB_400Hz_1h": ((1_440_000, 0.0025), {"N": 1, "B": 0.3}),
        "QNBK_400Hz_1h": ((1_440_000, 0.0025), {"Q": 0.005, "N": 1, "B": 0.3, "K": 0.08}),
        "NBK_25Hz_12h": ((1_080_000, 0.04), {"N": 1, "B": 0.15, "K": 0.012}),
        "NGM_100Hz_4h": ((1_440_000, 0.01), {"N": 1, "GM": [(0.3, 60)]}),
        "NBK_400Hz_10min": ((240_000, 0.0025), {"N": 1, "B": 0.8, "K": 0.3}),
        "NBK_400Hz_12h": ((17_280_000, 0.0025), {"N": 1, "B": 0.15, "K": 0.012}),
    },
    # 4 h with a warm-up of five times the floor (0.664 B), settled after about 30 min; with and without temperature.
    "warm_up": {
        "NBK_warm": ((720_000, 0.02), {"N": 1, "B": 0.3, "K": 0.02, "warm": (1.0, 600.0), "temperature": True}),
        "NBK_warm_blind": ((720_000, 0.02), {"N": 1, "B": 0.3, "K": 0.02, "warm": (1.0, 600.0)}),
    },
    # The rounding of a counter, alone and above all else.
    "quantized": {
        "Q": (H, {"Q": 0.05}),
        "QN_small": (H, {"Q": 0.05, "N": 0.02}),
        "QB": (H, {"Q": 0.05, "B": 2e-3}),
        "QK": (H, {"Q": 0.05, "K": 5e-4}),
        "Q_25Hz_10min": ((15_000, 0.04), {"Q": 0.05}),
        "QN_small_25Hz_10min": ((15_000, 0.04), {"Q": 0.05, "N": 0.02}),
        "QB_25Hz_10min": ((15_000, 0.04), {"Q": 0.05, "B": 4e-3}),
        "QK_25Hz_10min": ((15_000, 0.04), {"Q": 0.05, "K": 2e-3}),
    },
    # A slow strong process hides flicker.
    "hidden": {
        "NBGM_hidden": ((72_000, 0.1), {"N": 1, "B": 0.5, "GM": [(11.667, 100)]}),
        "NBGM_half": ((72_000, 0.1), {"N": 1, "B": 0.5, "GM": [(2, 100)]}),
        "NGM_alone": ((72_000, 0.1), {"N": 1, "GM": [(11.667, 100)]}),
    },
    # Processes at the short end of what is reported, ten samples, and below it.
    "short_process": {
        "NGM_10dt": ((108_000, 0.1), {"N": 1, "GM": [(0.8, 1.0)]}),
        "NGM_12dt": ((108_000, 0.1), {"N": 1, "GM": [(0.8, 1.2)]}),
        "NGM_15dt": ((108_000, 0.1), {"N": 1, "GM": [(0.8, 1.5)]}),
        "NGM_11dt_1Hz_24h": ((86_400, 1.0), {"N": 1, "GM": [(0.5, 11.0)]}),
        "NBGM_10dt_1kHz_10min": ((600_000, 0.001), {"N": 1, "B": 0.6, "GM": [(12, 0.0105)]}),
        "NGM_5dt": ((108_000, 0.1), {"N": 1, "GM": [(0.8, 0.5)]}),
        "NGM_2dt": ((108_000, 0.1), {"N": 1, "GM": [(0.8, 0.2)]}),
    },
    # Quantization too weak to be named (its threshold is 12) that N still depends on.
    "weak_q": {
        "QN_003": (H, {"Q": 0.003, "N": 1}),
        "QN_006": (H, {"Q": 0.006, "N": 1}),
        "QN_009": (H, {"Q": 0.009, "N": 1}),
        "QN_014": (H, {"Q": 0.014, "N": 1}),
        "QNB_200Hz_30min": ((360_000, 0.005), {"Q": 0.005, "N": 1, "B": 0.3}),
    },
    # A line in time, missed and found, beside a random walk.
    "ramp": {
        "NKR_3sd": (H, {"N": 1, "K": 0.05, "R": 0.0025}),
        "NKR_10sd": (H, {"N": 1, "K": 0.05, "R": 0.0083}),
        "NKR": (H, {"N": 1, "K": 0.05, "R": 0.003}),
        "NBKR_weak": (H, {"N": 1, "B": 0.3, "K": 0.05, "R": 0.002}),
        "NK_05": (H, {"N": 1, "K": 0.05}),
    },
    # The temperature's polynomial (profile, per K, per K^2) beside a random walk; the last two have no coefficient.
    "thermal": {
        "NK_sine": (H, {"N": 1, "K": 0.05, "temperature": ("sine", 0.3, 0)}),
        "NK_sine_2": (H, {"N": 1, "K": 0.05, "temperature": ("sine", 0.3, 0.03)}),
        "NK_heat": (H, {"N": 1, "K": 0.05, "temperature": ("ramp", 0.3, 0)}),
        "NK_walk": (H, {"N": 1, "K": 0.05, "temperature": ("walk", 0.3, 0)}),
        "NK_sine_0": (H, {"N": 1, "K": 0.05, "temperature": ("sine", 0, 0)}),
        "NK_walk_0": (H, {"N": 1, "K": 0.05, "temperature": ("walk", 0, 0)}),
    },
    # Flicker that stands clear beside a walk that is seldom named, and the other way round.
    "unnamed": {
        "NBK_unnamed": ((60_000, 0.04), {"N": 1, "B": 0.444, "K": 0.0556}),
        "NBK_beside": (H, {"N": 1, "B": 0.5, "K": 0.06}),
    },
    # Two lines 1, 1.44, 2, 7.2 and 21.6 times 1/T apart, and harmonics.
    "lines": {
        "line_1": (H, {"N": 1, "line": [(0.3, 3.0), (0.3, 3.0 + 1 / 3600)]}),
        "line_1.4": (H, {"N": 1, "line": [(0.3, 3.0), (0.3, 3.0004)]}),
        "line_2": (H, {"N": 1, "line": [(0.3, 3.0), (0.3, 3.0 + 2 / 3600)]}),
        "line_7": (H, {"N": 1, "line": [(0.3, 3.0), (0.3, 3.002)]}),
        "line_22": (H, {"N": 1, "line": [(0.3, 3.0), (0.3, 3.006)]}),
        "line_harmonics": (H, {"N": 1, "line": [(0.5, 1.7), (0.3, 3.4), (0.2, 5.1)]}),
    },
}


def binomial(k, n):
    """Wilson's 95 % interval in per cent."""
    if n == 0:
        return (0, 100)
    z, p = 1.96, k / n
    d = 1 + z * z / n
    c, h = p + z * z / (2 * n), z * np.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    return (100 * (c - h) / d, 100 * (c + h) / d)


def truth_rows(mix):
    rows = [(t, mix[t]) for t in "QNBKR" if mix.get(t)]
    for i, (s, tc) in enumerate(sorted(mix.get("GM", []), key=lambda g: g[1])):
        rows += [(f"sigma{i+1}", s), (f"Tc{i+1}", tc)]
    for i, (a, f) in enumerate(sorted(mix.get("line", []), key=lambda l: l[1])):
        rows += [(f"amplitude{i+1}", a), (f"frequency{i+1}", f)]
    if not mix.get("warm"):
        rows += [(f"temperature.{i}", c) for i, c in enumerate(mix.get("temperature", ())) if i and c]
    return rows


def pick(axis, name, count_gm):
    if name in "QNBKR":
        return axis[name]
    if name.startswith("temperature"):
        return axis.get("temperature", {}).get(name, {"status": "upper_limit", "upper": None})
    i = int(name[-1]) - 1
    if name.startswith(("amplitude", "frequency")):
        # Of too few lines the first stands for the first, the last for the last.
        found = axis["lines"]
        return found[min(i, len(found) - 1)][name[:-1]] if found else {"status": "upper_limit", "upper": None}
    found = [g for g in axis["GM"] if g["sigma"]["status"] == "detected"]
    if len(found) != count_gm:
        # A missing Gauss-Markov term: the limit stands for sigma, nothing for T_c.
        e = axis["GM"][0]["sigma"]
        return e if name.startswith("sigma") and e["status"] == "upper_limit" else {"status": "upper_limit", "upper": None}
    return found[i]["sigma" if name.startswith("sigma") else "Tc"]


class Mixture:
    """One mixture's stream of axes and the program that estimates them; rounds go on where the last one ended."""

    def __init__(self, program, name, number, seed, terms=None):
        self.name = name
        self.size, self.mix = next(s[name] for s in SETS.values() if name in s)
        n, dt = self.size
        self.rng = np.random.default_rng([seed, number])
        command = [program, repr(dt), str(n)] + ([terms] if terms else [])
        if self.mix.get("temperature"):
            command += ["all", "--temperature"]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.results = []

    def round(self, axes):
        n, dt = self.size
        for _ in range(axes):
            y = draw(self.rng, n, dt, self.mix)
            t = temperature(self.rng, n, dt, self.mix) if self.mix.get("temperature") else None
            if t is not None and not self.mix.get("warm"):
                _, first, second = self.mix["temperature"]
                y += first * (t - t.mean()) + second * (t - t.mean()) ** 2
            self.process.stdin.write(y.astype("<f8").tobytes())
            if t is not None:
                self.process.stdin.write(t.astype("<f8").tobytes())
            self.process.stdin.flush()
            self.results.append(json.loads(self.process.stdout.readline()))

    def summary(self):
        return summarize(self.name, self.size, self.mix, self.results)

    def close(self):
        self.process.stdin.close()
        self.process.wait()


_known = {}


def summarize(name, size, mix, results):
    n, dt = size
    total = len(results)
    stochastic = {k: v for k, v in mix.items() if k in "QNBK" or k == "GM"}
    stochastic["GM"] = sorted(mix.get("GM", []), key=lambda g: g[1])
    if name not in _known:
        _known[name] = bounds(stochastic, n, dt), clearness(stochastic, n, dt)
    bound, clear = _known[name]
    out = {"mixture": name, "truth": {k: v for k, v in mix.items()}, "samples": n, "dt": dt, "axes": total, "rows": [], "absent": {}}
    count_gm = len(mix.get("GM", []))
    for term, value in truth_rows(mix):
        es = [pick(r, term, count_gm) for r in results]
        detected = [e for e in es if e["status"] == "detected"]
        inside = sum(e["lower"] <= value <= e["upper"] for e in detected)
        limits = [e for e in es if e["status"] != "detected" and e.get("upper") is not None]
        covered = sum(value <= e["upper"] for e in limits)
        rel = np.array([e["value"] / value - 1 for e in detected]) if detected else np.array([np.nan])
        b = bound.get(term)
        cname = f"GM{term[-1]}" if term[0] in "sT" else term
        row = {
            "term": term,
            "value": value,
            "clear": clear.get(cname),
            "bound": b,
            "detected": len(detected) / total,
            "bias": float(rel.mean()),
            "bias_over_sd": float(rel.mean() / rel.std()) if len(rel) > 1 else None,
            "ratio": float(np.sqrt((rel**2).mean()) / b) if b else None,
            "coverage": 100 * inside / len(detected) if detected else None,
            "coverage_interval": binomial(inside, len(detected)),
            "printed": 100 * (inside + covered) / max(1, len(detected) + len(limits)),
            "printed_interval": binomial(inside + covered, len(detected) + len(limits)),
        }
        out["rows"].append(row)
    for term in "QNBKR":
        if not mix.get(term):
            out["absent"][term] = 100 * sum(r[term]["status"] == "detected" for r in results) / total
    extra = sum(sum(g["sigma"]["status"] == "detected" for g in r["GM"]) > count_gm for r in results)
    out["absent"]["GM"] = 100 * extra / total
    lines = len(mix.get("line", []))
    out["absent"]["line"] = 100 * sum(len(r["lines"]) > lines for r in results) / total
    if lines > 1:
        out["absent"]["too few lines"] = 100 * sum(len(r["lines"]) < lines for r in results) / total
    out["p_below_5"] = 100 * sum((r["p"] if r["p"] is not None else 1) < 0.05 for r in results) / total
    kinds = {}
    for r in results:
        for f in {f["kind"] for f in r["findings"]}:
            kinds[f] = kinds.get(f, 0) + 100 / total
    out["findings"] = kinds
    out["confused"] = 100 * sum(bool(r["confused"]) for r in results) / total
    out["milliseconds"] = 1000 * float(np.mean([r["seconds"] for r in results]))
    return out


def show(o):
    print(f"\n{o['mixture']}  {o['truth']}  {o['samples']} samples at {1/o['dt']:g} Hz, {o['axes']} axes, {o['milliseconds']:.1f} ms an axis")
    print("  term         clear   bound%  found%   bias%  bias/sd  ratio  cover% [binomial]     printed% [binomial]")
    f = lambda v, w, d: " " * (w - 1) + "-" if v is None or v != v else f"{v:{w}.{d}f}"
    for r in o["rows"]:
        c, p = r["coverage_interval"], r["printed_interval"]
        print(
            f"  {r['term']:11}{f(r['clear'],7,1)} {f(100*r['bound'] if r['bound'] else None,8,2)} {100*r['detected']:7.1f} {100*r['bias']:7.2f} {f(r['bias_over_sd'],8,2)} {f(r['ratio'],6,2)}"
            f" {f(r['coverage'],7,1)} [{c[0]:.1f} {c[1]:.1f}] {f(r['printed'],11,1)} [{p[0]:.1f} {p[1]:.1f}]"
        )
    absent = "  ".join(f"{k} {v:.1f}" for k, v in o["absent"].items())
    print(f"  false %: {absent}   p<0.05: {o['p_below_5']:.1f} %   confused {o['confused']:.1f} %   findings {({k: round(v,1) for k,v in o['findings'].items()})}", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--axes", type=int, default=200)
    parser.add_argument("--seed", type=int, default=DECLARED_SEEDS[0])
    parser.add_argument("--only", default="")
    parser.add_argument("--set", default="basic")
    parser.add_argument("--json", default="")
    parser.add_argument("--terms", default=None)
    parser.add_argument("--minutes", type=float, default=float("inf"), help="no new round of axes after so long")
    a = parser.parse_args()
    names = [n for s in SETS.values() for n in s]
    chosen = a.only.split(",") if a.only else [n for s in a.set.split(",") for n in SETS[s]]
    start = time.time()
    mixtures = [Mixture(a.program, name, names.index(name), a.seed, a.terms) for name in chosen]
    # Rounds of 20 axes, so that a run cut short has as many of every mixture; each stream is the same as in one go.
    done = 0
    while done < a.axes and time.time() - start < 60 * a.minutes:
        size = min(20, a.axes - done)
        for m in mixtures:
            m.round(size)
        done += size
        if a.json and (done % 100 == 0 or done == a.axes):
            with open(a.json, "w") as f:
                json.dump([dict(m.summary(), seed=a.seed) for m in mixtures], f, indent=1)
    for m in mixtures:
        m.close()
        show(m.summary())
    sys.exit(0)
