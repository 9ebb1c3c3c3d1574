"""Streams into Python: the same pairs in the same order whatever is killed meanwhile, parts of ranks, a store that is not seen
from here, the tar of `parallax stream`, farms of this machine alone, and errors.

python_stream_test.py BIN TREE: BIN is the folder of the programs, TREE the repository."""

import io
import os
import random
import shutil
import signal
import subprocess
import sys
import tarfile
import tempfile
import time
import unittest
from pathlib import Path
from unittest import mock

import numpy as np
from python_client_test import BIN, TREE, Farm, end, said

from parallax_data import ParallaxError, streams
from parallax_data.streams import PairStream

ENDLESS = """
study: endless
seed: 5
pairs: endless
rigs_per_scene: 4
set:
  floating: {count: 2}
  rigs: {count: 4, width_px: 64, height_px: 48}
  render: {profile: preview, samples_per_pixel: 1}
  filters: {min_mean_intensity: 0, min_depth_m: 0}
stream: {chunk_pairs: 8, chunks_ahead: 2, keep_s: 600}
variants:
  - {name: rooms, base: indoor}
  - {name: things, base: dense, set: {floating: {count: 3}, rigs: {count: 4}}}
"""
PAIRS = 32
# A training: it notes each pair with the position behind it, and goes on behind its last note.
TRAINING = """
import sys
from parallax_data import stream
address, notes = sys.argv[1:]
lines = open(notes).read().split("\\n")[:-1]
pairs = stream("endless", address, position=int(lines[-1].split()[1]) if lines else None, patience_s=60)
with open(notes, "a") as out:
    for pair in pairs:
        assert pair.left.shape == (48, 64, 3)
        after = pair.frame.index["position"] + 1
        out.write(f"{pair.frame.index['chunk']}/{pair.frame.key} {after}\\n")
        out.flush()
"""


# A training that makes its pairs itself.
ALONE = """
import sys
from parallax_data import stream
study, out, notes = sys.argv[1:]
with open(notes, "a") as file:
    for pair in stream(study, workers=1, out=out):
        file.write(f"{pair.frame.index['chunk']}/{pair.frame.key}\\n")
        file.flush()
"""
# A loader of torch whose workers split the stream. It prints the folders of its first pairs.
LOADER = """
import pickle, sys
import torch
from parallax_data.torch_dataset import TorchPairStream
data = TorchPairStream(sys.argv[1], workers=1, out=sys.argv[2])
assert pickle.loads(pickle.dumps(data)).args == data.args
pairs = iter(torch.utils.data.DataLoader(data, batch_size=1, num_workers=2))
for _ in range(8):
    paths, left, right, flow, valid = next(pairs)
    assert left.shape == right.shape == (1, 3, 48, 64) and flow.shape == (1, 1, 48, 64)
    print(paths[0][0])
del pairs
data.close()
"""
# A training whose disk is filled after three pairs. It prints what it takes, its error, and what it takes when there is room again.
FULL = """
import sys
from parallax_data import ParallaxError, stream
study, out = sys.argv[1:]
def take(most):
    pairs = stream(study, workers=1, out=out)
    try:
        take_from(pairs, most)
    finally:
        pairs.close()
def take_from(pairs, most):
    for count, pair in enumerate(pairs, 1):
        print(f"{pair.frame.index['chunk']}/{pair.frame.key}")
        if most and count == most:
            return
        if count == 3:
            with open(f"{out}/filler", "wb", buffering=0) as filler:
                try:
                    while True:
                        filler.write(bytes(1 << 20))
                except OSError:
                    pass
try:
    take(0)
except ParallaxError as error:
    print(error.code, str(error).replace(" ", "_"))
import os
os.remove(f"{out}/filler")
take(2)
"""
PATIENCE_S = 60


def key_of(pair):
    return f"{pair.frame.index['chunk']}/{pair.frame.key}"


def take(n, *args, **options):
    """The keys of the next `n` pairs of a stream."""
    keys, pairs = [], iter(PairStream(*args, **options))
    for pair in pairs:
        keys.append(key_of(pair))
        if len(keys) == n:
            break
    pairs.close()
    return keys


