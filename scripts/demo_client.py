#!/usr/bin/env python3
"""What happens in the demo: publishes a scan as the surface at rest, pulls the surface by its highest point with a force that
grows and turns, lets go, and writes a summary and a picture. It talks to the node as any other client would, over topics only."""
import os
import sys
import threading

import numpy as np
import rospy
from sensor_msgs.msg import PointCloud2, PointField

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import draw_cloud  # noqa: E402
import point_files  # noqa: E402
from deformable_surface.msg import PointForce, Statistics  # noqa: E402

# To z up, by a rotation each: a mirrored scan would not be the thing that was scanned.
UPRIGHT = {"x": [[0, 0, -1], [0, 1, 0], [1, 0, 0]], "y": [[1, 0, 0], [0, 0, -1], [0, 1, 0]], "z": np.eye(3)}

GROW_UNTIL, TURN_UNTIL = 0.25, 0.6  # shares of the duration: the force grows, then turns, then is gone
LEAN = 0.8                          # the force's horizontal part over its whole, so that the surface sways as the force turns


def prepare_scan(path, up, height):
    """The scan's points standing upright on z = 0, centred on the z axis, `height` metres tall."""
    if up not in UPRIGHT:
        raise ValueError("up is '%s'; accepted: x, y, z" % up)
    if not height > 0:
        raise ValueError("height is %s; accepted: a positive number of metres" % height)
    points = point_files.read_points(path) @ np.array(UPRIGHT[up], float).T
    low, high = points.min(axis=0), points.max(axis=0)
    if not high[2] > low[2]:
        raise ValueError("%s: all points have one %s coordinate; give the axis along which the scan extends as up" % (path, up))
    middle = 0.5 * (low + high)
    return (points - [middle[0], middle[1], low[2]]) * (height / (high[2] - low[2]))


def make_cloud(points, stamp, frame):
    message = PointCloud2(height=1, width=len(points), is_dense=True, point_step=12, row_step=12 * len(points))
    message.header.stamp, message.header.frame_id = stamp, frame
    message.fields = [PointField(name=name, offset=4 * i, datatype=PointField.FLOAT32, count=1) for i, name in enumerate("xyz")]
    message.data = points.astype("<f4").tobytes()
    return message


def read_field(message, name):
    """One float32 field of every point of a cloud without padded rows, which is how the node publishes."""
    offset = next(field.offset for field in message.fields if field.name == name)
    record = np.dtype({"names": [name], "formats": ["<f4"], "offsets": [offset], "itemsize": message.point_step})
    return np.frombuffer(message.data, record)[name].astype(float)


def read_positions(message):
    return np.stack([read_field(message, axis) for axis in "xyz"], axis=1)


def compute_pull(share, strength):
    """The force (N) at this share of the duration."""
    if share >= TURN_UNTIL:
        return np.zeros(3)
    grown = min(1.0, share / GROW_UNTIL)
    angle = 2 * np.pi * max(0.0, (share - GROW_UNTIL) / (TURN_UNTIL - GROW_UNTIL))
    return strength * grown * np.array([LEAN * np.cos(angle), LEAN * np.sin(angle), np.sqrt(1 - LEAN * LEAN)])


