#!/usr/bin/env python3
"""Starts a launch file with a real recording or scan, and checks the result: check_launch.py CASE. Each
case has a master of its own. A case that needs the folder of scans that DEFORMABLE_SURFACE_DATA names is skipped without it
(status 77). Files are in folders with a space and an apostrophe in their names."""
import glob
import os
import random
import re
import shlex
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import xml.etree.ElementTree

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "..", "scripts"))
PATIENCE = 60.0  # s; only a check that fails takes that long
SKIPPED = 77


def find_data(path):
    folder = os.environ.get("DEFORMABLE_SURFACE_DATA", "")
    if not folder or not os.path.exists(os.path.join(folder, path)):
        print("skipped: DEFORMABLE_SURFACE_DATA names no folder with %s" % path)
        sys.exit(SKIPPED)
    return os.path.join(folder, path)


def find_port():
    """A free port below those of connections (32768 and above), because a connection could take one of those before the master does."""
    while True:
        port = random.randrange(20000, 32768)
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", port)) != 0:
                return port


class Launch:
    """A running launch file with a master of its own, and the messages of its surface."""

    def __init__(self, name, *arguments):
        port = find_port()
        os.environ.update(ROS_MASTER_URI="http://127.0.0.1:%d" % port, ROS_IP="127.0.0.1",
                          PATH="/usr/bin:/bin:" + os.environ["PATH"])
        self.process = subprocess.Popen(["roslaunch", "-p", str(port), "deformable_surface", name] + list(arguments),
                                        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True)
        self.lines = []
        self.reader = threading.Thread(target=self.read)
        self.reader.start()
        import rosgraph
        end = time.time() + PATIENCE
        while not rosgraph.is_master_online():
            if time.time() > end or self.process.poll() is not None:
                raise RuntimeError("no master came")
            time.sleep(0.1)
        import rospy
        rospy.init_node("check_launch", disable_signals=True)
        self.last = {}

    def __enter__(self):
        return self

    def read(self):
        for line in self.process.stdout:
            print(line, end="", flush=True)
            self.lines.append(line)

    def __exit__(self, kind, *error):
        """Ends it as Ctrl-C does. roslaunch kills a node after 15 s."""
        self.process.send_signal(signal.SIGINT)
        self.process.wait(30)
        self.reader.join()
        killed = [line for line in self.lines if "escalating" in line or "Traceback" in line]
        assert kind or not killed, killed

    def listen(self, topic, kind):
        import rospy
        return rospy.Subscriber("/deformable_surface/" + topic, kind, lambda message: self.last.__setitem__(topic, message),
                                queue_size=1, buff_size=1 << 26)

    def wait(self, what, condition):
        end = time.time() + PATIENCE
        while not condition(self.last):
            if time.time() > end:
                raise AssertionError("in %g s there was not: %s" % (PATIENCE, what))
            if self.process.poll() is not None:
                raise AssertionError("the launch ended before there was: %s" % what)
            time.sleep(0.05)
        print("found: %s" % what)


def make_folder():
    return tempfile.TemporaryDirectory(prefix="a folder's ")


def link_into(folder, path):
    """The same file in the folder, under a name with a space."""
    link = os.path.join(folder, "a " + os.path.basename(path))
    os.symlink(path, link)
    return link


def write_ball(path, points=2000):
    """An upright scan: points of a sphere, evenly on a spiral."""
    z = 1 - (2 * np.arange(points) + 1) / points
    angle = np.arange(points) * np.pi * (3 - np.sqrt(5))
    around = np.sqrt(1 - z * z)
    np.savetxt(path, np.stack([around * np.cos(angle), around * np.sin(angle), z], axis=1))


def largest_displacement(last):
    from scan_clouds import read_field
    return np.nanmax(read_field(last["deformed"], "displacement")) if "deformed" in last else 0.0


