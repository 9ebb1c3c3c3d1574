"""OpenEXR maps through OpenCV, which reads them only when it is asked to before it is imported."""

import os
import sys

_FLAG = "OPENCV_IO_ENABLE_OPENEXR"
if "cv2" in sys.modules and os.environ.get(_FLAG) != "1":
    # OpenCV looks at the variable at its first EXR, so it is not too late unless one was read.
    os.environ[_FLAG] = "1"
os.environ.setdefault(_FLAG, "1")

import cv2  # noqa: E402
import numpy as np  # noqa: E402


def _read(path):
    path = os.fspath(path)
    if not os.path.exists(path):
        raise FileNotFoundError(path)
    image = cv2.imread(path, cv2.IMREAD_UNCHANGED)
    if image is None:
        raise ValueError(
            f"{path}: OpenCV {cv2.__version__} can't read it. It needs an OpenCV before 5 with OpenEXR, and "
            f"{_FLAG}=1 in the environment before the first EXR is read")
    return image


def read_depth(path):
    """float32 (height, width), metres along the optical axis; 0 = no surface."""
    image = _read(path)
    if image.ndim != 2 or image.dtype != np.float32:
        raise ValueError(f"{path}: {image.dtype} of shape {image.shape}, wanted one float32 channel")
    return image


def read_disparity(path):
    """float32 (height, width), pixels, positive in both views; 0 = no surface."""
    return read_depth(path)


def read_normals(path):
    """float32 (height, width, 3): x right, y down, z forward in the camera's frame; 0 = no surface."""
    image = _read(path)
    if image.ndim != 3 or image.shape[2] != 3:
        raise ValueError(f"{path}: shape {image.shape}, wanted three channels")
    return np.ascontiguousarray(image[:, :, ::-1], dtype=np.float32)
