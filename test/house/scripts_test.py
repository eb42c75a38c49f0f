"""scripts/*: each explains itself, and says what is missing in a tree that nothing was built in."""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

SCRIPTS = pathlib.Path(__file__).resolve().parent.parent.parent / "scripts"


def programs():
    files = [*SCRIPTS.iterdir(), *(SCRIPTS / "demos").iterdir()]
    return sorted(file for file in files if file.is_file() and os.access(file, os.X_OK))


def run(words, **options):
    return subprocess.run([str(word) for word in words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True, timeout=120, check=False, **options)


class EachScript(unittest.TestCase):
    def test_explains_itself_and_does_nothing_else(self):
        for script in programs():
            with self.subTest(script.name):
                end = run([script, "--help"])
                self.assertEqual((end.returncode, end.stderr), (0, ""))
                # What bootstrap, demo, … print is the comment at their head, with nothing of the code below.
                self.assertIn(script.name, end.stdout)
                self.assertNotIn("set -", end.stdout)

    def test_refuses_an_unknown_option(self):
        for script in programs():
            if script.name == "mutate":  # builds the tests that know their options
                continue
            with self.subTest(script.name):
                end = run([script, "--no-such-option"])
                self.assertNotEqual(end.returncode, 0)
                self.assertNotEqual(end.stdout + end.stderr, "")
                self.assertNotIn("Traceback", end.stderr)


class Lint(unittest.TestCase):
    """In a tree of its own, with fakes of what it runs."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.tree = pathlib.Path(folder.name)
        (self.tree / "scripts").mkdir()
        (self.tree / "bin").mkdir()
        shutil.copy(SCRIPTS / "lint", self.tree / "scripts/lint")
        self.add("ninja")
        self.add("clang-tidy")

    def add(self, program, commands=""):
        path = self.tree / "bin" / program
        path.write_text(f"#!/bin/sh\n{commands}\n")
        path.chmod(0o755)

    def lint(self):
        return run([sys.executable, self.tree / "scripts/lint"], env={"PATH": str(self.tree / "bin")})

    def test_configures_a_tree_that_was_never_configured(self):
        self.add("cmake", f'echo "$@" >> {self.tree}/calls; echo no Eigen3; exit 1')
        end = self.lint()
        self.assertEqual((self.tree / "calls").read_text(), "--preset lint\n")
        self.assertEqual(end.returncode, 2)
        self.assertIn("no Eigen3", end.stderr)
        self.assertIn("scripts/lint: `cmake --preset lint` has failed, see above", end.stderr)

    def test_configures_a_configured_tree_no_more(self):
        self.add("cmake", f'echo "$@" >> {self.tree}/calls; exit 1')
        (self.tree / "build/lint").mkdir(parents=True)
        (self.tree / "build/lint/build.ninja").touch()
        end = self.lint()
        self.assertIn("--target musher_message_headers", (self.tree / "calls").read_text())
        self.assertNotIn("--preset", (self.tree / "calls").read_text())
        self.assertEqual(end.returncode, 2)
        self.assertIn("scripts/lint: the generated headers cannot be built, see above", end.stderr)

    def test_names_the_programs_that_are_missing(self):
        end = self.lint()
        self.assertEqual((end.returncode, end.stderr),
                         (2, "scripts/lint: cmake not found; scripts/bootstrap installs what is missing\n"))


if __name__ == "__main__":
    unittest.main()
