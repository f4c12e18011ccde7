#!/usr/bin/env python3
"""Opens the window of a launch file without a screen and checks its picture: check_windows.py CASE [FOLDER for the pictures], or
all. The surfaces have frames and sizes that no RViz configuration states. A case is skipped (status 77) if RViz or a virtual display is
missing."""
import os
import shutil
import subprocess
import sys
import tempfile
import time

import numpy as np

from check_launch import SKIPPED, Launch

WINDOW = (1280, 720)
BACKGROUND = (32, 34, 40)  # of every configuration
SEEN = 76        # darkest that a lit surface is; the grid is darker
# s: RViz loads its plugins with software rendering. A window is awaited by what it shows, and only one that fails takes that long.
PATIENCE = 120.0


def skip_without(*programs):
    for program in programs:
        if not shutil.which(program):
            print("skipped: there is no %s here; scripts/rviz_pictures installs what is missing" % program)
            sys.exit(SKIPPED)


class Display:
    """A screen in memory, on which RViz opens its window."""

    def __enter__(self):
        read, write = os.pipe()
        self.server = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "%dx%dx24" % WINDOW, "-nolisten", "tcp"],
                                       pass_fds=[write], stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as stream:
            os.environ["DISPLAY"] = ":" + stream.readline().strip()
        os.environ.update(LIBGL_ALWAYS_SOFTWARE="1", QT_X11_NO_MITSHM="1", NO_AT_BRIDGE="1")
        os.environ.setdefault("XDG_RUNTIME_DIR", tempfile.gettempdir())
        return self

    def __exit__(self, *error):
        self.server.terminate()
        self.server.wait()


class Picture:
    """The present content of the window. Counts are pixels of the part that shows the scene."""

    def __init__(self, path):
        subprocess.run(["import", "-window", "root", path], check=True)
        data = subprocess.run(["convert", path, "-depth", "8", "rgb:-"], check=True, stdout=subprocess.PIPE).stdout
        pixels = np.frombuffer(data, np.uint8).reshape(WINDOW[1], WINDOW[0], 3).astype(int)
        ground = (pixels == BACKGROUND).all(axis=2)
        rows, columns = np.nonzero(ground.sum(axis=1) > 200)[0], np.nonzero(ground.sum(axis=0) > 100)[0]
        self.has_scene = len(rows) > 0 and len(columns) > 0
        if self.has_scene:
            self.top, self.left = rows[0], columns[0]
            self.scene = pixels[rows[0]:rows[-1] + 1, columns[0]:columns[-1] + 1]

    def letters(self):
        return np.count_nonzero((self.scene >= 235).all(axis=2)) if self.has_scene else 0

    def letters_below(self, place):
        column, row = place[0] - self.left, place[1] - self.top
        return np.count_nonzero((self.scene[row + 15:row + 60, column - 100:column + 100] >= 200).all(axis=2))

    def surface(self):
        """Pixels of broad objects in the scene, without letters and lines."""
        mask = self.scene.max(axis=2) >= SEEN
        for axis in (0, 1):
            mask = np.logical_and.reduce([np.roll(mask, shift, axis) for shift in range(-3, 4)])
        return mask

    def find_button(self):
        """The middle of the blue button above the surface, on the screen."""
        red, green, blue = (self.scene[:, :, k] for k in range(3))
        rows, columns = np.nonzero((blue > 120) & (blue > 1.3 * green) & (green > 1.5 * red))
        return (self.left + int(np.median(columns)), self.top + int(np.median(rows))) if len(rows) > 50 else None

    def describe_surface(self):
        """The first reason why the picture shows no surface, or nothing."""
        if not self.has_scene:
            return "there is no window"
        rows, columns = np.nonzero(self.surface())
        height, width = self.scene.shape[:2]
        if len(rows) < 0.02 * height * width:
            return "%.2g of the scene shows a surface" % (len(rows) / (height * width))
        if max((rows.max() - rows.min()) / height, (columns.max() - columns.min()) / width) < 0.25:
            return "the surface is small"
        if min(rows.min(), columns.min(), height - 1 - rows.max(), width - 1 - columns.max()) < 5:
            return "the surface goes beyond the window"
        return ""


def await_picture(folder, name, judge, launch):
    """Waits for a picture that judge accepts twice in a row, so that no message is on its way."""
    path = os.path.join(folder, name + ".png")
    end, good = time.time() + PATIENCE, 0
    while good < 2:
        picture = Picture(path)
        problem = judge(picture)
        good = 0 if problem else good + 1
        if time.time() > end:
            raise AssertionError("%s: %s" % (path, problem))
        if launch.process.poll() is not None:
            raise AssertionError("the launch ended before there was a picture; %s: %s" % (path, problem))
        time.sleep(1.0)
    print("found: %s" % path)
    return picture


