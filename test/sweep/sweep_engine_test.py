#!/usr/bin/env python3
"""The tasks that the engine sends to a cluster, with a client that only records them."""
import unittest

from sweep_cases import SweepCase

from deformable_surface_sweep.engine import MOST_SENT, Engine  # noqa: E402


class Client:
    def __init__(self):
        self.keys = []

    def submit(self, _, value, key, workers):
        self.keys.append(key)
        return value


class Engines(SweepCase):
    def test_inputs_that_no_run_needs_any_more_are_let_go(self):
        names = ["%d.ply" % i for i in range(3 * MOST_SENT)]
        inputs = {name: self.write(name, name) for name in ["scene.yaml"] + names}
        client = Client()
        engine = Engine(client, {"program": "", "version": ""}, inputs, False, print)
        for name in names:
            # Every run has the scene.
            engine.send("scene.yaml")
            self.assertEqual(engine.send(name), name.encode())
        self.assertEqual(len(engine.sent), MOST_SENT)
        self.assertEqual(len(client.keys), 1 + len(names))
        # Released inputs are sent again.
        engine.send(names[0])
        self.assertEqual(len(client.keys), 2 + len(names))


if __name__ == "__main__":
    unittest.main()
