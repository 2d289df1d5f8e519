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
import warnings
from typing import TYPE_CHECKING, Any, Dict, Iterable, Iterator, Literal, Mapping, Optional, Tuple, TypeVar, Union, overload

import numpy as np

from . import _heft
from ._calibration import Calibration
from ._estimator import Estimator, ExcavatorEstimate, LoaderEstimate
from ._heft import HeftError
from ._words import in_python

if TYPE_CHECKING:
    import pandas
    import polars

    from ._estimator import ExcavatorMethod, LoaderMethod

__version__: str = _heft.__version__
__all__ = [
    "Calibration",
    "DamageWarning",
    "Estimator",
    "ExcavatorEstimate",
    "HeftError",
    "HeftWarning",
    "LoaderEstimate",
    "calibrate",
    "command",
    "estimate",
    "loads",
    "read",
    "schema",
    "subscribe",
]


class HeftWarning(UserWarning):
    """What was left out, or looks like a mistake."""


class DamageWarning(HeftWarning):
    """A recording is damaged or was cut off: what is given is not all that was recorded.

    ``warnings.simplefilter("error", heft.DamageWarning)`` makes an exception of it.
    """


class Channels(Dict[str, Any]):
    """The channels of a recording by their names; ``attrs["damage"]`` says what of it is lacking,
    ``attrs["heft.description"]`` with which machine it was recorded."""

    def __init__(self, channels: Mapping[str, Any]) -> None:
        super().__init__(channels)
        self.attrs: Dict[str, Any] = {}


PathLike = Union[str, "os.PathLike[str]"]
Config = Union[None, PathLike, Mapping[str, Any]]
# A mapping has one type of key: strings, or paths.
_Loaded = TypeVar("_Loaded", bound=PathLike)
_Heavy = TypeVar("_Heavy", bound=PathLike)
Machine = Literal["excavator", "loader"]
Method = Union["ExcavatorMethod", "LoaderMethod"]


@overload
def estimate(
    data: "Union[polars.DataFrame, polars.LazyFrame]",
    machine: Machine,
    config: Config = None,
    method: Optional[Method] = None,
    map: None = None,
) -> "polars.DataFrame": ...


@overload
def estimate(
    data: "Union[pandas.DataFrame, Mapping[str, Any], np.ndarray, PathLike]",
    machine: Machine,
    config: Config = None,
    method: Optional[Method] = None,
    map: Optional[PathLike] = None,
) -> "pandas.DataFrame": ...


def estimate(
    data: Any,
    machine: Machine,
    config: Config = None,
    method: Optional[Method] = None,
    map: Optional[PathLike] = None,
) -> Any:
    """Estimates of one method, one row per row of ``data`` with a valid, increasing time.

    data
        A pandas or polars frame (lazy ones are collected), a table of pyarrow, a mapping of names to arrays, an array with
        named fields, or the path of a file that ``heft estimate`` reads. Columns have the names and SI
        units of the CSV (``heft.schema()``), ``t`` in seconds; other columns are left out; NaN, null,
        None and masked values are missing samples. Trucks may be words.
    machine
        ``"excavator"`` or ``"loader"``.
    config
        A description of the machine: the path of a TOML file, or a mapping of keys to values such as
        ``{"sensors.swing_velocity_std": 0.008}``. Without it, and below the keys of a mapping, a recording
        of heft brings its own, and so do the frames of ``heft.read``; else it is the reference machine.
    method
        As ``--method`` of the command line; without it, by the columns that there are.
    map
        Path of a signal map, where ``data`` is a file whose columns or CAN signals have other names.

    Returns a frame of the same kind (of pandas for others, if it is installed, else a dictionary of
    arrays). A quantity that the method does not estimate is NaN (null in polars). A frame of pandas
    keeps the index of the rows. Rows that are refused are left out, with a HeftWarning; one more says where times,
    angles or torque seem to be in another unit or of another machine. Of a recording that
    is damaged or was cut off, the rest is used, with a DamageWarning and the places in ``attrs["damage"]``.

    Raises HeftError where the data or the description cannot be used; it says what to do.
    """
    text, settings = _description(config)
    if isinstance(data, (str, os.PathLike)):
        place = None if map is None else os.fspath(map)
        result = _heft.estimate_file(machine, os.fspath(data), place, text, settings, method)
        return _estimates(result, "pandas", None)
    if map is not None:
        raise HeftError("map is for files; rename the columns of a frame")
    known = _heft.signals(machine)
    if text is None:
        text = getattr(data, "attrs", {}).get("heft.description")
    data = _table(data, known)
    _of_one_machine(data)
    names = _names(data)
    _hint_at_names(names, known)
    if "t" not in names:
        remedy = f"rename one of {', '.join(names)}" if names else "the table has no columns"
        raise HeftError(f"there is no column t, the time in seconds; {remedy}")
    columns = [(name, _numbers(name, data[name])) for name in names if name in known]
    result = _heft.estimate(machine, columns, text, settings, method)
    return _estimates(result, _library(data), getattr(data, "index", None))


