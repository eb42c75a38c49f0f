"""The client of docs/python.md; the commands of that page are typed by test/docs."""

import os
import shutil
import subprocess
import sys
import tempfile
import unittest

from robot import DEADLINE_S, SOURCE  # also sets the domain


class Client(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="musher-client-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.environment = {**os.environ, "XDG_STATE_HOME": os.path.join(self.folder, "state")}
        self.robot = os.path.join(self.folder, "robot")
        shutil.copytree(os.path.join(SOURCE, "examples/python_module"), self.robot)

    def run_client(self, state):
        return subprocess.run([sys.executable, "client.py", state], cwd=self.robot, env=self.environment, text=True,
                              capture_output=True, timeout=DEADLINE_S, check=False)

    def musher(self, *arguments):
        subprocess.run(["musher", *arguments], cwd=self.robot, env=self.environment, stdin=subprocess.DEVNULL,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, timeout=DEADLINE_S, check=True)

    def test_it_prints_each_state_and_says_why_a_state_is_refused(self):
        self.musher("up", "--detach", "robot.toml")
        self.addCleanup(self.musher, "down")
        follower = subprocess.Popen([sys.executable, "client.py"], cwd=self.robot, env=self.environment, text=True,
                                    stdout=subprocess.PIPE)
        self.addCleanup(follower.stdout.close)
        self.addCleanup(follower.wait, DEADLINE_S)
        self.addCleanup(follower.kill)
        self.assertEqual(follower.stdout.readline(), "Active\n")
        self.assertIn("done, the machine is in LowPower", self.run_client("LowPower").stdout)
        self.assertEqual(follower.stdout.readline(), "LowPower\n")
        refused = self.run_client("LowPwer")
        self.assertEqual(refused.returncode, 1)
        self.assertIn("did you mean 'LowPower'?", refused.stderr)

    def test_without_a_robot_it_says_that_there_is_no_controller(self):
        refused = self.run_client("Active")
        self.assertEqual(refused.returncode, 1)
        self.assertIn("client.py: no controller found", refused.stderr)


if __name__ == "__main__":
    unittest.main()
