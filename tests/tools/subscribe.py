#!/usr/bin/env python3
"""Subscribes to a live channel of heft and prints the swing inertia (or the centre of gravity).

    pip install iceoryx2==0.10.0
    heft run excavator --domain demo &
    python3 subscribe.py --domain demo --count 20

A channel is a public interface: a structure of the same type name, size and alignment is all it
takes. The program attaches as one more subscriber and leaves no trace.
"""

import argparse
import ctypes
import os
import pathlib
import sys
import time

import iceoryx2 as iox2


def homes():
    """Where heft keeps the domains of this user (`heft doctor` prints it)."""
    uid = os.getuid()
    runtime = [os.environ.get("XDG_RUNTIME_DIR"), f"/run/user/{uid}"]
    places = [pathlib.Path(r, "heft") for r in runtime if r] + [pathlib.Path(f"/dev/shm/heft-{uid}")]
    return [p for p in dict.fromkeys(places) if p.is_dir() and p.stat().st_uid == uid]


u32, u64, f64 = ctypes.c_uint32, ctypes.c_uint64, ctypes.c_double

# Every message begins with these: which sample, and when each stage published it [ns].
HEAD = [
    ("machine", u32), ("epoch", u32), ("sequence", u64), ("time", f64), ("measured_ns", u64),
    ("sensor_ns", u64), ("filter_ns", u64), ("estimate_ns", u64),
    ("filter_restarts", u32), ("estimate_restarts", u32),
]


class ExcavatorEstimate(ctypes.Structure):
    """SI units; see `heft`'s messages/src/excavator.rs."""

    _fields_ = HEAD + [(name, f64) for name in (
        "inertia", "inertia_std", "damping", "damping_std", "torque", "torque_std",
        "payload", "payload_std", "velocity", "acceleration", "friction", "friction_std",
        "offset", "offset_std", "nis",
        "forgetting_inertia", "forgetting_damping", "forgetting_torque")] + [
        ("flags", u32), ("estimated", u32), ("method", u32), ("reason", u32),
        ("refused", u64), ("reserved_2", u64)]
    TRUSTED = 1 << 8
    CHANNEL = "excavator/inertia_ukf"

    @staticmethod
    def type_name():
        return "ExcavatorEstimate"

    def __str__(self):
        word = "trusted" if self.flags & self.TRUSTED else "not trusted"
        return f"t {self.time:7.2f} s  inertia {self.inertia:7.0f} ± {self.inertia_std:4.0f} kg m²  {word}"


class LoaderEstimate(ctypes.Structure):
    """SI units; see `heft`'s messages/src/loader.rs."""

    _fields_ = HEAD + [(name, f64) for name in (
        "speed", "front_wheel_speed", "rear_wheel_speed", "slip_stiffness", "slip_stiffness_std",
        "cg_height", "cg_height_std", "cg_ratio", "cg_ratio_std", "cg_distance",
        "spade_force_x", "spade_force_x_std", "slope_bias",
        "front_radius_scale", "rear_radius_scale", "nis", "speed_delay", "speed_delay_std")] + [
        ("flags", u32), ("estimated", u32), ("method", u32), ("resets", u32), ("refused", u64),
        ("reason", u32), ("reserved", u32)]
    TRUSTED_RATIO, TRUSTED_HEIGHT = 1 << 8, 1 << 9
    CHANNEL = "loader/cg_ukf"

    @staticmethod
    def type_name():
        return "LoaderEstimate"

    def __str__(self):
        mark = lambda bit: "trusted" if self.flags & bit else "not trusted"
        return (f"t {self.time:7.2f} s  ratio {self.cg_ratio:.4f} ± {self.cg_ratio_std:.4f} {mark(self.TRUSTED_RATIO)}"
                f"  height {self.cg_height:.3f} ± {self.cg_height_std:.3f} m {mark(self.TRUSTED_HEIGHT)}")


PAYLOADS = {"excavator": ExcavatorEstimate, "loader": LoaderEstimate}


def find_domain(name):
    """Folder of the domain, of the only one where no name is given."""
    found = sorted({p.parent for home in homes() for p in home.glob(f"{name or '*'}/iceoryx2.toml")})
    if len(found) != 1:
        sys.exit(f"{len(found)} domains of this user: {found}; name one with --domain")
    return found[0]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--domain", help="of the run; needed where there are several")
    parser.add_argument("--machine", choices=PAYLOADS, default="excavator")
    parser.add_argument("--channel", help="default: that of the state-space filter")
    parser.add_argument("--count", type=int, default=0, help="estimates to print, then end; 0: until interrupted")
    parser.add_argument("--rate", type=float, default=10.0, help="lines a second at most")
    options = parser.parse_args()

    payload = PAYLOADS[options.machine]
    config = find_domain(options.domain) / "iceoryx2.toml"
    if not config.exists():
        sys.exit(f"no run in this domain: {config} is not there")
    # Globally, not only for the node: 0.10.0 cleans up dead nodes with the global configuration.
    iox2.config.setup_global_config_from_file(iox2.FilePath.new(str(config)))
    iox2.set_log_level_from_env_or(iox2.LogLevel.Error)
    node = (iox2.NodeBuilder.new().name(iox2.NodeName.new("subscribe.py"))
            .signal_handling_mode(iox2.SignalHandlingMode.Disabled).create(iox2.ServiceType.Ipc))
    channel = options.channel or payload.CHANNEL
    service = node.service_builder(iox2.ServiceName.new(channel)).publish_subscribe(payload).open()
    subscriber = service.subscriber_builder().create()

    printed, lost, last, shown = 0, 0, None, 0.0
    try:
        while not options.count or printed < options.count:
            sample = subscriber.receive()
            if sample is None:
                time.sleep(0.005)
                continue
            estimate = sample.payload().contents
            if last is not None and estimate.sequence > last:
                lost += estimate.sequence - last - 1
            last = estimate.sequence
            if time.monotonic() - shown >= 1.0 / options.rate:
                shown = time.monotonic()
                printed += 1
                print(estimate, f" lost {lost}", flush=True)
            sample.delete()
    except KeyboardInterrupt:
        pass


if __name__ == "__main__":
    main()