def read(recording: PathLike) -> Channels:
    """The channels of a recording, each as a frame (pandas, or a dictionary of arrays without it).

    Units stand in ``frame.attrs["units"]``, meanings in ``frame.attrs["meanings"]``. A signal that a
    sensor did not give, and a quantity that is not estimated, is NaN.

    Of a recording that is damaged or was cut off, what is whole is given, with a DamageWarning. The result
    has ``attrs["damage"]``, and so has each frame of pandas: what is lacking and where, one text each. In the same
    way ``attrs["heft.description"]`` is the machine that it was recorded with, as TOML, or None.
    """
    channels, damage, description = _heft.read(os.fspath(recording))
    _warn_of_damage(damage)
    result = Channels({name: _frame(columns, "pandas") for name, columns in channels})
    about = {"damage": damage, "heft.description": description}
    result.attrs.update(about)
    for frame in result.values():
        if hasattr(frame, "attrs"):
            frame.attrs.update(about)
    return result


def schema() -> Dict[str, Dict[str, Dict[str, str]]]:
    """The messages: for each its fields, with ``type``, ``unit`` and ``meaning``."""
    return {
        message: {field: {"type": kind, "unit": unit, "meaning": doc} for field, unit, doc, kind in fields}
        for message, fields in _heft.schema()
    }


def calibrate(
    machine: Machine,
    recordings: Iterable[PathLike],
    output: PathLike,
    *,
    payload: Optional[Mapping[_Loaded, Union[str, float]]] = None,
    mass: Optional[Mapping[_Heavy, Union[str, float]]] = None,
    config: Config = None,
    map: Optional[PathLike] = None,
    weigh: Optional[Mapping[Optional[PathLike], PathLike]] = None,
    out_and_back: Iterable[Tuple[PathLike, PathLike]] = (),
    free: Optional[Iterable[str]] = None,
    accept: bool = False,
    report: Optional[PathLike] = None,
) -> Calibration:
    """The machine's own parameters from recordings, written as a description to ``output``.

    ``payload`` and ``mass`` say what was weighed, such as ``{"empty.csv": 0, "full.csv": "400±5"}``. Returns the parameters
    that were found, by their key; ``str()`` of it is what ``heft calibrate`` printed. ``map`` is the signal map of
    recordings with other names. Of a loader, ``weigh`` gives the axle scales of a recording, or (None) of the machine
    without load, and ``out_and_back`` pairs of recordings on one path, the second with the machine turned round.

    Raises HeftError, and writes nothing, where the recordings do not determine the parameters; it says
    what is missing. ``accept=True`` writes what was found nevertheless.
    """
    arguments = ["calibrate", machine, *_files(recordings, "a machine is calibrated from files")]
    for option, known in (("--payload", payload), ("--mass", mass)):
        for file, weight in (known or {}).items():
            arguments += [option, f"{_path(file)}={weight}"]
    for weighed, scales in (weigh or {}).items():
        arguments += ["--weigh", _path(scales) if weighed is None else f"{_path(weighed)}={os.fspath(scales)}"]
    for there, back in out_and_back:
        arguments += ["--out-and-back", f"{_path(there)},{os.fspath(back)}"]
    if accept:
        arguments += ["--accept"]
    if map is not None:
        arguments += ["--map", os.fspath(map)]
    if free is not None:
        arguments += ["--free", free if isinstance(free, str) else ",".join(free)]
    if report is not None:
        arguments += ["--report", os.fspath(report)]
    with tempfile.TemporaryDirectory() as folder:
        arguments += _described(config, folder)
        return Calibration(_run([*arguments, "-o", os.fspath(output)]), Path(output))


