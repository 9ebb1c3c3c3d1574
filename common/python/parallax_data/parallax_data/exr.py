"""OpenEXR maps as numpy arrays.

The package `OpenEXR` (3.3 or later) reads them; where it is missing, an OpenCV that was built with OpenEXR does (Debian's, and
the wheels before 5)."""

import os

import numpy as np

try:
    import OpenEXR
    if not hasattr(OpenEXR, "File"):  # Releases before 3.3 have another interface.
        OpenEXR = None
except ImportError:
    OpenEXR = None


def _read_with_openexr(path):
    """Channels in the order R, G, B (or Y), as they are stored."""
    try:
        with OpenEXR.File(path) as file:
            channels = file.channels()
            for name in ("Y", "RGB"):
                if name in channels:
                    return channels[name].pixels
    except (RuntimeError, ValueError) as error:
        raise ValueError(f"{path}: not an OpenEXR image ({error})") from None
    raise ValueError(f"{path}: channels {', '.join(channels)}, wanted Y or RGB")


def _read_with_opencv(path):
    # OpenCV looks at the variable when it reads its first EXR.
    os.environ.setdefault("OPENCV_IO_ENABLE_OPENEXR", "1")
    try:
        import cv2
        image = cv2.imread(path, cv2.IMREAD_UNCHANGED)
        version = "OpenCV " + cv2.__version__
    except ImportError:
        image, version = None, "no OpenCV"
    except cv2.error:  # OpenCV 4 without the variable.
        image = None
    if image is None:
        raise ValueError(f"{path}: can't be read with {version}; `pip install 'OpenEXR>=3.3'` gives a reader")
    return image if image.ndim == 2 else image[:, :, ::-1]


def _read(path):
    path = os.fspath(path)
    if not os.path.exists(path):
        raise FileNotFoundError(path)
    return _read_with_opencv(path) if OpenEXR is None else _read_with_openexr(path)


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
    return read_rgb(path)


def read_rgb(path):
    """float32 (height, width, 3): channels R, G, B."""
    image = _read(path)
    if image.ndim != 3 or image.shape[2] != 3:
        raise ValueError(f"{path}: shape {image.shape}, wanted three channels")
    return np.ascontiguousarray(image, dtype=np.float32)


def read_flow(path):
    """float32 (height, width, 3): u, v in pixels, and the change of disparity in pixels."""
    image = _read(path)
    if image.ndim != 3 or image.shape[2] != 3 or image.dtype != np.float32:
        raise ValueError(f"{path}: {image.dtype} of shape {image.shape}, wanted three float32 channels")
    return np.ascontiguousarray(image)
