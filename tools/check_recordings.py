"""Every static recording of the data folder, run through the program as the README beside it says.

Usage: check_recordings.py PATH_TO_SAGNAC [--pages FOLDER] [--only NAME]

For each: `allan` at the averaging factors of the README's table must print the README's digits (allantools' `oadev`,
five of them, in the units of the column); `info` the means and scatters of its sanity table; `characterize` must say what is
known of the recording (rounding, smoothing, gaps, jitter); what it says besides is printed by --verbose, not judged.
--pages writes each report. The folder is $SAGNAC_DATA, else ../shared/data beside the workspace; recordings that are not there are
skipped. Formats that the program does not read (a zip, MATLAB 7.3) go in as CSV on standard input.
"""
import argparse
import csv
import io
import json
import math
import os
import pathlib
import re
import subprocess
import sys
import zipfile

DEG = 0.017453292519943295
G = 9.80665
ROOT = pathlib.Path(__file__).resolve().parent.parent
AXES = ("accel_x", "accel_y", "accel_z", "gyro_x", "gyro_y", "gyro_z")


def matlab(folder):
    """MATLAB 7.3 buffers (time, x, y, z) as CSV."""
    def read(data):
        import h5py
        names = {"accel": "accelerometer", "gyro": "gyroscope", "temperature": "temperature"}
        got = {}
        for key, name in names.items():
            with h5py.File(data / folder / f"mpu6050_{name}.mat") as f:
                got[key] = f[f"{key}Buffer"][()]
                if got[key].shape[0] > got[key].shape[1]:
                    got[key] = got[key].T
        out = io.StringIO()
        out.write("time,ax,ay,az,gx,gy,gz\n")
        n = min(got["accel"].shape[1], got["gyro"].shape[1])
        for k in range(n):
            row = [got["accel"][0, k], *got["accel"][1:4, k], *got["gyro"][1:4, k]]
            out.write(",".join(repr(float(v)) for v in row) + "\n")
        return out.getvalue().encode()
    return read


def zipped(path, first=0):
    def read(data):
        with zipfile.ZipFile(data / path) as z:
            lines = z.read(z.namelist()[0]).splitlines(keepends=True)
        return b"".join(lines[:1] + lines[1 + first:])
    return read


