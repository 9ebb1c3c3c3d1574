"""Reads a synthetic archive and its exports in every layout with nothing but numpy and OpenCV, and compares.

The decoders below are written from the formats' own descriptions, as public training code reads them; they share
nothing with the exporter. MAKE_EXPORTS is the program that writes the files (tests/worker/dataset)."""

import dataclasses
import glob
import gzip
import io
import json
import os
import re
import subprocess
import sys
import tarfile
import tempfile
import unittest
from pathlib import Path

from parallax_data import ParallaxDataset

import cv2
import numpy as np


def read_pfm(path):
    """As FlyingThings3D's and RAFT-Stereo's readers do."""
    with open(path, "rb") as file:
        header = file.readline().rstrip()
        assert header in (b"Pf", b"PF"), header
        width, height = map(int, re.match(rb"^(\d+)\s(\d+)\s$", file.readline()).groups())
        scale = float(file.readline().rstrip())
        data = np.fromfile(file, "<f" if scale < 0 else ">f")
    return np.flipud(data.reshape((height, width) if header == b"Pf" else (height, width, 3)))


def rgb(path):
    image = cv2.imread(str(path), cv2.IMREAD_COLOR)
    assert image is not None, path
    return image[:, :, ::-1]


def png_header(path):
    data = Path(path).read_bytes()
    return {"bits": data[24], "color": data[25]}


