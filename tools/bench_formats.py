"""Speed and memory of the streaming readers on generated logs, rosbags on the same bag and MCAP beside them.

    cargo build --release -p sagnac-log --example throughput
    python tools/bench_formats.py target/release/examples/throughput [--stream GB] [--only NAME]

Without --stream: a file of about 1 GB a format in the page cache, read three times by one thread, the best given. With it: so many
GB of each format go through a pipe, made as they are read, and the peak resident memory is printed: it must not grow with the length.
Formats that are read by place are files of so many GB of values: sparse (HDF5, .npy) or of packed, equal batches (Arrow, Parquet).
"""
import json
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import time
import zlib

import numpy as np

PROGRAM = sys.argv[1]
GB = float(sys.argv[sys.argv.index("--stream") + 1]) if "--stream" in sys.argv else None
ONLY = sys.argv[sys.argv.index("--only") + 1] if "--only" in sys.argv else None
START = 1_700_000_000_000_000_000
STEP = 5_000_000


def template(message, count):
    """`count` copies of a message's bytes, as rows to write stamps into."""
    return np.tile(np.frombuffer(message, "u1"), (count, 1))


def put(rows, at, values, kind):
    width = np.dtype(kind).itemsize
    rows[:, at:at + width] = values.astype(kind).view("u1").reshape(-1, width)


def body():
    b = bytearray(37 * 8)
    struct.pack_into("<3d", b, 13 * 8, 0.1, -0.2, 0.3)
    struct.pack_into("<3d", b, 25 * 8, 0.5, -0.6, 9.8)
    struct.pack_into("<d", b, 4 * 8, -1.0)
    return bytes(b)


def fields(*pairs):
    return b"".join(struct.pack("<I", len(n) + 1 + len(v)) + n + b"=" + v for n, v in pairs)


def record(head, data):
    return struct.pack("<I", len(head)) + head + struct.pack("<I", len(data)) + data


