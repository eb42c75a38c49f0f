"""State machines for applications: states are classes, with the engine of C++ (behavior/fsm).

    class Idle(fsm.State):
        def declare(self, transitions: fsm.Transitions) -> None:
            transitions.to("GREETING", "a face is seen")

        def check_transition(self, tick: fsm.Tick) -> Optional[fsm.Next]:
            return fsm.Next.to("GREETING") if robot.sees_face else None

    machine = fsm.Machine("greeter")
    machine.add("IDLE", Idle())
    machine.add("GREETING", Greeting())
    machine.add("SAFE_STOP", SafeStop(), fsm.Role.SAFE)
    machine.add_safety_check("too close", lambda tick: not robot.too_close)
    machine.build("IDLE")
    machine.start(now_s)
    ...  # each 20 ms: machine.run_once(now_s)

The engine reads no clock: the caller of a tick passes its time, so a test runs in virtual time. An actuator that runs
a machine is a musher.FsmActuator.

Modes: NORMAL; TRANSITIONING during a gradual transition; SAFE_STOP in the safe state. The machine goes to its safe
state in the same tick when a safety check fails, or when a state raises, goes where it has not declared to go, or
transitions for too long. It leaves the safe state only when that state decides so and every check passes again. A
fault of the safe state itself stops the machine.

Threads: one at a time.
"""

import dataclasses
import enum
from typing import Any, Callable, Dict, List, Optional, Sequence, Set, Tuple, Union

from musher import _native
from musher._log import Log, log, where

Archive = _native.FsmArchive
Change = _native.FsmChange
Next = _native.FsmNext
Tick = _native.FsmTick
Transitions = _native.FsmTransitions


class Role(enum.IntEnum):
    """What a state is for its machine."""

    NORMAL = 0
    SAFE = 1  #: the machine goes there when it is unsafe or a state fails; at most one
    FINAL = 2  #: the end: decides nothing more; left by force(), reset() and for the safe state


class Into(enum.IntEnum):
    """How a transition enters a state that holds a machine: transitions.to("SHOW", "on", into=fsm.Into.HISTORY), and
    Next.to("SHOW", into=fsm.Into.HISTORY)."""

    START = 0  #: at its start state, or as Nested says
    HISTORY = 1  #: where it was left; a machine inside of that state at its start
    DEEP_HISTORY = 2  #: where it was left, down to the innermost state


class State:
    """One state. Derive from it, and write the functions that it needs. One line a tick:

        on_enter                             the tick in which the last state was left
        check_transition: stays, run         each tick from then on
        check_transition: to another         decided; in the same tick:
          transition -> False                  a gradual one continues in the next tick; run is not called
          transition -> True, on_exit          and the next state's on_enter

    All of them return at once: they do not sleep, wait or read a clock; the tick has the time. What one of them
    raises leads to the safe state, and is reported with the state and the function.
    """

    def declare(self, transitions: Transitions) -> None:
        """Once, when the machine is built: its transitions, and the commands that it handles or defers.

        transitions.to("IDLE", "alone") is a transition: the state is searched in this machine, then in the machine
        around it, and so on; "SHOW/PHOTO" is PHOTO in a machine that SHOW holds. transitions.on("photo") is a command
        that it handles; transitions.defer("photo") one that waits while this state is present: later ones pass it."""

    def on_enter(self, tick: Tick) -> None:
        """The state is entered."""

    def run(self, tick: Tick) -> None:
        """Each tick in which the state stays; not in that in which it was entered."""

    def check_transition(self, tick: Tick) -> Optional[Next]:
        """What is next: Next.to("OPEN"), Next.to("OPEN", gradually_s=2) or Next.handle(), which stays and has handled
        tick.command; nothing, or Next.stay(), to stay. A command is consumed by this call: by a transition, by
        Next.handle(), or as unhandled, which is counted and reported; .keep_command() keeps it queued."""
        return None

    def transition(self, tick: Tick) -> bool:
        """Each tick of a transition away from here; whether it is complete: by default after its time."""
        return tick.progress >= 1

    def on_exit(self, tick: Tick) -> None:
        """The state is left, also when the machine is forced, made safe or stopped; not when on_enter failed."""

    def persist(self, archive: Archive) -> None:
        """Saves and restores what another process needs to continue from here: for Machine.save(), and for restore().
        The same function does both, a line for each field:

            self.greeted = archive.field("greeted", self.greeted)                # a bool, an int, a float or a str
            self.lost_for_s = archive.duration_s("lost_for", self.lost_for_s)
        """


