"""Musher's log: lines on standard error, which the controller keeps for each actuator."""

import os
import sys
import traceback
from typing import Callable

from musher import _native

DEBUG, INFO, WARNING, ERROR = range(4)

#: Set by a fault-injection test, in which hundreds of processes fail on purpose.
muted = False

_program_name = os.path.splitext(os.path.basename(sys.argv[0] if sys.argv else ""))[0] or "python"


class Log:
    """Writes lines of one actuator or program. MUSHER_LOG in the environment is the lowest level written."""

    def __init__(self, name: str = "") -> None:
        self._name = name

    def debug(self, text: str) -> None:
        self._write(DEBUG, text)

    def info(self, text: str) -> None:
        self._write(INFO, text)

    def warning(self, text: str) -> None:
        self._write(WARNING, text)

    def error(self, text: str) -> None:
        self._write(ERROR, text)

    def exception(self, text: str) -> None:
        """An error with the traceback of the exception that is handled."""
        self._write(ERROR, f"{text}\n{traceback.format_exc().rstrip()}")

    def traceback(self, error: BaseException) -> None:
        """An error: the traceback of this exception."""
        self._write(ERROR, "".join(traceback.format_exception(type(error), error, error.__traceback__)).rstrip())

    def _write(self, level: int, text: str) -> None:
        if not muted and level >= _native.lowest_log_level():
            _native.write_log(level, self._name or _program_name, _printable(str(text)))


def _printable(text: str) -> str:
    """A str may have lone surrogates (a file name that is not UTF-8), which no log takes."""
    return text.encode("utf-8", "backslashreplace").decode("utf-8")


def where(error: BaseException) -> str:
    """"ValueError: no such port (gripper.py:12)": the type, text and line of an exception."""
    text = _printable(str(error))
    name = type(error).__name__ + (f": {text}" if text else "")
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if os.path.dirname(frame.filename) != os.path.dirname(__file__)]
    if not own:
        return name
    return f"{name} ({os.path.basename(own[-1].filename)}:{own[-1].lineno})"


def short(value: object) -> str:
    try:
        text = repr(value)
    except Exception as error:
        text = f"a {type(value).__name__} whose repr() raises {type(error).__name__}"
    return text if len(text) <= 80 else text[:77] + "..."


def call_hook(name: str, hook: Callable[..., object], *arguments: object) -> None:
    """Raises what it raises, and TypeError for a result: of what is `async def`, or a generator, nothing has run yet."""
    returned = hook(*arguments)
    if returned is not None:
        raise TypeError(f"{name} returned {short(returned)}; it returns nothing when it has succeeded, and raises an "
                        "exception when it has not")


log = Log()
