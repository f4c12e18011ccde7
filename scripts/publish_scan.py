#!/usr/bin/env python3
"""Publishes a scan as the surface at rest, once, on a latched topic: upright on z = 0 and with a given height. In demos and launch files it
replaces the driver of a camera."""
import os
import sys

import rospy
from sensor_msgs.msg import PointCloud2

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
from launched_node import run_node  # noqa: E402
from scan_clouds import make_cloud, prepare_scan  # noqa: E402


def main():
    try:
        points = prepare_scan(rospy.get_param("~scan"), rospy.get_param("~up", "z"), float(rospy.get_param("~height", 0.3)))
    except (OSError, ValueError, KeyError) as error:
        return str(error)
    publisher = rospy.Publisher("cloud_in", PointCloud2, queue_size=1, latch=True)
    publisher.publish(make_cloud(points, rospy.Time.now(), rospy.get_param("~frame", "world")))
    rospy.loginfo("published %d points of %s", len(points), os.path.basename(rospy.get_param("~scan")))
    rospy.spin()
    return None


if __name__ == "__main__":
    run_node("publish_scan", main)
