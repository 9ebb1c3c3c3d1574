"""Training repositories' own readers, unmodified, read exports: each finds all pairs, has the disparities of the dataset,
and takes for valid exactly the pixels with truth; its augmentation mixes no sky into them. Where truth is missing the
exports of floats say infinity: what each reader takes 0 for is tried, too, on the same exports with 0 in its place.

trainer_readers_test.py MAKE_EXPORTS PYTHON READER: one of READERS, whose variable names the folder of its repository.
Without it, or without torch, torchvision, OpenCV and Pillow in the interpreter that runs this, the test is skipped
(exit status 77). PYTHON is not used."""

from __future__ import annotations

import importlib.machinery
import importlib.util
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
import types
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from unittest import mock

SKIPPED = 77
CROP = [32, 64]  # Of pictures of 96x54.
FSD_TOLERANCE_PX, CRESTEREO_TOLERANCE_PX = 5.1e-4, 1 / 64  # They have steps of 1/1000 and 1/32 px.


@dataclass
class Sample:
    """A pair as a reader gives it: pictures (height, width, 3), positive disparities, the pixels that it trains on."""

    files: str  # Path of the left picture.
    left: Any
    right: Any
    disparity: Any
    valid: Any
    occluded: Any = None  # Where the reader has it.


@dataclass
class Case:
    """A dataset of a reader. `pairs` are those that it must find."""

    export: str
    samples: Iterable[Sample]
    pairs: int
    augmented: bool = False
    tolerance_px: float = 0  # Half of a step of the encoding; pictures may be JPEG, then.
    without_occluded: bool = False  # Occluded pixels are not valid.
    zero_counts: bool = False  # Pixels without truth are valid, too, because they are 0.


class Settings(dict[str, Any]):
    """A dictionary whose keys are attributes, too, as yacs and EasyDict have it."""

    def __getattr__(self, name: str) -> Any:
        if name not in self:
            raise AttributeError(name)
        return self[name]


def skip(why: str) -> None:
    print(f"skipped: {why}")
    sys.exit(SKIPPED)


def has(module: str) -> bool:
    return importlib.util.find_spec(module) is not None


def stand_in(*modules: str) -> None:
    """Modules that the reader's files import, and that what it does with an export does not use."""
    for name in modules:
        sys.modules[name] = mock.MagicMock(__spec__=importlib.machinery.ModuleSpec(name, None))


def bare_packages(repository: str, *names: str) -> None:
    """Packages without their own __init__, which would import networks."""
    for name in names:
        sys.modules[name] = types.ModuleType(name)
        sys.modules[name].__path__ = [os.path.join(repository, *name.split("."))]  # type: ignore[attr-defined]


def lines_of(path: Path) -> list[list[str]]:
    return [line.split() for line in path.read_text().splitlines()]


def write_list(path: Path, lines: list[list[str]], root: str = "") -> str:
    path.write_text("".join(" ".join(root + file for file in line) + "\n" for line in lines))
    return str(path)


def of_raft(dataset: Any, sign: int) -> Iterator[Sample]:
    """RAFT-Stereo's tuples, whose flow of the left picture is `sign` times the disparity."""
    for i in range(len(dataset)):
        paths, left, right, flow, valid = dataset[i]
        yield Sample(paths[0], left.numpy().transpose(1, 2, 0), right.numpy().transpose(1, 2, 0), sign * flow.numpy()[0],
                     valid.numpy() > 0.5)


RAFT_AUGMENTATION = {"min_scale": -0.2, "max_scale": 0.4, "do_flip": False, "yjitter": True}


def raft_stereo(repository: str, exports: Path) -> Iterator[Case]:
    stand_in("imageio", "skimage")
    sys.path.insert(0, repository)
    from core.stereo_datasets import SceneFlowDatasets
    root = exports / "datasets"
    root.mkdir()
    (root / "FlyingThings3D").symlink_to(exports / "flyingthings")
    for passes in ("frames_cleanpass", "frames_finalpass"):
        yield Case("flyingthings", of_raft(SceneFlowDatasets(None, root=str(root), dstype=passes), -1), 8)
    augmented = SceneFlowDatasets({"crop_size": CROP, **RAFT_AUGMENTATION}, root=str(root))
    yield Case("flyingthings", of_raft(augmented, -1), 8, augmented=True)
    test = SceneFlowDatasets(None, root=str(root), dstype="frames_finalpass", things_test=True)
    yield Case("flyingthings", of_raft(test, -1), 1)


