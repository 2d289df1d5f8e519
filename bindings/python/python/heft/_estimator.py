"""An estimator that is fed sample by sample."""

from __future__ import annotations

import warnings
from collections import namedtuple
from typing import Any, Iterable, Optional

from . import _heft

# Half the width of a 95 % interval of a normal distribution, in standard deviations.
_HALF_WIDTH_95 = 1.959963984540054
# The flags that take trust away where they are set, and where they are not.
_AGAINST = ("refused", "changing", "frozen")
_NEEDED = (
    *("excited", "excited_ratio", "excited_height", "consistent", "fresh"),
    *("converged", "converged_ratio", "converged_height", "identifiable"),
)
# The verdicts that follow from them: named where no other flag explains them, because not every cause has a column.
_VERDICTS = ("trusted", "trusted_ratio", "trusted_height")


def _row(name: str, machine: str) -> type:
    """The type of a machine's estimates: a named tuple of the columns of the CSV."""
    columns = _heft.header(machine)
    why = dict(_heft.reasons(machine))
    own = {column for column, _, _ in columns}
    quantities = [c for c, _, _ in columns if f"{c}_std" in {other for other, _, _ in columns}]
    base = namedtuple(name, [column for column, _, _ in columns])  # type: ignore[misc]

    class Row(base):  # type: ignore[valid-type, misc]
        __slots__ = ()
        units = {column: unit for column, unit, _ in columns}

        @property
        def why(self) -> str:
            """What keeps any of its quantities from being trusted: the reason in words, then flags; "" where nothing does."""
            against = [flag for flag in _AGAINST if flag in own and getattr(self, flag)]
            lacking, verdicts = (
                [f"not {flag}" for flag in flags if flag in own and not getattr(self, flag)]
                for flags in (_NEEDED, _VERDICTS)
            )
            said = [word for word in (why.get(self.reason, ""), *against, *lacking) if word]
            return ", ".join(said or verdicts)

        def interval(self, quantity: str = quantities[0]) -> tuple[float, float]:
            """The 95 % interval of a quantity; NaN where the method does not estimate it."""
            if quantity not in quantities:
                raise _heft.HeftError(f"{quantity} has no interval; these have: {', '.join(quantities)}")
            value, half = getattr(self, quantity), _HALF_WIDTH_95 * getattr(self, f"{quantity}_std")
            return (value - half, value + half)

    Row.__name__ = Row.__qualname__ = name
    Row.__module__ = "heft"
    Row.__doc__ = "An estimate: the columns of ``heft.estimate``, and whether the sample was ``refused``."
    return Row


ExcavatorEstimate = _row("ExcavatorEstimate", "excavator")
LoaderEstimate = _row("LoaderEstimate", "loader")
_ROWS = {"excavator": ExcavatorEstimate, "loader": LoaderEstimate}


class Estimator:
    """Steps through samples as they come, with the numbers of ``heft.estimate``, bit for bit.

    >>> estimator = heft.Estimator("excavator", signals=["swing_velocity", "swing_torque"])
    >>> estimate = estimator.step(t=0.0, swing_velocity=0.1, swing_torque=5e3)
    >>> estimate.trusted, estimate.reason, estimate.interval("inertia")

    ``signals`` names the sensors that the machine has; a sample may lack any of them (left out, None or
    NaN). ``config`` and ``method`` are those of ``heft.estimate``. An estimator can be copied and pickled.
    """

    __slots__ = ("_native", "_row")

    def __init__(
        self,
        machine: str,
        *,
        signals: Iterable[str],
        config: Any = None,
        method: Optional[str] = None,
    ) -> None:
        from . import HeftWarning, _description, in_python

        if isinstance(signals, str):
            raise _heft.HeftError("signals is one text; give a list of names")
        text, settings = _description(config)
        self._take(_heft.Estimator(machine, text, settings, list(signals), method))
        undescribed = _heft.undescribed(machine, text, settings)
        if undescribed:
            warnings.warn(in_python(undescribed), HeftWarning, stacklevel=2)

    def _take(self, native: Any) -> None:
        self._native = native
        self._row = _ROWS[native.machine]._make  # type: ignore[attr-defined]

    def step(self, t: float, **values: Optional[float]) -> Any:
        """The estimate after a sample at time ``t`` [s]. One whose time does not increase is ``refused``."""
        return self._row(self._native.step(t, values))

    def state(self) -> bytes:
        """The complete state with machine file, method and signals; see ``from_state``."""
        return self._native.state()  # type: ignore[no-any-return]

    @classmethod
    def from_state(cls, state: bytes) -> "Estimator":
        """The estimator that wrote this state; it goes on bit for bit.

        Raises HeftError where other code than this one wrote it, or it is damaged.
        """
        new = cls.__new__(cls)
        new._take(_heft.Estimator.from_state(bytes(state)))
        return new

    @property
    def machine(self) -> str:
        """The machine."""
        return self._native.machine  # type: ignore[no-any-return]

    @property
    def method(self) -> str:
        """The method."""
        return self._native.method  # type: ignore[no-any-return]

    @property
    def signals(self) -> list[str]:
        """The sensors that the machine has."""
        return self._native.signals  # type: ignore[no-any-return]

    @property
    def description(self) -> str:
        """The machine file in full (TOML)."""
        return self._native.description  # type: ignore[no-any-return]

    def __reduce__(self) -> Any:
        return (Estimator.from_state, (self.state(),))

    def __copy__(self) -> "Estimator":
        return self.from_state(self.state())

    def __deepcopy__(self, _memo: Any) -> "Estimator":
        return self.from_state(self.state())

    def __repr__(self) -> str:
        return f"Estimator({self.machine!r}, signals={self.signals!r}, method={self.method!r})"
