"""On demand: a training of thousands of steps that drinks from a local farm, of which something is killed all the time.

stream_training.py BIN TREE [--steps N] [--step-s S] [--kill-every-s S] [--torch]: BIN is the folder of the programs, TREE the
repository; with --torch each step trains a small network on a batch of torch's loader, and takes S at least.
Prints JSON; ends with 1 unless no pair came twice, the pairs are those of a calm run in its order, at most 5 % of the time went
into waiting once the stream was warm, and the disk held no more than the plan says and what was used a short time ago.
"""

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import time

from python_client_test import BIN, TREE, Farm

from parallax_data import Client

STUDY = """
study: endless
seed: 5
pairs: endless
rigs_per_scene: 20
set:
  floating: {count: 3}
  rigs: {count: 20, width_px: 64, height_px: 48}
  render: {profile: preview, samples_per_pixel: 1, maps: [depth, disparity, occlusion, masks]}
  filters: {min_mean_intensity: 0, min_depth_m: 0}
stream: {chunk_pairs: 100, chunks_ahead: 3}
variants: [{name: things, base: dense}]
"""
# It notes each pair with the position behind it and the seconds that it waited for it; the first of a start is no wait.
TRAINING = """
import sys, time
from parallax_data import stream
address, notes, step_s = sys.argv[1:]
lines = open(notes).read().split("\\n")[:-1]
pairs = stream("endless", address, position=int(lines[-1].split()[1]) if lines else None, patience_s=300)
before = None
with open(notes, "a") as out:
    for pair in pairs:
        wait = 0 if before is None else pairs.waited_s - before
        before = pairs.waited_s
        time.sleep(float(step_s))
        out.write(f"{pair.frame.index['chunk']}/{pair.frame.key} {pair.frame.index['position'] + 1} {wait:.4f}\\n")
        out.flush()
"""
# The same with torch's loader and a network, whose steps are slowed down.
TORCH_TRAINING = """
import sys, time
import torch
from parallax_data.torch_dataset import TorchPairStream
address, notes, step_s = sys.argv[1:]
torch.set_num_threads(1)
lines = open(notes).read().split("\\n")[:-1]
data = TorchPairStream("endless", address, position=int(lines[-1].split()[1]) if lines else None, patience_s=300)
item_of = data.item_of
data.item_of = lambda pair: (f"{pair.frame.index['chunk']}/{pair.frame.key}", pair.frame.index["position"] + 1, item_of(pair))
network = torch.nn.Sequential(torch.nn.Conv2d(6, 16, 7, padding=3), torch.nn.ReLU(), torch.nn.Conv2d(16, 1, 7, padding=3))
optimiser = torch.optim.AdamW(network.parameters(), 1e-3)
before = None
with open(notes, "a") as out:
    for key, after, (_, left, right, flow, valid) in torch.utils.data.DataLoader(data, batch_size=None):
        wait = 0 if before is None else data.stream.waited_s - before
        before, began = data.stream.waited_s, time.monotonic()
        loss = ((network(torch.cat([left, right]) / 255) - flow).abs() * valid).mean()
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        time.sleep(max(0, float(step_s) - (time.monotonic() - began)))
        out.write(f"{key} {after} {wait:.4f}\\n")
        out.flush()
"""
LEASE_S = 10
WARM = 100  # Steps before waits count.


class Run:
    """A farm with one worker."""

    def __init__(self, training=TRAINING):
        self.farm, self.training = Farm(), training
        self.coordinator, self.address = self.serve("127.0.0.1:0")
        self.worker = self.work()
        self.study = self.farm.folder / "endless.yaml"
        self.study.write_text(STUDY)
        subprocess.run([BIN / "parallax", "stream", self.study, "--coordinator", self.address], check=True, capture_output=True)

    def serve(self, listen):
        return self.farm.serve("--lease-s", LEASE_S, listen=listen)

    def work(self):
        return self.farm.start(BIN / "worker", "--role", "all", "--coordinator", self.address, "--threads", "1", "--outbox",
                               self.farm.folder / "outbox")

    def train(self, notes, step_s):
        text = notes.read_text() if notes.exists() else ""
        notes.write_text(text[:text.rfind("\n") + 1])  # Without half a note.
        process = subprocess.Popen([sys.executable, "-B", "-c", self.training, self.address, notes, str(step_s)],
                                   stdout=subprocess.PIPE, env={**os.environ, "PYTHONPATH": ":".join(sys.path)})
        self.farm.processes.append(process)
        return process

    def kill(self, process):
        process.send_signal(signal.SIGKILL)
        process.wait()
        process.stdout.close()
        self.farm.processes.remove(process)

    def stored_pairs(self):
        return sum(1 for _ in (self.farm.folder / "store").glob("*/*/.attempt-*/*/frame.json"))


