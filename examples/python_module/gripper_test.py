#!/usr/bin/python3
"""Tests the gripper with injected faults, in virtual time."""

import unittest

from gripper import Gripper
from musher.testing import ActuatorFaultTest, Report


class GripperTest(unittest.TestCase):
    def test_has_power_only_where_it_should(self) -> None:
        test = ActuatorFaultTest(Gripper, "robot.toml")

        @test.always
        def power(gripper: Gripper, report: Report) -> None:
            assert not (report.state == "LowPower" and gripper.powered)
            assert not (report.emergency_stop and gripper.powered)

        @test.after_emergency_stop
        def no_power(gripper: Gripper, report: Report) -> None:
            assert not gripper.powered

        test.run()


if __name__ == "__main__":
    unittest.main()
