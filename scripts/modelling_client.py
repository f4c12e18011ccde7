#!/usr/bin/env python3
"""The modelling loop of [Szeliski and Tonnesen 1991, sec. 8] without a person: sprays points into space, lets them form a sheet,
shapes it, freezes it, melts it, trims it, adds to it. It checks each result and ends with an error if one is missing.
With ~spray_only it stops after the first step, so that a user can continue in RViz. With ~sheet (its length and width, m) it only
publishes a bare sheet."""
import os
import sys

import numpy as np
import rospy
from deformable_surface.msg import Statistics, Tool, ToolArray, ToolWrenchArray
from deformable_surface.srv import EditParticles, EditParticlesRequest, GrowSurface
from geometry_msgs.msg import Pose
from sensor_msgs.msg import PointCloud2
from shape_msgs.msg import SolidPrimitive

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
from launched_node import end_launch, run_node  # noqa: E402
from scan_clouds import make_cloud, read_field, read_positions  # noqa: E402

PATIENCE = 60.0  # s of wall time for each step


def spray(random, center, size, apart, tries=4000):
    """Points at random in a box of the size about the center, no two of them nearer than apart."""
    points = np.empty((0, 3))
    for point in center + size * (random.random_sample((tries, 3)) - 0.5):
        if len(points) == 0 or np.linalg.norm(points - point, axis=1).min() >= apart:
            points = np.vstack([points, point])
    return points


def make_lattice(length, width, spacing):
    """The lattice of scenes of this size: about the origin in z = 0, each point equally far from its six first neighbours."""
    columns = int(round(length / spacing)) + 1
    step = length / (columns - 1)
    rows = int(round(width / (0.5 * np.sqrt(3) * step))) + 1
    points = [((i - 0.5 * (columns - 1 - j % 2)) * step, 0.5 * np.sqrt(3) * step * (j - 0.5 * (rows - 1)), 0.0)
              for j in range(rows) for i in range(columns - j % 2)]
    return np.array(points)


def count_parts(points, reach):
    """The number of parts that are further than reach from each other."""
    left, parts = set(range(len(points))), 0
    while left:
        parts += 1
        front = [left.pop()]
        while front:
            near = [i for i in left if np.linalg.norm(points[i] - points[front[-1]]) <= reach]
            front.pop()
            left.difference_update(near)
            front.extend(near)
    return parts


