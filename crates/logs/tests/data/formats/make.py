"""Writes the logs beside it: the numbers of ../energy_shaping.csv in every format, and files that no reader may believe.

    pip install numpy scipy h5py pyarrow mcap lz4 zstandard && python make.py
"""

import csv
import json
import struct
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet
import scipy.io
from mcap.writer import CompressionType, Writer

here = Path(__file__).parent
with open(here.parent / "energy_shaping.csv") as file:
    header, *rows = csv.reader(file)
rows = np.array(rows, float)
columns = dict(zip(header, rows.T))
rate = {"fs": np.float64(200.0), "robot": np.array("pendulum")}

# Good ones.
np.savez(here / "log.npz", **columns, **rate)
np.savez_compressed(here / "packed.npz", **columns)
np.save(here / "record.npy", np.array([tuple(r) for r in rows], dtype=[(name, "<f8") for name in header]))
np.save(here / "matrix.npy", rows)
np.savez(here / "short-input.npz", **{k: v[:-1] if k == "torque" else v for k, v in columns.items()})
np.savez(here / "across.npz", time=columns["time"], q=rows[:, 1:3].T, u=np.asfortranarray(rows[:, 3:4]))
np.savez(here / "big-endian.npz", **{k: v.astype(">f8") for k, v in columns.items()})
scipy.io.savemat(here / "log.mat", columns, do_compression=True)
scipy.io.savemat(here / "struct.mat", {"data": columns, "note": "a struct", "fs": 200.0})


def mat73(path, content):
    """As MATLAB 7.3 writes it: HDF5 after 512 bytes, sizes turned round."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in content.items():
            file.create_dataset(name, data=np.asarray(values).reshape(1, -1))
    with open(path, "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116) + bytes(8) + b"\x00\x02IM")


mat73(here / "v73.mat", columns)
with h5py.File(here / "log.h5", "w") as file:
    for name, values in columns.items():
        file.create_dataset(f"run/{name}", data=values, compression="gzip", chunks=(16,))
pa.parquet.write_table(pa.table(columns), here / "log.parquet", compression="snappy")
lists = pa.array(rows[:, 1:3].tolist(), pa.list_(pa.float64()))
pa.parquet.write_table(pa.table({"time": columns["time"], "q": lists, "u": columns["torque"]}), here / "lists.parquet", compression="zstd")


def cdr(stamp, position, velocity, effort):
    """A sensor_msgs/JointState with one joint."""
    body = bytearray()

    def put(value, align):
        body.extend(bytes(-len(body) % align))
        body.extend(value)

    put(struct.pack("<iI", *divmod(stamp, 10**9)), 4)
    put(struct.pack("<I", 1) + b"\0", 4)
    put(struct.pack("<I", 1), 4)
    put(struct.pack("<I", 4) + b"rod\0", 4)
    for value in (position, velocity, effort):
        put(struct.pack("<I", 1), 4)
        put(struct.pack("<d", value), 8)
    return b"\0\1\0\0" + bytes(body)


def mcap(path, compression, encodings):
    with open(path, "wb") as file:
        writer = Writer(file, compression=compression, chunk_size=2048)
        writer.start()
        schema = writer.register_schema("sensor_msgs/msg/JointState", "ros2msg", b"")
        plain = writer.register_schema("state", "jsonschema", b"{}")
        other = writer.register_schema("std_msgs/msg/String", "ros2msg", b"")
        channels = {"cdr": writer.register_channel("/joint_states", "cdr", schema), "json": writer.register_channel("/state", "json", plain)}
        chatter = writer.register_channel("/chatter", "cdr", other)
        for i, row in enumerate(rows):
            stamp = round(row[0] * 1e9)
            log_time = 1_760_000_000_000_000_000 + stamp
            if "cdr" in encodings:
                writer.add_message(channels["cdr"], log_time, cdr(stamp, *row[1:]), log_time, i)
            if "json" in encodings:
                said = json.dumps(dict(zip(header, row)) | {"mode": "swing"}).encode()
                writer.add_message(channels["json"], log_time, said, log_time, i)
            writer.add_message(chatter, log_time, b"\0\1\0\0\3\0\0\0hi\0", log_time, i)
        writer.finish()


mcap(here / "joints.mcap", CompressionType.ZSTD, ["cdr"])
mcap(here / "joints-lz4.mcap", CompressionType.LZ4, ["cdr"])
mcap(here / "state.mcap", CompressionType.NONE, ["json"])
mcap(here / "both.mcap", CompressionType.ZSTD, ["cdr", "json"])
mcap(here / "chatter.mcap", CompressionType.NONE, [])

# Bad ones.
np.save(here / "objects.npy", np.array([{"a": 1}], object), allow_pickle=True)
np.savez(here / "objects.npz", a=np.array([{"a": 1}], object))
np.savez(here / "empty.npz")
np.savez(here / "nan.npz", time=columns["time"], position=np.full(60, np.nan))
np.savez(here / "infinite.npz", **{k: np.where(np.arange(60) == 7, np.inf, v) if k == "velocity" else v for k, v in columns.items()})
np.savez(here / "deep.npz", q=np.zeros((4, 5, 6)), fs=200.0)


def npy(shape, data):
    text = repr({"descr": "<f8", "fortran_order": False, "shape": shape}).encode() + b"\n"
    return b"\x93NUMPY\1\0" + struct.pack("<H", len(text)) + text + data


(here / "huge.npy").write_bytes(npy((10**12,), bytes(16)))
(here / "no-archive.npz").write_bytes(b"time,position\n0,1\n")
