#!/usr/bin/python3
"""Tests new_python_app without a robot, in virtual time."""

import unittest

from musher import fsm, testing

import new_python_app_states as states
from new_python_app import NewPythonApp


class NewPythonAppTest(unittest.TestCase):
    def setUp(self) -> None:
        self.data = states.NewPythonAppData()
        self.machine = fsm.Machine("new_python_app")
        states.build(self.machine, self.data)
        self.now_s = 0.0
        self.machine.start(self.now_s)

    def wait(self, time_s: float) -> None:
        for _ in range(round(time_s / 0.02)):
            self.now_s += 0.02
            self.machine.run_once(self.now_s)

    def test_works_for_three_seconds_after_go(self) -> None:
        self.machine.send("go")
        self.wait(1.5)
        self.assertEqual(self.machine.path, "WORKING")
        self.assertAlmostEqual(self.data.progress, 0.5, delta=0.05)
        self.wait(2)
        self.assertEqual(self.machine.path, "IDLE")

    def test_waits_while_there_is_an_obstacle(self) -> None:
        self.machine.send("go")
        self.wait(1)
        self.data.obstacle = True
        self.wait(1)
        self.assertEqual(self.machine.mode, "SAFE_STOP")
        self.data.obstacle = False
        self.wait(3)
        self.assertEqual(self.machine.path, "IDLE")

    def test_is_paused_outside_of_active_under_injected_faults(self) -> None:
        test = testing.ActuatorFaultTest(NewPythonApp, "robot.toml")

        @test.always
        def paused(new_python_app: NewPythonApp, report: testing.Report) -> None:
            assert not (new_python_app.ticking and report.state != "Active")

        @test.after_emergency_stop
        def stopped(new_python_app: NewPythonApp, report: testing.Report) -> None:
            assert not new_python_app.ticking

        test.run()


if __name__ == "__main__":
    unittest.main()
