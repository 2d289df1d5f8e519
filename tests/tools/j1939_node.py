#!/usr/bin/env python3
"""heft on a bus beside nodes of can-j1939: tests/tools/with-can python3 tests/tools/j1939_node.py HEFT [INTERFACE]

Needs pip install can-j1939. Status 0 and "ok" if heft claims before it speaks, defends its address against a weaker NAME,
answers requests, makes way for a stronger NAME, and is silent where it may not choose another address.
"""

import subprocess
import sys
import tempfile
import time

import can
import j1939

HEFT, BUS = sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else "vcan1"
CLAIM, OWN = 0xEE, 0x80


def name(identity, arbitrary):
    return j1939.Name(
        arbitrary_address_capable=arbitrary,
        industry_group=j1939.Name.IndustryGroup.Construction,
        vehicle_system=127,
        function=255,
        manufacturer_code=2047 if arbitrary else 1,
        identity_number=identity,
    )


class Heard(can.Listener):
    def __init__(self):
        self.frames = []

    def on_message_received(self, m):
        self.frames.append((time.monotonic(), m.arbitration_id, bytes(m.data)))

    def since(self, start, source, format=None):
        """Frames from an address since then, of a PDU format or of proprietary B."""
        wanted = 0xFF if format is None else format
        return [f for f in self.frames if f[0] >= start and f[1] & 0xFF == source and f[1] >> 16 & 0xFF == wanted]


def ca(identity, arbitrary):
    ecu = j1939.ElectronicControlUnit()
    ecu.connect(interface="socketcan", channel=BUS)
    application = ecu.add_ca(name=name(identity, arbitrary), device_address=OWN)
    application.start()
    return ecu, application


def main():
    bus = can.Bus(interface="socketcan", channel=BUS)
    heard = Heard()
    notifier = can.Notifier(bus, [heard])
    with tempfile.TemporaryDirectory() as folder:
        run = [HEFT, "run", "excavator", "--output", f"can:{BUS}", "--duration", "40", "--out", f"{folder}/run"]
        heft = subprocess.Popen([*run, "--quiet", "--no-report"], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        try:
            while not heard.since(0, OWN):
                assert heft.poll() is None, heft.stderr.read()
                time.sleep(0.1)
            claim, first = heard.since(0, OWN, CLAIM)[0], heard.since(0, OWN)[0]
            assert first[0] - claim[0] >= 0.24, "data 250 ms after the claim"

            print("a weaker node wants the address", flush=True)
            before = time.monotonic()
            weak, application = ca(2**21 - 1, 1)
            time.sleep(2)
            assert len(heard.since(before, OWN, CLAIM)) >= 2, "its claim and the answer"
            assert application.device_address != OWN or application.state != j1939.ControllerApplication.State.NORMAL
            assert heard.since(time.monotonic() - 0.5, OWN), "heft goes on"
            weak.disconnect()

            print("somebody asks", flush=True)
            before = time.monotonic()
            for data in ([0x00, 0xEE, 0x00], [0xEB, 0xFE, 0x00]):
                bus.send(can.Message(arbitration_id=0x18EA8001, data=data))
            time.sleep(1)
            assert heard.since(before, OWN, CLAIM), "the claim, asked for"
            refused = heard.since(before, OWN, 0xE8)
            assert refused and refused[0][2] == bytes([1, 255, 255, 255, 1, 0xEB, 0xFE, 0]), refused

            print("a stronger node wants the address", flush=True)
            before = time.monotonic()
            strong, application = ca(1, 0)
            time.sleep(3)
            # By its NAME: the weaker node may sit on the address beside.
            claims = [f for f in heard.frames if f[0] >= before and f[1] >> 16 & 0xFF == CLAIM and f[2] == claim[2]]
            moved = [f for f in claims if f[1] & 0xFF not in (OWN, 0xFE)]
            assert moved, "a claim to another address"
            late = [f for f in heard.since(before, OWN) if f[0] > moved[0][0]]
            assert not late, f"{len(late)} frames from the address that was lost"
            began = heard.since(before, moved[0][1] & 0xFF)
            assert began and began[0][0] - moved[0][0] >= 0.24, "data from the new address, 250 ms later"
            assert application.state == j1939.ControllerApplication.State.NORMAL
            strong.disconnect()
        finally:
            heft.terminate()
            heft.wait()
            notifier.stop()
    bus.shutdown()
    fixed()
    print("ok")


def fixed():
    """A node that may not choose: "cannot claim", and nothing but that."""
    print("a node without a choice", flush=True)
    bus = can.Bus(interface="socketcan", channel=BUS)
    heard = Heard()
    notifier = can.Notifier(bus, [heard])
    strong, _ = ca(1, 0)
    time.sleep(1)
    begun = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        with open(f"{folder}/out.toml", "w") as out:
            out.write("[can]\n[can.name]\narbitrary_address = false\n")
        run = [HEFT, "run", "excavator", "--output", f"can:{BUS}", "--output-map", f"{folder}/out.toml"]
        run += ["--duration", "8", "--out", f"{folder}/run", "--quiet", "--no-report"]
        heft = subprocess.run(run, capture_output=True, text=True)
    assert heft.returncode == 0 and "nothing is sent" in heft.stderr, heft.stderr
    assert heard.since(begun, 0xFE, CLAIM), "cannot claim"
    data = [f for f in heard.frames if f[0] >= begun and f[1] >> 16 & 0xFF == 0xFF]
    assert not data, f"{len(data)} frames without an address"
    strong.disconnect()
    notifier.stop()
    bus.shutdown()


main()
