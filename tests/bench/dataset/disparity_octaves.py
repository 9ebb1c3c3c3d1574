#!/usr/bin/env python3
"""Compares the disparities of generated pairs with those of real ones, by octaves: draws both, prints one line of JSON.

    PYTHONPATH=common/python/parallax_data tests/bench/dataset/disparity_octaves.py REAL MIX... --out octaves.svg
REAL is a folder of pairs in Middlebury's layout; MIX is FOLDER=SHARE, a variant of a dataset and its share of the mixture.
Each pair of a set counts alike. `covered` says whether ours have at least half of the real pairs' share of pixels in each
octave.
"""
import argparse
import html
import json
from pathlib import Path

import numpy as np
from parallax_data import ParallaxDataset

EDGES_PX = [0, *(2.0**k for k in range(9)), np.inf]
NAMES = ["< 1", *(f"{2**k}" for k in range(8)), "> 256"]


def shares(disparity_px: np.ndarray) -> np.ndarray:
    """Shares of pixels in each octave, of those with a disparity."""
    counts = np.histogram(disparity_px, EDGES_PX)[0]
    return counts / max(1, counts.sum())


def read_pfm(path: Path) -> np.ndarray:
    with open(path, "rb") as file:
        assert file.readline().strip() == b"Pf", f"{path}: expected a grey PFM"
        width, height = map(int, file.readline().split())
        order = "<" if float(file.readline()) < 0 else ">"
        return np.frombuffer(file.read(), order + "f4", width * height)


def real_shares(folder: Path) -> np.ndarray:
    truths = [read_pfm(path) for path in sorted(folder.glob("*/disp0GT.pfm"))]
    return np.mean([shares(truth[np.isfinite(truth) & (truth > 0)]) for truth in truths], axis=0)


def our_shares(folder: str, scale: float, pairs: int) -> np.ndarray:
    data = ParallaxDataset(folder)
    chosen = np.unique(np.linspace(0, len(data) - 1, pairs).astype(int))
    return np.mean([shares(scale * pair.disparity[pair.valid]) for pair in (data[int(i)] for i in chosen)], axis=0)


def svg(rows: dict[str, np.ndarray]) -> str:
    """Bars of each octave, a colour a row."""
    colours, step, high = ["#333333", "#d95f02", "#1b9e77", "#7570b3", "#66a61e"], 70, 240
    most = max(row.max() for row in rows.values())
    parts = []
    for r, (name, row) in enumerate(rows.items()):
        width = (step - 10) / len(rows)
        parts.append(f'<text x="{60 + 110 * r}" y="20" fill="{colours[r % len(colours)]}">{name}</text>')
        for i, share in enumerate(row):
            tall = high * share / most
            parts.append(f'<rect x="{40 + step * i + width * r:.1f}" y="{40 + high - tall:.1f}" width="{width:.1f}" '
                         f'height="{tall:.1f}" fill="{colours[r % len(colours)]}"><title>{name}: {100 * share:.1f} %</title></rect>')
    for i, name in enumerate(NAMES):
        parts.append(f'<text x="{40 + step * i}" y="{high + 58}">{html.escape(name)}</text>')
    parts.append(f'<text x="40" y="{high + 78}">disparity from, px; the highest bar is {100 * most:.0f} % of the pixels</text>')
    return (f'<svg xmlns="http://www.w3.org/2000/svg" width="{60 + step * len(NAMES)}" height="{high + 90}" '
            f'font-family="sans-serif" font-size="12">{"".join(parts)}</svg>\n')


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    arguments.add_argument("real", type=Path)
    arguments.add_argument("mix", nargs="+", help="FOLDER=SHARE")
    arguments.add_argument("--scale", type=float, default=1, help="times the disparities, for pairs of another width than meant")
    arguments.add_argument("--pairs", type=int, default=100, help="pairs to read of each folder, spread evenly")
    arguments.add_argument("--out", type=Path, required=True)
    options = arguments.parse_args()
    rows, mixture, total = {"real": real_shares(options.real)}, np.zeros(len(NAMES)), 0.0
    for text in options.mix:
        folder, share = text.rsplit("=", 1)
        rows[Path(folder).name] = our_shares(folder, options.scale, options.pairs)
        mixture += float(share) * rows[Path(folder).name]
        total += float(share)
    rows["mixture"] = mixture / total
    options.out.write_text(svg(rows))
    short = [name for name, real, ours in zip(NAMES, rows["real"], rows["mixture"]) if ours < real / 2]
    print(json.dumps({"bench": "disparity_octaves", "from_px": NAMES, "covered": not short, "short": short,
                      **{name: [round(100 * float(share), 2) for share in row] for name, row in rows.items()}}))


if __name__ == "__main__":
    main()
