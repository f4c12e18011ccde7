#!/usr/bin/env python3
"""A sweep whose workers Slurm starts, on two nodes that are namespaces of this machine. Needs root, namespaces, slurmctld, slurmd and
munged; skipped (status 77) without."""
import os
import sys
import tempfile
import unittest

from slurm_machines import Missing, SlurmMachines
from sweep_cases import PATIENCE, SKIPPED, STUB, STUB_PLAN, SweepCase, require_dask


class SlurmSweeps(SweepCase):
    machines = None

    def start(self, plan, *options, out="out"):
        os.chmod(self.folder, 0o755)
        return super().start(plan, *options, out=out, before=self.machines.on("control"), environment=self.machines.environment())

    def test_workers_on_two_nodes_give_the_table_of_one_machine_and_end_with_the_sweep(self):
        plan = STUB_PLAN % (0.05, 60, 60)
        process = self.start(plan, "--simulate", STUB, "--slurm=--partition=all --time=10", "--workers", "2")
        self.await_runs(20)
        self.assertEqual(sorted(self.machines.command("squeue", "-h", "-t", "running", "-o", "%N").split()), ["node1", "node2"])
        said, _ = process.communicate(timeout=PATIENCE)
        self.assertEqual(process.returncode, 0, said)
        self.assertEqual([float(row["min_z"]) for row in self.table()], [float(a * a) for a in range(1, 61)])
        self.machines.await_that("an empty queue", lambda: not self.machines.command("squeue", "-h").strip())

    def test_what_slurm_refuses_is_said(self):
        said = self.sweep(STUB_PLAN % (0.05, 2, 2), "--simulate", STUB, "--slurm=--partition=none", "--workers", "2", status=2)
        self.assertIn("sweep: --slurm: sbatch refused the job: sbatch: error: invalid partition specified: none", said)


if __name__ == "__main__":
    require_dask()
    try:
        with tempfile.TemporaryDirectory() as folder, SlurmMachines(folder) as SlurmSweeps.machines:
            unittest.main()
    except Missing as error:
        print("skipped: no cluster of Slurm can be made here (%s)" % error)
        sys.exit(SKIPPED)