def check_poke():
    scan = find_data("open3d_bunny/bunnyData.pcd")
    from deformable_surface.msg import ToolWrenchArray
    from sensor_msgs.msg import PointCloud2
    with make_folder() as folder, Launch("poke.launch", "scan:=" + link_into(folder, scan), "up:=y") as launch:
        keep = [launch.listen("deformed", PointCloud2), launch.listen("tool_wrenches", ToolWrenchArray)]  # noqa: F841
        launch.wait("the bunny, every point of it", lambda last: "deformed" in last and last["deformed"].width == 30571)
        launch.wait("a ball on the frame of tf that pushes with more than 0.1 N", lambda last: any(
            wrench.id == "tip" and wrench.contacts > 0 and abs(wrench.wrench.force.x) > 0.1
            for wrench in getattr(last.get("tool_wrenches"), "wrenches", [])))
        launch.wait("a dent of more than 10 mm", lambda last: largest_displacement(last) > 0.01)
        # The tool is back after a reset, maybe before the check.
        import rospy
        from std_srvs.srv import Trigger
        numbers = []
        keep.append(rospy.Subscriber("/deformable_surface/tool_wrenches", ToolWrenchArray,
                                     lambda message: numbers.append(len(message.wrenches))))
        launch.wait("the tool before a reset", lambda last: 1 in numbers)
        assert rospy.ServiceProxy("/deformable_surface/reset", Trigger)().success
        launch.wait("no tool after a reset", lambda last: 0 in numbers)
        launch.wait("the tool again", lambda last: 1 in numbers[numbers.index(0):])


def check_camera_bag():
    bag = find_data("flat_n_fold_garment/garment.bag")
    import rospy
    from deformable_surface.msg import PointForce
    from scan_clouds import read_positions
    from sensor_msgs.msg import PointCloud2
    with make_folder() as folder, \
            Launch("camera_bag.launch", "bag:=" + link_into(folder, bag), "topic:=/camera/depth/points") as launch:
        keep = launch.listen("deformed", PointCloud2)  # noqa: F841
        launch.wait("the first cloud", lambda last: "deformed" in last)
        force = rospy.Publisher("/deformable_surface/force", PointForce, queue_size=1, latch=True)
        point = np.nanmedian(read_positions(launch.last["deformed"]), axis=0)
        message = PointForce(id="pull", radius=0.1)
        message.point.x, message.point.y, message.point.z = point
        message.force.z = 2.0
        force.publish(message)
        launch.wait("a displacement of more than 50 mm", lambda last: largest_displacement(last) > 0.05)
        # The bag has two more clouds, of fewer points.
        assert launch.last["deformed"].width == 8192, launch.last["deformed"].width


def check_towel_on_table():
    """The cloud shows no table. The plane with most of its points is removed, and so are isolated points."""
    bag = find_data("ros_bags/watercan.bag")
    from scan_clouds import read_positions
    from sensor_msgs.msg import PointCloud2
    with make_folder() as folder, \
            Launch("towel_on_table.launch", "bag:=" + link_into(folder, bag), "topic:=/euclidean_cluster_indices_decomposer/output00",
                   "keep:=both", "radius:=0.0", "crop:=[{box: {min: [0, 0.1, 0], max: [2, 2, 2]}}]") as launch:
        keep = launch.listen("deformed", PointCloud2)  # noqa: F841
        launch.wait("the first cloud, every row of it", lambda last: "deformed" in last and last["deformed"].width == 13966)
        points = read_positions(launch.last["deformed"])
        stays = np.isfinite(points).all(axis=1)
        print("%d points stay" % np.count_nonzero(stays))
        assert 5000 < np.count_nonzero(stays) < 12000, np.count_nonzero(stays)
        assert points[stays, 1].min() > 0.099, "not cropped"
        launch.wait("what was taken away, in the log", lambda last: any(
            re.search("taken away: crop [0-9]+, plane [0-9]+", line) for line in launch.lines))