def await_surface(folder, name, launch):
    return await_picture(folder, name, Picture.describe_surface, launch)


# ---- Clouds ----

def make_sphere(radius=0.15, count=4000):
    """A hollow sphere with even points."""
    k = np.arange(count) + 0.5
    z, angle = 1 - 2 * k / count, np.pi * (1 + np.sqrt(5)) * k
    return radius * np.stack([np.sqrt(1 - z * z) * np.cos(angle), np.sqrt(1 - z * z) * np.sin(angle), z], axis=1)


def make_grid(columns, rows, spacing):
    return spacing * np.stack([np.tile(np.arange(columns), rows), np.repeat(np.arange(rows), columns), np.zeros(columns * rows)], axis=1)


def write_points(path, points):
    np.savetxt(path, points, fmt="%.6f")
    return path


def write_bag(path, topic, clouds, frame):
    import rosbag
    import rospy
    from scan_clouds import make_cloud
    with rosbag.Bag(path, "w") as bag:
        for k, points in enumerate(clouds):
            stamp = rospy.Time(1000.0 + 0.1 * k)
            bag.write(topic, make_cloud(points, stamp, frame), stamp)
    return path


def scene(name):
    """One without weight."""
    return os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "..", "scenes", name + ".yaml")


def publish(topic, points, frame):
    import rospy
    from scan_clouds import make_cloud
    from sensor_msgs.msg import PointCloud2
    publisher = rospy.Publisher(topic, PointCloud2, queue_size=1, latch=True)
    publisher.publish(make_cloud(points, rospy.Time.now(), frame))
    return publisher


# ---- Cases ----

def check_surface(folder):
    """The window waits, then shows a cloud of metres in a distant frame, then one of decimetres in another frame."""
    with Launch("deformable_surface.launch", "rviz:=true", "cloud:=/camera/points", "scene:=" + scene("tracked")) as launch:
        await_picture(folder, "waiting", lambda p: "" if p.letters() > 300 else "there is no text", launch)
        keep = [publish("/camera/points", make_grid(30, 20, 0.1) + [40.0, -25.0, 3.0], "far_table")]
        await_surface(folder, "surface", launch)
        keep.append(publish("/camera/points", make_sphere(0.06, 2000) + [0.0, 0.3, 0.5], "gripper"))
        time.sleep(3.0)  # the old surface would be taken for the new one
        await_surface(folder, "another_surface", launch)


def check_demo(folder):
    scan = write_points(os.path.join(folder, "sphere.xyz"), make_sphere())
    with Launch("demo.launch", "rviz:=true", "scan:=" + scan, "output:=" + folder, "duration:=300.0") as launch:
        await_surface(folder, "demo", launch)


def poke(folder, nearest, *arguments):
    scan = write_points(os.path.join(folder, "sphere.xyz"), make_sphere())
    return Launch("poke.launch", "rviz:=true", "scan:=" + scan,
                  "path:=[[0, 0.2, 0, 0.2], [5, {0}, 0, 0.2], [1e5, {0}, 0, 0.2]]".format(nearest), *arguments)


def check_poke(folder):
    with poke(folder, 0.15) as launch:
        await_surface(folder, "poke", launch)


def check_interactive_markers(folder):
    """The mouse pauses the surface, the answer appears, the mouse continues the run and pulls the surface aside."""
    from deformable_surface.msg import ToolWrenchArray
    with poke(folder, 0.2, "interactive_markers:=true") as launch:
        picture = await_surface(folder, "interactive_markers", launch)
        button = picture.find_button()
        assert button, "there is no blue button in interactive_markers.png"
        choose_first(button)
        await_picture(folder, "answer", lambda p: "" if p.letters_below(button) > 20 else "there is no answer", launch)
        choose_first(button, entry=2)
        rows, columns = np.nonzero(picture.surface())
        keep = launch.listen("tool_wrenches", ToolWrenchArray)  # noqa: F841
        # So little that the pull does not slip.
        drag(picture.left + int(np.median(columns)), picture.top + int(np.median(rows)), -8, -6)
        launch.wait("a pull by the mouse", lambda last: any(w.id == "hand" for w in getattr(last.get("tool_wrenches"), "wrenches", [])))
        Picture(os.path.join(folder, "pull.png"))


def xdotool(*arguments):
    subprocess.run(["xdotool"] + [str(a) for a in arguments], check=True)
    time.sleep(0.5)


