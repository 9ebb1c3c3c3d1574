"""Event files by their published formats: a decoder of its own, and checksums from RFC 3720."""

import importlib.util
import os
import pathlib
import re
import struct
import subprocess
import sys
import tempfile
import unittest

from parallax_data import tensorboard


def fields(data):
    """(field, wire type, value) of a protobuf message; as the encoding is described, written apart from the writer."""
    at = 0

    def varint():
        nonlocal at
        value = shift = 0
        while True:
            byte = data[at]
            at += 1
            value |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                return value

    while at < len(data):
        key = varint()
        kind = key & 7
        if kind == 0:
            value = varint()
        else:
            size = {1: 8, 5: 4}.get(kind)
            if size is None:
                size = varint()
            value = data[at:at + size]
            at += size
        yield key >> 3, kind, value


def read_events(path):
    """(step, wall time, {tag: value}) of each event with a summary; checks the framing."""
    data = pathlib.Path(path).read_bytes()
    events, versions, at = [], [], 0

    def check(chunk, stored):
        crc = tensorboard.crc32c(chunk)
        rotated = (crc >> 15) | ((crc << 17) & 0xFFFFFFFF)
        assert (rotated + 0xA282EAD8) % 2**32 == struct.unpack("<I", stored)[0]

    while at < len(data):
        length, = struct.unpack("<Q", data[at:at + 8])
        check(data[at:at + 8], data[at + 8:at + 12])
        body = data[at + 12:at + 12 + length]
        check(body, data[at + 12 + length:at + 16 + length])
        at += 16 + length
        step, wall, scalars = 0, None, {}
        for field, _, value in fields(body):
            if field == 1:
                wall, = struct.unpack("<d", value)
            elif field == 2:
                step = value
            elif field == 3:
                versions.append(value)
            elif field == 5:
                for _, _, one in fields(value):
                    parts = {f: v for f, _, v in fields(one)}
                    scalars[parts[1].decode()] = struct.unpack("<f", parts[2])[0]
        if scalars:
            events.append((step, wall, scalars))
    assert versions == [b"brain.Event:2"], versions
    return events


class TensorBoard(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.root = pathlib.Path(self.temporary.name)
        self.log = self.root / "runs"

    def tearDown(self):
        self.temporary.cleanup()

    def convert(self, source):
        tensorboard.main([str(source), "--log", str(self.log)])

    def test_checksums_are_those_of_the_rfc(self):
        self.assertEqual(tensorboard.crc32c(b"123456789"), 0xE3069283)
        self.assertEqual(tensorboard.crc32c(bytes(32)), 0x8A9136AA)

    def test_a_study_gives_a_run_for_each_training(self):
        out = self.root / "out"
        for seed in ("seed-0", "seed-1"):
            folder = out / "training" / "wide" / "builtin" / seed
            folder.mkdir(parents=True)
            (folder / "curve.csv").write_text("step,loss,epe_px,train_s\n10,2.5,,1.5\n300,1.25,0.75,40\n")
        (out / "curves").mkdir()
        (out / "curves" / "learning_curves.csv").write_text(
            "benchmark,metric,set,trainer,seed,step,value\nshipped,bad-2 nocc,wide,builtin,1,150,12.5\n")
        self.convert(out)
        file = self.log / "wide" / "builtin" / "seed-0" / tensorboard.EVENTS
        self.assertEqual(read_events(file), [(10, 1.5, {"loss": 2.5}), (300, 40.0, {"loss": 1.25, "epe_px": 0.75})])
        steps = read_events(self.log / "wide" / "builtin" / "seed-1" / tensorboard.EVENTS)
        self.assertEqual([step for step, _, _ in steps], [10, 150, 300])
        self.assertEqual(steps[1][2], {"shipped/bad-2_nocc": 12.5})
        before = file.read_bytes()
        self.convert(out)
        self.assertEqual(file.read_bytes(), before)
        self.assertEqual(len(list(file.parent.iterdir())), 1)

    def test_the_recipes_for_wandb_and_mlflow_are_right(self):
        page = pathlib.Path(__file__).parents[4] / "deploy" / "site" / "docs" / "recipes" / "python.md"
        folder = self.root / "out" / "table1" / "training" / "wide" / "builtin" / "seed-0"
        folder.mkdir(parents=True)
        (folder / "curve.csv").write_text("step,loss,epe_px,train_s\n10,2.5,,1.5\n300,1.25,0.75,40\n")
        self.log.mkdir()
        environment = {"WANDB_MODE": "offline", "WANDB_DIR": str(self.log), "MLFLOW_TRACKING_URI": f"file:{self.log}/ml",
                       "MLFLOW_ALLOW_FILE_STORE": "true", "PYTHONPATH": ":".join(sys.path)}
        for package, written in (("wandb", "wandb/offline-run-*/*.wandb"), ("mlflow", "ml/*/*/metrics/loss")):
            with self.subTest(package):
                if importlib.util.find_spec(package) is None:
                    self.skipTest(f"{package} is optional and not installed")
                (lines,) = re.findall(rf"^```python[^\n]*\n(import {package}\n.*?)^```", page.read_text(), re.M | re.S)
                subprocess.run([sys.executable, "-c", lines], check=True, capture_output=True, cwd=self.root, timeout=300,
                               env={**os.environ, **environment})
                (file,) = self.log.glob(written)
                if package == "mlflow":
                    self.assertEqual([line.split()[1:] for line in file.read_text().splitlines()], [["2.5", "10"], ["1.25", "300"]])

    def test_the_trainers_lines_give_a_run(self):
        lines = self.root / "mine.jsonl"
        lines.write_text('warning: slow disk\n{"event": "start", "step": 0, "steps": 20}\n'
                         '{"step": 10, "steps": 20, "loss": 0.5, "eta_s": 3}\n'
                         '{"event": "checkpoint", "step": 10, "path": "x"}\n{"step": 20, "steps": 20, "loss": 0.25}\n')
        self.convert(lines)
        self.assertEqual([(step, scalars) for step, _, scalars in read_events(self.log / "mine" / tensorboard.EVENTS)],
                         [(10, {"loss": 0.5}), (20, {"loss": 0.25})])

    def test_nothing_to_show_is_an_error(self):
        for source in (self.root, self.root / "missing"):
            with self.assertRaises(SystemExit) as error:
                self.convert(source)
            self.assertEqual(error.exception.code, 2)


if __name__ == "__main__":
    unittest.main()
