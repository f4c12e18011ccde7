#!/usr/bin/env python3
"""Adjusts the view of an RViz window to the surface that it shows. The window's fixed frame is a tf frame with this node's name. It lies in
the middle of the surface, whatever the surface's own frame is. Distance, direction, grid and colours follow the size of the surface. Until
a surface comes, the window says what it waits for. RViz itself has neither a view nor a frame that follows a cloud."""
import os
import sys
import tempfile

import numpy as np
import rospy
import tf2_ros
import yaml
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Bool, String
from visualization_msgs.msg import Marker

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
from launched_node import until_shutdown  # noqa: E402
from scan_clouds import read_positions  # noqa: E402

HALF_FIELD = np.tan(0.5 * 0.785)  # of view, upright; RViz's own, as in the configurations
FULL_DISPLACEMENT = 0.25          # of the extent: full scale of the colours, as in ~markers
LETTER, SMALLEST_LETTER, SPACING = 0.035, 0.004, 0.01  # share of the extent, m, m: of text, as in ~markers
ROWS_BELOW, ROWS_ABOVE, COLUMNS = 4, 6, 10  # COLUMNS: half its width, in rows
FILLED = 0.85                     # of the picture; what moves goes beyond where it was
FLAT = 0.1                        # smallest over middle extent of what is looked at face on
# Columns: forward, left and up of a camera, whose optical frame has z forward and y down (REP 103).
OPTICAL = np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0]], float)


class SendFilePath:
    """rviz/SendFilePath, by its layout: Debian has RViz's own messages for Python in a package with all of Qt."""
    _type, _md5sum, _request_class, _response_class = "rviz/SendFilePath", "*", String, Bool


def is_optical(frame):
    return "optical" in frame


