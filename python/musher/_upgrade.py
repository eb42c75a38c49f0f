"""Refuses parts of another version of Musher in a process that began before an upgrade: parts are loaded at their first
use, and would not fit the extension that the process has loaded."""

import os
import sys
from typing import Optional, Sequence

from musher import _native

_VERSION_FILE = os.path.join(os.path.dirname(__file__), "VERSION")  # of the files that are installed now


class _OneVersion:
    """A finder before those of Python, which finds nothing itself."""

    def find_spec(self, name: str, path: Optional[Sequence[str]] = None, target: object = None) -> None:
        if not name.startswith("musher."):
            return
        try:
            with open(_VERSION_FILE, encoding="ascii") as file:
                installed = file.read().strip()
        except OSError:
            return  # removed: Python says so
        if installed != _native.VERSION:
            raise ImportError(f"Musher was upgraded from {_native.VERSION} to {installed} while this process runs, "
                              f"so {name} cannot be loaded any more: restart the process")


sys.meta_path.insert(0, _OneVersion())
