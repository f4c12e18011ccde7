#!/usr/bin/env python3
"""Plays the tracked points of a bag as clouds, at their pace: from sensor_msgs/PointCloud2, or from any message with a list of
geometry_msgs/Point, which trackers of ropes and cloths publish in types of their own. The bag brings those types along."""
import os
import sys

import rosbag
import rospy
from sensor_msgs import point_cloud2
from sensor_msgs.msg import PointCloud2

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
from launched_node import run_node  # noqa: E402


def read_points(message):
    """The tracked points as rows of x y z."""
    if message._type == "sensor_msgs/PointCloud2":
        # A message of a bag has a class of its own.
        cloud = PointCloud2(**{name: getattr(message, name) for name in PointCloud2.__slots__})
        return [point[:3] for point in point_cloud2.read_points(cloud, ("x", "y", "z"))]
    for name, kind in zip(message.__slots__, message._slot_types):
        if kind == "geometry_msgs/Point[]":
            return [(p.x, p.y, p.z) for p in getattr(message, name)]
    raise ValueError("%s holds no points; accepted: sensor_msgs/PointCloud2, messages with a list of geometry_msgs/Point" %
                     message._type)


def main():
    publisher = rospy.Publisher("tracked", PointCloud2, queue_size=10, latch=True)
    rate = float(rospy.get_param("~rate", 1.0))  # times the recorded pace
    try:
        with rosbag.Bag(rospy.get_param("~bag")) as bag:
            topic = rospy.get_param("~topic")
            messages = [(stamp, message.header, read_points(message)) for _, message, stamp in bag.read_messages([topic])]
        if not messages:
            raise ValueError("the bag has nothing on %s" % topic)
        if not rate > 0:
            raise ValueError("rate is %s; accepted: a positive number" % rate)
    except (OSError, ValueError, KeyError, rosbag.ROSBagException) as error:
        return str(error)
    # The first is the surface at rest, which takes a moment to build.
    before = messages[0][0]
    for i, (stamp, header, points) in enumerate(messages):
        rospy.sleep((stamp - before).to_sec() / rate if i != 1 else max(2.0, (stamp - before).to_sec() / rate))
        before = stamp
        cloud = point_cloud2.create_cloud_xyz32(header, points)
        cloud.header.stamp = rospy.Time.now()
        publisher.publish(cloud)
    rospy.loginfo("played %d messages of %s", len(messages), topic)
    rospy.spin()
    return None


if __name__ == "__main__":
    run_node("play_tracked", main)
