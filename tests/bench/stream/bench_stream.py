"""Delivery of stored pairs by a stream, without rendering.

bench_stream.py BIN [--pairs N]: BIN is the folder of the programs. Workers without work make N pairs; then one consumer takes
them. Prints JSON: pairs a second, and the coordinator's CPU time for each pair.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "common/python/parallax_data"))
from parallax_data import Client  # noqa: E402

STUDY = """
study: bench
pairs: endless
rigs_per_scene: 20
set: {{filters: {{min_mean_intensity: 0}}, rigs: {{width_px: 640, height_px: 360}}}}
stream: {{chunk_pairs: {chunk}, chunks_ahead: {ahead}}}
variants: [{{name: rooms, base: indoor}}]
"""


def cpu_s(pid):
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("bin", type=Path)
    parser.add_argument("--pairs", type=int, default=20000)
    options = parser.parse_args()
    binaries, chunk = options.bin.resolve(), 400
    chunks = -(-options.pairs // chunk)
    with tempfile.TemporaryDirectory() as folder:
        daemon = subprocess.Popen([binaries / "coordinator", "serve", "--db", "queue.db", "--store", "store", "--http", "", "--listen",
                                   "127.0.0.1:0"], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        address = daemon.stdout.readline().split()[-1]
        worker = subprocess.Popen([binaries / "noop_worker", "--role", "all", "--coordinator", address, "--outbox", "outbox"], cwd=folder,
                                  stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            study = Path(folder, "bench.yaml")
            study.write_text(STUDY.format(chunk=chunk, ahead=min(1000, chunks)))
            subprocess.run([binaries / "parallax", "stream", study, "--coordinator", address], check=True, capture_output=True)
            client = Client(address)
            while client.call("Streams.List", name="bench").streams[0].chunks_made < chunks:
                time.sleep(0.5)
            began, cpu_before, taken, position = time.monotonic(), cpu_s(daemon.pid), 0, 0
            while taken < options.pairs:
                reply = client.call("Streams.Next", stream="bench", consumer="bench", ranks=1, position=position,
                                    acknowledged=position, limit=64, wait_s=10.0)
                position, taken = reply.position, taken + len(reply.pairs)
            seconds, cpu = time.monotonic() - began, cpu_s(daemon.pid) - cpu_before
            print(json.dumps({"pairs": taken, "pairs_per_s": round(taken / seconds, 1),
                              "coordinator_cpu_ms_per_pair": round(1000 * cpu / taken, 4)}))
        finally:
            for process in (worker, daemon):
                process.terminate()
                process.wait()


if __name__ == "__main__":
    main()
