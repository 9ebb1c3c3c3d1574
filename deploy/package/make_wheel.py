#!/usr/bin/env python3
"""Makes the wheel parallax-stereo from the tree that package.sh collects.

The wheel holds the programs with their libraries, commands that start them, and the reader parallax_data.
The same tree and SOURCE_DATE_EPOCH give the same bytes."""
import argparse
import base64
import hashlib
import os
import pathlib
import time
import zipfile

PROGRAMS = ("parallax", "coordinator", "worker", "trainer")

START = '''"""Starts the programs of Parallax that are in this package."""
import os
import sys

_HERE = os.path.dirname(os.path.abspath(__file__))


def path(program):
    """Absolute path of a program: "parallax", "coordinator", "worker" or "trainer"."""
    return os.path.join(_HERE, "bin", program)


def _start(program):
    os.execv(path(program), [program] + sys.argv[1:])


''' + "\n\n".join(f'def {name}():\n    _start("{name}")\n' for name in PROGRAMS)

METADATA = """Metadata-Version: 2.1
Name: parallax-stereo
Version: {version}
Summary: Synthetic stereo datasets with exact ground truth, and which of them train well
License: See LICENSE
Requires-Python: >=3.9
Requires-Dist: numpy>=1.21
Requires-Dist: OpenEXR>=3.3
Requires-Dist: pillow>=9
Provides-Extra: torch
Requires-Dist: torch>=1.10; extra == "torch"
Description-Content-Type: text/markdown

"""


class Wheel:
    """A zip file in the layout of PEP 427, with hashes of all that was added."""

    def __init__(self, path, info):
        self.zip = zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9)
        self.info, self.record = info, []
        self.time = time.gmtime(max(int(os.environ.get("SOURCE_DATE_EPOCH", "0")), 315532800))[:6]

    def add(self, name, data, executable=False):
        entry = zipfile.ZipInfo(name, self.time)
        entry.external_attr = (0o100755 if executable else 0o100644) << 16
        entry.compress_type = zipfile.ZIP_DEFLATED
        self.zip.writestr(entry, data)
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        self.record.append(f"{name},sha256={digest},{len(data)}")

    def close(self):
        name = f"{self.info}/RECORD"
        self.record.append(f"{name},,")
        self.zip.writestr(zipfile.ZipInfo(name, self.time), "\n".join(self.record) + "\n")
        self.zip.close()


def files_below(folder):
    return sorted(p for p in folder.rglob("*") if p.is_file() and "__pycache__" not in p.parts)


def main():
    args = argparse.ArgumentParser(description=__doc__)
    for option in ("--tree", "--data", "--out"):
        args.add_argument(option, type=pathlib.Path, required=True)
    args.add_argument("--version", required=True)
    args.add_argument("--glibc", required=True, help="oldest glibc, as in 2.36")
    args = args.parse_args()

    tag = f"py3-none-manylinux_{args.glibc.replace('.', '_')}_x86_64"
    info = f"parallax_stereo-{args.version}.dist-info"
    path = args.out / f"parallax_stereo-{args.version}-{tag}.whl"
    wheel = Wheel(f"{path}.new", info)
    wheel.add("parallax_stereo/__init__.py", START.encode())
    for part in ("bin", "lib", "share"):
        for file in files_below(args.tree / part):
            name = f"parallax_stereo/{file.relative_to(args.tree)}"
            wheel.add(name, file.read_bytes(), executable=part != "share")
    for file in files_below(args.data):
        wheel.add(f"parallax_data/{file.relative_to(args.data)}", file.read_bytes())
    readme = (args.tree / "share/doc/parallax/README.md").read_text()
    wheel.add(f"{info}/METADATA", (METADATA.format(version=args.version) + readme).encode())
    wheel.add(f"{info}/WHEEL", f"Wheel-Version: 1.0\nGenerator: parallax\nRoot-Is-Purelib: false\nTag: {tag}\n".encode())
    commands = "".join(f"{name} = parallax_stereo:{name}\n" for name in PROGRAMS)
    wheel.add(f"{info}/entry_points.txt", f"[console_scripts]\n{commands}".encode())
    wheel.close()
    os.replace(f"{path}.new", path)


if __name__ == "__main__":
    main()