def igev_stereo(repository: str, exports: Path) -> Iterator[Case]:
    stand_in("imageio", "skimage")
    sys.path.insert(0, repository)
    from core.stereo_datasets import SceneFlowDatasets
    root = str(exports / "flyingthings")
    for augmentation in (None, {"crop_size": CROP, **RAFT_AUGMENTATION}):
        dataset = SceneFlowDatasets(augmentation, root=root)
        yield Case("flyingthings", of_raft(dataset, 1), 8, augmented=augmentation is not None)
    yield Case("flyingthings", of_raft(SceneFlowDatasets(None, root=root, things_test=True), 1), 1)


def waft_stereo(repository: str, exports: Path) -> Iterator[Case]:
    stand_in("imageio", "h5py", "tabulate", "termcolor")
    sys.path.insert(0, repository)
    bare_packages(repository, "bridgedepth", "bridgedepth.dataloader", "bridgedepth.dataloader.base")
    from bridgedepth.dataloader.datasets import FSD, KITTI, CREStereo, SceneFlowDatasets, WMGStereo

    def samples(dataset: Any) -> Iterator[Sample]:
        for i in range(len(dataset)):
            pair = dataset[i]
            yield Sample(str(dataset.image_list[i][0]), pair["img1"].numpy().transpose(1, 2, 0),
                         pair["img2"].numpy().transpose(1, 2, 0), pair["disp"].numpy(), pair["valid"].numpy() > 0.5)

    datasets = exports / "datasets"
    for link, name in (("WMGStereo/release_subset", "wmgstereo"), ("sceneflow/FlyingThings3D", "flyingthings"), ("KITTI/2015", "kitti")):
        (datasets / link).parent.mkdir(parents=True)
        (datasets / link).symlink_to(exports / name)
    for augmentation in (None, {"crop_size": CROP, **RAFT_AUGMENTATION}):
        augmented = augmentation is not None

        def read(reader: Callable[..., Any], root: Path, **more: Any) -> Iterator[Sample]:
            return samples(reader(augmentation and dict(augmentation), root=str(root), **more))

        yield Case("wmgstereo", read(WMGStereo, datasets / "WMGStereo"), 9, augmented)
        yield Case("flyingthings", read(SceneFlowDatasets, datasets / "sceneflow"), 8, augmented)
        yield Case("fsd", read(FSD, exports / "fsd"), 9, augmented, FSD_TOLERANCE_PX)
        yield Case("crestereo", read(CREStereo, exports / "crestereo"), 9, augmented, CRESTEREO_TOLERANCE_PX)
        yield Case("kitti", read(KITTI, datasets / "KITTI", nonocc=True), 9, augmented, 1 / 512, without_occluded=True)


def openstereo(repository: str, exports: Path) -> Iterator[Case]:
    stand_in("easydict", "matplotlib", "matplotlib.pyplot", "yaml")
    bare_packages(repository, "stereo", "stereo.datasets", "stereo.utils")
    from stereo.datasets.sceneflow_dataset import FlyingThings3DSubsetDataset, SceneFlowDataset

    def samples(reader: type, list_file: str, steps: list[dict[str, Any]], **info: Any) -> Iterator[Sample]:
        transform = {"TRAINING": [Settings(step) for step in [*steps, {"NAME": "TransposeImage"}, {"NAME": "ToTensor"}]]}
        dataset = reader(Settings(DATA_PATH=str(root), DATA_SPLIT={"TRAINING": list_file}, **info),
                         Settings(DATA_TRANSFORM=transform), "training")
        for i in range(len(dataset)):
            pair = {key: value.numpy() if hasattr(value, "numpy") else value for key, value in dataset[i].items()}
            # Losses take disparities above 0; what has no flags has no other rule.
            valid = (pair["disp"] > 0) & (pair["disp"] < 512) & pair.get("valid", True)
            yield Sample(pair["name"], pair["left"].transpose(1, 2, 0), pair["right"].transpose(1, 2, 0), pair["disp"], valid,
                         pair.get("occ_mask"))

    root = exports / "flyingthings"
    crop = {"NAME": "RandomCrop", "SIZE": CROP, "Y_JITTER": False}
    scale = {"NAME": "RandomScale", "SIZE": CROP, "MIN_SCALE": -0.2, "MAX_SCALE": 0.4, "SCALE_PROB": 1, "STRETCH_PROB": 0.8}
    for steps in ([], [scale, crop]):
        yield Case("flyingthings", samples(SceneFlowDataset, str(root / "train.txt"), steps, RETURN_RIGHT_DISP=True), 8,
                   augmented=bool(steps))
    with_occlusion = []
    for left, right, disparity in lines_of(root / "train.txt"):
        occlusion = disparity.replace("disparity", "disparity_occlusions").replace(".pfm", ".png")
        with_occlusion.append([left, right, disparity, disparity.replace("left", "right"), occlusion,
                               occlusion.replace("left", "right")])
    list_file = write_list(exports / "occlusions.txt", with_occlusion)
    yield Case("flyingthings", samples(FlyingThings3DSubsetDataset, list_file, [], RETURN_OCC_MASK=True, ZEROING_OCC=False), 8)


