#!/usr/bin/env python3
"""Plans: their runs, refused plans, and the names of runs."""
import json
import math
import os
import unittest

from sweep_cases import SweepCase

from deformable_surface_sweep.documents import find_files, merge, read_yaml, to_text  # noqa: E402
from deformable_surface_sweep.errors import SweepError  # noqa: E402
from deformable_surface_sweep.identity import hash_run  # noqa: E402
from deformable_surface_sweep.plan import Plan  # noqa: E402
from deformable_surface_sweep.sampling import draw  # noqa: E402


class Plans(SweepCase):
    def plan(self, text):
        return Plan(self.write("plan.yaml", "scene: scene.yaml\n" + text))

    def test_runs_are_the_product_of_grid_pairs_and_samples_in_order(self):
        plan = self.plan("""
set: {duration: 0.2}
grid: {material.thickness: [1e-3, 2e-3], material.damping: {from: 1, to: 100, steps: 3, scale: log}}
paired: {cloud.points: [100, 400], cloud.size: [[1, 1], [2, 2]]}
random: {samples: 3, keys: {cloud.seed: {integers: [1, 9]}}}
""")
        self.assertEqual(len(plan.runs), 2 * 3 * 2 * 3)
        self.assertEqual([run["material.thickness"] for run in plan.runs[::18]], [0.001, 0.002])
        self.assertEqual([round(run["material.damping"], 9) for run in plan.runs[:18:6]], [1.0, 10.0, 100.0])
        self.assertEqual({(run["cloud.points"], tuple(run["cloud.size"])) for run in plan.runs}, {(100, (1, 1)), (400, (2, 2))})
        self.assertEqual({run["duration"] for run in plan.runs}, {0.2})
        self.assertEqual(plan.varied, ["material.thickness", "material.damping", "cloud.points", "cloud.size", "cloud.seed"])

    def test_numbers_are_those_of_yaml_1_2(self):
        self.write("numbers.yaml", "{a: 1e5, b: 1.0, c: yes, d: .5, e: 010, f: -2, g: 1_0, h: true, i: .inf}")
        self.assertEqual(read_yaml(self.path("numbers.yaml")),
                         {"a": 1e5, "b": 1.0, "c": "yes", "d": 0.5, "e": 10, "f": -2, "g": "1_0", "h": True, "i": float("inf")})

    def test_values_go_to_the_program_as_it_reads_them(self):
        values = {"it's; $(x)": "it's; $(x)", "": "", ".inf": math.inf, "-.inf": -math.inf, ".nan": math.nan, "true": True, "null": None,
                  '[1, .inf, "a: b", {"x": [0.1]}]': [1, math.inf, "a: b", {"x": [0.1]}]}
        for text, value in values.items():
            self.assertEqual(to_text(value), text)

    def test_samples_of_distributions_lie_where_they_say_and_are_always_the_same(self):
        text = """
%s:
  samples: 64
  seed: 3
  keys:
    material.young_modulus: {log_uniform: [1e4, 1e6]}
    material.damping: {normal: [5, 1]}
    material.thickness: {uniform: [0.001, 0.002]}
    cloud.seed: {choice: [1, 4]}
"""
        for method in ("random", "latin_hypercube", "sobol"):
            runs = self.plan(text % method).runs
            self.assertEqual(runs, self.plan(text % method).runs)
            stiff = [run["material.young_modulus"] for run in runs]
            self.assertTrue(1e4 <= min(stiff) and max(stiff) <= 1e6)
            self.assertAlmostEqual(sum(value < 1e5 for value in stiff) / 64, 0.5, delta=0.2)
            self.assertAlmostEqual(sum(run["material.damping"] for run in runs) / 64, 5.0, delta=0.5)
            self.assertEqual({run["cloud.seed"] for run in runs}, {1, 4})

    def test_a_latin_hypercube_has_one_sample_in_each_stratum_of_each_key(self):
        for column in draw("latin_hypercube", 50, 1, ["a", "b"]).T:
            self.assertEqual(sorted(int(50 * u) for u in column), list(range(50)))

    def test_more_random_or_sobol_samples_begin_with_the_fewer(self):
        for method in ("random", "sobol"):
            few, many = draw(method, 20, 7, ["a", "b"]), draw(method, 90, 7, ["a", "b"])
            self.assertEqual(few.tolist(), many[:20].tolist())
        self.assertEqual(draw("random", 9, 7, ["a"])[:, 0].tolist(), draw("random", 9, 7, ["b", "a"])[:, 1].tolist())

    def test_clouds_by_pattern_are_a_value_each_named_from_the_plan(self):
        for name in ("b.ply", "a.ply", "c.txt"):
            self.write(name, "")
        runs = self.plan("clouds: '*.ply'\n").runs
        self.assertEqual([os.path.basename(run["cloud.file"]) for run in runs], ["a.ply", "b.ply"])
        self.assertEqual({run["cloud.shape"] for run in runs}, {"none"})

    def test_what_is_wrong_is_refused_with_what_was_found_and_what_is_accepted(self):
        cases = {
            "grids: {a: [1]}": "found the key 'grids'; accepted: scene, bag",
            "grid: {a: 3}": "grid: a: found 3; accepted: a list of values",
            "grid: {a: []}": "grid: a: found",
            "grid: {a: {from: 0, to: 1, steps: 3, scale: log}}": "A and B above 0",
            "grid: {a: {from: 0, to: .nan, steps: 3}}": "accepted: a list of values",
            "paired: {a: [1, 2], b: [1]}": "found lists of 2 (a), 1 (b) values; accepted: lists of one length",
            "random: {samples: 0, keys: {a: {uniform: [0, 1]}}}": "found samples: 0; accepted: a whole number from 1",
            "random: {samples: 3, seed: x, keys: {a: {uniform: [0, 1]}}}": "found seed: x",
            "random: {samples: 3, keys: {a: {uniform: [1, 0]}}}": "accepted: uniform: [A, B]",
            "random: {samples: 3, keys: {a: {log_uniform: [0, 1]}}}": "0 < A < B",
            "sobol: {samples: 3}": "found keys: None",
            "grid: {a: [1]}\nset: {a: 1}": "found the key 'a' twice",
            "grid: {'pins[0].box': [1]}": "found the key 'pins[0].box'; accepted: dotted paths of the scene, as in material.thickness or",
            "grid: {a=b: [1]}": "found the key 'a=b'; accepted",
            "grid: {material: {damping: [1]}}": "keys below keys are written as dotted paths, here material.damping",
            "keep:": "keep: found nothing; accepted: a map of keys",
            "grid: {threads: [1]}": "found the key 'threads'",
            "grid: {pins.3.box: [1]}": "found '3' as the place in a list of 1",
            "grid: {duration.x: [1]}": "found 'x' below a value",
            "clouds: '*.nothing'": "found no file for",
            "keep: {statistics: {max_speed: most}}": "found most; accepted: last, max, mean, min, or a time in s",
            "keep: {wrenches: {ball: max}}": "accepted: ID.COMPONENT",
            "keep: {final: 1}": "keep: final: found 1; accepted: true or false",
            "keep: {frames: -1}": "accepted: a rate in Hz",
            "keep: {finals: true}": "found the key 'finals'",
            "keep: {measure: [min_z, min_z]}": "keep: found the column 'min_z' twice; accepted: once",
            "keep: {statistics: {max_speed: [max, 0.1, 0.1]}}": "keep: found the column 'max_speed.at_0.1' twice",
            "grid: {}": "grid: found no key; accepted: at least one",
            "paired: {}": "paired: found no key; accepted: at least one",
            "timeout: 0": "timeout: found 0; accepted: a number above 0",
            "topics: {cloud_in: /a}": "topics: found without bag",
            "grid: {a: [1], a: [2]}": "found the key 'a' twice",
            "grid: [": "no YAML",
            "grid: {a: {from: 1, to: 2, steps: 9999999}, b: {from: 1, to: 2, steps: 99}}": "accepted: at most 1e+07"}
        for text, sentence in cases.items():
            with self.assertRaises(SweepError, msg=text) as caught:
                self.plan(text)
            self.assertIn(sentence, str(caught.exception))
            self.assertNotIn("\n", str(caught.exception))
        for text in ("", "scene: none.yaml\n", "scene: 3\n", "scene: package://no_such_package/scene.yaml\n"):
            with self.assertRaises(SweepError):
                Plan(self.write("plan.yaml", text))

    def test_the_name_of_a_run_follows_from_everything_that_its_result_depends_on_and_from_nothing_else(self):
        plan = self.plan("grid: {material.thickness: [0.001, 0.002]}")
        keep, args = plan.keep.describe(), ("", {}, {}, "version")
        first, second = (hash_run(merge(plan.scene, run), *args) for run in plan.runs)
        self.assertNotEqual(first, second)
        # The origin of a value does not matter.
        fixed = self.plan("set: {material.thickness: 0.001}")
        self.assertEqual(first, hash_run(merge(fixed.scene, fixed.runs[0]), *args))
        self.assertEqual(first, hash_run(dict(merge(plan.scene, plan.runs[0]), threads=3), *args))
        for other in (("bag", {}, {}, "version"), ("", {"cloud_in": "/a"}, {}, "version"), ("", {}, keep, "version"), ("", {}, {}, "other")):
            self.assertNotEqual(first, hash_run(merge(plan.scene, plan.runs[0]), *other))

    def test_files_that_a_scene_names_are_found_at_any_depth(self):
        scene = {"cloud": {"file": "a.ply"}, "tools": [{"shape": {"mesh": {"file": "b.stl"}}}], "robot": {"file": ""}}
        self.assertEqual(dict(find_files(scene)), {"cloud.file": "a.ply", "tools.0.shape.mesh.file": "b.stl"})
        json.dumps(scene)


if __name__ == "__main__":
    unittest.main()
