#!/usr/bin/env python3
"""Puts a ball on a frame of tf as a tool of a surface: the tip of a robot, a tracked hand. It is sent again whenever the surface
lost it: at the start and after a reset or another cloud. With ~path it moves the frame itself, for trying without a
robot."""
import os
import sys

import numpy as np
import rospy
import tf2_ros
from deformable_surface.msg import Tool, ToolArray, ToolWrenchArray
from geometry_msgs.msg import TransformStamped
from shape_msgs.msg import SolidPrimitive

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
from launched_node import until_shutdown  # noqa: E402

MODES = {"solid": Tool.SOLID, "attract": Tool.ATTRACT, "move": Tool.MOVE, "erase": Tool.ERASE, "cut": Tool.CUT, "heat": Tool.HEAT}
REPEAT = 1.0  # s between two tries
RATE = 50.0   # Hz of the frame that is moved here


class ToolOnFrame:
    def __init__(self):
        self.tool = Tool(id=rospy.get_param("~id", "tip"), follow_frame=True, friction=float(rospy.get_param("~friction", 0.0)),
                         strength=float(rospy.get_param("~strength", 0.0)))
        self.tool.header.frame_id = rospy.get_param("~frame")
        mode = rospy.get_param("~mode", "solid")
        if mode not in MODES:
            raise ValueError("mode is '%s'; accepted: %s" % (mode, ", ".join(MODES)))
        self.tool.mode = MODES[mode]
        self.tool.primitive = SolidPrimitive(type=SolidPrimitive.SPHERE, dimensions=[float(rospy.get_param("~radius", 0.02))])
        self.tool.pose.orientation.w = 1.0
        # Rows of time (s) and position (m) in the frame ~parent, one round of a path without end; none: somebody else moves it.
        self.path = np.array(rospy.get_param("~path", []), float).reshape(-1, 4)
        if len(self.path) == 1 or (np.diff(self.path[:, 0]) <= 0).any():
            raise ValueError("path: accepted: none, or at least two rows [time, x, y, z] whose times grow")
        self.parent = rospy.get_param("~parent", "world")
        self.sent = rospy.Time()
        self.start = None
        self.broadcaster = tf2_ros.TransformBroadcaster()
        self.tools = rospy.Publisher("tools", ToolArray, queue_size=1)
        rospy.Subscriber("tool_wrenches", ToolWrenchArray, until_shutdown(self.take_wrenches), queue_size=1)
        if len(self.path) > 0:
            rospy.Timer(rospy.Duration(1.0 / RATE), until_shutdown(lambda event: self.move_frame()))

    def take_wrenches(self, message):
        now = rospy.Time.now()
        if any(wrench.id == self.tool.id for wrench in message.wrenches) or (now - self.sent).to_sec() < REPEAT:
            return
        self.sent = now
        self.tools.publish(ToolArray(tools=[self.tool]))

    def move_frame(self):
        now = rospy.Time.now()
        if self.start is None:
            self.start = now
        times = self.path[:, 0]
        time = times[0] + (now - self.start).to_sec() % (times[-1] - times[0])
        transform = TransformStamped(child_frame_id=self.tool.header.frame_id)
        transform.header.stamp, transform.header.frame_id = now, self.parent
        for axis in range(3):
            setattr(transform.transform.translation, "xyz"[axis], np.interp(time, times, self.path[:, 1 + axis]))
        transform.transform.rotation.w = 1.0
        self.broadcaster.sendTransform(transform)


def main():
    rospy.init_node("tool_on_frame")
    try:
        tool = ToolOnFrame()  # noqa: F841  # what it subscribed to lives as long as it does
    except (KeyError, TypeError, ValueError) as error:
        rospy.logfatal("tool_on_frame: %s", error)
        sys.exit(1)
    rospy.spin()


if __name__ == "__main__":
    main()
