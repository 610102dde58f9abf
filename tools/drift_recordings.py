"""The recordings of AGREEMENT.md: strapdown of a real log with and without correction, beside the prediction.

Usage: drift_recordings.py PATH_TO_SAGNAC FOLDER_OF_RECORDINGS   (no packages needed)

Runs `drift MODEL --log LOG --reference TRUTH` on the TUM VI recording `tumvi-room1` and on two of BROAD. The models say
only what is known without the reference. Of the BMI160 that is its data sheet; the makers of TUM VI have corrected its
log, so that what is left of its bias is the size of the biases that the calibration of the corrected set in basalt states
(`data/tumvi_512_ds_calib.json`, commit 0cef943: gyro -7.4e-5, 2.4e-6, -1.8e-5 rad/s, accelerometer -1.18e-3, -7.71e-3,
6.7e-5 m/s^2; their RMS over the axes is taken for sigma). Of BROAD's aktos-t what its 34 s of rest at the start give: the mean rate is the gyro's bias, to N/sqrt(34 s); scatter
times sqrt(dt) is the white noise; that |mean force| is 9.82 and 9.89 m/s^2 allows about 0.05 m/s^2 of accelerometer
bias an axis, of which one pose tells no more.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

BROAD = """schema = 1
name = "aktos-t, trial {trial}"
sample_rate = "285.714 Hz"
[gyro.bias]
fixed = [{bias}]
[gyro.noise]
angle_random_walk = "{gyro} rad/sqrt(s)"
[accel.bias]
fixed = {{ value = "0 m/s^2", sigma = "0.05 m/s^2" }}
[accel.noise]
velocity_random_walk = "{accel} m/s/sqrt(s)"
"""
BMI160 = """schema = 1
name = "BMI160 of TUM VI, as corrected by its makers"
sample_rate = "200 Hz"
[gyro.noise]
angle_random_walk = "0.008 deg/s/sqrt(Hz)"
[gyro.bias]
stability = "4.4e-5 rad/s"
[accel.noise]
velocity_random_walk = "180 ug/sqrt(Hz)"
[accel.bias]
stability = "4.5e-3 m/s^2"
"""
# trial: file, mean rate at rest in rad/s, N of gyro and accelerometer
TRIALS = {
    "01": ("01_undisturbed_slow_rotation_A.mat", (-0.00124, -0.00125, 0.00817), "2.0e-4", "3.4e-3"),
    "11": ("11_undisturbed_slow_translation_B.hdf5", (0.00379, 0.00202, -0.00405), "1.6e-4", "3.3e-3"),
}
RATE = "285.714285714Hz"


def main():
    program, data = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
    room = data / "tumvi-room1" / "mav0"
    options = ["--log", room / "imu0" / "data.csv", "--reference", room / "mocap0" / "data.csv"]
    cases = [("tumvi-room1, data sheet", "catalog:BMI160", options)]
    with tempfile.TemporaryDirectory() as folder:
        model = Path(folder) / "bmi160.toml"
        model.write_text(BMI160)
        cases.append(("tumvi-room1, with published biases", model, options))
        for trial, (name, bias, gyro, accel) in TRIALS.items():
            model = Path(folder) / f"broad-{trial}.toml"
            values = ", ".join(f'{{ value = "{b} rad/s", sigma = "3.5e-5 rad/s" }}' for b in bias)
            model.write_text(BROAD.format(trial=trial, bias=values, gyro=gyro, accel=accel))
            log = data / "broad-orientation" / name
            cases.append((f"broad-orientation, trial {trial}", model,
                          ["--log", log, "--rate", RATE, "--columns", "gyro=imu_gyr:rad/s, accel=imu_acc:m/s^2",
                           "--reference", log, "--reference-rate", RATE,
                           "--reference-columns", "position=opt_pos:m, quaternion=opt_quat"]))
        print("| recording | | " + " | ".join(f"{h} s" for h in (1, 2, 5, 10, 20, 30, 60)) + " |")
        print("|---|---|" + "---|" * 7)
        for name, model, options in cases:
            out = subprocess.run([program, "drift", model, *options, "--format", "json", "--quiet"],
                                 check=True, capture_output=True, text=True)
            found = json.loads(out.stdout)
            for key, words in (("starts", "starts"), ("rms_raw_m", "as recorded, m"),
                               ("rms_corrected_m", "corrected, m"), ("rms_predicted_m", "predicted, m")):
                cells = ["–" if x is None else f"{x:.3g}" for x in found[key]]
                print(f"| {name if key == 'starts' else ''} | {words} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