def check_garment():
    # In decimetres or so, upright along y.
    scan = find_data("diffcloth_garments/tshirt1900.obj")
    from scan_clouds import read_field, read_positions
    from sensor_msgs.msg import PointCloud2
    with make_folder() as folder, Launch("garment.launch", "scan:=" + link_into(folder, scan), "up:=y") as launch:
        keep = launch.listen("deformed", PointCloud2)  # noqa: F841
        launch.wait("the shirt", lambda last: "deformed" in last and last["deformed"].width == 1921)
        rest = read_positions(launch.last["deformed"]) - 0.0
        held = [np.linalg.norm(rest - [x, 0.0, 0.65], axis=1) < 0.04 for x in (-0.2, 0.2)]
        assert all(np.count_nonzero(part) > 0 for part in held)
        launch.wait("cloth that has sagged by more than 20 mm", lambda last: largest_displacement(last) > 0.02)
        displacement = read_field(launch.last["deformed"], "displacement")
        assert max(displacement[part].max() for part in held) < 0.01, [displacement[part].max() for part in held]
        assert read_positions(launch.last["deformed"])[:, 2].min() > -0.5, "it fell"


def check_tracked():
    path, topic = find_data("ros_bags/cloth_placemat_val_setup.bag"), "/object_estimate"
    import rosbag
    from play_tracked import read_points
    from scan_clouds import read_positions
    from sensor_msgs.msg import PointCloud2
    with rosbag.Bag(path) as bag:
        recorded = [np.array(read_points(message)) for _, message, _ in bag.read_messages([topic])]
    with make_folder() as folder, \
            Launch("tracked.launch", "bag:=" + link_into(folder, path), "topic:=" + topic, "columns:=3") as launch:
        keep = [launch.listen(topic, PointCloud2) for topic in ("deformed", "simulation_points")]  # noqa: F841
        launch.wait("the placemat", lambda last: len(last) == 2)

        def find_distance(topic):
            surface = read_positions(launch.last[topic])
            return max(np.linalg.norm(surface - point, axis=1).min() for point in recorded[-1])

        moved = np.linalg.norm(recorded[-1] - recorded[0], axis=1).max()
        # float32 on the wire, half a metre from the origin.
        launch.wait("simulation points at the last tracked points within 1e-6 m; these have moved by %.2g m" % moved,
                    lambda last: find_distance("simulation_points") < 1e-6)
        # Its points are smoothed over the surrounding simulation points, some of which are constrained.
        print("the published surface is within %.2g m of them" % find_distance("deformed"))
        assert find_distance("deformed") < moved


def check_track():
    """A recorded motion as a camera would see it, dense, followed by a surface with the policy `track`."""
    import csv
    import rosbag
    import rospy
    from play_tracked import read_points
    from sensor_msgs import point_cloud2
    with rosbag.Bag(find_data("ros_bags/cloth_placemat_val_setup.bag")) as bag:
        recorded = [(stamp, np.array(read_points(message)).reshape(3, 3, 3))
                    for _, message, stamp in bag.read_messages(["/object_estimate"])]
    # Between the nine tracked points the cloth is interpolated bilinearly.
    at = np.linspace(0.0, 2.0, 41)
    cell, share = np.minimum(at.astype(int), 1), at - np.minimum(at.astype(int), 1)

    def refine(rows):
        return rows[cell] * (1 - share)[:, None, None] + rows[cell + 1] * share[:, None, None]

    clouds = [refine(refine(points).swapaxes(0, 1)).reshape(-1, 3) for _, points in recorded]
    moved = np.linalg.norm(clouds[-1] - clouds[0], axis=1).max()
    with make_folder() as folder:
        path, scene, table = (os.path.join(folder, name) for name in ("in.bag", "scene.yaml", "statistics.csv"))
        with rosbag.Bag(path, "w") as bag:
            for (stamp, _), points in zip(recorded, clouds):
                message = point_cloud2.create_cloud_xyz32(rospy.Header(stamp=stamp, frame_id="world"), points)
                bag.write("/deformable_surface/cloud_in", message, stamp)
        with open(scene, "w") as stream:
            stream.write("{model: mass_spring, gravity: [0, 0, 0], material: {young_modulus: 1.0e3, damping: 1.0}, "
                         "simplification: {target_points: 200}, input: {policy: track}}")
        length = (recorded[-1][0] - recorded[0][0]).to_sec()
        subprocess.run(["rosrun", "deformable_surface", "simulate", scene, "--bag_in", path, "--statistics", table, "--quiet",
                        "--duration", "%.2f" % (np.ceil(length * 100) / 100 + 1.0)], check=True)
        with open(table) as stream:
            rows = list(csv.DictReader(stream))
    residuals = np.array([float(row["tracking_residual"]) for row in rows])
    seen = int(rows[-1]["tracked_points"])
    print("moved by up to %.3g m; %d points seen; residual at most %.3g m, %.3g m in the end" %
          (moved, seen, np.nanmax(residuals), residuals[-1]))
    assert seen > 150, seen
    # The noise of float32 and the resistance of the surface, far below the motion.
    assert residuals[-1] < 0.05 * moved, (residuals[-1], moved)
    assert np.nanmax(residuals) > 2 * residuals[-1], "nothing was followed"


