"""An upgrade of Musher under a Python process that runs."""

import os
import shutil
import subprocess
import sys
import tempfile
import unittest

import musher
from robot import DEADLINE_S

UPGRADED = r"Musher was upgraded from \S+ to 99\.0\.0 while this process runs, so musher\.\S+ cannot be loaded any more: " \
           "restart the process"


class Upgrade(unittest.TestCase):
    def setUp(self):
        """A copy of the package, but for the extension, to which it links."""
        self.folder = tempfile.mkdtemp(prefix="musher-upgrade-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.copy = os.path.join(self.folder, "musher")
        installed = os.path.dirname(musher.__file__)
        shutil.copytree(installed, self.copy, ignore=shutil.ignore_patterns("*.so", "__pycache__"))
        for name in os.listdir(installed):
            if name.endswith(".so"):
                os.symlink(os.path.join(installed, name), os.path.join(self.copy, name))

    def run_python(self, *lines):
        return subprocess.run([sys.executable, "-c", "\n".join(lines)], capture_output=True, text=True,
                              timeout=DEADLINE_S, check=False, env={**os.environ, "PYTHONPATH": self.folder})

    def upgrade(self):
        return f"open({os.path.join(self.copy, 'VERSION')!r}, 'w').write('99.0.0')"

    def test_a_part_that_is_loaded_later_is_refused_and_what_is_loaded_works(self):
        for later in ("musher.fsm", "musher.Machine", "musher.FsmActuator", "import musher.testing",
                      "from musher.std_srvs.srv import Trigger"):
            with self.subTest(later):
                shutil.copy(os.path.join(os.path.dirname(musher.__file__), "VERSION"), self.copy)
                ended = self.run_python("import musher", "from musher.std_msgs.msg import String", self.upgrade(), "try:",
                                        f"    {later}", "except ImportError as error: print(error)",
                                        "from musher.std_msgs.msg import String", "print(String('works').data)")
                self.assertRegex(ended.stdout, f"^{UPGRADED}\nworks\n$", ended.stderr)

    def test_without_an_upgrade_all_parts_are_loaded(self):
        ended = self.run_python("import musher, musher.testing", "musher.fsm, musher.Machine, musher.FsmActuator")
        self.assertEqual((ended.returncode, ended.stderr), (0, ""))


if __name__ == "__main__":
    unittest.main()
