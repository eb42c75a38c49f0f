"""Tests an actuator class under injected faults: a whole robot in virtual time with your class behind one of its
actuators, and events sampled from seeds. No DDS, no processes, no waiting.

    class GripperTest(unittest.TestCase):
        def test_has_no_power_in_low_power(self):
            test = musher.testing.ActuatorFaultTest(Gripper, "robot.toml")

            @test.always
            def power(gripper, report):
                assert not (report.state == "LowPower" and gripper.powered)

            test.run()

A failing scenario raises AssertionError. Its text has the seed, how to replay it, and a timeline with as few injected
events as possible. A scenario fails when a check raises or returns False; a callback fails when it runs twice in its
state; a callback neither ends nor calls stop_requested(); on_emergency_stop() raises or blocks; or an invariant of
`musher simulate` is violated.

    MUSHER_SEED=42 [MUSHER_ONLY=3,7]   replays that scenario, optionally with these events only
    MUSHER_SEEDS=1000                  runs so many scenarios

The process is an object here: when it is killed, stop_requested() ends the callback, and the object is dropped without
TearDown. What is global or a member of the test outlives it, as hardware does. Virtual time passes only in
stop_requested() and at the end of a callback; checkpoint() does nothing, and self.node has no transport.
"""

import os
import sys
from typing import Any, Callable, Dict, List, Optional, Type, TypeVar, Union

from musher import _log, _native
from musher._actuator import Actuator
from musher._errors import ConfigError
from musher._log import where

Faults = _native.Faults
Report = _native.Report

_A = TypeVar("_A", bound=Actuator)
Check = Callable[[Any, Report], Any]


class ActuatorFaultTest:
    """`actuator`: the class, or a function that makes one. `config`: the state config of the robot, a file or its
    text; without it, your actuator with one before and one after it."""

    def __init__(self, actuator: Union[Type[Actuator], Callable[..., Actuator]],
                 config: "str | os.PathLike[str]" = "") -> None:
        if not callable(actuator):
            raise TypeError(f"the class of an actuator is expected, not {actuator!r}")
        self._make = actuator
        self._config = os.fspath(config)
        self._always: Optional[Check] = None
        self._after_stop: Optional[Check] = None
        #: With True, the actuator gets a Faults object and asks its should_fail() at each step of its fake hardware;
        #: else an injected failure happens before the first step of a callback.
        self.with_faults = False
        #: Runs before each scenario; resets what outlives a process.
        self.before_scenario: Optional[Callable[[], None]] = None
        #: The battery's level, %; None: not known.
        self.battery: Optional[int] = 100
        self.first_seed = 1
        self.scenarios = 300
        #: A callback that has neither ended nor called stop_requested() for so long is stuck.
        self.real_time_limit_s = 10.0
        #: What the actuators of the last run went through.
        self.counts: Dict[str, int] = {}

    def always(self, check: Check) -> Check:
        """Must hold whenever a callback has succeeded, and when an emergency stop is engaged while none runs."""
        self._always = check
        return check

    def after_emergency_stop(self, check: Check) -> Check:
        """Must hold as soon as on_emergency_stop() has run, which may be during a callback."""
        self._after_stop = check
        return check

    def run(self) -> None:
        """Raises AssertionError at the first failing scenario, with as few injected events as make it fail."""
        seed = _number("MUSHER_SEED")
        if seed is not None:
            return self._replay(seed)
        count = _number("MUSHER_SEEDS")
        failure = self._run(lambda test: test.find(self.first_seed, self.scenarios if count is None else count))
        if failure is None:
            return
        seed, only, what, timeline, reproduced = failure
        again = "" if reproduced else (
            "not reproduced: the replayed scenario passed. Either some state outlives a scenario (reset it in "
            "before_scenario), or the actuator uses real time or threads of its own\n")
        raise AssertionError(f"{what}\nreplay with: MUSHER_SEED={seed}{_only_text(only)} {_command()}\n"
                             f"{again}{timeline}")

    def _replay(self, seed: int) -> None:
        test: List[_native.FaultTest] = []

        def run_one(made: _native.FaultTest) -> Any:
            test.append(made)
            return made.run_one(seed, _only())

        failure = self._run(run_one)
        print(test[0].timeline())
        if failure is not None:
            raise AssertionError(failure[2])

    def _run(self, work: Callable[[_native.FaultTest], Any]) -> Any:
        is_text = "\n" in self._config
        test = _native.FaultTest("" if is_text else self._config, self._config if is_text else "", self._made,
                                 self.with_faults, self.before_scenario, _checked(self._always),
                                 _checked(self._after_stop), self.battery, self.real_time_limit_s)
        quiet, _log.muted = _log.muted, "MUSHER_SEED" not in os.environ
        try:
            return work(test)
        finally:
            _log.muted = quiet
            self.counts = test.counts()

    def _made(self, *faults: Faults) -> Actuator:
        made = self._make(*faults)
        if not isinstance(made, Actuator):
            raise TypeError(f"{self._make!r} made {made!r}, which is no musher.Actuator")
        if not hasattr(made, "_handle"):
            raise TypeError(f"{type(made).__name__}.__init__ does not call super().__init__()")
        return made


def _checked(check: Optional[Check]) -> Optional[Callable[[Any, Report], Optional[str]]]:
    if check is None:
        return None
    name = getattr(check, "__name__", repr(check))

    def run(actuator: Any, report: Report) -> Optional[str]:
        try:
            held = check(actuator, report)
        except Exception as error:
            return f"{name}: {where(error)} in {report.state}"
        return f"{name} returned False in {report.state}" if held is False else None

    return run


def _number(variable: str) -> Optional[int]:
    text = os.environ.get(variable, "")
    if not text:
        return None
    if not text.isdigit():
        raise ValueError(f"{variable} is not a number: {text}")
    return int(text)


def _only() -> Optional[List[int]]:
    text = os.environ.get("MUSHER_ONLY", "")
    if not text:
        return None
    try:
        return [] if text == "none" else [int(number) for number in text.split(",")]
    except ValueError:
        raise ValueError(f"MUSHER_ONLY is not a list of numbers such as 3,7: {text}") from None


def _only_text(only: Optional[List[int]]) -> str:
    return "" if only is None else " MUSHER_ONLY=" + (",".join(map(str, only)) or "none")


def _command() -> str:
    return " ".join([os.path.basename(sys.executable), *sys.orig_argv[1:]])


__all__ = ["ActuatorFaultTest", "ConfigError", "Faults", "Report"]
