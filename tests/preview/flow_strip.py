#!/usr/bin/env python3
"""A sequence as a strip of pictures: left image, forward flow by colour, change of disparity, occlusion.

    PYTHONPATH=common/python/parallax_data tests/preview/flow_strip.py OUT/VARIANT strip.png [--sequence 0] [--frames 6]

Flow: hue is direction (red to the right, by the colour wheel of Baker et al.), saturation its length, up to the longest that is
not among the one percent longest. Change of disparity: red nears, blue recedes. Occlusion: red over the image is hidden in the
next frame, blue has no flow.
"""
import argparse

import cv2
import numpy as np
from parallax_data import ParallaxDataset


def flow_colours(flow, valid, longest):
    length = np.linalg.norm(flow, axis=-1)
    angle = np.degrees(np.arctan2(flow[..., 1], flow[..., 0])) % 360
    hsv = np.stack([angle, np.clip(length / longest, 0, 1), np.ones_like(length)], -1).astype(np.float32)
    colours = cv2.cvtColor(hsv, cv2.COLOR_HSV2RGB) * 255
    colours[~valid] = 40
    return colours.astype(np.uint8)


def change_colours(change, valid, largest):
    part = np.clip(change / largest, -1, 1)
    white = 255 * (1 - np.abs(part))
    colours = np.stack([np.where(part > 0, 255, white), white, np.where(part < 0, 255, white)], -1)
    colours[~valid] = 40
    return colours.astype(np.uint8)


def wheel(size):
    y, x = np.mgrid[:size, :size] - (size - 1) / 2
    flow = np.stack([x, y], -1) / (size / 2)
    disc = flow_colours(flow, np.ones(x.shape, bool), 1.0)
    disc[np.linalg.norm(flow, axis=-1) > 1] = 255
    return disc


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n\n')[0])
    parser.add_argument('dataset')
    parser.add_argument('out')
    parser.add_argument('--sequence', type=int, default=0)
    parser.add_argument('--frames', type=int, default=6)
    parser.add_argument('--direction', default='forward')
    parser.add_argument('--eye', default='left')
    options = parser.parse_args()
    sequences = ParallaxDataset(options.dataset, filtered=False).sequences()
    frames = sequences[options.sequence][:options.frames]
    flows = [frame.flow(options.direction, options.eye) for frame in frames]
    lengths = np.concatenate([np.linalg.norm(f.flow, axis=-1)[f.valid] for f in flows])
    longest = max(float(np.percentile(lengths, 99)), 1e-3)
    changes = np.concatenate([np.abs(f.disparity_change[f.valid]) for f in flows])
    largest = max(float(np.percentile(changes, 98)), 1e-3)
    columns = []
    for frame, flow in zip(frames, flows):
        image = frame.image(options.eye)
        shown = image.copy()
        shown[flow.occluded] = shown[flow.occluded] // 2 + np.array([127, 0, 0], np.uint8)
        shown[~flow.valid] = shown[~flow.valid] // 2 + np.array([0, 0, 127], np.uint8)
        columns.append(np.concatenate([image, flow_colours(flow.flow, flow.valid, longest),
                                       change_colours(flow.disparity_change, flow.valid, largest), shown]))
    strip = np.concatenate(columns, axis=1)
    size = image.shape[0] // 3
    strip[image.shape[0]:image.shape[0] + size, :size] = wheel(size)
    cv2.imwrite(options.out, strip[..., ::-1])
    print(f'{options.out}: {len(frames)} frames, flow up to {longest:.1f} px, disparity changes by up to {largest:.2f} px')


main()
