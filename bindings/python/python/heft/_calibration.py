"""What a calibration found."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Iterator, Mapping, NamedTuple, Optional

_CALIBRATED = "# calibrated, ±"


class Parameter(NamedTuple):
    """A parameter that was found: its key, value, standard deviation, and the value of the machine file before."""

    key: str
    value: float
    std: float
    described: Optional[float]


class Calibration(Mapping[str, Parameter]):
    """Parameters by their key; ``str()`` is what ``heft calibrate`` printed, ``frame()`` a table."""

    def __init__(self, text: str, output: Path) -> None:
        self._text = text
        self.output = output
        """The machine file that was written."""
        found = parameters(output.read_text(encoding="utf-8"))
        self._parameters = {parameter.key: parameter for parameter in found}

    def __getitem__(self, key: str) -> Parameter:
        return self._parameters[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._parameters)

    def __len__(self) -> int:
        return len(self._parameters)

    def __str__(self) -> str:
        return self._text

    def frame(self) -> Any:
        """A frame of pandas with the columns key, value, std, described."""
        import pandas

        return pandas.DataFrame(list(self._parameters.values()), columns=list(Parameter._fields))


def parameters(description: str) -> list[Parameter]:
    """The parameters that a calibrated machine file says were found."""
    found, table = [], ""
    for line in map(str.strip, description.splitlines()):
        if line.startswith("[") and line.endswith("]"):
            table = line[1:-1]
        assignment, note_found, note = line.partition(_CALIBRATED)
        if not note_found or line.startswith("#"):
            continue
        name, _, value = assignment.partition("=")
        std, _, described = note.partition(", described")
        before = float(described) if described.strip() else None
        found.append(Parameter(f"{table}.{name.strip()}", float(value), float(std), before))
    return found
