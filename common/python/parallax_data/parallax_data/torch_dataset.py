"""The same as torch Datasets in RAFT-Stereo's convention."""

import numpy as np
import torch

from .dataset import ParallaxDataset
from .local_farm import LocalFarm
from .streams import PairStream


class _Convention:
    """Makes items of pairs: (paths, left, right, flow, valid) as RAFT-Stereo's datasets give them: images float32 (3, height,
    width) in [0, 255]; flow float32 (1, height, width), from a left pixel to its right one: -disparity; valid float32
    (height, width).

    sign     of flow: -1, -disparity, as RAFT-Stereo and DLNR train on; 1, disparity, as IGEV-Stereo and WAFT-Stereo
    augment  augment(left, right, flow) gets numpy arrays, uint8 RGB and float32 (height, width, 2), the flow with that
             sign, and returns such
    """

    def __init__(self, augment, sign):
        if sign not in (-1, 1):
            raise ValueError(f"sign {sign!r}: allowed are -1 and 1")
        self.augment = augment
        self.sign = np.float32(sign)

    def __call__(self, pair):
        left, right, flow, valid = pair.left, pair.right, self.sign * pair.disparity, pair.valid
        if self.augment is not None:
            # Invalid pixels travel as an infinite disparity: what is mixed with it is not finite either.
            marked = np.where(valid, flow, self.sign * np.float32(np.inf))
            left, right, both = self.augment(left, right, np.stack([marked, np.zeros_like(marked)], axis=-1))
            disparity = self.sign * both[..., 0]
            valid = np.isfinite(disparity) & (disparity > 0)
            flow = np.where(valid, both[..., 0], np.float32(0))
        to_tensor = lambda image: torch.from_numpy(np.ascontiguousarray(image)).permute(2, 0, 1).float()
        path = str(pair.frame.path)
        return ([path + "/left.png", path + "/right.png", path + "/disparity_left.exr"], to_tensor(left),
                to_tensor(right), torch.from_numpy(np.ascontiguousarray(flow))[None].float(),
                torch.from_numpy(np.ascontiguousarray(valid)).float())


class TorchStereoDataset(torch.utils.data.Dataset):
    """Items as _Convention makes them, of ParallaxDataset(*args, **options)."""

    def __init__(self, *args, augment=None, sign=-1, **options):
        self.item_of = _Convention(augment, sign)
        self.data = ParallaxDataset(*args, **options)

    def __len__(self):
        return len(self.data)

    def __getitem__(self, index):
        return self.item_of(self.data[index])


class TorchPairStream(torch.utils.data.IterableDataset):
    """Items as _Convention makes them, of PairStream(*args, **options). Each worker of a DataLoader is a rank of its own: a
    loader with W workers on each of R ranks splits the stream in R x W parts. As a loader fetches ahead, `lag` should be what
    a worker has ahead: prefetch_factor x batch_size; then nothing is lost when the training is killed, and so many pairs come
    again. With `workers` this process has a LocalFarm, which ends with close(), this object or the process."""

    def __init__(self, name, address=None, *args, augment=None, sign=-1, rank=0, ranks=1, lag=0, workers=0, out=None, **options):
        self.item_of = _Convention(augment, sign)
        self.farm = LocalFarm(name, workers, out) if workers > 0 else None
        if self.farm is not None:
            name, address = self.farm.name, self.farm.address
        self.args, self.options = (name, address, *args), options
        self.rank, self.ranks, self.lag = rank, ranks, lag
        self.stream = None  # The PairStream of this process, once it is iterated.

    def close(self):
        """Ends the farm on this machine, if there is one."""
        if self.farm is not None:
            self.farm.close()

    def __getstate__(self):
        return {**self.__dict__, "farm": None}  # Workers of a loader only take pairs of it.

    def __iter__(self):
        info = torch.utils.data.get_worker_info()
        number, workers = (info.id, info.num_workers) if info else (0, 1)
        self.stream = PairStream(*self.args, **self.options, rank=self.rank * workers + number, ranks=self.ranks * workers,
                                 lag=self.lag)
        return map(self.item_of, iter(self.stream))
