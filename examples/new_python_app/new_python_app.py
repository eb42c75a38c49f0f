#!/usr/bin/python3
"""NewPythonApp as an actuator of the robot: its machine runs in Active, and pauses in the other states."""

import musher
import musher.std_msgs.msg as std_msgs

import new_python_app_states as states


class NewPythonApp(musher.FsmActuator):
    name = "new_python_app"  # as in the config
    rate_hz = 50

    def __init__(self) -> None:
        super().__init__()
        self.data = states.NewPythonAppData()

    def build_machine(self, machine: musher.fsm.Machine) -> None:
        states.build(machine, self.data)

    def open_topics(self) -> None:
        self.node.subscribe("new_python_app/obstacle", std_msgs.Bool, self.see)
        self.progress = self.node.publisher("new_python_app/progress", std_msgs.Float32)

    def after_tick(self) -> None:
        self.progress.publish(std_msgs.Float32(self.data.progress))

    def see(self, obstacle: std_msgs.Bool) -> None:
        self.data.obstacle = obstacle.data


if __name__ == "__main__":
    musher.run(NewPythonApp)
