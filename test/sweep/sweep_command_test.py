#!/usr/bin/env python3
"""The command in this process, without a cluster."""
import contextlib
import unittest
import unittest.mock

from sweep_cases import STUB, STUB_PLAN, SweepCase

from deformable_surface_sweep import command  # noqa: E402
from deformable_surface_sweep.simulator import Result  # noqa: E402


class FakeEngine:
    """Passes on a result for each run."""

    def __init__(self, *_):
        pass

    def run(self, todo, take):
        for run in todo:
            take(run.name, Result("done", "", {"min_z": 1.0}, {}, "abc", 0.1))


class Commands(SweepCase):
    def test_an_interrupt_just_after_a_result_was_stored_leaves_it_in_the_table(self):
        arguments = [self.write("plan.yaml", STUB_PLAN % (0.0, 3, 3)), "--out", self.path("out"), "--simulate", STUB, "--quiet"]
        with unittest.mock.patch.multiple(command, Engine=FakeEngine, check_plan=lambda sweep: None,
                                          open_cluster=lambda *_: contextlib.nullcontext((None, True))), \
                unittest.mock.patch.object(command.Store, "sync", side_effect=[KeyboardInterrupt, None]):
            with self.assertRaises(KeyboardInterrupt):
                command.run_sweep(command.parse_arguments(arguments))
        self.assertEqual((self.count_runs(), len(self.table())), (1, 1))


if __name__ == "__main__":
    unittest.main()
