"""Reads the exports in every layout with nothing but numpy and OpenCV, and compares them with their archive.

The decoders below are written from the formats' own descriptions, as public training code reads them; they share
nothing with the exporter."""

import glob
import gzip
import io
import json
import os
import re
import subprocess
import tarfile
import unittest
from pathlib import Path

from exports_case import ExportsCase
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


class Exports(ExportsCase):
    def frame_of(self, scene, rig):
        return self.frames.pop((scene, rig))

    def assert_all_seen(self):
        self.assertEqual(self.frames, {}, "frames that the export lacks")

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
                more = {f"{name}_{eye}.{kind}" for name, kind in (("masks", "png"), ("normals", "exr")) for eye in ("left", "right")}
                self.assertEqual(set(sample), {"left.png", "right.png", "disp.npy", "occ.png", "json"} | more)
                frame = self.frame_of(*map(int, key.split("_")))
                decode = lambda name: cv2.imdecode(np.frombuffer(sample[name], np.uint8), cv2.IMREAD_UNCHANGED)
                np.testing.assert_array_equal(decode("left.png")[:, :, ::-1], frame.image("left"))
                np.testing.assert_array_equal(decode("right.png")[:, :, ::-1], frame.image("right"))
                np.testing.assert_array_equal(np.load(io.BytesIO(sample["disp.npy"])), frame.disparity())
                np.testing.assert_array_equal(decode("occ.png") != 0, frame.occluded())
                np.testing.assert_array_equal(decode("masks_right.png"), frame.map("masks", "right"))
                np.testing.assert_array_equal(decode("normals_left.exr")[:, :, ::-1], frame.map("normals", "left"))
                info = json.loads(sample["json"])
                self.assertEqual(info["baseline_m"], frame.camera()["baseline_m"])
                splits.add((shard.name.split("-")[0], info["split"]))
                self.assertEqual([row["index"] for row in info["objects"]],
                                 [int(index) for index in frame.camera()["objects"]])
        self.assertEqual(splits, {("train", "TRAIN"), ("test", "TEST")})
        self.assert_all_seen()

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


if __name__ == "__main__":
    unittest.main()
