"""A sheet of left images: a row a biome, a column a seed.

nature_sheet.py PROGRAM SHEET.jpg [--biomes A,B] [--seeds FIRST-LAST] [--size WxH] [--out FOLDER]: runs
nature_check once for each biome and seed, which renders the middle frame of its walk (profile
`preview`), and puts the pictures side by side. What is in FOLDER is not rendered again. A rejected
scene is a grey tile.
"""

import argparse
import pathlib
import subprocess
import sys

import cv2
import numpy as np

from nature_table import BIOMES


def tile(program, biome, seed, size, folder):
    """Returns the scene's picture, BGR; raises if nature_check crashes."""
    width, height = map(int, size.split("x"))
    pictures = sorted(folder.glob(f"{biome}_{seed}_*.png"))
    if not pictures:
        subprocess.run(
            [program, "--biome", biome, "--seed", str(seed), "--frames", "50", "--render", "1",
             "--profile", "preview", "--size", size, "--out", str(folder)],
            stdout=subprocess.DEVNULL, check=True)
        pictures = sorted(folder.glob(f"{biome}_{seed}_*.png"))
    if not pictures:
        return np.full((height, width, 3), 128, np.uint8)
    return cv2.imread(str(pictures[0]))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program", help="path of nature_check")
    parser.add_argument("sheet", help="the JPEG to write")
    parser.add_argument("--biomes", default=BIOMES)
    parser.add_argument("--seeds", default="7001-7006", help="first and last, included")
    parser.add_argument("--size", default="320x180")
    parser.add_argument("--out", default="nature_sheet", type=pathlib.Path)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    first, last = map(int, options.seeds.split("-"))
    rows = [
        np.hstack([tile(options.program, biome, seed, options.size, options.out)
                   for seed in range(first, last + 1)])
        for biome in options.biomes.split(",")
    ]
    if not cv2.imwrite(options.sheet, np.vstack(rows), [cv2.IMWRITE_JPEG_QUALITY, 82]):
        raise OSError(f"cannot write {options.sheet}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
