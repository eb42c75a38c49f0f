"""Types the commands of docs/python.md, each in the folder of its example, and runs the client of that page."""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from robot import BIN, DEADLINE_S, SOURCE  # also sets the domain

APPLICATION = "## An application"
OWN_PROJECT = "## A project of your own"


def blocks(chapter_from, chapter_to):
    """The ```sh blocks between two headings."""
    with open(os.path.join(SOURCE, "docs/python.md"), encoding="utf-8") as file:
        text = file.read()
    begin = text.index(chapter_from) if chapter_from else 0
    end = text.index(chapter_to) if chapter_to else len(text)
    return re.findall(r"^```sh\n(.*?)^```$", text[begin:end], re.MULTILINE | re.DOTALL)


class WithFolder(unittest.TestCase):
    """A reader's folder and shell."""

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="musher-docs-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.robot = os.path.join(self.folder, "robot")
        programs = os.path.join(self.folder, "bin")
        os.mkdir(programs)
        os.symlink(sys.executable, os.path.join(programs, "python3"))
        self.environment = {**os.environ, "PATH": f"{programs}:{BIN}:{os.environ['PATH']}",
                            "XDG_STATE_HOME": os.path.join(self.folder, "state")}

    def copy(self, example):
        shutil.copytree(os.path.join(SOURCE, "examples", example), self.robot)
        self.addCleanup(self.type, "musher down || true")

    def type(self, commands):
        with open(os.path.join(self.folder, "out"), "w+", encoding="utf-8") as out:  # no pipe: `up` leaves processes
            ran = subprocess.run(["sh", "-ec", commands], cwd=self.robot, env=self.environment, stdin=subprocess.DEVNULL,
                                 stdout=out, stderr=subprocess.STDOUT, timeout=2 * DEADLINE_S, check=False)
            out.seek(0)
            text = out.read()
        self.assertEqual(ran.returncode, 0, f"{commands}\n{text}")
        return text


class Commands(WithFolder):
    def test_of_the_first_module(self):
        self.copy("python_module")
        printed = [self.type(block) for block in blocks("", APPLICATION)]
        self.assertGreaterEqual(len(printed), 3)
        self.assertRegex(printed[0], "done: the machine is in LowPower")
        self.assertRegex(printed[0], r"gripper\* +LowPower")
        self.assertIn("OK", printed[1])
        self.assertIn("done, the machine is in Active", printed[2])

    def test_of_the_application(self):
        self.copy("python_application")
        printed = "".join(self.type(block) for block in blocks(APPLICATION, OWN_PROJECT))
        for text in ("OK\n", "sent open to door", "TRANSITIONING", "BLOCKED"):
            self.assertIn(text, printed)

    def test_of_an_own_project(self):
        os.mkdir(self.robot)
        self.addCleanup(self.type, "musher down || true")
        printed = "".join(self.type(block) for block in blocks(OWN_PROJECT, None))
        self.assertIn("module left_arm in left_arm: .gitignore, README.md, left_arm.py, left_arm_test.py, robot.toml", printed)
        self.assertTrue(os.path.exists(os.path.join(self.robot, "left_arm/left_arm.py")))


class Client(WithFolder):
    def test_it_prints_each_state_and_says_why_a_state_is_refused(self):
        self.copy("python_module")
        self.type("musher up --detach robot.toml")
        follower = subprocess.Popen([sys.executable, "client.py"], cwd=self.robot, env=self.environment, text=True,
                                    stdout=subprocess.PIPE)
        self.addCleanup(follower.stdout.close)
        self.addCleanup(follower.wait, DEADLINE_S)
        self.addCleanup(follower.kill)
        self.assertEqual(follower.stdout.readline(), "Active\n")
        self.assertIn("done, the machine is in LowPower", self.type("python3 client.py LowPower"))
        self.assertEqual(follower.stdout.readline(), "LowPower\n")
        refused = subprocess.run([sys.executable, "client.py", "LowPwer"], cwd=self.robot, env=self.environment,
                                 text=True, capture_output=True, timeout=DEADLINE_S, check=False)
        self.assertEqual(refused.returncode, 1)
        self.assertIn("did you mean 'LowPower'?", refused.stderr)

    def test_without_a_robot_it_says_that_there_is_no_controller(self):
        self.copy("python_module")
        refused = subprocess.run([sys.executable, "client.py", "Active"], cwd=self.robot, env=self.environment,
                                 text=True, capture_output=True, timeout=DEADLINE_S, check=False)
        self.assertEqual(refused.returncode, 1)
        self.assertIn("client.py: no controller found", refused.stderr)


if __name__ == "__main__":
    unittest.main()