def calm_keys(steps):
    """The pairs of a run in which nothing is killed, without reading them."""
    run = Run()
    try:
        client, keys, position = Client(run.address), [], 0
        while len(keys) < steps:
            reply = client.call("Streams.Next", stream="endless", consumer="calm", ranks=1, position=position, acknowledged=position,
                                limit=64, wait_s=10.0)
            position = reply.position
            keys += [f"{pair.chunk}/{pair.variant}/{pair.scene:06}/{pair.frame.rig:03}" for pair in reply.pairs]
        return keys[:steps]
    finally:
        run.farm.stop()


def killed_notes(options):
    """What the training notes, what was killed, and the most pairs that were kept and stored."""
    run = Run(TORCH_TRAINING if options.torch else TRAINING)
    try:
        notes = run.farm.folder / "notes.txt"
        training = run.train(notes, options.step_s)
        chance, kills, kept, stored = random.Random(1), {"coordinator": 0, "worker": 0, "training": 0}, 0, 0
        while len(lines := notes.read_text().splitlines()) < options.steps:
            until = time.monotonic() + options.kill_every_s
            while time.monotonic() < until and len(notes.read_text().splitlines()) < options.steps:
                time.sleep(1)
                assert training.poll() is None, "the training ended by itself"
            client = Client(run.address)
            kept = max(kept, client.call("Streams.List", name="endless").streams[0].pairs_kept)
            client.close()
            stored = max(stored, run.stored_pairs())
            what = chance.choice(list(kills))
            kills[what] += 1
            if what == "coordinator":
                run.kill(run.coordinator)
                run.coordinator, _ = run.serve(run.address)
            elif what == "worker":
                run.kill(run.worker)
                run.worker = run.work()
            else:
                run.kill(training)
                training = run.train(notes, options.step_s)
        plan = json.loads(subprocess.run([BIN / "parallax", "plan", run.study, "--json"], check=True, capture_output=True).stdout)
        run.kill(training)
        return [line.split() for line in lines[:options.steps]], kills, kept, stored, plan["stream"]
    finally:
        run.farm.stop()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, default=2000)
    parser.add_argument("--step-s", type=float, default=0.1)
    parser.add_argument("--kill-every-s", type=float, default=10)
    parser.add_argument("--torch", action="store_true")
    options = parser.parse_args()
    began = time.monotonic()
    notes, kills, kept, stored, plan = killed_notes(options)
    wall_s = time.monotonic() - began
    keys, waits = [key for key, _, _ in notes], [float(wait) for _, _, wait in notes[min(WARM, len(notes) // 2):]]
    share = sum(waits) / (sum(waits) + options.step_s * len(waits))
    # Files of pairs that were used go after five leases, by a look a minute, and later while the coordinator is away.
    most_kept = plan["chunks_kept"] * plan["chunk_pairs"]
    most_stored = most_kept + (5 * LEASE_S + 60 + 2 * options.kill_every_s) / options.step_s
    calm = calm_keys(options.steps)
    good = (len(set(keys)) == len(keys), keys == calm, share <= 0.05, kept <= most_kept, stored <= most_stored)
    print(json.dumps({"steps": len(keys), "wall_s": round(wall_s), "kills": kills, "wait_share": round(share, 4),
                      "longest_wait_s": max(waits), "pairs_twice": len(keys) - len(set(keys)), "as_calm": keys == calm,
                      "most_pairs_kept": kept, "allowed": most_kept, "most_pairs_stored": stored}))
    return 0 if all(good) else 1


if __name__ == "__main__":
    sys.exit(main())
