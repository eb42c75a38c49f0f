#!/usr/bin/python3
"""Tests new_python_module with injected faults, in virtual time."""

import unittest

from musher import testing

from new_python_module import NewPythonModule


class NewPythonModuleTest(unittest.TestCase):
    def test_has_power_only_in_active_and_never_in_an_emergency_stop(self) -> None:
        test = testing.ActuatorFaultTest(NewPythonModule, "robot.toml")

        @test.always
        def power(new_python_module: NewPythonModule, report: testing.Report) -> None:
            assert not (report.state == "LowPower" and new_python_module.powered)
            assert not (report.emergency_stop and new_python_module.powered)

        @test.after_emergency_stop
        def no_power(new_python_module: NewPythonModule, report: testing.Report) -> None:
            assert not new_python_module.powered

        test.run()


if __name__ == "__main__":
    unittest.main()
