"""The same as a torch Dataset in RAFT-Stereo's convention."""

import numpy as np
import torch

from .dataset import ParallaxDataset


class TorchStereoDataset(torch.utils.data.Dataset):
    """Items are (paths, left, right, flow, valid) as RAFT-Stereo's datasets give them: images float32 (3, height,
    width) in [0, 255]; flow float32 (1, height, width), from a left pixel to its right one: -disparity; valid float32
    (height, width).

    sign     of flow: -1, -disparity, as RAFT-Stereo and DLNR train on; 1, disparity, as IGEV-Stereo and WAFT-Stereo
    augment  augment(left, right, flow) gets numpy arrays, uint8 RGB and float32 (height, width, 2), the flow with that
             sign, and returns such
    """

    def __init__(self, *args, augment=None, sign=-1, **options):
        if sign not in (-1, 1):
            raise ValueError(f"sign {sign!r}: allowed are -1 and 1")
        self.data = ParallaxDataset(*args, **options)
        self.augment = augment
        self.sign = np.float32(sign)

    def __len__(self):
        return len(self.data)

    def __getitem__(self, index):
        pair = self.data[index]
        left, right, flow, valid = pair.left, pair.right, self.sign * pair.disparity, pair.valid
        if self.augment is not None:
            # Invalid pixels travel as a disparity that no limit lets pass.
            marked = np.where(valid, flow, self.sign * np.float32(1e6))
            left, right, both = self.augment(left, right, np.stack([marked, np.zeros_like(marked)], axis=-1))
            disparity = self.sign * both[..., 0]
            valid = (disparity > 0) & (disparity < 1e5)
            flow = np.where(valid, both[..., 0], np.float32(0))
        to_tensor = lambda image: torch.from_numpy(np.ascontiguousarray(image)).permute(2, 0, 1).float()
        path = str(pair.frame.path)
        return ([path + "/left.png", path + "/right.png", path + "/disparity_left.exr"], to_tensor(left),
                to_tensor(right), torch.from_numpy(np.ascontiguousarray(flow))[None].float(),
                torch.from_numpy(np.ascontiguousarray(valid)).float())
