# [states]
"""The behaviour of an automatic door, independent of topics, threads and clocks."""

from typing import Optional

from musher import fsm


class DoorData:
    """The input of the states, and their output."""

    def __init__(self) -> None:
        self.obstacle = False  # something is in the way
        self.opening = 0.0  # 0 shut, 1 open


class Closed(fsm.State):
    def __init__(self, door: DoorData) -> None:
        self.door = door

    def declare(self, transitions: fsm.Transitions) -> None:
        transitions.to("OPEN", "open")
        transitions.on("open")

    def on_enter(self, tick: fsm.Tick) -> None:
        self.door.opening = 0.0

    def check_transition(self, tick: fsm.Tick) -> Optional[fsm.Next]:
        return fsm.Next.to("OPEN", gradually_s=2) if tick.command == "open" else None

    # Opening takes two seconds.
    def transition(self, tick: fsm.Tick) -> bool:
        self.door.opening = tick.progress
        return super().transition(tick)


class Open(fsm.State):
    def __init__(self, door: DoorData) -> None:
        self.door = door

    def declare(self, transitions: fsm.Transitions) -> None:
        transitions.to("CLOSED", "5 s later")

    def on_enter(self, tick: fsm.Tick) -> None:
        self.door.opening = 1.0

    def check_transition(self, tick: fsm.Tick) -> Optional[fsm.Next]:
        return fsm.Next.to("CLOSED", gradually_s=2) if tick.elapsed_s >= 5 else None

    def transition(self, tick: fsm.Tick) -> bool:
        self.door.opening = 1 - tick.progress
        return super().transition(tick)


# An obstacle: the door stays where it is, and opens once the path is free.
class Blocked(fsm.State):
    def __init__(self, door: DoorData) -> None:
        self.door = door
        self.from_opening = 0.0

    def declare(self, transitions: fsm.Transitions) -> None:
        transitions.to("OPEN", "the path is free")

    def on_enter(self, tick: fsm.Tick) -> None:
        self.from_opening = self.door.opening

    def check_transition(self, tick: fsm.Tick) -> Optional[fsm.Next]:
        return fsm.Next.to("OPEN", gradually_s=2)

    def transition(self, tick: fsm.Tick) -> bool:
        self.door.opening = self.from_opening + (1 - self.from_opening) * tick.progress
        return super().transition(tick)
# [states end]


# [build]
def build_door(machine: fsm.Machine, door: DoorData) -> None:
    machine.add_event("open")
    machine.add("CLOSED", Closed(door))
    machine.add("OPEN", Open(door))
    machine.add("BLOCKED", Blocked(door), fsm.Role.SAFE)
    machine.add_safety_check("an obstacle", lambda tick: not door.obstacle)
    machine.build("CLOSED")
# [build end]