class Nested(State):
    """A state that holds a machine of its own, with the same rules, to any depth.

        photo = fsm.Machine("photo")
        photo.add("CONFIRM", Confirm())
        photo.add("DONE", fsm.State(), fsm.Role.FINAL)
        machine.add("PHOTO", fsm.Nested(photo, "CONFIRM", finished="TRACKING"))

    The inner machine starts when the state is entered (`resumes`: in the state in which it was left), is ticked with
    it, and is stopped when it is left. A command that decide() neither handles nor keeps goes to the inner machine, if
    that has one of the same name; with `inner_first` it goes there first, and decide() gets what is left. Once the
    inner machine is in a final state, this one goes to `finished`.

    Several machines run side by side: fsm.Nested([(arms, "WAVE"), (face, "SMILE")]). A command goes to all that have
    it, and the state is finished once all are.

    on_enter and run of a derived class come before the inner machine, on_exit after it.
    """

    def __init__(self, machine: Union["Machine", Sequence[Tuple["Machine", str]]], start: str = "", *,
                 finished: str = "", resumes: bool = False, inner_first: bool = False) -> None:
        regions = [(machine, start)] if isinstance(machine, Machine) else machine
        if not isinstance(regions, (list, tuple)) or not regions:
            raise TypeError(f"a state holds a musher.fsm.Machine, not {machine!r}")
        for inner, _ in regions:
            if not isinstance(inner, Machine):
                raise TypeError(f"a state holds a musher.fsm.Machine, not {inner!r}")
        self.inner = regions[0][0]
        self._regions = [(inner._native, at) for inner, at in regions]
        self._options = (finished, resumes, inner_first)

    def decide(self, tick: Tick) -> Optional[Next]:
        """As check_transition(); called before the inner machine."""
        return None


class Listener:
    """What a machine reports. An exception is logged and counted; it does not disturb the machine."""

    def on_change(self, change: Change) -> None:
        """The machine is in its new state; on_enter of that state follows."""

    def on_kept(self, command: str, state: str) -> None:
        """The state stays and keeps this command: as long as it does, no other is handled. Once for each of both."""

    def on_unhandled(self, command: str, state: str) -> None:
        """A command was not handled in this state."""

    def on_fault(self, fault: str) -> None:
        """Before the machine goes to its safe state or stops: "SHOW/PHOTO: OnEnter: …"."""


@dataclasses.dataclass(frozen=True)
class Replayed:
    """What Machine.replay() has made of a recording."""

    ticks: int
    changes: int
    difference: Optional[str]  #: the first change that differs from the recorded one, with both; None: none


