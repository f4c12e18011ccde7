#!/usr/bin/env python3
"""The demo: publishes a scan as the surface at rest, pulls the highest point that can move with a force that grows and turns, releases it,
ends the recording, and writes a summary and a picture. Like any other client it uses topics only."""
import os
import sys
import threading
import time

import numpy as np
import rospy
import tf2_ros
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import PointCloud2

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import draw_cloud  # noqa: E402
from launched_node import end_launch, end_neighbor, run_node  # noqa: E402
from look_at_scan import Scan, to_quaternion  # noqa: E402
from scan_clouds import make_cloud, read_field, read_positions  # noqa: E402
from deformable_surface.msg import PointForce, Statistics  # noqa: E402

GROW_UNTIL, TURN_UNTIL = 0.25, 0.6  # shares of the duration: the force grows, then turns, then is gone
RECORDER_PATIENCE = 60.0            # s of wall time; the recorder writes what it has taken, packed, before it ends
FARTHEST = 2.0                      # heights of the scan: what comes farther than that is let go
LISTENERS = 2                       # to transforms: the node and the recorder
TF_PATIENCE, TF_LAG = 5.0, 0.3      # s of wall time: until both listen, and until what was sent is there
REAL_TIME = 0.95                    # of real time: a run that is slower is called slow
FEWEST_POINTS = 100                 # that are proposed for a faster run
CAMERA_FRAME = "demo_camera"
LEAN = 0.8                          # the force's horizontal part over its whole, so that the surface sways as the force turns


def compute_pull(share, strength):
    """The force (N) at this share of the duration."""
    if share >= TURN_UNTIL:
        return np.zeros(3)
    grown = min(1.0, share / GROW_UNTIL)
    angle = 2 * np.pi * max(0.0, (share - GROW_UNTIL) / (TURN_UNTIL - GROW_UNTIL))
    return strength * grown * np.array([LEAN * np.cos(angle), LEAN * np.sin(angle), np.sqrt(1 - LEAN * LEAN)])


def measure_speed(clock):
    """Simulated time over wall time, between the first and the last pair of them; NaN if no time has passed."""
    (first, begin), (last, end) = clock[0], clock[-1]
    return (last - first) / (end - begin) if end > begin else float("nan")


def choose_handle(points, is_held):
    """The highest point (a row of the n x 3) that can move, and how many higher ones cannot. ValueError if none can."""
    free = np.flatnonzero(~is_held)
    if len(free) == 0:
        raise ValueError("found every simulation point held; accepted: a scan that the demo holds by a part only")
    handle = points[free[points[free, 2].argmax()]]
    return handle, int(np.count_nonzero(points[:, 2] > handle[2]))


def find_refusal(message, node):
    """What the node's diagnostics say of a cloud that it has refused, or nothing."""
    for status in message.status:
        refused = [item.value for item in status.values if item.key == "clouds refused"]
        if status.name.endswith(node + ": input") and refused and int(refused[0]) > 0:
            return status.message
    return None