class Demo:
    def __init__(self):
        self.path = rospy.get_param("~scan")
        if not self.path:
            raise ValueError("no scan is given; give one: scan:=FILE")
        self.output = rospy.get_param("~output")
        self.strength = float(rospy.get_param("~force", 2.0))
        self.radius = float(rospy.get_param("~radius", 0.02))
        self.duration = float(rospy.get_param("~duration", 8.0))
        self.frame = rospy.get_param("~frame", "world")
        self.azimuth = float(rospy.get_param("~azimuth", -60.0))
        self.height = float(rospy.get_param("~height", 0.3))
        self.points = prepare_scan(self.path, rospy.get_param("~up", "z"), self.height)
        self.handle = int(self.points[:, 2].argmax())

        self.lock = threading.Lock()  # the two subscribers call from threads of their own
        self.start = None             # the stamp of the surface at rest
        self.rest = None
        self.best = None              # the most deformed surface so far: positions, displacements, time
        self.last = None              # the newest statistics
        self.speeds = []
        self.pulling = True
        self.ended = threading.Event()

        self.force = rospy.Publisher("force", PointForce, queue_size=10)
        self.cloud = rospy.Publisher("cloud_in", PointCloud2, queue_size=1, latch=True)
        rospy.Subscriber("statistics", Statistics, self.take_statistics, queue_size=100)
        rospy.Subscriber("deformed", PointCloud2, self.take_surface, queue_size=1, buff_size=1 << 26)

    def run(self):
        """Returns the sentence that says why the demo failed, or nothing."""
        rospy.loginfo("publishing %d points of %s", len(self.points), os.path.basename(self.path))
        self.cloud.publish(make_cloud(self.points, rospy.Time.now(), self.frame))
        patience = rospy.get_param("~patience", 120.0)  # s of wall time; a slow machine may fall behind real time
        if not self.ended.wait(patience) and not rospy.is_shutdown():
            if self.rest is None:
                return "no deformed surface arrived within %g s" % patience
            rospy.logwarn("the demo did not reach %g simulated seconds within %g s; ending it here", self.duration, patience)
        with self.lock:
            if self.best is None or self.last is None:
                return "the run ended before there was a deformed surface with statistics"
            self.write_results()
        return None

    def take_statistics(self, message):
        with self.lock:
            self.last = message
            self.speeds.append(message.real_time_factor)

    def take_surface(self, message):
        with self.lock:
            if self.ended.is_set():
                return
            positions, displacement = read_positions(message), read_field(message, "displacement")
            if self.rest is None:
                self.start, self.rest = message.header.stamp, (positions, displacement)
            time = (message.header.stamp - self.start).to_sec()
            if self.best is None or np.nanmax(displacement) > np.nanmax(self.best[1]):
                self.best = positions, displacement, time
            self.pull(positions[self.handle], time)
            if time >= self.duration:
                self.ended.set()

    def pull(self, point, time):
        """Sends the force anew at the place to which the surface has moved. A zero force ends it and is sent once."""
        force = compute_pull(time / self.duration, self.strength)
        if not self.pulling:
            return
        self.pulling = time < TURN_UNTIL * self.duration
        message = PointForce(id="pull", radius=self.radius)
        message.header.frame_id = self.frame  # the stamp stays zero: from now on
        message.point.x, message.point.y, message.point.z = point
        message.force.x, message.force.y, message.force.z = force
        self.force.publish(message)

    def write_results(self):
        positions, displacement, time = self.best
        largest = np.nanmax(displacement)
        picture = os.path.join(self.output, "surface.png")
        caption = "%s: %d points, %d of them simulated, pulled by the highest point with %g N" % (
            os.path.basename(self.path), self.last.points, self.last.simulation_points, self.strength)
        titles = ["at rest", "after %.1f s" % time]
        draw_cloud.draw(picture, [self.rest, (positions, displacement)], titles, caption, self.azimuth)
        lines = [
            ("scan", "%s, %.2f m tall" % (os.path.basename(self.path), self.height)),
            ("points", "%d" % self.last.points),
            ("simulation points", "%d" % self.last.simulation_points),
            ("steps", "%d (%.2f s simulated)" % (self.last.step, self.last.simulation_time)),
            ("real-time factor", "%.2f (median)" % np.median(self.speeds)),
            ("largest displacement", "%.1f mm (at %.2f s, under at most %g N)" % (1000 * largest, time, self.strength)),
            ("picture", picture)]
        with open(os.path.join(self.output, "summary.txt"), "w") as stream:
            stream.writelines("%-22s%s\n" % line for line in lines)
        rospy.loginfo("wrote %s and summary.txt; the demo is over, and the launch ends with it", picture)


def main():
    rospy.init_node("demo_client")
    try:
        problem = Demo().run()
    except (OSError, ValueError, KeyError) as error:
        problem = str(error)
    if problem:
        rospy.logfatal("demo: %s", problem)
        sys.exit(1)


if __name__ == "__main__":
    main()
