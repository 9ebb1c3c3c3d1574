"""The archive that `parallax run` and `parallax fetch` write."""

import json
import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Callable, Dict, Iterable, Iterator, List, Optional, Sequence, Union

import numpy as np

from . import frame_maps
from .masks import EXTERIOR, SKY

HELDOUT = "heldout"  # The variant of evaluate.heldout_pairs, which no network may be trained on.
TEST_EVERY = 20  # As `parallax export` splits: every Nth scene, at least one.


MAPS = ("depth", "normals", "occluded", "masks", "objects", "materials", "layers", "flow", "infrared", "raw_image",
        "raw_flow", "raw_occluded")  # What Pair.maps may have: methods of Frame.
FLOW_NONE = 128  # In flow_occlusion_*.png: no flow.


@dataclass(frozen=True)
class Flow:
    """From one frame of a sequence to a neighbour, of one eye."""

    flow: np.ndarray              # float32 (height, width, 2), pixels: where the surface point of a pixel's centre goes.
    disparity_change: np.ndarray  # float32 (height, width), pixels: its disparity there less its disparity here.
    valid: np.ndarray             # bool: there is flow. False everywhere where there is no neighbour; else nearly nowhere.
    occluded: np.ndarray          # bool: hidden in the neighbour, or outside of its picture. The flow is exact, too.


CLEARNESS = ("opaque", "thin_glass", "solid_glass", "water")


@dataclass(frozen=True)
class Layers:
    """All surfaces on each pixel's straight ray up to the first opaque one, at most four; layer 0 is what the other maps
    show. Arrays are (layers, height, width), with as many layers as any pixel has; 0 = no such layer."""

    count: np.ndarray      # uint8 (height, width): number of layers.
    more: np.ndarray       # bool (height, width): there are more than four.
    depth: np.ndarray      # float32, metres along the optical axis.
    disparity: np.ndarray  # float32, pixels.
    objects: np.ndarray    # uint16, keys of camera()["objects"].
    materials: np.ndarray  # uint16, keys of camera()["materials"].
    clear: np.ndarray      # uint8, how clear each is: an index into CLEARNESS.

    def last(self, stack: np.ndarray) -> np.ndarray:
        """(height, width): of one of the arrays above, the last layer of each pixel."""
        return np.take_along_axis(stack, np.maximum(self.count, 1)[None].astype(np.int64) - 1, 0)[0]

    @property
    def behind(self) -> np.ndarray:
        """float32 (height, width), pixels: disparity of the last layer; 0 where that is see-through itself, because nothing
        is behind it, or has more layers behind it."""
        return np.where(self.more | (self.last(self.clear) != 0), np.float32(0), self.last(self.disparity))


