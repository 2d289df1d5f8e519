"""Mass properties of construction machines, estimated from what their sensors measured.

>>> import heft, pandas
>>> estimates = heft.estimate(pandas.read_csv("swing.csv"), "excavator")
>>> estimates.loc[estimates.trusted, ["t", "inertia", "inertia_std", "payload"]]

The numbers are those of the command line, bit for bit. Units are SI; those of a result stand in
``frame.attrs["units"]``. Believe the rows whose ``trusted`` is set; an interval of 95 % is the value
+- 1.96 of its standard deviation.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path
from typing import Any, Dict, Iterable, Iterator, Mapping, Optional, Union

import numpy as np

from . import _heft
from ._heft import HeftError

__version__: str = _heft.__version__
__all__ = ["HeftError", "calibrate", "command", "estimate", "read", "schema", "subscribe"]

PathLike = Union[str, "os.PathLike[str]"]
Config = Union[None, PathLike, Mapping[str, Any]]


def estimate(data: Any, machine: str, config: Config = None, method: Optional[str] = None) -> Any:
    """Estimates of one method, one row per row of ``data`` with a valid, increasing time.

    data
        A pandas or polars frame, or a mapping of names to arrays. Columns have the names and SI
        units of the CSV (``heft.schema()``), ``t`` in seconds; other columns are left out; NaN, null
        and None are missing samples.
    machine
        ``"excavator"`` or ``"loader"``.
    config
        A description of the machine: the path of a TOML file, or a mapping of keys to values such as
        ``{"sensors.swing_velocity_std": 0.008}``. Without it, the reference machine.
    method
        As ``--method`` of the command line; without it, by the columns that there are.

    Returns a frame of the same kind (of pandas for a mapping, if it is installed, else a dictionary
    of arrays). A quantity that the method does not estimate is NaN (null in polars).

    Raises HeftError where the data or the description cannot be used; it says what to do.
    """
    names = set(_heft.signals(machine))
    columns = [(name, _numbers(name, data[name])) for name in _names(data) if name in names]
    text, settings = _description(config)
    result = _heft.estimate(machine, columns, text, settings, method)
    return _frame(result, _library(data))


def read(recording: PathLike) -> Dict[str, Any]:
    """The channels of a recording, each as a frame (pandas, or a dictionary of arrays without it).

    Units stand in ``frame.attrs["units"]``, meanings in ``frame.attrs["meanings"]``. A signal that a
    sensor did not give is NaN. A recording that was cut off is read up to its last whole chunk.
    """
    channels = _heft.read(os.fspath(recording))
    return {name: _frame(columns, "pandas") for name, columns in channels}


def schema() -> Dict[str, Dict[str, Dict[str, str]]]:
    """The messages: for each its fields, with ``type``, ``unit`` and ``meaning``."""
    return {
        message: {field: {"type": kind, "unit": unit, "meaning": doc} for field, unit, doc, kind in fields}
        for message, fields in _heft.schema()
    }


def calibrate(
    machine: str,
    recordings: Iterable[PathLike],
    output: PathLike,
    *,
    payload: Optional[Mapping[PathLike, str]] = None,
    mass: Optional[Mapping[PathLike, str]] = None,
    config: Config = None,
    free: Optional[Iterable[str]] = None,
    report: Optional[PathLike] = None,
) -> str:
    """The machine's own parameters from recordings, written as a description to ``output``.

    ``payload`` and ``mass`` say what was weighed, such as ``{"full.csv": "400±5"}``. Returns what
    ``heft calibrate`` printed.

    Raises HeftError, and writes nothing, where the recordings do not determine the parameters; it says
    what is missing.
    """
    arguments = ["calibrate", machine, *(os.fspath(file) for file in recordings)]
    for option, known in (("--payload", payload), ("--mass", mass)):
        for file, weight in (known or {}).items():
            arguments += [option, f"{os.fspath(file)}={weight}"]
    if free is not None:
        arguments += ["--free", ",".join(free)]
    if report is not None:
        arguments += ["--report", os.fspath(report)]
    text, settings = _description(config)
    with tempfile.TemporaryDirectory() as folder:
        if text is not None or settings:
            described = Path(folder) / "description.toml"
            described.write_text(_heft.description(machine, text, settings), encoding="utf-8")
            arguments += ["--config", str(described)]
        return _run([*arguments, "-o", os.fspath(output)])


def subscribe(channel: str, domain: Optional[str] = None) -> Iterator[Dict[str, Any]]:
    """The messages of a running pipeline as they come: ``for m in heft.subscribe("excavator/sensors")``.

    Ends with the pipeline. Closing the iterator ends the subscription. Raises HeftError where no
    pipeline runs, or it has no such channel.
    """
    arguments = [command(), "tail", channel, "--format", "json"]
    if domain is not None:
        arguments += ["--domain", domain]
    with subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None and process.stderr is not None
        try:
            for line in process.stdout:
                yield json.loads(line)
            told = process.stderr.read().strip()
        finally:
            process.terminate()
    if process.returncode not in (0, -15):
        raise HeftError(told or f"heft tail {channel} ended with status {process.returncode}")


def command() -> str:
    """Path of the command ``heft`` that came with this package."""
    name = "heft.exe" if sys.platform == "win32" else "heft"
    for folder in (sysconfig.get_path("scripts"), Path(sys.executable).parent):
        path = Path(folder) / name
        if path.exists():
            return str(path)
    return name


def _run(arguments: Iterable[str]) -> str:
    done = subprocess.run([command(), *arguments], capture_output=True, text=True)
    if done.returncode != 0:
        raise HeftError(done.stderr.strip() or done.stdout.strip())
    return done.stdout


def _description(config: Config) -> tuple[Optional[str], list[str]]:
    """Text of a description, and keys that are set one by one."""
    if config is None:
        return None, []
    if isinstance(config, Mapping):
        return None, [f"{key}={_value(value)}" for key, value in config.items()]
    return Path(config).read_text(encoding="utf-8"), []


def _value(value: Any) -> str:
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, str):
        return value
    if isinstance(value, (list, tuple, np.ndarray)):
        return "[" + ", ".join(_value(v) for v in value) + "]"
    return repr(float(value))


def _names(data: Any) -> list[str]:
    return [str(name) for name in (data.keys() if isinstance(data, Mapping) else data.columns)]


def _library(data: Any) -> str:
    return type(data).__module__.split(".")[0]


def _numbers(name: str, column: Any) -> bytes:
    """A column as the bytes of its doubles; times of day as seconds since the first of them."""
    try:
        if _library(column) == "polars":
            array = column.to_numpy()
        elif _library(column) == "pandas" and column.dtype.kind not in "Mm":
            array = column.to_numpy(dtype="float64", na_value=float("nan"))
        else:
            aware = getattr(column.dtype, "tz", None) is not None if hasattr(column, "dtype") else False
            array = np.asarray(column, dtype="datetime64[ns]" if aware else None)
        if array.dtype.kind == "M":
            array = array - np.nanmin(array)
        if array.dtype.kind == "m":
            array = array / np.timedelta64(1, "s")
        return np.ascontiguousarray(array, dtype="<f8").tobytes()
    except (TypeError, ValueError) as error:
        raise HeftError(f"column {name} is not of numbers: {error}; convert it first") from None


def _array(values: Any) -> np.ndarray:
    kind, content = values
    if kind == "words":
        return np.array(content, dtype=object)
    # A copy, because what stands on bytes cannot be written to.
    return np.frombuffer(content, dtype={"numbers": "<f8", "flags": "?", "u4": "<u4", "u8": "<u8"}[kind]).copy()


def _frame(columns: list[tuple[str, str, str, Any]], library: str) -> Any:
    arrays = {name: _array(values) for name, _, _, values in columns}
    if library == "polars":
        import polars

        frame = polars.DataFrame(arrays)
        return frame.with_columns(polars.col(polars.Float64).fill_nan(None))
    try:
        import pandas
    except ImportError:
        return arrays
    frame = pandas.DataFrame(arrays)
    frame.attrs["units"] = {name: unit for name, unit, _, _ in columns}
    frame.attrs["meanings"] = {name: meaning for name, _, meaning, _ in columns if meaning}
    return frame