def loads(
    recordings: Union[PathLike, Iterable[PathLike]],
    machine: Optional[Machine] = None,
    *,
    config: Config = None,
    map: Optional[PathLike] = None,
    method: Optional[str] = None,
    target: Optional[float] = None,
    pause: Optional[float] = None,
) -> list[Dict[str, Any]]:
    """What was carried and dumped, as ``heft loads`` counts it: an account for each recording.

    ``account["loads"]`` has a dictionary a load: ``filled`` and ``dumped`` [s], ``in_bucket`` and ``delivered`` with ``kg``,
    ``std``, ``low`` and ``high`` of the 95 % interval, ``witness``, ``trusted``, ``reason``. ``account["trucks"]`` and
    ``account["total"]`` are sums; with ``target`` [kg] a truck has what remains. ``pause`` [s] between
    loads begins a truck. ``account["outages"]`` are the times in which a fault of a sensor left no load weighed.
    A recording of heft brings its machine and description; ``config`` takes the place of the latter.
    """
    arguments = ["loads", *_files(recordings, "loads are counted in files")]
    for option, value in (("machine", machine), ("map", map), ("method", method), ("target", target), ("pause", pause)):
        if value is not None:
            arguments += [f"--{option}={os.fspath(value) if option == 'map' else value}"]
    with tempfile.TemporaryDirectory() as folder:
        arguments += _described(config, folder)
        found = Path(folder) / "loads.json"
        _run([*arguments, "--json", str(found)], found)
        accounts = json.loads(found.read_text(encoding="utf-8"))["recordings"]
        return list(accounts)


def subscribe(channel: str, domain: Optional[str] = None) -> Iterator[Dict[str, Any]]:
    """The messages of a running pipeline as they come: ``for m in heft.subscribe("excavator/sensors")``.

    A number that is not measured, or not estimated, is None. Ends with the pipeline. Closing the iterator ends the subscription. Raises HeftError where no
    pipeline runs, or it has no such channel.
    """
    arguments = [command(), "tail", "--format", "json"]
    if domain is not None:
        arguments += [f"--domain={domain}"]
    arguments += ["--", channel]  # a name is never an option
    # A pipe that nobody reads would fill up and stop the command.
    with tempfile.TemporaryFile("w+", encoding="utf-8") as words, subprocess.Popen(
        arguments, stdout=subprocess.PIPE, stderr=words, text=True
    ) as process:
        assert process.stdout is not None
        try:
            for line in process.stdout:
                yield json.loads(line)
        finally:
            process.terminate()
        process.wait()
        words.seek(0)
        told = in_python(words.read().strip())
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


def _files(recordings: Any, why: str) -> list[str]:
    """The paths of recordings, which are one or several."""
    if isinstance(recordings, (str, os.PathLike)):
        recordings = [recordings]
    recordings = [recordings] if hasattr(recordings, "columns") else list(recordings)
    if any(not isinstance(file, (str, os.PathLike)) for file in recordings):
        raise HeftError(f"{why}; write the frame to a table (to_csv), and give its path")
    if not recordings:
        raise HeftError(f"{why}; give the path of one at least")
    return [_path(file) for file in recordings]


def _path(file: PathLike) -> str:
    """A path that the command cannot take for an option."""
    if not isinstance(file, (str, os.PathLike)):
        raise HeftError(f"{type(file).__name__} is no path of a recording")
    path = os.fspath(file)
    return os.path.join(".", path) if path.startswith("-") else path


def _run(arguments: Iterable[str], result: Optional[Path] = None) -> str:
    """What the command prints; a result that it wrote although something of the input was lost counts, with a warning."""
    done = subprocess.run([command(), *arguments], capture_output=True, text=True)
    # Notes of the command are no warnings, and an exception has a name of its own.
    lines = done.stderr.strip().splitlines()
    told = in_python("\n".join(line for line in lines if not line.startswith("note: ")))
    has_result = done.returncode == 1 and result is not None and result.exists()
    if done.returncode != 0 and not has_result:
        raise HeftError(told or in_python(done.stdout.strip()))
    if told:
        warnings.warn(told, HeftWarning, stacklevel=3)
    return done.stdout


def _described(config: Config, folder: str) -> list[str]:
    """The options of a command that say what the machine is. Keys change what the recordings say of it."""
    text, settings = _description(config)
    if text is None:
        return [option for setting in settings for option in ("--set", setting)]
    file = Path(folder) / "description.toml"
    file.write_text(text, encoding="utf-8")
    return ["--config", str(file)]


