"""The installed package gives the numbers of the command line, bit for bit."""

import contextlib
import datetime
import os
import pickle
import shutil
import subprocess
import time
import warnings
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


@contextlib.contextmanager
def no_warnings():
    """Every warning is an error, but that nobody described the machine: the tests use the reference machine."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".* is taken for the reference machine", category=heft.HeftWarning)
        yield


def bits(column):
    return np.asarray(column, dtype=float).view("u8")


@pytest.mark.parametrize("machine, file, method", CASES)
def test_a_pandas_frame_gives_the_bits_of_the_command_line(machine, file, method, tmp_path):
    expected = command_line(machine, file, method, tmp_path)
    data = pandas.read_csv(GOLDEN / file, float_precision="round_trip")
    ours = heft.estimate(data, machine, method=method)
    assert list(ours.columns) == list(expected.columns)
    for name in expected.columns:
        if name in ("method", "reason"):
            assert list(ours[name]) == list(expected[name].fillna(""))
            assert ours[name].dtype == "category"
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


def test_what_cannot_be_used_is_reported():
    data = pandas.read_csv(GOLDEN / "excavator_input_base_case2.csv")
    with pytest.raises(heft.HeftError, match="swing_velocity"):
        heft.estimate(data[["t", "swing_torque"]], "excavator")
    with pytest.raises(heft.HeftError, match="rate"):
        heft.estimate(data, "excavator", config={"sensors.ratee": 100})
    with pytest.raises(heft.HeftError, match="nonsense"):
        heft.estimate(data, "excavator", method="nonsense")
    with pytest.raises(heft.HeftError, match="machine"):
        heft.estimate(data, "crane")
    with pytest.raises(heft.HeftError, match="the table has no columns"):
        heft.estimate({}, "excavator")
    with pytest.raises(heft.HeftError, match="give the path of one at least"):
        heft.calibrate("excavator", [], "machine.toml")
    with pytest.raises(heft.HeftError, match="calibrated from files"):
        heft.calibrate("excavator", [data], "machine.toml")


def test_a_row_or_a_column_of_matlab_is_a_column_and_a_matrix_is_none():
    data = pandas.read_csv(GOLDEN / "excavator_input_base_case2.csv")
    expected = heft.estimate(data, "excavator")
    for shape in ((-1, 1), (1, -1)):
        columns = {name: data[name].to_numpy().reshape(shape) for name in data.columns}
        pandas.testing.assert_frame_equal(heft.estimate(columns, "excavator"), expected)
    matrix = {name: np.zeros((10, 2)) for name in data.columns}
    with pytest.raises(heft.HeftError, match="2 dimensions, where each row has one value"):
        heft.estimate(matrix, "excavator")


def test_rows_that_are_too_far_apart_are_spoken_of():
    data = pandas.read_csv(GOLDEN / "machines" / "excavator_1_13t_level.csv")
    with pytest.warns(heft.HeftWarning, match="the rows are 1 s apart: of so few nothing is trusted"):
        heft.estimate(data.iloc[::100], "excavator")


def test_a_machine_that_nobody_described_is_spoken_of(tmp_path):
    table = GOLDEN / "excavator_input_two_swings.csv"
    for data in (table, pandas.read_csv(table)):
        with pytest.warns(heft.HeftWarning, match=r"the excavator is taken for the reference machine of 5.5 t; say .*config="):
            heft.estimate(data, "excavator")
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            heft.estimate(data, "excavator", config={"sensors.rate": 100.0})
    with pytest.warns(heft.HeftWarning, match=r"the loader is taken for the reference machine of 4.7 t"):
        heft.Estimator("loader", signals=["speed", "front_wheel_speed", "rear_wheel_speed", "front_torque", "rear_torque", "slope"])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        heft.Estimator("excavator", signals=["swing_velocity"], config={"sensors.rate": 100.0})


def test_data_in_other_units_are_spoken_of():
    data = pandas.read_csv(GOLDEN / "excavator_input_two_swings.csv")
    with no_warnings():
        heft.estimate(data, "excavator")
    with pytest.warns(heft.HeftWarning, match="is the time in ms"):
        heft.estimate(data.assign(t=1000 * data["t"]), "excavator")
    data = pandas.read_csv(GOLDEN / "excavator_input_constant.csv")
    with pytest.warns(heft.HeftWarning, match="swing_velocity seems to be in deg/s"):
        heft.estimate(data.assign(swing_velocity=np.degrees(data["swing_velocity"])), "excavator")
    data = pandas.read_csv(GOLDEN / "loader_input_S4_tierB.csv")
    with no_warnings():
        heft.estimate(data, "loader")
    with pytest.warns(heft.HeftWarning, match="in km/h"):
        heft.estimate(data.assign(speed=3.6 * data["speed"]), "loader")


def test_signs_are_checked_as_the_command_checks_them():
    t = np.arange(12_000) / 100
    velocity, acceleration = 0.8 * np.sin(t), 0.8 * np.cos(t)
    data = {"t": t, "swing_velocity": velocity, "swing_torque": 7000 * acceleration + 600 * velocity}
    data |= {name: np.full(len(t), x) for name, x in [("boom_angle", 0.8), ("arm_angle", -1.4), ("bucket_angle", -0.6)]}
    with no_warnings():
        heft.estimate(data, "excavator")
    turned = {**data, "swing_velocity": np.where(t < 50, velocity, -velocity)}
    with pytest.warns(heft.HeftWarning, match="changes its sign at about t = 60 s(.|\n)*a frame has no signal map"):
        heft.estimate(turned, "excavator")
    with pytest.warns(heft.HeftWarning, match="boom_angle"):
        heft.estimate({**data, "boom_angle": -data["boom_angle"]}, "excavator")


def test_an_inclinometer_of_a_curled_bucket_may_pass_half_a_turn():
    data = pandas.read_csv(GOLDEN / "excavator_input_two_swings.csv")
    turns = 2 * np.pi * (data.index % 200 < 100)
    expected = heft.estimate(data, "excavator")
    found = heft.estimate(data.assign(bucket_angle=data["bucket_angle"] + turns), "excavator")
    assert expected["trusted"].any() and (found["trusted"] == expected["trusted"]).all()
    assert np.allclose(found["inertia"], expected["inertia"], rtol=1e-9)


def test_what_no_sensor_measures_is_spoken_of():
    frame = pandas.read_csv(GOLDEN / "excavator_input_base_case2.csv")
    frame["swing_torque"] *= 1e6
    with pytest.warns(heft.HeftWarning, match="swing_torque is larger than any measurement in"):
        heft.estimate(frame, "excavator")
    frame["swing_velocity"] = float("nan")
    with pytest.warns(heft.HeftWarning, match="nothing was measured"):
        heft.estimate(frame[["t", "swing_velocity"]], "excavator")
    with pytest.warns(heft.HeftWarning, match="swing_velocity or swing_angle holds no value in any row"):
        heft.estimate(frame, "excavator")


def test_an_error_passes_from_one_process_to_another_and_notes_are_no_warnings():
    error = pickle.loads(pickle.dumps(heft.HeftError("what")))
    assert isinstance(error, heft.HeftError) and str(error) == "what"
    table = GOLDEN / "machines" / "excavator_8_13t_good.csv"
    with pytest.raises(heft.HeftError, match="^the machine is not known"):
        heft.loads(table)
    with no_warnings():
        heft.loads(table, "excavator", config={"machine.operating_mass": 13000})


def test_a_machine_file_that_cannot_be_read_is_named(tmp_path):
    data = pandas.read_csv(GOLDEN / "excavator_input_base_case2.csv")
    files = {"absent.toml": None, "utf16.toml": "[sensors]".encode("utf-16"), "folder": None}
    (tmp_path / "folder").mkdir()
    for name, content in files.items():
        if content is not None:
            (tmp_path / name).write_bytes(content)
        with pytest.raises(heft.HeftError, match=f"{name} cannot be read"):
            heft.estimate(data, "excavator", config=tmp_path / name)


def test_a_table_without_times_and_keys_that_are_none_are_named():
    data = pandas.read_csv(GOLDEN / "excavator_input_base_case2.csv")
    with pytest.raises(heft.HeftError, match="no column t, .* one of zeit, swing_velocity"):
        heft.estimate(data.rename(columns={"t": "zeit"}), "excavator")
    for value in (None, {"rate": 100}):
        with pytest.raises(heft.HeftError, match="sensors cannot be .* keys with dots"):
            heft.estimate(data, "excavator", config={"sensors": value})


def test_missing_values_are_missing_samples():
    data = pandas.read_csv(GOLDEN / "excavator_input_base_case2.csv")
    data["swing_torque"] = data["swing_torque"].astype("Float64")
    data.loc[10:20, "swing_torque"] = pandas.NA
    estimates = heft.estimate(data, "excavator")
    assert len(estimates) == len(data)
    assert np.isfinite(estimates["inertia"]).all()


def test_a_recording_reads_back_with_units(tmp_path):
    # With another machine file than the reference machine's, so that it shows which one is taken.
    run = ["run", "excavator", "--set", "machine.nominal_damping=900", "--duration", "5", "--pace", "max", "--out", str(tmp_path)]
    done = subprocess.run([heft.command(), *run], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    (recording,) = tmp_path.rglob("*.mcap")
    channels = heft.read(recording)
    sensors = channels["excavator/sensors"]
    assert sensors.attrs["units"]["swing_velocity"] == "rad/s"
    # One sensor row, one estimate: the recording replays through `estimate`, with the machine that it brings.
    recorded = channels["excavator/inertia_ukf"]
    renamed = shutil.copy(recording, tmp_path / "monday.bin")
    for again in (sensors, recording, tmp_path, renamed):
        assert (bits(heft.estimate(again, "excavator")["inertia"]) == bits(recorded["inertia"])).all(), again
    assert "[machine]" in channels.attrs["heft.description"]
    changed = heft.estimate(sensors, "excavator", config={"sensors.swing_velocity_std": 0.05})
    assert not (bits(changed["inertia"]) == bits(recorded["inertia"])).all()


def last_large(data):
    """Where the last large block of a recording begins and how long it is: samples, not what lists them, and not the first."""
    at, blocks = 8, []
    while at + 9 < len(data) - 8:
        length = int.from_bytes(data[at + 1 : at + 9], "little")
        blocks.append((at + 9, length))
        at += 9 + length
    large = max(length for _, length in blocks) // 2
    return [block for block in blocks if block[1] > large][-1]


def damaged(whole, folder):
    """Copies of a recording: one byte among its samples changed, and all cut off from there."""
    data = bytearray(whole.read_bytes())
    start, length = last_large(data)
    middle = start + length // 2
    cut = folder / "cut.mcap"
    cut.write_bytes(data[:middle])
    data[middle] ^= 0x40
    flipped = folder / "flipped.mcap"
    flipped.write_bytes(data)
    return flipped, cut


def test_what_a_recording_lacks_is_said(tmp_path):
    run = ["run", "excavator", "--duration", "20", "--pace", "max", "--out", str(tmp_path / "run")]
    subprocess.run([heft.command(), *run], check=True, capture_output=True)
    (whole,) = (tmp_path / "run").rglob("*.mcap")
    with no_warnings():
        complete = heft.read(whole)
        assert complete.attrs["damage"] == []
        everything = len(heft.estimate(whole, "excavator"))
    for file in damaged(whole, tmp_path):
        with pytest.warns(heft.DamageWarning, match="not whole"):
            channels = heft.read(file)
        assert channels.attrs["damage"] and str(file) in channels.attrs["damage"][0]
        sensors = channels["excavator/sensors"]
        assert len(sensors) < len(complete["excavator/sensors"])
        assert sensors.attrs["damage"] == channels.attrs["damage"]
        with pytest.warns(heft.DamageWarning):
            estimates = heft.estimate(file, "excavator")
        assert len(estimates) < everything and estimates.attrs["damage"]


def test_times_of_day_are_seconds_since_the_first():
    data = pandas.read_csv(GOLDEN / "excavator_input_base_case2.csv")
    seconds = data["t"] - data["t"][0]
    expected = heft.estimate(data.assign(t=seconds.round(9)), "excavator")
    for start in (pandas.Timestamp("2026-11-21 16:00"), pandas.Timestamp("2026-11-21 16:00", tz="Europe/Berlin")):
        dated = data.assign(t=start + pandas.to_timedelta((1e9 * seconds).round().astype("int64"), unit="ns"))
        estimates = heft.estimate(dated, "excavator")
        assert np.allclose(estimates["t"], expected["t"], atol=1e-9)
        assert np.allclose(estimates["inertia"], expected["inertia"])
    of_day = [(datetime.datetime(2026, 11, 21, 16) + datetime.timedelta(seconds=s)).time() for s in seconds]
    frame = polars.DataFrame({**{name: data[name].tolist() for name in data.columns}, "t": of_day})
    assert np.allclose(heft.estimate(frame, "excavator")["inertia"], expected["inertia"])
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        with pytest.warns(heft.HeftWarning, match="rows are left out"):
            heft.estimate(data.assign(t=pandas.NaT), "excavator")
    with pytest.raises(heft.HeftError, match="swing_velocity"):
        heft.estimate(data.assign(swing_velocity="fast"), "excavator")


def test_a_running_pipeline_is_followed_live(tmp_path):
    domain = f"python-{os.getpid()}"
    run = ["run", "excavator", "--scenario", "cycle", "--domain", domain, "--quiet", "--no-report", "--out", str(tmp_path / "run")]
    with subprocess.Popen([heft.command(), *run], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as process:
        try:
            got = []
            while len(got) < 50 and process.poll() is None:
                try:
                    for message in heft.subscribe("excavator/inertia_ukf", domain):
                        got.append(message)
                        if len(got) == 50:
                            break
                except heft.HeftError:
                    time.sleep(0.2)  # the pipeline is not up yet
        finally:
            process.terminate()
    assert len(got) == 50
    assert all(later["t"] > earlier["t"] for earlier, later in zip(got, got[1:]))
    assert {"inertia", "inertia_std", "flags"} <= got[0].keys()


def swings(name, payload, folder):
    run = ["run", "excavator", "--scenario", "cycle", "--payload", str(payload), "--duration", "120", "--pace", "max"]
    command = [heft.command(), *run, "--quiet", "--no-report", "--out", str(folder / name)]
    subprocess.run(command, check=True, capture_output=True)
    return folder / name / "run.mcap"


def test_two_recordings_calibrate_a_machine_and_one_of_standstill_does_not(tmp_path):
    empty, loaded = swings("empty", 0, tmp_path), swings("loaded", 400, tmp_path)
    out = tmp_path / "machine.toml"
    told = heft.calibrate("excavator", [empty, loaded], out, payload={empty: "0±2", loaded: "400±4"})
    assert "the gain of the torque" in str(told)
    assert all(p.std > 0 and np.isfinite(p.value) for p in told.values()) and len(told.frame()) == len(told) > 0
    keys = heft.estimate(heft.read(loaded)["excavator/sensors"], "excavator", config=out)
    assert np.isfinite(keys["inertia"]).all()
    out.unlink()
    with pytest.raises(heft.HeftError, match="stands still"):
        heft.calibrate("excavator", [GOLDEN / "excavator_input_base_case2.csv"], out)
    with pytest.raises(heft.HeftError, match="int is no path"):
        heft.calibrate("excavator", [empty], out, payload={3: 0})
    assert not out.exists()
    # Under other names, by a map.
    foreign, map = tmp_path / "foreign.csv", tmp_path / "map.toml"
    pandas.read_csv(GOLDEN / "excavator_input_base_case2.csv").rename(columns={"swing_velocity": "gyro"}).to_csv(foreign)
    map.write_text('[columns]\nswing_velocity = "gyro"\n')
    with pytest.raises(heft.HeftError, match="stands still"):
        heft.calibrate("excavator", [foreign], out, map=map)


def test_loads_are_counted_with_their_intervals_and_a_target(tmp_path):
    loaded = swings("loaded", 400, tmp_path)
    (account,) = heft.loads(loaded, target=5000, pause=0)
    weights = [load["in_bucket"] for load in account["loads"]]
    assert len(weights) == 7 and sum(w["low"] < 400 < w["high"] for w in weights) >= 6
    truck = account["trucks"][0]
    assert truck["remaining"] == pytest.approx(5000 - truck["total"]["kg"])
    wide = {"machine.boom_cylinder.friction_std": 0.1}
    (other,) = heft.loads([loaded], config=wide)
    assert other["loads"][0]["in_bucket"]["std"] != weights[0]["std"]
    with pytest.raises(heft.HeftError, match="machine"):
        heft.loads(GOLDEN / "excavator_input_base_case2.csv")


def test_the_schema_tells_units_and_meanings():
    field = heft.schema()["ExcavatorSensors"]["swing_torque"]
    assert field["unit"] == "N m" and "upper body" in field["meaning"]


def test_a_column_that_is_there_twice_is_named_and_so_is_a_gap_in_the_times():
    data = pandas.read_csv(GOLDEN / "machines" / "excavator_1_13t_level.csv")
    twice = pandas.concat([data, data[["boom_angle"]]], axis=1)
    with pytest.raises(heft.HeftError, match="two columns are called boom_angle"):
        heft.estimate(twice, "excavator")
    late = data.assign(t=data.t.where(data.t < 10, data.t + 3600))
    with pytest.warns(heft.HeftWarning, match="a gap of more than 10 s, the longest of 3600 s"):
        heft.estimate(late, "excavator")


def test_rows_of_two_machines_are_not_mixed_and_loads_are_counted_in_files():
    data = pandas.read_csv(GOLDEN / "machines" / "excavator_1_13t_level.csv")
    mixed = data.assign(machine=["EX1" if k % 2 else "EX2" for k in range(len(data))])
    # Texts of pandas 3 become those of polars by pyarrow, which no user need have.
    columns = {name: mixed[name].tolist() for name in mixed.columns}
    for frame in (mixed, polars.DataFrame(columns).lazy()):
        with pytest.raises(heft.HeftError, match="of 2 machines, EX1 and EX2"):
            heft.estimate(frame, "excavator")
    assert len(heft.estimate(mixed.assign(machine="EX1"), "excavator")) == len(data)
    with pytest.raises(heft.HeftError, match="give its path"):
        heft.loads(data, "excavator")


def test_a_truck_may_be_a_word_as_in_a_table():
    swings = pandas.read_csv(GOLDEN / "excavator_input_two_swings.csv")
    words = ["TRK-12", None, " ", "7", "k.A."]
    kinds = [pandas.Series(words), pandas.Series(words, dtype="string"), pandas.Series(words, dtype="category"), polars.Series(words), words]
    for kind in kinds:
        numbers = heft._labels(kind)
        assert numbers[0] == 636594109.0 and numbers[3] == 7.0, numbers
        assert np.isnan(numbers[[1, 2, 4]]).all(), numbers
    column = ["TRK-%d" % (row // 500) for row in range(len(swings))]
    plain = heft.estimate(swings, "excavator")
    for frame in (swings.assign(truck=column), polars.from_pandas(swings).with_columns(truck=polars.Series(column))):
        with no_warnings():
            named = heft.estimate(frame, "excavator")
        assert len(named) == len(plain)
    with pytest.raises(heft.HeftError, match="boom_angle is not of numbers"):
        heft.estimate(swings.assign(boom_angle="TRK-1"), "excavator")


def test_a_table_of_pyarrow_gives_the_estimates_of_its_frame():
    pyarrow = pytest.importorskip("pyarrow")
    data = pandas.read_csv(GOLDEN / "excavator_input_two_swings.csv")
    assert heft.estimate(pyarrow.Table.from_pandas(data), "excavator").equals(heft.estimate(data, "excavator"))
    one = pyarrow.Table.from_pandas(data).append_column("machine", [["EX1", None] * (len(data) // 2) + ["EX1"] * (len(data) % 2)])
    assert len(heft.estimate(one, "excavator")) == len(data)
    twice = pyarrow.table([[0.0], [1.0], [2.0]], names=["t", "swing_velocity", "swing_velocity"])
    with pytest.raises(heft.HeftError, match="two columns are called swing_velocity"):
        heft.estimate(twice, "excavator")


def test_messages_name_parameters_and_not_options(tmp_path):
    table = tmp_path / "day.csv"
    table.write_text("t,speed\n0,1\n0.01,1\n")

    def said(what):
        with pytest.raises(heft.HeftError) as failed:
            what()
        return str(failed.value)

    golden = GOLDEN / "excavator_input_two_swings.csv"
    messages = {
        "map=; `heft map": lambda: heft.estimate(table, "excavator"),
        'config={"machine.operating_mas": 3.0}': lambda: heft.Estimator(
            "excavator", signals=["swing_velocity"], config={"machine.operating_mas": 3}
        ),
        'add machine="excavator" or machine="loader"': lambda: heft.loads(golden),
        "'-1' for target=": lambda: heft.loads(golden, "excavator", target=-1),
        'payload={"other.csv": "400"}': lambda: heft.calibrate(
            "excavator", [golden], tmp_path / "m.toml", payload={"other.csv": "400"}
        ),
        "mass= is of a loader": lambda: heft.calibrate("excavator", [golden], tmp_path / "m.toml", mass={golden: "400"}),
        'out_and_back=[("a.csv", "b.csv")]': lambda: heft.calibrate(
            "loader", [GOLDEN / "loader_input_S4_tierB.csv"], tmp_path / "m.toml", out_and_back=[("a.csv", "b.csv")]
        ),
        "no pipeline runs": lambda: next(heft.subscribe("excavator/loads", domain="nobody")),
    }
    for words, what in messages.items():
        message = said(what)
        assert words in message, message
        options = message.replace("`heft estimate --help`", "").replace("`heft check FILE --print`", "")
        assert "--" not in options and not message.startswith(("heft: ", "error: ")), message
