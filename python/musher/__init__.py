"""Musher in Python: modules of a robot, clients of a machine, topics, services and actions.

    import musher

    class Gripper(musher.Actuator):
        def on_active(self) -> None: ...

    musher.run(Gripper)
"""

try:
    from musher import _native
except ImportError as error:
    import sys as _sys
    raise ImportError(f"musher's extension does not fit this interpreter, {_sys.executable} (Python "
                      f"{_sys.version_info.major}.{_sys.version_info.minor}); it is built for the system's, "
                      f"/usr/bin/python3: {error}") from error

from typing import TYPE_CHECKING, Any

import musher._upgrade  # before all other parts
from musher._actuator import Actuator, run, state
from musher._errors import ConfigError, Failure, Key, NotAllowed
from musher._log import log
from musher._native import VERSION as __version__
from musher._node import Node, Publisher, ServiceClient, ServiceServer, Subscription

if TYPE_CHECKING:
    from musher._action import ActionClient, ActionServer, Goal, GoalCanceled, GoalFailed, ServerGoal
    from musher import fsm, skill
    from musher._fsm_actuator import FsmActuator
    from musher._machine import ActuatorOutcome, Machine, Outcome, SwitchFailed
    from musher._skill_actuator import SkillActuator

# Loaded at their first use: an actuator mostly does not need them.
_LATER = {
    "_action": ("ActionClient", "ActionServer", "Goal", "GoalCanceled", "GoalFailed", "ServerGoal"),
    "_fsm_actuator": ("FsmActuator",),
    "_machine": ("ActuatorOutcome", "Machine", "Outcome", "SwitchFailed"),
    "_skill_actuator": ("SkillActuator",),
}


def __getattr__(name: str) -> Any:
    import importlib
    if name in ("fsm", "skill"):
        return importlib.import_module(f"musher.{name}")
    for module, names in _LATER.items():
        if name in names:
            return getattr(importlib.import_module(f"musher.{module}"), name)
    raise AttributeError(f"module 'musher' has no attribute '{name}'")


__all__ = [
    "ActionClient", "ActionServer", "Actuator", "ActuatorOutcome", "ConfigError", "Failure", "FsmActuator", "Goal",
    "GoalCanceled", "GoalFailed", "Key", "Machine", "Node", "NotAllowed", "Outcome", "Publisher", "ServerGoal",
    "ServiceClient", "ServiceServer", "SkillActuator", "Subscription", "SwitchFailed", "__version__", "fsm", "log", "run",
    "skill", "state",
]