@dataclass(frozen=True)
class Frame:
    """One stereo pair on disk. Reads what it is asked for, anew each time."""

    path: Path
    variant: str
    scene: int
    rig: int
    passed: bool  # All filters.
    index: Dict = field(repr=False, hash=False, compare=False)  # Its line of index.jsonl.

    @property
    def key(self) -> str:
        return f"{self.variant}/{self.scene:06d}/{self.rig:03d}"

    def map(self, name: str, eye: str = "left", direction: str = "forward") -> np.ndarray:
        """Any map of the table (frame_maps.csv), by the name of its file without eye: "depth", "raw_flow"... As stored:
        float32 (height, width) or (height, width, 3); uint8 or uint16."""
        return frame_maps.read(self.path, name, eye, direction)

    def has(self, name: str, eye: str = "left", direction: str = "forward") -> bool:
        return (self.path / frame_maps.file_of(name, eye, direction)).exists()

    def image(self, eye: str = "left") -> np.ndarray:
        """uint8 (height, width, 3), RGB."""
        return self.map("", eye)

    def disparity(self, eye: str = "left") -> np.ndarray:
        return self.map("disparity", eye)

    def depth(self, eye: str = "left") -> np.ndarray:
        return self.map("depth", eye)

    def normals(self, eye: str = "left") -> np.ndarray:
        return self.map("normals", eye)

    def occluded(self, eye: str = "left", exact: bool = False) -> np.ndarray:
        """bool (height, width): not visible in the other eye. exact: by rays, not by re-projection; the study must
        have kept that map (render.maps: [..., exact_occlusion])."""
        return self.map("exact_occlusion" if exact else "occlusion", eye) != 0

    def masks(self, eye: str = "left") -> np.ndarray:
        """uint8 (height, width), bits of parallax_data.masks."""
        return self.map("masks", eye)

    def objects(self, eye: str = "left") -> np.ndarray:
        """uint16 (height, width), keys of camera()["objects"]; 0 = none."""
        return self.map("objects", eye)

    def materials(self, eye: str = "left") -> np.ndarray:
        return self.map("materials", eye)

    def layers(self, eye: str = "left") -> Layers:
        """What is behind glass and water (render.maps: [..., layers])."""
        counts = self.map("layers", eye)
        count = counts & 127

        def stack(name):
            first = self.map(name, eye)
            more = [self.map(f"{name}{n}", eye) for n in range(2, int(count.max(initial=0)) + 1)]
            return np.stack([np.where(count > 0, first, first.dtype.type(0)), *more])

        materials = stack("materials")
        clear = np.zeros(1 << 16, np.uint8)
        for index, entry in self.camera()["materials"].items():
            clear[int(index)] = CLEARNESS.index(entry.get("clear", "opaque"))
        depth = stack("depth")
        return Layers(count, counts >= 128, depth, stack("disparity"), stack("objects"), materials,
                      np.where(depth > 0, clear[materials], np.uint8(0)))

    def flow(self, direction: str = "forward", eye: str = "left") -> Flow:
        """Optical flow and scene flow to the next frame of the sequence ("forward") or to the one before ("backward")."""
        if direction not in ("forward", "backward"):
            raise ValueError(f"direction {direction!r}: allowed are forward and backward")
        maps = self.map("flow", eye, direction)
        mask = self.map("flow_occlusion", eye, direction)
        return Flow(maps[..., :2], maps[..., 2], mask != FLOW_NONE, mask == 255)

    def sequence(self) -> Optional[Dict]:
        """"path" (from 1), "time_s", and the rigs "previous" and "next" (None at an end); None for single views."""
        return self.camera().get("sequence")

    def infrared(self, eye: str = "left") -> np.ndarray:
        """uint8 (height, width): what a monochrome sensor sees under the rig's projector (render.maps: infrared)."""
        return self.map("infrared", eye)

    def raw_image(self, eye: str = "left") -> np.ndarray:
        """uint8 (height, width, 3), RGB, before rectification (render.maps: raw); its camera is camera()["raw"][eye]."""
        return self.map("raw", eye)

    def raw_flow(self, eye: str = "left") -> np.ndarray:
        """float32 (height, width, 2): from a raw pixel to where the other raw picture shows the same point, x and y in
        pixels. NaN where the other lens does not see that point."""
        stored = self.map("raw_flow", eye)
        return np.where(stored[:, :, 2:] != 0, stored[:, :, :2], np.float32("nan"))

    def raw_occluded(self, eye: str = "left") -> np.ndarray:
        """bool (height, width): the raw pixel's point is not visible in the other raw picture."""
        return self.map("raw_occlusion", eye) != 0

    def camera(self) -> Dict:
        """frame.json: intrinsics, baseline_m, poses, the tables of objects and materials. Seeds are int (files have
        them as strings, because not every reader of JSON keeps 64 bits; older files as numbers)."""
        camera = json.loads((self.path / "frame.json").read_text(encoding="utf-8"))
        camera["seeds"] = {name: int(seed) for name, seed in camera.get("seeds", {}).items()}
        for table in ("objects", "materials"):
            for entry in camera.get(table, {}).values():
                entry["seed"] = int(entry["seed"])
        return camera

    def picture(self, eye: str = "left", pictures: str = "color") -> np.ndarray:
        """uint8 (height, width, 3): image(), or for "infrared" that picture in all three channels."""
        if pictures == "color":
            return self.image(eye)
        return np.repeat(self.infrared(eye)[:, :, None], 3, axis=2)

    def valid(self, eye: str = "left", max_disparity: Optional[float] = None,
              disparity: Optional[np.ndarray] = None) -> np.ndarray:
        """bool (height, width): a surface of the scene's inside is there; as in the paper, sky and untextured
        exteriors are masked out. Occluded pixels are valid: their disparity is exact, too. `disparity` is that of
        the eye, where the caller has read it already."""
        if disparity is None:
            disparity = self.disparity(eye)
        valid = disparity > 0
        if self.has("masks", eye):
            valid &= (self.masks(eye) & (SKY | EXTERIOR)) == 0
        if max_disparity is not None:
            valid &= disparity < max_disparity
        return valid


