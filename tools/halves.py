"""Two halves of long recordings against each other: z = (a - b)/sqrt(s_a^2 + s_b^2) of ln N, ln B, ln K. Markdown.

usage: halves.py FIT_AXES DATA_FOLDER   (FIT_AXES is the built example `fit_axes`)
Under a stationary process z has mean 0 and standard deviation 1. Where either half says that its fit is conditional (p < 0.001,
changing scatter) the row carries a star: there the process of the two halves differs or no mixture explains it.
"""
import io
import json
import subprocess
import sys
import zipfile
from pathlib import Path
import numpy as np


def recordings(folder):
    for unit in (2, 3):
        d = np.genfromtxt(folder / f"adis16405-static/adis_16405_imu{unit}_counts.csv.gz", delimiter=",", skip_header=1)
        yield f"ADIS16405 imu{unit}", 0.01, ["gx", "gy", "gz", "ax", "ay", "az"], d[:, -6:]
    d = np.genfromtxt(folder / "samsung-galaxy-s5-static/samsung_galaxy_s5_acc_gyro.csv.gz", delimiter=",", skip_header=1)
    yield "Samsung Galaxy S5", 0.1, ["ax", "ay", "az", "gx", "gy", "gz"], d[:, -6:]
    with zipfile.ZipFile(folder / "astropi-sensehat-static/astro_pi_data_20150824_085954.zip") as z:
        text = z.read(z.namelist()[0]).decode()
    head = text.splitlines()[0].split(",")
    names = [c for c in head if c.strip().lower() in ("accel_x", "accel_y", "accel_z", "gyro_x", "gyro_y", "gyro_z", "ax", "ay", "az", "gx", "gy", "gz")]
    if names:
        # Disturbed before row 4101.
        d = np.genfromtxt(io.StringIO(text), delimiter=",", skip_header=1, usecols=[head.index(c) for c in names])[4100:]
        yield "Astro Pi Sense HAT", 10.0, names, d


def fit(program, dt, y):
    r = subprocess.run([program, repr(dt), str(len(y))], input=np.ascontiguousarray(y, "<f8").tobytes(), capture_output=True, check=True)
    return json.loads(r.stdout)


def main(program, folder):
    print("| recording | channel | N, difference | z of N | z of B | z of K | |\n|---|---|---|---|---|---|---|")
    sound, all_z = [], []
    for name, dt, channels, data in recordings(Path(folder)):
        half = len(data) // 2
        for i, channel in enumerate(channels):
            y = data[:, i][np.isfinite(data[:, i])]
            a, b = fit(program, dt, y[: len(y) // 2]), fit(program, dt, y[len(y) // 2 : 2 * (len(y) // 2)])
            star = any(f["kind"] in ("misfit", "non_stationary", "step", "warm_up") for r in (a, b) for f in r["findings"])
            cells = [f"{100 * (a['N']['value'] / b['N']['value'] - 1):+.1f} %" if a['N']['value'] and b['N']['value'] else '-']
            for term in "NBK":
                e, f = a[term], b[term]
                if e["status"] != "detected" or f["status"] != "detected":
                    limits = [x["upper"] for x in (e, f) if x["status"] == "upper_limit"]
                    seen = [x for x in (e, f) if x["status"] == "detected"]
                    if seen and limits:
                        cells.append("below its limit" if seen[0]["lower"] <= limits[0] else "above the other's limit")
                    else:
                        cells.append("-")
                    continue
                z = np.log(e["value"] / f["value"]) / np.hypot(e["sigma"] / e["value"], f["sigma"] / f["value"])
                cells.append(f"{z:+.1f}")
                all_z.append(z)
                if not star:
                    sound.append(z)
            print(f"| {name} | {channel} | {' | '.join(cells)} | {'*' if star else ''} |", flush=True)
    for what, z in (("without a star", sound), ("all", all_z)):
        z = np.array(z)
        if len(z):
            print(f"\n{len(z)} z-scores, {what}: mean {z.mean():+.2f}, standard deviation {z.std(ddof=1) if len(z) > 1 else 0:.2f}, |z| > 1.96 in {np.sum(abs(z) > 1.96)}")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
