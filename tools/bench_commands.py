"""Every goal for a whole process, taken in one run: wall time, processor time and peak memory of each command.

Usage: bench_commands.py SAGNAC [--model EVERY.toml] [--runs 5] [--only WORD] [--folder /dev/shm]

The inputs are made first, by the program (logs) and here (tables); then each command runs --runs times and the run of
least wall time is printed as a row of BENCHMARKS.md, beside its goal. Wall times mean something on a quiet machine only:
the load is printed.
"""
import argparse
import datetime
import multiprocessing
import os
import pathlib
import subprocess
import sys
import tempfile
import time

CATALOGUE = "catalog:ADIS16470"


def stations(path, rows):
    """Any references, gyro and accelerometer outputs of a sensor with small errors, standard errors, temperature."""
    import numpy as np
    rng = np.random.default_rng(4)
    f, w, wdot = rng.normal(0, 20, (rows, 3)), rng.normal(0, 2, (rows, 3)), rng.normal(0, 5, (rows, 3))
    columns = {}
    for j, a in enumerate("xyz"):
        columns[f"accel_{a} [m/s^2]"] = f[:, j] * 1.003 + 0.05 + rng.normal(0, 1e-3, rows)
        columns[f"gyro_{a} [rad/s]"] = w[:, j] * 0.998 + 0.01 + rng.normal(0, 1e-4, rows)
        columns[f"accel_{a}_se [m/s^2]"] = np.full(rows, 1e-3)
        columns[f"gyro_{a}_se [rad/s]"] = np.full(rows, 1e-4)
        columns[f"f_{a} [m/s^2]"], columns[f"w_{a} [rad/s]"], columns[f"wdot_{a} [rad/s^2]"] = f[:, j], w[:, j], wdot[:, j]
    columns["temperature [degC]"] = rng.uniform(-20, 60, rows)
    np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="", fmt="%.9g")


def hand_turned(path, samples):
    """A log turned by hand, its poses as many as the samples need."""
    from multi_position_generator import make, write
    time_, gyro, accel, _ = make(20261201, poses=samples // 550)
    write(path, time_[:samples], gyro[:samples], accel[:samples])


def schedule(path, spans, seconds):
    """Spans of equal length that fill the log, every one with the sensor's z axis down."""
    step = seconds / spans
    rows = [f"{i + 1},{i * step!r},{(i + 1) * step!r},0,0,-9.80665" for i in range(spans)]
    path.write_text("\n".join(["station,start [s],end [s],f_x [m/s^2],f_y [m/s^2],f_z [m/s^2]", *rows]) + "\n")


def inputs(program, at):
    """Draws every input; in a process of its own, for a child's peak memory counts what its parent held."""
    for hours, name in ((4, "six.npy"), (10, "tenhours.npy")):
        command = [program, "simulate", CATALOGUE, "--rest", f"{hours}h", "--rate", "100Hz", "-o", str(at / name)]
        subprocess.run(command, check=True, capture_output=True)
    stations(at / "stations.csv", 10_000)
    hand_turned(at / "hand.npy", 51_000)
    schedule(at / "spans.csv", 60, 36_000.0)


def measure(command, runs):
    """Wall and processor seconds and peak MB of the run with the least wall time; None and the error where it fails."""
    best = None
    for _ in range(runs):
        for output in command[command.index("-o") + 1 :][:1] if "-o" in command else []:
            pathlib.Path(output).unlink(missing_ok=True)
        begin = time.perf_counter()
        child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        error = child.stderr.read().decode()
        _, status, used = os.wait4(child.pid, 0)
        wall = time.perf_counter() - begin
        child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode:
            return None, error
        if best is None or wall < best[0]:
            best = wall, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024
    return best, ""


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("sagnac")
    parser.add_argument("--model", default="crates/sagnac-model/tests/data/example.toml")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--only", default="")
    parser.add_argument("--folder", default=None)
    o = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=o.folder) as folder:
        at = pathlib.Path(folder)
        out, model = str(at / "out"), str(at / "cal.toml")
        maker = multiprocessing.get_context("spawn").Process(target=inputs, args=(o.sagnac, at))
        maker.start()
        maker.join()
        if maker.exitcode:
            sys.exit("the inputs could not be made")
        drive = ["--trajectory", "drive", "--duration", "1h", "--rate", "100Hz", "--method", "monte-carlo", "--runs", "100"]
        rows = [
            ("`sagnac --version`", ["--version"], 0.010),
            ("`characterize six.npy`, 6 × 1.44 M samples", ["characterize", str(at / "six.npy")], 1.5),
            ("`simulate catalog:ADIS16470 --rest 10h --rate 100Hz -o x.npy`", ["simulate", CATALOGUE, "--rest", "10h", "--rate", "100Hz", "-o", out + ".npy"], 0.6),
            ("the same of a model with every term, low-pass and rounding", ["simulate", o.model, "--rest", "10h", "--rate", "100Hz", "-o", out + ".npy"], 0.6),
            ("`drift catalog:ADIS16470 --trajectory flight --duration 1h --rate 100Hz`", ["drift", CATALOGUE, "--trajectory", "flight", "--duration", "1h", "--rate", "100Hz"], 0.5),
            ("`drift … --trajectory drive … --method monte-carlo --runs 100`", ["drift", CATALOGUE, *drive], 0.4),
            ("`grade catalog:ADIS16470`", ["grade", CATALOGUE], 1.0),
            ("`catalog list`", ["catalog", "list"], 1.0),
            ("`budget --cep '1 km' --after 10min`", ["budget", "--cep", "1 km", "--after", "10min"], 1.0),
            ("`plan catalog:ADIS16470 --duration 4h`", ["plan", CATALOGUE, "--duration", "4h"], 0.2),
            ("`calibrate stations`, 10 000 rows, all 90 terms", ["calibrate", "stations", str(at / "stations.csv"), "--terms", "all", "-o", model], 0.1),
            ("`calibrate multi-position`, 51 000 samples with gyro, 92 poses", ["calibrate", "multi-position", str(at / "hand.npy"), "-o", model], 0.1),
            ("`calibrate stations tenhours.npy --schedule`, 60 spans", ["calibrate", "stations", str(at / "tenhours.npy"), "--schedule", str(at / "spans.csv"), "--terms", "bias", "-o", model], None),
        ]
        print(f"{datetime.date.today()}, load {os.getloadavg()[0]:.1f}, least wall time of {o.runs} runs\n")
        print("| command | wall | processor | peak memory | goal |\n|---|---|---|---|---|")
        failed = 0
        for name, command, goal in rows:
            if o.only not in name:
                continue
            best, error = measure([o.sagnac, *command], o.runs)
            if best is None:
                print(f"{name}: {error}", file=sys.stderr)
                failed = 1
                continue
            wall, processor, memory = best
            verdict = "" if goal is None else f"{goal:g} s" + (f": missed, {wall / goal:.1f} times" if wall > goal else "")
            print(f"| {name} | {wall:.3f} s | {processor:.3f} s | {memory:.0f} MB | {verdict} |", flush=True)
    return failed


if __name__ == "__main__":
    sys.exit(main())
