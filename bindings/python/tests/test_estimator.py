"""Sample by sample the numbers are those of the whole table, and a state goes on bit for bit."""

import copy
import importlib.util
import pickle
import subprocess
import sys
from pathlib import Path

import heft
import numpy as np
import pandas
import polars
import pytest

HERE = Path(__file__).resolve().parent
GOLDEN = HERE.parents[2] / "tests" / "golden"
CASES = [
    ("excavator", "excavator_input_base_case2.csv", None),
    ("excavator", "excavator_input_base_case2.csv", "svf-rls"),
    ("loader", "loader_input_S4_tierB.csv", None),
]


def bits(values):
    return np.asarray(values, dtype=float).view("u8")


def signals_of(data, machine):
    known = heft._heft.signals(machine)
    return [name for name in data.columns if name in known and name != "t" and not name.startswith("true_")]


def samples(data, names):
    for t, *values in data[["t", *names]].itertuples(index=False):
        yield t, dict(zip(names, values))


@pytest.mark.parametrize("machine, file, method", CASES)
def test_steps_give_the_bits_of_the_table_also_through_a_state(machine, file, method):
    data = pandas.read_csv(GOLDEN / file, float_precision="round_trip")
    data = data[:3000]
    names = signals_of(data, machine)
    names = [name for name in names if data[name][:100].notna().any()]
    expected = heft.estimate(data[["t", *names]], machine, method=method)
    estimator = heft.Estimator(machine, signals=names, method=method)
    rows = []
    for i, (t, values) in enumerate(samples(data, names)):
        if i == 1234:
            estimator = heft.Estimator.from_state(estimator.state())
        rows.append(estimator.step(t, **values))
    steps = pandas.DataFrame(rows)
    assert not steps.refused.any()
    for name in expected.columns:
        if name in ("method", "reason"):
            assert list(steps[name]) == list(expected[name])
        else:
            assert (bits(steps[name]) == bits(expected[name])).all(), name


def estimator():
    return heft.Estimator("excavator", signals=["swing_velocity", "swing_torque"])


def test_an_estimate_has_verdict_reason_and_interval():
    one = estimator()
    first = one.step(0.0, swing_velocity=0.1, swing_torque=5e3)
    assert isinstance(first, heft.ExcavatorEstimate) and first.trusted is False
    low, high = first.interval()
    assert low < first.inertia < high and np.isclose(high - low, 2 * 1.959964 * first.inertia_std)
    assert first.units["inertia"] == "kg m^2"
    assert one.step(0.0, swing_velocity=0.1).refused, "the time does not increase"
    assert not one.step(0.01, swing_torque=None).refused
    with pytest.raises(heft.HeftError, match="interval"):
        first.interval("trusted")


def test_why_names_all_that_keeps_an_estimate_from_being_trusted():
    rows = {}
    for machine in ("excavator", "loader"):
        columns = heft._heft.header(machine)
        kinds = {"float": 0.0, "bool": False, "method": "", "reason": ""}
        of = heft.ExcavatorEstimate if machine == "excavator" else heft.LoaderEstimate
        row = of(*(kinds[kind] for _, _, kind in columns))
        verdicts = ("trusted",) if machine == "excavator" else ("trusted_ratio", "trusted_height")
        rows[machine] = row._replace(**dict.fromkeys(verdicts, True))
    needed = {"excavator": ("excited", "consistent", "fresh", "converged", "identifiable")}
    needed["loader"] = ("excited_ratio", "excited_height", "consistent", "fresh", "converged_ratio", "converged_height")
    for machine, flags in needed.items():
        sound = rows[machine]._replace(**{flag: True for flag in flags})
        assert sound.why == ""
        for flag in flags:
            assert sound._replace(**{flag: False}).why == f"not {flag}"
        assert sound._replace(refused=True).why == "refused"
        verdict = "trusted" if machine == "excavator" else "trusted_height"
        assert sound._replace(**{verdict: False}).why == f"not {verdict}"
    sound = rows["excavator"]._replace(**{flag: True for flag in needed["excavator"]})
    assert sound._replace(changing=True).why == "changing"
    assert sound._replace(reason="slope", refused=True).why == "the ground seems inclined, refused"


def test_what_cannot_be_fed_is_reported():
    with pytest.raises(heft.HeftError, match="did you mean swing_velocity"):
        heft.Estimator("excavator", signals=["swing_velocty"])
    with pytest.raises(heft.HeftError, match="swing_velocity or swing_angle"):
        heft.Estimator("excavator", signals=["swing_torque"])
    with pytest.raises(heft.HeftError, match="boom_angle is none of the signals"):
        estimator().step(0.0, boom_angle=0.1)
    with pytest.raises(heft.HeftError, match="one text"):
        heft.Estimator("excavator", signals="swing_velocity")
    with pytest.raises(TypeError, match="swing_velocity"):
        estimator().step(0.0, swing_velocity="fast")


def test_numbers_that_run_python_code_do_not_stop_two_threads():
    code = """
import threading, time, heft
class Slow:
    def __float__(self):
        time.sleep(0.001)
        return 0.1
one = heft.Estimator("excavator", signals=["swing_velocity"])
def run():
    for i in range(50):
        one.step(0.01 * i, swing_velocity=Slow())
threads = [threading.Thread(target=run) for _ in range(2)]
for thread in threads: thread.start()
for thread in threads: thread.join()
"""
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


