"""The part in Rust; use the functions of `heft`."""

from typing import Any, List, Optional, Tuple

__version__: str

class HeftError(ValueError):
    """What is wrong, where, and what to do about it."""

Column = Tuple[str, str, str, Tuple[str, Any]]

def signals(machine: str) -> List[str]: ...
def estimate(
    machine: str,
    columns: List[Tuple[str, bytes]],
    description: Optional[str],
    settings: List[str],
    method: Optional[str],
) -> List[Column]: ...
def description(machine: str, text: Optional[str], settings: List[str]) -> str: ...
def read(path: str) -> List[Tuple[str, List[Column]]]: ...
def schema() -> List[Tuple[str, List[Tuple[str, str, str, str]]]]: ...
