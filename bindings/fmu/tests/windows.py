"""The library for Windows gives the bits of the one for Linux, under wine: windows.py FOLDER-OF-FMUS. Needs fmpy, cc, mingw, wine."""

import csv
import shutil
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

from fmpy import extract, read_model_description

HERE = Path(__file__).resolve().parent
GOLDEN = HERE.parents[2] / "tests" / "golden"
CASES = [("excavator", "excavator_input_two_swings.csv"), ("loader", "loader_input_S4_tierB.csv")]
MINGW = "x86_64-w64-mingw32-gcc"
# Wine before 9 lacks this library, which Rust's hash maps ask for a seed.
PRNG = """#include <windows.h>
__declspec(dllexport) BOOL WINAPI ProcessPrng(PBYTE into, SIZE_T count) { while (count--) *into++ = (BYTE)count; return TRUE; }
"""


def number(text):
    return struct.pack(">d", float(text or "nan")).hex()


def main(fmus):
    wine = shutil.which("wine64") or shutil.which("wine")
    if not wine or not shutil.which(MINGW):
        print("skipped: the library for Windows is tried where mingw and wine are")
        return
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        for compiler, name, libraries in [("cc", "bits", ["-ldl"]), (MINGW, "bits.exe", [])]:
            subprocess.run([compiler, "-Wall", "-Werror", HERE / "bits.c", "-o", folder / name, *libraries], check=True)
        (folder / "prng.c").write_text(PRNG)
        subprocess.run([MINGW, "-shared", folder / "prng.c", "-o", folder / "bcryptprimitives.dll"], check=True)
        for machine, file in CASES:
            fmu = fmus / f"heft_{machine}.fmu"
            about = read_model_description(str(fmu))
            unpacked = Path(extract(str(fmu), unzipdir=str(folder / machine)))
            variables = {v.name: v.valueReference for v in about.modelVariables}
            with open(GOLDEN / file, newline="") as text:
                rows = list(csv.DictReader(text))
            inputs = [name for name in rows[0] if name in variables and name != "t"]
            outputs = [r for name, r in variables.items() if name.startswith("estimate.") and name not in ("estimate.method", "estimate.reason")]
            has = [str(variables["has." + name]) for name in inputs if "has." + name in variables]
            data = "".join(" ".join(number(row[name]) for name in ["t", *inputs]) + "\n" for row in rows)
            references = [",".join(map(str, refs)) for refs in ([variables[name] for name in inputs], outputs)]

            def bits(*command):
                command = [*command, about.guid, *references, *has]
                done = subprocess.run(command, input=data, text=True, capture_output=True, env={"WINEDEBUG": "-all", "HOME": str(folder), "PATH": "/usr/bin:/bin"})
                assert done.returncode == 0, done.stderr
                return done.stdout.split()

            linux = bits(folder / "bits", unpacked / "binaries/x86_64-linux" / f"heft_{machine}.so")
            windows = bits(wine, folder / "bits.exe", "Z:" + str(unpacked / "binaries/x86_64-windows" / f"heft_{machine}.dll"))
            assert len(linux) == len(rows) * len(outputs), (machine, len(linux))
            differing = [i for i, (a, b) in enumerate(zip(linux, windows)) if a != b]
            assert linux == windows, (machine, len(linux), len(windows), len(differing), differing[:5])
            print(f"{machine}: {len(linux)} numbers have the same bits on Windows")


main(Path(sys.argv[1]))
