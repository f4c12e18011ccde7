#!/usr/bin/env python3
"""What happens in the demo: publishes a scan as the surface at rest, pulls the surface by its highest point with a force that
grows and turns, lets go, ends the recording, and writes a summary and a picture. It talks to the node as any other client would,
over topics only."""
import os
import sys
import threading
import time

import numpy as np
import rospy
from sensor_msgs.msg import PointCloud2

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import draw_cloud  # noqa: E402
from launched_node import end_launch, end_neighbor, run_node  # noqa: E402
from scan_clouds import make_cloud, prepare_scan, read_field, read_positions  # noqa: E402
from deformable_surface.msg import PointForce, Statistics  # noqa: E402

GROW_UNTIL, TURN_UNTIL = 0.25, 0.6  # shares of the duration: the force grows, then turns, then is gone
RECORDER_PATIENCE = 60.0            # s of wall time; the recorder writes what it has taken, packed, before it ends
LEAN = 0.8                          # the force's horizontal part over its whole, so that the surface sways as the force turns


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
        self.radius = float(rospy.get_param("~radius", 0.0))
        self.duration = float(rospy.get_param("~duration", 8.0))
        self.frame = rospy.get_param("~frame", "world")
        self.azimuth = float(rospy.get_param("~azimuth", -60.0))
        self.height = float(rospy.get_param("~height", 0.3))
        self.points = prepare_scan(self.path, rospy.get_param("~up", "z"), self.height)
        self.handle = int(self.points[:, 2].argmax())

        self.lock = threading.Lock()  # the two subscribers call from threads of their own
        self.rest = None
        self.now = None               # positions of the newest surface; one that has not changed is not sent again
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
        rospy.on_shutdown(self.ended.set)
        rospy.loginfo("publishing %d points of %s", len(self.points), os.path.basename(self.path))
        self.cloud.publish(make_cloud(self.points, rospy.Time.now(), self.frame))
        patience = rospy.get_param("~patience", 120.0)  # s of wall time; a slow machine may fall behind real time
        ended = self.ended.wait(patience)
        if rospy.is_shutdown():
            return "it was shut down before its end; nothing is written"
        if not ended:
            if self.rest is None:
                return "no deformed surface arrived within %g s" % patience
            rospy.logwarn("the demo did not reach %g simulated seconds within %g s; ending it here", self.duration, patience)
        bag = self.end_recording()
        with self.lock:
            if self.best is None or self.last is None:
                return "the run ended before there was a deformed surface with statistics"
            self.write_results(bag)
        return None

    def end_recording(self):
        """Ends the recorder of the launch, which would go on as long as that does. Returns what the summary says of its bag."""
        if not end_neighbor("record"):
            return "none: no recorder was started with this node"
        path = os.path.join(self.output, "demo.bag")
        end = time.time() + RECORDER_PATIENCE
        while os.path.exists(path + ".active") or not os.path.exists(path):  # it has that name until it is complete
            if time.time() > end:
                return "none: %s was not complete after %g s" % (path, RECORDER_PATIENCE)
            time.sleep(0.05)
        return "%s (%.1f MB)" % (path, os.path.getsize(path) / 1e6)

    def take_statistics(self, message):
        """They come while the surface rests, too, and are the demo's clock."""
        with self.lock:
            if self.ended.is_set():
                return
            self.last = message
            if self.rest is None:
                return
            self.speeds.append(message.real_time_factor)
            self.pull(self.now[self.handle], message.simulation_time)
            if message.simulation_time >= self.duration:
                self.ended.set()

    def take_surface(self, message):
        with self.lock:
            if self.ended.is_set():
                return
            positions, displacement = read_positions(message), read_field(message, "displacement")
            if self.rest is None:
                self.rest = positions, displacement
            self.now = positions
            time = self.last.simulation_time if self.last else 0.0
            if self.best is None or np.nanmax(displacement) > np.nanmax(self.best[1]):
                self.best = positions, displacement, time

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

    def write_results(self, bag):
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
            ("picture", picture),
            ("bag", bag)]
        with open(os.path.join(self.output, "summary.txt"), "w") as stream:
            stream.writelines("%-22s%s\n" % line for line in lines)
        rospy.loginfo("wrote %s and summary.txt; the demo is over, and the launch ends with it", picture)


def main():
    try:
        problem = Demo().run()
    except (OSError, ValueError, KeyError) as error:
        problem = str(error)
    if not problem:
        end_launch()
    return problem


if __name__ == "__main__":
    run_node("demo_client", main)
