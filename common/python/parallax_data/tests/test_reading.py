"""Options of the reader: maps, transforms, folders that grow."""

import copy
import dataclasses
import shutil
import sys
import tempfile
import types
import unittest
import unittest.mock
from pathlib import Path

import numpy as np

from exports_case import ExportsCase
from parallax_data import ParallaxDataset
from parallax_data.augment import RaftAugment
from parallax_data.rerun import main as show
from parallax_data.rerun import points


class Options(ExportsCase):
    def test_maps_come_with_the_pair(self):
        data = ParallaxDataset(self.root / "archive", maps=("normals", "depth", "occluded"))
        pair = data[0]
        self.assertEqual(set(pair.maps), {"normals", "depth", "occluded"})
        np.testing.assert_array_equal(pair.maps["normals"], pair.frame.normals())
        np.testing.assert_array_equal(pair.maps["occluded"], pair.frame.occluded())
        with self.assertRaisesRegex(ValueError, "maps 'normal': allowed are depth, normals"):
            ParallaxDataset(self.root / "archive", maps=["normal"])

    def test_a_transform_makes_what_is_returned(self):
        data = ParallaxDataset(self.root / "archive", transform=lambda pair: pair.disparity.max())
        self.assertEqual(data[0], self.data[0].disparity.max())
        self.assertEqual(len(list(data)), 9)

    def test_reprs_say_what_is_there(self):
        self.assertEqual(repr(self.data), "ParallaxDataset(9 pairs of 5 scenes, variants a)")
        test = ParallaxDataset(self.root / "archive", split="test", filtered=False)
        self.assertEqual(repr(test), f"ParallaxDataset({len(test)} pairs of 1 scenes, variants a, split test, unfiltered)")
        self.assertRegex(repr(self.data[0]), r"^Pair\(a/000000/000, 96x54, disparity [\d.]+ to [\d.]+ px, \d+ % valid\)$")

    def test_a_folder_that_grows_reads_as_far_as_it_is(self):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name) / "archive"
            shutil.copytree(self.root / "archive", folder)
            index = folder / "a" / "index.jsonl"
            lines = index.read_text().splitlines(keepends=True)
            index.write_text("".join(lines[:4]))
            data = ParallaxDataset(folder, filtered=False)
            self.assertEqual(len(data), 4)
            self.assertEqual(data.refresh(), 0)
            index.write_text("".join(lines))
            self.assertEqual(data.refresh(), 6)
            self.assertEqual(len(data), 10)

    def test_a_variant_without_its_index_is_refused(self):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name) / "archive"
            shutil.copytree(self.root / "archive", folder)
            shutil.copytree(folder / "a", folder / "b")
            (folder / "b" / "index.jsonl").unlink()
            with self.assertRaisesRegex(FileNotFoundError, "b/index.jsonl"):
                ParallaxDataset(folder)
            self.assertEqual(len(ParallaxDataset(folder, variants=["a"])), 9)
            shutil.rmtree(folder / "b" / "frames")
            (folder / "b" / "frames").mkdir()  # A variant whose first pair is still to come.
            self.assertEqual(len(ParallaxDataset(folder)), 9)

    def test_the_last_line_of_a_copy_may_be_half(self):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name) / "archive"
            shutil.copytree(self.root / "archive", folder)
            index = folder / "a" / "index.jsonl"
            text = index.read_bytes()
            ends = [at + 1 for at, byte in enumerate(text) if byte == 10]
            for size, pairs in ((ends[3] + 1, 4), (ends[4] - 2, 4), (ends[4] - 1, 5), (ends[4], 5), (0, 0)):
                index.write_bytes(text[:size])
                self.assertEqual(len(ParallaxDataset(folder, filtered=False)), pairs, size)
            index.write_bytes(text[:ends[3] - 20] + text[ends[3] - 1:])
            with self.assertRaisesRegex(ValueError, "index.jsonl:4: not a line of an index"):
                ParallaxDataset(folder)

    def test_points_lie_where_the_depth_says(self):
        frame = self.data.frames[0]
        where, colors = points(frame)
        self.assertEqual(where.shape, (int((frame.valid() & (frame.depth() > 0)).sum()), 3))
        self.assertEqual(colors.shape, where.shape)
        pose = np.asarray(frame.camera()["world_from_left"], np.float64).reshape(-1, 4)
        seen = (where - pose[:3, 3]) @ pose[:3, :3]
        depth = frame.depth()[frame.valid() & (frame.depth() > 0)]
        np.testing.assert_allclose(seen[:, 2], depth, rtol=1e-4)

    def test_pairs_go_into_a_file_of_the_rerun_viewer(self):
        try:
            import rerun  # noqa: F401
        except ImportError:
            self.skipTest("rerun is optional and not installed")
        with tempfile.TemporaryDirectory() as folder:
            sizes = []
            for pairs in ("1", "2"):
                show([str(self.root / "archive"), "--pairs", pairs, "--save", f"{folder}/{pairs}.rrd"])
                sizes.append(Path(folder, f"{pairs}.rrd").stat().st_size)
            self.assertGreater(sizes[0], 96 * 54 * 3)
            self.assertGreater(sizes[1], sizes[0] + 96 * 54 * 3)


