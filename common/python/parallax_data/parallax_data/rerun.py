"""Shows pairs as point clouds in the rerun viewer (`pip install rerun-sdk`):

    python -m parallax_data.rerun out/quickstart
    python -m parallax_data.rerun out/quickstart --save pairs.rrd      # on a machine without a screen
"""

import argparse

import numpy as np

from .dataset import Frame, ParallaxDataset


def points(frame: Frame):
    """World points of the left view's valid pixels, float32 (n, 3), and their colours, uint8 (n, 3)."""
    camera, depth, valid = frame.camera(), frame.depth(), frame.valid()
    intrinsics = camera["intrinsics"]
    y, x = np.nonzero(valid & (depth > 0))
    z = depth[y, x]
    seen = np.stack([(x + 0.5 - intrinsics["cx"]) / intrinsics["fx"] * z,
                     (y + 0.5 - intrinsics["cy"]) / intrinsics["fy"] * z, z, np.ones_like(z)])
    world_from_left = np.asarray(camera["world_from_left"], np.float64).reshape(-1, 4)
    return (world_from_left[:3] @ seen).T.astype(np.float32), frame.image()[y, x]


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python -m parallax_data.rerun", description=__doc__.splitlines()[0])
    parser.add_argument("roots", nargs="+", metavar="DIR", help="datasets, or variants of them")
    parser.add_argument("--pairs", type=int, default=20, help="how many (default 20)")
    parser.add_argument("--save", metavar="FILE.rrd", help="write a file for the viewer instead of starting it")
    options = parser.parse_args(arguments)
    import rerun
    rerun.init("parallax", spawn=options.save is None)
    if options.save is not None:
        rerun.save(options.save)
    for number, frame in enumerate(ParallaxDataset(options.roots).frames[:options.pairs]):
        rerun.set_time("pair", sequence=number)
        where, colors = points(frame)
        rerun.log("scene", rerun.Points3D(where, colors=colors, radii=0.004))
        rerun.log("left", rerun.Image(frame.image()))
        rerun.log("disparity", rerun.DepthImage(frame.disparity()))


if __name__ == "__main__":
    main()