class Demo:
    def __init__(self):
        self.path = rospy.get_param("~scan")
        if not self.path:
            raise ValueError("no scan is given; give one: scan:=FILE")
        self.output = rospy.get_param("~output")
        self.strength = float(rospy.get_param("~force", 2.0))
        self.radius = float(rospy.get_param("~radius", 0.0))
        self.duration = float(rospy.get_param("~duration", 8.0))
        old_timeout = rospy.get_param("~patience", "")
        if old_timeout:
            rospy.logwarn("patience is now called timeout; the old name goes with version 0.3")
        self.timeout = float(old_timeout or rospy.get_param("~timeout", 120.0))  # s of wall time; a slow machine may fall behind
        self.frame = rospy.get_param("~frame", "world")
        self.azimuth = float(rospy.get_param("~azimuth", -60.0))
        self.height = float(rospy.get_param("~height", 0.3))
        self.scan = Scan(self.path, rospy.get_param("~up", "auto"), self.height)
        for sentence in self.scan.notices:
            rospy.loginfo("%s", sentence)

        self.lock = threading.Lock()  # the subscribers call from threads of their own
        self.rest = None
        self.now = None               # positions of the newest surface; one that has not changed is not sent again
        self.best = None              # the most deformed surface so far: positions, displacements, time
        self.last = None              # the newest statistics
        self.clock = []               # pairs of simulated and wall time, s
        self.simulated = None         # the simulation points at rest, and which of them are held
        self.handle = None            # the point of the surface that is pulled: its index
        self.pulled = "nothing"       # the same in words
        self.refusal = None           # why there is no surface
        self.pulling = True
        self.ended = threading.Event()

        self.force = rospy.Publisher("force", PointForce, queue_size=10)
        self.cloud = rospy.Publisher("cloud_in", PointCloud2, queue_size=1, latch=True)
        rospy.Subscriber("statistics", Statistics, self.take_statistics, queue_size=100)
        rospy.Subscriber("deformed", PointCloud2, self.take_surface, queue_size=1, buff_size=1 << 26)
        rospy.Subscriber("simulation_points", PointCloud2, self.take_simulation_points, queue_size=1)
        rospy.Subscriber("/diagnostics", DiagnosticArray, self.take_diagnostics, queue_size=10)

    def publish_scan(self):
        """A camera's frame as the camera would: its grid, in its own frame. Anything else upright in the world; a grid as a grid, because
        the node finds in it where a camera stood."""
        scan, now = self.scan, rospy.Time.now()
        if not scan.is_camera:
            placed = scan.place()
            if scan.height == 1:
                placed = placed[np.isfinite(placed).all(axis=1)]
            self.cloud.publish(make_cloud(placed, now, self.frame, scan.width if scan.height > 1 else None))
            return
        transform = TransformStamped(child_frame_id=CAMERA_FRAME)
        transform.header.stamp, transform.header.frame_id = now, self.frame
        for target, names, values in ((transform.transform.translation, "xyz", scan.offset),
                                      (transform.transform.rotation, "xyzw", to_quaternion(scan.rotation))):
            for name, value in zip(names, values):
                setattr(target, name, value)
        self.broadcaster = tf2_ros.StaticTransformBroadcaster()
        self.broadcaster.sendTransform(transform)
        # A node that gets the cloud first waits for the transform, but says so as if something were wrong. The recorder listens, too.
        end = time.monotonic() + TF_PATIENCE
        while self.broadcaster.pub_tf.get_num_connections() < LISTENERS and time.monotonic() < end and not rospy.is_shutdown():
            time.sleep(0.05)
        time.sleep(TF_LAG)
        self.cloud.publish(make_cloud(scan.scale * scan.rows, now, CAMERA_FRAME, scan.width))

    def run(self):
        """Returns the sentence that says why the demo failed, or nothing."""
        rospy.on_shutdown(self.ended.set)
        self.publish_scan()
        ended = self.ended.wait(self.timeout)
        if rospy.is_shutdown():
            return "it was shut down before its end; nothing is written"
        if self.refusal:
            return self.refusal
        with self.lock:
            self.ended.set()
            if self.rest is None or self.best is None or self.last is None:
                return "no deformed surface with statistics arrived within %g s; nothing is written" % self.timeout
        if not ended:
            rospy.logwarn("the demo did not reach %g simulated seconds within %g s; ending it here", self.duration, self.timeout)
        self.write_results(self.end_recording())
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

    def take_diagnostics(self, message):
        with self.lock:
            node = rospy.resolve_name("statistics").split("/")[1]
            if self.rest is None and not self.ended.is_set():
                self.refusal = find_refusal(message, node)
            if self.refusal:
                self.ended.set()

    def take_simulation_points(self, message):
        with self.lock:
            if self.simulated is None:
                self.simulated = read_positions(message), read_field(message, "pinned") > 0
                self.take_hold()

    def take_hold(self):
        """Chooses what is pulled, once both are there: what is simulated says what can move."""
        if self.rest is None or self.simulated is None or self.ended.is_set():
            return
        try:
            place, higher = choose_handle(*self.simulated)
        except ValueError as error:
            self.refusal = str(error)
            self.ended.set()
            return
        self.handle = int(np.nanargmin(np.linalg.norm(self.rest[0] - place, axis=1)))
        self.pulled = "the highest point that can move, %.3g m above the ground" % place[2]
        if higher:
            self.pulled += "; %d higher simulation points are held, or in parts that nothing holds" % higher
        rospy.loginfo("pulls %s", self.pulled)

    def take_statistics(self, message):
        """They come while the surface rests, too, and are the demo's clock."""
        with self.lock:
            if self.ended.is_set():
                return
            self.last = message
            if self.rest is None or self.handle is None:
                return
            self.clock.append((message.simulation_time, time.monotonic()))
            # What was simulated before there was a handle is not the demo's.
            self.pull(self.now[self.handle], message.simulation_time - self.clock[0][0])
            if message.simulation_time - self.clock[0][0] >= self.duration:
                self.ended.set()

    def take_surface(self, message):
        with self.lock:
            if self.ended.is_set():
                return
            positions, displacement = read_positions(message), read_field(message, "displacement")
            if self.rest is None:
                self.rest = positions, displacement
                self.take_hold()
            self.now = positions
            time = self.last.simulation_time if self.last else 0.0
            if self.best is None or np.nanmax(displacement) > np.nanmax(self.best[1]):
                self.best = positions, displacement, time

    def pull(self, point, time):
        """Sends the force anew at the place to which the surface has moved. A zero force ends it and is sent once."""
        if not self.pulling:
            return
        force = compute_pull(time / self.duration, self.strength)
        self.pulling = time < TURN_UNTIL * self.duration
        way = np.linalg.norm(point - self.rest[0][self.handle])
        if self.pulling and way > FARTHEST * self.height:
            force, self.pulling = np.zeros(3), False
            self.pulled += "; let go after %.2f s, when it had come %.3g m" % (time, way)
        message = PointForce(id="pull", radius=self.radius)
        message.header.frame_id = self.frame  # the stamp stays zero: from now on
        message.point.x, message.point.y, message.point.z = point
        message.force.x, message.force.y, message.force.z = force
        self.force.publish(message)

    def write_results(self, bag):
        positions, displacement, time = self.best
        largest = np.nanmax(displacement)
        picture = os.path.join(self.output, "surface.png")
        caption = "%s: %d points, %d of them simulated, pulled by the highest point that can move with %g N" % (
            os.path.basename(self.path), self.last.points, self.last.simulation_points, self.strength)
        titles = ["at rest", "after %.1f s" % time]
        draw_cloud.draw(picture, [self.rest, (positions, displacement)], titles, caption, self.azimuth)
        speed = measure_speed(self.clock) if self.clock else float("nan")
        fewer = max(FEWEST_POINTS, self.last.simulation_points // 4)
        slow = "" if speed >= REAL_TIME else "; slower than real time, try set:='{simplification: {target_points: %d}}'" % fewer
        lines = [("scan", self.scan.notices[0])]
        lines += [("", sentence) for sentence in self.scan.notices[1:]]
        lines += [
            ("points", "%d" % self.last.points),
            ("simulation points", "%d" % self.last.simulation_points),
            ("pulled", self.pulled),
            ("steps", "%d (%.2f s simulated)" % (self.last.step, self.last.simulation_time)),
            ("real-time factor", "%.3g (simulated time over wall time)%s" % (speed, slow)),
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
