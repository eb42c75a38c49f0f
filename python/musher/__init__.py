"""Musher in Python: modules of a robot, clients of a machine, topics, services and actions.

    import musher

    class Gripper(musher.Actuator):
        def on_active(self) -> None: ...

    musher.run(Gripper)
"""

from musher._actuator import Actuator, run, state
from musher._errors import ConfigError, Failure, Key, NotAllowed
from musher._log import log
from musher._native import VERSION as __version__

__all__ = ["Actuator", "ConfigError", "Failure", "Key", "NotAllowed", "__version__", "log", "run", "state"]
