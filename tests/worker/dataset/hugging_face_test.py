"""Opens a WebDataset export with Hugging Face `datasets` and compares every value with the archive it came from.

hugging_face_test.py MAKE_EXPORTS PYTHON: PYTHON is the one of setup_python.sh's environment; without it the test is
skipped (exit status 77)."""

import io
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

SKIPPED = 77


def rows(table):
    return [{"index": int(index), **entry} for index, entry in table.items()]


def compare(sample, root, archive="archive"):
    import numpy as np
    scene, rig = sample["__key__"].split("_")
    folder = root / archive / "a" / "frames" / scene / rig
    frame = json.loads((folder / "frame.json").read_text())
    seen = sample["json"]
    assert seen["seeds"]["scene"] == frame["seeds"]["scene"], (seen["seeds"], frame["seeds"])
    for table in ("objects", "materials"):
        assert seen[table] == rows(frame[table]), (table, seen[table])
    for pixels in ("object_pixels", "material_pixels"):
        assert {row["class"]: row["pixels"] for row in seen[pixels]} == frame[pixels], pixels
    assert seen["intrinsics"] == frame["intrinsics"] and seen["baseline_m"] == frame["baseline_m"]
    if "moving" in frame:
        moving = [{"index": int(index), "pose": pose} for index, pose in frame["moving"].items()]
        assert seen["moving"] == moving, (seen["moving"], moving)
    from PIL import Image
    for eye in ("left", "right"):
        with Image.open(folder / f"{eye}.png") as image:
            np.testing.assert_array_equal(np.asarray(sample[f"{eye}.png"]), np.asarray(image))
    assert np.asarray(sample["disp.npy"]).shape == (frame["intrinsics"]["height"], frame["intrinsics"]["width"])
    return int(scene), int(rig)


def check(split, expected, root, archive="archive"):
    found = [compare(sample, root, archive) for sample in split]
    assert found == expected, (found, expected)


def main():
    import datasets
    with tempfile.TemporaryDirectory() as name:
        root = Path(name)
        subprocess.run([sys.argv[1], name], check=True)
        export = root / "webdataset"
        # Scene 4 is the one for tests; its second pair is too dark.
        expected = {"train": [(scene, rig) for scene in range(4) for rig in range(2)], "test": [(4, 0)]}
        by_name = datasets.load_dataset("webdataset", cache_dir=str(root / "cache_a"), data_files={
            split: str(export / f"{split}-*.tar") for split in expected})
        by_card = datasets.load_dataset(str(export), cache_dir=str(root / "cache_b"))
        for dataset in (by_name, by_card):
            assert set(dataset) == set(expected), dataset
            for split, keys in expected.items():
                check(dataset[split], keys, root)
        streamed = datasets.load_dataset("webdataset", streaming=True, split="test",
                                         data_files={"test": str(export / "test-*.tar")})
        check(streamed, expected["test"], root)
        sequences = datasets.load_dataset("webdataset", cache_dir=str(root / "cache_c"), split="train", data_files={
            "train": str(root / "archive_sequences_webdataset" / "train-*.tar")})
        assert all(len(sample["json"]["moving"]) == 2 for sample in sequences)
        check(sequences, [(0, rig) for rig in range(4)], root, "archive_sequences")
        # Scenes with and without motion in one dataset.
        still, moving = "webdataset", "archive_sequences_webdataset"
        for order in ((still, moving), (moving, still)):
            mixed = datasets.load_dataset("webdataset", cache_dir=str(root / f"cache_{order[0]}"), split="train",
                                          data_files={"train": [str(root / o / "train-000000.tar") for o in order]})
            assert len(mixed) == 8, mixed
            counts = [len(sample["json"].get("moving") or []) for sample in mixed]
            assert order[0] == still or counts == [2] * 4 + [0] * 4, counts
    print(f"datasets {datasets.__version__} opened the export with its splits")


if __name__ == "__main__":
    python = sys.argv[2]
    if not os.path.exists(python):
        print(f"skipped: {python} is missing; tests/worker/dataset/setup_python.sh makes it")
        sys.exit(SKIPPED)
    if os.path.realpath(sys.prefix) != os.path.realpath(Path(python).parents[1]):
        # Offline: a look at the hub would only cost time.
        os.execve(python, [python, "-B", *sys.argv], {**os.environ, "HF_HUB_OFFLINE": "1"})
    main()
