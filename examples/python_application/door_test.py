#!/usr/bin/python3
"""Tests the door without a robot, in virtual time."""

import unittest

from musher import fsm
from musher.testing import ActuatorFaultTest, Report

from door import Door
from door_states import DoorData, build_door


class DoorTest(unittest.TestCase):
    def setUp(self) -> None:
        self.door = DoorData()
        self.machine = fsm.Machine("door")
        build_door(self.machine, self.door)
        self.now_s = 0.0
        self.machine.start(self.now_s)

    def wait(self, time_s: float) -> None:
        for _ in range(round(time_s / 0.02)):
            self.now_s += 0.02
            self.machine.run_once(self.now_s)

    def test_opens_in_two_seconds_and_shuts_itself_after_five(self) -> None:
        self.machine.send("open")
        self.wait(1)
        self.assertAlmostEqual(self.door.opening, 0.5, delta=0.02)
        self.wait(1.1)
        self.assertEqual(self.machine.path, "OPEN")
        self.wait(8)
        self.assertEqual(self.machine.path, "CLOSED")

    def test_stops_where_it_is_at_an_obstacle_and_opens_once_the_path_is_free(self) -> None:
        self.machine.send("open")
        self.wait(1)
        before = self.door.opening
        self.door.obstacle = True
        self.wait(1)
        self.assertEqual((self.machine.mode, self.door.opening), ("SAFE_STOP", before))
        self.door.obstacle = False
        self.wait(1)
        self.assertAlmostEqual(self.door.opening, (before + 1) / 2, delta=0.02)
        self.wait(1.2)
        self.assertEqual(self.machine.path, "OPEN")

    def test_is_paused_outside_of_active_under_injected_faults(self) -> None:
        test = ActuatorFaultTest(Door, "robot.toml")

        @test.always
        def paused(door: Door, report: Report) -> None:
            assert not (door.ticking and report.state != "Active")

        @test.after_emergency_stop
        def stopped(door: Door, report: Report) -> None:
            assert not door.ticking

        test.run()


if __name__ == "__main__":
    unittest.main()