@dataclass(frozen=True)
class Pair:
    """What training code takes from a frame."""

    left: np.ndarray       # uint8 RGB (height, width, 3)
    right: np.ndarray      # uint8 RGB
    disparity: np.ndarray  # float32 (height, width), of the left view
    valid: np.ndarray      # bool (height, width)
    frame: Frame
    maps: Dict[str, Any] = field(default_factory=dict)  # Those that were asked for, of the left view, by name.

    def __repr__(self) -> str:
        height, width = self.disparity.shape
        seen = self.disparity[self.valid]
        pixels = f"disparity {seen.min():.1f} to {seen.max():.1f} px" if seen.size else "no valid pixel"
        maps = f", {', '.join(self.maps)}" if self.maps else ""
        return f"Pair({self.frame.key}, {width}x{height}, {pixels}, {100 * self.valid.mean():.0f} % valid{maps})"


def check_maps(pictures: str, maps: Sequence[str]) -> None:
    """Errors: ValueError for what read_pair does not know."""
    if pictures not in ("color", "infrared"):
        raise ValueError(f"pictures {pictures!r}: allowed are color and infrared")
    unknown = [name for name in maps if name not in MAPS]
    if unknown:
        raise ValueError(f"maps {unknown[0]!r}: allowed are {', '.join(MAPS)}")


def read_pair(frame: Frame, pictures: str = "color", max_disparity: Optional[float] = None, maps: Sequence[str] = ()) -> Pair:
    """The pair of a frame; the arguments are those of ParallaxDataset."""
    # Decoders let go of Python's lock. Threads of its own, because those of a pool don't survive a fork.
    with ThreadPoolExecutor(2) as pool:
        left, right = (pool.submit(frame.picture, eye, pictures) for eye in ("left", "right"))
        disparity = frame.disparity("left")
        valid = frame.valid("left", max_disparity, disparity)
        others = {name: getattr(frame, name)() for name in maps}
        return Pair(left.result(), right.result(), disparity, valid, frame, others)


def _is_variant(directory: Path) -> bool:
    # Frames without an index are a damaged variant, not none: reading it names the index.
    frames = directory / "frames"
    return os.path.isfile(directory / "index.jsonl") or (os.path.isdir(frames) and bool(os.listdir(frames)))


def _variant_dirs(root: Path) -> List[Path]:
    if (root / "index.jsonl").is_file():
        return [root]
    return sorted(path for path in root.glob("*") if not path.name.startswith(".") and _is_variant(path))


def _read_variant(directory: Path) -> Iterable[Frame]:
    with open(directory / "index.jsonl", encoding="utf-8", errors="replace") as lines:
        for number, line in enumerate(lines, 1):
            try:
                entry = json.loads(line)
                yield Frame(directory / entry["path"], directory.name, int(entry["scene"]), int(entry["rig"]),
                            bool(entry.get("passed", all(v["passed"] for v in entry["filters"].values()))), entry)
            except (ValueError, KeyError, TypeError) as error:
                if not line.endswith("\n"):
                    return  # A copy that is still being made.
                raise ValueError(f"{directory / 'index.jsonl'}:{number}: not a line of an index ({error!r})") from None


def _test_scenes(frames: Sequence[Frame]) -> set:
    # By number over all variants: one number is one room.
    scenes = sorted({frame.scene for frame in frames})
    test = {scene for scene in scenes if scene % TEST_EVERY == TEST_EVERY - 1}
    if len(scenes) > 1:
        test = test or {scenes[-1]}
        if len(test) == len(scenes):
            test.discard(scenes[0])
    return test


