"""A sheet of left images: a row a biome, a column a seed.

nature_sheet.py PROGRAM SHEET.jpg [--biomes A,B] [--seeds FIRST-LAST] [--size WxH] [--render WxH]
[--out FOLDER]: runs nature_check once for each biome and seed, which renders the middle frame of
its walk (profile `preview`), and puts the pictures side by side, reduced to `--size`: plants have
the detail that the rendered size asks for. What is in FOLDER is not rendered again. A rejected
scene is a grey tile.
"""

import argparse
import pathlib
import subprocess
import sys

import cv2
import numpy as np

from nature_table import BIOMES


def tile(program, biome, seed, size, rendered, folder):
    """Returns the scene's picture, BGR, in `size`; raises if nature_check crashes."""
    width, height = map(int, size.split("x"))
    pictures = sorted(folder.glob(f"{biome}_{seed}_*.png"))
    if not pictures:
        subprocess.run(
            [program, "--biome", biome, "--seed", str(seed), "--frames", "50", "--render", "1",
             "--profile", "preview", "--size", rendered, "--out", str(folder)],
            stdout=subprocess.DEVNULL, check=True)
        pictures = sorted(folder.glob(f"{biome}_{seed}_*.png"))
    if not pictures:
        return np.full((height, width, 3), 128, np.uint8)
    return cv2.resize(cv2.imread(str(pictures[0])), (width, height), interpolation=cv2.INTER_AREA)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program", help="path of nature_check")
    parser.add_argument("sheet", help="the JPEG to write")
    parser.add_argument("--biomes", default=BIOMES)
    parser.add_argument("--seeds", default="7001-7006", help="first and last, included")
    parser.add_argument("--size", default="320x180", help="of a tile")
    parser.add_argument("--render", default="640x360", help="of what is rendered")
    parser.add_argument("--out", default="nature_sheet", type=pathlib.Path)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    first, last = map(int, options.seeds.split("-"))
    rows = [
        np.hstack([tile(options.program, biome, seed, options.size, options.render, options.out)
                   for seed in range(first, last + 1)])
        for biome in options.biomes.split(",")
    ]
    if not cv2.imwrite(options.sheet, np.vstack(rows), [cv2.IMWRITE_JPEG_QUALITY, 82]):
        raise OSError(f"cannot write {options.sheet}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
