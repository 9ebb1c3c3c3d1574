"""Makes the networks of exchange_network_test.cc: make_networks.py FOLDER.

Needs the package onnx of PyPI; its files are kept here, so that tests need not.
"""

import sys

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

# Weights of a convolution over six channels: mean of left minus mean of right.
DIFFERENCE = np.array([1, 1, 1, -1, -1, -1], np.float32).reshape(1, 6, 1, 1) / 3


def values(shapes):
    """Returns inputs or outputs of a graph."""
    return [helper.make_tensor_value_info(name, TensorProto.FLOAT, shape)
            for name, shape in shapes.items()]


def convolution(source, weights, target):
    """Returns a convolution of one pixel."""
    return helper.make_node("Conv", [source, weights], [target], kernel_shape=[1, 1],
                            name=f"Conv_{target}")


def save(name, nodes, inputs, outputs, weights):
    """Writes NAME.onnx; operator set 16 has GridSample."""
    tensors = [numpy_helper.from_array(value, key) for key, value in weights.items()]
    graph = helper.make_graph(nodes, name, values(inputs), values(outputs), tensors)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 16)], ir_version=6)
    onnx.save(model, f"{sys.argv[1]}/{name}.onnx")


def main():
    pair = helper.make_node("Concat", ["left", "right"], ["pair"], axis=1, name="Concat_0")
    open_sizes = [1, 3, "height", "width"]
    eyes = {"left": open_sizes, "right": open_sizes}
    one = [1, 1, "height", "width"]
    # Outputs: half the difference of the pictures, then the difference.
    save("two_inputs",
         [pair, convolution("pair", "half", "coarse"), convolution("pair", "whole", "fine")],
         eyes, {"coarse": one, "fine": one}, {"half": DIFFERENCE / 2, "whole": DIFFERENCE})
    # Pictures of one size; a flow, which is the negative disparity.
    save("stacked", [convolution("pair", "weights", "flow")], {"pair": [1, 6, 32, 64]},
         {"flow": [1, 2, 32, 64]}, {"weights": np.concatenate([-DIFFERENCE, DIFFERENCE * 0])})
    # An operation that OpenCV 4.6 does not have.
    save("unknown",
         [pair, helper.make_node("GridSample", ["pair", "pair"], ["fine"], name="GridSample_1")],
         eyes, {"fine": open_sizes}, {})
    # The right picture first, as its name says.
    save("right_first",
         [pair, convolution("pair", "whole", "fine")],
         {"right": open_sizes, "left": open_sizes}, {"fine": one}, {"whole": DIFFERENCE})
    # Softmax along the last axis, as it is from operator set 13 on: 1 / width, times 320.
    save("last_axis",
         [helper.make_node("Sub", ["left", "right"], ["difference"], name="Sub_0"),
          helper.make_node("Softmax", ["difference"], ["shares"], name="Softmax_0"),
          convolution("shares", "sum", "fine")],
         eyes, {"fine": one}, {"sum": np.full((1, 3, 1, 1), 320 / 3, np.float32)})
    # Inputs that are no pictures.
    save("three_inputs", [convolution("left", "weights", "fine")],
         {**eyes, "mask": open_sizes}, {"fine": one}, {"weights": DIFFERENCE[:, :3]})


main()
