"""The behaviour of NewPythonApp, independent of topics, threads and clocks."""

from __future__ import annotations

from musher import fsm


class NewPythonAppData:
    """The input of the states, and their output."""

    def __init__(self) -> None:
        self.obstacle = False  # input: work must pause
        self.progress = 0.0  # output: 0 to 1


class Idle(fsm.State):
    def declare(self, transitions: fsm.Transitions) -> None:
        transitions.to("WORKING", "go")
        transitions.on("go")

    def check_transition(self, tick: fsm.Tick) -> fsm.Next | None:
        return fsm.Next.to("WORKING") if tick.command == "go" else None


class Working(fsm.State):
    def __init__(self, data: NewPythonAppData) -> None:
        self.data = data

    def declare(self, transitions: fsm.Transitions) -> None:
        transitions.to("IDLE", "3 s later")

    def on_enter(self, tick: fsm.Tick) -> None:
        self.data.progress = 0.0

    def run(self, tick: fsm.Tick) -> None:
        self.data.progress = tick.elapsed_s / 3

    def check_transition(self, tick: fsm.Tick) -> fsm.Next | None:
        return fsm.Next.to("IDLE") if tick.elapsed_s >= 3 else None


# An obstacle: the application waits, and starts again from IDLE once the path is free.
class Waiting(fsm.State):
    def declare(self, transitions: fsm.Transitions) -> None:
        transitions.to("IDLE", "the path is free")

    def check_transition(self, tick: fsm.Tick) -> fsm.Next | None:
        return fsm.Next.to("IDLE")


def build(machine: fsm.Machine, data: NewPythonAppData) -> None:
    machine.add_event("go")
    machine.add("IDLE", Idle())
    machine.add("WORKING", Working(data))
    machine.add("WAITING", Waiting(), fsm.Role.SAFE)
    machine.add_safety_check("an obstacle", lambda tick: not data.obstacle)
    machine.build("IDLE")
