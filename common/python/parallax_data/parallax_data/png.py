"""PNG images as numpy arrays: with OpenCV of any version, else with Pillow."""

import os

import numpy as np

try:
    import cv2
except ImportError:
    cv2 = None  # type: ignore[assignment]
if cv2 is None:
    from PIL import Image


def _missing_or_broken(path):
    return ValueError(f"{path}: not an image") if os.path.exists(path) else FileNotFoundError(path)


def _read_with_opencv(path, flags):
    try:
        data = np.fromfile(path, np.uint8)  # imread knows no names beyond the locale's.
    except OSError:
        raise _missing_or_broken(path) from None
    image = cv2.imdecode(data, flags) if data.size > 0 else None
    if image is None:
        raise _missing_or_broken(path)
    return image


def _read_with_pillow(path, mode=None):
    try:
        with Image.open(path) as image:
            if mode is None and image.mode == "I":  # How older releases hold 16 bits.
                return np.asarray(image).astype(np.uint16)
            return np.array(image if mode in (None, image.mode) else image.convert(mode))
    except OSError:
        raise _missing_or_broken(path) from None


def read_rgb(path):
    """uint8 (height, width, 3)."""
    path = os.fspath(path)
    if cv2 is None:
        return _read_with_pillow(path, "RGB")
    if hasattr(cv2, "IMREAD_COLOR_RGB"):
        return _read_with_opencv(path, cv2.IMREAD_COLOR_RGB)
    image = _read_with_opencv(path, cv2.IMREAD_COLOR)
    return cv2.cvtColor(image, cv2.COLOR_BGR2RGB, dst=image)


def read_index(path):
    """uint8 or uint16 (height, width), as stored."""
    path = os.fspath(path)
    return _read_with_pillow(path) if cv2 is None else _read_with_opencv(path, cv2.IMREAD_UNCHANGED)
