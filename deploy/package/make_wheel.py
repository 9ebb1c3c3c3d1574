#!/usr/bin/env python3
"""Makes a wheel from a tree that package.sh collects: parallax-stereo or parallax-stereo-trainer.

A wheel holds programs with their libraries and commands that start them, the first one the reader parallax_data as well.
The same tree and SOURCE_DATE_EPOCH give the same bytes."""
import argparse
import base64
import hashlib
import os
import pathlib
import re
import runpy
import time
import zipfile

PROGRAMS = ("parallax", "coordinator", "worker", "trainer")
FOR_SHELLS = ("bash-completion", "zsh", "fish", "man")

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

READER_NEEDS = """Requires-Dist: numpy>=1.21
Requires-Dist: OpenEXR>=3.3
Requires-Dist: pillow>=9
Provides-Extra: client
Requires-Dist: grpcio>=1.49; extra == "client"
Requires-Dist: protobuf>=3.20; extra == "client"
Provides-Extra: torch
Requires-Dist: torch>=1.10; extra == "torch"
"""

METADATA = """Metadata-Version: 2.1
Name: {name}
Version: {version}
Summary: {summary}
License: See LICENSE
Requires-Python: >=3.9
{needs}Description-Content-Type: text/markdown

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


def without_files_beside(text):
    """Markdown without pictures and links that only work in the repository."""
    text = re.sub(r"^(\|.*\n)*\|.*!\[.*\n(\|.*\n)*|^!\[.*\n", "", text, flags=re.MULTILINE)
    return re.sub(r"\[([^\]]*)\]\((?!https?:)[^)]*\)", r"\1", text)


def main():
    args = argparse.ArgumentParser(description=__doc__)
    for option in ("--tree", "--out"):
        args.add_argument(option, type=pathlib.Path, required=True)
    args.add_argument("--name", required=True)
    args.add_argument("--version", required=True)
    args.add_argument("--tag", required=True, help="platforms, as in manylinux_2_17_x86_64; several with dots between")
    args.add_argument("--data", type=pathlib.Path, help="the reader's package; without it: programs for another wheel's folder")
    args = args.parse_args()

    name = args.name.replace("-", "_")
    info = f"{name}-{args.version}.dist-info"
    path = args.out / f"{name}-{args.version}-py3-none-{args.tag}.whl"
    wheel = Wheel(f"{path}.new", info)
    for part in ("bin", "libexec", "lib", "share"):
        for file in files_below(args.tree / part):
            data = b"wheel\n" if file.name == "installed_as" else file.read_bytes()
            place = file.relative_to(args.tree)
            # pip puts the data of a wheel below the environment's root, where shells and man look.
            folder = f"{name}-{args.version}.data/data" if place.parts[1] in FOR_SHELLS else "parallax_stereo"
            wheel.add(f"{folder}/{place}", data, executable=part != "share")
    if args.data:
        wheel.add("parallax_stereo/__init__.py", START.encode())
        for file in files_below(args.data):
            wheel.add(f"parallax_data/{file.relative_to(args.data)}", file.read_bytes())
        wheel.add("parallax_data/service.descriptors", runpy.run_path(str(args.data / "_messages.py"))["compiled"]())
        summary, needs = "Synthetic stereo datasets with exact ground truth, and which of them train well", READER_NEEDS
        text = without_files_beside((args.tree / "share/doc/parallax/README.md").read_text())
    else:
        summary, needs = "The built-in trainer of parallax-stereo", f"Requires-Dist: parallax-stereo=={args.version}\n"
        text = "Adds the program `trainer` to parallax-stereo.\n"
    head = METADATA.format(name=args.name, version=args.version, summary=summary, needs=needs)
    wheel.add(f"{info}/METADATA", (head + text).encode())
    tags = "".join(f"Tag: py3-none-{tag}\n" for tag in args.tag.split("."))
    wheel.add(f"{info}/WHEEL", f"Wheel-Version: 1.0\nGenerator: parallax\nRoot-Is-Purelib: false\n{tags}".encode())
    programs = [file.name for file in files_below(args.tree / "bin")]
    commands = "".join(f"{program} = parallax_stereo:{program}\n" for program in programs)
    wheel.add(f"{info}/entry_points.txt", f"[console_scripts]\n{commands}".encode())
    wheel.close()
    os.replace(f"{path}.new", path)
    print(path)


if __name__ == "__main__":
    main()
