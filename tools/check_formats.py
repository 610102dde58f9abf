"""Logs of other tools against those tools' own readers, value by value; and what the program writes, read back by them.

Usage: check_formats.py PATH_TO_SAGNAC

Readers: rosbags, pyulog, pymavlink, SciPy, h5py, pyarrow, numpy (also of KITTI's oxts folders). The files are testdata/logs, testdata/arrays and
the recordings of $SAGNAC_DATA (else ../shared/data beside the workspace), which are skipped where they are not there.
Numbers must be equal to the last bit, time stamps to the nanosecond. Resampling is compared with SciPy's filter.
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import h5py
import numpy as np
import pyarrow.ipc
import pyarrow.parquet as pq
import scipy.io
import scipy.signal
from mcap.reader import make_reader
from pymavlink import DFReader
from pyulog import ULog
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

PROGRAM = sys.argv[1]
ROOT = pathlib.Path(__file__).resolve().parent.parent
DATA = pathlib.Path(os.environ.get("SAGNAC_DATA", ROOT.parent / "shared/data"))
if not DATA.exists():
    DATA = ROOT.parent.parent / "shared/data"
SIX = [f"{w}_{a}" for w in ("gyro", "accel") for a in "xyz"]
failures = []


def run(*words):
    done = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{' '.join(map(str, words))}: {done.stderr.strip()}")
    return done.stdout


def ours(path, *options):
    """Stamps [ns] or times [s] and the six channels, by way of a Parquet file."""
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "a.parquet"
        run("convert", path, "-o", out, "--quiet", *options)
        table = pq.read_table(out)
    columns = {n.split(" ")[0]: table[n].to_numpy() for n in table.column_names}
    return columns["time"], {c: columns[c] for c in SIX if c in columns}


def ros(path, topic=None):
    """rosbags; the header's stamps."""
    path = pathlib.Path(path)
    folder = path.parent if path.suffix == ".db3" and (path.parent / "metadata.yaml").exists() else path
    rows = []
    with AnyReader([folder], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        wanted = [c for c in reader.connections if c.msgtype == "sensor_msgs/msg/Imu" and topic in (None, c.topic)]
        for connection, _, raw in reader.messages(connections=wanted):
            m = reader.deserialize(raw, connection.msgtype)
            stamp = m.header.stamp.sec * 10**9 + m.header.stamp.nanosec
            w, a = m.angular_velocity, m.linear_acceleration
            rows.append((stamp, w.x, w.y, w.z, a.x, a.y, a.z))
    return np.array([r[0] for r in rows]), np.array([r[1:] for r in rows])


def mcap(path):
    """The reference reader of MCAP; rosbags decodes the messages."""
    store, rows = get_typestore(Stores.ROS2_HUMBLE), []
    with open(path, "rb") as f:
        for _, _, message in make_reader(f).iter_messages(log_time_order=False):
            m = store.deserialize_cdr(message.data, "sensor_msgs/msg/Imu")
            w, a = m.angular_velocity, m.linear_acceleration
            rows.append((m.header.stamp.sec * 10**9 + m.header.stamp.nanosec, w.x, w.y, w.z, a.x, a.y, a.z))
    return np.array([r[0] for r in rows]), np.array([r[1:] for r in rows])


def sqlite(path):
    """A lone .db3 without its metadata: the rows themselves."""
    import sqlite3
    store, rows = get_typestore(Stores.ROS2_HUMBLE), []
    for (data,) in sqlite3.connect(f"file:{path}?mode=ro&immutable=1", uri=True).execute(
            "select messages.data from messages join topics on topics.id = topic_id "
            "where type = 'sensor_msgs/msg/Imu' order by messages.timestamp, messages.id"):
        m = store.deserialize_cdr(data, "sensor_msgs/msg/Imu")
        w, a = m.angular_velocity, m.linear_acceleration
        rows.append((m.header.stamp.sec * 10**9 + m.header.stamp.nanosec, w.x, w.y, w.z, a.x, a.y, a.z))
    return np.array([r[0] for r in rows]), np.array([r[1:] for r in rows])


def ulog(path):
    data = ULog(str(path), ["sensor_combined"]).get_dataset("sensor_combined").data
    six = [data[f"{n}[{k}]"] for n in ("gyro_rad", "accelerometer_m_s2") for k in range(3)]
    return data["timestamp"].astype("i8") * 1000, np.array(six, "f8").T


def vehicle_imu(path, instance):
    """pyulog: increments over their own intervals."""
    data = next(d for d in ULog(str(path), ["vehicle_imu"]).data_list if d.multi_id == instance).data
    six = [data[f"delta_{n}[{k}]"].astype("f8") / (1e-6 * data[f"delta_{n}_dt"]) for n in ("angle", "velocity") for k in range(3)]
    return data["timestamp_sample"].astype("i8") * 1000, np.array(six).T


def dataflash(path, name="IMU", instance=None):
    log, rows = DFReader.DFReader_binary(str(path)), []
    while (m := log.recv_match(type=[name])) is not None:
        if instance is None or m.I == instance:
            rows.append((m.TimeUS * 1000, m.GyrX, m.GyrY, m.GyrZ, m.AccX, m.AccY, m.AccZ))
    return np.array([r[0] for r in rows], "i8"), np.array([r[1:] for r in rows])


def oxts(path):
    """numpy: a file of 30 numbers a sample, the dates of all beside them; samples may be missing."""
    dates = [line.strip().replace(" ", "T") for line in (path / "timestamps.txt").read_text().splitlines()]
    files = sorted((path / "data").glob("*.txt"))
    table = np.array([np.loadtxt(file) for file in files])
    assert table.shape[1] == 30, table.shape
    stamps = np.array([dates[int(file.stem)] for file in files], "datetime64[ns]").astype("i8")
    return stamps, table[:, [17, 18, 19, 11, 12, 13]]


def drawn_oxts(folder, rows=200, lost=(3, 4, 77)):
    """A KITTI oxts folder of drawn numbers as that data set prints them, at 10 Hz with uneven stamps."""
    rng = np.random.default_rng(20110926)
    (folder / "data").mkdir()
    steps = 100_000_000 + rng.integers(-9_000_000, 9_000_000, rows)
    stamps = np.datetime64("2011-09-26T13:02:25.964389445") + np.cumsum(steps).astype("timedelta64[ns]")
    (folder / "timestamps.txt").write_text("".join(str(t).replace("T", " ") + "\n" for t in stamps))
    for k in set(range(rows)) - set(lost):
        numbers = [f"{v:.13f}" for v in rng.normal(size=25) * 10.0] + ["4", "10", "4", "4", "0"]
        (folder / "data" / f"{k:010}.txt").write_text(" ".join(numbers) + "\n")


def compare(name, got, want):
    time, channels = got
    stamps, six = want
    problems = []
    if len(time) != len(six):
        problems.append(f"{len(time)} rows, not {len(six)}")
    else:
        if stamps is not None and not np.array_equal(np.asarray(time), np.asarray(stamps)):
            problems.append("time differs")
        for k, c in enumerate(SIX):
            if c in channels and not np.array_equal(channels[c], six[:, k].astype("f8"), equal_nan=True):
                problems.append(f"{c} differs")
        if not channels:
            problems.append("no channels")
    print(f"{'FAIL' if problems else 'ok':4} {name}: {len(six)} rows {'; '.join(problems)}")
    failures.extend(f"{name}: {p}" for p in problems)


def check(path, read, *options, **more):
    if not path.exists():
        print(f"skip {path.name}: not there")
        return
    try:
        compare(path.name + "".join(f" {o}" for o in options[:2] if options), ours(path, *options), read(path, **more))
    except Exception as e:  # A reader of either side gave up: as bad as a wrong number.
        failures.append(f"{path.name}: {e}")
        print(f"FAIL {path.name}: {e}")


def named(arrays, time, gyro, accel):
    def table(v):
        return v if v.shape[0] >= v.shape[1] else v.T
    six = np.hstack([table(arrays[gyro]), table(arrays[accel])])
    return (np.asarray(arrays[time]).ravel() if time else None), six


def h5(path):
    with h5py.File(path) as f:
        return {n: f[n][()] for n in ("imu/stamp", "imu/gyr", "imu/acc")}


logs, arrays, real = ROOT / "testdata/logs", ROOT / "testdata/arrays", DATA / "formats"
for name in ("none.bag", "bz2.bag", "lz4.bag"):
    check(logs / name, ros)
for name in ("none.mcap", "zstd.mcap", "lz4.mcap"):
    check(logs / name, mcap)
check(logs / "none.db3", sqlite)
check(logs / "packed.db3", lambda _: sqlite(logs / "none.db3"))
check(logs / "small.ulg", ulog)
for instance in range(2):
    check(logs / "small.bin", dataflash, "--topic", f"IMU[{instance}]", instance=instance)
check(real / "ros1/phidgets_imu_upside_down.bag", ros)
check(real / "ros1/phidgets_imu_upside_down_lz4.bag", ros)
check(real / "ros1/husky_test1.bag", ros)
check(real / "ros2/phidgets_20s_mcap/phidgets_20s_mcap.mcap", mcap)
check(real / "ros2/phidgets_20s_zstd.mcap", mcap)
check(real / "ros2/phidgets_20s_db3/phidgets_20s_db3.db3", sqlite)
check(real / "ros2/constant_imu/rosbag2_test_0.db3", sqlite)
check(real / "ulog/sample.ulg", ulog)
check(real / "ulog/fmu_v6c_6s.ulg", ulog)
for instance in range(2):
    check(real / "ulog/fmu_v6c_6s.ulg", vehicle_imu, "--topic", str(instance), instance=instance)
for name in ("IMU", "IMU2"):
    check(real / "ardupilot/plane_px4v4.BIN", dataflash, "--topic", name, name=name)
for instance in range(2):
    check(real / "ardupilot/copter_pixhawk4_80k.bin", dataflash, "--topic", f"IMU[{instance}]", instance=instance)

flat = "time=stamp:ns, gyro=gyr:rad/s, accel=acc:m/s^2"
for name in ("plain.mat", "packed.mat", "big.mat"):
    check(arrays / name, lambda p: named(scipy.io.loadmat(p), "stamp", "gyr", "acc"), "--columns", flat)
for name in ("contiguous.h5", "filters.h5", "version108.h5", "latest.h5", "odd_chunks.h5", "many_links.h5"):
    check(arrays / name, lambda p: named(h5(p), "imu/stamp", "imu/gyr", "imu/acc"),
          "--columns", flat.replace("=stamp", "=imu/stamp").replace("=gyr", "=imu/gyr").replace("=acc", "=imu/acc"))
for name in ("snappy.parquet", "zstd.parquet", "gzip_v2.parquet"):
    def columns(p):
        t = pq.read_table(p)
        return t["stamp"].cast("int64").to_numpy(), np.array([t[f"{w}_{a}"] for w in ("gyr", "acc") for a in "xyz"]).T
    check(arrays / name, columns, "--columns", flat.replace(":ns", ""))
for name in ("plain.arrow", "lz4.arrow", "zstd.arrows"):
    def columns(p):
        t = (pyarrow.ipc.open_stream if p.suffix == ".arrows" else pyarrow.ipc.open_file)(p).read_all()
        return t["stamp"].cast("int64").to_numpy(), np.array([t[f"{w}_{a}"] for w in ("gyr", "acc") for a in "xyz"]).T
    check(arrays / name, columns, "--columns", flat.replace(":ns", ""))
broad, rate = "gyro=imu_gyr:rad/s, accel=imu_acc:m/s^2", ("--rate", "285.7142857142857 Hz")
check(DATA / "broad-orientation/01_undisturbed_slow_rotation_A.mat",
      lambda p: named(scipy.io.loadmat(p), None, "imu_gyr", "imu_acc"), "--columns", broad, *rate)


def broad_h5(p):
    with h5py.File(p) as f:
        return None, np.hstack([f["imu_gyr"][()], f["imu_acc"][()]])


check(DATA / "broad-orientation/11_undisturbed_slow_translation_B.hdf5", broad_h5, "--columns", broad, *rate)
check(real / "npz/imu_data.npz", lambda p: named(np.load(p), None, "gyr", "acc"),
      "--columns", "gyro=gyr:rad/s, accel=acc:m/s^2", *rate)
for folder in sorted((DATA / "mpu6050-orientations/set-2").glob("*")):
    for file, key, word in (("gyroscope", "gyro", "gyro"), ("accelerometer", "accel", "accel")):
        def buffer(p, key=key, word=word):
            with h5py.File(p) as f:
                v = f[key + "Buffer"][()].T
            six = np.zeros((len(v), 6))
            six[:, 3 * (word == "accel"):][:, :3] = v[:, 1:4]
            return v[:, 0], six
        unit = "rad/s" if word == "gyro" else "m/s^2"
        check(folder / f"mpu6050_{file}.mat", buffer, "--columns",
              f"time={key}Buffer[0]:s, {word}={key}Buffer[1],{key}Buffer[2],{key}Buffer[3]:{unit}")

check(real / "kitti-oxts", oxts)
with tempfile.TemporaryDirectory() as folder:
    folder = pathlib.Path(folder) / "oxts"
    folder.mkdir()
    drawn_oxts(folder)
    check(folder, oxts)

# What the program writes, by the others' readers.
with tempfile.TemporaryDirectory() as folder:
    folder = pathlib.Path(folder)
    source = logs / "none.bag"
    want = ros(source)
    for name, read in (("a.bag", ros), ("a.mcap", mcap)):
        run("convert", source, "-o", folder / name, "--quiet")
        stamps, six = read(folder / name)
        compare(f"written {name}", (stamps, dict(zip(SIX, six.T))), want)
    for name in ("a.npy", "a.npz"):
        run("convert", source, "-o", folder / name, "--quiet")
        log = np.load(folder / name)
        log = log["log"] if name == "a.npz" else log
        six = np.array([log[n] for n in log.dtype.names[1:]]).T
        compare(f"written {name}", (want[0], dict(zip(SIX, six.T))), want)
    # Remounting: x = -y, y = x.
    run("convert", source, "-o", folder / "turned.mcap", "--quiet", "--axes", "x=-y, y=x, z=z")
    stamps, six = mcap(folder / "turned.mcap")
    w = want[1]
    turned = np.column_stack([-w[:, 1], w[:, 0], w[:, 2], -w[:, 4], w[:, 3], w[:, 5]])
    compare("remounted", (stamps, dict(zip(SIX, six.T))), (want[0], turned))
    # Cut: start <= t - t0 < end.
    run("convert", source, "-o", folder / "cut.mcap", "--quiet", "--start", "20 ms", "--end", "50 ms")
    stamps, six = mcap(folder / "cut.mcap")
    keep = (want[0] - want[0][0] >= 20_000_000) & (want[0] - want[0][0] < 50_000_000)
    compare("cut", (stamps, dict(zip(SIX, six.T))), (want[0][keep], want[1][keep]))
    # Resampling: tones below the new band keep their amplitude, tones beyond it are gone; and it is SciPy's
    # resample_poly with the same window.
    n, rate = 8000, 400.0
    t = np.arange(n) / rate
    tone = np.column_stack([np.sin(2 * np.pi * f * t + 0.3) for f in (3.0, 31.0, 70.0, 130.0, 171.0, 199.0)])
    names = [f"{c} [{'rad/s' if c.startswith('gyro') else 'm/s^2'}]" for c in SIX]
    lines = [",".join(["time [s]", *names])] + [",".join(map(repr, [float(a), *map(float, b)])) for a, b in zip(t, tone)]
    (folder / "tones.csv").write_text("\n".join(lines) + "\n")
    said = json.loads(run("convert", folder / "tones.csv", "-o", folder / "slow.npy", "--resample", "100 Hz", "--format", "json"))
    slow = np.load(folder / "slow.npy")
    got = np.array([slow[c] for c in slow.dtype.names[1:]]).T
    # The same kernel as a filter of SciPy: cutoff 0.45 of the new rate, 16 lobes each side, Kaiser 8.
    half = int(16 / (2 * 0.45 / 4))
    taps = scipy.signal.firwin(2 * half + 1, 0.45 * 100.0, window=("kaiser", 8.0), fs=rate)
    want = scipy.signal.upfirdn(taps, tone, 1, 1, axis=0)[half:half + n][::4]
    inner = slice(half // 4 + 1, -half // 4 - 1)
    worst = np.abs(got[: len(want)][inner] - want[inner]).max()
    left = np.abs(got[inner, 2:]).max()
    okay = worst < 2e-4 and left < 2e-4 and any("resampled" in note for note in said["notes"])
    print(f"{'ok' if okay else 'FAIL':4} resampled 400 to 100 Hz: largest difference to SciPy's filter {worst:.1e}, "
          f"of tones beyond the band {left:.1e} is left")
    if not okay:
        failures.append("resampling")

print(f"{len(failures)} failures")
sys.exit(bool(failures))
