"""What training does to a pair before a network sees it, as a transform of ParallaxDataset.

    data = ParallaxDataset("out/quickstart", transform=RaftAugment((320, 720)))
    pair = data[0]      # a Pair of 320 x 720: other colours, another scale, a crop; disparity and valid go along

RaftAugment follows the recipe of RAFT-Stereo for dense ground truth (https://arxiv.org/abs/2109.07547). OpenCV resizes the
pictures where it is there, else Pillow.
"""

import dataclasses
import sys
from typing import Optional, Tuple

import numpy as np

from .dataset import Pair

try:
    import cv2
except ImportError:
    cv2 = None  # type: ignore[assignment]


def _resize(picture: np.ndarray, width: int, height: int) -> np.ndarray:
    if cv2 is not None:
        return cv2.resize(picture, (width, height), interpolation=cv2.INTER_LINEAR)
    from PIL import Image
    return np.asarray(Image.fromarray(picture).resize((width, height), Image.BILINEAR))


def _nearest(values: np.ndarray, width: int, height: int) -> np.ndarray:
    """Of pixel centres, so that a value stays one of the scene's and edges do not blend."""
    rows = np.minimum(((np.arange(height) + 0.5) * values.shape[0] / height).astype(int), values.shape[0] - 1)
    columns = np.minimum(((np.arange(width) + 0.5) * values.shape[1] / width).astype(int), values.shape[1] - 1)
    return values[rows[:, None], columns[None, :]]


class RaftAugment:
    """Colours (each eye its own in a fifth of the pairs), patches erased from the right picture, scale and stretch, a
    vertical shift of the right picture by up to two pixels, and a crop.

    size            (height, width) of what comes out
    scale           log2 of the smallest and the largest scale
    stretch         log2 of the largest stretch of one axis against the other
    y_jitter        largest vertical shift of the right picture, pixels
    seed            pairs are drawn from it and a count of calls; in the workers of a DataLoader from it and their own seeds,
                    which torch gives anew in each epoch

    Maps of the pair go along. Those whose values change with the picture (flow, layers, raw...) are refused: ValueError.
    """

    def __init__(self, size: Tuple[int, int], scale: Tuple[float, float] = (-0.2, 0.4), stretch: float = 0.2,
                 y_jitter: int = 2, asymmetric_p: float = 0.2, erase_p: float = 0.5, seed: Optional[int] = None):
        if len(size) != 2 or min(size) < 1:
            raise ValueError(f"size {size!r}: allowed is (height, width)")
        self.size, self.scale, self.stretch, self.y_jitter = tuple(size), scale, stretch, y_jitter
        self.asymmetric_p, self.erase_p = asymmetric_p, erase_p
        self.seed, self.worker_seed = seed, None
        self.random = np.random.default_rng(seed)

    def _begin_in_worker(self):
        data = sys.modules.get("torch.utils.data")
        info = data.get_worker_info() if data is not None else None
        if info is not None and info.seed != self.worker_seed:
            self.worker_seed = info.seed
            self.random = np.random.default_rng([info.seed, self.seed or 0])

    def __call__(self, pair: Pair) -> Pair:
        for name in pair.maps:
            if name.startswith(("flow", "layers", "raw")):
                raise ValueError(f"maps {name!r}: RaftAugment does not change its values, so it can't come with it")
        self._begin_in_worker()
        left, right = self._colors(pair.left, pair.right)
        if self.random.random() < self.erase_p:
            right = self._erase(right)
        return self._crop(*self._scaled(dataclasses.replace(pair, left=left, right=right)))

    def _colors(self, left, right):
        if self.random.random() < self.asymmetric_p:
            return self._jitter(left, *self._draw()), self._jitter(right, *self._draw())
        drawn = self._draw()
        return self._jitter(left, *drawn), self._jitter(right, *drawn)

    def _draw(self):
        uniform = self.random.uniform
        return uniform(0.6, 1.4), uniform(0.6, 1.4), uniform(0.6, 1.4), uniform(0.8, 1.2)

    @staticmethod
    def _jitter(picture, brightness, contrast, saturation, gamma):
        color = picture.astype(np.float32) * np.float32(brightness)
        color = (color - color.mean()) * np.float32(contrast) + color.mean()
        grey = color @ np.array([0.299, 0.587, 0.114], np.float32)
        color = grey[..., None] + (color - grey[..., None]) * np.float32(saturation)
        color = 255 * np.power(np.clip(color, 0, 255) / 255, np.float32(gamma))
        return np.round(color).astype(np.uint8)

    def _erase(self, picture):
        picture = picture.copy()
        height, width = picture.shape[:2]
        mean = picture.reshape(-1, 3).mean(0)
        for _ in range(self.random.integers(1, 3)):
            y, x = self.random.integers(0, height), self.random.integers(0, width)
            rows, columns = self.random.integers(50, 101, 2)
            picture[y:y + rows, x:x + columns] = mean
        return picture

    def _scaled(self, pair):
        """The pair in its new size, which is at least that of the crop, and the vertical room for the shift."""
        height, width = pair.disparity.shape
        both = 2 ** self.random.uniform(*self.scale)
        one = 2 ** self.random.uniform(-self.stretch, self.stretch)
        room = 2 * self.y_jitter
        scale_x = max(both * one, self.size[1] / width)
        scale_y = max(both / one, (self.size[0] + room) / height)
        new = int(np.ceil(width * scale_x)), int(np.ceil(height * scale_y))
        ratio = np.float32(new[0] / width)
        return dataclasses.replace(
            pair, left=_resize(pair.left, *new), right=_resize(pair.right, *new),
            disparity=_nearest(pair.disparity, *new) * ratio, valid=_nearest(pair.valid, *new),
            maps={name: _nearest(values, *new) for name, values in pair.maps.items()}), room

    def _crop(self, pair, room):
        height, width = pair.disparity.shape
        y = room // 2 + self.random.integers(0, height - self.size[0] - room + 1)
        x = self.random.integers(0, width - self.size[1] + 1)
        shift = self.random.integers(-self.y_jitter, self.y_jitter + 1)
        part = np.s_[y:y + self.size[0], x:x + self.size[1]]
        moved = np.s_[y + shift:y + shift + self.size[0], x:x + self.size[1]]
        cut = np.ascontiguousarray
        return dataclasses.replace(pair, left=cut(pair.left[part]), right=cut(pair.right[moved]),
                                   disparity=cut(pair.disparity[part]), valid=cut(pair.valid[part]),
                                   maps={name: cut(values[part]) for name, values in pair.maps.items()})