def _description(config: Config) -> tuple[Optional[str], list[str]]:
    """Text of a machine file, and keys that are set one by one."""
    if config is None:
        return None, []
    if isinstance(config, Mapping):
        return None, [f"{key}={_value(key, value)}" for key, value in config.items()]
    if not isinstance(config, (str, os.PathLike)):
        raise HeftError(f"{type(config).__name__} is no machine file; give the path of a TOML file, or a mapping of keys")
    try:
        return Path(config).read_text(encoding="utf-8"), []
    except (OSError, UnicodeError) as error:
        raise HeftError(f"the machine file {os.fspath(config)} cannot be read: {error}; give a TOML file in UTF-8") from None


def _value(key: str, value: Any) -> str:
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, str):
        return value
    if isinstance(value, (list, tuple, np.ndarray)):
        return "[" + ", ".join(_value(key, v) for v in value) + "]"
    try:
        return repr(float(value))
    except (TypeError, ValueError):
        what = f"{key} cannot be {value!r}; give a number, a word, true or false, or a list of numbers"
        raise HeftError(f'{what}, and write keys with dots: {{"sensors.rate": 100}}') from None


def _table(data: Any, known: list[str]) -> Any:
    """What has names and columns."""
    library = _library(data)
    if library == "polars" and hasattr(data, "collect"):
        names = data.collect_schema().names()
        _hint_at_names(names, known, stacklevel=4)
        data = data.select([name for name in names if name in known or name == "machine"]).collect()
    if isinstance(data, np.ndarray):
        if data.dtype.names is None:
            raise HeftError("an array has no names of columns; give {'t': ..., 'swing_velocity': ...} or a frame")
        return {name: data[name] for name in data.dtype.names}
    if library == "pyarrow" and hasattr(data, "column_names"):
        _refuse_twice(data.column_names, known)
        return {name: np.asarray(column) for name, column in zip(data.column_names, data.columns)}
    if library == "pandas" and hasattr(data, "columns"):
        _refuse_twice(data.columns, known)
        if "t" not in data.columns and (data.index.name == "t" or data.index.dtype.kind in "Mm"):
            return data.assign(t=data.index)
        return data
    if isinstance(data, Mapping) or hasattr(data, "columns"):
        return data
    raise HeftError(
        f"{type(data).__name__} cannot be used; give a frame of pandas or polars, a table of pyarrow, a mapping of names to arrays, or a path"
    )


def _refuse_twice(names: Iterable[Any], known: list[str]) -> None:
    seen = set()
    for name in names:
        if name in known and name in seen:
            raise HeftError(f"two columns are called {name}; rename or drop one of them")
        seen.add(name)


def _of_one_machine(table: Any) -> None:
    """Refuses the rows of several machines: a column of this name says whose each row is, as in tables of ``heft serve``."""
    if "machine" in _names(table):
        names = sorted({str(name) for name in table["machine"] if name is not None and name == name})
        if len(names) > 1:
            raise HeftError(
                f"the rows are of {len(names)} machines, {names[0]} and {names[1]} among them; "
                "give those of one, or rename the column machine if it names something else"
            )


def _names(data: Any) -> list[str]:
    return [str(name) for name in (data.keys() if isinstance(data, Mapping) else data.columns)]


def _hint_at_names(names: list[str], known: list[str], stacklevel: int = 3) -> None:
    """Warns of a column that is left out and is probably a signal misspelt."""
    absent = [name for name in known if name not in names]
    for name in names:
        near = None if name in known else _heft.nearest(name, absent)
        if near is not None:
            warnings.warn(f"the column {name} is not used; did you mean {near}?", HeftWarning, stacklevel)


def _library(data: Any) -> str:
    return type(data).__module__.split(".")[0]


def _label(value: Any) -> float:
    """What a truck is called, as the number that it is in a table."""
    if value is None:
        return float("nan")
    if not isinstance(value, (str, bytes)):
        return float(value)
    return _heft.label(value.decode() if isinstance(value, bytes) else value)


def _labels(column: Any) -> Any:
    """A column of trucks as numbers, where it has words."""
    if getattr(getattr(column, "dtype", None), "kind", "O") in "biuf":
        return column
    values = column.to_list() if hasattr(column, "to_list") else column.tolist() if hasattr(column, "tolist") else column
    values = [None if type(value).__name__ in ("NAType", "NaTType") else value for value in values]
    if not any(isinstance(value, (str, bytes)) for value in values):
        return column
    return np.array([_label(value) for value in values], dtype="float64")