class Machine:
    """A machine of states. See the module.

    `history`: how many changes are kept; `commands`: how many may be queued, `commands_per_tick`: how many of them a
    tick handles at most; for each after the first the state is checked and run with a step of no time. A longer gradual
    transition than `longest_transition_s` is a fault.
    """

    def __init__(self, name: str = "machine", *, history: int = 64, commands: int = 32, commands_per_tick: int = 1,
                 longest_transition_s: float = 10.0) -> None:
        self._native = _native.FsmMachine(name, history, commands, commands_per_tick, longest_transition_s)
        self._urgent: Set[str] = set()
        self._log_to(log)

    def _log_to(self, where_to: Log) -> None:
        """The tracebacks of its states, once as long as an exception is the same."""
        last = [""]

        def report(error: BaseException) -> None:
            text = where(error)
            if text != last[0] and isinstance(error, Exception):
                where_to.traceback(error)
            last[0] = text

        self._native.report_exceptions(report)

    # Before build().

    def add(self, name: str, state: State, role: Role = Role.NORMAL) -> None:
        """Registers a state."""
        if not isinstance(state, State):
            raise TypeError(f"the state {name} is an object of a class derived from musher.fsm.State, not {state!r}")
        if hasattr(state, "run_once"):
            raise TypeError(f"the state {name} has a run_once(), which no machine calls; a state has run()")
        if isinstance(state, Nested):
            if type(state).check_transition is not State.check_transition:
                raise TypeError(f"{type(state).__name__} has a machine inside: override decide(), not "
                                "check_transition()")
            self._native.add_nested(name, int(role), _hooks(state, Nested, "decide"), state._regions,
                                    *state._options)
        else:
            self._native.add(name, int(role), _hooks(state, State, "check_transition"))

    def add_event(self, name: str, *, urgent: bool = False, data: Optional[type] = None) -> None:
        """A command by its name. An urgent one is handled before all queued ones, and drops them. `data`: the dataclass
        that it carries, whose fields are bool, int, float or str and have defaults; a state reads it as tick.data."""
        self._native.add_event(name, urgent, data)
        if urgent:
            self._urgent.add(name)

    def is_urgent(self, event: str) -> bool:
        """Whether there is an event of that name, and it was registered as urgent."""
        return event in self._urgent

    def add_safety_check(self, name: str, is_safe: Callable[[Tick], bool]) -> None:
        """Called at the beginning and at the end of each tick; False leads to the safe state."""
        if not callable(is_safe):
            raise TypeError(f"the safety check {name} is a function, not {is_safe!r}")
        self._native.add_safety_check(name, is_safe)

    def add_data(self, name: str, persist: Callable[[Archive], None]) -> None:
        """Data that several states share, saved and restored with them: `persist` does so as State.persist()."""
        if not callable(persist):
            raise TypeError(f"the data {name} is saved by a function, not by {persist!r}")
        self._native.add_data(name, persist)

    def build(self, start: str) -> None:
        """Calls declare() of the states, and checks the machine: dead ends, traps, unknown names. Raises musher.Failure
        with all errors, a line each; then add what is missing, and build again."""
        self._native.build(start)

    @property
    def built(self) -> bool:
        return self._native.built()

    @property
    def warnings(self) -> List[str]:
        """Those of build(): a state that only force() reaches."""
        return self._native.warnings()

    # Run. The calls that change the state raise musher.Failure when a state fails in it.

    def start(self, now_s: float, state: str = "") -> None:
        """Enters the start state, or this one. Also again after stop()."""
        self._native.start(_ns(now_s), state)

    def run_once(self, now_s: float) -> None:
        """A tick. A time before the last one counts as no elapsed time."""
        self._native.run_once(_ns(now_s))

    def pause(self) -> None:
        """The time until the next tick does not count."""
        self._native.pause()

    def stop(self) -> None:
        """Leaves the state permanently."""
        self._native.stop()

    def send(self, command: str, data: Any = None) -> None:
        """A command for the state to handle, with its data; the only call that a state or a listener may make. Raises
        musher.Failure when it is not registered, when the queue is full, and when the machine does not run."""
        self._native.send(command, data)

    def force(self, state: str) -> None:
        """To that state at once, whether declared or not."""
        self._native.force(state)

    def reset(self) -> None:
        """Forces the start state and drops queued commands."""
        self._native.reset()

    def listen(self, listener: Listener) -> None:
        """Reports to it from now on."""
        if not isinstance(listener, Listener):
            raise TypeError(f"a listener is an object of a class derived from musher.fsm.Listener, not {listener!r}")
        self._native.listen(listener.on_change, lambda unhandled: listener.on_unhandled(*unhandled), listener.on_fault,
                            lambda kept: listener.on_kept(*kept))

    def record(self, write: Callable[[str], Any]) -> None:
        """Records all that happens to the machine from its start on, a line each, for replay(): machine.record(file.write).
        Inputs that states read besides their ticks are recorded with record_input(). Raises musher.Failure while the
        machine runs. An exception of `write` is logged and counted; it does not disturb the machine."""
        if not callable(write):
            raise TypeError(f"what writes a recording is a function, not {write!r}")
        self._native.record(write)

    def record_input(self, name: str, text: str) -> None:
        """An input of the application that states will read: a message, a measurement. For each such one, between ticks;
        `text` is in a format of the application."""
        self._native.record_input(name, text)

    def replay(self, recording: str, apply: Optional[Callable[[str, str], Any]] = None, *,
               file: str = "recording") -> Replayed:
        """Repeats a recording of a machine that was built like this one, and compares the changes: states that depend
        only on their ticks, their own data and the recorded inputs make the same ones. `apply` gets the name and the
        text of each input; what it raises ends the replay. Raises musher.Failure with the line, named with `file`,
        where the recording does not fit, and while the machine runs. The machine stays as it is at the end of the
        recording. Continues after a difference."""
        return Replayed(*self._native.replay(recording, file, apply or _no_input))

    def save(self) -> str:
        """The machine between two ticks: state, times, queued commands with their data, history, and what persist() of
        its states and add_data() save, also of the machines inside. A TOML text that a person can read and edit, and
        that a machine of C++ with the same states and fields reads, too. Raises musher.Failure, naming the state, when
        one cannot save itself, and in a tick."""
        return self._native.save()

    def restore(self, saved: str, now_s: float, *, file: str = "saved") -> None:
        """Continues from the text of save(), also from one of C++, as if the last tick had been at `now_s`. No state is
        entered. The machine is built like the saved one, and does not run. Raises musher.Failure with all errors, a
        line each, as "file:line:column: error: …"; then nothing has changed."""
        self._native.restore(saved, file, _ns(now_s))

    # Status.

    @property
    def name(self) -> str:
        return self._native.name()

    @property
    def running(self) -> bool:
        return self._native.running()

    @property
    def mode(self) -> str:
        """"NORMAL", "TRANSITIONING" or "SAFE_STOP"."""
        return self._native.mode()

    @property
    def state(self) -> str:
        """"SHOW"; "" when the machine does not run."""
        return self._native.state()

    @property
    def path(self) -> str:
        """"SHOW/PHOTO" where a state holds a machine."""
        return self._native.path()

    @property
    def ticks(self) -> int:
        return self._native.ticks()

    @property
    def time_s(self) -> float:
        """Machine time: the sum of the steps from tick to tick since the start."""
        return self._native.time_s()

    @property
    def elapsed_s(self) -> float:
        """Machine time since the state was entered."""
        return self._native.elapsed_s()

    @property
    def unsafe(self) -> str:
        """The safety check that brought it to its safe state; "": none."""
        return self._native.unsafe()

    @property
    def fault(self) -> str:
        """The last fault, "SHOW/PHOTO: OnEnter: …"; "": none."""
        return self._native.fault()

    @property
    def waiting_commands(self) -> int:
        return self._native.waiting_commands()

    @property
    def commands(self) -> List[str]:
        """The registered ones."""
        return self._native.commands()

    @property
    def history(self) -> List[Change]:
        """The last changes, oldest first."""
        return self._native.history()

    @property
    def counts(self) -> Dict[str, int]:
        """Since it was built: "changes", "unhandled", "superseded", "refused", "faults", "listener_faults"."""
        return self._native.counts()

    def picture(self, format: str = "dot") -> str:
        """The machine with its present state marked: "dot" for Graphviz, "mermaid" for a Markdown page."""
        return self._native.picture(format)


