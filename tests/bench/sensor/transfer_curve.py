#!/usr/bin/env python3
"""Draws the photon transfer curve of the sensors' presets: noise over signal, in electrons.

    tests/bench/sensor/transfer_curve.py BENCH_SENSOR OUT.svg [--side 512]

Runs BENCH_SENSOR for the device in the middle of each preset's ranges. Dots are measured, lines are the model; both axes
are logarithmic. Read noise is where a line begins, shot noise its slope of 1/2, the full well where it falls.
"""

import argparse
import csv
import math
import subprocess
import tempfile

COLORS = {"phone": "#440154", "webcam": "#31688e", "stereo_module": "#35b779", "industrial": "#e08a00"}
WIDTH, HEIGHT, LEFT, BOTTOM, TOP, RIGHT = 760, 440, 64, 52, 16, 196
SIGNAL, NOISE = (1, 40000), (1, 300)  # Electrons at the ends of the axes.


def measure(program, side):
    """The rows of the program's table with a signal."""
    with tempfile.NamedTemporaryFile(suffix=".csv") as table:
        subprocess.run([program, "--csv", table.name, "--devices", "0", "--side", str(side)], check=True)
        with open(table.name, newline="") as file:
            rows = [{key: value if key == "preset" else float(value) for key, value in row.items()}
                    for row in csv.DictReader(file)]
    return [row for row in rows if row["electrons"] >= SIGNAL[0]]


def place(signal, noise):
    def share(value, ends):
        return math.log(value / ends[0]) / math.log(ends[1] / ends[0])

    return (LEFT + (WIDTH - LEFT - RIGHT) * share(signal, SIGNAL),
            HEIGHT - BOTTOM - (HEIGHT - BOTTOM - TOP) * share(noise, NOISE))


def ticks(ends):
    return [10 ** k for k in range(int(math.log10(ends[1])) + 1)]


def axes():
    right, bottom = WIDTH - RIGHT, HEIGHT - BOTTOM
    svg = []
    for signal in ticks(SIGNAL):
        x, _ = place(signal, 1)
        svg.append(f'<line x1="{x:.1f}" x2="{x:.1f}" y1="{TOP}" y2="{bottom}" stroke="#ddd"/>')
        svg.append(f'<text x="{x:.1f}" y="{bottom + 18}" text-anchor="middle">{signal:,}</text>')
    for noise in ticks(NOISE):
        _, y = place(1, noise)
        svg.append(f'<line x1="{LEFT}" x2="{right}" y1="{y:.1f}" y2="{y:.1f}" stroke="#ddd"/>')
        svg.append(f'<text x="{LEFT - 6}" y="{y + 4:.1f}" text-anchor="end">{noise:,}</text>')
    svg.append(f'<text x="{(LEFT + right) / 2}" y="{HEIGHT - 12}" text-anchor="middle">signal [e-]</text>')
    svg.append(f'<text x="16" y="{(TOP + bottom) / 2}" text-anchor="middle" '
               f'transform="rotate(-90 16 {(TOP + bottom) / 2})">noise [e- rms]</text>')
    return svg


def shot_noise():
    """The line that no sensor passes, with its name along it."""
    (x1, y1), (x2, y2) = place(*[SIGNAL[0], 1]), place(SIGNAL[1], math.sqrt(SIGNAL[1]))
    x, y = place(3, math.sqrt(3))
    angle = math.degrees(math.atan2(y2 - y1, x2 - x1))
    return [f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="#888" stroke-dasharray="5 4"/>',
            f'<text x="{x:.1f}" y="{y + 16:.1f}" fill="#666" transform="rotate({angle:.1f} {x:.1f} {y + 16:.1f})">'
            'shot noise alone</text>']


def curve(rows, color):
    line = " ".join("{:.1f},{:.1f}".format(*place(row["model_mean_e"], math.sqrt(row["model_variance_e2"])))
                    for row in rows)
    svg = [f'<polyline points="{line}" fill="none" stroke="{color}" stroke-width="1.5"/>']
    for row in rows:
        x, y = place(row["mean_e"], math.sqrt(row["variance_e2"]))
        svg.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{color}"/>')
    return svg


def key(curves):
    x = WIDTH - RIGHT + 16
    svg = []
    for number, (preset, rows) in enumerate(curves):
        y = TOP + 14 + 42 * number
        svg.append(f'<line x1="{x}" x2="{x + 20}" y1="{y}" y2="{y}" stroke="{COLORS[preset]}" stroke-width="1.5"/>')
        svg.append(f'<circle cx="{x + 10}" cy="{y}" r="3" fill="{COLORS[preset]}"/>')
        svg.append(f'<text x="{x + 28}" y="{y + 4}">{preset}</text>')
        svg.append(f'<text x="{x + 28}" y="{y + 19}" fill="#666" font-size="11">'
                   f'white {rows[0]["white_e"]:,.0f} e-, read {rows[0]["read_noise_e"]:g} e-</text>')
    y = TOP + 14 + 42 * len(curves) + 6
    svg.append(f'<text x="{x}" y="{y}" fill="#666" font-size="11">dots measured, lines the model</text>')
    return svg


def draw(rows):
    curves = [(preset, [row for row in rows if row["preset"] == preset]) for preset in COLORS]
    svg = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" '
           f'viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="13">',
           f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>', *axes(), *shot_noise()]
    for preset, of_preset in curves:
        svg += curve(of_preset, COLORS[preset])
    return "\n".join(svg + key(curves) + ["</svg>", ""])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("out")
    parser.add_argument("--side", type=int, default=512)
    options = parser.parse_args()
    rows = measure(options.program, options.side)
    with open(options.out, "w") as file:
        file.write(draw(rows))


if __name__ == "__main__":
    main()
