"""What `sagnac plan` promises against the scatter of the joint estimate on axes that were never its own.

usage: plan_promise.py SAGNAC FIT_AXES [--axes N] [--seed S]

For every mixture a model file of its terms goes through `sagnac plan`; axes of the same terms, rate and length come from
`axes.py`, their estimates from the built example `fit_axes`. Printed: the promised relative standard deviation, the
standard deviation of the estimates over the truth, their ratio and its 95 % interval (1/sqrt(2 n)), and whether the term
stands clear (6 or more): there the promise should hold within 10 %. Terms are compared over the axes that detect them.
Asked for the promised precision, `sagnac plan --precision` must give the length back, to 1 %.
"""
import argparse
import json
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from axes import clearness, draw
from fidelity import pick, truth_rows

# Declared before the first run, on 1 December 2026.
SEED = 20261301
H = 180_000, 0.02
MIXTURES = {
    "N": (H, {"N": 1}),
    "NB": (H, {"N": 1, "B": 0.4}),
    "NK": (H, {"N": 1, "K": 0.05}),
    "QN": (H, {"Q": 0.05, "N": 1}),
    "NBK": (H, {"N": 1, "B": 0.5, "K": 0.15}),
    "NGM": (H, {"N": 1, "GM": [(0.8, 5)]}),
    "NBK_100Hz_2h": ((720_000, 0.01), {"N": 1, "B": 0.4, "K": 0.1}),
    "QN_25Hz_10min": ((15_000, 0.04), {"Q": 0.08, "N": 1}),
}
# The generator's numbers are of order one; as angular rates they are a gyro's at a ten-thousandth.
SCALE = 1e-4
KEYS = {
    "Q": ("quantization", "rad"),
    "N": ("angle_random_walk", "rad/sqrt(s)"),
    "K": ("rate_random_walk", "rad/s/sqrt(s)"),
}
JSON = {"Q": "quantization", "N": "angle_random_walk", "B": "bias_instability", "K": "rate_random_walk"}


def model(mix, dt):
    lines = ['name = "plan"', f'sample_rate = "{1 / dt!r} Hz"']
    if "B" in mix:
        lines += ["[gyro.bias.instability]", f'coefficient = "{mix["B"] * SCALE!r} rad/s"']
    lines.append("[gyro.noise]")
    lines += [f'{key} = "{mix[term] * SCALE!r} {unit}"' for term, (key, unit) in KEYS.items() if term in mix]
    if "GM" in mix:
        entries = [f'{{ sigma = "{s * SCALE!r} rad/s", correlation_time = "{tc!r} s" }}' for s, tc in mix["GM"]]
        lines.append(f"gauss_markov = [{', '.join(entries)}]")
    return "\n".join(lines) + "\n"


def plan(program, mix, dt, *wanted):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "plan.toml"
        path.write_text(model(mix, dt))
        command = [program, "plan", str(path), *wanted, "--format", "json"]
        return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def promised(program, mix, n, dt):
    terms = plan(program, mix, dt, "--duration", f"{n * dt!r} s")["axes"][0]["terms"]
    out = {term: terms[JSON[term]]["relative_sigma"] for term in "QNBK" if term in mix}
    for i, entry in enumerate(terms.get("gauss_markov", [])):
        out[f"sigma{i + 1}"] = entry["sigma"]["relative_sigma"]
        out[f"Tc{i + 1}"] = entry["correlation_time"]["relative_sigma"]
    return out


def length_back(program, mix, dt, term, precision):
    """The length [s] that a precision asks for."""
    name = {"s": "gauss_markov", "T": "correlation_time"}.get(term[0]) or JSON[term]
    return plan(program, mix, dt, "--precision", f"{name}={precision!r}")["duration_s"]


def estimates(program, mix, n, dt, axes, rng):
    process = subprocess.Popen([program, repr(dt), str(n)], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    results = []
    for _ in range(axes):
        process.stdin.write(draw(rng, n, dt, mix).astype("<f8").tobytes())
        process.stdin.flush()
        results.append(json.loads(process.stdout.readline()))
    process.stdin.close()
    process.wait()
    return results


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("sagnac")
    parser.add_argument("fit_axes")
    parser.add_argument("--axes", type=int, default=400)
    parser.add_argument("--seed", type=int, default=SEED)
    arguments = parser.parse_args()
    print("mixture         term     clear  found%  promised%  scatter%  ratio  [95 %]")
    judged = outside = astray = 0
    for number, (name, ((n, dt), mix)) in enumerate(MIXTURES.items()):
        promise = promised(arguments.sagnac, mix, n, dt)
        results = estimates(arguments.fit_axes, mix, n, dt, arguments.axes, np.random.default_rng([arguments.seed, number]))
        clear = clearness(dict(mix, GM=mix.get("GM", [])), n, dt)
        for term, value in truth_rows(mix):
            found = [e for e in (pick(r, term, len(mix.get("GM", []))) for r in results) if e["status"] == "detected"]
            scatter = np.std([e["value"] for e in found]) / value
            ratio, half = scatter / promise[term], 1.96 / np.sqrt(2 * len(found))
            stands = clear[f"GM{term[-1]}" if term[0] in "sT" else term]
            # The promise is broken where even the interval's near end is further than 10 % away.
            off = stands >= 6 and (ratio * (1 - half) > 1.1 or ratio * (1 + half) < 0.9)
            judged += stands >= 6
            outside += off
            if len(mix.get("GM", [])) < 2:
                astray += abs(length_back(arguments.sagnac, mix, dt, term, promise[term]) / (n * dt) - 1) > 0.01
            print(
                f"{name:15} {term:8} {stands:5.1f} {100 * len(found) / len(results):7.1f} {100 * promise[term]:10.3f}"
                f" {100 * scatter:9.3f} {ratio:6.3f}  [{ratio * (1 - half):.3f} {ratio * (1 + half):.3f}]{'  *' if off else ''}",
                flush=True,
            )
    print(f"{judged} clear terms, {outside} further than 10 % from the promise (*)")
    print(f"{astray} lengths that the promised precision does not give back to 1 %")


if __name__ == "__main__":
    main()
