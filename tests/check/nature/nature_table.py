"""The tables of figures over seeds in worker/scene/types/nature/README.md.

nature_table.py PROGRAM [--biomes A,B] [--seeds FIRST-LAST] [--render WxH] [--out FOLDER]: runs
nature_check once for each biome and seed, each in a process of its own so that the peak of memory
is its own; it renders the middle frame of the walk (profile `preview`). Keeps its JSON and picture
in FOLDER (what is there is not run again), and prints two tables as Markdown: scenes, and what
their middle frames show.
"""

import argparse
import json
import pathlib
import statistics
import subprocess
import sys

BIOMES = "plain,forest,mountain,river,coast,desert,canyon,cliff,arctic,snowy_mountain,cave"
SCENE_COLUMNS = [
    "biome", "scenes", "rejected", "solve, core-s: median (most)",
    "expand and build, core-s: median (most)", "instances, thousands",
    "different / placed triangles, millions, most", "memory, GB, most",
    "least clearance of an eye, m", "largest recipe, kB", "show daylight"]
VIEW_COLUMNS = [
    "biome", "nothing nearer than 5 m, % of frames",
    "median disparity at 1280 px: median (least to most)", "below 4 px, % of things",
    "sky, % of pixels", "`mixed`, % of pixels", "`mixed`, most, %", "mean level", "darkest"]


def check(program, biome, seed, rendered, folder):
    """Returns nature_check's JSON object for one scene of 50 frames; raises if it crashes."""
    kept = folder / f"{biome}.{seed}.json"
    if not kept.exists():
        run = subprocess.run(
            [program, "--biome", biome, "--seed", str(seed), "--frames", "50", "--render", "1",
             "--profile", "preview", "--size", rendered, "--out", str(folder)],
            stdout=subprocess.PIPE, check=True, text=True)
        kept.write_text(run.stdout)
    return json.loads(kept.read_text())


def scene_row(biome, scenes):
    """Returns the biome's row of the first table: medians, extremes and sums over its scenes."""
    solved = [scene for scene in scenes if "rejected" not in scene]
    solve_s = [scene["solve_s"] for scene in scenes]
    ready_s = [scene["build_s"] + scene["create_s"] for scene in solved]
    instances = [scene["instances"] / 1000 for scene in solved]
    cells = [
        biome.replace("_", " "), str(len(scenes)), str(len(scenes) - len(solved)),
        f"{statistics.median(solve_s):.1f} ({max(solve_s):.1f})",
        f"{statistics.median(ready_s):.1f} ({max(ready_s):.1f})",
        f"{min(instances):.1f} to {max(instances):.1f}",
        f"{max(scene['unique_triangles'] for scene in solved) / 1e6:.1f} / "
        f"{max(scene['placed_triangles'] for scene in solved) / 1e6:.0f}",
        f"{max(scene['peak_mb'] for scene in solved) / 1000:.2f}",
        f"{min(scene['clearance_m'] for scene in solved):.2f}",
        f"{max(scene['recipe_bytes'] for scene in solved) / 1000:.1f}",
        f"{sum(scene['roots']['daylight'] for scene in solved)} of "
        f"{sum(scene['roots']['checked'] for scene in solved):,}",
    ]
    return "| " + " | ".join(cells) + " |"


def view_row(biome, scenes, to_1280):
    """Returns the biome's row of the second table; `to_1280`: 1280 / rendered width."""
    solved = [scene for scene in scenes if "rejected" not in scene]

    def median(values):
        return f"{statistics.median(values):.0f}"

    def percent(key):
        return f"{100 * statistics.mean(scene[key] for scene in solved):.1f}"

    medians = [to_1280 * scene["disparity_px"].get("50", 0) for scene in solved]
    cells = [
        biome.replace("_", " "),
        f"{100 * statistics.mean(scene['frames_beyond_5_m'] for scene in solved):.0f}",
        f"{median(medians)} ({min(medians):.0f} to {max(medians):.0f})",
        percent("below_4_px_of_1280_share"), percent("sky_share"),
        percent("mixed_share"),
        f"{100 * max(scene['mixed_share'] for scene in solved):.1f}",
        median([scene["mean_level"] for scene in solved]),
        f"{min(scene['mean_level'] for scene in solved):.0f}",
    ]
    return "| " + " | ".join(cells) + " |"


def head(columns):
    """Returns the two lines that begin a table of Markdown."""
    return "| " + " | ".join(columns) + " |\n|" + "---|" * len(columns)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program", help="path of nature_check")
    parser.add_argument("--biomes", default=BIOMES)
    parser.add_argument("--seeds", default="7001-7010", help="first and last, included")
    parser.add_argument("--render", default="640x360", help="size of what is rendered")
    parser.add_argument("--out", default="nature_table", type=pathlib.Path)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    first, last = map(int, options.seeds.split("-"))
    width = int(options.render.split("x")[0])
    views = []
    print(head(SCENE_COLUMNS))
    for biome in options.biomes.split(","):
        scenes = [check(options.program, biome, seed, options.render, options.out)
                  for seed in range(first, last + 1)]
        print(scene_row(biome, scenes), flush=True)
        views.append(view_row(biome, scenes, 1280 / width))
    print("\n".join(["", head(VIEW_COLUMNS), *views]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