def find_main_points(points):
    """Without holes, and without stray points: those farther outside the middle eight tenths than these are wide."""
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) == 0:
        return points
    lower, upper = np.sort(points, axis=0)[[len(points) // 10, len(points) - 1 - len(points) // 10]]
    return points[((points >= 2 * lower - upper) & (points <= 2 * upper - lower)).all(axis=1)]


class View:
    """Of a surface in a frame: where the window's own frame lies, and from where it is looked at."""

    def __init__(self, points, frame):
        self.frame, self.count = frame, len(points)
        main = find_main_points(points)
        self.turn = OPTICAL if is_optical(frame) else np.eye(3)
        turned = main @ self.turn
        low, high = turned.min(axis=0), turned.max(axis=0)
        self.extent = np.linalg.norm(high - low)
        self.origin = self.turn @ (0.5 * (low + high))
        self.foot = 0.5 * (low[2] - high[2])
        self.choose_direction(turned - turned.mean(axis=0))
        self.choose_distance(turned - 0.5 * (low + high))

    def direction(self):
        return np.array([np.cos(self.yaw) * np.cos(self.pitch), np.sin(self.yaw) * np.cos(self.pitch), np.sin(self.pitch)])

    def choose_direction(self, points):
        """From the front left and a little above; what is flat is seen on its face."""
        self.yaw, self.pitch = (3.5, 0.2) if is_optical(self.frame) else (5.24, 0.3)
        lengths, axes = np.linalg.eigh(points.T @ points)
        if not np.sqrt(max(lengths[0], 0.0)) < FLAT * np.sqrt(lengths[1]):
            return
        normal = axes[:, 0] * (1 if axes[:, 0] @ self.direction() > 0 else -1)
        # Not quite along the normal, where every dent looks flat.
        self.pitch = float(np.clip(np.arcsin(np.clip(normal[2], -1, 1)), 0.2, 0.8))
        if np.hypot(normal[0], normal[1]) > 0.5:
            self.yaw = float(np.arctan2(normal[1], normal[0]) + 0.4)

    def choose_distance(self, points):
        """The middle of the picture, as a height above the surface's, and the distance from it, so that surface and text just fit.
        points: from the middle of the surface."""
        toward, right = self.direction(), np.array([-np.sin(self.yaw), np.cos(self.yaw), 0.0])
        up = np.cross(toward, right)
        row = max(LETTER * self.extent, SMALLEST_LETTER) + SPACING
        # RViz turns text to whoever looks, so that its corners lie in the plane of the screen.
        place = np.array([0.0, 0.0, 0.5 * self.extent + ROWS_BELOW * row])
        corners = place + ROWS_ABOVE * row * up + np.outer([-1, 1], COLUMNS * row * right)
        points = np.vstack([points[::max(1, len(points) // 5000)], corners])
        self.height, self.distance = 0.0, float(3.0 * self.extent)
        for _ in range(50):
            away = points - [0.0, 0.0, self.height]
            depth = np.maximum(self.distance - away @ toward, 0.1 * self.distance)
            across, along = away @ right / depth, away @ up / depth
            self.height += float(0.5 * (along.max() + along.min()) * self.distance / np.cos(self.pitch))
            self.distance *= float(max(0.5 * (along.max() - along.min()), np.abs(across).max()) / (FILLED * HALF_FIELD))

    def shows(self, other):
        """Whether a surface is well seen where another was."""
        return self.frame == other.frame and np.linalg.norm(self.origin - other.origin) < 0.5 * self.extent and \
            0.5 < other.extent / self.extent < 2.0

    def fit(self, configuration):
        """The configuration of RViz, a tree, for this view."""
        manager = configuration["Visualization Manager"]
        for display in manager["Displays"]:
            if display["Class"] == "rviz/Grid":
                cell = float(10.0 ** np.floor(np.log10(self.extent / 2)))
                display.update({"Cell Size": cell, "Plane Cell Count": int(2 * np.ceil(self.extent / cell)),
                                "Offset": {"X": 0, "Y": 0, "Z": float(self.foot)}})
            if display["Class"] == "rviz/PointCloud2":
                display["Max Intensity"] = float(FULL_DISPLACEMENT * self.extent)
                # Balls that touch where points lie evenly on the sides of a box.
                display["Size (m)"] = float(1.5 * self.extent / np.sqrt(self.count))
        view = manager["Views"]["Current"]
        view.update({"Distance": self.distance, "Yaw": self.yaw, "Pitch": self.pitch,
                     "Focal Point": {"X": 0, "Y": 0, "Z": self.height},
                     "Near Clip Distance": 0.01 * self.distance})
        return configuration


def make_transform(parent, child, origin=np.zeros(3), turn=np.eye(3)):
    transform = TransformStamped()
    transform.header.stamp, transform.header.frame_id, transform.child_frame_id = rospy.Time.now(), parent, child
    t, r = transform.transform.translation, transform.transform.rotation
    t.x, t.y, t.z = origin
    r.x, r.y, r.z, r.w = (0.5, -0.5, 0.5, 0.5) if turn is OPTICAL else (0, 0, 0, 1)
    return transform


class Window:
    def __init__(self):
        self.name = rospy.get_name().strip("/")
        if rospy.get_param("~view", "") == "hand":
            rospy.logwarn("the view hand is now called interactive_markers; the old name goes with version 0.3")
        self.configuration = rospy.get_param("~configuration")
        self.rviz = rospy.get_param("~rviz")
        self.view = None
        self.folder = tempfile.TemporaryDirectory()
        self.frames = tf2_ros.StaticTransformBroadcaster()
        # RViz says of a frame that tf has never heard of that there is an error.
        self.frames.sendTransform(make_transform(self.name, self.name + "_origin"))
        self.text = rospy.Publisher("~text", Marker, queue_size=1, latch=True)
        self.say("waiting for a cloud on %s" % rospy.resolve_name("cloud_in"))
        rospy.Subscriber("deformed", PointCloud2, until_shutdown(self.take), queue_size=1, buff_size=1 << 26)

    def say(self, sentence):
        marker = Marker(ns="waiting", type=Marker.TEXT_VIEW_FACING, text=sentence)
        marker.action = Marker.ADD if sentence else Marker.DELETE
        marker.header.frame_id = self.name
        marker.pose.orientation.w = 1.0
        marker.pose.position.z = 0.14
        marker.scale.z = 0.03
        marker.color.r = marker.color.g = marker.color.b = marker.color.a = 1.0
        self.text.publish(marker)

    def take(self, message):
        # A surface that moves is followed by the person who looks at it.
        if self.view and (message.header.frame_id, message.width * message.height) == (self.view.frame, self.view.count):
            return
        points = read_positions(message)
        if len(find_main_points(points)) < 3:
            return
        view = View(points, message.header.frame_id)
        if self.view and self.view.shows(view):
            self.view.count = view.count
            return
        self.view = view
        self.frames.sendTransform([make_transform(self.name, self.name + "_origin"),
                                   make_transform(view.frame, self.name, view.origin, view.turn)])
        self.say("")
        self.show(view)

    def show(self, view):
        path = os.path.join(self.folder.name, os.path.basename(self.configuration))
        with open(self.configuration) as stream:
            tree = view.fit(yaml.safe_load(stream))
        tree["Visualization Manager"]["Global Options"]["Fixed Frame"] = self.name
        with open(path, "w") as stream:
            yaml.safe_dump(tree, stream)
        service = rospy.resolve_name(self.rviz) + "/load_config_discarding_changes"
        try:
            rospy.wait_for_service(service, timeout=60.0)
            if not rospy.ServiceProxy(service, SendFilePath)(path).data:
                rospy.logwarn("RViz did not take %s", path)
        except (rospy.ROSException, rospy.ServiceException) as error:
            rospy.logwarn("the window keeps its distance: %s", error)


def main():
    rospy.init_node("view_cloud")
    try:
        window = Window()  # noqa: F841  # what it subscribed to lives as long as it does
    except KeyError as error:
        rospy.logfatal("view_cloud: found no parameter %s; accepted: ~configuration, a file of RViz, and ~rviz, a node", error)
        sys.exit(1)
    rospy.spin()


if __name__ == "__main__":
    main()
