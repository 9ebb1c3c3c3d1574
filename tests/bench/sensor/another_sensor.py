#!/usr/bin/env python3
"""What another sensor costs on a dataset that is rendered: CPU seconds a pair, and that nothing is rendered.

    tests/bench/sensor/another_sensor.py OUT [--pairs 100] [--presets industrial,webcam] [--workers 1]

Makes the dataset of tests/bench/sensor/study.yaml in OUT, unless it is there, then gives the same study each preset in
turn, with `parallax run`. Prints one JSON line. `core_s_per_pair`: what the run costs beyond one that changes nothing,
by the kernel's count of the program and its workers; reading the linear pictures and packing PNG files included. Fails if
a run renders a pair or furnishes a scene, or if a picture stays as it was.
"""
import argparse
import hashlib
import json
import os
import pathlib
import re
import resource
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
PRESETS = "industrial,stereo_module,webcam,phone"


def first_line_of(*command):
    done = subprocess.run(command, cwd=HERE, capture_output=True, text=True)
    return done.stdout.strip().split("\n")[0]


def machine():
    model = re.search(r"model name\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text())
    return f"{model.group(1) if model else 'unknown'}, {os.cpu_count()} cores"


class Dataset:
    def __init__(self, options):
        self.options = options
        self.out = pathlib.Path(options.out)
        self.study = self.out.parent / (self.out.name + ".yaml")

    def run(self, preset):
        """(the run's report, CPU seconds) with this sensor."""
        text = (HERE / "study.yaml").read_text().replace("preset: 'off'", f"preset: {preset!r}")
        self.study.write_text(text)
        command = [self.options.parallax, "run", str(self.study), "--out", str(self.out), "--yes", "--json",
                   "--workers", str(self.options.workers), "--pairs", str(self.options.pairs)]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if done.returncode != 0:
            sys.exit(f"another_sensor: {' '.join(command)}: exit {done.returncode}\n{done.stderr[-2000:]}")
        return json.loads(done.stdout), after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    def pictures(self):
        return {str(path.relative_to(self.out)): hashlib.sha256(path.read_bytes()).hexdigest()
                for side in ("left", "right") for path in self.out.glob(f"pairs/**/{side}.png")}


def work_in(report):
    """What the run made that was not there; empty if nothing."""
    made = {"pairs rendered": report["pairs_rendered"],
            "pairs not reused": report["pairs_done"] - report["frames_reused"],
            "solves not reused": report["solves_done"] - report["solves_reused"],
            "core-seconds in jobs": round(report["core_seconds"], 1)}
    return [f"{count} {name}" for name, count in made.items() if count != 0]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out")
    parser.add_argument("--pairs", type=int, default=100)
    parser.add_argument("--presets", default=PRESETS)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--parallax", default=str(HERE.parents[2] / "build/release/bin/parallax"))
    options = parser.parse_args()
    dataset = Dataset(options)
    dataset.run("off")
    _, idle_s = dataset.run("off")
    pictures = dataset.pictures()
    costs = {}
    for preset in options.presets.split(","):
        report, cpu_s = dataset.run(preset)
        now = dataset.pictures()
        problems = work_in(report)
        if now.keys() != pictures.keys() or any(now[name] == pictures[name] for name in now):
            problems.append("pictures are missing or as they were")
        if problems:
            sys.exit(f"another_sensor: {preset}: " + ", ".join(problems))
        costs[preset] = {"core_s_per_pair": round((cpu_s - idle_s) / options.pairs, 3),
                         "pairs_rendered": report["pairs_rendered"], "pairs_reused": report["frames_reused"]}
        pictures = now
    print(json.dumps({"bench": "another_sensor",
                      "core_s_per_pair": max(cost["core_s_per_pair"] for cost in costs.values()),
                      "presets": costs, "unchanged_run_core_s": round(idle_s, 2), "pairs": options.pairs,
                      "machine": machine(), "commit": first_line_of("git", "rev-parse", "--short", "HEAD"),
                      "command": " ".join(["tests/bench/sensor/another_sensor.py", *sys.argv[1:]])}))


if __name__ == "__main__":
    main()
