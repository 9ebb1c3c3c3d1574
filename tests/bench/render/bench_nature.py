#!/usr/bin/env python3
"""Cost and quality of landscapes, biome by biome; prints a table, and JSON lines with --json.

    tests/bench/render/bench_nature.py --program build/release/bin/bench_render
    tests/bench/render/bench_nature.py --program NEW --before OLD --biomes forest,plain --seeds 7002

Runs bench_render for each biome and seed: one pair and three, whose difference is a pair's own cost and whose rest is
the scene's; then parts of its pictures against the reference. Costs are core-seconds a pair in scenes of 50. With
--before each run of one program is followed by the same of the other, so that both see the same machine.
"""
import argparse
import json
import math
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).parents[3]
NATURE = ROOT / "configs/scenes/nature.yaml"
WEIGHTS = re.compile(r"biomes: \{([^}]*)\}")
PAIRS_OF_A_SCENE = 50


def mix():
    """The default weights of the biomes, by name."""
    pairs = WEIGHTS.search(NATURE.read_text()).group(1).split(",")
    return {name.strip(): float(weight) for name, weight in (pair.split(":") for pair in pairs)}


def run(program, scene, *options):
    done = subprocess.run([program, scene, *options], stdout=subprocess.PIPE, text=True)
    if done.returncode != 0:
        sys.exit(f"{program} {scene}: exit {done.returncode}")
    return json.loads(done.stdout.splitlines()[-1])


def costs(program, scene):
    """(core-seconds a pair, of a scene, peak megabytes)"""
    one, three = (run(program, scene, "--pairs", str(n), "--quality-rigs", "0") for n in (1, 3))
    pair = (3 * three["core_s_per_pair"] - one["core_s_per_pair"]) / 2
    return pair, max(0.0, one["core_s_per_pair"] - pair), three["peak_mb"]


def quality(program, scene, options):
    return run(program, scene, "--pairs", "0", "--quality-rigs", str(options.rigs), "--reference-spp",
               str(options.reference_spp), "--quality-width", "160")


def measure(program, scene, options):
    pair, of_scene, peak = costs(program, scene)
    row = {"core_s": pair + of_scene / PAIRS_OF_A_SCENE, "pair_core_s": pair, "scene_core_s": of_scene, "peak_mb": peak}
    if options.rigs > 0:
        seen = quality(program, scene, options)
        row |= {key: seen[key] for key in ("psnr_db", "radiance_over_reference", "stereo_rms")}
    return row


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", required=True, help="bench_render")
    parser.add_argument("--before", help="bench_render of the commit to compare with")
    parser.add_argument("--biomes", default=",".join(mix()), help="default: all")
    parser.add_argument("--seeds", default="7002,7003,7004")
    parser.add_argument("--rigs", type=int, default=2, help="pictures compared with the reference; 0: none")
    parser.add_argument("--reference-spp", type=int, default=96)
    parser.add_argument("--json", action="store_true", help="print a JSON line a run instead of the table")
    options = parser.parse_args()
    programs = {"now": options.program} | ({"before": options.before} if options.before else {})
    names = ["core_s", "pair_core_s", "scene_core_s", "peak_mb"]
    names += ["psnr_db", "radiance_over_reference", "stereo_rms"] if options.rigs > 0 else []
    means = {which: {} for which in programs}
    with tempfile.TemporaryDirectory() as folder:
        for biome in options.biomes.split(","):
            config = pathlib.Path(folder) / f"{biome}.yaml"
            config.write_text(WEIGHTS.sub(f"biomes: {{{biome}: 1}}", NATURE.read_text()))
            rows = {which: [] for which in programs}
            for seed in options.seeds.split(","):
                for which, program in programs.items():
                    row = measure(program, f"solve:{seed}:{config}", options)
                    rows[which].append(row)
                    if options.json:
                        print(json.dumps({"biome": biome, "seed": int(seed), "program": which} | row), flush=True)
            for which in programs:
                means[which][biome] = {name: statistics.mean(row[name] for row in rows[which]) for name in names}
    if options.json:
        return
    weights = mix()
    for which, biomes in means.items():
        print(f"\n{which:16}" + "".join(f"{name:>26}" for name in names))
        for biome, row in biomes.items():
            print(f"{biome:16}" + "".join(f"{row[name]:26.3f}" for name in names))
        total = sum(weights[biome] for biome in biomes)
        mean = sum(weights[biome] * row["core_s"] for biome, row in biomes.items()) / total
        print(f"{'mean of the mix':16}{mean:26.3f}")
    if options.before:
        ratios = [means["now"][biome]["core_s"] / means["before"][biome]["core_s"] for biome in means["now"]]
        print(f"\ncost over before: {math.exp(statistics.mean(map(math.log, ratios))):.3f} (geometric mean)")


if __name__ == "__main__":
    main()
