#!/usr/bin/python3
"""A robot's module in one file: a gripper; its thermometer is a file."""

import musher

HOTTEST = 70  # °C


class Gripper(musher.Actuator):
    name = "gripper"  # as in the config
    module_code = 6100  # 6109 is "self-check failed" of this module

    def __init__(self) -> None:
        super().__init__()
        self.width_mm = 80.0
        self.powered = False

    def on_active(self) -> None:
        self.set_power(True)

    def on_low_power(self) -> None:
        self.set_power(False)

    def on_tear_down(self) -> None:
        self.set_power(False)

    # A long callback reports its progress, and checks whether it should stop.
    def on_set_up(self) -> None:
        while self.width_mm > 0:
            if self.stop_requested():
                raise self.failure(musher.Key.TIMEOUT, "still not closed")
            self.width_mm -= 0.5
            self.checkpoint()

    # A failure carries a sentence that `musher` shows.
    def on_self_check(self) -> None:
        temperature = read_temperature()
        if temperature > HOTTEST:
            raise self.failure(musher.Key.SELF_CHECK_FAILED, f"the motor has {temperature} °C")

    # Runs beside any callback, and again when a callback ends that was running: so it is idempotent.
    def on_emergency_stop(self) -> None:
        self.powered = False

    # Called for a command from outside, on any thread.
    def grip(self, width_mm: float) -> None:
        with self.allowed("grip"):
            self.width_mm = width_mm

    def set_power(self, on: bool) -> None:
        self.powered = on
        # A later stop runs on_emergency_stop(); an earlier one is detected here.
        if self.emergency_stopped:
            self.powered = False
        self.log.info("power " + ("on" if self.powered else "off"))


def read_temperature() -> int:
    try:
        with open("temperature", encoding="utf-8") as file:
            return int(file.read())
    except FileNotFoundError:
        return 20


if __name__ == "__main__":
    musher.run(Gripper)
