#!/usr/bin/env python3
"""Draws how solving grows with rooms and objects: one dot a house, CPU seconds over objects.

  tests/bench/solve/growth.py BENCH_SOLVE OUT.svg [--scenes 4] [--mode full]

Runs `bench_solve --each` for houses of 1 to 8 rooms, writes the figure and prints the medians.
"""

import argparse
import re
import statistics
import subprocess

COLORS = ["#440154", "#46327e", "#365c8d", "#277f8e", "#1fa187", "#4ac16d", "#a0da39", "#e0c81c"]
LINE = re.compile(r"(\d+) rooms, (\d+) objects, .* CPU ([0-9.]+) s \+ ([0-9.]+) s")
WIDTH, HEIGHT, LEFT, BOTTOM, TOP, RIGHT = 560, 320, 56, 44, 16, 92


def measure(program, rooms, scenes, mode):
    """(objects, CPU seconds of the solve, of the meshes) of each house."""
    command = [program, "--each", "--mode", mode, "--kind", "living_room",
               "--rooms", str(rooms), "--scenes", str(scenes)]
    text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return [(int(o), float(s), float(m)) for _, o, s, m in LINE.findall(text)]


def draw(points):
    most_objects = 200 * (1 + max(p[1] for p in points) // 200)
    most_s = 2 * (1 + int(max(p[2] for p in points) / 2))

    def place(objects, seconds):
        return (LEFT + (WIDTH - LEFT - RIGHT) * objects / most_objects,
                HEIGHT - BOTTOM - (HEIGHT - BOTTOM - TOP) * seconds / most_s)

    svg = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" '
           'font-family="sans-serif" font-size="12">',
           f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>']
    for k in range(5):
        _, y = place(0, most_s * k / 4)
        x, _ = place(most_objects * k / 4, 0)
        svg.append(f'<line x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{y:.1f}" y2="{y:.1f}" '
                   'stroke="#ddd"/>')
        svg.append(f'<text x="{LEFT - 6}" y="{y + 4:.1f}" text-anchor="end">{most_s * k / 4:g}</text>')
        svg.append(f'<text x="{x:.1f}" y="{HEIGHT - BOTTOM + 16}" text-anchor="middle">'
                   f'{most_objects * k // 4}</text>')
    svg.append(f'<text x="{(LEFT + WIDTH - RIGHT) / 2}" y="{HEIGHT - 8}" text-anchor="middle">'
               'objects</text>')
    svg.append(f'<text x="14" y="{HEIGHT / 2}" text-anchor="middle" '
               f'transform="rotate(-90 14 {HEIGHT / 2})">CPU seconds of the solve</text>')
    for rooms, objects, seconds in points:
        x, y = place(objects, seconds)
        svg.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{COLORS[rooms - 1]}"/>')
    for rooms in range(1, 9):
        y = TOP + 18 * rooms
        svg.append(f'<circle cx="{WIDTH - RIGHT + 16}" cy="{y}" r="4" fill="{COLORS[rooms - 1]}"/>')
        svg.append(f'<text x="{WIDTH - RIGHT + 26}" y="{y + 4}">{rooms} room'
                   f'{"s" if rooms > 1 else ""}</text>')
    return "\n".join(svg + ["</svg>", ""])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("bench_solve")
    parser.add_argument("out")
    parser.add_argument("--scenes", type=int, default=4)
    parser.add_argument("--mode", default="full")
    options = parser.parse_args()
    points = []
    for rooms in range(1, 9):
        found = measure(options.bench_solve, rooms, options.scenes, options.mode)
        points += [(rooms, objects, seconds) for objects, seconds, _ in found]
        print(f"{rooms} rooms: {statistics.median(o for o, _, _ in found):.0f} objects, "
              f"solve {statistics.median(s for _, s, _ in found):.2f} CPU s, "
              f"meshes {statistics.median(m for _, _, m in found):.2f} CPU s", flush=True)
    with open(options.out, "w", encoding="utf-8") as out:
        out.write(draw(points))


if __name__ == "__main__":
    main()
