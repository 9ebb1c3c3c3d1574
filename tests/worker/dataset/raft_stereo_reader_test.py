"""RAFT-Stereo's own training reader, unmodified, reads an export: it finds all training pairs, and takes
for valid exactly the pixels with truth.

raft_stereo_reader_test.py MAKE_EXPORTS PYTHON: $RAFT_STEREO is the folder of
https://github.com/princeton-vl/RAFT-Stereo. Without it, or without torch in the interpreter that runs this, the
test is skipped (exit status 77). PYTHON is not used. With torchvision, the reader's augmentation runs, too."""

import importlib.util
import os
import subprocess
import sys
import tempfile
import types

SKIPPED = 77


def skip(why):
    print(f"skipped: {why}")
    sys.exit(SKIPPED)


def has(module):
    return importlib.util.find_spec(module) is not None


def import_reader(repository):
    # The reader's files import these, and what it does with an export uses none of them.
    for name, members in (("imageio", ()), ("skimage", ("color", "io"))):
        if not has(name):
            sys.modules[name] = types.ModuleType(name)
            for member in members:
                setattr(sys.modules[name], member, None)
    if not has("torchvision"):
        for name in ("torchvision", "torchvision.transforms"):
            sys.modules[name] = types.ModuleType(name)
        sys.modules["torchvision.transforms"].ColorJitter = None
        sys.modules["torchvision.transforms"].functional = None
        sys.modules["torchvision.transforms"].Compose = None
    sys.path.insert(0, repository)
    from core.stereo_datasets import SceneFlowDatasets
    return SceneFlowDatasets


def main(make_exports, repository):
    import numpy as np
    from parallax_data import ParallaxDataset
    augmentation = has("torchvision")
    reader = import_reader(repository)
    with tempfile.TemporaryDirectory() as root:
        subprocess.run([make_exports, root], check=True)
        frames = {(f.scene, f.rig): f for f in ParallaxDataset(root + "/archive").frames}
        os.makedirs(root + "/datasets")
        os.symlink(root + "/flyingthings", root + "/datasets/FlyingThings3D")
        for dstype in ("frames_cleanpass", "frames_finalpass"):
            data = reader(None, root=root + "/datasets", dstype=dstype)
            assert len(data) == 8, len(data)
            no_truth = 0
            for i in range(len(data)):
                paths, left, right, flow, valid = data[i]
                parts = paths[0].split("/")
                frame = frames[int(parts[-3]), int(parts[-1].split(".")[0])]
                truth = frame.disparity()
                known = (truth > 0) & ((frame.masks() & 3) == 0)
                np.testing.assert_array_equal(left.numpy().transpose(1, 2, 0), frame.image("left"))
                np.testing.assert_array_equal(right.numpy().transpose(1, 2, 0), frame.image("right"))
                np.testing.assert_array_equal(valid.numpy() > 0.5, known)
                np.testing.assert_array_equal(-flow.numpy()[0][known], truth[known])
                no_truth += np.count_nonzero(~known)
            assert no_truth > 0, "the frames have no sky"
        if augmentation:
            settings = {"crop_size": [32, 64], "min_scale": -0.2, "max_scale": 0.4, "do_flip": False, "yjitter": True,
                        "saturation_range": [0, 1.4]}
            data = reader(settings, root=root + "/datasets", dstype="frames_cleanpass")
            for i in range(len(data)):
                _, _, _, flow, valid = data[i]
                disparity = -flow.numpy()[0][valid.numpy() > 0.5]
                assert np.isfinite(disparity).all() and (disparity > 0).all(), "sky is mixed into valid disparities"
    print("RAFT-Stereo reads the export" + (", augmented, too" if augmentation else "; no torchvision: not augmented"))


if __name__ == "__main__":
    if not os.environ.get("RAFT_STEREO"):
        skip("$RAFT_STEREO is not set: the folder of https://github.com/princeton-vl/RAFT-Stereo")
    if not has("torch"):
        skip(f"{sys.executable} has no torch")
    main(sys.argv[1], os.environ["RAFT_STEREO"])
