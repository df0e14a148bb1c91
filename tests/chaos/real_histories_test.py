#!/usr/bin/env python3
"""Seeded histories of real processes over real sockets: whatever is killed, stopped, cut, lost, repeated or full, the
pictures have the bits of `parray render`."""

import importlib.machinery
import importlib.util
import pathlib
import sys
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
loader = importlib.machinery.SourceFileLoader("histories", str(HERE / "histories"))
histories = importlib.util.module_from_spec(importlib.util.spec_from_loader("histories", loader))
loader.exec_module(histories)

SOME = (3, 20, 98, 117)  # every kind of event, a faulty worker, workers of another release


class RealHistories(unittest.TestCase):
    def play(self, seeds):
        for result in histories.play(seeds):
            with self.subTest(seed=result["seed"]):
                self.assertNotIn("wrong", result, "\n".join(result.get("notes", [])))

    def test_whatever_happens_pictures_are_those_of_render_and_nothing_is_lost_or_left(self):
        self.play(SOME)


class Long(unittest.TestCase):
    def test_200_histories(self):
        RealHistories.play(self, range(1, 201))


if __name__ == "__main__":
    unittest.main()
