"""Types what pages have their readers type, into an empty folder, and compares what is printed.

    type_pages_test.py [--prefix FOLDER] [--shell SHELL]... PAGE...

--prefix names an installation, as by `cmake --install build/dev --prefix FOLDER`; without it, the programs are those
on PATH. PAGE: docs/first-skill.md. See page.py for the comments in a page.
"""

import argparse
import os
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest
from typing import List, Optional

import page
from page import Command, File, Typed

sys.path.insert(0, os.path.join(page.SOURCE, "test/support"))
from domain import lock_domain  # noqa: E402

LIMIT_S = 900  # for a folder; the longest builds the robot with a gripper, and tests it

# A group of commands runs in the shell itself: `cd` and `export` last.
GROUP = {"bash": ("{{ {}\n}} > {} 2>&1 < /dev/null", "$?"),
         "zsh": ("{{ {}\n}} > {} 2>&1 < /dev/null", "$?"),
         "fish": ("begin; {}\nend > {} 2>&1 < /dev/null", "$status")}


class Reader:
    """A person's folder, shell and computer, which is this one but for some places."""

    def __init__(self, shell: str, prefix: Optional[str]) -> None:
        self.shell = shell
        self.root = tempfile.mkdtemp(prefix="musher-typed-")
        self.prefix = prefix
        programs = self.path("bin")
        os.mkdir(programs)
        os.symlink(sys.executable, os.path.join(programs, "python3"))
        self.script("sudo", 'exec "$@"')
        if prefix:  # what /usr/local is on the page
            cmake = shutil.which("cmake") or "cmake"
            self.script("cmake", f'case $1 in\n--install) exec {cmake} "$@" --prefix {prefix} ;;\n*) exec {cmake} "$@" ;;\nesac')
        before = [programs] + ([os.path.join(prefix, "bin")] if prefix else [])
        self.environment = {**os.environ, "PATH": ":".join([*before, os.environ["PATH"]]), "HOME": self.root,
                            "XDG_STATE_HOME": self.path("state"), "XDG_CONFIG_HOME": self.path("config")}
        if prefix:
            self.environment["CMAKE_PREFIX_PATH"] = prefix
            packages = os.path.join(prefix, "lib/python3/dist-packages")
            self.environment["PYTHONPATH"] = ":".join(filter(None, [packages, os.environ.get("PYTHONPATH")]))
            if shutil.which("ccache"):
                self.environment.update(CMAKE_CXX_COMPILER_LAUNCHER="ccache", CCACHE_BASEDIR=self.root, CCACHE_NOHASHDIR="1")

    def path(self, name: str) -> str:
        return os.path.join(self.root, name)

    def script(self, name: str, text: str) -> None:
        with open(self.path(f"bin/{name}"), "w", encoding="utf-8") as file:
            file.write(f"#!/bin/sh\n{text}\n")
        os.chmod(self.path(f"bin/{name}"), 0o755)

    def as_here(self, command: str) -> str:
        """The places of the page are others on this computer."""
        command = command.replace("/tmp/faults", self.path("faults"))
        if self.prefix:
            for place in ("/usr/local", "/usr"):
                command = command.replace(f" {place}/share", f" {self.prefix}/share").replace(f" {place}/etc", f" {self.prefix}/etc")
        return command

    def type(self, part: Typed) -> None:
        """Into an empty folder, in one shell; the output of step N is in the file N."""
        folder = self.path(part.folder)
        os.mkdir(folder)
        group, status = GROUP[self.shell]
        lines = []
        for number, step in enumerate(part.steps):
            if isinstance(step, File):
                with open(self.path(f"{number}.text"), "w", encoding="utf-8") as file:
                    file.write(step.text)
                lines.append(f"cat {self.path(f'{number}.text')} {'>>' if step.part else '>'} {shlex.quote(step.name)}")
            else:
                lines.append(group.format(self.as_here(step.text), self.path(f"{number}.out")))
                lines.append(f"echo {status} > {self.path(f'{number}.status')}")
        with open(self.path("typed"), "w", encoding="utf-8") as file:
            file.write("\n".join(lines) + "\n")
        with open(self.path("shell.out"), "w", encoding="utf-8") as out:  # no pipe: `up` leaves processes
            shell = subprocess.Popen([self.shell, self.path("typed")], cwd=folder, env=self.environment,
                                     stdin=subprocess.DEVNULL, stdout=out, stderr=subprocess.STDOUT, start_new_session=True)
            try:
                shell.wait(LIMIT_S)
            except subprocess.TimeoutExpired:
                os.killpg(shell.pid, signal.SIGKILL)
                shell.wait()

    def read(self, name: str) -> str:
        try:
            with open(self.path(name), encoding="utf-8", errors="replace") as file:
                return file.read()
        except FileNotFoundError:
            return ""

    def failures(self, part: Typed) -> List[str]:
        """A command whose output the page shows may fail, as the page then says; the others succeed. A build has no
        warnings."""
        wrong = []
        for number, step in enumerate(part.steps):
            if not isinstance(step, Command):
                continue
            printed = self.read(f"{number}.out")
            status = self.read(f"{number}.status").strip()
            missing = page.not_printed(step, printed)
            where = f"{part.page}:{step.line}: $ {step.text}"
            if not status:
                return [*wrong, f"{where}\ndoes not end within {LIMIT_S} s; it has printed\n{printed}{self.read('shell.out')}"]
            warned = "cmake --build" in step.text and "warning:" in printed
            if missing or warned or (status != "0" and not step.printed):
                shown = "".join(f"not printed: {line}\n" for line in missing)
                wrong.append(f"{where}\n{shown}exit code {status}; printed:\n{printed}")
        if self.read("shell.out"):
            wrong.append(f"{part.page}: {self.shell}: {self.read('shell.out')}")
        return wrong

    def leave(self) -> None:
        """A page that fails half-way leaves its robot up, or actuators whose controller was replaced."""
        for more in ([], [], ["--without-controller"]):
            subprocess.run(["musher", "down", *more], env=self.environment, capture_output=True, timeout=300, check=False)
        shutil.rmtree(self.root, ignore_errors=True)


class Pages(unittest.TestCase):
    pages: List[str] = []
    shells: List[str] = ["bash"]
    prefix: Optional[str] = None

    def test_print_what_they_say_when_they_are_typed(self) -> None:
        if not self.shells:
            self.skipTest("the shell is not installed")
        for path in self.pages:
            parts = page.typed(path)
            self.assertTrue(parts, f"nothing of {path} is typed")
            for shell in self.shells:
                for part in parts:
                    with self.subTest(page=path, folder=part.folder, shell=shell):
                        reader = Reader(shell, self.prefix)
                        self.addCleanup(reader.leave)
                        reader.type(part)
                        wrong = reader.failures(part)
                        reader.leave()
                        if wrong:
                            self.fail("\n" + "\n".join(wrong))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--prefix")
    parser.add_argument("--shell", action="append")
    parser.add_argument("page", nargs="+")
    options = parser.parse_args()
    number, _lock = lock_domain()
    os.environ["ROS_DOMAIN_ID"] = str(number)
    for name in ("MUSHER_NAMESPACE", "MUSHER_MACHINE", "MUSHER_KEYS"):
        os.environ.pop(name, None)
    Pages.pages = options.page
    Pages.shells = [shell for shell in options.shell or ["bash"] if shutil.which(shell)]
    Pages.prefix = os.path.abspath(options.prefix) if options.prefix else None
    unittest.main(argv=sys.argv[:1])


if __name__ == "__main__":
    main()