# name: (input, options, README section (None: the file), scale of accel, of gyro, table column names by axis,
#        factors times which rate, kinds that must be found, kinds that may be found beside them)
MPU = ["ax", "ay", "az", "gx", "gy", "gz"]
SHORT = ["acc_x", "acc_y", "acc_z", "gyro_x", "gyro_y", "gyro_z"]
COUNTS = ["--columns", "gyro=0,1,2:0.05 deg/s, accel=3,4,5:0.00333 g", "--rate", "100Hz"]
ORIENTED = "time=time:s, accel=ax,ay,az:g, gyro=gx,gy,gz:deg/s"
ASTRO = "time=time_stamp:iso, accel=accel_x,accel_y,accel_z:g, gyro=gyro_x,gyro_y,gyro_z:rad/s, temperature=temp_p:degC"
RECORDINGS = {
    "adis16405-imu2": dict(
        file="adis16405-static/adis_16405_imu2_counts.csv.gz", options=COUNTS, section="adis_16405_imu2",
        scale=(G, DEG), names=SHORT, must={"quantization"},
        lsb=(0.00333 * G, 0.05 * DEG)),
    "adis16405-imu3": dict(
        file="adis16405-static/adis_16405_imu3_counts.csv.gz", options=COUNTS, section="adis_16405_imu3",
        scale=(G, DEG), names=SHORT, must={"quantization"},
        lsb=(0.00333 * G, 0.05 * DEG)),
    "samsung-galaxy-s5": dict(
        file="samsung-galaxy-s5-static/samsung_galaxy_s5_acc_gyro.csv.gz",
        options=["--columns", "accel=0,1,2:m/s^2, gyro=3,4,5:rad/s", "--rate", "10Hz"], section="Reference Allan",
        scale=(1, 1), names=["acc_x", "acc_y", "acc_z", "gyro_raw_x", "gyro_raw_y", "gyro_raw_z"], must={"filtered"}),
    "astropi-all": dict(
        pipe=zipped("astropi-sensehat-static/astro_pi_data_20150824_085954.zip"),
        options=["--columns", ASTRO], scale=(G, 1), names=None, must={"gap"}),
    "astropi-still": dict(
        pipe=zipped("astropi-sensehat-static/astro_pi_data_20150824_085954.zip", first=4101),
        options=["--columns", ASTRO.replace("time=time_stamp:iso, ", ""), "--rate", "0.1Hz"], section="Reference Allan",
        scale=(G, 1), names=list(AXES), must=set()),
    "mpu6050-10min": dict(
        pipe=matlab("mpu6050-orientations/set-2/unmoved-with-x-pointing-forward-10min"), options=["--columns",
        ORIENTED.replace("time=time:s, ", ""), "--rate", "99.3171Hz"], section="set-2/unmoved-with-x-pointing-forward-10min", scale=(G, DEG), names=SHORT,
        must=set(), lsb=(4 * G / 16384, DEG / 131)),
    "mpu6050-10min-stamps": dict(
        pipe=matlab("mpu6050-orientations/set-2/unmoved-with-x-pointing-forward-10min"), options=["--columns", ORIENTED],
        scale=(G, DEG), names=None, must={"jitter"}),
    "mpu6050-x-forward": dict(
        pipe=matlab("mpu6050-orientations/set-2/unmoved-with-x-pointing-forward"), options=["--columns", ORIENTED,
        "--rate", "99.37Hz"], scale=(G, DEG), names=None, must=set()),
    "mpu6050-x-up": dict(
        pipe=matlab("mpu6050-orientations/set-2/unmoved-with-z-pointing-front-and-x-up"), options=["--columns", ORIENTED,
        "--rate", "99.52Hz"], scale=(G, DEG), names=None, must=set()),
    "mpu6050-y-down": dict(
        pipe=matlab("mpu6050-orientations/set-2/unmoved-with-z-pointing-front-and-y-down"), options=["--columns", ORIENTED,
        "--rate", "99.4Hz"], scale=(G, DEG), names=None, must=set()),
    "mpu6050-tinit": dict(
        file="mpu6050-multiposition/static_tinit.csv",
        options=["--columns", "accel=0,1,2:6.103515625e-5 g, gyro=3,4,5:0.007633587786259542 deg/s", "--rate", "100Hz"], section="Static log",
        scale=(G / 16384, DEG / 131), names=MPU, must=set()),
    "mpu6050-test": dict(
        file="mpu6050-multiposition/static_test.csv",
        options=["--columns", "accel=0,1,2:6.103515625e-5 g, gyro=3,4,5:0.007633587786259542 deg/s", "--rate", "100Hz"],
        scale=(G / 16384, DEG / 131), names=None, must=set()),
}


def tables(text):
    """Markdown tables as lists of dicts, each with the last heading before it."""
    heading, head, out = "", None, []
    for row in text.splitlines():
        if row.startswith("#"):
            heading, head = row.strip("# "), None
        elif row.startswith("|"):
            cells = [c.strip() for c in row.strip("|").split("|")]
            if head is None:
                head = cells
                out.append((heading, []))
            elif not set(row) <= set("|-: "):
                out[-1][1].append(dict(zip(head, cells)))
        else:
            head = None
    return out


class Run:
    def __init__(self, program, data, name, entry):
        self.program, self.entry, self.name = program, entry, name
        if "pipe" in entry:
            self.source, self.stdin = "-", entry["pipe"](data)
        else:
            self.source, self.stdin = str(data / entry["file"]), None
            if not pathlib.Path(self.source).exists():
                raise FileNotFoundError(self.source)

    def __call__(self, command, *more):
        args = [self.program, command, self.source, "--format", "json", *self.entry["options"], *more]
        run = subprocess.run(args, input=self.stdin, capture_output=True)
        if run.returncode:
            raise SystemExit(f"{args}: {run.stderr.decode()}")
        return json.loads(run.stdout)


def agrees(text, value):
    """`value` is the printed number, to its last digit."""
    want = float(text)
    digits = len(re.sub(r"[eE].*|[-.]", "", text).lstrip("0"))
    if want == 0:
        return abs(value) < 1e-12
    step = 10.0 ** (math.floor(math.log10(abs(want))) - max(digits, 5) + 1)
    # Half a digit; the phone's CSV is itself rounded to seven digits, which moves a tie.
    return abs(value - want) <= 0.51 * step


