"""Reading a CSV log of 1e7 rows x 7 columns: the program's reader and polars, on the same file, in one run.

Usage: bench_csv.py READ_SPEED [--rows N] [--file F]
READ_SPEED is the built example (`cargo build --release -p sagnac-log --example read_speed`). The file is drawn here
(numpy, seed 7): time with two decimals, six values with nine decimals. Each reader runs three times with two threads and
three times with one; wall and processor time are of the best run, memory is the peak resident size.
"""
import argparse
import os
import resource
import subprocess
import sys
import time

HEADER = "time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s],accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2]"
POLARS = "import polars, sys; d = polars.read_csv(sys.argv[1]); print(d.height)"


def write(path, rows):
    import numpy as np
    import polars as pl
    rng = np.random.default_rng(7)
    names = HEADER.split(",")
    with open(path, "wb") as f:
        f.write((HEADER + "\n").encode())
        for start in range(0, rows, 1_000_000):
            n = min(1_000_000, rows - start)
            table = {names[0]: np.round(0.01 * np.arange(start + 1, start + n + 1), 2)}
            for name in names[1:4]:
                table[name] = np.round(0.01 * rng.standard_normal(n), 9)
            for name, mean in zip(names[4:], (0.1, -0.2, 9.8)):
                table[name] = np.round(mean + 0.02 * rng.standard_normal(n), 9)
            pl.DataFrame(table).write_csv(f, include_header=False)


def run(command, environment):
    """Wall seconds, processor seconds, peak MB."""
    start = time.perf_counter()
    child = subprocess.Popen(command, env={**os.environ, **environment}, stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(child.pid, 0)
    if status:
        raise SystemExit(f"{command} failed")
    return time.perf_counter() - start, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def main():
    p = argparse.ArgumentParser()
    p.add_argument("program")
    p.add_argument("--rows", type=int, default=10_000_000)
    p.add_argument("--file", default="/tmp/bench-read.csv")
    p.add_argument("--write", action="store_true", help="draw the file and end")
    o = p.parse_args()
    if o.write:
        return write(o.file, o.rows)
    if not os.path.exists(o.file):
        # A child counts what its parent held before it started: the file is drawn elsewhere.
        subprocess.run([sys.executable, __file__, o.program, "--write", "--rows", str(o.rows), "--file", o.file], check=True)
    size = os.path.getsize(o.file)
    print(f"{o.rows} rows, {size / 2**20:.1f} MiB")
    for threads in ("2", "1"):
        for name, command, environment in (
            ("sagnac", [o.program, o.file, "", threads], {}),
            ("polars", [sys.executable, "-c", POLARS, o.file], {"POLARS_MAX_THREADS": threads}),
        ):
            runs = [run(command, environment) for _ in range(3)]
            wall, cpu, peak = min(r[0] for r in runs), min(r[1] for r in runs), max(r[2] for r in runs)
            print(f"{name}, {threads} threads: {wall:.2f} s, processor {cpu:.2f} s, peak {peak:.0f} MB", flush=True)


if __name__ == "__main__":
    main()
