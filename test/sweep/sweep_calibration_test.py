#!/usr/bin/env python3
"""The calibration by the engine of sweeps, with a stand-in for `benchmark_core`: each seed runs once, on any worker."""
import os
import subprocess
import sys
import unittest

from sweep_cases import PATIENCE, SweepCase, make_environment, require_dask

STAND_IN = """#!/bin/sh
# --calibration --scenes SEED 1 --output FOLDER
echo "$3" >> %s
[ "$3" != 13 ] || { echo "scene 13: pins[0]: holds no point" >&2; exit 0; }
printf 'seed,scene,look\\n%%s,sheet,1\\n%%s,sheet,2\\n' "$3" "$3" > "$6/calibration_scenes.csv"
"""


class Calibrations(SweepCase):
    def calibrate(self, first, count, *options, code=0):
        command = [sys.executable, "-m", "deformable_surface_sweep.calibration", self.path("program"), self.folder, str(first), str(count)]
        done = subprocess.run(command + list(options), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True,
                              env=make_environment(), timeout=PATIENCE)
        self.assertEqual(done.returncode, code, done.stdout)
        return done.stdout

    def text_of(self, name):
        with open(self.path(name)) as stream:
            return stream.read()

    def test_every_seed_is_run_once_and_the_table_is_in_their_order(self):
        os.chmod(self.write("program", STAND_IN % self.path("asked")), 0o755)
        said = self.calibrate(10, 5, "--workers", "2")
        self.assertIn("seed13: scene 13: pins[0]: holds no point", said)
        rows = ["%d,sheet,%d\n" % (seed, look) for seed in (10, 11, 12, 14) for look in (1, 2)]
        self.assertEqual(self.text_of("calibration_scenes.csv"), "".join(["seed,scene,look\n"] + rows))
        # It continues where it was stopped.
        self.write("calibration_scenes.csv", "".join(["seed,scene,look\n"] + rows[:4]))
        self.calibrate(10, 3)
        self.assertEqual(sorted(self.text_of("asked").split()), ["10", "11", "12", "12", "13", "14"])
        self.assertEqual(self.text_of("calibration_scenes.csv"), "".join(["seed,scene,look\n"] + rows[:6]))

    def test_a_table_with_other_columns_stays_as_it_is(self):
        os.chmod(self.write("program", STAND_IN % self.path("asked")), 0o755)
        old = "seed,scene\n10,sheet\n"
        self.write("calibration_scenes.csv", old)
        said = self.calibrate(10, 3, code=1)
        self.assertEqual(said.strip().splitlines()[-1],
                         "calibration: %s: found the columns 'seed,scene'; accepted: 'seed,scene,look', or another folder than that "
                         "of another version's scenes" % os.path.join(self.folder, "calibration_scenes.csv"))
        self.assertEqual(self.text_of("calibration_scenes.csv"), old)


if __name__ == "__main__":
    require_dask()
    unittest.main()
