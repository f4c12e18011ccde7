#!/usr/bin/env python3
"""Sweeps on processes of this machine, with `simulate`: the table, runs that are repeated, and equal bits everywhere."""
import os
import signal
import unittest

from sweep_cases import STUB, STUB_PLAN, SweepCase, require_dask

PLAN = """
scene: scene.yaml
grid: {material.thickness: [0.001, 0.002, -1.0], material.damping: [1, 2%s]}
keep:
  statistics: {max_speed: [max, last]}
  measure: [min_z]
  final: true
"""


class LocalSweeps(SweepCase):
    def test_a_refused_run_is_a_row_and_the_bits_are_those_of_any_number_of_workers(self):
        self.sweep(PLAN % "", "--workers", "2", status=1)
        self.assertEqual(sorted(os.listdir(self.folder)), ["out", "plan.yaml", "scene.yaml"])
        rows = self.table()
        self.assertEqual([row["status"] for row in rows], ["done"] * 4 + ["refused"] * 2)
        self.assertEqual(rows[5]["problem"], "material.thickness: found -1.0; accepted: 1e-10 to 1000 (m)")
        self.assertTrue(all(os.path.exists(os.path.join(self.path("out"), row["final"])) for row in rows[:4]))
        self.assertEqual(len({row["hash"] for row in rows[:4]}), 4)
        self.sweep(PLAN % "", "--workers", "1", "--quiet", out="other", status=1)
        self.assertEqual(self.text("out"), self.text("other"))
        # A plan with more values runs only the new ones.
        said = self.sweep(PLAN % ", 3", status=1)
        self.assertIn("6 of 9 runs are there from before", said)
        self.assertEqual(self.count_runs(), 9)
        self.assertEqual([row for row in self.table() if row["material.damping"] != "3"], rows)
        # A plan with fewer values shows only its own runs.
        self.assertIn("6 of 6 runs are there from before", self.sweep(PLAN % "", status=1))
        self.assertEqual(self.count_runs(), 9)
        self.assertEqual(self.table(), rows)

    def test_clouds_go_by_what_is_in_them(self):
        for name, shift in (("a.xyz", 0.0), ("b.xyz", 0.0), ("c.xyz", 0.5)):
            self.write(name, "".join("%g %g %g\n" % (0.1 * x, 0.1 * y, shift) for x in range(8) for y in range(8)))
        self.write("scene.yaml", "model: mass_spring\nduration: 0.05\n")
        said = self.sweep("scene: scene.yaml\nclouds: '*.xyz'\nkeep: {measure: [min_z]}\n")
        self.assertEqual(self.count_runs(), 2, said)
        rows = self.table()
        self.assertEqual(rows[0]["hash"], rows[1]["hash"])
        self.assertNotEqual(rows[0]["min_z"], rows[2]["min_z"])

    def test_an_interrupted_sweep_goes_on_and_its_table_is_that_of_one_that_was_not(self):
        plan = STUB_PLAN % (0.02, 60, 60)
        process = self.start(plan, "--workers", "2", "--simulate", STUB)
        self.await_runs(10)
        process.send_signal(signal.SIGTERM)
        said, _ = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130, said)
        self.assertIn("interrupted; finished runs are kept", said)
        kept = self.count_runs()
        self.assertEqual(len(self.table()), kept)
        self.assertLess(kept, 60)
        # A killed sweep, too.
        process = self.start(plan, "--workers", "2", "--simulate", STUB)
        self.await_runs(kept + 10)
        process.kill()
        process.communicate()
        self.sweep(plan, "--workers", "2", "--simulate", STUB)
        self.assertEqual(self.count_runs(), 60)
        self.sweep(plan, "--workers", "1", "--simulate", STUB, out="other")
        self.assertEqual(self.text("out"), self.text("other"))

    def test_runs_that_failed_are_run_again_where_that_is_asked_for(self):
        plan = "scene: scene.yaml\ngrid: {a: [1], stub.status: ['0', '3', signal 9]}\n"
        self.sweep(plan, "--simulate", STUB, status=1)
        self.assertEqual([row["status"] for row in self.table()], ["done", "failed", "failed"])
        self.assertIn("signal 9 (SIGKILL)", self.table()[2]["problem"])
        self.assertIn("3 of 3 runs are there from before", self.sweep(plan, "--simulate", STUB, status=1))
        self.assertIn("1 of 3 runs are there from before", self.sweep(plan, "--simulate", STUB, "--retry", status=1))

    def test_a_dry_run_says_how_many_runs_how_long_and_how_many_bytes_and_makes_nothing(self):
        said = self.sweep(PLAN % "", "--dry_run")
        self.assertIn("6 runs, 6 of them to be run\n", said)
        self.assertRegex(said, r"s a run, by 3 of them: \d+ s with \d+ workers\n[0-9.]+ kB of files\nrefused: material.thickness: found -1")
        self.assertFalse(os.path.exists(self.path("out")))

    def test_the_command_line_and_the_plan_are_refused_in_sentences(self):
        self.assertIn("--workers: found '0'; accepted: a number above 0", self.sweep(PLAN % "", "--workers", "0", status=2))
        self.assertIn("found without --workers", self.sweep(PLAN % "", "--slurm", "", status=2))
        self.assertIn("--simulate: found '/none'", self.sweep(PLAN % "", "--simulate", "/none", status=2))
        self.assertIn("sweep: grid: a: found 1; accepted: a list", self.sweep("scene: scene.yaml\ngrid: {a: 1}\n", status=2))
        self.assertIn("sweep: found no scheduler at tcp://127.0.0.1:9", self.sweep(PLAN % "", "--scheduler", "tcp://127.0.0.1:9", status=2))
        self.assertIn("cannot be made", self.sweep(PLAN % "", out="plan.yaml", status=2))
        self.write("dask.py", "raise ImportError('as if there were none')\n")
        self.assertIn("sweep: found no Dask", self.sweep(PLAN % "", status=2, environment=dict(os.environ, PYTHONPATH=self.folder)))

    def test_names_that_no_run_has_are_refused_before_any_run(self):
        cases = {"keep: {statistics: {speed: max}}": "keep: statistics: found 'speed'; accepted: simulation_time, step",
                 "keep: {measure: [minz]}": "keep: measure: found 'minz'; the nearest known one is min_z",
                 "keep: {wrenches: {ball.force_z: max}}": "keep: wrenches: found 'ball'; accepted: pins[0]",
                 "grid: {material.thicknes: [0.001]}": "found the key 'material.thicknes' in the plan, which scenes have not; "
                                                       "the nearest known one is material.thickness",
                 "grid: {pins.0.paths: [1]}": "found the key 'pins[0].paths' in the plan",
                 "set: {materials.thickness: 0.001}": "found the key 'materials' in the plan"}
        for text, sentence in cases.items():
            self.assertIn("sweep: " + sentence, self.sweep("scene: scene.yaml\n%s\n" % text, status=2))
        self.assertFalse(os.path.exists(self.path("out")))

    def test_a_wrench_that_some_runs_have_is_refused_in_the_others(self):
        plan = "scene: scene.yaml\ngrid: {pins: [[], [{sphere: {center: [0, 0, 0], radius: 0.3}}]]}\nkeep: {wrenches: {'pins[0].force_z': last}}\n"
        self.sweep(plan, "--workers", "1", status=1)
        self.assertEqual([row["status"] for row in self.table()], ["refused", "done"])
        self.assertIn("keep: wrenches: found 'pins[0]'; accepted: none", self.table()[0]["problem"])


if __name__ == "__main__":
    require_dask()
    unittest.main()
