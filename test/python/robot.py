"""A robot of Python actuators that a test runs: its own folder and DDS domain, real processes."""

import contextlib
import os
import re
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from typing import Dict, Optional

SOURCE = os.environ["MUSHER_SOURCE"]
sys.path.insert(0, os.path.join(SOURCE, "test/support"))
from domain import lock_domain  # noqa: E402

BIN = os.environ["MUSHER_BIN"]
DEADLINE_S = 120.0

DOMAIN, _LOCK = lock_domain()
os.environ["ROS_DOMAIN_ID"] = str(DOMAIN)
os.environ.pop("MUSHER_NAMESPACE", None)
os.environ.pop("MUSHER_MACHINE", None)
os.environ["PATH"] = BIN + ":" + os.environ["PATH"]

CONFIG = """[controller]
name = "robot"
actuators = [{names}]
states = ["SetUp", "SelfCheck", "Active", "LowPower", "TearDown"]
default_time = 20000
default_state = "Uninitialized"
state_dir = "state"
"""
ACTUATOR = """
[actuator.{name}]
states = ["SetUp", "SelfCheck", "Active", "LowPower", "TearDown"]
times = [60000, 20000, 20000, 20000, 5000]
command = ["{python}", "{name}.py"]
cwd = "."
critical = true
restart_delay_ms = 10
{more}
"""


class Robot:
    """`programs`: the source of each actuator's program by its name, `more`: more keys of its table."""

    def __init__(self, programs: Dict[str, str], more: str = "", config: str = "") -> None:
        self.folder = tempfile.mkdtemp(prefix="musher-python-")
        self.file = os.path.join(self.folder, "robot.toml")
        text = CONFIG.format(names=", ".join(f'"{name}"' for name in programs)) + config
        for name, program in programs.items():
            text += ACTUATOR.format(name=name, python=sys.executable, more=more)
            self.write(f"{name}.py", "import musher\n" + program + "\n")
        self.write("robot.toml", text)
        self._up: Optional[subprocess.Popen[str]] = None

    def write(self, name: str, text: str) -> None:
        with open(os.path.join(self.folder, name), "w", encoding="utf-8") as file:
            file.write(text)

    def read(self, name: str) -> str:
        try:
            with open(os.path.join(self.folder, name), encoding="utf-8") as file:
                return file.read()
        except FileNotFoundError:
            return ""

    def await_log(self, name: str, pattern: str, count: int = 1) -> "list[str]":
        """Waits until so many lines of an actuator's log match; returns all its lines up to there. A line is in the
        log once the controller has read it, which is after the answer to a request that wrote it."""
        lines = []
        with subprocess.Popen(["musher", "logs", "--follow", "--lines", "0", name], stdout=subprocess.PIPE,
                              text=True) as logs:
            deadline = threading.Timer(DEADLINE_S, logs.kill)
            deadline.start()
            try:
                assert logs.stdout is not None
                for line in logs.stdout:
                    lines.append(line.rstrip("\n"))
                    count -= re.search(pattern, line) is not None
                    if count == 0:
                        return lines
            finally:
                deadline.cancel()
                logs.kill()
        raise AssertionError(f"no {pattern!r} in the log of {name}: {lines}")

    def up(self) -> "subprocess.Popen[str]":
        with open(os.path.join(self.folder, "up.err"), "w", encoding="utf-8") as err:
            self._up = subprocess.Popen(["musher", "up", self.file], stdout=subprocess.DEVNULL, stderr=err, text=True)
        return self._up

    def run(self, *arguments: str) -> "subprocess.CompletedProcess[str]":
        return subprocess.run(["musher", *arguments], capture_output=True, text=True, timeout=DEADLINE_S, check=False)

    def close(self) -> None:
        if self._up is not None:
            self.run("down")
            try:
                self._up.wait(DEADLINE_S)
            except subprocess.TimeoutExpired:
                self._up.kill()
                self._up.wait()
        shutil.rmtree(self.folder, ignore_errors=True)

    def __enter__(self) -> "Robot":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def run_python(program: str, deadline_s: float = DEADLINE_S, **more: str) -> "subprocess.CompletedProcess[str]":
    """Runs a program of its own to its end."""
    return subprocess.run([sys.executable, "-X", "faulthandler", "-c", "import musher\n" + program],
                          capture_output=True, text=True, timeout=deadline_s, check=False, env={**os.environ, **more})


def end(pid: int) -> None:
    """Returns once the process has exited."""
    with contextlib.suppress(ProcessLookupError):
        process = os.pidfd_open(pid)
        os.kill(pid, signal.SIGKILL)
        select.select([process], [], [], DEADLINE_S)
        os.close(process)


def freeze(pid: int) -> None:
    """Returns once each thread of the process stands."""
    os.kill(pid, signal.SIGSTOP)
    deadline = time.monotonic() + DEADLINE_S
    for thread in os.listdir(f"/proc/{pid}/task"):
        stands = False
        while not stands and time.monotonic() < deadline:
            with open(f"/proc/{pid}/task/{thread}/stat", encoding="utf-8") as file:
                stands = file.read().rpartition(") ")[2].startswith("T")