class ParallaxDataset:
    """Pairs of an archive, of some of its variants, or of several archives, in order.

    roots     folders: an archive or one of its variants
    variants  names to take; None: all but "heldout", which benchmarks are made of (a root that is that
              variant's own folder is taken)
    filtered  leave out pairs that fail a filter (dark, near...): two readings of one dataset
    split     "train", "test" (every 20th scene, at least one; whole scenes) or "all"
    max_disparity  pixels beyond it are not valid (training code takes 192 to 1000)
    pictures  "color", or "infrared": a pair's left and right are the infrared pictures
    maps      what Pair.maps has beside: names of Frame's methods ("normals", "depth", "occluded", "objects", "masks",
              "layers", "flow", "infrared"...), each as the method returns it for the left eye
    transform transform(pair) gives what indexing and iterating return: see parallax_data.augment for training's
    """

    def __init__(self, roots: Union[str, os.PathLike, Sequence], variants: Optional[Sequence[str]] = None,
                 filtered: bool = True, split: str = "all", max_disparity: Optional[float] = None,
                 pictures: str = "color", maps: Sequence[str] = (),
                 transform: Optional[Callable[[Pair], Any]] = None):
        check_maps(pictures, maps)
        if split not in ("all", "train", "test"):
            raise ValueError(f"split {split!r}: allowed are all, train and test")
        self.roots = [Path(root) for root in ([roots] if isinstance(roots, (str, os.PathLike)) else roots)]
        self.variants, self.filtered, self.split = variants, filtered, split
        self.max_disparity = max_disparity
        self.pictures = pictures
        self.maps = tuple(maps)
        self.transform = transform
        self.frames: List[Frame] = []
        self.refresh()

    def refresh(self) -> int:
        """Reads the folders again, as far as they are: `parallax run` writes their index anew as it goes on. The last line of
        an index that is still being copied may be half. Returns how many pairs came since the last time."""
        before = len(self.frames)
        self.frames = self._read()
        return len(self.frames) - before

    def _read(self) -> List[Frame]:
        frames: List[Frame] = []
        found = set()
        for root in self.roots:
            directories = _variant_dirs(root)
            if not directories:
                raise FileNotFoundError(f"{root}: no dataset (no index.jsonl in it or in its folders)")
            for directory in directories:
                found.add(directory.name)
                whole = directory.name != HELDOUT or directory == root
                if whole if self.variants is None else directory.name in self.variants:
                    frames += _read_variant(directory)
        missing = set(self.variants or ()) - found
        if missing:
            raise ValueError(f"no variant {sorted(missing)[0]!r}; there are {', '.join(sorted(found))}")
        if self.filtered:
            frames = [frame for frame in frames if frame.passed]
        if self.split != "all":
            test = _test_scenes(frames)
            frames = [frame for frame in frames if (frame.scene in test) == (self.split == "test")]
        return frames

    def __repr__(self) -> str:
        variants = sorted({frame.variant for frame in self.frames})
        scenes = len({(frame.variant, frame.scene) for frame in self.frames})
        shown = ", ".join(variants[:4]) + (f" and {len(variants) - 4} more" if len(variants) > 4 else "")
        return (f"ParallaxDataset({len(self)} pairs of {scenes} scenes, variants {shown or 'none'}"
                f"{'' if self.split == 'all' else ', split ' + self.split}{'' if self.filtered else ', unfiltered'})")

    def sequences(self) -> List[List[Frame]]:
        """Frames that follow each other, of one scene, way and baseline. A frame that is missing or filtered out ends a
        sequence. Single views are left out."""
        ways: Dict = {}
        for frame in self.frames:
            camera = frame.camera()
            sequence = camera.get("sequence")
            if sequence is None:
                continue
            eye = frame.rig - camera.get("left_rig", frame.rig)
            runs = ways.setdefault((frame.path.parent, eye, sequence["path"]), [])
            if runs and runs[-1][1] == frame.rig:
                runs[-1][0].append(frame)
                runs[-1][1] = sequence["next"]
            else:
                runs.append([[frame], sequence["next"]])
        return [frames for runs in ways.values() for frames, _ in runs]

    def __len__(self) -> int:
        return len(self.frames)

    def __getitem__(self, index: int) -> Any:
        pair = read_pair(self.frames[index], self.pictures, self.max_disparity, self.maps)
        return pair if self.transform is None else self.transform(pair)

    def __iter__(self) -> Iterator:
        return (self[i] for i in range(len(self)))
