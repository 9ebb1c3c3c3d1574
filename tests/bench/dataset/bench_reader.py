#!/usr/bin/env python3
"""Pairs a second that parallax_data reads in one process: left, right, disparity and valid. Prints one line of JSON.

    PYTHONPATH=common/python/parallax_data tests/bench/dataset/bench_reader.py OUT [--seconds 10]
"""
import argparse
import json
import os
import platform
import time

from parallax_data import ParallaxDataset


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    arguments.add_argument("dataset")
    arguments.add_argument("--seconds", type=float, default=10)
    options = arguments.parse_args()
    data = ParallaxDataset(options.dataset, filtered=False)
    height, width = data[0].disparity.shape  # Brings the files into the system's memory, and the decoders into ours.
    pairs, start_s, start_cpu_s = 0, time.perf_counter(), time.process_time()
    while time.perf_counter() - start_s < options.seconds:
        pair = data[pairs % len(data)]
        assert pair.disparity.shape == pair.valid.shape
        pairs += 1
    print(json.dumps({
        "bench": "reader", "width_px": width, "height_px": height, "pairs": pairs,
        "pairs_per_s": round(pairs / (time.perf_counter() - start_s), 1),
        "cpu_ms_per_pair": round(1000 * (time.process_time() - start_cpu_s) / pairs, 1),
        "cores": os.cpu_count(), "load": os.getloadavg()[0], "python": platform.python_version()}))


if __name__ == "__main__":
    main()