def tao(repository: str, exports: Path) -> Iterator[Case]:
    package = "nvidia_tao_pytorch.cv.depth_net.dataloader"
    parts = package.split(".")
    bare_packages(repository, *(".".join(parts[:i + 1]) for i in range(len(parts))), package + ".stereo_datasets",
                  package + ".utils")
    stand_in("nvidia_tao_pytorch.core", "nvidia_tao_pytorch.core.loggers", "nvidia_tao_pytorch.core.loggers.api_logging")
    from nvidia_tao_pytorch.cv.depth_net.dataloader.stereo_datasets.stereo_dataset import FSD, Crestereo, GenericDataset, Middlebury
    from nvidia_tao_pytorch.cv.depth_net.dataloader.transforms import build_stereo_transforms
    from nvidia_tao_pytorch.cv.depth_net.dataloader.utils.dataset_utils import PrepareForNet
    augmentation = {"input_mean": [0.0] * 3, "input_std": [1 / 255] * 3, "color_aug_prob": 0.2, "color_aug_brightness": 0.4,
                    "color_aug_contrast": 0.4, "color_aug_saturation": [0.0, 1.4], "color_aug_hue_range": [-0.03, 0.03],
                    "eraser_aug_prob": 0.5, "do_flip": False, "crop_size": CROP, "min_scale": -0.2, "max_scale": 0.4,
                    "stretch_prob": 0.8, "max_stretch": 0.2, "spatial_aug_prob": 1.0, "yjitter_prob": 1.0,
                    "crop_min_valid_disp_ratio": 0.0}

    def samples(reader: type, list_file: str, transform: Callable[..., Any]) -> Iterator[Sample]:
        dataset = reader(list_file, transform, 416)
        for i in range(len(dataset)):
            pair = dataset[i]
            yield Sample(pair["image_path"], pair["image"].numpy().transpose(1, 2, 0),
                         pair["right_image"].numpy().transpose(1, 2, 0), pair["disparity"].numpy()[0],
                         pair["valid_mask"].numpy()[0])

    for transform, augmented in ((PrepareForNet(), False), (build_stereo_transforms(augmentation, 416, "train"), True)):
        for name, reader, tolerance_px in (("flyingthings", GenericDataset, 0), ("fsd", FSD, FSD_TOLERANCE_PX),
                                           ("crestereo", Crestereo, CRESTEREO_TOLERANCE_PX), ("middlebury", Middlebury, 0)):
            lines = lines_of(exports / name / "train.txt")
            if name == "middlebury":
                lines = [line + [line[0].replace("im0", "mask0nocc")] for line in lines]
            list_file = write_list(exports / f"{name}.txt", lines, f"{exports}/{name}/")
            if name != "crestereo" or not augmented:
                yield Case(name, samples(reader, list_file, transform), 8, augmented, tolerance_px,
                           without_occluded=name == "middlebury", zero_counts=name == "crestereo")


@dataclass
class Reader:
    variable: str
    source: str
    cases: Callable[[str, Path], Iterator[Case]]
    zero_counts: bool  # It trains on disparities of 0 in .pfm files.


