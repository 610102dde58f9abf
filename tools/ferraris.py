"""The published result of the Ferraris recording (imucal) against `sagnac calibrate stations LOG --schedule`.

Writes log and schedule from `ferraris-nilspod/annotated_parts.csv` at the nominal scales 1/208 m/s² and 1/16.4 °/s,
runs the program and compares with the authors' K, R, b and K_ga (`expected_calibration.json`):
I + M_a = K_a R_a / 208, I + M_g = −K_g R_g / 16.4 (turns of −360° in their sign), G_g = K_ga.

    python3 tools/ferraris.py target/release/sagnac ../shared/data/ferraris-nilspod
"""

import csv
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

RATE = 204.8
FACES = {"x_p": (0, 1), "x_a": (0, -1), "y_p": (1, 1), "y_a": (1, -1), "z_p": (2, 1), "z_a": (2, -1)}


def main():
    program, folder = sys.argv[1], Path(sys.argv[2])
    out = Path(tempfile.mkdtemp())
    rows, spans = [], {}
    with open(folder / "annotated_parts.csv") as file:
        for row in csv.DictReader(file):
            rows.append(row)
            i = len(rows)
            first, _ = spans.get(row["part"], (i, i))
            spans[row["part"]] = (first, i)
    with open(out / "log.csv", "w") as file:
        file.write("time [s],accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2],gyro_x [deg/s],gyro_y [deg/s],gyro_z [deg/s]\n")
        for i, row in enumerate(rows):
            cells = [(i + 1) / RATE] + [float(row[f"acc_{a}"]) / 208 for a in "xyz"]
            cells += [float(row[f"gyr_{a}"]) / 16.4 for a in "xyz"]
            file.write(",".join(repr(c) for c in cells) + "\n")
    with open(out / "schedule.csv", "w") as file:
        file.write("station,start [s],end [s],up,angle_x [deg],angle_y [deg],angle_z [deg]\n")
        for part, (first, last) in spans.items():
            start, end = (first - 1) / RATE, last / RATE
            if part in FACES:
                k, s = FACES[part]
                file.write(f"{part},{start!r},{end!r},{'+' if s > 0 else '-'}{'xyz'[k]},,,\n")
            else:
                angle = [360 if a == part[0] else 0 for a in "xyz"]
                file.write(f"{part},{start!r},{end!r},,{angle[0]},{angle[1]},{angle[2]}\n")
    command = [program, "calibrate", "stations", str(out / "log.csv"), "--schedule", str(out / "schedule.csv"),
               "--gravity", "9.81m/s^2", "--format", "json"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        sys.exit(done.stderr)
    found = json.loads(done.stdout)
    value = {p["name"]: p["value"] for p in found["parameters"]}
    want = json.loads((folder / "expected_calibration.json").read_text())
    get = lambda name: want[name] if name in want else want["data"][name]
    ka, ra, ba, kg, rg, bg, kga = (get(n) for n in ("K_a", "R_a", "b_a", "K_g", "R_g", "b_g", "K_ga"))
    product = lambda a, b: [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]

    def entry(sensor, i, j):
        name = f"{sensor}.scale_factor.{'xyz'[i]}" if i == j else f"{sensor}.misalignment.{'xyz'[i]}{'xyz'[j]}"
        return value.get(name, math.nan) + (i == j)

    pairs = [(i, j) for i in range(3) for j in range(3)]
    largest = lambda pick: max(abs(pick(i, j)) for i, j in pairs)
    a, g = product(ka, ra), product(kg, rg)
    print("I + M_a, largest difference:", largest(lambda i, j: entry("accel", i, j) - a[i][j] / 208))
    print("b_a [m/s²]:", max(abs(value[f"accel.bias.{'xyz'[i]}"] - ba[i] / 208) for i in range(3)))
    print("I + M_g, largest difference:", largest(lambda i, j: entry("gyro", i, j) + g[i][j] / 16.4))
    print("b_g [rad/s]:", max(abs(value[f"gyro.bias.{'xyz'[i]}"] - math.radians(bg[i] / 16.4)) for i in range(3)))
    print("G_g [(rad/s)/(m/s²)]:", largest(lambda i, j: value.get(f"gyro.g_sensitivity.{'xyz'[i]}{'xyz'[j]}", math.nan) - math.radians(kga[i][j] / 16.4)))
    print("|f| - g after [m/s²]:", found["after"]["residual_rms"])
    print("not determined:", ", ".join(w["name"] for w in found["why_unobservable"] if "temperature" not in w["name"] and "accel.mis" in w["name"]))


if __name__ == "__main__":
    main()
