#!/usr/bin/env python3
"""Makes the MCAP files of this folder with the libraries that others use (pip install mcap mcap-ros2-support protobuf).

An excavator swings with velocity 0.5 sin t and torque 1000 cos t for 4 s; the swing is the second of two joints.
"""
import json
import math
from pathlib import Path

from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from mcap.writer import CompressionType, Writer
from mcap_ros2.writer import Writer as RosWriter

HERE = Path(__file__).resolve().parent
START = 1_700_000_000_000_000_000
LINE = "=" * 80
JOINTS = f"""std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
{LINE}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{LINE}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
PRESSURE = f"""std_msgs/Header header   # stamp of the measurement
float64 fluid_pressure
float64 variance
{LINE}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{LINE}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""


def rows():
    for i in range(400):
        t = i / 100
        yield t, START + i * 10_000_000, 0.5 * math.sin(t), 1000 * math.cos(t)


def header(time):
    return {"stamp": {"sec": time // 10**9, "nanosec": time % 10**9}, "frame_id": "base"}


def ros(name, compression):
    with open(HERE / name, "wb") as out:
        writer = RosWriter(out, chunk_size=8192, compression=compression)
        joints = writer.register_msgdef("sensor_msgs/msg/JointState", JOINTS)
        pressure = writer.register_msgdef("sensor_msgs/msg/FluidPressure", PRESSURE)
        for t, time, velocity, torque in rows():
            message = {"name": ["boom", "swing_joint"], "position": [], "velocity": [9.0, velocity], "effort": []}
            # Recorded 20 ms after it was measured.
            writer.write_message("/joint_states", joints, {"header": header(time), **message}, time + 20_000_000, time)
            message = {"header": header(time), "fluid_pressure": torque * 100, "variance": 0.0}
            writer.write_message("/swing/pressure", pressure, message, time + 20_000_000, time)
        writer.finish()


def as_json(name):
    with open(HERE / name, "wb") as out:
        writer = Writer(out, compression=CompressionType.LZ4)
        writer.start(profile="", library="make.py")
        schema = writer.register_schema("Drive", "jsonschema", b'{"type": "object"}')
        channel = writer.register_channel("/drive", "json", schema)
        for t, time, velocity, torque in rows():
            data = {"swing": {"rate_deg": math.degrees(velocity), "torques": [0, torque]}, "note": "\u00e4"}
            writer.add_message(channel, time, json.dumps(data).encode(), time)
        writer.finish()


def as_protobuf(name, use_chunking):
    file = descriptor_pb2.FileDescriptorProto(name="drive.proto", package="acme", syntax="proto3")
    inner = file.message_type.add(name="Vector")
    inner.field.add(name="z", number=7, type=1, label=1)
    message = file.message_type.add(name="Drive")
    message.field.add(name="rate", number=1, type=2, label=1)
    message.field.add(name="torque", number=2, type=11, label=1, type_name=".acme.Vector")
    files = descriptor_pb2.FileDescriptorSet(file=[file])
    pool = descriptor_pool.DescriptorPool()
    pool.Add(file)
    drive = message_factory.GetMessageClass(pool.FindMessageTypeByName("acme.Drive"))
    with open(HERE / name, "wb") as out:
        writer = Writer(out, use_chunking=use_chunking)
        writer.start()
        schema = writer.register_schema("acme.Drive", "protobuf", files.SerializeToString())
        channel = writer.register_channel("/drive", "protobuf", schema)
        for t, time, velocity, torque in rows():
            m = drive(rate=velocity)
            m.torque.z = torque
            writer.add_message(channel, time, m.SerializeToString(), time)
        writer.finish()


ros("ros2.zstd.mcap", CompressionType.ZSTD)
as_json("json.lz4.mcap")
as_protobuf("protobuf.plain.mcap", False)
