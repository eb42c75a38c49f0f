"""ActuatorFaultTest in Python: finds planted faults, and shows the shortest failing run."""

import unittest

import musher
from musher.testing import ActuatorFaultTest


class Motor(musher.Actuator):
    name = "motor"

    def __init__(self):
        super().__init__()
        self.powered = False

    def on_set_up(self):
        pass

    def on_self_check(self):
        pass

    def on_active(self):
        self.powered = not self.emergency_stopped

    def on_low_power(self):
        self.powered = False

    def on_tear_down(self):
        self.powered = False

    def on_emergency_stop(self):
        self.powered = False


STATES = """[controller]
actuators = ["{name}"]
states = ["SetUp", "SelfCheck", "Active", "LowPower", "TearDown"]
default_time = 1000
default_state = "Uninitialized"
[actuator.{name}]
states = ["SetUp", "SelfCheck", "Active", "LowPower", "TearDown"]
times = [1000, 1000, 1000, 1000, 1000]
command = ["true"]
"""


class FaultTests(unittest.TestCase):
    def failure_of(self, motor, scenarios=300):
        test = ActuatorFaultTest(motor)
        test.scenarios = scenarios
        test.real_time_limit_s = 0.5
        test.always(lambda made, report: not (report.state == "LowPower" and made.powered))
        test.after_emergency_stop(lambda made, report: not made.powered)
        with self.assertRaises(AssertionError) as raised:
            test.run()
        return str(raised.exception)

    def test_a_sound_actuator_passes_and_is_well_tried(self):
        test = ActuatorFaultTest(Motor)
        test.always(lambda made, report: not (report.state == "LowPower" and made.powered))
        test.run()
        for count in ("killed", "failed", "repeated", "emergency_stops"):
            self.assertGreater(test.counts[count], 0, count)

    def test_a_forgotten_stop_is_found_with_the_command_that_replays_it(self):
        class Forgets(Motor):
            def on_emergency_stop(self):
                pass

        self.assertRegex(self.failure_of(Forgets), r"replay with: MUSHER_SEED=\d+ MUSHER_ONLY=[\d,]+ ")

    def test_a_callback_that_fails_when_it_runs_twice_is_found(self):
        class Once(Motor):
            def on_active(self):
                if self.powered:
                    raise musher.Failure(6101, "is on already")
                super().on_active()

        self.assertIn("fails when it runs again", self.failure_of(Once))

    def test_a_stop_that_raises_is_found(self):
        class Raises(Motor):
            def on_emergency_stop(self):
                raise ValueError("no brake")

        self.assertIn("its OnEmergencyStop() failed: the callback threw: ValueError: no brake", self.failure_of(Raises))

    def test_an_application_that_goes_on_in_an_emergency_stop_is_found(self):
        class Show(musher.FsmActuator):
            name = "show"

            def build_machine(self, machine):
                machine.add("STOP", musher.fsm.State(), musher.fsm.Role.SAFE)
                machine.build("STOP")

        class Moves(Show):
            def on_emergency_stop(self):
                pass

        for application, error in ((Show, None), (Moves, AssertionError)):
            test = ActuatorFaultTest(application, STATES.format(name="show"))
            test.after_emergency_stop(lambda made, report: not made.ticking)
            if error is None:
                test.run()
            else:
                self.assertRaises(error, test.run)

    def test_a_config_that_does_not_fit_is_refused(self):
        class Nothing(musher.Actuator):
            name = "motor"

        with self.assertRaisesRegex((musher.ConfigError, TypeError), "states|config"):
            ActuatorFaultTest(Nothing).run()
        with self.assertRaisesRegex(musher.ConfigError, "/nowhere.toml"):
            ActuatorFaultTest(Motor, "/nowhere.toml").run()
        with self.assertRaisesRegex(TypeError, "the class of an actuator"):
            ActuatorFaultTest(5)


if __name__ == "__main__":
    unittest.main()
