#!/usr/bin/env python3
"""Results on the disk and the numbers of a run: no incomplete results, no duplicates."""
import importlib.util
import math
import os
import sys
import threading
import types
import unittest
import unittest.mock

from sweep_cases import SweepCase

from deformable_surface_sweep.errors import SweepError  # noqa: E402
from deformable_surface_sweep.identity import hash_bytes  # noqa: E402
from deformable_surface_sweep.plan import Plan  # noqa: E402
from deformable_surface_sweep.reduce import reduce_column, reduce_statistics, reduce_wrenches  # noqa: E402
from deformable_surface_sweep.simulator import Result  # noqa: E402
from deformable_surface_sweep.store import Store, write_whole  # noqa: E402
from deformable_surface_sweep.table import write_table  # noqa: E402


def make_result(value, data=b""):
    files = {"final": [(hash_bytes(data) + ".ply", data)]} if data else {}
    return Result("done", "", {"min_z": value}, files, "abc", 0.1)


class Stores(SweepCase):
    def test_what_was_added_is_read_again_but_for_a_line_that_was_cut_off(self):
        store = Store(self.path("out"))
        first = store.add("a", make_result(0.1 + 0.2, b"cloud"))
        store.add("b", make_result(math.nan))
        store.close()
        folder = os.path.join(self.path("out"), "runs")
        with open(os.path.join(folder, os.listdir(folder)[0]), "a") as stream:
            stream.write('{"run": "c", "status": "do')
        with open(os.path.join(folder, "torn.jsonl"), "wb") as stream:
            stream.write(b"\xff\x00\n")
        records = Store(self.path("out")).read()
        self.assertEqual(records["a"], first)
        self.assertEqual(set(records), {"a", "b"})
        self.assertTrue(math.isnan(records["b"]["values"]["min_z"]))

    def test_what_cannot_be_written_is_said_in_a_sentence(self):
        self.write("out", "a file")
        with self.assertRaisesRegex(SweepError, r"out/table.csv: cannot be written \(.*\); accepted: a folder with room on its disk"):
            write_whole(self.path("out/table.csv"), b"")

    def test_equal_files_are_kept_once_under_the_hash_of_what_is_in_them(self):
        store = Store(self.path("out"))
        names = [store.add(run, make_result(0.0, b"cloud"))["files"]["final"] for run in "ab"]
        store.close()
        self.assertEqual(names[0], names[1])
        with open(os.path.join(self.path("out"), names[0][0]), "rb") as stream:
            self.assertEqual(hash_bytes(stream.read()) + ".ply", os.path.basename(names[0][0]))

    def test_two_writers_at_once_spoil_nothing(self):
        def write(writer):
            store = Store(self.path("out"))
            for i in range(200):
                store.add("run%d" % i, make_result(float(i), b"%d" % (i % 7)))
                write_whole(self.path("out/table.csv"), b"x" * 1000 * (writer + 1))
            store.close()

        threads = [threading.Thread(target=write, args=(writer,)) for writer in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        records = Store(self.path("out")).read()
        self.assertEqual({name: record["values"]["min_z"] for name, record in records.items()}, {"run%d" % i: float(i) for i in range(200)})
        self.assertIn(os.path.getsize(self.path("out/table.csv")), (1000, 2000))
        left = [name for _, _, files in os.walk(self.path("out")) for name in files if name.endswith(".partial")]
        self.assertEqual(left, [])

    def test_the_table_has_a_row_a_run_in_the_order_of_the_plan_with_all_digits(self):
        plan = Plan(self.write("plan.yaml", "scene: scene.yaml\ngrid: {cloud.size: [[1, 1], [2, 2], [3, 3]]}\nkeep: {measure: [min_z], final: true}\n"))
        store = Store(self.path("out"))
        records = {"c": store.add("c", make_result(0.1 + 0.2, b"cloud")),
                   "a": store.add("a", Result("refused", "found 1, 2", {}, {}, "", 0.0))}
        store.close()
        write_table(plan, ["a", "b", "c"], records, self.path("out"))
        rows = self.table()
        self.assertEqual([row["run"] for row in rows], ["a", "c"])
        self.assertEqual(rows[0]["problem"], "found 1, 2")
        self.assertEqual(rows[1]["cloud.size"], "[3, 3]")
        self.assertEqual(float(rows[1]["min_z"]), 0.1 + 0.2)
        self.assertTrue(os.path.exists(os.path.join(self.path("out"), rows[1]["final"])))

    @unittest.skipUnless(importlib.util.find_spec("pyarrow"), "no pyarrow here")
    def test_the_table_in_parquet_is_that_in_csv(self):
        import pandas
        plan = Plan(self.write("plan.yaml", "scene: scene.yaml\ngrid: {duration: [0.1, 0.2]}\nkeep: {measure: [min_z]}\n"))
        store = Store(self.path("out"))
        records = {"a": store.add("a", make_result(0.1 + 0.2)), "b": store.add("b", Result("refused", "found 1, 2", {}, {}, "", 0.0))}
        store.close()
        csv, parquet = write_table(plan, ["a", "b"], records, self.path("out"))
        pandas.testing.assert_frame_equal(pandas.read_csv(csv), pandas.read_parquet(parquet))


    def test_what_is_handed_to_pyarrow_is_the_table(self):
        """With a stand-in, because Debian has no pyarrow. It checks the data passed to pyarrow, not that a file can be read."""
        plan = Plan(self.write("plan.yaml", "scene: scene.yaml\ngrid: {duration: [0.1, 0.2], model: [mass_spring]}\nkeep: {measure: [min_z]}\n"))
        store = Store(self.path("out"))
        records = {"a": store.add("a", make_result(0.1 + 0.2)), "b": store.add("b", Result("refused", "found 1, 2", {}, {}, "", 0.0))}
        store.close()
        handed = {}

        class Buffer:
            def getvalue(self):
                return self

            def to_pybytes(self):
                return b"what was written"

        parquet = types.ModuleType("pyarrow.parquet")
        parquet.write_table = lambda table, buffer: handed.update(table)
        pyarrow = types.ModuleType("pyarrow")
        pyarrow.parquet, pyarrow.BufferOutputStream, pyarrow.table = parquet, Buffer, dict
        pyarrow.float64, pyarrow.string, pyarrow.array = lambda: "number", lambda: "text", lambda cells, kind: (kind, cells)
        with unittest.mock.patch.dict(sys.modules, {"pyarrow": pyarrow, "pyarrow.parquet": parquet}):
            written = write_table(plan, ["a", "b"], records, self.path("out"))
        with open(written[1], "rb") as stream:
            self.assertEqual(stream.read(), b"what was written")
        self.assertEqual(list(handed), ["run", "duration", "model", "status", "problem", "min_z", "hash"])
        self.assertEqual(handed["duration"], ("number", [0.1, 0.2]))
        self.assertEqual(handed["model"], ("text", ["mass_spring"] * 2))
        self.assertEqual(handed["problem"], ("text", [None, "found 1, 2"]))
        self.assertEqual(handed["min_z"][0], "number")
        self.assertEqual(handed["min_z"][1][0], 0.1 + 0.2)
        self.assertTrue(math.isnan(handed["min_z"][1][1]))


class Reductions(SweepCase):
    def test_a_column_becomes_its_last_largest_mean_or_least_value_or_that_at_a_time(self):
        times, values = [0.1, 0.2, 0.30000000000000004], [3.0, 1.0, 2.0]
        ways = {"last": 2.0, "max": 3.0, "mean": 2.0, "min": 1.0, 0.3: 2.0, 0.15: 1.0, 0.0: 3.0}
        self.assertEqual({way: reduce_column(times, values, way) for way in ways}, ways)
        self.assertTrue(math.isnan(reduce_column(times, values, 0.31)))
        self.assertTrue(math.isnan(reduce_column([0.1, 0.2], [1.0, math.nan], "max")))
        self.assertTrue(math.isnan(reduce_column([], [], "mean")))

    def test_columns_and_ids_that_there_are_not_are_refused_with_those_that_there_are(self):
        path = self.write("s.csv", "simulation_time,id,force_z\n0.1,ball,1\n0.1,pins[0],5\n0.2,ball,3\n")
        self.assertEqual(reduce_wrenches(path, {"ball.force_z": ["max", 0.1]}), {"ball.force_z.max": 3.0, "ball.force_z.at_0.1": 1.0})
        with self.assertRaisesRegex(SweepError, "found 'bowl'; accepted: ball, pins"):
            reduce_wrenches(path, {"bowl.force_z": ["max"]})
        with self.assertRaisesRegex(SweepError, "found 'speed'; accepted: simulation_time, id, force_z"):
            reduce_statistics(path, {"speed": ["max"]})


if __name__ == "__main__":
    unittest.main()
