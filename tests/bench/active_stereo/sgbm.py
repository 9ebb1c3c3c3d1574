"""What a projector's dots do for classical matching: OpenCV's SGBM on infrared pairs, with and without projector.

    python3 tests/bench/active_stereo/sgbm.py OUT [--passive off] [--active d435] [--csv FILE] [--pictures DIR]

OUT is the dataset of tests/bench/active_stereo/study.yaml: two variants that differ in lighting.projector alone, so that
their frames show the same rooms. Prints the share of pixels that are off by more than 2 px (bad-2), of those that both eyes
see: of all, and of those where the room itself shows no texture (local contrast of the passive picture below 1.5 levels).
A pixel without an answer counts as off."""
import argparse
import csv
import pathlib
import sys

import cv2
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parents[3] / "common/python/parallax_data"))
from parallax_data import ParallaxDataset  # noqa: E402

BLOCK = 5
BARE = 1.5       # Levels of local standard deviation.
WINDOW = 11      # Pixels, of that contrast.


def disparity_of(left, right, most):
    """float32 pixels; NaN: no answer. Settings of OpenCV's stereo_match sample, mode HH."""
    count = int(np.ceil(most / 16 + 1) * 16)
    matcher = cv2.StereoSGBM_create(0, count, BLOCK, P1=8 * BLOCK**2, P2=32 * BLOCK**2, disp12MaxDiff=1,
                                    preFilterCap=31, uniquenessRatio=10, speckleWindowSize=100, speckleRange=2,
                                    mode=cv2.STEREO_SGBM_MODE_HH)
    pad = ((0, 0), (count, 0))  # Without it, the left border has no answers.
    found = matcher.compute(np.pad(left, pad), np.pad(right, pad))[:, count:].astype(np.float32) / 16
    return np.where(found < 0, np.float32("nan"), found)


def local_contrast(image):
    image = image.astype(np.float32)
    size = (WINDOW, WINDOW)
    mean = cv2.blur(image, size)
    return np.sqrt(np.maximum(cv2.blur(image * image, size) - mean * mean, 0))


def colours(disparity, most):
    scaled = np.nan_to_num(np.clip(disparity / most, 0, 1) * 255).astype(np.uint8)
    picture = cv2.applyColorMap(scaled, cv2.COLORMAP_TURBO)
    picture[~np.isfinite(disparity)] = 0
    return picture


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out")
    parser.add_argument("--passive", default="off")
    parser.add_argument("--active", default="d435")
    parser.add_argument("--csv")
    parser.add_argument("--pictures")
    options = parser.parse_args()
    frames = {name: {(f.scene, f.rig): f for f in ParallaxDataset(options.out, variants=[name], filtered=False).frames}
              for name in (options.passive, options.active)}
    rows = []
    for key in sorted(set(frames[options.passive]) & set(frames[options.active])):
        passive, active = (frames[name][key] for name in (options.passive, options.active))
        truth = passive.disparity()
        assert np.array_equal(truth, active.disparity()), "the variants show different rooms"
        seen = passive.valid() & ~passive.occluded()
        bare = seen & (local_contrast(passive.infrared()) < BARE)
        row = {"scene": key[0], "rig": key[1], "pixels": int(seen.sum()), "bare": int(bare.sum())}
        shown = [colours(truth, truth.max())]
        for name, frame in (("passive", passive), ("active", active)):
            found = disparity_of(frame.infrared("left"), frame.infrared("right"), truth.max())
            off = ~(np.abs(found - truth) <= 2)
            row[f"{name}_all"] = float(off[seen].mean())
            row[f"{name}_bare"] = float(off[bare].mean()) if bare.any() else float("nan")
            shown += [cv2.cvtColor(frame.infrared("left"), cv2.COLOR_GRAY2BGR), colours(found, truth.max())]
        rows.append(row)
        if options.pictures:
            folder = pathlib.Path(options.pictures)
            folder.mkdir(parents=True, exist_ok=True)
            cv2.imwrite(str(folder / f"{key[0]:06d}_{key[1]:03d}.png"), np.hstack([*shown[1:], shown[0]]))
    total = {"pixels": sum(r["pixels"] for r in rows), "bare": sum(r["bare"] for r in rows)}
    print(f"{len(rows)} pairs, {total['pixels']} pixels, {total['bare']} of them bare")
    for name in ("passive", "active"):
        whole = sum(r[f"{name}_all"] * r["pixels"] for r in rows) / total["pixels"]
        bare = sum(r[f"{name}_bare"] * r["bare"] for r in rows if r["bare"]) / max(1, total["bare"])
        print(f"{name:8s} bad-2 {100 * whole:5.1f} % of all, {100 * bare:5.1f} % of the bare ones")
    if options.csv:
        with open(options.csv, "w", newline="") as file:
            writer = csv.DictWriter(file, rows[0].keys())
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()
