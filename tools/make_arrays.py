"""The small MATLAB, HDF5, Parquet and Arrow files of testdata/arrays: one log in every layout that the readers know.

    python tools/make_arrays.py testdata/arrays

Row k of 60: t = 0.01 (k + 1) s, gyr = (k + 1000 j) / 8 (f4), acc = k - 30 j (i2), stamp = 1520530308181901469 + 5e6 k ns.
"""
import sys
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.feather as feather
import pyarrow.parquet as pq
import scipy.io

out = Path(sys.argv[1])
out.mkdir(parents=True, exist_ok=True)
n = 60
k = np.arange(n)
t = 0.01 * (k + 1)
gyr = ((k[:, None] + 1000 * np.arange(3)) / 8).astype("f4")
acc = (k[:, None] - 30 * np.arange(3)).astype("i2")
stamp = (1520530308181901469 + 5_000_000 * k).astype("i8")

flat = dict(t=t, gyr=gyr, acc=acc, stamp=stamp.reshape(-1, 1), rate=100.0, text="hello")
scipy.io.savemat(out / "plain.mat", flat, do_compression=False)
scipy.io.savemat(out / "packed.mat", flat, do_compression=True)
imu = {"t": t, "raw": {"gyr": gyr.T, "acc": acc.T}, "name": "x", "stamp": stamp}
cells = np.array([1, "a"], dtype=object)
for name, packed in [("struct.mat", False), ("struct_packed.mat", True)]:
    scipy.io.savemat(out / name, {"cells": cells, "imu": imu}, do_compression=packed)


def big_endian_mat(path):
    """SciPy writes little-endian files alone."""
    def element(kind, data):
        pad = -len(data) % 8
        return np.array([kind, len(data)], ">u4").tobytes() + data + bytes(pad)

    def matrix(name, array, kind, mx):
        array = np.atleast_2d(array.T).T
        body = element(6, np.array([mx, 0], ">u4").tobytes())
        body += element(5, np.array(array.shape, ">i4").tobytes()) + element(1, name.encode())
        return element(14, body + element(kind, array.astype(array.dtype.newbyteorder(">")).tobytes("F")))

    text = b"MATLAB 5.0 MAT-file, Platform: made by hand".ljust(116) + bytes(8)
    path.write_bytes(
        text + b"\x01\x00MI" + matrix("t", t, 9, 6) + matrix("gyr", gyr, 7, 7)
        + matrix("acc", acc, 3, 10) + matrix("stamp", stamp, 12, 14)
    )


big_endian_mat(out / "big.mat")


def hdf5(name, libver=None, **options):
    with h5py.File(out / name, "w", libver=libver) as f:
        f.create_dataset("t", data=t, **options)
        f.create_dataset("imu/gyr", data=gyr, **options)
        f.create_dataset("imu/acc", data=acc.T, **options)
        f["imu/stamp"] = stamp
        f["moving"] = np.ones(n, bool)
        f["text"] = "hello"


hdf5("contiguous.h5")
hdf5("filters.h5", compression="gzip", shuffle=True, fletcher32=True)
hdf5("fletcher.h5", chunks=True, fletcher32=True)
hdf5("version108.h5", ("v108", "v108"), compression="gzip")
hdf5("latest.h5", ("latest", "latest"), chunks=True)
with h5py.File(out / "odd_chunks.h5", "w") as f:
    f.create_dataset("t", data=t.astype(">f8"), chunks=(7,))
    f.create_dataset("imu/gyr", data=gyr.astype(">f4"), chunks=(11, 2))
    f.create_dataset("imu/acc", data=acc.T.astype(">i2"), chunks=(2, 13), compression="gzip")
    f.create_dataset("imu/stamp", data=stamp, chunks=(60,))
with h5py.File(out / "many_links.h5", "w", track_order=True, libver=("v108", "v108")) as f:
    for i in range(30):
        f[f"further_{i:02}"] = t + i
    f["t"] = t
    for name, value in [("gyr", gyr), ("acc", acc), ("stamp", stamp)]:
        f["imu/" + name] = value

columns = {"t": t}
columns |= {f"gyr_{a}": gyr[:, j] for j, a in enumerate("xyz")}
columns |= {f"acc_{a}": acc[:, j].astype("i4") for j, a in enumerate("xyz")}
table = pa.table(columns | {"stamp": pa.array(stamp).cast(pa.timestamp("ns")), "text": ["x"] * n})
for name, options in [
    ("snappy.parquet", {}),
    ("zstd.parquet", dict(compression="zstd", row_group_size=17, use_dictionary=False)),
    ("gzip_v2.parquet", dict(compression="gzip", data_page_version="2.0", use_dictionary=False,
                             column_encoding={"t": "BYTE_STREAM_SPLIT", "stamp": "DELTA_BINARY_PACKED"})),
    ("checked.parquet", dict(compression="none", use_dictionary=False, write_page_checksum=True)),
    ("brotli.parquet", dict(compression="brotli")),
]:
    pq.write_table(table, out / name, **options)

# Before the numbers stand columns that are none, of every number of buffers.
odd = dict(
    word=pa.array(["x"] * n), many=pa.array([[1, 2]] * n), kind=pa.array(["a", "b"] * (n // 2)).dictionary_encode(),
    nothing=pa.nulls(n), view=pa.array(["longer than twelve bytes"] * n, pa.string_view()),
    pair=pa.array([[1.0, 2.0]] * n, pa.list_(pa.float64(), 2)))
feather.write_feather(table, out / "plain.arrow", compression="uncompressed")
feather.write_feather(table, out / "lz4.arrow", compression="lz4", chunksize=17)
mixed = pa.table(odd | {c: table[c] for c in table.column_names})
with pa.ipc.new_stream(out / "zstd.arrows", mixed.schema, options=pa.ipc.IpcWriteOptions(compression="zstd")) as f:
    f.write_table(mixed, max_chunksize=23)
parts = {c: table[c].combine_chunks() for c in table.column_names if c != "t"}
parts["gyr_x"] = pa.array(gyr[:, 0], mask=k % 7 == 3)
imu = pa.StructArray.from_arrays(list(parts.values()), list(parts), mask=pa.array(k % 11 == 5))
nested = pa.table({"imu": imu, "t": t})
with pa.ipc.new_file(out / "nested.arrow", nested.schema) as f:
    f.write_table(nested)

# Numbers of two bytes, and three of a row as a list of its own length, one of them null, one a row of none.
half = {f"gyr_{a}": pa.array((gyr[:, j] / 8).astype("f2")) for j, a in enumerate("xyz")}
lists = pa.FixedSizeListArray.from_arrays(pa.array(gyr.ravel(), mask=np.arange(3 * n) == 13), 3, mask=pa.array(k == 9))
small = pa.table({"time": t, "word": pa.array(["x"] * n), "gyr": lists} | half)
feather.write_feather(small, out / "lists.arrow", compression="lz4", chunksize=17)
pq.write_table(small, out / "lists.parquet")
