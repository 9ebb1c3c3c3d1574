"""The table of a frame's maps, frame_maps.csv: names of files, encodings, units. The programs are built from it, too."""

import csv
from pathlib import Path
from typing import Dict

import numpy as np

from . import exr, png

with open(Path(__file__).with_name("frame_maps.csv"), newline="", encoding="utf-8") as _table:
    FRAME_MAPS = list(csv.DictReader(_table))

_READERS = {"rgb8": png.read_rgb, "grey8": png.read_index, "index16": png.read_index, "float_y": exr.read_depth,
            "float_rgb": exr.read_flow, "half_rgb": exr.read_rgb}


def _stem(row: Dict[str, str]) -> str:
    return row["file"].split("_{")[0] if "_{" in row["file"] else ""


BY_STEM = {_stem(row): row for row in FRAME_MAPS}


def file_of(stem: str, eye: str, direction: str = "forward") -> str:
    """The name of an eye's file, of a row by its name without eye: "depth", "flow"; "": the picture."""
    if stem not in BY_STEM:
        raise ValueError(f"no map {stem!r}; there are {', '.join(filter(None, BY_STEM))}")
    return BY_STEM[stem]["file"].format(eye=eye, direction=direction)


def read(folder: Path, stem: str, eye: str, direction: str = "forward") -> np.ndarray:
    """A map as it is stored: float32 (height, width) or (height, width, 3), uint8 or uint16."""
    file = folder / file_of(stem, eye, direction)
    return _READERS[BY_STEM[stem]["encoding"]](file)