def bag(n):
    yield b"#ROSBAG V2.0\n"
    head = fields((b"op", b"\x03"), (b"index_pos", bytes(8)), (b"conn_count", struct.pack("<I", 1)), (b"chunk_count", bytes(4)))
    yield record(head, b" " * (4096 - len(head) - 8))
    about = fields((b"topic", b"/imu"), (b"type", b"sensor_msgs/Imu"), (b"md5sum", b"6a62c6daae103f4ff57a132d6f95cec2"),
                   (b"message_definition", b""))
    connection = record(fields((b"op", b"\x07"), (b"conn", bytes(4)), (b"topic", b"/imu")), about)
    data = bytes(12) + struct.pack("<I", 3) + b"imu" + body()
    message = record(fields((b"op", b"\x02"), (b"conn", bytes(4)), (b"time", bytes(8))), data)
    stamp = len(message) - len(data) + 4
    per = 2000
    rows = template(message, per)
    for first in range(0, n, per):
        ns = START + STEP * np.arange(first, first + per)
        put(rows, stamp, ns // 10**9, "<u4")
        put(rows, stamp + 4, ns % 10**9, "<u4")
        chunk = (connection if first == 0 else b"") + rows.tobytes()
        yield record(fields((b"op", b"\x05"), (b"compression", b"none"), (b"size", struct.pack("<I", len(chunk)))), chunk)


def mcap(n):
    def text(s):
        return struct.pack("<I", len(s)) + s

    def entry(kind, content):
        return bytes([kind]) + struct.pack("<Q", len(content)) + content

    yield b"\x89MCAP0\r\n" + entry(1, text(b"ros2") + text(b"bench"))
    yield entry(3, struct.pack("<H", 1) + text(b"sensor_msgs/msg/Imu") + text(b"ros2msg") + text(b""))
    yield entry(4, struct.pack("<HH", 0, 1) + text(b"/imu") + text(b"cdr") + struct.pack("<I", 0))
    cdr = b"\x00\x01\x00\x00" + bytes(8) + struct.pack("<I", 4) + b"imu\x00" + body()
    message = entry(5, struct.pack("<HIQQ", 0, 0, 0, 0) + cdr)
    stamp, per = len(message) - len(cdr) + 4, 2000
    rows = template(message, per)
    for first in range(0, n, per):
        ns = START + STEP * np.arange(first, first + per)
        put(rows, stamp, ns // 10**9, "<u4")
        put(rows, stamp + 4, ns % 10**9, "<u4")
        for at in (15, 23):
            put(rows, at, ns, "<u8")
        data = rows.tobytes()
        yield entry(6, struct.pack("<QQQI", int(ns[0]), int(ns[-1]), len(data), zlib.crc32(data)) + text(b"") + struct.pack("<Q", len(data)) + data)
    yield entry(15, bytes(4)) + entry(2, bytes(20)) + b"\x89MCAP0\r\n"


def ulog(n):
    def message(kind, content):
        return struct.pack("<HB", len(content), ord(kind)) + content
    names = "uint64_t timestamp;float[3] gyro_rad;uint32_t gyro_integral_dt;float[3] accelerometer_m_s2;"
    yield b"ULog\x01\x12\x35\x01" + bytes(8) + message("B", bytes(40)) + message("F", f"sensor_combined:{names}".encode())
    yield message("A", bytes(1) + struct.pack("<H", 3) + b"sensor_combined")
    rows, per = template(message("D", struct.pack("<HQ3fI3f", 3, 0, 0.1, -0.2, 0.3, 5000, 0.5, -0.6, 9.8)), 20000), 20000
    for first in range(0, n, per):
        put(rows, 5, 5000 * np.arange(first, first + per), "<u8")
        yield rows.tobytes()


def dataflash(n):
    def form(kind, length, *texts):
        return b"\xA3\x95\x80" + struct.pack("<BB4s16s64s", kind, length, *texts)
    yield form(128, 89, b"FMT", b"BBnNZ", b"Type,Length,Name,Format,Columns")
    yield form(131, 40, b"IMU", b"QBfffffff", b"TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,T")
    one = b"\xA3\x95\x83" + struct.pack("<QB7f", 0, 0, 0.1, -0.2, 0.3, 0.5, -0.6, 9.8, 25.0)
    rows, per = template(one, 20000), 20000
    for first in range(0, n, per):
        put(rows, 3, 5000 * np.arange(first, first + per), "<u8")
        yield rows.tobytes()


FORMATS = {"bag": (bag, 361.2), "mcap": (mcap, 347), "ulog": (ulog, 41), "dataflash": (dataflash, 40)}


def stream(name, make, size):
    n = int(GB * 1e9 / size)
    start, sent = time.time(), 0
    with subprocess.Popen([PROGRAM, "-"], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as child:
        for piece in make(n):
            child.stdin.write(piece)
            sent += len(piece)
        child.stdin.close()
        said = json.loads(child.stdout.read())
    print(f"| {name} | {sent / 1e9:.1f} | {said['rows']:,} | {said['peak']} | {time.time() - start:.0f} |", flush=True)
    assert said["rows"] >= n


def sparse_npy(path, n):
    with open(path, "wb") as f:
        np.lib.format.write_array_header_1_0(f, dict(descr="<f8", fortran_order=False, shape=(n, 6)))
        f.truncate(f.tell() + 48 * n)


def sparse_hdf5(path, n):
    import h5py
    with h5py.File(path, "w") as f:
        f.create_dataset("gyr", (n, 3), "f8")[-1] = 1.0
        f.create_dataset("acc", (n, 3), "f8")[-1] = 1.0


def batches(path, n, per=1 << 17):
    import pyarrow as pa
    import pyarrow.parquet as pq
    table = pa.table({f"{w}_{a} [{u}]": np.arange(per) * 1e-3 for w, u in (("gyro", "rad/s"), ("accel", "m/s^2")) for a in "xyz"})
    with (pq.ParquetWriter(path, table.schema, compression="zstd") if path.suffix == ".parquet" else
          pa.ipc.new_file(path, table.schema, options=pa.ipc.IpcWriteOptions(compression="zstd"))) as f:
        for _ in range(-(-n // per)):
            f.write_table(table)


BY_PLACE = {
    "npy": (sparse_npy, "accel=0,1,2:m/s^2, gyro=3,4,5:rad/s"), "h5": (sparse_hdf5, "gyro=gyr:rad/s, accel=acc:m/s^2"),
    "arrow": (batches, None), "parquet": (batches, None)}


def by_place(name, make, columns):
    n = int(GB * 1e9 / 48)
    with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as folder:
        path = pathlib.Path(folder) / f"log.{name}"
        make(path, n)
        start = time.time()
        options = (["--columns", columns] if columns else []) + ["--rate", "100"]
        said = json.loads(subprocess.check_output([PROGRAM, path, *options]))
    print(f"| {name} | {48 * said['rows'] / 1e9:.1f} | {said['rows']:,} | {said['peak']} | {time.time() - start:.0f} |", flush=True)
    assert said["rows"] >= n


def peers(name, path):
    """Messages a second of rosbags, decoded as it does."""
    from rosbags.rosbag1 import Reader as Bag
    from rosbags.rosbag2 import Reader as Ros2
    from rosbags.typesys import Stores, get_typestore
    start, n = time.time(), 0
    if name == "bag":
        store = get_typestore(Stores.ROS1_NOETIC)
        with Bag(path) as reader:
            for connection, _, raw in reader.messages():
                store.deserialize_ros1(raw, connection.msgtype)
                n += 1
    else:
        from mcap.reader import make_reader
        store = get_typestore(Stores.ROS2_HUMBLE)
        with open(path, "rb") as f:
            for _, _, m in make_reader(f).iter_messages(log_time_order=False):
                store.deserialize_cdr(m.data, "sensor_msgs/msg/Imu")
                n += 1
    return n / (time.time() - start)


def cached(name, make, size):
    with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as folder:
        path = pathlib.Path(folder) / name
        with open(path, "wb") as f:
            for piece in make(int(1e9 / size)):
                f.write(piece)
        runs = [json.loads(subprocess.check_output([PROGRAM, path])) for _ in range(3)]
        best = max(r["rows_per_s"] for r in runs)
        print(f"| {name} | {best / 1e6:.1f} | {best * size / 1e6:.0f} | {runs[0]['peak']} |", flush=True)


print("| format | GB | messages | peak memory | s |\n|---|---|---|---|---|" if GB else
      "| format | M messages/s | MB/s | peak memory |\n|---|---|---|---|")
for name, (make, size) in FORMATS.items():
    if ONLY in (None, name):
        stream(name, make, size) if GB else cached(name, make, size)
if GB:
    for name, (make, columns) in BY_PLACE.items():
        if ONLY in (None, name):
            by_place(name, make, columns)
if not GB:
    # rosbags reads recordings that were closed: ours, converted.
    sagnac = os.environ.get("SAGNAC", "target/release/sagnac")
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "open.bag").write_bytes(b"".join(bag(100_000)))
        for name in ("bag", "mcap"):
            subprocess.run([sagnac, "convert", folder / "open.bag", "-o", folder / f"a.{name}", "--quiet"], check=True)
            print(f"| {name}, rosbags | {peers(name, folder / f'a.{name}') / 1e6:.3f} | | |", flush=True)
