"""The table of figures over seeds in worker/scene/types/nature/README.md.

nature_table.py PROGRAM [--biomes A,B] [--seeds FIRST-LAST] [--out FOLDER]: runs nature_check once for
each biome and seed, each in a process of its own so that the peak of memory is its own, keeps its
JSON in FOLDER (what is there is not run again), and prints the rows as Markdown.
"""

import argparse
import json
import pathlib
import statistics
import subprocess
import sys

BIOMES = "plain,forest,mountain,river,coast,desert,canyon,cliff,arctic,snowy_mountain,cave"


def check(program, biome, seed, folder):
    """Returns nature_check's JSON object for one scene of 50 frames; raises if it crashes."""
    kept = folder / f"{biome}.{seed}.json"
    if not kept.exists():
        run = subprocess.run(
            [program, "--biome", biome, "--seed", str(seed), "--frames", "50", "--render", "0"],
            stdout=subprocess.PIPE, check=True, text=True)
        kept.write_text(run.stdout)
    return json.loads(kept.read_text())


def row(biome, scenes):
    """Returns the biome's row: medians, extremes and sums over its scenes."""
    solved = [scene for scene in scenes if "rejected" not in scene]
    solve_s = [scene["solve_s"] for scene in scenes]
    instances = [scene["instances"] / 1000 for scene in solved]
    cells = [
        biome.replace("_", " "), str(len(scenes)), str(len(scenes) - len(solved)),
        f"{statistics.median(solve_s):.1f} ({max(solve_s):.1f})",
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


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program", help="path of nature_check")
    parser.add_argument("--biomes", default=BIOMES)
    parser.add_argument("--seeds", default="7001-7010", help="first and last, included")
    parser.add_argument("--out", default="nature_table", type=pathlib.Path)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    first, last = map(int, options.seeds.split("-"))
    print("| biome | scenes | rejected | solve, core-s: median (most) | instances, thousands | "
          "different / placed triangles, millions, most | memory, GB | least clearance of an eye, m | "
          "largest recipe, kB | show daylight |")
    print("|" + "---|" * 10)
    for biome in options.biomes.split(","):
        scenes = [check(options.program, biome, seed, options.out)
                  for seed in range(first, last + 1)]
        print(row(biome, scenes), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
