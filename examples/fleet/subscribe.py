#!/usr/bin/env python3
"""A fleet from Python: prints estimates as they come, or plots them.    pip install eclipse-zenoh protobuf [matplotlib]

    subscribe.py [--connect tcp/127.0.0.1:7447] [--site '*'] [--machine '*'] [--seconds 10] [--field inertia] [--plot out.png]
"""
import argparse, time
import zenoh
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

p = argparse.ArgumentParser()
for name, default in (("connect", "tcp/127.0.0.1:7447"), ("site", "*"), ("machine", "*"), ("seconds", "10"), ("field", "inertia"), ("plot", "")):
    p.add_argument("--" + name, default=default)
a = p.parse_args()
config = zenoh.Config()
for key, value in {"mode": '"client"', "connect/endpoints": f'["{a.connect}"]', "scouting/multicast/enabled": "false"}.items():
    config.insert_json5(key, value)
classes, lines = {}, {}

def on_sample(sample):
    machine, run, number, after, wall_ms = sample.attachment.to_string().split(" ")
    schema = str(sample.encoding).split(";")[-1]  # heft.ExcavatorEstimate
    message = classes[schema].FromString(bytes(sample.payload))
    lines.setdefault(machine, []).append((int(wall_ms) / 1e3, getattr(message, a.field, float("nan"))))
    print(machine, "run", run, "sample", number, f"t={message.t:.2f} s", f"{a.field}={getattr(message, a.field, None)}")

with zenoh.open(config) as session:
    for reply in session.get(f"heft/v1/{a.site}/{a.machine}/schema/*"):  # the machines tell what their messages mean
        files = descriptor_pb2.FileDescriptorSet.FromString(bytes(reply.ok.payload))
        classes.update(message_factory.GetMessages(files.file, descriptor_pool.DescriptorPool()))
    subscriber = session.declare_subscriber(f"heft/v1/{a.site}/{a.machine}/estimate/*", on_sample)
    time.sleep(float(a.seconds))
if a.plot:
    import matplotlib; matplotlib.use("Agg"); import matplotlib.pyplot as plt
    for machine, points in lines.items(): plt.plot(*zip(*points), ".-", label=machine)
    plt.ylabel(a.field); plt.legend(); plt.savefig(a.plot)