class Augmented(ExportsCase):
    def test_disparity_goes_along_with_the_pictures(self):
        # Colours stay, so that the right picture can be moved onto the left one.
        augment = RaftAugment((40, 64), y_jitter=0, erase_p=0, seed=3)
        augment._colors = lambda left, right: (left, right)
        errors = []
        for pair in ParallaxDataset(self.root / "archive", transform=augment):
            self.assertEqual(pair.left.shape, (40, 64, 3))
            self.assertEqual(pair.right.shape, (40, 64, 3))
            self.assertEqual(pair.disparity.shape, (40, 64))
            self.assertTrue((pair.disparity[pair.valid] > 0).all())
            y, x = np.nonzero(pair.valid)
            at = np.round(x - pair.disparity[y, x]).astype(int)
            inside = at >= 0
            errors.append(np.median(np.abs(pair.left[y, x][inside].astype(int) - pair.right[y, at][inside])))
            wrong = np.clip(at - 9, 0, 63)
            self.assertGreater(np.abs(pair.left[y, x][inside].astype(int) - pair.right[y, wrong][inside]).mean(),
                               np.abs(pair.left[y, x][inside].astype(int) - pair.right[y, at][inside]).mean())
        self.assertLess(np.median(errors), 14)

    def test_scales_scale_the_disparity(self):
        pair = self.data[0]
        twice = RaftAugment((54, 96), scale=(1, 1), stretch=0, y_jitter=0, seed=1)(pair)
        self.assertTrue(set(np.unique(twice.disparity)) <= set(np.unique(2 * pair.disparity)))

    def test_a_seed_gives_the_same_pairs_and_another_does_not(self):
        first, again, other = (RaftAugment((32, 48), seed=seed)(self.data[1]) for seed in (5, 5, 6))
        np.testing.assert_array_equal(first.left, again.left)
        np.testing.assert_array_equal(first.right, again.right)
        self.assertFalse(np.array_equal(first.left, other.left))

    def test_maps_go_along_and_others_are_refused(self):
        maps = ("depth", "occluded")
        pair = ParallaxDataset(self.root / "archive", maps=maps, transform=RaftAugment((32, 48), seed=4))[0]
        camera = pair.frame.camera()
        constant = np.median(pair.disparity[pair.valid] * pair.maps["depth"][pair.valid])
        np.testing.assert_allclose(pair.disparity[pair.valid] * pair.maps["depth"][pair.valid], constant, rtol=1e-3)
        self.assertGreater(constant, camera["baseline_m"])
        self.assertEqual({values.shape for values in pair.maps.values()}, {(32, 48)})
        with self.assertRaisesRegex(ValueError, "maps 'layers'"):
            RaftAugment((32, 48))(dataclasses.replace(pair, maps={"layers": None}))

    def test_workers_and_epochs_of_a_loader_draw_others(self):
        def draws(seed):
            loader = types.SimpleNamespace(get_worker_info=lambda: types.SimpleNamespace(seed=seed))
            with unittest.mock.patch.dict(sys.modules, {"torch.utils.data": loader}):
                return [copied(self.data[1]).left.tobytes() for copied in (copy.deepcopy(augment),) for _ in range(2)]
        augment = RaftAugment((32, 48), seed=5)
        first, again, other = draws(7), draws(7), draws(8)
        self.assertEqual(first, again)
        self.assertEqual(len({*first, *other}), 4)

    def test_eyes_differ_in_colour_only_where_asked(self):
        pair = self.data[0]
        same = RaftAugment((54, 96), scale=(0, 0), stretch=0, y_jitter=0, asymmetric_p=0, erase_p=0, seed=2)
        brightness = [np.mean(picture) for picture in (same(pair).left, same(pair).right)]
        self.assertLess(abs(brightness[0] - brightness[1]), 60)
        with self.assertRaisesRegex(ValueError, "size"):
            RaftAugment((0, 10))


if __name__ == "__main__":
    unittest.main()
