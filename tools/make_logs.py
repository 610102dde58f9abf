"""The small logs of testdata/logs, 20 messages each, written by the formats' own tools where those write them.

    python tools/make_logs.py testdata/logs

Row k of 20: stamp 1700000000 s + 5 ms k, gyro (k, -k, k / 2) rad/s, accel (k / 4, -k, 9.8125) m/s^2.
ULog and DataFlash hold f4, their clocks microseconds since 0. Seeds of the fuzzing as well.
"""
import shutil
import struct
import sys
import tempfile
from pathlib import Path

import numpy as np
from mcap.writer import CompressionType, Writer as McapWriter
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer as Writer2
from rosbags.typesys import Stores, get_typestore

out = Path(sys.argv[1])
out.mkdir(parents=True, exist_ok=True)
rows = [((k, -k, k / 2), (k / 4, -k, 9.8125)) for k in range(20)]
ros1, ros2 = get_typestore(Stores.ROS1_NOETIC), get_typestore(Stores.ROS2_HUMBLE)
KIND = "sensor_msgs/msg/Imu"


def messages(store):
    t = store.types
    is_old = store is ros1
    for k, (gyro, accel) in enumerate(rows):
        stamp = t["builtin_interfaces/msg/Time"](sec=1_700_000_000, nanosec=5_000_000 * k)
        head = dict(stamp=stamp, frame_id="imu") | ({"seq": k} if is_old else {})
        vector, zero = t["geometry_msgs/msg/Vector3"], np.zeros(9)
        yield 1_700_000_000_000_000_000 + 5_000_000 * k, t[KIND](
            header=t["std_msgs/msg/Header"](**head),
            orientation=t["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0),
            orientation_covariance=zero,
            angular_velocity=vector(*map(float, gyro)),
            angular_velocity_covariance=zero,
            linear_acceleration=vector(*map(float, accel)),
            linear_acceleration_covariance=zero,
        )


for name, packing in [("none", None), ("bz2", Writer1.CompressionFormat.BZ2), ("lz4", Writer1.CompressionFormat.LZ4)]:
    path = out / f"{name}.bag"
    path.unlink(missing_ok=True)
    writer = Writer1(path)
    if packing:
        writer.set_compression(packing)
    with writer:
        topic = writer.add_connection("/imu", KIND, typestore=ros1)
        for ns, message in messages(ros1):
            writer.write(topic, ns, ros1.serialize_ros1(message, KIND))
for name, plugin, end in [
    ("none", StoragePlugin.SQLITE3, "db3"), ("none", StoragePlugin.MCAP, "mcap"), ("packed", StoragePlugin.SQLITE3, "db3"),
]:
    with tempfile.TemporaryDirectory() as folder:
        writer = Writer2(Path(folder) / "a", version=8, storage_plugin=plugin)
        if name == "packed":
            writer.set_compression(CompressionMode.MESSAGE, CompressionFormat.ZSTD)
        with writer:
            topic = writer.add_connection("/imu", KIND, typestore=ros2)
            for ns, message in messages(ros2):
                writer.write(topic, ns, ros2.serialize_cdr(message, KIND))
        shutil.copy(next((Path(folder) / "a").glob("*." + end)), out / f"{name}.{end}")
for name, packing in [("zstd", CompressionType.ZSTD), ("lz4", CompressionType.LZ4)]:
    with open(out / f"{name}.mcap", "wb") as f:
        writer = McapWriter(f, compression=packing, chunk_size=2000)
        writer.start("ros2", "sagnac test")
        schema = writer.register_schema(KIND, "ros2msg", b"")
        topic = writer.register_channel("/imu", "cdr", schema)
        for k, (ns, message) in enumerate(messages(ros2)):
            data = bytes(ros2.serialize_cdr(message, KIND, little_endian=k % 2 == 0))
            writer.add_message(topic, ns, data, ns, k)
        writer.finish()


def ulog():
    def message(kind, body):
        return struct.pack("<HB", len(body), ord(kind)) + body

    fields = "uint64_t timestamp;float[3] gyro_rad;uint32_t gyro_integral_dt;float[3] accelerometer_m_s2;"
    data = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0)
    data += message("B", bytes(40))
    data += message("I", bytes([14]) + b"char[4] sys_hw" + b"test")
    data += message("F", b"sensor_combined:" + fields.encode())
    data += message("A", bytes(1) + struct.pack("<H", 3) + b"sensor_combined")
    for k, (gyro, accel) in enumerate(rows):
        body = struct.pack("<HQ3fI3f", 3, 5000 * k, *gyro, 5000, *accel)
        data += message("D", body)
        if k == 9:
            data += message("O", struct.pack("<H", 12)) + message("S", bytes(8))
    return data


def dataflash():
    def form(kind, length, name, types, labels):
        return b"\xA3\x95\x80" + struct.pack("<BB4s16s64s", kind, length, name, types, labels)

    data = form(128, 89, b"FMT", b"BBnNZ", b"Type,Length,Name,Format,Columns")
    data += form(131, 3 + 8 + 1 + 28, b"IMU", b"QBfffffff", b"TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,T")
    data += form(132, 3 + 8 + 64, b"MSG", b"QZ", b"TimeUS,Message")
    for k, (gyro, accel) in enumerate(rows):
        for instance in range(2):
            data += b"\xA3\x95\x83" + struct.pack("<QB7f", 5000 * k, instance, *gyro, *accel, 25.5)
        if k == 9:
            data += b"\xA3\x95\x84" + struct.pack("<Q64s", 5000 * k, b"hello")
    return data


(out / "small.ulg").write_bytes(ulog())
(out / "small.bin").write_bytes(dataflash())
