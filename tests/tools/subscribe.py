#!/usr/bin/env python3
"""Subscribes to a live channel of heft and prints the swing inertia (or the centre of gravity).

    pip install iceoryx2==0.10.0
    heft run excavator --domain demo &
    python3 subscribe.py --domain demo --count 20

A channel is a public interface: a structure of the same type name, size and alignment is all it
takes. The program attaches as one more subscriber and leaves no trace.
"""

import argparse
import os
import pathlib
import subprocess
import sys
import time
import types

import iceoryx2 as iox2


def homes():
    """Where heft keeps the domains of this user (`heft doctor` prints it)."""
    uid = os.getuid()
    runtime = [os.environ.get("XDG_RUNTIME_DIR"), f"/run/user/{uid}"]
    places = [pathlib.Path(r, "heft") for r in runtime if r] + [pathlib.Path(f"/dev/shm/heft-{uid}")]
    return [p for p in dict.fromkeys(places) if p.is_dir() and p.stat().st_uid == uid]


def messages(heft):
    """The structures of the messages, as this heft declares them: no copy that could grow old."""
    text = subprocess.run([heft, "schema", "--lang", "python"], check=True, capture_output=True, text=True).stdout
    module = types.ModuleType("heft_messages")
    exec(text, module.__dict__)
    return module


def excavator(e):
    word = "trusted" if e.flags & 1 << 8 else "not trusted"
    return f"inertia {e.inertia:7.0f} ± {e.inertia_std:4.0f} kg m²  {word}"


def loader(e):
    mark = lambda bit: "trusted" if e.flags & 1 << bit else "not trusted"
    return (f"ratio {e.cg_ratio:.4f} ± {e.cg_ratio_std:.4f} {mark(8)}"
            f"  height {e.cg_height:.3f} ± {e.cg_height_std:.3f} m {mark(9)}")


def anything(message):
    return "  ".join(f"{name} {getattr(message, name):g}" for name, _ in message._fields_[10:])


SHOWN = {"ExcavatorEstimate": excavator, "LoaderEstimate": loader}
CHANNEL = {"excavator": "excavator/inertia_ukf", "loader": "loader/cg_ukf"}


def find_domain(name):
    """Folder of the domain, of the only one where no name is given."""
    found = sorted({p.parent for home in homes() for p in home.glob(f"{name or '*'}/iceoryx2.toml")})
    if len(found) != 1:
        sys.exit(f"{len(found)} domains of this user: {found}; name one with --domain")
    return found[0]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--domain", help="of the run; needed where there are several")
    parser.add_argument("--machine", choices=CHANNEL, default="excavator")
    parser.add_argument("--heft", default="heft", help="the program; it declares the structures")
    parser.add_argument("--channel", help="default: that of the state-space filter")
    parser.add_argument("--count", type=int, default=0, help="estimates to print, then end; 0: until interrupted")
    parser.add_argument("--rate", type=float, default=10.0, help="lines a second at most")
    options = parser.parse_args()

    channel = options.channel or CHANNEL[options.machine]
    payload = messages(options.heft).CHANNELS[channel]
    show = SHOWN.get(payload.__name__, anything)
    config = find_domain(options.domain) / "iceoryx2.toml"
    if not config.exists():
        sys.exit(f"no run in this domain: {config} is not there")
    # Globally, not only for the node: 0.10.0 cleans up dead nodes with the global configuration.
    iox2.config.setup_global_config_from_file(iox2.FilePath.new(str(config)))
    iox2.set_log_level_from_env_or(iox2.LogLevel.Error)
    node = (iox2.NodeBuilder.new().name(iox2.NodeName.new("subscribe.py"))
            .signal_handling_mode(iox2.SignalHandlingMode.Disabled).create(iox2.ServiceType.Ipc))
    service = node.service_builder(iox2.ServiceName.new(channel)).publish_subscribe(payload).open()
    # Without this word the latest samples of before come first: their writers hold them for a logger that is started again.
    subscriber = service.subscriber_builder().history_request(0).create()

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
                simulated = " simulated" if getattr(estimate, "flags", 0) & 1 << 31 else ""
                print(f"t {estimate.t:7.2f} s  {show(estimate)}{simulated}  lost {lost}", flush=True)
            sample.delete()
    except KeyboardInterrupt:
        pass


if __name__ == "__main__":
    main()
