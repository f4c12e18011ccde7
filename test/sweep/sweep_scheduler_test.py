#!/usr/bin/env python3
"""Sweeps on a running scheduler with workers on loopback: runs whose worker dies, lacks the package or has another simulate."""
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
import unittest

from sweep_cases import PATIENCE, STUB, STUB_PLAN, SweepCase, make_environment, require_dask


class SchedulerSweeps(SweepCase):
    def setUp(self):
        super().setUp()
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.address = "tcp://127.0.0.1:%d" % free.getsockname()[1]
        self.scheduler = self.run_dask("scheduler", "--host", "127.0.0.1", "--port", self.address.rsplit(":", 1)[1], "--scheduler-file",
                                       self.path("scheduler.json"))
        begin = time.monotonic()
        while not os.path.exists(self.path("scheduler.json")):
            self.assertLess(time.monotonic() - begin, PATIENCE)
            time.sleep(0.05)

    def run_dask(self, what, *arguments, environment=None):
        process = subprocess.Popen([sys.executable, "-m", "distributed.cli.dask_" + what, "--no-dashboard"] + list(arguments),
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment or make_environment(),
                                   cwd=self.folder)
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        return process

    def start_worker(self, environment=None):
        return self.run_dask("worker", self.address, "--nthreads", "1", "--no-nanny", environment=environment)

    def test_no_run_is_lost_or_run_twice_for_long_when_one_of_two_workers_is_killed(self):
        workers = [self.start_worker(), self.start_worker()]
        plan = STUB_PLAN % (0.05, 100, 100)
        plan = plan.replace("set: {", "set: {stub.log: %s, " % self.path("log"))
        process = self.start(plan, "--simulate", STUB, "--scheduler", self.address)
        self.await_runs(20)
        workers[0].kill()
        said, _ = process.communicate(timeout=PATIENCE)
        self.assertEqual(process.returncode, 0, said)
        self.assertEqual([float(row["min_z"]) for row in self.table()], [float(a * a) for a in range(1, 101)])
        with open(self.path("log")) as stream:
            ran = stream.read().split()
        self.assertEqual(len(set(ran)), 100)
        self.assertLess(len(ran), 100 + 60)  # what the dead one had and had not handed on
        # The same bits as without workers.
        self.sweep(plan, "--simulate", STUB, "--workers", "1", out="other")
        self.assertEqual(self.text("out"), self.text("other"))

    def test_scenes_and_clouds_travel_to_workers(self):
        self.start_worker()
        self.write("a.xyz", "".join("%g %g 0\n" % (0.1 * x, 0.1 * y) for x in range(8) for y in range(8)))
        self.write("scene.yaml", "model: mass_spring\nduration: 0.05\n")
        plan = "scene: scene.yaml\nclouds: a.xyz\ngrid: {material.thickness: [0.001, 0.002]}\nkeep: {measure: [min_z], final: true}\n"
        self.sweep(plan, "--scheduler-file", self.path("scheduler.json"))
        self.sweep(plan, "--workers", "1", out="other")
        self.assertEqual(self.text("out"), self.text("other"))

    def test_a_worker_without_the_package_is_named_and_not_used(self):
        bare = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
        self.start_worker(environment=bare)
        plan = STUB_PLAN % (0.01, 10, 10)
        said = self.sweep(plan, "--simulate", STUB, "--scheduler", self.address, status=2)
        self.assertIn("found no package deformable_surface_sweep; accepted: workers started after `source setup.bash`", said)
        self.start_worker()
        process = self.start(plan, "--simulate", STUB, "--scheduler", self.address)
        said, _ = process.communicate(timeout=PATIENCE)
        while process.returncode == 2 and "no worker that can run this" in said:  # the good one is on its way
            process = self.start(plan, "--simulate", STUB, "--scheduler", self.address)
            said, _ = process.communicate(timeout=PATIENCE)
        self.assertEqual(process.returncode, 0, said)
        self.assertIn("is not used: found no package", said)

    def test_a_worker_with_another_simulate_is_not_used(self):
        program = self.path("other/lib/deformable_surface/simulate")
        os.makedirs(os.path.dirname(program))
        shutil.copy(STUB, program)
        self.start_worker(environment=dict(make_environment(), CMAKE_PREFIX_PATH=self.path("other")))
        said = self.sweep("scene: scene.yaml\n", "--scheduler", self.address, status=2)
        self.assertIn("found simulate of another build", said)

    def test_what_was_finished_survives_the_scheduler(self):
        self.start_worker()
        plan = STUB_PLAN % (0.05, 60, 60)
        process = self.start(plan, "--simulate", STUB, "--scheduler", self.address)
        self.await_runs(10)
        self.scheduler.send_signal(signal.SIGKILL)
        said, _ = process.communicate(timeout=PATIENCE)
        self.assertEqual(process.returncode, 2, said)
        self.assertIn("sweep: lost the scheduler; finished runs are kept", said)
        kept = self.count_runs()
        self.assertEqual(len(self.table()), kept)
        self.assertIn("%d of 60 runs are there from before" % kept, self.sweep(plan, "--simulate", STUB))
        self.assertEqual(self.count_runs(), 60)


if __name__ == "__main__":
    require_dask()
    unittest.main()
