"""Reads a synthetic archive with the package, and compares it with what was written."""

import dataclasses
import json
import os
import re
import subprocess
import sys
import tarfile
import tempfile
import unittest
from pathlib import Path

from exports_case import ExportsCase
from parallax_data import ParallaxDataset

import numpy as np


class Archives(ExportsCase):
    def test_archive_filtered_and_unfiltered_are_two_readings(self):
        self.assertEqual(len(self.data), 9)  # 5 scenes x 2 rigs, one dark.
        self.assertEqual(len(ParallaxDataset(self.root / "archive", filtered=False)), 10)
        self.assertEqual(len(ParallaxDataset(self.root / "archive" / "a")), 9)
        self.assertEqual(len(ParallaxDataset([self.root / "archive"] * 2)), 18)

    def test_pair_is_what_training_code_expects(self):
        for pair in self.data:
            self.assertEqual(pair.left.shape, (54, 96, 3))
            self.assertEqual(pair.left.dtype, np.uint8)
            self.assertEqual(pair.right.shape, pair.left.shape)
            self.assertEqual(pair.disparity.dtype, np.float32)
            self.assertEqual(pair.disparity.shape, (54, 96))
            self.assertEqual(pair.valid.dtype, bool)
            self.assertTrue((pair.disparity[pair.valid] > 0).all())
            camera = pair.frame.camera()
            depth = pair.frame.depth()
            expected = np.zeros_like(depth)
            seen = depth > 0
            expected[seen] = camera["intrinsics"]["fx"] * camera["baseline_m"] / depth[seen]
            np.testing.assert_allclose(pair.disparity, expected, rtol=2e-6)
            # The right image, moved by the disparity, is the left one where both eyes see.
            y, x = np.nonzero(pair.valid & ~pair.frame.occluded())
            at = np.round(x - pair.disparity[y, x]).astype(int)
            inside = (at >= 0) & (at < 96)
            difference = np.abs(pair.left[y, x][inside].astype(int) - pair.right[y, at][inside])
            self.assertLess(np.median(difference), 12)
            self.assertEqual(set(np.unique(pair.frame.objects())) - {0}
                             - {int(i) for i in camera["objects"]}, set())
            lengths = np.linalg.norm(pair.frame.normals("right"), axis=2)
            np.testing.assert_allclose(lengths[pair.frame.depth("right") > 0], 1, atol=5e-3)

    def test_split_is_by_scene_and_leaves_none_out(self):
        train = ParallaxDataset(self.root / "archive", split="train")
        test = ParallaxDataset(self.root / "archive", split="test")
        self.assertEqual(len(train) + len(test), len(self.data))
        self.assertEqual({f.scene for f in test.frames}, {4})
        self.assertEqual({f.scene for f in train.frames}, {0, 1, 2, 3})

    def test_heldout_pairs_are_taken_only_where_they_are_named(self):
        with tempfile.TemporaryDirectory() as name:
            root = Path(name) / "both"
            root.mkdir()
            for variant in ("a", "heldout"):
                (root / variant).symlink_to(self.root / "archive" / "a")
            self.assertEqual({f.variant for f in ParallaxDataset(root).frames}, {"a"})
            self.assertEqual(len(ParallaxDataset(root, variants=["heldout"])), 9)
            self.assertEqual(len(ParallaxDataset(root, variants=["a", "heldout"])), 18)
            self.assertEqual(len(ParallaxDataset(root / "heldout")), 9)

    def test_max_disparity_bounds_what_is_valid(self):
        limit = float(np.median(self.data[0].disparity))
        bounded = ParallaxDataset(self.root / "archive", max_disparity=limit)[0]
        self.assertTrue((bounded.disparity[bounded.valid] < limit).all())
        self.assertLess(bounded.valid.sum(), self.data[0].valid.sum())

    def test_errors_name_what_is_wrong(self):
        with self.assertRaisesRegex(FileNotFoundError, "no dataset"):
            ParallaxDataset(self.root)
        with self.assertRaisesRegex(ValueError, "there are a"):
            ParallaxDataset(self.root / "archive", variants=["huge"])
        with self.assertRaisesRegex(FileNotFoundError, "depth_up"):
            self.data.frames[0].depth("up")

    def test_opencvs_exr_flag_is_set_by_the_package_alone(self):
        environment = {k: v for k, v in os.environ.items() if k != "OPENCV_IO_ENABLE_OPENEXR"}
        code = ("import sys, cv2; from parallax_data import ParallaxDataset\n"
                "print(ParallaxDataset(sys.argv[1])[0].disparity.max() > 0)")
        done = subprocess.run([sys.executable, "-B", "-c", code, str(self.root / "archive")], env=environment,
                              capture_output=True, text=True, check=True)
        self.assertEqual(done.stdout.strip(), "True")

    def test_seeds_are_exact_whether_they_are_strings_or_numbers(self):
        frame = self.data.frames[0]
        text = (frame.path / "frame.json").read_text()
        self.assertIn('{"scene":"18446744073709551557"}', text)
        camera = frame.camera()
        self.assertEqual(camera["seeds"]["scene"], 18446744073709551557)
        self.assertEqual(camera["objects"]["1"]["seed"], 201)
        with tempfile.TemporaryDirectory() as folder:
            older = re.sub(r'"(seed|scene)":"(\d{3,})"', r'"\1":\2', text)
            self.assertNotEqual(older, text)
            (Path(folder) / "frame.json").write_text(older)
            self.assertEqual(dataclasses.replace(frame, path=Path(folder)).camera(), camera)

    def test_no_number_in_any_json_is_larger_than_a_double_holds(self):
        def parse_int(text):
            self.assertLess(abs(int(text)), 2 ** 53)
            return int(text)
        texts = [path.read_text() for path in self.root.rglob("*.json*") if path.is_file()]
        for shard in (self.root / "webdataset").glob("*.tar"):
            with tarfile.open(shard) as archive:
                texts += [archive.extractfile(m).read().decode() for m in archive if m.name.endswith(".json")]
        self.assertGreater(len(texts), 30)
        for text in texts:
            for document in text.splitlines() if text.startswith('{"variant"') else [text]:
                json.loads(document, parse_int=parse_int)

    def test_flow_leads_to_the_same_surface_in_the_neighbour(self):
        for frames in self.sequences():
            for now, then, direction in [(a, b, "forward") for a, b in zip(frames, frames[1:])] + \
                                        [(b, a, "backward") for a, b in zip(frames, frames[1:])]:
                for eye in ("left", "right"):
                    flow = now.flow(direction, eye)
                    y, x = np.nonzero(flow.valid & ~flow.occluded & (now.depth(eye) > 0))
                    u = np.floor(x + 0.5 + flow.flow[y, x, 0]).astype(int)
                    v = np.floor(y + 0.5 + flow.flow[y, x, 1]).astype(int)
                    same = now.objects(eye)[y, x] == then.objects(eye)[v, u]
                    self.assertGreater(same.mean(), 0.95)
                    expected = then.disparity(eye)[v, u]
                    off = np.abs(now.disparity(eye)[y, x] + flow.disparity_change[y, x] - expected)
                    self.assertLess(np.median(off[same]), 0.1)
                    colour = np.abs(now.image(eye)[y, x].astype(int) - then.image(eye)[v, u]).mean(1)
                    self.assertLess(np.median(colour[same]), 6)
            self.assertFalse(frames[0].flow("backward").valid.any())
            self.assertFalse(frames[-1].flow("forward").valid.any())
            self.assertEqual(frames[1].sequence(), {"path": 1, "time_s": 0.1, "previous": 0, "next": 2})
            with self.assertRaisesRegex(ValueError, "allowed are forward and backward"):
                frames[0].flow("sideways")

    def test_infrared_and_raw_pairs(self):
        data = ParallaxDataset(self.root / "archive_extras", pictures="infrared")
        color = ParallaxDataset(self.root / "archive_extras")
        self.assertEqual(len(data), 6)
        for pair, plain in zip(data, color):
            frame = pair.frame
            np.testing.assert_array_equal(pair.right[:, :, 2], frame.infrared("right"))
            np.testing.assert_array_equal(pair.left[:, :, 0], plain.left[:, :, 1])
            np.testing.assert_array_equal(pair.disparity, plain.disparity)
            np.testing.assert_array_equal(frame.raw_image("right"), plain.right)
            flow = frame.raw_flow("left")
            np.testing.assert_array_equal(flow[:, :, 0], -frame.disparity("left"))
            self.assertTrue((flow[:, :, 1] == 0).all())
            np.testing.assert_array_equal(frame.raw_occluded("right"), frame.occluded("right"))
        with self.assertRaisesRegex(ValueError, "color and infrared"):
            ParallaxDataset(self.root / "archive_extras", pictures="thermal")

    def test_every_map_of_the_table_is_read(self):
        from parallax_data import frame_maps
        read = set()
        for archive in ("archive_extras", "archive_sequences"):
            frame = ParallaxDataset(self.root / archive, filtered=False).frames[0]
            for stem, row in frame_maps.BY_STEM.items():
                for eye in ("left", "right"):
                    if frame.has(stem, eye):
                        self.assertEqual(frame.map(stem, eye).shape[:2], frame.depth(eye).shape)
                        read.add(stem)
            files = {path.name for path in frame.path.iterdir()} - {"frame.json"}
            known = {frame_maps.file_of(stem, eye, way) for stem in frame_maps.BY_STEM for eye in ("left", "right")
                     for way in ("forward", "backward")}
            self.assertLessEqual(files, known)
        self.assertGreaterEqual(read, {"depth", "raw_flow", "flow", "infrared", "layers", "depth2", "materials2"})
        with self.assertRaisesRegex(ValueError, "no map 'deph'; there are .*depth"):
            frame.map("deph")

    def test_layers(self):
        frame = ParallaxDataset(self.root / "archive_extras").frames[0]
        for eye in ("left", "right"):
            layers = frame.layers(eye)
            ball = frame.objects(eye) >= 3
            self.assertTrue(ball.any() and not ball.all())
            np.testing.assert_array_equal(layers.count, np.where(ball, 2, frame.depth(eye) > 0))
            self.assertFalse(layers.more.any())
            np.testing.assert_array_equal(layers.depth[0], frame.depth(eye))
            np.testing.assert_allclose(layers.depth[1][ball], frame.depth(eye)[ball] + 0.5, rtol=1e-6)
            self.assertTrue((layers.depth[1][~ball] == 0).all())
            np.testing.assert_array_equal(layers.clear[0], np.where(ball, 1, 0))
            self.assertTrue((layers.clear[1] == 0).all())
            np.testing.assert_array_equal(layers.last(layers.objects), np.where(ball, 2, frame.objects(eye)))
            np.testing.assert_array_equal(layers.behind, np.where(ball, layers.disparity[1], frame.disparity(eye)))


