"""`sagnac audit` on noise files that others published, and on files with mistakes planted against a log.

Usage: check_audit.py PATH_TO_SAGNAC [--page > AUDIT.md]

Published values with their sources; each file is written in its own tool's format. Planted: a log is simulated from a model
(seed 1, 2 h at 200 Hz), its right file and eleven wrong ones are judged with --log; each mistake must be named, and of the right
file none.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

PROGRAM, PAGE = sys.argv[1], "--page" in sys.argv
KEYS = ("gyro N", "gyro K", "accel N", "accel K")
failures = []


def kalibr(gn, gk, an, ak, rate=200.0):
    return (f"accelerometer_noise_density: {an!r}\naccelerometer_random_walk: {ak!r}\ngyroscope_noise_density: {gn!r}\n"
            f"gyroscope_random_walk: {gk!r}\nupdate_rate: {rate}\nrostopic: /imu0\n")


def openvins(*v):
    body = "".join("  " + line + "\n" for line in kalibr(*v).splitlines())
    return ("%YAML:1.0\nimu0:\n  T_i_b:\n    - [1.0, 0.0, 0.0, 0.0]\n    - [0.0, 1.0, 0.0, 0.0]\n    - [0.0, 0.0, 1.0, 0.0]\n"
            "    - [0.0, 0.0, 0.0, 1.0]\n" + body + "  time_offset: 0.0\n  model: \"kalibr\"\n")


def kimera(gn, gk, an, ak, rate=200.0):
    return (f"%YAML:1.0\nimu_preintegration_type: 0\nrate_hz: {rate}\nimu_bias_init_sigma: 1.0e-03\ngyroscope_noise_density: {gn!r}\n"
            f"gyroscope_random_walk: {gk!r}\naccelerometer_noise_density: {an!r}\naccelerometer_random_walk: {ak!r}\n"
            "imu_integration_sigma: 1.0e-8\nimu_time_shift: 0.0\nn_gravity: [0.0, 0.0, -9.81]\n")


def vins(gn, gk, an, ak):
    return f"%YAML:1.0\nimu: 1\nacc_n: {an!r}\ngyr_n: {gn!r}\nacc_w: {ak!r}\ngyr_w: {gk!r}\ng_norm: 9.81007\n"


def orbslam3(gn, gk, an, ak):
    return (f"%YAML:1.0\nFile.version: \"1.0\"\nIMU.NoiseGyro: {gn!r}\nIMU.NoiseAcc: {an!r}\nIMU.GyroWalk: {gk!r}\n"
            f"IMU.AccWalk: {ak!r}\nIMU.Frequency: 200.0\n")


def basalt(gn, gk, an, ak):
    three = {k: [v] * 3 for k, v in (("accel_noise_std", an), ("gyro_noise_std", gn), ("accel_bias_std", ak), ("gyro_bias_std", gk))}
    return json.dumps({"value0": {"calib_accel_bias": [0.0] * 9, "calib_gyro_bias": [0.0] * 12, "imu_update_rate": 200.0, **three}})


def imu_utils(gn, gw, an, aw):
    def part(name, unit, key, n, w):
        axes = "".join(f"   {a}-axis:\n      {key}_n: {n!r}\n      {key}_w: {w!r}\n" for a in ("avg", "x", "y", "z"))
        return f"{name}:\n   unit: \" {unit}\"\n{axes}"
    return "%YAML:1.0\n---\ntype: IMU\n" + part("Gyr", "rad/s", "gyr", gn, gw) + part("Acc", "m/s^2", "acc", an, aw)


C, W, S = "consistent", "wrong", "suspicious"
COPY, INFL = f"{S}: instability_as_walk", f"{S}: inflated"
# Name, source, text, options, verdicts that are known (None: shown, not checked).
PUBLISHED = [
    ("EuRoC ADIS16448", "rpng/open_vins config/euroc_mav", openvins(1.6968e-4, 1.9393e-5, 2.0e-3, 3.0e-3), (), (C, COPY, C, INFL)),
    ("EuRoC", "UZ-SLAMLab/ORB_SLAM3 EuRoC.yaml", orbslam3(1.7e-4, 1.9393e-5, 2.0e-3, 3.0e-3), (), (C, COPY, C, INFL)),
    ("EuRoC, Kimera", "MIT-SPARK/Kimera-VIO params/Euroc", kimera(1.6968e-4, 1.9393e-5, 2.0e-3, 3.0e-2), (), (C, COPY, C, W)),
    ("EuRoC, basalt", "basalt data/euroc_ds_calib.json", basalt(2.82e-4, 1e-4, 1.6e-2, 1e-3), (), None),
    ("EuRoC, VINS-Fusion, taken at 200 Hz", "VINS-Fusion config/euroc", vins(0.01, 1e-4, 0.1, 1e-3), ("--rate", "200Hz"), (C, C, C, C)),
    ("ADIS16448, Kalibr wiki", "kalibr issue 63", kalibr(5e-3, 4.0e-6, 1e-2, 2e-4), (), None),
    ("ADIS16448, Kalibr help", "kalibr_calibrate_imu_camera", kalibr(4e-4, 4.0e-6, 6e-3, 2e-4), (), None),
    ("ADIS16448, imu_utils", "gaowenliang/imu_utils", imu_utils(1.858e-4, 7.245e-5, 1.986e-3, 1.215e-3), ("--rate", "200Hz"), None),
    ("BMI160, imu_utils", "gaowenliang/imu_utils", imu_utils(1.214e-3, 2.63e-5, 1.99e-2, 5.26e-4), ("--rate", "196Hz"), None),
    ("TUM-VI BMI160", "rpng/open_vins config/tum_vi", openvins(1.6e-4, 2.2e-5, 2.8e-3, 8.6e-4), (), (C, C, C, INFL)),
    ("TUM-VI, basalt", "basalt data/tumvi_512_ds_calib.json", basalt(2.82e-4, 1e-4, 1.6e-2, 1e-3), (), None),
    ("KAIST urban MTi-300", "rpng/open_vins config/kaist", openvins(1.7453e-4, 1e-5, 5.886e-3, 1e-4, 500.0), (), (C, C, C, C)),
    ("KAIST VIO, measured", "rpng/open_vins config/kaist_vio, comment", openvins(5.770e-5, 1.565e-5, 3.334e-3, 4.740e-4, 100.0), (), None),
    ("KAIST VIO, used", "rpng/open_vins config/kaist_vio", openvins(1e-3, 3e-4, 0.07, 9e-3, 100.0), (), None),
    ("UZH-FPV, data set's", "basalt doc/Calibration.md", kalibr(0.05, 4.0e-5, 0.1, 2e-3), (), (W, C, W, C)),
    ("Hilti 2022 Alphasense", "lunarlab-gatech/open_vins config/hilti_2022", openvins(2.2192e-4, 7.1730e-6, 1.6536e-3, 2.5729e-4, 400.0), (), None),
    ("RealSense D455, measured", "rpng/open_vins config/rs_d455", openvins(1.0272e-4, 1.1106e-6, 1.0382e-3, 4.1328e-5, 400.0), (), (C, C, C, C)),
    ("RealSense D455, ×2 and ×10", "rpng/open_vins config/rs_d455", openvins(2.0544e-4, 1.1106e-5, 2.0765e-3, 4.1328e-4, 400.0), (), None),
    ("RealSense D455, Kimera", "MIT-SPARK/Kimera-VIO params/D455", kimera(0.187, 0.0266, 0.186, 0.0433, 400.0), (), (W, W, W, W)),
    ("RealSense T265, ×5 and ×10", "rpng/open_vins config/rs_t265", openvins(5.4167e-4, 1.1688e-5, 7.3208e-3, 6.6965e-4), (), None),
    ("RealSense, allan_variance_ros", "ori-drs/allan_variance_ros README", kalibr(1.5199e-4, 2.6645e-6, 6.3082e-3, 1.1674e-4), (), None),
    ("OpenVINS ironsides", "rpng/open_vins config/rpng_ironsides", openvins(1.1187e-4, 8.9975e-7, 2.7053e-3, 1.3055e-4), (), (C, C, C, C)),
    ("MicroStrain GX4, imu_utils", "gaowenliang/imu_utils", imu_utils(6.58e-5, 4.50e-5, 9.08e-4, 4.41e-4), ("--rate", "500Hz"), None),
    ("Xsens MTi-100, imu_utils", "gaowenliang/imu_utils", imu_utils(1.56e-4, 5.84e-5, 7.85e-4, 3.21e-4), ("--rate", "100Hz"), None),
]


def judge(folder, text, *options):
    path = folder / ("file.json" if text.startswith("{") else "file.yaml")
    path.write_text(text)
    done = subprocess.run([PROGRAM, "audit", path, "--format", "json", *options], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"audit: {done.stderr}\n{text}")
    return json.loads(done.stdout)["entries"]


def column(entry):
    """Which of the four numbers an entry is."""
    key = entry["key"].lower()
    unit = entry["meaning"] and (entry["meaning"]["unit"] or "")
    gyro = "gyr" in key or (unit or "").startswith("rad")
    walk = any(w in key for w in ("walk", "_w", "bias_std"))
    return (0 if gyro else 2) + walk


def cells(entries):
    out = [[] for _ in KEYS]
    for e in entries:
        said = e["verdict"] + (f": {e['likely_mistake']}" if e["likely_mistake"] else "")
        if said not in out[column(e)]:
            out[column(e)].append(said)
    return [" / ".join(c) for c in out]


def published(folder):
    print("| file | source | " + " | ".join(KEYS) + " |\n|---|---|---|---|---|---|")
    for name, source, text, options, wanted in PUBLISHED:
        got = cells(judge(folder, text, *options))
        if wanted and tuple(got) != wanted:
            failures.append(f"{name}: {got}, not {wanted}")
        print(f"| {name} | {source} | " + " | ".join(got) + " |", flush=True)


MODEL = """schema = 1
name = "planted"
sample_rate = "200 Hz"
[gyro.noise]
angle_random_walk = "2e-4 rad/s/sqrt(Hz)"
rate_random_walk = "1e-5 rad/s^2/sqrt(Hz)"
[accel.noise]
velocity_random_walk = "1.9e-3 m/s^2/sqrt(Hz)"
acceleration_random_walk = "1e-4 m/s^3/sqrt(Hz)"
"""


def planted(folder):
    (folder / "model.toml").write_text(MODEL)
    subprocess.run([PROGRAM, "simulate", folder / "model.toml", "--rest", "2h", "--noise", "white,random_walk", "--seed", "1",
                    "-o", folder / "log.npy", "--quiet", "--force"], check=True, capture_output=True)
    right, root = (2e-4, 1e-5, 1.9e-3, 1e-4), 200 ** 0.5
    cases = [("the right file", None, None, right)]
    for which, factor, mistake, what in [
        (0, root, "per_sample", "gyro N times √f"), (0, 1 / root, "sqrt_rate", "gyro N over √f"),
        (2, root, "per_sample", "accel N times √f"), (0, 57.29578, "degrees", "gyro N in deg"),
        (1, 57.29578, "degrees", "gyro K in deg"), (2, 1 / 9.80665, "g", "accel N in g"), (0, 2 ** 0.5, "sqrt_2", "gyro N one-sided"),
        (2, 0.5 ** 0.5, "sqrt_2", "accel N over √2"), (0, 2e-4, "variance", "gyro N squared"),
        (1, 10.0, "inflated", "gyro K ×10"), (2, 5.0, "inflated", "accel N ×5"),
    ]:
        wrong = list(right)
        wrong[which] *= factor
        cases.append((what, which, mistake, wrong))
    print("| planted | verdict on it | others |\n|---|---|---|")
    for what, which, mistake, values in cases:
        entries = judge(folder, kalibr(*values), "--log", str(folder / "log.npy"), "--rate", "200Hz")
        others = [e for e in entries if column(e) != which]
        bad = [f"{e['key']} {e['verdict']}" for e in others if e["verdict"] not in ("consistent", "unknown")]
        mine = next((e for e in entries if column(e) == which), None)
        said = f"{mine['verdict']}: {mine['likely_mistake']}" if mine else "none"
        if bad or (mine and mine["likely_mistake"] != mistake):
            failures.append(f"planted {what}: {said}, others {bad}")
        print(f"| {what} | {said} | {', '.join(bad) or 'all consistent'} |", flush=True)


with tempfile.TemporaryDirectory() as folder:
    folder = pathlib.Path(folder)
    if PAGE:
        print("# What `sagnac audit` says of published noise files\n\nMade by `python tools/check_audit.py target/release/sagnac "
              "--page > AUDIT.md`, which `cargo xtask python` runs as a check.\nWithout a log, `consistent` means possible, no more: most "
              "shipped values are inflated on purpose and no measurement of a sensor.\nOf imu_utils both readings of `_n` are judged, "
              "since a file does not say which it holds; its `_w` is an Allan minimum.\n")
    published(folder)
    if PAGE:
        print("\n## Mistakes planted against a log\n\nTwo hours at 200 Hz, simulated with gyro N 2e-4, K 1e-5 and accelerometer N 1.9e-3, "
              "K 1e-4 (SI), judged with `--log`.\n")
    planted(folder)
if failures:
    print("\n".join(failures), file=sys.stderr)
sys.exit(bool(failures))