def check(run, readme, pages):
    """Problems, and what the program said."""
    entry, problems = run.entry, []
    rate = re.sub(r"[^0-9.]", "", entry["options"][-1]) if "--rate" in entry["options"] else None
    compared = 0
    if entry["names"]:
        columns = dict(zip(AXES, entry["names"]))
        scale = {a: entry["scale"][0 if a.startswith("accel") else 1] for a in AXES}
        found = [t for h, t in tables(readme) if entry["section"] in h and t and "m" in t[0]]
        taus = [int(r["m"]) for r in found[0]]
        curve = run("allan", "--taus", ", ".join(f"{m / float(rate)!r} s" for m in taus))
        by_axis = {a["axis"]: a for a in curve["axes"]}
        for k, row in enumerate(found[0]):
            for axis, column in columns.items():
                got = by_axis[axis]["deviation"][k] / scale[axis]
                compared += 1
                if not agrees(row[column], got):
                    problems.append(f"oadev {axis} m = {row['m']}: {got:.6g}, README {row[column]}")
        facts = run("info")
        for channel in facts["channels"]:
            table = [t for h, t in tables(readme) if t and "channel" in t[0] and
                     (entry["section"] in h or not any(entry["section"] in h2 and t2 and "channel" in t2[0]
                                                       for h2, t2 in tables(readme)))]
            for row in table[0] if table and "still" not in run.name else []:
                if row["channel"] != columns.get(channel["name"]):
                    continue
                for key in ("mean", "std", "min", "max"):
                    got = channel[key] / scale[channel["name"]]
                    compared += 1
                    if abs(got - float(row[key])) > 2e-5 * abs(float(row[key])) + 1e-9 * abs(scale[channel["name"]]):
                        problems.append(f"{channel['name']} {key}: {got:.6g}, README {row[key]}")
            lsb = entry.get("lsb")
            if lsb and channel["name"] in AXES:
                want = lsb[0 if channel["name"].startswith("accel") else 1]
                if channel["lsb"] is None or abs(channel["lsb"] / want - 1) > 2e-3:
                    problems.append(f"{channel['name']}: step {channel['lsb']}, known {want:.6g}")
    more = []
    if pages:
        page = pathlib.Path(pages, f"{run.name}.html")
        page.unlink(missing_ok=True)
        more = ["--report", str(page)]
    got = run("characterize", *more)
    issues = got["log"]["issues"]
    kinds = {i["kind"] for i in issues}
    for kind in entry["must"] - kinds:
        problems.append(f"`{kind}` is known of it and not found")
    return problems, compared, got


def summary(got):
    """What was said, one line a finding kind, one an axis."""
    lines, seen = [], {}
    for i in got["log"]["issues"]:
        seen.setdefault(i["kind"], []).append(i)
    for kind, all_of in seen.items():
        first = all_of[0]
        lines.append(f"    {kind} ({len(all_of)}): {first['channel'] or 'log'}: {first['text']}")
    for a in got["axes"]:
        words = []
        for term, e in a["terms"].items():
            if isinstance(e, dict) and e["status"] == "detected":
                words.append(f"{term} {e['value']:.3g} ({e['lower']:.3g} … {e['upper']:.3g})")
        p = a["fit"]["p_value"]
        lines.append(f"    {a['axis']}: {'; '.join(words) or 'limits only'}; p = {p if p is None else round(p, 3)}")
    return "\n".join(lines)


def main():
    p = argparse.ArgumentParser()
    p.add_argument("program")
    p.add_argument("--pages")
    p.add_argument("--only")
    p.add_argument("--verbose", action="store_true")
    o = p.parse_args()
    data = pathlib.Path(os.environ.get("SAGNAC_DATA") or ROOT.parent / "shared" / "data")
    if o.pages:
        pathlib.Path(o.pages).mkdir(parents=True, exist_ok=True)
    failed = 0
    for name, entry in RECORDINGS.items():
        if o.only and o.only not in name:
            continue
        try:
            run = Run(o.program, data, name, entry)
        except FileNotFoundError as missing:
            print(f"skipped {name}: {missing.filename or missing} is not there")
            continue
        readme = next(iter(data.glob(f"{(entry.get('file') or 'x/').split('/')[0]}/README.md")), None)
        if readme is None:
            folder = "astropi-sensehat-static" if name.startswith("astro") else "mpu6050-orientations"
            readme = data / folder / "README.md"
        problems, compared, got = check(run, readme.read_text(), o.pages)
        failed += bool(problems)
        print(f"{'FAIL' if problems else 'ok  '} {name}: {got['log']['samples']} samples, {got['log']['rate_hz']:.6g} Hz, "
              f"{compared} numbers of the README compared")
        for problem in problems:
            print(f"    {problem}")
        if o.verbose:
            print(summary(got))
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
