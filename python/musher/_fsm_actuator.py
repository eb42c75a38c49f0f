"""The base class of an application that is a state machine: an actuator that runs it while the robot is Active."""

import time
from typing import Any, Callable, Dict, List, Optional

from musher import _native, fsm
from musher._actuator import LONGEST_BREAK_S, Actuator
from musher._errors import Failure, ProcessKilled
from musher._log import ERROR, INFO, WARNING, call_hook, where
from musher._node import Endpoint
from musher.musher_msgs.srv import GetBehavior, SendCommand
from musher.std_msgs.msg import String
from musher.builtin_interfaces.msg import Time

_FAILED = 101  # Robot (100) + FAILED
_STATE_INVALID = 103


class FsmActuator(Actuator):
    """Derive from it, and build the machine in build_machine():

        class Show(musher.FsmActuator):
            name = "show"

            def build_machine(self, machine: musher.fsm.Machine) -> None:
                machine.add("IDLE", Idle(self.data))
                ...
                machine.build("IDLE")

        musher.run(Show)

        robot          machine
        SetUp          is built; topics are opened
        SelfCheck      self_check() is called
        Active         is started, or continues in its state (or from the start: resumes = False); ticks
        TearDown       is stopped: its state is left; on_pause()
        all others     is paused, its time stands still; on_pause()
        an emergency stop: on_pause() as soon as the tick that runs has ended, and it is paused until the stop is
                       released and Active is set again
        its process, or the node's thread, could not run for more than a minute: is stopped; on_pause(). It begins at
                       its start state

    A machine that stops because its safe state failed, or because it has none, ends the process with a non-zero exit
    code, so that its restart policy applies. Musher's loop never waits for a state; a tick that computes for ever is
    hung, if checkpoint_ms is in the config.

    Interfaces: service <name>/get_behavior (musher behavior, musher graph --behavior), topic <name>/behavior_state
    (std_msgs/String, latched: "PHOTO/COUNTDOWN"; "" when it does not run), and service <name>/send_command for its
    commands (musher behavior --send).

    In a fault-injection test there is neither transport nor clock: the machine is built, started, paused and stopped,
    and is not ticked.

    Threads: the machine, the hooks but self_check(), and the handlers of topics run on the node's thread, one at a
    time, so they share data without locks. All times are the machine's, see [controller] clock.
    """

    #: Of ticks.
    rate_hz: float = 50.0
    #: Whether the machine continues where it was when the robot is Active again; else from its start state, without
    #: commands.
    resumes: bool = True

    def __init__(self, name: str = "") -> None:
        super().__init__(name)
        if not self.rate_hz > 0:
            raise ValueError(f"the rate of ticks is more than 0 Hz, not {self.rate_hz}")
        self._machine: Optional[fsm.Machine] = None
        self._ticks: Optional[_native.FsmTicks] = None
        self._tick_key = 0
        self._opened: List[Endpoint] = []
        self._is_set_up = False
        self._ticking = False
        self._has_begun = False
        self._has_ended = False  # the application has stopped the machine, since START
        self._waits = False  # for START, in Active; each pause and stop ends that
        self._in_tick = False
        self._published: Optional[str] = None
        self._last_raised: Dict[str, str] = {}  # by the hook around a tick
        self._limited = _LimitedLog(self)

    # What a derived class writes.

    def build_machine(self, machine: fsm.Machine) -> None:
        """In SetUp: registers states, commands and safety checks, and calls machine.build(). What it raises fails
        SetUp. Runs on the worker."""
        raise NotImplementedError(f"write {type(self).__name__}.build_machine(self, machine)")

    def open_topics(self) -> None:
        """After that: topics and services of self.node. Their handlers may read the machine, send() commands, force and
        reset it."""

    def self_check(self) -> None:
        """Whether its dependencies are available; raises musher.Failure if not. May block: it runs on the worker."""

    def before_tick(self) -> None:
        """An exception is logged, and the machine goes to its safe state as if one of its states had failed."""

    def after_tick(self) -> None:
        """As before_tick()."""

    def on_pause(self) -> None:
        """The robot is in a state in which the machine is paused, or an emergency stop was engaged: bring the outputs
        to neutral. Must return at once and be idempotent. An exception is logged, and the status shows
        it until on_pause() succeeds; an emergency stop is then not confirmed."""

    def on_resume(self) -> None:
        """The robot goes to Active; called before the machine is started or continues. An exception fails the switch to
        Active, after on_pause()."""

    # What it uses.

    @property
    def machine(self) -> fsm.Machine:
        """From SetUp on."""
        if self._machine is None:
            raise Failure(_STATE_INVALID, f"{self.name} has no machine before SetUp")
        return self._machine

    @property
    def ticking(self) -> bool:
        """Whether the machine is ticked now."""
        return self._ticking

    def send(self, command: str, data: Any = None) -> None:
        """A command for the machine, of <name>/send_command or of a topic, with its data. Raises musher.Failure when the machine is
        paused, so that no command is executed hours later, and when machine.send() does. A machine that the application
        has stopped begins again by START only."""
        if self._waits and command == "START":
            return self.node._run(self._begin_by_start)  # a stop, too, pauses on the node's thread
        if not self._ticking:
            if self._waits:
                raise Failure(_STATE_INVALID, f"{self.name} stands and waits for START: musher behavior {self.name} "
                              "--send START")
            held = ", held by the emergency stop" if self.held_by_stop else ""
            raise Failure(_STATE_INVALID, f"{self.name} is paused in {self.current_state}{held}")
        self.machine.send(command, data)

    def stamp(self) -> Time:
        """The time of the machine's clock, for messages; zero in a fault-injection test."""
        sec, nanosec = self._ticks.stamp() if self._ticks is not None else (0, 0)
        return Time(sec, nanosec)

    # Inside.

    def _callbacks(self) -> Dict[str, str]:
        callbacks = super()._callbacks()
        for state, method in callbacks.items():
            if state or getattr(type(self), method) is not FsmActuator.on_state:
                raise TypeError(f"{type(self).__name__}.{method} would replace the callback that runs the machine; "
                                "override on_pause(), on_resume() or self_check()")
        return callbacks

    def on_state(self, state: str) -> None:
        """Runs the machine: do not override it."""
        if state == "SetUp":
            self._set_up()
        elif state == "SelfCheck":
            self._named("self_check", self.self_check)
        else:
            self.node._run(lambda: self._enter(state))

    def on_emergency_stop(self) -> None:
        """Pauses the machine: do not override it, but on_pause()."""
        if not self._is_set_up:
            return  # nothing moves yet, and the machine belongs to the worker
        self._ticking = self._waits = False  # at once: no further tick begins, and START begins none
        self.node._run(self._pause_at_stop, first=True)

    def _set_up(self) -> None:
        self._is_set_up = False
        machine = fsm.Machine(self.name)
        machine._log_to(self.log)
        machine.listen(_Reports(self, machine))
        self._named("build_machine", lambda: self.build_machine(machine))
        if not machine.built:
            raise Failure(_FAILED, "build_machine() has not called machine.build()")
        for warning in machine.warnings:
            self.log.warning(warning)
        self._machine = machine
        self._has_begun = self._has_ended = self._waits = False
        self.node._run(self._open_all)
        self._is_set_up = True

    def _open_all(self) -> None:
        node = self.node
        for endpoint in self._opened:
            endpoint.close()
        before = set(node._endpoints)
        try:
            self._tick_key = self._tick_key or node._handle(self._on_tick)
            self._ticks = _native.FsmTicks(self._actuator, node._mailbox, self._tick_key)
            self._state_topic = node.publisher(f"{self.name}/behavior_state", String, latched=True, depth=1)
            node.serve(f"{self.name}/get_behavior", GetBehavior, self._report)
            node.serve(f"{self.name}/send_command", SendCommand, self._send_requested)
            self._published = None
            self._publish()
            self._named("open_topics", self.open_topics)
        finally:
            self._opened = [endpoint for endpoint in node._endpoints if endpoint not in before]

    def _enter(self, state: str) -> None:
        try:
            if state == "Active":
                self._start_or_resume()
            elif state == "TearDown":
                self._pause_machine()
                self._quietly(self.machine.stop)
                self._call_on_pause(self.on_pause)
            else:
                self._pause()
        finally:
            self._publish()

    def _start_or_resume(self) -> None:
        try:
            self._resume()
        except BaseException:
            self._pause()  # an incomplete start is not left running
            raise

    def _resume(self) -> None:
        if self.emergency_stopped:
            raise Failure(_STATE_INVALID, "an emergency stop was engaged meanwhile")
        if self._ticking:
            return
        self._end_after_break()
        self._has_ended |= self._has_begun and not self.machine.running  # it was stopped in a pause
        self._waits = self._has_ended
        if self._waits:
            self.log.info("stands, and waits for START")
            return
        self._named("on_resume", self.on_resume)
        machine, ticks = self.machine, self._ticks
        assert ticks is not None
        now_ns = ticks.now_ns()
        if not machine.running:
            self._quietly(lambda: machine._native.start(now_ns, ""))
            if not machine.running:
                raise Failure(_FAILED, f"the machine stopped at its start: {machine.fault}")
            self._has_begun = True
        elif not self.resumes:
            self._quietly(machine.reset)
        if now_ns == 0:
            machine.pause()  # the first time received from /clock may have any value
        self._ticking = True
        ticks.start(self.rate_hz)
        self.node._delivery.take_longest_s()  # nothing ran yet that on_resume() could have held up

    def _begin_by_start(self) -> None:
        if not self._waits:  # a stop, or another START, came first
            return self.send("START")
        self._has_ended = self._has_begun = False
        try:
            self._start_or_resume()
        except BaseException:
            self._has_ended = self._waits = True  # a START that fails was not given
            raise

    def _end_after_break(self, waited_s: float = 0.0) -> bool:
        """As after a restart: what ran long ago does not go on by itself. Whether the machine was ended."""
        could_not_run_s = self._take_break_s(self._ticks, waited_s)
        if could_not_run_s <= LONGEST_BREAK_S or not self.machine.running:
            return False
        self._limited(WARNING, f"the machine is ended: its process could not run for {could_not_run_s:.0f} s")
        self._pause_machine()
        self._quietly(self.machine.stop)
        self._call_on_pause(self.on_pause)
        self._has_begun = False
        return True

    def _begin_after_break(self) -> None:
        try:
            self._start_or_resume()
        except Failure as failure:
            self._has_ended = self._waits = True
            self._limited(ERROR, f"waits for START: {failure.reason}")
        self._publish()

    def _on_tick(self, item: _native.Item) -> None:
        if not self._ticking:
            return
        if self._end_after_break(item.waited_s()):
            self._begin_after_break()
            return
        machine = self.machine
        self._in_tick = True
        try:
            well = self._guard_tick("before_tick", self.before_tick)
            if self._ticking:
                machine._native.run_once(item.token)
            if not well:
                self._go_safe()  # also when the tick has just left it
            self._guard_tick("after_tick", self.after_tick)
        finally:  # also after sys.exit() in a state
            self._in_tick = False
            self._publish()
            if not machine.running:
                self._ended()

    def _ended(self) -> None:
        """The machine stopped: by a fault, or by the application."""
        by_fault = self.machine.fault != "" and self.machine.mode == "SAFE_STOP"
        self._pause()
        if by_fault:
            self.give_up(_FAILED, self.machine.fault)
        else:
            self._has_ended = self._waits = True
            self.log.info("the machine has ended, and waits for START")

    def _pause_at_stop(self) -> None:
        if not self._pause():
            raise Failure(_FAILED, self._pause_fault)

    def _pause(self) -> bool:
        """False: on_pause has failed, and the outputs may not be neutral."""
        self._pause_machine()
        return self._call_on_pause(self.on_pause)

    def _pause_machine(self) -> None:
        self._ticking = self._waits = False
        if self._ticks is not None:
            self._ticks.stop()
        if self._machine is not None:
            self._machine.pause()

    def _named(self, name: str, hook: Callable[[], None]) -> None:
        """An exception becomes the failure of the state's callback, with the name of the hook."""
        try:
            call_hook(name, hook)
        except (Failure, ProcessKilled):
            raise
        except BaseException as error:
            self.log.exception(f"{name} raised an exception")
            raise Failure(_FAILED, f"{name} raised {where(error)}") from None

    def _quietly(self, work: Callable[[], None]) -> None:
        """A fault is reported by on_fault, and by the state of the machine; so is sys.exit() in a state."""
        try:
            work()
        except Failure:
            pass
        except (ProcessKilled, Exception):
            raise
        except BaseException:
            pass

    def _guard_tick(self, name: str, hook: Callable[[], None]) -> bool:
        """An exception counts as a failed state; it is logged once as long as it is the same."""
        last = self._last_raised.pop(name, "")
        try:
            call_hook(name, hook)
            return True
        except BaseException as error:
            raised = f"{name}: {where(error)}"
            self._last_raised[name] = raised
            if raised != last:
                self.log.exception(f"fault: {raised}")
        if not self._go_safe():
            self._pause()
            self.give_up(_FAILED, f"{raised}; and there is no safe state to go to")
        return False

    def _go_safe(self) -> bool:
        """False when there is no safe state."""
        machine = self.machine
        safe = machine._native.safe_state()
        if safe and machine.mode != "SAFE_STOP":
            self._quietly(lambda: machine.force(safe))
        return safe != ""

    def _publish(self) -> None:
        path = self.machine.path
        if self._published != path:
            self._published = path
            self._state_topic.publish(String(path))

    def _publish_soon(self) -> None:
        """Once the state has been entered: a machine in it has a state only then."""
        if self._is_set_up:
            self.node._post(self._publish)

    def _report(self, request: "GetBehavior.Request") -> "GetBehavior.Response":
        encoded = self.machine._native.report(self._ticking, request.history, request.format)
        report = GetBehavior.Response.from_bytes(encoded)
        report.held_by_stop = self.held_by_stop
        return report

    def _send_requested(self, request: "SendCommand.Request") -> "SendCommand.Response":
        try:
            urgent = self._ticks is None or self.machine.is_urgent(request.command)
            if not urgent:
                self.check_not_late()
            self.send(request.command)
        except Failure as failure:
            return SendCommand.Response(False, failure.reason)
        return SendCommand.Response(True, "")