def _no_input(name: str, text: str) -> None:
    raise ValueError(f"the recording has the input {name}, and nothing applies it")


def _hooks(state: State, base: type, check: str) -> Tuple[Optional[Callable[..., Any]], ...]:
    """Its functions in the order of native/fsm_state.hpp; None: that of the base class, which does nothing."""
    def own(name: str) -> Optional[Callable[..., Any]]:
        function = getattr(state, name)
        inherited = name not in getattr(state, "__dict__", ()) and getattr(type(state), name) is getattr(base, name)
        return None if inherited else function

    return tuple(own(name) for name in ("declare", "on_enter", "run", check, "transition", "on_exit", "persist"))


def _event_fields(data: type) -> List[str]:
    """The names of the fields of the data of an event."""
    if not isinstance(data, type) or not dataclasses.is_dataclass(data):
        raise TypeError(f"the data of an event is a dataclass, not {data!r}")
    fields = dataclasses.fields(data)
    for field in fields:
        if field.default is dataclasses.MISSING or type(field.default) not in (bool, int, float, str):
            raise TypeError(f"{data.__name__}.{field.name}: a field of an event has a bool, an int, a float or a str "
                            "as its default")
    return [field.name for field in fields]


def _check_event(value: Any, defaults: Any, fields: List[str]) -> None:
    """Raises TypeError unless `value` is such an object, with fields of their types."""
    if type(value) is not type(defaults):
        raise TypeError(f"the command carries a {type(defaults).__name__}, not {value!r}")
    for name in fields:
        if type(getattr(value, name)) is not type(getattr(defaults, name)):
            raise TypeError(f"{type(value).__name__}.{name} is a {type(getattr(defaults, name)).__name__}, not "
                            f"{getattr(value, name)!r}")


def _ns(seconds: float) -> int:
    return round(seconds * 1e9)


__all__ = ["Archive", "Change", "Into", "Listener", "Machine", "Nested", "Next", "Replayed", "Role", "State", "Tick",
           "Transitions"]