class StreamTest(unittest.TestCase):
    def setUp(self):
        self.farm = Farm()
        self.addCleanup(self.farm.stop)

    def begin(self, workers=1, *more):
        self.coordinator, self.address = self.farm.serve(*more)
        self.workers = [self.work() for _ in range(workers)]
        study = self.farm.folder / "endless.yaml"
        study.write_text(ENDLESS)
        subprocess.run([BIN / "parallax", "stream", study, "--coordinator", self.address], check=True, capture_output=True)

    def work(self):
        return self.farm.start(BIN / "worker", "--role", "all", "--coordinator", self.address, "--threads", "1", "--outbox",
                               self.farm.folder / "outbox")

    def test_kills_of_anything_change_nothing(self):
        self.begin()
        calm = take(PAIRS, "endless", self.address)
        self.assertEqual(len(set(calm)), PAIRS)
        self.assertEqual({key.split("/")[1] for key in calm}, {"rooms", "things"})
        for process in (self.coordinator, *self.workers):
            end(process)

        # Another farm, of which something is killed all the time.
        other = Farm()
        self.addCleanup(other.stop)
        self.farm = other
        self.begin()
        port = self.address
        notes = other.folder / "notes.txt"
        notes.touch()
        training = self.train(notes)
        chance, kills = random.Random(1), {"coordinator": 0, "worker": 0, "training": 0}
        until, before = time.monotonic() + 400, 0
        while time.monotonic() < until:
            # A kill at each third pair, and one every five seconds.
            at = time.monotonic() + 5
            while time.monotonic() < at and len(notes.read_text().splitlines()) < before + 3:
                time.sleep(0.02)
            self.assertIsNone(training.poll(), "the training ended by itself")
            before = len(notes.read_text().splitlines())
            if before >= PAIRS:
                break
            what = chance.choice(list(kills))
            kills[what] += 1
            if what == "coordinator":
                self.kill(self.coordinator)
                self.coordinator, _ = other.serve(listen=port)
            elif what == "worker":
                self.kill(self.workers.pop())
                self.workers.append(self.work())
            else:
                self.kill(training)
                training = self.train(notes)
        streams, studies = said("stream", "--coordinator", port)[1], said("status", "--coordinator", port)[1]
        self.kill(training)
        delivered = [line.split()[0] for line in notes.read_text().splitlines()]
        self.assertEqual(delivered[:PAIRS], calm, f"after {kills}\n{streams}{studies}")

    def train(self, notes):
        text = notes.read_text()
        notes.write_text(text[:text.rfind("\n") + 1])  # Without half a note.
        process = subprocess.Popen([sys.executable, "-B", "-c", TRAINING, self.address, notes],
                                   env={**os.environ, "PYTHONPATH": str(TREE / "common/python/parallax_data")})
        self.farm.processes.append(process)
        return process

    def kill(self, process):
        process.send_signal(signal.SIGKILL)
        process.wait()
        if process.stdout:
            process.stdout.close()
        self.farm.processes.remove(process)

    def test_ranks_take_all_pairs_between_them(self):
        self.begin()
        whole = take(24, "endless", self.address, consumer="alone")
        parts = [PairStream("endless", self.address, rank=rank, ranks=2, ahead=2, position=0) for rank in (0, 1)]
        iterators = [iter(part) for part in parts]
        halves = [[key_of(next(one)) for _ in range(12)] for one in iterators]
        for one in iterators:
            one.close()
        self.assertEqual(halves[0], whole[0::2])
        self.assertEqual(halves[1], whole[1::2])

    def test_a_consumer_goes_on_behind_what_it_acknowledged_and_a_checkpoint_where_it_was(self):
        self.begin()
        whole = take(16, "endless", self.address, consumer="other")
        first = take(5, "endless", self.address, position=0)
        self.assertEqual(first, whole[:5])
        self.assertEqual(take(5, "endless", self.address), whole[4:9], "the fifth was in use")
        pairs = PairStream("endless", self.address, consumer="third", position=0)
        taken = []
        for pair in pairs:
            taken.append(key_of(pair))
            if len(taken) == 4:
                state = pairs.state_dict()  # Three are used: the fourth is in use.
            if len(taken) == 8:
                break
        again = PairStream("endless", self.address, consumer="third")
        again.load_state_dict(state)
        self.assertEqual(key_of(next(iter(again))), whole[3])

    def test_a_store_that_is_not_seen_from_here_comes_through_the_coordinator(self):
        self.begin()
        here = next(iter(PairStream("endless", self.address)))
        with mock.patch.object(streams.os.path, "isdir", lambda path: False):
            pairs = iter(PairStream("endless", self.address, consumer="far", maps=("normals",)))
            there = next(pairs)
            folder = there.frame.path
            self.assertTrue(folder.exists())
            np.testing.assert_array_equal(there.left, here.left)
            np.testing.assert_array_equal(there.disparity, here.disparity)
            self.assertEqual(there.maps["normals"].shape, (48, 64, 3))
            next(pairs)
            self.assertFalse(folder.exists(), "it is used")
            pairs.close()

    def test_the_tar_has_the_same_pairs(self):
        self.begin()
        done = subprocess.run([BIN / "parallax", "stream", "endless", "--tar", "--most", "3", "--coordinator", self.address],
                              check=True, capture_output=True)
        with tarfile.open(fileobj=io.BytesIO(done.stdout)) as tar:
            names = tar.getnames()
        keys = [name[:-len(".left.png")] for name in names if name.endswith(".left.png")]
        self.assertEqual(len(keys), 3)
        for key in keys:
            for part in ("right.png", "disp.npy", "occ.png", "json"):
                self.assertIn(f"{key}.{part}", names)
        expected = take(4, "endless", self.address)
        self.assertEqual([key.replace("_", "/") for key in keys], expected[:3])
        more = subprocess.run([BIN / "parallax", "stream", "endless", "--tar", "--most", "1", "--coordinator", self.address],
                              check=True, capture_output=True)
        with tarfile.open(fileobj=io.BytesIO(more.stdout)) as tar:
            self.assertEqual(tar.getnames()[0].split(".")[0].replace("_", "/"), expected[3], "it goes on")

    def test_the_tar_goes_on_when_its_coordinator_is_back(self):
        self.begin()
        path = self.farm.folder / "pairs.tar"
        with open(path, "wb") as out:
            process = subprocess.Popen(
                [BIN / "parallax", "stream", "endless", "--tar", "--most", "20", "--coordinator", self.address],
                stdout=out, stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        while path.stat().st_size == 0:
            self.assertIsNone(process.poll(), "the tar ended by itself")
            time.sleep(0.02)
        end(self.coordinator)
        self.assertTrue(any("the coordinator does not answer" in line for line in process.stderr))
        self.coordinator, _ = self.farm.serve(listen=self.address)
        self.assertEqual(process.wait(PATIENCE_S), 0)
        with tarfile.open(path) as tar:
            names = tar.getnames()
        keys = [name[:-len(".left.png")].replace("_", "/") for name in names if name.endswith(".left.png")]
        self.assertEqual(len(set(keys)), 20, "none comes twice")
        rounds = [key.partition("/")[0] for key in keys]
        self.assertEqual(rounds, sorted(rounds))
        first, second = (sorted(key.partition("/")[2] for key in keys if key.startswith(number)) for number in ("0/", "1/"))
        self.assertEqual(first, second, "none is missing")

    def test_errors_are_those_of_the_program(self):
        self.begin(0)
        with self.assertRaises(ParallaxError) as unknown:
            next(iter(PairStream("endles", self.address)))
        self.assertIn('stream "endles" is not known; known are: endless', str(unknown.exception))
        with self.assertRaises(ValueError):
            PairStream("endless", self.address, maps=("normal",))
        end(self.coordinator)
        began = time.monotonic()
        with self.assertRaises(ParallaxError) as away:
            next(iter(PairStream("endless", self.address, patience_s=1)))
        self.assertEqual(away.exception.code, ParallaxError.UNREACHABLE)
        self.assertLess(time.monotonic() - began, 60)


class LocalFarmTest(unittest.TestCase):
    """Streams without a coordinator: `parallax stream --workers`."""

    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="parallax-alone-"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.study, self.out = self.folder / "endless.yaml", self.folder / "farm"
        self.study.write_text(ENDLESS)

    def processes(self):
        """Processes of this test's farm: its command and its workers have the folder in their arguments."""
        found = {}
        for entry in Path("/proc").glob("[0-9]*"):
            try:
                words = (entry / "cmdline").read_bytes().decode().split("\0")
            except OSError:
                continue
            if Path(words[0]).name in ("parallax", "worker") and any(str(self.out) in word for word in words):
                found[int(entry.name)] = Path(words[0]).name
        return found

    def await_end(self):
        """Waits until no process of the farm is left."""
        until = time.monotonic() + PATIENCE_S
        while self.processes() and time.monotonic() < until:
            time.sleep(0.05)
        self.assertEqual(self.processes(), {})

    def stream(self, **options):
        return PairStream(str(self.study), workers=1, out=str(self.out), **options)

    def test_a_killed_training_leaves_nothing_and_goes_on_where_it_was(self):
        notes = self.folder / "notes.txt"
        notes.touch()
        training = subprocess.Popen([sys.executable, "-B", "-c", ALONE, self.study, self.out, notes],
                                    env={**os.environ, "PYTHONPATH": str(TREE / "common/python/parallax_data")})
        while len(notes.read_text().splitlines()) < 3:
            self.assertIsNone(training.poll(), "the training ended by itself")
            time.sleep(0.02)
        self.assertEqual(sorted(self.processes().values()), ["parallax", "worker"])
        training.kill()
        training.wait()
        self.await_end()
        noted = notes.read_text().split()
        pairs = self.stream()
        resumed = next(iter(pairs))
        whole = take(12, pairs.name, pairs._farm.address, consumer="other", position=0)
        pairs.close()
        self.await_end()
        self.assertEqual(len(set(whole)), 12)
        self.assertEqual(noted, whole[:len(noted)])
        self.assertLessEqual(whole.index(key_of(resumed)), len(noted))
        self.assertFalse((self.out / ".parallax" / "socket").exists(), "its socket's folder is gone, too")

    def test_the_farm_ends_with_the_stream(self):
        pairs = self.stream()
        self.assertEqual(sorted(self.processes().values()), ["parallax", "worker"])
        with self.assertRaises(ParallaxError) as second:
            self.stream()
        self.assertIn(f"{self.out} is in use by another parallax", str(second.exception))
        self.assertEqual(second.exception.code, ParallaxError.USAGE)
        del pairs
        self.await_end()
        other = self.folder / "other.yaml"
        for text in (ENDLESS.replace("seed: 5", "seed: 6"), ENDLESS.replace("study: endless", "study: other")):
            other.write_text(text)
            with self.assertRaises(ParallaxError) as different:
                PairStream(str(other), workers=1, out=str(self.out))
            self.assertIn("has a stream of another study or of other settings", str(different.exception))
        with self.assertRaises(ParallaxError) as counted:
            PairStream("quickstart", workers=1, out=str(self.out))
        self.assertIn("allowed in a stream is `pairs: endless`", str(counted.exception))
        with self.assertRaises(ValueError):
            PairStream("endless", "127.0.0.1:7070", workers=1)
        self.await_end()

    def test_a_killed_farm_is_an_error_at_once(self):
        pairs = self.stream()
        began = iter(pairs)
        next(began)
        for process, name in self.processes().items():
            if name == "parallax":
                os.kill(process, signal.SIGKILL)
        with self.assertRaises(ParallaxError) as killed:
            for _ in began:
                pass
        self.assertEqual(str(killed.exception), "the local farm ended with status -9")
        self.await_end()

    def test_a_full_disk_ends_the_farm_with_its_cause_and_nothing_is_lost(self):
        self.out.mkdir()
        mount = ["/usr/bin/unshare", "-Urm", "/bin/sh", "-c", f'mount -t tmpfs -o size=120m none {self.out} && exec "$@"', "sh"]
        if subprocess.run([*mount, "true"], capture_output=True).returncode != 0:
            self.skipTest("mounting is not allowed here")
        done = subprocess.run([*mount, sys.executable, "-B", "-c", FULL, self.study, self.out], capture_output=True, text=True,
                              env={**os.environ, "PYTHONPATH": ":".join(sys.path)}, timeout=4 * PATIENCE_S)
        self.assertEqual(done.returncode, 0, done.stderr)
        said = done.stdout.splitlines()
        (told,) = (line for line in said if line.startswith("4 "))
        self.assertRegex(told, "is_full|could_not_be_written")
        before, after = said[:said.index(told)], said[said.index(told) + 1:]
        pairs = self.stream(consumer="calm")
        whole = [key_of(pair) for pair, _ in zip(pairs, range(len(before) + len(after)))]
        pairs.close()
        self.assertEqual(before, whole[:len(before)])
        self.assertEqual(len(after), 2)
        self.assertEqual(after, whole[whole.index(after[0]):][:2])
        self.assertLessEqual(whole.index(after[0]), len(before))

    def test_workers_of_a_torch_loader_share_a_farm(self):
        try:
            import torch  # noqa: F401
        except ImportError:
            self.skipTest("torch is optional and not installed")
        done = subprocess.run([sys.executable, "-B", "-c", LOADER, self.study, self.out], capture_output=True, text=True,
                              env={**os.environ, "PYTHONPATH": ":".join(sys.path)}, timeout=4 * PATIENCE_S)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.await_end()
        pairs = self.stream(consumer="other", position=0)
        whole = [f"{pair.frame.path}/left.png" for pair, _ in zip(pairs, range(8))]
        pairs.close()
        self.assertEqual(done.stdout.split(), whole)

    def test_the_tar_of_a_farm_ends_with_its_reader(self):
        process = subprocess.Popen([BIN / "parallax", "stream", self.study, "--workers", "1", "--out", self.out, "--tar"],
                                   stdout=subprocess.PIPE)
        with tarfile.open(fileobj=process.stdout, mode="r|") as tar:
            self.assertTrue(tar.next().name.endswith(".left.png"))
        process.stdout.close()
        self.assertEqual(process.wait(PATIENCE_S), 0)
        self.await_end()


if __name__ == "__main__":
    unittest.main()