class Modeller:
    def __init__(self):
        self.spacing = float(rospy.get_param("~spacing", 0.04))
        self.plane = bool(rospy.get_param("~plane", False))  # the 2-D mode: everything in y = 0
        self.frame = rospy.get_param("~frame", "world")
        self.random = np.random.RandomState(1991)
        self.points = self.pinned = self.ids = self.speed = None
        self.contacts = {}
        self.table = []
        self.cloud = rospy.Publisher("cloud_in", PointCloud2, queue_size=1, latch=True)
        self.tools = rospy.Publisher("tools", ToolArray, queue_size=10)
        self.edit_service = rospy.ServiceProxy("edit", EditParticles)
        self.grow_service = rospy.ServiceProxy("grow_surface", GrowSurface)
        rospy.Subscriber("simulation_points", PointCloud2, self.take_points, queue_size=1)
        rospy.Subscriber("statistics", Statistics, self.take_statistics, queue_size=1)
        rospy.Subscriber("tool_wrenches", ToolWrenchArray, self.take_wrenches, queue_size=1)

    def take_points(self, message):
        self.points, self.ids = read_positions(message), read_field(message, "id").astype(int)
        self.pinned = read_field(message, "pinned") != 0

    def take_statistics(self, message):
        self.speed = message.max_speed

    def take_wrenches(self, message):
        self.contacts = {wrench.id: wrench.contacts for wrench in message.wrenches}

    def wait(self, what, condition):
        end = rospy.get_time() + PATIENCE
        while not condition():
            if rospy.get_time() > end or rospy.is_shutdown():
                raise RuntimeError("in %g s there was not: %s" % (PATIENCE, what))
            rospy.sleep(0.05)

    def wait_for_rest(self):
        rospy.sleep(0.3)
        self.wait("a surface at rest", lambda: self.speed is not None and self.speed < 0.1 * self.spacing)
        rospy.sleep(0.1)

    def note(self, step, result):
        self.table.append((step, result))
        rospy.loginfo("%s: %s", step, result)

    def require(self, holds, sentence):
        if not holds:
            raise RuntimeError(sentence)

    def edit(self, action, ids=(), positions=()):
        request = EditParticlesRequest(action=action, ids=list(ids))
        request.header.frame_id = self.frame
        for position in positions:
            pose = Pose()
            pose.position.x, pose.position.y, pose.position.z = position
            pose.orientation.w = 1.0
            request.poses.append(pose)
        response = self.edit_service(request)
        self.require(response.success, response.message)
        return response

    def measure_thickness(self, points):
        """Root of the mean squared distance from the plane that fits best, or from the line in the plane y = 0, in spacings."""
        sizes = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
        return sizes[1 if self.plane else 2] / np.sqrt(len(points)) / self.spacing

    def grow_surface(self):
        grown = self.grow_service()
        self.require(grown.success, grown.message)
        self.wait_for_rest()

    def move_ball(self, start, end, seconds, radius, mode=Tool.SOLID):
        tool = Tool(id="ball", mode=mode, primitive=SolidPrimitive(type=SolidPrimitive.SPHERE, dimensions=[radius]))
        tool.header.frame_id = self.frame
        tool.pose.orientation.w = 1.0
        for share in np.linspace(0, 1, int(seconds * 20) + 1):
            tool.pose.position.x, tool.pose.position.y, tool.pose.position.z = (1 - share) * start + share * end
            self.tools.publish(ToolArray(tools=[tool]))
            rospy.sleep(0.05)
        self.wait("the ball among the tools", lambda: "ball" in self.contacts)
        rospy.sleep(0.3)

    def remove_ball(self):
        self.tools.publish(ToolArray(tools=[Tool(id="ball", action=Tool.DELETE)]))
        self.wait("no ball", lambda: "ball" not in self.contacts)

    def publish(self, points):
        self.cloud.publish(make_cloud(points, rospy.Time.now(), self.frame))

    def run(self):
        a = self.spacing
        sheet = rospy.get_param("~sheet", None)
        if sheet:
            self.publish(make_lattice(*sheet, a))
            return
        # Spray: in a slab, as from a can that moves over a table; in the plane, along a line.
        if self.plane:
            x = np.cumsum(self.random.uniform(0.8 * a, 1.2 * a, 25))
            sprayed = np.stack([x - x.mean(), 0 * x, self.random.uniform(-0.2 * a, 0.2 * a, 25)], axis=1)
        else:
            sprayed = spray(self.random, np.zeros(3), np.array([12 * a, 12 * a, 0.4 * a]), 0.75 * a)
        self.publish(sprayed)
        self.wait("particles", lambda: self.points is not None and len(self.points) == len(sprayed))
        self.note("sprayed", "%d points, %.2f spacings thick" % (len(sprayed), self.measure_thickness(sprayed)))
        if rospy.get_param("~spray_only", False):
            return
        self.wait_for_rest()
        self.grow_surface()
        parts, thickness = count_parts(self.points, 1.6 * a), self.measure_thickness(self.points)
        self.note("a chain" if self.plane else "a sheet", "%d particles, %d part, %.2f spacings thick" %
                  (len(self.points), parts, thickness))
        self.require(parts == 1, "the sprayed points did not become one piece but %d" % parts)
        self.require(thickness < 0.1, "the sprayed points did not become flat")

        # Shape: a ball from below lifts the middle.
        before = self.points.copy()
        self.move_ball(np.array([0, 0, -4 * a]), np.array([0, 0, 0.5 * a]), 1.5, 2 * a)
        lifted = self.points[:, 2].max()
        self.note("shaped", "the middle stands %.1f spacings high" % (lifted / a))
        self.require(lifted > a, "the ball did not lift the sheet")

        # Freeze: held, position and orientation; a ball from above moves nothing.
        self.remove_ball()
        self.edit(EditParticlesRequest.FIX, self.ids)
        self.wait("that all are held", lambda: self.pinned.all())
        rospy.sleep(0.2)
        frozen = self.points.copy()
        above, below = np.array([0, 0, lifted + 3 * a]), np.array([0, 0, lifted + a])
        self.move_ball(above, below, 1.0, 2 * a)
        drift = np.linalg.norm(self.points - frozen, axis=1).max()
        self.note("frozen", "%d held, moved by %.2g spacings under the ball" % (self.pinned.sum(), drift / a))
        self.require(self.contacts["ball"] > 0, "the ball did not touch what was frozen")
        self.require(drift == 0.0, "what was frozen moved by %g m" % drift)
        self.move_ball(below, above, 0.5, 2 * a)
        self.remove_ball()

        # Melt: free again; the same ball takes it along.
        self.edit(EditParticlesRequest.FREE, self.ids)
        self.wait("that none is held", lambda: not self.pinned.any())
        self.wait_for_rest()
        self.move_ball(above, below, 1.0, 2 * a)
        moved = np.linalg.norm(self.points - frozen, axis=1).max()
        self.note("melted", "moved by %.1f spacings under the ball" % (moved / a))
        self.require(moved > 0.5 * a, "what was melted did not move")
        self.remove_ball()
        self.wait_for_rest()

        # Trim: what is on one side goes.
        limit = np.percentile(self.points[:, 0], 75)
        many = len(self.points)
        self.edit(EditParticlesRequest.DELETE, self.ids[self.points[:, 0] > limit])
        self.wait("fewer particles", lambda: len(self.points) < many)
        self.note("trimmed", "%d of %d are left" % (len(self.points), many))
        self.require(self.points[:, 0].max() <= limit + a, "beyond the cut there are still some")

        # Add: a spray along the new edge, and what is missing between grows.
        few = len(self.points)
        edge = self.points[np.argmax(self.points[:, 0])]
        if self.plane:
            added = edge + a * np.outer(np.arange(1, 5), [1.0, 0.0, 0.0])
        else:
            ys = np.arange(self.points[:, 1].min(), self.points[:, 1].max(), a)
            border = [self.points[np.abs(self.points[:, 1] - y) < 0.6 * a] for y in ys]
            border = np.array([part[np.argmax(part[:, 0])] for part in border if len(part)])
            added = np.vstack([border + [a, 0, 0], border + [2 * a, 0.5 * a, 0]])
            added = added[[np.linalg.norm(self.points - p, axis=1).min() > 0.8 * a for p in added]]
            added = np.array([p for i, p in enumerate(added)
                              if i == 0 or np.linalg.norm(added[:i] - p, axis=1).min() > 0.8 * a])
        self.edit(EditParticlesRequest.ADD, positions=added)
        self.wait("more particles", lambda: len(self.points) == few + len(added))
        self.wait_for_rest()
        self.grow_surface()
        parts = count_parts(self.points, 1.6 * a)
        self.note("added to", "%d particles, %d part" % (len(self.points), parts))
        self.require(parts == 1, "what was added did not join: there are %d parts" % parts)
        self.require(np.isfinite(before).all() and np.isfinite(self.points).all(), "there are points that are not finite")


def main():
    modeller = Modeller()
    try:
        modeller.edit_service.wait_for_service(PATIENCE)
        modeller.run()
    except rospy.ROSInterruptException:
        raise
    except (RuntimeError, rospy.ROSException) as error:
        return str(error)
    output = rospy.get_param("~output", "")
    if output:
        with open(output, "w") as stream:
            stream.writelines("%-10s %s\n" % line for line in modeller.table)
    if rospy.get_param("~spray_only", False) or rospy.get_param("~sheet", None):
        rospy.spin()
    else:
        end_launch()
    return None


if __name__ == "__main__":
    run_node("modelling_client", main)