def _numbers(name: str, column: Any) -> bytes:
    """A column as the bytes of its doubles; times of day as seconds since the first of them."""
    try:
        if name == "truck":
            column = _labels(column)
        if _library(column) == "polars":
            import polars

            is_of_day = column.dtype == polars.Time
            array = (column.cast(polars.Duration("ns")) if is_of_day else column).to_numpy()
        elif _library(column) == "pandas" and column.dtype.kind not in "Mm":
            if column.dtype.kind == "c":
                raise TypeError("complex numbers")
            array = column.to_numpy(dtype="float64", na_value=float("nan"))
        elif isinstance(column, np.ma.MaskedArray):
            if column.dtype.kind not in "biuf":
                raise TypeError(f"masked values of type {column.dtype}")
            array = column.astype("float64").filled(np.nan)
        else:
            aware = getattr(column.dtype, "tz", None) is not None if hasattr(column, "dtype") else False
            array = np.asarray(column, dtype="datetime64[ns]" if aware else None)
        if array.dtype.kind in "Mm" and name != "t":
            raise TypeError("times")
        if array.dtype.kind == "c":
            raise TypeError("complex numbers")
        if array.ndim == 2 and 1 in array.shape:
            array = array.ravel()  # a row or a column of MATLAB
        if array.ndim != 1:
            raise TypeError(f"an array of {array.ndim} dimensions, where each row has one value")
        if array.dtype.kind == "M" and not np.isnat(array).all():
            array = array - np.nanmin(array)
        if array.dtype.kind == "m":
            array = array / np.timedelta64(1, "s")
        return np.ascontiguousarray(array, dtype="<f8").tobytes()
    except (TypeError, ValueError) as error:
        raise HeftError(f"column {name} is not of numbers: {error}; convert it first") from None


def _array(values: Any) -> np.ndarray:
    kind, content = values
    if kind == "words":
        codes, words = content
        return np.array(words, dtype=object)[np.frombuffer(codes, dtype="u1")]
    # A copy, because what stands on bytes cannot be written to.
    return np.frombuffer(content, dtype={"numbers": "<f8", "flags": "?", "u4": "<u4", "u8": "<u8"}[kind]).copy()


def _estimates(result: Any, library: str, index: Any) -> Any:
    """The frame of estimates; its rows keep their index, and those that were refused are spoken of."""
    columns, refused, rows, damage, hints = result
    _warn_of_damage(damage)
    for hint in hints:
        warnings.warn(in_python(hint), HeftWarning, stacklevel=3)
    if refused:
        warnings.warn(
            f"{len(refused)} of {rows} rows are left out: their time is missing or does not increase"
            f" (the first is row {refused[0]})",
            HeftWarning,
            stacklevel=3,
        )
    frame = _frame(columns, library)
    if library == "pandas" and index is not None and not isinstance(frame, dict):
        frame.index = np.delete(np.arange(rows), refused) if len(index) != rows else index.delete(refused)
    if damage and hasattr(frame, "attrs"):
        frame.attrs["damage"] = damage
    return frame


def _warn_of_damage(damage: list[str]) -> None:
    if damage:
        what = "\n  ".join(damage)
        warnings.warn(f"the recording is not whole; the rest is given\n  {what}", DamageWarning, stacklevel=3)


def _frame(columns: list[tuple[str, str, str, Any]], library: str) -> Any:
    if library == "polars":
        import polars

        frame = polars.DataFrame({name: _array(values) for name, _, _, values in columns})
        return frame.with_columns(polars.col(polars.Float64).fill_nan(None))
    try:
        import pandas
    except ImportError:
        return {name: _array(values) for name, _, _, values in columns}

    def series(values: Any) -> Any:
        if values[0] != "words":
            return _array(values)
        codes, words = values[1]
        return pandas.Categorical.from_codes(np.frombuffer(codes, dtype="u1"), words)

    frame = pandas.DataFrame({name: series(values) for name, _, _, values in columns})
    frame.attrs["units"] = {name: unit for name, unit, _, _ in columns}
    frame.attrs["meanings"] = {name: meaning for name, _, meaning, _ in columns if meaning}
    return frame