class Torch(unittest.TestCase):
    def test_items_are_in_raft_stereos_convention(self):
        try:
            import torch
        except ImportError:
            self.skipTest("torch is optional and not installed")
        from parallax_data.torch_dataset import TorchStereoDataset
        with tempfile.TemporaryDirectory() as root:
            subprocess.run([os.environ["MAKE_EXPORTS"], root], check=True)
            data = TorchStereoDataset(Path(root) / "archive")
            paths, left, right, flow, valid = data[0]
            self.assertEqual(tuple(left.shape), (3, 54, 96))
            self.assertEqual(tuple(flow.shape), (1, 54, 96))
            self.assertEqual(tuple(valid.shape), (54, 96))
            self.assertGreater(float(left.max()), 1)
            self.assertTrue(bool((flow[0][valid > 0] < 0).all()))
            self.assertEqual(len(paths), 3)
            disparity = data.data[0].disparity
            np.testing.assert_array_equal(flow[0].numpy(), -disparity)
            # The left pixel moved by the flow is the right one.
            y, x = np.nonzero((valid.numpy() > 0) & ~data.data.frames[0].occluded())
            at = np.round(x + flow[0].numpy()[y, x]).astype(int)
            inside = (at >= 0) & (at < 96)
            difference = (left.numpy()[:, y, x] - right.numpy()[:, y, np.clip(at, 0, 95)])[:, inside]
            self.assertLess(np.median(np.abs(difference)), 12)
            seen = []
            keep = lambda l, r, f: seen.append(f) or (l, r, f)
            for sign in (-1, 1):
                options = {"augment": keep, "sign": sign}
                augmented = TorchStereoDataset(Path(root) / "archive", **options)[0]
                known = augmented[4].numpy() > 0
                np.testing.assert_array_equal(known, valid.numpy() > 0)
                np.testing.assert_array_equal(augmented[3][0].numpy()[known], sign * disparity[known])
                np.testing.assert_array_equal(seen[-1][known][:, 0], sign * disparity[known])
                self.assertTrue((sign * seen[-1][~known][:, 0] > 1e5).all())
            # Resizing mixes neighbours.
            mixes = lambda l, r, f: (l, r, 0.9 * f + 0.1 * np.roll(f, 1, axis=1))
            mixed = TorchStereoDataset(Path(root) / "archive", augment=mixes)[0]
            self.assertLessEqual(float(-mixed[3].min()), disparity.max())
            with self.assertRaisesRegex(ValueError, "allowed are -1 and 1"):
                TorchStereoDataset(Path(root) / "archive", sign=0)


if __name__ == "__main__":
    unittest.main()
