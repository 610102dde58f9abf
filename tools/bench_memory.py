"""Peak resident size of every command that reads a log, at 1e6 and 1e8 samples (three axes together), from a file and from a pipe.

Usage: bench_memory.py PATH_TO_SAGNAC [--only COMMAND] [--long N] [--folder F]
The logs are drawn here (numpy, seed 3): white noise as `.npy` (f8) and as CSV. Commands that the contract wants constant
(`allan --estimate strided`, `convert`, `correct`) must differ by at most 20 MB between the two lengths; `info` holds a section,
the others the log. `characterize` must stay below three times the log, 24 bytes a value.
"""
import argparse
import os
import pathlib
import subprocess
import sys

CONSTANT = {"allan strided", "convert", "correct"}
# Peak MB at any length, or bytes a value.
MOST_MB = {"info": 150}
MOST_BYTES = {"characterize": 24}
MODEL = 'schema = 1\nname = "one"\n[gyro.bias]\nfixed = "1 deg/h"\n'


def write(folder, samples):
    import numpy as np
    rng = np.random.default_rng(3)
    npy, text = folder / f"memory-{samples}.npy", folder / f"memory-{samples}.csv"
    if not npy.exists():
        y = np.lib.format.open_memmap(npy, mode="w+", dtype="f8", shape=(samples, 3))
        for k in range(0, samples, 1 << 20):
            n = min(1 << 20, samples - k)
            y[k : k + n] = np.round(1e-4 * rng.standard_normal((n, 3)), 9)
        del y
    if not text.exists():
        # The same million rows again and again: memory does not depend on what they say.
        y = np.load(npy, mmap_mode="r")[: 1 << 20]
        lines = [b"%.9f,%.9f,%.9f\n" % tuple(row) for row in y.tolist()]
        block = b"".join(lines)
        with open(text, "wb") as f:
            f.write(b"gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s]\n")
            for _ in range(samples // len(lines)):
                f.write(block)
            f.write(b"".join(lines[: samples % len(lines)]))
    return npy, text


def run(command, source):
    """Peak MB and processor seconds; the source comes through a pipe where it is a pair (path, pipe)."""
    path, piped = source
    feeder = None
    if piped:
        feeder = subprocess.Popen(["cat", path], stdout=subprocess.PIPE)
        command = [c if c != str(path) else "/dev/stdin" for c in command]
    child = subprocess.Popen(command, stdin=feeder.stdout if feeder else subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                             stderr=subprocess.PIPE)
    if feeder:
        feeder.stdout.close()
    error = child.stderr.read()
    _, status, used = os.wait4(child.pid, 0)
    if feeder:
        feeder.wait()
    if status:
        return None, error.decode().splitlines()[0]
    return used.ru_maxrss / 1024, used.ru_utime + used.ru_stime


def main():
    p = argparse.ArgumentParser()
    p.add_argument("program")
    p.add_argument("--only")
    p.add_argument("--long", type=int, default=100_000_000)
    p.add_argument("--folder", default="/tmp")
    p.add_argument("--write", action="store_true", help="draw the logs and end")
    o = p.parse_args()
    folder = pathlib.Path(o.folder)
    model = folder / "memory-model.toml"
    model.write_text(MODEL)
    rows = [n // 3 for n in (1_000_000, o.long)]
    if o.write:
        for n in rows:
            write(folder, n)
        return 0
    # A child counts what its parent held before it started: the logs are drawn elsewhere.
    subprocess.run([sys.executable, __file__, o.program, "--write", "--folder", o.folder, "--long", str(o.long)], check=True)
    logs = [(folder / f"memory-{n}.npy", folder / f"memory-{n}.csv") for n in rows]
    failed = False
    print(f"{'command':14s} {'from':10s} {'1e6: MB':>9s} {'s':>6s} {f'{o.long:.0e}: MB':>12s} {'s':>7s}")
    for name, words in (("allan strided", ["allan", "LOG", "--estimate", "strided"]),
                        ("convert", ["convert", "LOG", "-o", str(folder / "memory-out.npy"), "--force"]),
                        ("correct", ["correct", str(model), "LOG", "-o", str(folder / "memory-out.npy"), "--force"]),
                        ("allan spectrum", ["allan", "LOG", "--spectrum"]),
                        ("allan exact", ["allan", "LOG", "--estimate", "exact"]),
                        ("info", ["info", "LOG"]),
                        ("characterize", ["characterize", "LOG"])):
        if o.only and o.only != name:
            continue
        for kind in (0, 1):
            for piped in (False, True):
                results = []
                for log in logs:
                    options = ["--columns", "gyro=0,1,2:rad/s"] if kind == 0 else []
                    command = [o.program] + [str(log[kind]) if w == "LOG" else w for w in words] + options
                    results.append(run(command + ["--rate", "100Hz"], (log[kind], piped)))
                label = ("npy", "csv")[kind] + (" pipe" if piped else " file")
                cells = [f"{'—' if r[0] is None else f'{r[0]:.0f}':>9s} {r[1]:>6.1f}" if r[0] is not None else f"   {r[1]}"
                         for r in results]
                bad = name in CONSTANT and all(r[0] is not None for r in results) and results[1][0] - results[0][0] > 20
                peak = results[1][0] or 0.0
                much = peak > MOST_MB.get(name, peak) or peak * 2**20 > MOST_BYTES.get(name, 1e9) * o.long
                failed |= bad or much
                print(f"{name:14s} {label:10s} {cells[0]} {cells[1]} {'GROWS' if bad else 'TOO MUCH' if much else ''}",
                      flush=True)
    (folder / "memory-out.npy").unlink(missing_ok=True)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
