"""Cost and quality of landscapes, a row a biome: the table in worker/scene/types/nature/README.md.

bench_nature.py PROGRAM [--biomes A,B] [--seed N] [--pairs N] [--reference-spp N] [--out FOLDER]:
runs bench_render once for each biome on a scene of 50 frames, keeps its JSON in FOLDER (what is
there is not run again), and prints the rows as Markdown.
"""

import argparse
import json
import pathlib
import re
import subprocess
import sys

from nature_table import BIOMES

NATURE = pathlib.Path(__file__).parents[3] / "configs/scenes/nature.yaml"


def measure(options, biome):
    """Returns bench_render's JSON object for one scene; raises if it fails."""
    kept = options.out / f"{biome}.{options.seed}.json"
    if not kept.exists():
        config = options.out / f"{biome}.yaml"
        weights = ", ".join(f"{name}: {int(name == biome)}" for name in BIOMES.split(","))
        config.write_text(re.sub(r"biomes: {[^}]*}", f"biomes: {{{weights}}}", NATURE.read_text()))
        run = subprocess.run(
            [options.program, f"solve:{options.seed}:{config}", "--pairs", str(options.pairs),
             "--quality-rigs", "2", "--quality-width", "128",
             "--reference-spp", str(options.reference_spp)],
            stdout=subprocess.PIPE, check=True, text=True)
        kept.write_text(run.stdout)
    return json.loads(kept.read_text())


def row(biome, seen):
    """Returns the biome's row."""
    fixed = seen["geometry_core_s_per_scene"] + seen["build_core_s_per_scene"]
    cells = [
        biome.replace("_", " "), f"{seen['core_s_per_pair_of_scene']:.1f}", f"{fixed:.1f}",
        f"{seen['peak_mb'] / 1000:.2f}", f"{seen['psnr_db']:.1f}",
        f"{seen['radiance_over_reference']:.3f}",
    ]
    return "| " + " | ".join(cells) + " |"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program", help="path of bench_render")
    parser.add_argument("--biomes", default=BIOMES)
    parser.add_argument("--seed", default=7002, type=int)
    parser.add_argument("--pairs", default=4, type=int, help="at least 2")
    parser.add_argument("--reference-spp", default=64, type=int, help="of each of two references")
    parser.add_argument("--out", default="bench_nature", type=pathlib.Path)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    print("| biome | core-s a pair, in scenes of 50 | of a scene: expand and build, core-s | "
          "memory, GB | PSNR, dB | radiance / reference's |")
    print("|---|---|---|---|---|---|")
    for biome in options.biomes.split(","):
        print(row(biome, measure(options, biome)), flush=True)


if __name__ == "__main__":
    sys.exit(main())
