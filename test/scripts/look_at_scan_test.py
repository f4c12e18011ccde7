#!/usr/bin/env python3
"""Checks of a scan before the demo builds or starts anything: scripts/look_at_scan.py, and computations of demo_client.py."""
import os
import subprocess
import sys
import tempfile
import unittest

import numpy as np

SCRIPTS = os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "..", "scripts")
sys.path.insert(0, SCRIPTS)
import demo_client  # noqa: E402
from look_at_scan import UPRIGHT, Scan, find_parts, to_quaternion  # noqa: E402
from scan_clouds import make_cloud, read_positions  # noqa: E402


def make_sheet(wide, tall, spacing=0.01):
    return spacing * np.stack(np.meshgrid(np.arange(wide), np.arange(tall), [0.0]), axis=-1).reshape(-1, 3)


class Scans(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def write(self, points, name="scan.xyz"):
        path = os.path.join(self.folder.name, name)
        np.savetxt(path, points)
        return path

    def write_frame(self, points, width, height):
        path = os.path.join(self.folder.name, "frame.pcd")
        with open(path, "w") as stream:
            stream.write("VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH %d\nHEIGHT %d\n"
                         "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS %d\nDATA ascii\n" % (width, height, width * height))
            np.savetxt(stream, points)
        return path

    def test_what_filters_have_marked_is_left_out(self):
        sheet = make_sheet(20, 20)
        path = os.path.join(self.folder.name, "filtered.pcd")
        with open(path, "w") as stream:
            stream.write("VERSION 0.7\nFIELDS x y z removed_by\nSIZE 4 4 4 1\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH 400\nHEIGHT 1\n"
                         "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 400\nDATA ascii\n")
            np.savetxt(stream, np.column_stack([sheet, np.repeat([0, 4], 200)]), fmt="%g")
        rows = Scan(path).rows
        self.assertEqual(len(rows), 400)
        self.assertTrue(np.isfinite(rows[:200]).all())
        self.assertTrue(np.isnan(rows[200:]).all())

    def look_down_at_wall(self):
        """A wall 1 m before a camera with a hole of NaN, 40 x 30 pixels."""
        column, row = np.meshgrid(np.arange(40), np.arange(30))
        points = np.stack([(column - 19.5) / 50, (row - 14.5) / 50, np.ones(column.shape)], axis=-1)
        points[10:15, 10:15] = np.nan
        return points.reshape(-1, 3)

    def test_a_list_of_pixels_gets_its_rows_and_columns_back(self):
        wall = self.look_down_at_wall() * np.random.default_rng(1).uniform(0.9, 1.1, (1200, 1))  # along the lines of sight
        seen = wall[np.isfinite(wall).all(axis=1)]
        scan = Scan(self.write(np.random.default_rng(2).permutation(seen)))
        self.assertEqual((scan.width, scan.height, scan.is_camera), (40, 30, True))
        np.testing.assert_allclose(scan.rows, wall, atol=1e-6)
        self.assertEqual(scan.up, "-y")
        # Off the lines of sight, and with two depths in a pixel, it stays a list.
        for points in (seen + np.random.default_rng(3).normal(scale=0.01, size=seen.shape), np.append(seen, [1.2 * seen[0]], axis=0)):
            scan = Scan(self.write(points))
            self.assertEqual((scan.width, scan.height), (len(points), 1))

    def test_each_axis_comes_up_by_a_rotation(self):
        for up, rows in UPRIGHT.items():
            rotation = np.array(rows, float)
            self.assertEqual(np.linalg.det(rotation), 1.0)
            axis = np.eye(3)["xyz".index(up[-1])] * (-1 if up[0] == "-" else 1)
            self.assertEqual((rotation @ axis).tolist(), [0, 0, 1])
            x, y, z, w = to_quaternion(rotation)
            again = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                              [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                              [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
            np.testing.assert_allclose(again, rotation, atol=1e-12)

    def test_the_largest_part_stands_on_the_ground_as_tall_as_asked_with_its_lowest_tenth_held(self):
        tall = make_sheet(20, 40)[:, [0, 2, 1]]  # upright along z
        far = make_sheet(5, 5) + [1.0, 0.0, -2.0]
        scan = Scan(self.write(np.vstack([far, tall])), height=0.5)
        placed = scan.place()[len(far):]
        np.testing.assert_allclose([placed[:, 2].min(), placed[:, 2].max()], [0.0, 0.5], atol=1e-6)
        np.testing.assert_allclose(placed[:, :2].min(axis=0), -placed[:, :2].max(axis=0), atol=1e-9)
        self.assertIn("2 parts; the largest, of 800 points", " ".join(scan.notices))

    def test_where_few_points_are_low_enough_are_held_all_the_same(self):
        points = np.vstack([make_sheet(40, 20)[:, [0, 2, 1]] + [0.0, 0.0, 0.2], make_sheet(1, 20)[:, [0, 2, 1]]])
        placed = Scan(self.write(points)).place()
        self.assertGreaterEqual(np.count_nonzero(placed[:, 2] <= 0.03 + 1e-9), 0.1 * len(points))
        self.assertLess(placed[:, 2].min(), -0.01)

    def test_up_is_z_or_the_longest_axis_of_what_lies_flat_or_what_is_given(self):
        upright = self.write(make_sheet(20, 40)[:, [0, 2, 1]], "a.xyz")
        flat = self.write(make_sheet(20, 40), "b.xyz")
        self.assertEqual([Scan(upright).up, Scan(flat).up, Scan(flat, "-x").up], ["z", "y", "-x"])
        with self.assertRaisesRegex(ValueError, "one z coordinate"):
            Scan(flat, "z")
        with self.assertRaisesRegex(ValueError, "up is 'up'; accepted: auto, -x"):
            Scan(flat, "up")

    def test_a_cameras_frame_stays_one(self):
        rows = self.look_down_at_wall()
        scan = Scan(self.write_frame(rows, 40, 30))
        self.assertTrue(scan.is_camera)
        self.assertEqual((scan.width, scan.height, scan.up), (40, 30, "-y"))
        message = make_cloud(scan.scale * scan.rows, None, "camera", scan.width)
        self.assertEqual((message.width, message.height, message.is_dense), (40, 30, False))
        np.testing.assert_allclose(read_positions(message), scan.scale * rows, rtol=1e-6)
        # Its top row is at the top, and it is in front of the camera.
        placed = scan.place()
        self.assertAlmostEqual(placed[0, 2], 0.3)
        np.testing.assert_allclose(placed - scan.offset, scan.scale * rows[:, [0, 2, 1]] * [1, 1, -1], atol=1e-9)

    def test_a_grid_of_something_else_is_no_cameras_frame(self):
        self.assertFalse(Scan(self.write_frame(make_sheet(40, 30)[:, [0, 2, 1]] + [0, 0, 1.0], 40, 30)).is_camera)

    def test_what_is_no_surface_is_refused_in_a_sentence(self):
        line = np.outer(np.linspace(0, 1, 200), [1.0, 2.0, 3.0])
        random = np.random.RandomState(1)
        for points, sentence in ((line, "points along a line"),
                                 (random.uniform(size=(2000, 3)) * [0.1, 0.1, 3.0], "points along a line"),
                                 (np.tile(make_sheet(3, 3), (9, 1)), "found 9 finite distinct points; accepted: at least 20"),
                                 (np.full((30, 3), np.nan), "found 0 finite distinct points")):
            with self.assertRaisesRegex(ValueError, sentence):
                Scan(self.write(points))
        angle = np.arange(3000) * 0.7
        hose = np.stack([0.02 * np.cos(angle), 0.02 * np.sin(angle), np.arange(3000) / 3000], axis=1)
        self.assertFalse(Scan(self.write(hose)).is_camera)

    def test_the_demo_refuses_what_it_cannot_take_before_it_installs_or_builds(self):
        with open(os.path.join(self.folder.name, "scan.vtk"), "w"):
            pass
        for name, sentence in (("scan.vtk", "accepted: .ply, .pcd, .obj, .off, .xyz"), ("none.ply", "there is no scan")):
            ended = subprocess.run([os.path.join(SCRIPTS, "demo"), os.path.join(self.folder.name, name)], stdout=subprocess.PIPE,
                                   stderr=subprocess.STDOUT, universal_newlines=True, timeout=20)
            self.assertEqual(ended.returncode, 1)
            self.assertIn(sentence, ended.stdout)
            self.assertNotIn("packages", ended.stdout)

    def test_parts_are_what_more_than_a_few_spacings_are_between(self):
        sheet = make_sheet(20, 20)
        parts = find_parts(np.vstack([sheet, sheet + [0, 0, 0.2], sheet + [0.2, 0, 0]]))
        self.assertEqual(len(set(parts)), 2)
        self.assertEqual(parts[0], parts[-1])
        self.assertNotEqual(parts[0], parts[500])


class Client(unittest.TestCase):
    def test_its_speed_is_simulated_time_over_wall_time(self):
        self.assertAlmostEqual(demo_client.measure_speed([(1.0, 100.0), (1.01, 101.0), (1.06, 110.0)]), 0.006)
        self.assertTrue(np.isnan(demo_client.measure_speed([(1.0, 100.0)])))

    def test_it_pulls_the_highest_point_that_can_move(self):
        points = np.array([[0, 0, 0.0], [0, 0, 0.1], [0, 0, 0.2], [0, 0, 0.3]])
        place, higher = demo_client.choose_handle(points, np.array([True, False, False, True]))
        self.assertEqual((place.tolist(), higher), ([0, 0, 0.2], 1))
        with self.assertRaisesRegex(ValueError, "every simulation point held"):
            demo_client.choose_handle(points, np.ones(4, bool))

    def test_it_lets_go_of_what_comes_too_far(self):
        demo = demo_client.Demo.__new__(demo_client.Demo)
        demo.pulling, demo.pulled, demo.strength, demo.duration, demo.height = True, "", 2.0, 8.0, 0.3
        demo.radius, demo.frame, demo.handle, demo.rest = 0.0, "world", 0, (np.zeros((1, 3)),)
        sent = []
        demo.force = type("Publisher", (), {"publish": lambda self, message: sent.append(message.force.z)})()
        for place in (0.1, 0.5, 0.7, 0.8):
            demo.pull(np.array([place, 0.0, 0.0]), 2.0)
        self.assertEqual([force > 0 for force in sent], [True, True, False])
        self.assertIn("let go after 2.00 s, when it had come 0.7 m", demo.pulled)


if __name__ == "__main__":
    unittest.main()