def check_record():
    import rosbag
    with make_folder() as folder:
        path = os.path.join(folder, "record.bag")
        with Launch("record.launch", "output:=" + path) as launch:
            import rospy
            from deformable_surface.msg import PointForce, Statistics
            force = rospy.Publisher("/deformable_surface/force", PointForce, queue_size=10)
            statistics = rospy.Publisher("/deformable_surface/statistics", Statistics, queue_size=10)
            other = rospy.Publisher("/deformable_surface/other", Statistics, queue_size=10)
            launch.wait("a recorder that listens",
                        lambda last: force.get_num_connections() > 0 and statistics.get_num_connections() > 0)
            assert other.get_num_connections() == 0
            for _ in range(3):
                force.publish(PointForce(id="pull"))
                statistics.publish(Statistics())
            launch.wait("a bag", lambda last: os.path.exists(path + ".active"))
            time.sleep(1.0)  # nothing tells when the recorder has written
        with rosbag.Bag(path) as bag:
            counts = {topic: info.message_count for topic, info in bag.get_type_and_topic_info().topics.items()}
        assert counts == {"/deformable_surface/force": 3, "/deformable_surface/statistics": 3}, counts


def expect_clean_end(launch):
    launch.reader.join()
    assert launch.process.returncode == 0, launch.process.returncode
    # Errors of roslaunch (red). Warnings and errors of the surface (yellow and red), except for the speed of the machine.
    slow = re.compile("slower than real time|the process did not get to run")
    loud = [line for line in launch.lines if re.search(r"\033\[3[13]m", line) and not slow.search(line)]
    assert not loud, loud


def check_demo():
    import rosbag
    with make_folder() as folder:
        scan = os.path.join(folder, "a ball.xyz")
        write_ball(scan)
        with Launch("demo.launch", "scan:=" + scan, "output:=" + folder, "duration:=1") as launch:
            launch.process.wait(2 * PATIENCE)
            expect_clean_end(launch)
        bag, picture = os.path.join(folder, "demo.bag"), os.path.join(folder, "surface.png")
        with open(os.path.join(folder, "summary.txt")) as stream:
            summary = stream.read()
        assert "%s (%.1f MB)" % (bag, os.path.getsize(bag) / 1e6) in summary, summary
        assert os.path.getmtime(bag) <= os.path.getmtime(picture), "it was recorded while the picture was drawn"
        with rosbag.Bag(bag) as recorded:
            counts = {topic: info.message_count for topic, info in recorded.get_type_and_topic_info().topics.items()}
        assert counts["/deformable_surface/cloud_in"] == 1 and counts["/deformable_surface/force"] > 1, counts


def write_frame(path, width=80, height=60):
    """A frame of a camera that looks at a wall with a bulge, 1 m away; a corner was not seen."""
    column, row = np.meshgrid(np.arange(width), np.arange(height))
    x, y = (column - 0.5 * width) / width, (row - 0.5 * height) / width
    depth = 1.0 - 0.1 * np.exp(-20 * (x * x + y * y))
    depth[:10, :10] = np.nan
    with open(path, "w") as stream:
        stream.write("VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH %d\nHEIGHT %d\n"
                     "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS %d\nDATA ascii\n" % (width, height, width * height))
        np.savetxt(stream, np.stack([x * depth, y * depth, depth], axis=-1).reshape(-1, 3))