def choose_first(place, entry=1):
    """Chooses an entry of the menu that the right button opens at the place."""
    xdotool("mousemove", *place)
    xdotool("mousemove_relative", 2, 2)
    xdotool("click", 3)
    for _ in range(entry):
        xdotool("key", "Down")
    xdotool("key", "Return")


def drag(x, y, right, down):
    xdotool("mousemove", x - 5, y - 2)
    xdotool("mousemove", x, y)
    xdotool("mousedown", 1)
    for k in range(1, 21):
        subprocess.run(["xdotool", "mousemove", str(x + right * k // 20), str(y + down * k // 20)], check=True)
        time.sleep(0.1)


def check_camera_bag(folder):
    """A camera frame, where y points down, with stray points far away. No RViz configuration states either."""
    grid = make_grid(60, 60, 0.015)
    cloth = np.stack([grid[:, 0] - 0.45, grid[:, 1] - 0.45, 2.0 + 0.05 * np.sin(8 * grid[:, 0])], axis=1)
    stray = make_grid(5, 4, 0.01) + [3.0, 0.0, 6.0]
    bag = write_bag(os.path.join(folder, "camera.bag"), "/camera/points", [np.vstack([cloth, stray])], "camera_depth_optical_frame")
    with Launch("camera_bag.launch", "rviz:=true", "bag:=" + bag, "topic:=/camera/points") as launch:
        await_surface(folder, "camera_bag", launch)


def check_garment(folder):
    body = make_grid(60, 70, 0.01) - [0.295, 0.0, 0.0]
    scan = write_points(os.path.join(folder, "garment.xyz"), body[:, [0, 2, 1]])
    with Launch("garment.launch", "rviz:=true", "scan:=" + scan, "left:=[-0.28, 0.0, 0.68]", "right:=[0.28, 0.0, 0.68]") as launch:
        await_surface(folder, "garment", launch)


def check_tracked(folder):
    steps = [make_grid(3, 3, 0.1) + [0.5, -0.3, 0.9] + [0.0, 0.002 * k, 0.001 * k] for k in range(20)]
    bag = write_bag(os.path.join(folder, "tracked.bag"), "/tracker/points", steps, "table_surface")
    with Launch("tracked.launch", "rviz:=true", "bag:=" + bag, "topic:=/tracker/points", "columns:=3") as launch:
        await_surface(folder, "tracked", launch)


def check_modelling(folder):
    with Launch("modelling.launch", "rviz:=true") as launch:
        await_surface(folder, "modelling", launch)


def check_record(folder):
    """The window of a recording, on a surface that another launch file runs."""
    with Launch("deformable_surface.launch", "scene:=" + scene("camera_bag")) as launch:
        keep = publish("/deformable_surface/cloud_in", make_sphere() + [2.0, 2.0, 0.0], "cell")  # noqa: F841
        recording = subprocess.Popen(["roslaunch", "deformable_surface", "record.launch", "rviz:=true",
                                      "output:=" + os.path.join(folder, "recording.bag")])
        try:
            await_surface(folder, "record", launch)
        finally:
            recording.send_signal(2)
            recording.wait(30)


def check_springs(folder):
    with Launch("deformable_surface.launch", "rviz:=true", "view:=springs", "scene:=" + scene("camera_bag")) as launch:
        keep = publish("/deformable_surface/cloud_in", make_sphere(), "world")  # noqa: F841
        await_picture(folder, "springs", lambda p: "" if p.has_scene and np.count_nonzero(p.scene.max(axis=2) >= SEEN) >
                      0.05 * p.scene.shape[0] * p.scene.shape[1] else "there are no springs", launch)


def main():
    cases = {name[len("check_"):]: check for name, check in list(globals().items()) if name.startswith("check_")}
    if len(sys.argv) not in (2, 3) or sys.argv[1] not in list(cases) + ["all"]:
        sys.exit("usage: check_windows.py CASE [FOLDER]; the cases: %s, all" % ", ".join(sorted(cases)))
    skip_without("rviz", "Xvfb", "import", "convert", "xdotool")
    with tempfile.TemporaryDirectory() as folder:
        if len(sys.argv) == 3:
            folder = os.path.abspath(sys.argv[2])
            os.makedirs(folder, exist_ok=True)
        if sys.argv[1] == "all":
            # A process has only one master.
            failed = [case for case in cases if subprocess.run([sys.executable, __file__, case, folder]).returncode != 0]
            sys.exit("failed: %s" % ", ".join(failed) if failed else 0)
        with Display():
            cases[sys.argv[1]](folder)


if __name__ == "__main__":
    main()
