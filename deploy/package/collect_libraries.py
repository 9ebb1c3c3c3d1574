#!/usr/bin/env python3
"""Copies the libraries that files need, with those that they need, and prints where each is from.

collect_libraries.py --out DIR [--system NAME...] [--unused PATTERN...] --files FILE...
--system names libraries to leave out, as `libc.so.6`. --unused names patterns of libraries that other ones ask for, but of
which nothing is ever called: Debian's libtorch asks for codecs of videos, and so for Qt, GDAL and ffmpeg. In place of each
a stub is made that has the asked-for symbols; a call of one ends the process with a message."""
import argparse
import fnmatch
import pathlib
import re
import shutil
import subprocess
import tempfile


def run(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def needed_by(path):
    return re.findall(r"\(NEEDED\).*\[(.*)\]", run("readelf", "-dW", path))


def symbols(path, which):
    """Name, version and kind of a library's dynamic symbols: "--undefined-only" or "--defined-only"."""
    for line in run("nm", "-D", which, path).splitlines():
        kind, name = line.split()[-2:]
        name, _, version = name.partition("@")
        yield name, version.lstrip("@"), kind


def make_stub(name, real, askers, out):
    """A library that has what `askers` want of `real`."""
    wanted = {name for asker in askers for name, _, _ in symbols(asker, "--undefined-only")}
    code, versions = ["#include <stdlib.h>", "#include <unistd.h>"], {}
    for symbol, version, kind in symbols(real, "--defined-only"):
        if symbol not in wanted:
            continue
        if kind in "TWi":
            text = f"{symbol} of {name} is not in this package\\n"
            code.append(f'void f{len(code)}(void) __asm__("{symbol}"); void f{len(code)}(void) '
                        f'{{ if (write(2, "{text}", {len(text) - 1}) != 0) abort(); }}')
        elif kind in "BDRVG":
            code.append(f'char d{len(code)}[4096] __asm__("{symbol}");')
        else:
            raise SystemExit(f"{real}: {symbol} is of kind {kind}")
        versions.setdefault(version, []).append(symbol)
    with tempfile.TemporaryDirectory() as work:
        source, script = pathlib.Path(work) / "stub.c", pathlib.Path(work) / "stub.map"
        source.write_text("\n".join(code) + "\n")
        named = "".join(f"{version} {{ global: {' '.join(f'{s};' for s in names)} }};\n" for version, names in versions.items() if version)
        script.write_text(named)
        options = [f"-Wl,--version-script={script}"] if named else []
        run("gcc", "-shared", "-fPIC", "-Os", "-s", source, "-o", out / name, f"-Wl,-soname,{name}", *options)


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("--out", type=pathlib.Path, required=True)
    arguments.add_argument("--system", nargs="*", default=[])
    arguments.add_argument("--unused", nargs="*", default=[])
    arguments.add_argument("--files", nargs="+", type=pathlib.Path, required=True)
    options = arguments.parse_args()
    paths = dict(re.findall(r"^\t(\S+) => (/\S+)", run("ldd", *options.files), re.MULTILINE))
    waiting, askers, kept = list(options.files), {}, {}
    while waiting:
        asker = waiting.pop()
        for name in needed_by(asker):
            if name in options.system:
                continue
            if any(fnmatch.fnmatch(name, pattern) for pattern in options.unused):
                askers.setdefault(name, []).append(asker)
            elif name not in kept:
                kept[name] = paths[name]
                waiting.append(pathlib.Path(paths[name]))
    for name, path in sorted(kept.items()):
        shutil.copy(path, options.out / name)
        print(path)
    for name, asking in sorted(askers.items()):
        make_stub(name, paths[name], asking, options.out)


if __name__ == "__main__":
    main()