class Exports(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.root = Path(cls.temporary.name)
        subprocess.run([os.environ["MAKE_EXPORTS"], str(cls.root)], check=True)
        cls.data = ParallaxDataset(cls.root / "archive")
        cls.frames = {(f.scene, f.rig): f for f in cls.data.frames}

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def frame_of(self, scene, rig):
        return self.frames.pop((scene, rig))

    def setUp(self):
        self.frames = {(f.scene, f.rig): f for f in self.data.frames}

    def assert_all_seen(self):
        self.assertEqual(self.frames, {}, "frames that the export lacks")

    # ---- the archive ----------------------------------------------------------------------------

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

    # ---- the layouts ----------------------------------------------------------------------------

    def test_flyingthings_as_raft_stereo_reads_it(self):
        root = self.root / "flyingthings"
        for split, scenes in (("TRAIN", {0, 1, 2, 3}), ("TEST", {4})):
            for dstype in ("frames_cleanpass", "frames_finalpass"):
                left = sorted(glob.glob(str(root / dstype / split / "*/*/left/*.png")))
                right = [path.replace("left", "right") for path in left]
                disparity = [path.replace(dstype, "disparity").replace(".png", ".pfm") for path in left]
                self.assertEqual({int(path.split("/")[-3]) for path in left}, scenes)
                for l, r, d in zip(left, right, disparity):
                    key = int(l.split("/")[-3]), int(Path(l).stem)
                    frame = self.frames.pop(key) if dstype == "frames_cleanpass" else None
                    if frame is None:
                        continue
                    np.testing.assert_array_equal(rgb(l), frame.image("left"))
                    np.testing.assert_array_equal(rgb(r), frame.image("right"))
                    for eye in ("left", "right"):
                        truth = frame.disparity(eye)  # Readers take all below 512 for truth, 0 as well.
                        wanted = np.where(truth > 0, truth, np.inf)
                        np.testing.assert_array_equal(read_pfm(d.replace("left", eye)), wanted)
                    for eye, path in (("left", l), ("right", r)):
                        occlusion = path.replace(dstype, "disparity_occlusions")
                        self.assertEqual(png_header(occlusion), {"bits": 1, "color": 0})
                        bits = cv2.imread(occlusion, cv2.IMREAD_GRAYSCALE)
                        np.testing.assert_array_equal(bits != 0, frame.occluded(eye))
        self.assert_all_seen()
        lines = (root / "train.txt").read_text().split("\n")[:-1] + (root / "test.txt").read_text().split("\n")[:-1]
        self.assertEqual(len(lines), 9)
        for line in lines:
            self.assertTrue(all((root / path).is_file() for path in line.split()))

    def test_fsd_as_foundation_stereo_decodes_it(self):
        root = self.root / "fsd"
        for left in sorted(root.glob("*/dataset/data/left/rgb/*.jpg")):
            data = left.parents[2]
            frame = self.frame_of(int(left.parents[4].name), int(left.stem))
            encoded = rgb(data / "left/disparity" / (left.stem + ".png")).astype(float)
            decoded = (encoded[..., 0] * 255 * 255 + encoded[..., 1] * 255 + encoded[..., 2]) / 1000
            np.testing.assert_allclose(decoded, frame.disparity(), atol=5.1e-4)
            for eye in ("left", "right"):
                jpeg = rgb(data / eye / "rgb" / left.name).astype(int)
                self.assertLess(np.abs(jpeg - frame.image(eye)).mean(), 8)
            lines = (data / "K.txt").read_text().splitlines()
            camera = next(f for f in self.data.frames if f.scene == frame.scene).camera()
            k = np.array(list(map(float, lines[0].split()))).reshape(3, 3)
            self.assertAlmostEqual(k[0, 0], camera["intrinsics"]["fx"], places=4)
            self.assertAlmostEqual(k[1, 2], camera["intrinsics"]["cy"], places=4)
            self.assertAlmostEqual(float(lines[1]), camera["baseline_m"], places=8)
        self.assert_all_seen()

    def crestereo(self, root, parse):
        folders = ("shapenet", "reflective", "tree", "hole")
        self.assertEqual(sorted(p.name for p in root.iterdir() if p.is_dir()), sorted(folders))
        for folder in folders:
            found = sorted((root / folder).rglob("*_left.jpg"))
            self.assertTrue(found, folder)  # Readers give up on an empty one.
            for left in found:
                frame = self.frame_of(*parse(left))
                for eye in ("left", "right"):
                    path = str(left).replace("_left.jpg", f"_{eye}.disp.png")
                    encoded = cv2.imread(path, cv2.IMREAD_UNCHANGED)
                    self.assertEqual(encoded.dtype, np.uint16)
                    np.testing.assert_allclose(encoded.astype(np.float32) / 32, frame.disparity(eye), atol=1 / 63)
                    self.assertEqual(rgb(str(left).replace("_left.jpg", f"_{eye}.jpg")).shape, (54, 96, 3))
        self.assert_all_seen()

    def test_crestereo(self):
        self.crestereo(self.root / "crestereo", lambda p: (int(p.parent.name), int(p.name.split("_")[0])))

    def test_crestereo_flat(self):
        root = self.root / "crestereo_flat"
        self.assertEqual([p for p in root.glob("*/*") if p.is_dir()], [])
        self.crestereo(root, lambda p: tuple(map(int, p.name.split("_")[:2])))

    def test_wmgstereo_with_three_wildcard_levels(self):
        root = self.root / "wmgstereo"
        for left in sorted(glob.glob(str(root / "*/*/*/Image/camera_0/*.png"))):
            frame = self.frame_of(int(left.split("/")[-5]), int(Path(left).stem))
            self.assertEqual(left.split("/")[-6], "indoor")
            for eye, camera in (("left", "camera_0"), ("right", "camera_1")):
                image = left.replace("camera_0", camera)
                np.testing.assert_array_equal(rgb(image), frame.image(eye))
                disparity = np.load(image.replace("Image", "disparity").replace(".png", ".npy"))
                self.assertEqual(disparity.dtype, np.float32)
                np.testing.assert_array_equal(disparity, frame.disparity(eye))
        self.assert_all_seen()

    def test_middlebury(self):
        root = self.root / "middlebury"
        for folder in sorted(p for p in root.iterdir() if p.is_dir()):
            frame = self.frame_of(*map(int, folder.name.split("_")))
            np.testing.assert_array_equal(rgb(folder / "im0.png"), frame.image("left"))
            np.testing.assert_array_equal(rgb(folder / "im1.png"), frame.image("right"))
            for eye, name in (("left", "disp0GT.pfm"), ("right", "disp1GT.pfm")):
                disparity = read_pfm(folder / name)
                known = np.isfinite(disparity)
                np.testing.assert_array_equal(known, frame.disparity(eye) > 0)
                np.testing.assert_array_equal(disparity[known], frame.disparity(eye)[known])
            mask = cv2.imread(str(folder / "mask0nocc.png"), cv2.IMREAD_UNCHANGED)
            surface, occluded = frame.disparity() > 0, frame.occluded()
            np.testing.assert_array_equal(mask == 255, surface & ~occluded)
            np.testing.assert_array_equal(mask == 128, surface & occluded)
            np.testing.assert_array_equal(mask == 0, ~surface)
            calib = dict(line.split("=", 1) for line in (folder / "calib.txt").read_text().splitlines())
            camera = frame.camera()
            k = np.array([[float(v) for v in row.split()] for row in calib["cam0"].strip("[]").split(";")])
            np.testing.assert_allclose([k[0, 0], k[1, 1], k[0, 2], k[1, 2]],
                                       [camera["intrinsics"][n] for n in ("fx", "fy", "cx", "cy")], rtol=1e-8)
            self.assertEqual(calib["cam0"], calib["cam1"])
            self.assertAlmostEqual(float(calib["baseline"]), 1000 * camera["baseline_m"], places=4)
            self.assertEqual((int(calib["width"]), int(calib["height"])), (96, 54))
            self.assertEqual(float(calib["doffs"]), 0)
            self.assertGreater(int(calib["ndisp"]), frame.disparity().max())
        self.assert_all_seen()

    def test_kitti(self):
        root = self.root / "kitti" / "training"
        order = sorted(self.frames)
        names = sorted(p.name for p in (root / "image_2").iterdir())
        self.assertEqual(names, [f"{i:06d}_10.png" for i in range(9)])
        for folder in ("image_3", "disp_occ_0", "disp_noc_0"):
            self.assertEqual(sorted(p.name for p in (root / folder).iterdir()), names)
        for name, key in zip(names, order):
            frame = self.frames[key]
            np.testing.assert_array_equal(rgb(root / "image_2" / name), frame.image("left"))
            np.testing.assert_array_equal(rgb(root / "image_3" / name), frame.image("right"))
            occ = cv2.imread(str(root / "disp_occ_0" / name), cv2.IMREAD_ANYDEPTH).astype(np.float64) / 256
            noc = cv2.imread(str(root / "disp_noc_0" / name), cv2.IMREAD_ANYDEPTH).astype(np.float64) / 256
            truth = frame.disparity()
            fits = truth * 256 <= 65535
            np.testing.assert_allclose(occ[fits], truth[fits], atol=1 / 511)
            self.assertTrue((occ[~fits] == 0).all())
            np.testing.assert_array_equal(noc, np.where(frame.occluded(), 0, occ))

    def test_webdataset(self):
        shards = sorted((self.root / "webdataset").glob("*.tar"), reverse=True)
        self.assertEqual([s.name for s in shards], ["train-000001.tar", "train-000000.tar", "test-000000.tar"])
        splits = set()
        for shard in shards:
            samples = {}
            with tarfile.open(shard) as archive:
                for member in archive:
                    key, extension = member.name.split(".", 1)
                    samples.setdefault(key, {})[extension] = archive.extractfile(member).read()
            for key, sample in samples.items():
                self.assertEqual(set(sample), {"left.png", "right.png", "disp.npy", "occ.png", "json"})
                frame = self.frame_of(*map(int, key.split("_")))
                decode = lambda name: cv2.imdecode(np.frombuffer(sample[name], np.uint8), cv2.IMREAD_UNCHANGED)
                np.testing.assert_array_equal(decode("left.png")[:, :, ::-1], frame.image("left"))
                np.testing.assert_array_equal(decode("right.png")[:, :, ::-1], frame.image("right"))
                np.testing.assert_array_equal(np.load(io.BytesIO(sample["disp.npy"])), frame.disparity())
                np.testing.assert_array_equal(decode("occ.png") != 0, frame.occluded())
                info = json.loads(sample["json"])
                self.assertEqual(info["baseline_m"], frame.camera()["baseline_m"])
                splits.add((shard.name.split("-")[0], info["split"]))
                self.assertEqual([row["index"] for row in info["objects"]],
                                 [int(index) for index in frame.camera()["objects"]])
        self.assertEqual(splits, {("train", "TRAIN"), ("test", "TEST")})
        self.assert_all_seen()

    # ---- sequences ------------------------------------------------------------------------------

    def sequences(self):
        data = ParallaxDataset(self.root / "archive_sequences")
        self.assertEqual(len(data), 8)
        sequences = data.sequences()
        self.assertEqual([[(f.scene, f.rig) for f in frames] for frames in sequences],
                         [[(0, 0), (0, 1), (0, 2), (0, 3)], [(1, 0), (1, 1), (1, 2), (1, 3)]])
        return sequences

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

    def test_flyingthings_flow_as_raft_reads_it(self):
        root = self.root / "flyingthings-flow"
        pairs = 0
        for direction, towards in (("into_future", "forward"), ("into_past", "backward")):
            image_dirs = [os.path.join(d, "left") for d in sorted(glob.glob(str(root / "frames_cleanpass/TRAIN/*/*")))]
            flow_dirs = [os.path.join(d, direction, "left") for d in sorted(glob.glob(str(root / "optical_flow/TRAIN/*/*")))]
            change_dirs = [os.path.join(d, direction, "left") for d in
                           sorted(glob.glob(str(root / "disparity_change/TRAIN/*/*")))]
            for image_dir, flow_dir, change_dir in zip(image_dirs, flow_dirs, change_dirs):
                images, flows = sorted(glob.glob(image_dir + "/*.png")), sorted(glob.glob(flow_dir + "/*.pfm"))
                changes = sorted(glob.glob(change_dir + "/*.pfm"))
                self.assertEqual(len(images), len(flows))
                for i in range(len(flows) - 1):
                    k = i if direction == "into_future" else i + 1
                    frame = self.sequences()[int(Path(image_dir).parent.name[:6])][k]
                    np.testing.assert_array_equal(rgb(images[k]), frame.image())
                    read = read_pfm(flows[k])
                    self.assertEqual(read.shape, (54, 96, 3))
                    np.testing.assert_array_equal(read[..., :2], frame.flow(towards).flow)
                    np.testing.assert_array_equal(read_pfm(changes[k]), frame.flow(towards).disparity_change)
                    pairs += 1
                unknown = read_pfm(flows[-1 if direction == "into_future" else 0])[..., :2]
                self.assertTrue((unknown > 1e9).all())
        self.assertEqual(pairs, 6)

    def test_sintel_as_raft_and_dynamic_stereo_read_it(self):
        for split, scene in (("training", 0), ("test", 1)):
            frames = self.sequences()[scene]
            root = self.root / "sintel" / "Sintel" / split
            names = sorted(p.name for p in (root / "clean").iterdir())
            self.assertEqual(names, [f"{scene:06d}-p1"])
            images = sorted(glob.glob(str(root / "clean" / names[0] / "*.png")))
            flows = sorted(glob.glob(str(root / "flow" / names[0] / "*.flo")))
            self.assertEqual([Path(p).name for p in images], [f"frame_{i:04d}.png" for i in range(1, 5)])
            self.assertEqual(len(flows), 3)
            for path, frame in zip(flows, frames):
                data = Path(path).read_bytes()
                self.assertEqual(np.frombuffer(data[:4], np.float32)[0], np.float32(202021.25))
                self.assertEqual(tuple(np.frombuffer(data[4:12], np.int32)), (96, 54))
                flow = np.frombuffer(data[12:], np.float32).reshape(54, 96, 2)
                np.testing.assert_array_equal(flow, frame.flow().flow)
                occluded = cv2.imread(path.replace("/flow/", "/occlusions/").replace(".flo", ".png"), cv2.IMREAD_UNCHANGED)
                np.testing.assert_array_equal(occluded == 255, frame.flow().occluded)
            stereo = self.root / "sintel" / "sintel_stereo" / split
            for image, frame in zip(sorted(glob.glob(str(stereo / "clean_right" / names[0] / "*.png"))), frames):
                np.testing.assert_array_equal(rgb(image), frame.image("right"))
                place = image.replace("clean_right", "disparities")
                r, g, b = np.moveaxis(rgb(place).astype(np.float64), 2, 0)
                np.testing.assert_allclose(r * 4 + g / 64 + b / 16384, frame.disparity(), atol=1 / 32000)
                hidden = rgb(place.replace("disparities", "occlusions"))[..., 0] > 0
                outside = rgb(place.replace("disparities", "outofframe"))[..., 0] > 0
                self.assertTrue((hidden <= frame.occluded()).all())
                self.assertTrue((outside <= frame.occluded()).all())

    def test_dynamic_replica_as_dynamic_stereo_reads_it(self):
        def halves(path):
            bits = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
            self.assertEqual(bits.dtype, np.uint16)
            return bits.view(np.float16).astype(np.float32)
        for split, scene in (("train", 0), ("test", 1), ("valid", 1)):
            root = self.root / "dynamic-replica" / split
            with gzip.open(root / f"frame_annotations_{split}.jgz", "rt", encoding="utf8") as file:
                annotations = json.load(file)
            self.assertEqual([(a["camera_name"], a["frame_number"]) for a in annotations],
                             [(eye, i) for eye in ("left", "right") for i in range(4)])
            frames = self.sequences()[scene]
            for a in annotations:
                frame, eye = frames[a["frame_number"]], a["camera_name"]
                np.testing.assert_array_equal(rgb(root / a["image"]["path"]), frame.image(eye))
                self.assertEqual(a["image"]["size"], [54, 96])
                np.testing.assert_allclose(halves(root / a["depth"]["path"]), frame.depth(eye), rtol=6e-4)
                mask = cv2.imread(str(root / a["mask"]["path"]), cv2.IMREAD_UNCHANGED) > 0
                np.testing.assert_array_equal(mask, np.isin(frame.objects(eye), [3, 4]))
                self.assertAlmostEqual(a["frame_timestamp"], 0.1 * a["frame_number"])
                self.camera(a["viewpoint"], frame, eye)
                for direction, end in (("forward", 3), ("backward", 0)):
                    if a["frame_number"] == end:
                        self.assertIsNone(a[f"flow_{direction}"])
                        continue
                    both = halves(root / a[f"flow_{direction}"]["path"])
                    flow = np.stack([both[:, :96], both[:, 96:]], -1)
                    np.testing.assert_allclose(flow, frame.flow(direction, eye).flow, rtol=6e-4, atol=1e-4)
                    seen = cv2.imread(str(root / a[f"flow_{direction}_mask"]["path"]), cv2.IMREAD_UNCHANGED) > 0
                    np.testing.assert_array_equal(seen, ~frame.flow(direction, eye).occluded)

    def camera(self, viewpoint, frame, eye):
        """PyTorch3D: x = X R + T, x to the left, y up; in NDC of half of the smaller side."""
        camera = frame.camera()
        pose, k = np.array(camera[f"world_from_{eye}"]), camera["intrinsics"]
        point = pose[:3, :3] @ [0.3, -0.2, 2.5] + pose[:3, 3]  # In front of the camera, right and up.
        x, y, z = point @ np.array(viewpoint["R"]) + viewpoint["T"]
        np.testing.assert_allclose([x, y, z], [-0.3, 0.2, 2.5], atol=1e-9)
        half = min(k["width"], k["height"]) / 2
        focal = np.array(viewpoint["focal_length"]) * half
        centre = np.array([k["width"] / 2, k["height"] / 2]) - np.array(viewpoint["principal_point"]) * half
        np.testing.assert_allclose([*focal, *centre], [k["fx"], k["fy"], k["cx"], k["cy"]], rtol=1e-9)

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

    def test_exports_of_infrared_and_raw_pairs(self):
        frames = {(f.scene, f.rig): f for f in ParallaxDataset(self.root / "archive_extras").frames}
        shards = sorted((self.root / "archive_extras_webdataset").glob("*.tar"))
        seen = 0
        for shard in shards:
            with tarfile.open(shard) as archive:
                for member in archive:
                    key, extension = member.name.split(".", 1)
                    frame = frames[tuple(map(int, key.split("_")))]
                    content = archive.extractfile(member).read()
                    decode = lambda: cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED)
                    if extension == "infrared_left.png":
                        np.testing.assert_array_equal(decode(), frame.infrared("left"))
                        seen += 1
                    elif extension == "raw_flow_right.npy":
                        flow = np.load(io.BytesIO(content))
                        np.testing.assert_array_equal(flow[:, :, :2], frame.raw_flow("right"))
                        self.assertTrue((flow[:, :, 2] == 1).all())
                        seen += 1
                    elif extension == "disparity2_left.npy":
                        np.testing.assert_array_equal(np.load(io.BytesIO(content)), frame.map("disparity2", "left"))
                        seen += 1
                    elif extension == "disparity3_left.npy":
                        self.assertTrue((np.load(io.BytesIO(content)) == 0).all())
                        seen += 1
                    elif extension == "layers_right.png":
                        np.testing.assert_array_equal(decode(), frame.map("layers", "right"))
                        seen += 1
                    elif extension == "raw_left.png":
                        np.testing.assert_array_equal(decode()[:, :, ::-1], frame.raw_image("left"))
                        seen += 1
        self.assertEqual(seen, 6 * len(frames))
        infrared = self.root / "archive_extras_infrared"
        self.assertEqual(json.loads((infrared / "export.json").read_text())["pictures"], "infrared")
        pictures = sorted((infrared / "frames_finalpass").glob("*/A/*/left/*.png"))
        self.assertEqual(len(pictures), len(frames))
        for picture in pictures:
            frame = frames[int(picture.parts[-3]), int(picture.stem)]
            np.testing.assert_array_equal(rgb(picture)[:, :, 0], frame.infrared("left"))

    def test_rules_that_readers_impose(self):
        words = re.compile(r"left|right|rgb|disparity|frames_|\s")
        allowed = {"left", "right", "rgb", "disparity", "disparity_occlusions", "disparity_change", "frames_cleanpass",
                   "frames_finalpass"}
        for layout in (p for p in self.root.iterdir() if p.is_dir() and not p.name.startswith("archive")):
            manifest = json.loads((layout / "export.json").read_text())
            self.assertGreater(sum(f["split"] == "TEST" for f in manifest["frames"]), 0)
            scenes = [(f["variant"], f["scene"]) for f in manifest["frames"]]
            seen = [scenes[0]] + [b for a, b in zip(scenes, scenes[1:]) if a != b]
            self.assertEqual(len(seen), len(set(seen)), "frames of one scene are not consecutive")
            self.assertEqual(set(manifest["disparity_fraction_below_px"]), {"192", "256", "416", "512", "700", "1000"})
            for path in layout.rglob("*"):
                name = path.name
                if layout.name in ("sintel", "dynamic-replica"):
                    break  # Their readers go by lists and fixed names.
                if path.is_dir() and name not in allowed:
                    self.assertIsNone(words.search(name), path)
                if path.is_dir() and name == "left":
                    right = path.parent / "right"
                    count = lambda p: sum(1 for f in p.rglob("*") if f.suffix in (".png", ".jpg", ".pfm"))
                    if layout.name == "flyingthings":
                        self.assertEqual(count(path), count(right))
            sums = subprocess.run(["sha256sum", "--quiet", "-c", "SHA256SUMS"], cwd=layout, capture_output=True)
            self.assertEqual(sums.returncode, 0, sums.stderr)


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
            with self.assertRaisesRegex(ValueError, "allowed are -1 and 1"):
                TorchStereoDataset(Path(root) / "archive", sign=0)


if __name__ == "__main__":
    unittest.main()
