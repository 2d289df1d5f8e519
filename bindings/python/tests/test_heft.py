"""The installed package gives the numbers of the command line, bit for bit."""

import subprocess
from pathlib import Path

import heft
import numpy as np
import pandas
import polars
import pytest

GOLDEN = Path(__file__).resolve().parents[3] / "tests" / "golden"
CASES = [
    ("excavator", "excavator_input_base_case2.csv", None),
    ("excavator", "excavator_input_bad.csv", None),
    ("excavator", "excavator_input_base_case2.csv", "svf-rls"),
    ("loader", "loader_input_S4_tierB.csv", None),
    ("loader", "loader_input_bad_20s.csv", "ekf"),
]


def command_line(machine, file, method, folder, *more):
    out = folder / "out.csv"
    arguments = [heft.command(), "estimate", str(GOLDEN / file), "--machine", machine, "-o", str(out), *more]
    subprocess.run(arguments + (["--method", method] if method else []), check=True, capture_output=True)
    return pandas.read_csv(out, float_precision="round_trip")


def bits(column):
    return np.asarray(column, dtype=float).view("u8")


@pytest.mark.parametrize("machine, file, method", CASES)
def test_a_pandas_frame_gives_the_bits_of_the_command_line(machine, file, method, tmp_path):
    expected = command_line(machine, file, method, tmp_path)
    data = pandas.read_csv(GOLDEN / file, float_precision="round_trip")
    ours = heft.estimate(data, machine, method=method)
    assert list(ours.columns) == list(expected.columns)
    for name in expected.columns:
        if name == "method":
            assert list(ours[name]) == list(expected[name])
        else:
            assert (bits(ours[name]) == bits(expected[name])).all(), name
    assert ours.attrs["units"]["t"] == "s"


def test_polars_and_mappings_give_what_pandas_gives():
    file = GOLDEN / "excavator_input_bad.csv"
    data = pandas.read_csv(file, float_precision="round_trip")
    expected = heft.estimate(data, "excavator")
    frame = heft.estimate(polars.from_pandas(data), "excavator")
    assert isinstance(frame, polars.DataFrame)
    mapping = heft.estimate({name: data[name].to_numpy() for name in data.columns}, "excavator")
    for name in ("inertia", "payload_std"):
        assert (bits(frame[name].fill_null(float("nan")).to_numpy()) == bits(expected[name])).all()
        assert (bits(mapping[name]) == bits(expected[name])).all()


def test_a_description_is_a_file_or_keys(tmp_path):
    data = pandas.read_csv(GOLDEN / "excavator_input_base_case2.csv")
    file = tmp_path / "machine.toml"
    file.write_text("[sensors]\nswing_velocity_std = 0.008\n")
    keys = heft.estimate(data, "excavator", config={"sensors.swing_velocity_std": 0.008})
    assert keys.equals(heft.estimate(data, "excavator", config=file))
    assert not keys.equals(heft.estimate(data, "excavator"))


def test_what_cannot_be_used_is_told():
    data = pandas.read_csv(GOLDEN / "excavator_input_base_case2.csv")
    with pytest.raises(heft.HeftError, match="swing_velocity"):
        heft.estimate(data[["t", "swing_torque"]], "excavator")
    with pytest.raises(heft.HeftError, match="rate"):
        heft.estimate(data, "excavator", config={"sensors.ratee": 100})
    with pytest.raises(heft.HeftError, match="nonsense"):
        heft.estimate(data, "excavator", method="nonsense")
    with pytest.raises(heft.HeftError, match="machine"):
        heft.estimate(data, "crane")


def test_missing_values_are_missing_samples():
    data = pandas.read_csv(GOLDEN / "excavator_input_base_case2.csv")
    data["swing_torque"] = data["swing_torque"].astype("Float64")
    data.loc[10:20, "swing_torque"] = pandas.NA
    estimates = heft.estimate(data, "excavator")
    assert len(estimates) == len(data)
    assert np.isfinite(estimates["inertia"]).all()


def test_a_recording_reads_back_with_units(tmp_path):
    run = ["run", "excavator", "--duration", "5", "--pace", "max", "--out", str(tmp_path)]
    done = subprocess.run([heft.command(), *run], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    (recording,) = tmp_path.rglob("*.mcap")
    channels = heft.read(recording)
    sensors = channels["excavator/sensors"]
    assert sensors.attrs["units"]["swing_velocity"] == "rad/s"
    # One sensor row, one estimate: the recording replays through `estimate`.
    again = heft.estimate(sensors, "excavator")
    recorded = channels["excavator/inertia_ukf"]
    assert (bits(again["inertia"]) == bits(recorded["inertia"])).all()


def test_the_schema_tells_units_and_meanings():
    field = heft.schema()["ExcavatorSensors"]["swing_torque"]
    assert field["unit"] == "N m" and "upper body" in field["meaning"]
