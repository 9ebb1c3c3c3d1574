"""Reads datasets that Parallax made: stereo pairs with exact disparity, for both eyes; and gives studies to a coordinator.

    from parallax_data import ParallaxDataset
    data = ParallaxDataset("out/quickstart")        # pairs that pass the filters
    everything = ParallaxDataset("out/quickstart", filtered=False)
    pair = data[0]
    pair.left, pair.right        # uint8 RGB, (height, width, 3)
    pair.disparity, pair.valid   # float32 pixels, bool
    pair.frame.layers().behind   # disparity of what is behind glass and water, where render.maps has layers
    for frames in data.sequences():                # of scenes with ways of the rig
        flow = frames[0].flow("forward", "left")   # flow.flow, flow.disparity_change, flow.occluded

    from parallax_data import Client
    client = Client()                              # $PARALLAX_COORDINATOR; see parallax_data.client
    client.watch(client.submit("quickstart"))

    from parallax_data import stream
    for pair in stream("endless"):                 # as the farm makes them; see parallax_data.streams
        ...

numpy is needed, the package OpenEXR (or an OpenCV that has OpenEXR), and OpenCV or Pillow for PNG;
`parallax_data.torch_dataset` needs torch, `Client` needs grpcio and protobuf.
"""

from .client import Client
from .dataset import CLEARNESS, Flow, Frame, Layers, ParallaxDataset, Pair
from .errors import ParallaxError
from .exr import read_depth, read_disparity, read_flow, read_normals
from .masks import EXTERIOR, MIRROR, MIXED, SKY, TRANSPARENT, VEILED
from .streams import PairStream, stream

__all__ = [
    "CLEARNESS", "Client", "Flow", "Frame", "Layers", "Pair", "PairStream", "ParallaxDataset", "ParallaxError", "read_depth", "read_disparity",
    "read_flow", "read_normals", "stream", "SKY", "EXTERIOR", "TRANSPARENT", "MIRROR", "MIXED", "VEILED",
]
__version__ = "0.3.0"
