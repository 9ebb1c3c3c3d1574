#!/usr/bin/env python3
"""Overwrites with zeros the networks in Open Image Denoise that worker/render/film/denoiser.cc never asks for.

drop_weights.py LIBRARY: libOpenImageDenoise_core.so.2, changed in place. Its networks are nine tenths of it and hardly
compress. The library finds a network of zeros invalid, and says so if it is ever asked for one."""
import pathlib
import struct
import subprocess
import sys

# The filter RT for pictures of high range with clean albedo and normals; in all qualities.
KEPT = "rt_hdr_calb_cnrm"
PREFIX = "_ZN4oidn5blobs7weights"


def segments(data):
    """File offset, address and size in the file of each loaded part."""
    at, size, count = (*struct.unpack_from("<Q", data, 32), *struct.unpack_from("<HH", data, 54))
    for i in range(count):
        kind, _, offset, address, _, in_file = struct.unpack_from("<IIQQQQ", data, at + i * size)
        if kind == 1:
            yield offset, address, in_file


def main():
    library = pathlib.Path(sys.argv[1])
    data = bytearray(library.read_bytes())
    parts = list(segments(data))
    listed = subprocess.run(["nm", "-D", "-S", "--defined-only", library], check=True, capture_output=True, text=True).stdout
    networks = [line.split() for line in listed.splitlines() if PREFIX in line]
    kept = [words for words in networks if KEPT in words[3]]
    if not kept or len(kept) == len(networks):
        sys.exit(f"{library}: {len(networks)} networks, {len(kept)} of them {KEPT}: not the library that this was written for")
    for address, size, _, _ in (words for words in networks if words not in kept):
        address, size = int(address, 16), int(size, 16)
        offset = next(o + address - a for o, a, n in parts if a <= address and address + size <= a + n)
        data[offset:offset + size] = bytes(size)
    library.write_bytes(data)


if __name__ == "__main__":
    main()