def test_copies_go_their_own_way_and_damaged_states_are_refused():
    one = estimator()
    for i in range(500):
        one.step(i / 100, swing_velocity=np.sin(i / 50), swing_torque=1e4 * np.cos(i / 50))
    before = one.state()
    others = [copy.copy(one), copy.deepcopy(one), pickle.loads(pickle.dumps(one))]
    one.step(5.0, swing_velocity=0.2)
    assert all(other.state() == before != one.state() for other in others)
    assert all(other.description == one.description for other in others)
    for at in (0, 20, len(before) // 2, len(before) - 1):
        damaged = bytearray(before)
        damaged[at] ^= 1
        with pytest.raises(heft.HeftError, match="no state"):
            heft.Estimator.from_state(bytes(damaged))
    for cut in (0, 7, 60, len(before) - 1):
        with pytest.raises(heft.HeftError, match="no state"):
            heft.Estimator.from_state(before[:cut])


def test_tables_of_all_kinds_give_the_same():
    file = GOLDEN / "excavator_input_base_case2.csv"
    data = pandas.read_csv(file, float_precision="round_trip")
    expected = heft.estimate(data, "excavator")
    lazy = heft.estimate(polars.from_pandas(data).lazy(), "excavator")
    assert isinstance(lazy, polars.DataFrame)
    misspelt = polars.from_pandas(data).lazy().rename({"swing_torque": "swing_torq"})
    with pytest.warns(heft.HeftWarning, match="did you mean swing_torque"):
        heft.estimate(misspelt, "excavator")
    records = data[["t", "swing_velocity", "swing_torque"]].to_records(index=False)
    short = heft.estimate(data[["t", "swing_velocity", "swing_torque"]], "excavator")
    assert heft.estimate(records, "excavator").equals(short)
    for path in (file, str(file)):
        assert heft.estimate(path, "excavator").equals(expected)
    assert (bits(lazy["inertia"].to_numpy()) == bits(expected["inertia"])).all()
    for wrong in (data.to_numpy(), data["t"].to_numpy(), [1, 2, 3], 7):
        with pytest.raises(heft.HeftError, match="frame"):
            heft.estimate(wrong, "excavator")
    with pytest.raises(heft.HeftError, match="files"):
        heft.estimate(data, "excavator", map="map.toml")


def test_the_index_is_kept_and_refused_rows_are_spoken_of():
    data = pandas.read_csv(GOLDEN / "excavator_input_base_case2.csv")[:200]
    data.index = [f"row {i}" for i in range(len(data))]
    with pytest.warns(heft.HeftWarning, match="200 rows"):
        late = data.copy()
        late.loc["row 7", "t"] = 0.0
        estimates = heft.estimate(late, "excavator")
    assert list(estimates.index) == [f"row {i}" for i in range(200) if i != 7]
    assert len(data.join(estimates, rsuffix="_est")) == 200
    by_time = data.set_index("t")
    assert list(heft.estimate(by_time, "excavator").index) == list(by_time.index)
    with pytest.warns(heft.HeftWarning, match="did you mean swing_torque"):
        heft.estimate(data.rename(columns={"swing_torque": "swing_torq"}), "excavator")


def test_masked_values_are_missing_and_other_kinds_are_refused():
    data = pandas.read_csv(GOLDEN / "excavator_input_base_case2.csv")
    table = {name: data[name].to_numpy() for name in ("t", "swing_velocity", "swing_torque")}
    mask = np.arange(len(data)) % 7 == 3
    with_nan = dict(table, swing_torque=np.where(mask, np.nan, table["swing_torque"]))
    masked = dict(table, swing_torque=np.ma.array(table["swing_torque"], mask=mask))
    assert heft.estimate(masked, "excavator").equals(heft.estimate(with_nan, "excavator"))
    for wrong in (
        table["swing_velocity"] + 1j,
        np.arange(len(data)).astype("datetime64[s]"),
        np.ones((len(data), 2)),
        np.ma.array(np.ones(len(data)) * 1j, mask=mask),
    ):
        with pytest.raises(heft.HeftError, match="swing_velocity is not of numbers"):
            heft.estimate(dict(table, swing_velocity=wrong), "excavator")
    with pytest.raises(heft.HeftError, match="complex"):
        heft.estimate(data.assign(swing_velocity=1j), "excavator")


def test_names_are_never_options():
    with pytest.raises(heft.HeftError):
        next(heft.subscribe("--help"))
    with pytest.raises(heft.HeftError):
        heft.calibrate("excavator", ["--help"], "out.toml")


def test_the_types_are_those_of_the_tables():
    specification = importlib.util.spec_from_loader("stubs", loader=None)
    stubs = importlib.util.module_from_spec(specification)
    source = (HERE.parent / "stubs").read_text(encoding="utf-8")
    exec(compile(source, "stubs", "exec"), stubs.__dict__)
    there = Path(heft.__file__).with_name("_estimator.pyi").read_text(encoding="utf-8")
    assert stubs.stub() == there, "run bindings/python/stubs"


def test_a_users_file_passes_a_strict_type_checker(tmp_path):
    def mypy(file):
        command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path), str(file)]
        return subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)

    passes = mypy(HERE / "user.py")
    assert passes.returncode == 0, passes.stdout
    for wrong in (
        'heft.Estimator("crane", signals=[])',
        'heft.Estimator("excavator", signals=["speed"])',
        'heft.Estimator("excavator", signals=["swing_velocity"]).step(0.0, speed=1.0)',
        'heft.Estimator("excavator", signals=["swing_velocity"]).step(0.0).inertias',
        'heft.estimate({}, "excavator", method="magic")',
    ):
        (tmp_path / "wrong.py").write_text(f"import heft\n{wrong}\n")
        assert mypy(tmp_path / "wrong.py").returncode == 1, wrong