READERS = {
    "raft-stereo": Reader("RAFT_STEREO", "https://github.com/princeton-vl/RAFT-Stereo", raft_stereo, True),
    "igev-stereo": Reader("IGEV_STEREO", "IGEV-Stereo of https://github.com/gangweiX/IGEV", igev_stereo, True),
    "waft-stereo": Reader("WAFT_STEREO", "https://github.com/princeton-vl/WAFT-Stereo", waft_stereo, False),
    "openstereo": Reader("OPENSTEREO", "https://github.com/XiandaGuo/OpenStereo", openstereo, False),
    "tao": Reader("TAO_PYTORCH", "https://github.com/NVIDIA-TAO/tao-pytorch", tao, True),
}


def replace_infinite_by_zero(pfm: Path) -> None:
    import numpy as np
    data = pfm.read_bytes()
    start = len(data) - len(data.split(b"\n", 3)[3])
    disparity = np.frombuffer(data[start:], "<f4")
    pfm.write_bytes(data[:start] + np.where(np.isfinite(disparity), disparity, np.float32(0)).tobytes())


def check(case: Case, exports: Path, frames: dict[tuple[int, int], Any]) -> None:
    import numpy as np
    entries = json.loads((exports / case.export / "export.json").read_text())["frames"]
    # The list names one of the two folders with pictures that the layout `flyingthings` has.
    frame_of = {entry["files"].split()[0].removeprefix("frames_finalpass"): frames[entry["scene"], entry["rig"]] for entry in entries}
    read = valid = no_truth = 0
    for sample in case.samples:
        read += 1
        valid += np.count_nonzero(sample.valid)
        if case.augmented:
            assert sample.disparity.shape == sample.valid.shape == tuple(CROP) == sample.left.shape[:2] == sample.right.shape[:2]
            disparity = sample.disparity[sample.valid]
            assert np.isfinite(disparity).all() and (disparity > 0).all(), "sky is mixed into valid disparities"
            continue
        frame = next(frame for file, frame in frame_of.items() if sample.files.endswith(file))
        truth = frame.disparity()
        occluded = frame.map("occlusion", "left") > 0
        known = (truth > 0) & ((frame.masks() & 3) == 0) & ~(case.without_occluded & occluded)
        difference = [np.abs(sample.left - frame.image("left").astype(float)), np.abs(sample.right - frame.image("right").astype(float))]
        assert max(d.mean() for d in difference) <= (8 if case.tolerance_px else 0), sample.files
        np.testing.assert_array_equal(sample.valid, known | case.zero_counts)
        np.testing.assert_allclose(sample.disparity[known], truth[known], rtol=0, atol=case.tolerance_px)
        if sample.occluded is not None:
            np.testing.assert_array_equal(sample.occluded, occluded)
        no_truth += np.count_nonzero(~known)
    assert read == case.pairs, f"{case.export}: {read} pairs, expected {case.pairs}"
    assert valid > 0 and (case.augmented or no_truth > 0), f"{valid} valid pixels, {no_truth} of sky"


def main(make_exports: str, name: str, repository: str) -> None:
    import numpy as np
    from parallax_data import ParallaxDataset
    random.seed(1)
    np.random.seed(1)
    with tempfile.TemporaryDirectory() as folder:
        exports, zeros = Path(folder) / "exports", Path(folder) / "zeros"
        subprocess.run([make_exports, exports], check=True)
        frames = {(f.scene, f.rig): f for f in ParallaxDataset(exports / "archive").frames}
        shutil.copytree(exports, zeros)
        for case in READERS[name].cases(repository, exports):
            check(case, exports, frames)
            print(f"{name} reads {case.export}" + (", augmented" if case.augmented else ""))
        for pfm in zeros.glob("flyingthings/disparity/**/*.pfm"):
            replace_infinite_by_zero(pfm)
        for case in READERS[name].cases(repository, zeros):
            if case.export == "flyingthings" and not case.augmented:
                check(replace(case, zero_counts=READERS[name].zero_counts), zeros, frames)
        print(f"{name} trains on disparities of 0" if READERS[name].zero_counts else f"{name} leaves 0 out")


if __name__ == "__main__":
    reader = READERS[sys.argv[3]]
    if not os.environ.get(reader.variable):
        skip(f"${reader.variable} is not set: the folder of {reader.source}")
    for module in ("torch", "torchvision", "cv2", "PIL"):
        if not has(module):
            skip(f"{sys.executable} has no {module}")
    main(sys.argv[1], sys.argv[3], os.environ[reader.variable])
