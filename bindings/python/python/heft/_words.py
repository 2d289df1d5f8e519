"""Messages of the command in the words of this package: each option is the parameter that does the same."""

from __future__ import annotations

import re

# FILE=MASS, or a table of scales.
_VALUE = r"[^\s;,()]+(?:=[^\s;,()]+|\.csv)"
# Commands in backquotes stay: the command comes with the package.
_FOUND = re.compile(
    r"`heft [^`]*`(?: with --\w+)?"
    rf"|(?P<pairs>--(?P<name>payload|mass|weigh)[ =]{_VALUE}(?: --(?P=name)[ =]{_VALUE})*)"
    r"|--set[ =](?P<key>\w+(?:\.\w+)+)(?:=(?P<number>[^\s;,()]+))?"
    r"|--machine[ =](?P<machine>excavator|loader)\b"
    r"|--out-and-back[ =](?P<there>[^\s;,()]+),(?P<back>[^\s;,()]+)"
    r"|--class(?: \d\w*)?"
    r"|(?P<flag>--accept)\b"
    r"|--(?P<option>config|domain|free|machine|map|mass|method|out-and-back|output|pause|payload|report|set|target|weigh)\b"
)


# What only a terminal needs.
_OF_TERMINALS = re.compile(r"^(?:heft|error): |\n+For more information, try '--help'\.", re.M)
_QUOTED = re.compile(r"'--([\w-]+) <\w+>'")


def in_python(text: str) -> str:
    """The message with the parameters of the package in the place of options."""
    return _FOUND.sub(_parameter, _QUOTED.sub(r"--\1", _OF_TERMINALS.sub("", text)))


def _parameter(found: "re.Match[str]") -> str:
    part = found.groupdict()
    if part["pairs"]:
        values = re.findall(r"--\w+[ =](\S+)", part["pairs"])
        return f"{part['name']}={{{', '.join(map(_pair, values))}}}"
    if part["key"]:
        return f'config={{"{part["key"]}": {part["number"] or "..."}}}'
    if part["machine"]:
        return f'machine="{part["machine"]}"'
    if part["there"]:
        return f'out_and_back=[("{part["there"]}", "{part["back"]}")]'
    if part["flag"]:
        return "accept=True"
    if part["option"]:
        name = part["option"].replace("-", "_")
        return "config=" if name == "set" else f"{name}="
    return "config=" if found[0].startswith("--class") else found[0]


def _pair(value: str) -> str:
    file, has_file, rest = value.partition("=")
    return f'"{file}": "{rest}"' if has_file else f'None: "{file}"'
