"""A sheet of left images: a row a biome, a column a seed.

nature_sheet.py PROGRAM SHEET.jpg [--biomes A,B] [--seeds FIRST-LAST] [--size WxH] [--render WxH]
[--columns N] [--out FOLDER]: puts pictures of nature_table.py, the middle frame of each walk, side by
side, reduced to `--size`: plants have the detail that the rendered size asks for. What is missing in
FOLDER is rendered. A biome takes as many rows as its scenes fill. A rejected scene is a grey tile.
"""

import argparse
import pathlib
import sys

import cv2
import numpy as np

from nature_table import BIOMES, check


def tile(program, biome, seed, size, rendered, folder):
    """Returns the scene's picture, BGR, in `size`; raises if nature_check crashes."""
    width, height = map(int, size.split("x"))
    check(program, biome, seed, rendered, folder)
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
    parser.add_argument("--columns", type=int, help="scenes a row (default: all)")
    parser.add_argument("--out", default="nature_table", type=pathlib.Path)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    first, last = map(int, options.seeds.split("-"))
    seeds = range(first, last + 1)
    columns = options.columns or len(seeds)
    rows = []
    for biome in options.biomes.split(","):
        tiles = [tile(options.program, biome, seed, options.size, options.render, options.out)
                 for seed in seeds]
        tiles += [np.full_like(tiles[0], 255)] * (-len(tiles) % columns)
        rows += [np.hstack(tiles[k:k + columns]) for k in range(0, len(tiles), columns)]
    if not cv2.imwrite(options.sheet, np.vstack(rows), [cv2.IMWRITE_JPEG_QUALITY, 82]):
        raise OSError(f"cannot write {options.sheet}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
