"""Musher's exceptions: each has CyberDog's code for programs and a sentence for people."""

import enum

from musher import _native


class Key(enum.IntEnum):
    """What a code says: the code of a module plus one of these, or a number from 21 to 99 of its own."""

    FAILED = 1
    UNINITIALIZED = 2
    STATE_INVALID = 3
    STATUS_ERROR = 4
    NET_ERROR = 5
    PERMISSION_DENIED = 6
    TIMEOUT = 7
    UNSUPPORTED = 8
    SELF_CHECK_FAILED = 9
    PARAMETERS_INVALID = 10
    TARGET_BUSY = 11
    DEVICE_ERROR = 12
    PROTECTED = 13


class Failure(Exception):
    """An expected failure. A state callback raises it to fail; Musher's calls raise it, too."""

    code: int
    reason: str

    def __init__(self, code: int, reason: str = "") -> None:
        if isinstance(code, bool) or not isinstance(code, int):
            raise TypeError(f"the code of a Failure is an int, not {code!r}: musher.Failure(6109, \"the reason\")")
        if code == 0:
            raise ValueError("code 0 means success; give a failure another code")
        if not -(2**31) <= code < 2**31:
            raise ValueError(f"the code of a Failure has 32 bits; {code} does not fit")
        if not isinstance(reason, str):
            raise TypeError(f"the reason of a Failure is a str, not {reason!r}")
        super().__init__(code, reason)
        self.code = code
        self.reason = reason

    def __str__(self) -> str:
        return _native.code_text(self.code) + (f", {self.reason}" if self.reason else "")


class ConfigError(Failure):
    """The state config is invalid, or does not fit the actuator."""


class NotAllowed(Failure):
    """A function may not run now: not in this state, or not with this battery."""


class ProcessKilled(BaseException):
    """In a fault-injection test: the process of the actuator is killed. Do not catch it."""
