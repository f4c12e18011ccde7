#!/usr/bin/env python3
"""Makes a surface from the first cloud of tracked points and moves it with the later clouds. A point of a cloud is the same place of
the object in every message. A gripping tool holds the surface there; between the points the surface follows its material."""
import os
import sys

import numpy as np
import rospy
from deformable_surface.msg import Tool, ToolArray, ToolWrenchArray
from sensor_msgs.msg import PointCloud2
from sensor_msgs import point_cloud2
from shape_msgs.msg import SolidPrimitive

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
from launched_node import until_shutdown  # noqa: E402
from scan_clouds import make_cloud  # noqa: E402

MAX_TOOLS = 100  # as many as a surface has at a time


def refine(grid, count):
    """A grid (rows x columns x 3) with count parts in each of its cells, bilinearly."""
    rows, columns = grid.shape[:2]
    at = [np.linspace(0, n - 1, count * (n - 1) + 1) for n in (rows, columns)]
    along = np.stack([np.stack([np.interp(at[1], np.arange(columns), row[:, axis]) for axis in range(3)], axis=1)
                      for row in grid])
    return np.stack([np.stack([np.interp(at[0], np.arange(rows), along[:, c, axis]) for axis in range(3)], axis=1)
                     for c in range(along.shape[1])], axis=1)


class Follower:
    def __init__(self):
        self.columns = int(rospy.get_param("~columns"))
        self.parts = int(rospy.get_param("~parts", 10))
        if not (self.columns >= 2 and self.parts >= 1):
            raise ValueError("columns is %d and parts %d; accepted: at least 2 and 1" % (self.columns, self.parts))
        self.radius = None
        self.points = None  # tracked last
        self.cloud = rospy.Publisher("cloud_in", PointCloud2, queue_size=1, latch=True)
        self.tools = rospy.Publisher("tools", ToolArray, queue_size=10)
        rospy.Subscriber("tracked", PointCloud2, until_shutdown(self.take_points), queue_size=10)
        rospy.Subscriber("tool_wrenches", ToolWrenchArray, until_shutdown(self.take_wrenches), queue_size=1)

    def take_points(self, message):
        points = np.array([p[:3] for p in point_cloud2.read_points(message, ("x", "y", "z"))])
        if self.points is None:
            if len(points) % self.columns != 0 or len(points) < 2 * self.columns or not np.isfinite(points).all():
                rospy.logerr_throttle(10.0, "found %d points; accepted: finite ones, in at least two rows of %d" %
                                      (len(points), self.columns))
                return
            grid = points.reshape(-1, self.columns, 3)
            # A tool grips the place of its point and no more.
            self.radius = 0.5 * np.linalg.norm(np.diff(grid, axis=1), axis=2).min() / self.parts
            self.frame = message.header.frame_id
            self.cloud.publish(make_cloud(refine(grid, self.parts).reshape(-1, 3), rospy.Time.now(), self.frame))
        elif len(points) != len(self.points):
            rospy.logwarn_throttle(10.0, "found %d points where there were %d; left out" % (len(points), len(self.points)))
            return
        # A point that was not seen leaves its tool where it is.
        self.points = points if self.points is None else np.where(np.isfinite(points), points, self.points)
        self.send()

    def take_wrenches(self, message):
        if self.points is not None and not message.wrenches:
            self.send()

    def send(self):
        array = ToolArray()
        for i in np.linspace(0, len(self.points) - 1, min(len(self.points), MAX_TOOLS)).astype(int):
            tool = Tool(id="track_%d" % i, mode=Tool.MOVE)
            tool.header.frame_id = self.frame
            tool.primitive = SolidPrimitive(type=SolidPrimitive.SPHERE, dimensions=[1.01 * self.radius])
            tool.pose.position.x, tool.pose.position.y, tool.pose.position.z = self.points[i]
            tool.pose.orientation.w = 1.0
            array.tools.append(tool)
        self.tools.publish(array)


def main():
    rospy.init_node("follow_points")
    try:
        follower = Follower()  # noqa: F841  # what it subscribed to lives as long as it does
    except (KeyError, ValueError) as error:
        rospy.logfatal("follow_points: %s", error)
        sys.exit(1)
    rospy.spin()


if __name__ == "__main__":
    main()
