"""The benchmarks in Python still work; what they measure is not checked here."""

import os
import subprocess
import sys
import unittest

from robot import DEADLINE_S, SOURCE


class Benchmarks(unittest.TestCase):
    def run_driver(self, *line):
        ran = subprocess.run([sys.executable, os.path.join(SOURCE, "test/benchmark/python", line[0]), *line[1:]],
                             capture_output=True, text=True, timeout=2 * DEADLINE_S, check=False)
        self.assertEqual(ran.returncode, 0, ran.stderr)
        return ran.stdout

    def test_pictures_arrive(self):
        self.assertIn("10 of 10 received", self.run_driver("images.py", "1", "10"))

    def test_machines_of_both_languages_are_switched(self):
        printed = self.run_driver("actuators.py", "2", "4")
        for line in ("2 actuators in cpp, a switch: ", "2 actuators in python, a switch: ", "python / cpp: "):
            self.assertIn(line, printed)


if __name__ == "__main__":
    unittest.main()
