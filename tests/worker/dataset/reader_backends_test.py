"""The Python reader gives the same arrays whichever packages decode for it: OpenEXR or OpenCV for the float maps, OpenCV or
Pillow for PNG.

reader_backends_test.py MAKE_EXPORTS PYTHON: PYTHON is the one of setup_python.sh's environment (OpenEXR, Pillow, OpenCV 5);
without it the test is skipped (exit status 77). The interpreter that runs this has OpenCV 4 with OpenEXR."""

import os
import subprocess
import sys
import tempfile

SKIPPED = 77

# Prints a hash of all maps of a dataset, read without the modules named in argv[2:].
DIGEST = """
import hashlib, sys
for module in sys.argv[2:]:
    sys.modules[module] = None
from parallax_data import ParallaxDataset
digest = hashlib.sha256()
for frame in ParallaxDataset(sys.argv[1], filtered=False).frames:
    for eye in ("left", "right"):
        for read in (frame.image, frame.disparity, frame.depth, frame.normals, frame.occluded, frame.masks, frame.objects,
                     frame.materials, frame.valid):
            array = read(eye)
            assert array.flags.writeable and array.flags.c_contiguous, read
            digest.update(f"{array.dtype} {array.shape}".encode() + array.tobytes())
print(digest.hexdigest())
"""


def digest(python, archive, *hidden):
    environment = {k: v for k, v in os.environ.items() if k != "OPENCV_IO_ENABLE_OPENEXR"}
    done = subprocess.run([python, "-B", "-c", DIGEST, archive, *hidden], env=environment, capture_output=True, text=True)
    return done.stdout.strip() or done.stderr.strip().splitlines()[-1]


def main(make_exports, python):
    with tempfile.TemporaryDirectory() as root:
        subprocess.run([make_exports, root], check=True)
        archive = root + "/archive"
        wanted = digest(sys.executable, archive)
        assert len(wanted) == 64, wanted
        for hidden in ((), ("cv2",), ("PIL",)):
            found = digest(python, archive, *hidden)
            assert found == wanted, f"without {hidden or 'nothing'}: {found}, wanted {wanted}"
        # OpenCV 5 has no OpenEXR: the message says what to install.
        for hidden in (("OpenEXR",), ("OpenEXR", "cv2")):
            found = digest(python, archive, *hidden)
            assert "OpenEXR>=3.3" in found, found
    print("same arrays with OpenCV 4, OpenCV 5 and Pillow")


if __name__ == "__main__":
    if not os.path.exists(sys.argv[2]):
        print(f"skipped: {sys.argv[2]} is missing; tests/worker/dataset/setup_python.sh makes it")
        sys.exit(SKIPPED)
    main(*sys.argv[1:])
