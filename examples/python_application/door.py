#!/usr/bin/python3
"""The door as an actuator of the robot."""

import musher
from musher.std_msgs.msg import Bool, Float32, String

from door_states import DoorData, build_door


class Door(musher.FsmActuator):
    name = "door"  # as in the config
    rate_hz = 50

    def __init__(self) -> None:
        super().__init__()
        self.door = DoorData()

    def build_machine(self, machine: musher.fsm.Machine) -> None:
        build_door(machine, self.door)

    def open_topics(self) -> None:
        self.node.subscribe("door/command", String, self.obey)
        self.node.subscribe("door/obstacle", Bool, self.see)
        self.opening = self.node.publisher("door/opening", Float32)

    def after_tick(self) -> None:
        self.opening.publish(Float32(self.door.opening))

    def obey(self, word: String) -> None:
        try:
            self.send(word.data)
        except musher.Failure as failure:
            self.log.info(failure.reason)

    def see(self, obstacle: Bool) -> None:
        self.door.obstacle = obstacle.data


if __name__ == "__main__":
    musher.run(Door)