def check_demo_camera():
    import rosbag
    with make_folder() as folder:
        scan = os.path.join(folder, "a frame.pcd")
        write_frame(scan)
        with Launch("demo.launch", "scan:=" + scan, "output:=" + folder, "duration:=1",
                    "set:={simplification: {target_points: 200}, contact: {self: false}}") as launch:
            launch.process.wait(2 * PATIENCE)
            expect_clean_end(launch)
        with open(os.path.join(folder, "summary.txt")) as stream:
            summary = stream.read()
        assert "a camera's frame" in summary and "up is -y" in summary, summary
        assert re.search(r"simulation points +2\d\d\n", summary), summary
        assert 0 < float(re.search(r"real-time factor +(\S+)", summary).group(1)) < 1.2, summary
        with rosbag.Bag(os.path.join(folder, "demo.bag")) as bag:
            messages = {topic: message for topic, message, _ in bag.read_messages()}
        sent, back = messages["/deformable_surface/cloud_in"], messages["/deformable_surface/deformed"]
        assert (sent.width, sent.height, sent.header.frame_id) == (80, 60, "demo_camera"), sent.header
        assert (back.width, back.height, back.header.frame_id) == (80, 60, "world"), back.header
        assert messages["/tf_static"].transforms[0].child_frame_id == "demo_camera"


def check_demo_refused():
    with make_folder() as folder:
        scan = os.path.join(folder, "a line.xyz")
        np.savetxt(scan, np.outer(np.linspace(0.0, 1.0, 200), [1.0, 2.0, 3.0]))
        with Launch("demo.launch", "scan:=" + scan, "output:=" + folder) as launch:
            launch.process.wait(PATIENCE)
            launch.reader.join()
        assert any("found points along a line" in line for line in launch.lines)
        assert not os.path.exists(os.path.join(folder, "summary.txt"))


def check_demo_interrupted():
    from deformable_surface.msg import PointForce
    with make_folder() as folder:
        scan = os.path.join(folder, "a ball.xyz")
        write_ball(scan)
        with Launch("demo.launch", "scan:=" + scan, "output:=" + folder, "duration:=100") as launch:
            keep = launch.listen("force", PointForce)  # noqa: F841
            launch.wait("a pull", lambda last: "force" in last)
        # The exit checks that no node had to be killed.
        assert not os.path.exists(os.path.join(folder, "summary.txt"))


PATHS = {"bag", "output", "scan", "scene"}  # the arguments of launch files that are paths


def find_split_paths(args):
    """The paths in the args of a node that blanks would split into several words."""
    return [match for match in re.findall(r"\$\((?:find|arg) [^)]*\)", args)
            if (match.startswith("$(find") or match[6:-1] in PATHS)
            and len(shlex.split(args.replace(match, "a b"))) != len(shlex.split(args.replace(match, "a")))]


def check_spaces():
    """The words that roslaunch passes to a program: every path is one word, whatever the names of its folders."""
    assert find_split_paths("-O $(arg output)/demo.bag") == ["$(arg output)"]
    assert find_split_paths('-O "$(arg output)/demo.bag" $(arg topic)') == []
    folder = os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "..", "launch")
    files = glob.glob(os.path.join(folder, "*.launch"))
    found = 0
    for path in files:
        for node in xml.etree.ElementTree.parse(path).iter("node"):
            args = node.get("args", "")
            assert not find_split_paths(args), (path, find_split_paths(args))
            found += len(args) > 0
    assert found > 4, (files, found)


def run_modelling(*arguments):
    with make_folder() as folder:
        output = os.path.join(folder, "steps.txt")
        with Launch("modelling.launch", "unattended:=true", "output:=" + output, *arguments) as launch:
            # The launch ends with the script, which reports wrong results itself.
            launch.process.wait(4 * PATIENCE)
            expect_clean_end(launch)
        with open(output) as stream:
            steps = stream.read()
    print(steps)
    for step in ("sprayed", "shaped", "frozen", "melted", "trimmed", "added to"):
        assert step in steps, step


def check_modelling():
    run_modelling()


def check_modelling_plane():
    run_modelling("plane:=true")


if __name__ == "__main__":
    cases = {name[len("check_"):]: check for name, check in list(globals().items()) if name.startswith("check_")}
    if len(sys.argv) != 2 or sys.argv[1] not in cases:
        sys.exit("usage: check_launch.py CASE; the cases: %s" % ", ".join(sorted(cases)))
    cases[sys.argv[1]]()
