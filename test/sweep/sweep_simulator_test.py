#!/usr/bin/env python3
"""Runs of `simulate`, one after another in one process."""
import os
import unittest

from sweep_cases import STUB, SweepCase

from deformable_surface_sweep.identity import find_program, find_version  # noqa: E402
from deformable_surface_sweep.simulator import Simulator  # noqa: E402

KEEP = {"statistics": {}, "wrenches": {}, "measure": [], "final": False, "frames": 0, "bag": False}


class Simulators(SweepCase):
    def setUp(self):
        super().setUp()
        self.simulator = Simulator(find_program())
        self.addCleanup(self.simulator.close)

    def run_scene(self, *assignments, timeout=60.0, **keep):
        return self.simulator.run(self.path("scene.yaml"), list(assignments), "", {}, dict(KEEP, **keep), timeout)

    def test_it_keeps_what_was_asked_for(self):
        result = self.run_scene(statistics={"max_speed": ["max", 0.05]}, wrenches={"pins[0].force_z": ["last"]}, measure=["min_z"],
                                final=True, frames=50, bag=True)
        self.assertEqual((result.status, result.problem), ("done", ""))
        self.assertEqual(set(result.values), {"max_speed.max", "max_speed.at_0.05", "pins[0].force_z.last", "min_z"})
        self.assertLess(result.values["min_z"], 0.0)
        self.assertEqual({name: len(files) for name, files in result.files.items()}, {"final": 1, "frames": 6, "bag": 1})
        self.assertTrue(result.files["final"][0][1].startswith(b"ply"))
        self.assertEqual(len(result.hash), 16)

    def test_it_goes_on_after_runs_that_are_refused_fail_or_take_too_long(self):
        refused = self.run_scene("material.thickness=-1")
        self.assertEqual(refused.status, "refused")
        self.assertEqual(refused.problem, "material.thickness: found -1; accepted: 1e-10 to 1000 (m)")
        slow = self.run_scene("duration=10000", timeout=0.3)
        self.assertEqual((slow.status, slow.problem), ("timed out", "found no end after 0.3 s; accepted: runs within the plan's timeout"))
        broken = self.run_scene("integrator={type: explicit_euler, time_step: 1.0}", "material={young_modulus: 1.0e9}", "duration=1000")
        self.assertEqual(broken.status, "failed")
        self.assertIn("; the state before it is kept", broken.problem)
        wrong = self.run_scene(statistics={"speed": ["max"]})
        self.assertEqual(wrong.status, "refused")
        self.assertIn("found 'speed'; accepted: simulation_time", wrong.problem)
        self.assertEqual(self.run_scene().status, "done")

    def test_quantities_that_there_are_not_are_said(self):
        result = self.run_scene(measure=["volume_ratio"])
        self.assertEqual((result.status, result.values), ("done", {}))
        self.assertIn("volume_ratio: found a surface with a boundary", result.problem)

    def test_a_program_that_is_no_server_fails_its_runs(self):
        for program in ("/bin/false", os.path.join(self.folder, "none")):
            self.simulator.program = program
            self.assertEqual(self.run_scene().status, "failed")

    def test_the_version_is_another_for_another_program(self):
        version = find_version(find_program())
        self.assertNotEqual(version, find_version(STUB))


if __name__ == "__main__":
    unittest.main()
