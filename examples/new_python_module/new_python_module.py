#!/usr/bin/python3
"""NewPythonModule: an actuator with a method for each of its states."""

import musher


class NewPythonModule(musher.Actuator):
    name = "new_python_module"  # as in the config
    # Codes of this module are 7000 plus a key: 7009 is "self-check failed". 6000 to 9999 are free.
    module_code = 7000

    def __init__(self) -> None:
        super().__init__()
        self.is_open = False
        self.powered = False

    # A method is idempotent: it may run again in the same state.
    def on_set_up(self) -> None:
        self.is_open = True  # here the module opens its device

    # A failure carries a sentence, which `musher` shows.
    def on_self_check(self) -> None:
        if not self.is_open:
            raise self.failure(musher.Key.SELF_CHECK_FAILED, "the device is not open")

    def on_active(self) -> None:
        self.set_power(True)

    def on_low_power(self) -> None:
        self.set_power(False)

    def on_tear_down(self) -> None:
        self.set_power(False)

    # Runs at once, beside any method, and again when that method ends.
    def on_emergency_stop(self) -> None:
        self.powered = False

    def set_power(self, on: bool) -> None:
        self.powered = on
        # A later stop runs on_emergency_stop(); an earlier one is detected here.
        if self.emergency_stopped:
            self.powered = False
        self.log.info("power on" if self.powered else "power off")


if __name__ == "__main__":
    musher.run(NewPythonModule)
