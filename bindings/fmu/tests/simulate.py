"""FMPy finds nothing wrong with the FMUs, and golden data through them give the bits of `heft estimate`:
simulate.py FOLDER-OF-FMUS HEFT. Needs fmpy, numpy."""

import csv
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

GOLDEN = Path(__file__).resolve().parents[3] / "tests" / "golden"
CASES = [
    ("excavator", "excavator_input_base_case2.csv"),
    ("excavator", "excavator_input_bad.csv"),
    ("loader", "loader_input_S4_tierB.csv"),
]


def rows(file):
    with open(file, newline="") as text:
        return [{k: float(v) if v else float("nan") for k, v in row.items() if k not in ("method", "reason")} for row in csv.DictReader(text)]


def command_line(heft, machine, file, folder):
    out = Path(folder) / "out.csv"
    subprocess.run([heft, "estimate", GOLDEN / file, "--machine", machine, "-o", out], check=True, capture_output=True)
    return {row["t"]: row for row in rows(out)}


def step_by_step(fmu, machine, data, expected, folder):
    """The same times as in the file, which a fixed step could not give to the last bit."""
    description = read_model_description(fmu)
    by_name = {v.name: v for v in description.modelVariables}
    unpacked = extract(fmu, unzipdir=folder)
    instance = FMU3Slave(
        guid=description.guid,
        unzipDirectory=unpacked,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName=machine,
    )
    instance.instantiate()
    inputs = [name for name in data[0] if name in by_name and not name.startswith("true_") and name != "t"]
    instance.setBoolean([by_name["has." + name].valueReference for name in inputs], [True] * len(inputs))
    instance.enterInitializationMode(startTime=data[0]["t"])
    instance.exitInitializationMode()
    references = [by_name[name].valueReference for name in inputs]
    outputs = {name[9:]: v.valueReference for name, v in by_name.items() if name.startswith("estimate.") and v.type == "Float64"}
    verdicts = {name[8:]: v.valueReference for name, v in by_name.items() if name.startswith("verdict.")}
    compared = 0
    for row, after in zip(data, data[1:] + [data[-1]]):
        if not np.isfinite(row["t"]):
            continue
        length = after["t"] - row["t"]
        instance.setFloat64(references, [row[name] for name in inputs])
        instance.doStep(row["t"], length if length > 0 else 0.01)
        values = dict(zip(outputs, instance.getFloat64(list(outputs.values()))))
        flags = dict(zip(verdicts, instance.getBoolean(list(verdicts.values()))))
        assert all(np.isfinite(list(values.values())))
        if flags["refused"]:
            continue
        for name, value in expected[row["t"]].items():
            if name in values and np.isfinite(value):
                assert values[name] == value, (row["t"], name, values[name], value)
                compared += 1
            elif name in flags:
                assert flags[name] == bool(value), (row["t"], name)
                compared += 1
    instance.terminate()
    instance.freeInstance()
    return compared


def main():
    folder, heft = Path(sys.argv[1]), sys.argv[2]
    for machine in ("excavator", "loader"):
        problems = validate_fmu(str(folder / f"heft_{machine}.fmu"))
        assert not problems, problems
        print(f"heft_{machine}.fmu: FMPy finds no problem")
    for machine, file in CASES:
        fmu = str(folder / f"heft_{machine}.fmu")
        with tempfile.TemporaryDirectory() as scratch:
            expected = command_line(heft, machine, file, scratch)
            compared = step_by_step(fmu, machine, rows(GOLDEN / file), expected, scratch)
        assert compared > 10 * len(expected)
        print(f"{file}: {len(expected)} rows, {compared} numbers and flags with the bits of the command line")
    # As a user simulates: inputs from a table, a fixed step, named outputs.
    # One swing with an uncalibrated torque is not enough.
    data = rows(GOLDEN / "excavator_input_two_swings.csv")
    names = ["swing_velocity", "swing_torque", "boom_angle", "arm_angle", "bucket_angle"]
    table = np.array([tuple([row["t"]] + [row[n] for n in names]) for row in data], dtype=[(n, float) for n in ["time"] + names])
    result = simulate_fmu(
        str(folder / "heft_excavator.fmu"),
        start_time=data[0]["t"],
        stop_time=data[-1]["t"],
        output_interval=0.01,
        input=table,
        start_values={f"has.{n}": True for n in names} | {"prior.payload_std": 200.0},
        output=["estimate.inertia", "estimate.payload", "verdict.trusted"],
    )
    assert np.isfinite(result["estimate.inertia"]).all() and result["verdict.trusted"].any()
    print(f"simulate_fmu: {len(result)} rows, trusted in {int(result['verdict.trusted'].sum())}")


if __name__ == "__main__":
    main()