class _Reports(fsm.Listener):
    """Logs what the machine reports."""

    def __init__(self, actuator: FsmActuator, machine: fsm.Machine) -> None:
        self._actuator = actuator
        self._machine = machine

    def on_change(self, change: fsm.Change) -> None:
        actuator = self._actuator
        line = f"{change.from_state} -> {change.to_state}: {change.cause}"
        if change.command:
            line += f" by {change.command}"
        if change.cause == "unsafe":
            line += f", {self._machine.unsafe}"
        actuator._limited(INFO, line)
        if not actuator._in_tick:
            actuator._publish_soon()

    def on_kept(self, command: str, state: str) -> None:
        self._actuator._limited(WARNING, f"{state} keeps command {command}, and all later ones wait behind it; declare "
                                         f"transitions.defer(\"{command}\") to let them pass")

    def on_unhandled(self, command: str, state: str) -> None:
        self._actuator._limited(WARNING, f"command {command} is not handled in {state}")

    def on_fault(self, fault: str) -> None:
        self._actuator._limited(ERROR, f"fault: {fault}")


class _LimitedLog:
    """At most so many lines within a second, so that a fault in each tick does not fill the disk."""

    _MOST = 20

    def __init__(self, actuator: FsmActuator) -> None:
        self._actuator = actuator
        self._since = -1.0
        self._lines = 0

    def __call__(self, level: int, line: str) -> None:
        now = time.monotonic()
        if self._since < 0 or now - self._since >= 1:
            self._since, self._lines = now, 0
        self._lines += 1
        if self._lines <= self._MOST:
            self._actuator.log._write(level, line)
        if self._lines == self._MOST:
            self._actuator.log._write(level, "further messages within this second are suppressed")


__all__ = ["FsmActuator"]
