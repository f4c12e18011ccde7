#!/usr/bin/env python3
"""Converts scans to clouds for the node, and clouds that it publishes to arrays. Every client in Python uses it."""
import os
import sys

import numpy as np
from sensor_msgs.msg import PointCloud2, PointField

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import point_files  # noqa: E402
from look_at_scan import UPRIGHT  # noqa: E402

def prepare_scan(path, up, height):
    """The scan's points standing upright on z = 0, centred on the z axis, `height` metres tall."""
    if up not in UPRIGHT:
        raise ValueError("up is '%s'; accepted: %s" % (up, ", ".join(sorted(UPRIGHT))))
    if not height > 0:
        raise ValueError("height is %s; accepted: a positive number of metres" % height)
    points = point_files.read_points(path) @ np.array(UPRIGHT[up], float).T
    low, high = points.min(axis=0), points.max(axis=0)
    if not high[2] > low[2]:
        raise ValueError("%s: all points have one %s coordinate; give the axis along which the scan extends as up" % (path, up))
    middle = 0.5 * (low + high)
    return (points - [middle[0], middle[1], low[2]]) * (height / (high[2] - low[2]))


def make_cloud(points, stamp, frame, width=None):
    """width: of the grid that the points are in, row after row; NaN are its holes."""
    width = width or len(points)
    message = PointCloud2(height=len(points) // width, width=width, is_dense=bool(np.isfinite(points).all()), point_step=12,
                          row_step=12 * width)
    message.header.stamp, message.header.frame_id = stamp, frame
    message.fields = [PointField(name=name, offset=4 * i, datatype=PointField.FLOAT32, count=1) for i, name in enumerate("xyz")]
    message.data = points.astype("<f4").tobytes()
    return message


FORMATS = {PointField.UINT8: "u1", PointField.UINT32: "<u4", PointField.FLOAT32: "<f4", PointField.FLOAT64: "<f8"}


def read_field(message, name):
    """One field of every point of a cloud without padded rows, which is how the node publishes."""
    field = next(field for field in message.fields if field.name == name)
    record = np.dtype({"names": [name], "formats": [FORMATS[field.datatype]], "offsets": [field.offset],
                       "itemsize": message.point_step})
    return np.frombuffer(message.data, record)[name].astype(float)


def read_positions(message):
    return np.stack([read_field(message, axis) for axis in "xyz"], axis=1)
