"""What the packages of heft have in common: a tree of files becomes a .deb by dpkg-deb."""

import email.utils
import gzip
import hashlib
import json
import os
import re
import shutil
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
SCRIPTS = ("preinst", "postinst", "prerm", "postrm")


def run(*command, **more):
    return subprocess.run([str(part) for part in command], check=True, **more)


def output(*command):
    return run(*command, capture_output=True, text=True).stdout.strip()


def metadata():
    """Of the workspace, and of its package heft: version, maintainer, target folder."""
    workspace = json.loads(output("cargo", "metadata", "--no-deps", "--format-version", 1))
    return workspace, next(p for p in workspace["packages"] if p["name"] == "heft")


def libraries(binaries):
    """The packages that they are linked with, the C library in the version of its newest symbol."""
    content = b"".join(binary.read_bytes() for binary in binaries)
    versions = re.findall(rb"GLIBC_(\d+)\.(\d+)", content)
    newest = max(((int(major), int(minor)) for major, minor in versions), default=(2, 17))
    needed = [f"libc6 (>= {newest[0]}.{newest[1]})"]
    return needed + (["libgcc-s1"] if b"libgcc_s.so.1" in content else [])


def zipped(file, content):
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(gzip.compress(content, 9, mtime=0))


def put(source, to, mode=0o644):
    to.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(source, to)
    to.chmod(mode)


def documents(tree, name, package):
    """What every package has in its folder of documents: licences, changelog."""
    folder = tree / "usr/share/doc" / name
    put(ROOT / "services/heft/debian/copyright", folder / "copyright")
    zipped(folder / "CHANGELOG.md.gz", (ROOT / "CHANGELOG.md").read_bytes())
    date = email.utils.formatdate((ROOT / "CHANGELOG.md").stat().st_mtime)
    maintainer = package["metadata"]["deb"]["maintainer"]
    entry = f"heft ({package['version']}) unstable; urgency=medium\n\n  * See CHANGELOG.md.gz.\n\n -- {maintainer}  {date}\n"
    zipped(folder / "changelog.gz", entry.encode())


def build(tree, out, package, fields, scripts=None, more=None):
    """Writes OUT/NAME_VERSION_ARCHITECTURE.deb. `fields`: those of the control file beside what all have, `Description` last; `more`: files
    beside it, by name."""
    architecture = output("dpkg", "--print-architecture")
    control = tree / "DEBIAN"
    control.mkdir()
    files = sorted(f for f in tree.rglob("*") if f.is_file() and not f.is_symlink() and control not in f.parents)
    size = sum(f.stat().st_size for f in files) // 1024 + 1
    common = {
        "Version": package["version"],
        "Architecture": architecture,
        "Maintainer": package["metadata"]["deb"]["maintainer"],
        "Installed-Size": size,
        "Priority": "optional",
        "Homepage": package["repository"],
    }
    lines = {"Package": fields["Package"], **common, **fields}
    (control / "control").write_text("".join(f"{key}: {value}\n" for key, value in lines.items()))
    for script in SCRIPTS:
        if scripts and (scripts / script).exists():
            put(scripts / script, control / script, 0o755)
    for name, text in (more or {}).items():
        (control / name).write_text(text)
    conffiles = [f for f in files if (tree / "etc") in f.parents]
    if conffiles:
        (control / "conffiles").write_text("".join(f"/{f.relative_to(tree)}\n" for f in conffiles))
    sums = (f"{hashlib.md5(f.read_bytes()).hexdigest()}  {f.relative_to(tree)}\n" for f in files)
    (control / "md5sums").write_text("".join(sums))
    os.makedirs(out, exist_ok=True)
    file = out / f"{fields['Package']}_{package['version']}_{architecture}.deb"
    run("dpkg-deb", "--root-owner-group", "--build", tree, file, stdout=subprocess.DEVNULL)
    print(file)


def empty(folder):
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder


def described(short, long):
    """A description as the control file has it."""
    paragraph = long.strip().replace("\n\n", "\n.\n").replace("\n", "\n ")
    return f"{short}\n {paragraph}"
