"""The base class of a robot's module in Python."""

import atexit
import contextlib
import difflib
import math
import os
import re
import signal
import sys
import threading
from typing import Callable, ContextManager, Dict, List, NoReturn, Optional, Set, Tuple, Type, TypeVar, Union

from musher import _native
from musher._errors import ConfigError, Failure, Key, ProcessKilled
from musher._log import Log, call_hook, short, where
from musher._node import Node, request_here

_FAILED = 101  # Robot (100) + FAILED
_STATE_INVALID = 103
_LONGEST_END_S = 2.0  # of callbacks and threads that still run
LONGEST_BREAK_S = 60.0  # of a process, after which what ran goes on; as in base/break_watch.hpp

#: The methods that are callbacks of the built-in states.
STATE_METHODS = {
    "on_set_up": "SetUp",
    "on_self_check": "SelfCheck",
    "on_active": "Active",
    "on_protected": "Protected",
    "on_deactive": "DeActive",
    "on_low_power": "LowPower",
    "on_ota": "OTA",
    "on_error": "Error",
    "on_tear_down": "TearDown",
}
_METHOD_OF = {state: method for method, state in STATE_METHODS.items()}

_Method = TypeVar("_Method", bound=Callable[..., None])


def state(*names: str) -> Callable[[_Method], _Method]:
    """Makes a method the callback of these states, also of states that the config adds.

        @musher.state("Docked", "Parked")
        def hold_still(self) -> None: ...
    """
    if not names or not all(isinstance(name, str) and name for name in names):
        raise TypeError('@musher.state takes names of states: @musher.state("Docked")')

    def mark(method: _Method) -> _Method:
        setattr(method, "_musher_states", names)
        return method

    return mark


class Actuator:
    """Derive from it, write a method for each state, and start it by musher.run().

    A state's method returns nothing when it has succeeded, and raises musher.Failure with a code and a reason
    when it has failed; any other exception is a failure, too. The methods must be idempotent: one that failed
    may run again. They run one at a time on a worker thread; meanwhile the process keeps answering queries.
    One that takes long calls checkpoint() and stop_requested() now and then.

    on_state(self, state) is the callback of all states without a method of their own.
    """

    #: The actuator's name in the state config; empty: $MUSHER_ACTUATOR, which a controller sets, else the
    #: name of the class in the form `left_gripper`.
    name: str = ""
    #: The code of this module, to which failure() adds a Key: 6100.
    module_code: int = 100

    def __init__(self, name: str = "") -> None:
        chosen = name or type(self).name or os.environ.get("MUSHER_ACTUATOR", "") or _snake(type(self).__name__)
        if not isinstance(chosen, str):
            raise TypeError(f"the name of an actuator is a str, not {chosen!r}")
        self.name = chosen
        self.log = Log(chosen)
        self._node: Optional[Node] = None
        self._node_lock = threading.Lock()
        self._pause_fault = ""  # of an application
        self._handle = _native.ActuatorHandle(chosen, self)
        for state_name, method in self._callbacks().items():
            self._handle.register(state_name, method)

    # What a state's method uses.

    def failure(self, key: int, reason: str = "") -> Failure:
        """The Failure with the code of this module plus `key`: raise self.failure(Key.DEVICE_ERROR, "…")."""
        return Failure(self.module_code + int(key), reason)

    def checkpoint(self, allowance_s: Optional[float] = None) -> None:
        """The calling thread makes progress; its next checkpoint follows within this time (none: checkpoint_ms
        of the config). A thread that gives none for longer is hung, and the process is restarted.

        In a state's method: watched from its beginning to its end. In another thread: from its first
        checkpoint on, until the next callback begins, or checkpoint(math.inf).
        """
        self._actuator.checkpoint(allowance_s)

    def stop_requested(self) -> bool:
        """In a long callback: whether the controller no longer waits for it, or an emergency stop was engaged on its
        way up; return at the next safe point."""
        return self._actuator.stop_requested()

    def report_degraded(self, code: int, reason: str) -> None:
        """In on_self_check: a part does not work, but the actuator can work without it."""
        self._actuator.report_degraded(code, reason)

    # From any thread.

    @property
    def current_state(self) -> str:
        """The state the actuator is in; before SetUp is done the config's default state."""
        return self._actuator.current_state()

    @property
    def emergency_stopped(self) -> bool:
        """Whether an emergency stop is engaged. Methods of less active states run all the same."""
        return self._actuator.emergency_stopped()

    @property
    def held_by_stop(self) -> bool:
        """Whether a stop is engaged, or was, and no callback of the state or a higher one has succeeded since."""
        return self._actuator.held_by_stop()

    def allowed(self, capability: str) -> ContextManager[None]:
        """Raises musher.NotAllowed if this function may not run now, according to [capability.<name>] of the
        config: `with self.allowed("grip"): …`, or as a statement of its own."""
        self._actuator.allowed(capability, self.module_code)
        return contextlib.nullcontext()

    def check_not_late(self) -> None:
        """At the beginning of a handler of a topic, service or action that may move the robot: raises musher.Failure
        when what it handles may be older than 5 s. It has waited for the node's thread, or for this process, which was
        stopped, or for its computer, which was suspended."""
        request = request_here()
        late = None if request is None else request.may_be_late(self.name)
        if late is not None:
            raise Failure(_STATE_INVALID, late)

    def give_up(self, code: int, reason: str) -> None:
        """The actuator cannot continue: the process exits with 1, and its restart policy applies."""
        self._actuator.give_up(code, reason)

    @property
    def node(self) -> Node:
        """For topics, services and actions of this actuator, from on_set_up on. In a fault-injection test it has
        no transport: publishing does nothing, and nothing is received."""
        with self._node_lock:  # one for all threads
            if self._node is None:
                native = self._actuator.node()
                if native is None and not self._actuator.under_test():
                    raise Failure(_STATE_INVALID, f"{self.name} is not started: open its topics in on_set_up")
                self._node = Node._of(native, self.log)
                self._node._delivery.watch = self._watch
            return self._node

    def on_emergency_stop(self) -> None:
        """Stop all motion now. Runs on a thread of its own, also beside a running callback, and again at the
        end of the one that was running: must be idempotent, use only data that is safe to use from any thread,
        and return at once. Until a callback on the way up has ended, the stop is not confirmed."""

    # For a program that does more than run one actuator; else musher.run().

    def start(self, config: str = "") -> None:
        """Reads the state config (empty: $MUSHER_CONFIG), runs SetUp and joins the machine. Then call wait()
        or shutdown()."""
        self._prepare(config)
        _started.add(self)
        try:
            self._actuator.start()
        except Failure:
            _started.discard(self)
            raise

    def wait(self) -> int:
        """Blocks until TearDown is done or give_up() is called; returns the exit code for the program."""
        codes: List[int] = []
        native = self._actuator
        # Not on the main thread, so that it keeps running Python's signal handlers.
        waiter = threading.Thread(target=lambda: codes.append(native.wait()), daemon=True)
        waiter.start()
        waiter.join()
        self._leave()
        return codes[0]

    def shutdown(self) -> None:
        """Leaves the machine without TearDown; waits for a running callback. Idempotent."""
        self._actuator.shutdown()
        self._leave()

    def _leave(self) -> None:
        _started.discard(self)
        if self._node is not None:
            self._node.close()

    # Inside.

    def _watch(self, busy: bool) -> None:
        """The node's thread makes progress: it begins to handle something, or waits for more."""
        self._actuator.checkpoint(None if busy else math.inf)

    @property
    def _actuator(self) -> _native.ActuatorHandle:
        try:
            return self._handle
        except AttributeError:
            raise RuntimeError(
                f"{type(self).__name__}.__init__ has not called super().__init__() yet") from None

    def _callbacks(self) -> Dict[str, str]:
        found: Dict[str, str] = {}
        for method in dir(type(self)):
            function = getattr(type(self), method, None)
            states = getattr(function, "_musher_states", ())
            if method in STATE_METHODS and not states:
                states = (STATE_METHODS[method],)
            if method == "on_state":
                states = ("",)
            for state_name in states:
                if state_name in found:
                    raise TypeError(f"{type(self).__name__} has two callbacks for the state {state_name}: "
                                    f"{found[state_name]} and {method}")
                found[state_name] = method
        return found

    def _prepare(self, config: str) -> None:
        self._actuator.init(str(config))
        callbacks = self._callbacks()
        if "" in callbacks:
            return
        for listed in self._actuator.listed_states():
            if listed not in callbacks:
                raise ConfigError(110, f"{self._actuator.config_file()} lists the state '{listed}' for "
                                       f"{self.name}, but {type(self).__name__} has no callback for it; "
                                       + self._hint(listed, callbacks))

    def _hint(self, missing: str, callbacks: Dict[str, str]) -> str:
        method = _METHOD_OF.get(missing)
        if method is None:
            return f'write a method with @musher.state("{missing}")'
        own = [name for name in vars(type(self)) if name not in callbacks.values() and name != "on_emergency_stop"]
        near = difflib.get_close_matches(method, own, 1)
        return f"write {method}(self)" + (f" (its {near[0]} is not one)" if near else "")

    def _run_callback(self, method: str, state_name: str) -> Optional[Tuple[int, str]]:
        """Runs the callback on the worker; returns a code and a reason if it failed."""
        try:
            function = getattr(self, method)
            result = function(state_name) if method == "on_state" else function()
        except Failure as failure:
            return failure.code, failure.reason
        except ProcessKilled:
            return _FAILED, "killed"
        except BaseException as error:  # also SystemExit: a callback does not end the process
            self.log.exception(f"{method} raised an exception")
            return _FAILED, f"{method} raised {where(error)}"
        if result is None:
            return None
        return _FAILED, (f"{method} returned {short(result)}; a callback returns nothing when it has succeeded, "
                         "and raises musher.Failure(code, reason) when it has not")

    def _take_break_s(self, ticks: Optional[_native.FsmTicks], waited_s: float = 0.0) -> float:
        """Of an application: for how long at most its process, or its node's thread, could not run since the last call.
        `waited_s`: for that long a tick has waited for the thread."""
        could_not_run_s = ticks.take_break_s() if ticks is not None else None
        return max(could_not_run_s or 0.0, self.node._delivery.take_longest_s(), waited_s)

    def _call_on_pause(self, on_pause: Callable[[], None]) -> bool:
        """Of an application. False: its outputs may not be neutral, which the status shows until it succeeds."""
        fault = ""
        try:
            call_hook("on_pause", on_pause)
        except ProcessKilled:
            raise
        except BaseException as error:
            fault = f"on_pause raised {where(error)}; its outputs may not be neutral"
            self.log.exception(f"fault: {fault}")
        before, self._pause_fault = self._pause_fault, fault
        if before:
            self._actuator.report_fault(0, before)
        if fault:
            self._actuator.report_fault(_FAILED, fault)
        return not fault

    def _run_emergency_stop(self) -> str:
        try:
            call_hook("on_emergency_stop", self.on_emergency_stop)
        except BaseException as error:
            self.log.exception("on_emergency_stop raised an exception")
            return where(error)
        return ""


def run(actuator: Union[Type[Actuator], Actuator, Callable[[], Actuator]], config: str = "") -> NoReturn:
    """The program that is this actuator: makes it, runs it until TearDown, and exits.

    Exit codes: 0 after TearDown; 1 if SetUp fails, it cannot start, or it gave up; 2 if the config is invalid
    or does not fit the class, after which a controller does not restart it. SIGTERM and SIGINT end the
    process at once, as they do a C++ module, unless the program has handlers of its own. Threads of the program
    that are no daemons are waited for at most 2 s, then the functions of atexit run, and the process exits.
    """
    made = actuator() if callable(actuator) else actuator
    if not isinstance(made, Actuator):
        raise TypeError(f"musher.run() takes a class derived from musher.Actuator, not {actuator!r}")
    if threading.current_thread() is threading.main_thread():
        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            signal.signal(signal.SIGINT, signal.SIG_DFL)
    for stream in (sys.stdout, sys.stderr):  # the controller reads its lines
        with contextlib.suppress(AttributeError):
            getattr(stream, "reconfigure")(line_buffering=True)
    code = _run(made, config)
    if threading.current_thread() is threading.main_thread():
        _limit_end(code, made.log)
    sys.exit(code)


def _limit_end(code: int, log: Log) -> None:
    """Once the main thread has ended, the interpreter waits for the tasks of concurrent.futures, and for all threads
    that are no daemons, if need be for ever."""
    main_has_ended, all_have_ended = threading.Event(), threading.Event()
    at_main_end: Callable[[Callable[[], None]], None] = getattr(threading, "_register_atexit", lambda call: call())
    at_main_end(main_has_ended.set)
    atexit.register(all_have_ended.set)

    def limit() -> None:
        main_has_ended.wait()
        if all_have_ended.wait(_LONGEST_END_S):
            return
        others = [thread for thread in threading.enumerate() if not thread.name.startswith("Dummy-")  # of no Thread
                  and thread not in (threading.main_thread(), threading.current_thread())]
        names = ", ".join(thread.name for thread in [one for one in others if not one.daemon] or others)
        log.warning(f"the process exits while threads of its program still run, {_LONGEST_END_S:.0f} s after its end: "
                    f"{names}; end them in on_tear_down(), or make them daemon threads")
        last = threading.Thread(target=_call_at_exit, daemon=True)
        last.start()
        last.join(_LONGEST_END_S)
        os._exit(code)

    threading.Thread(target=limit, daemon=True, name="musher end").start()


def _call_at_exit() -> None:
    atexit._run_exitfuncs()
    _flush()


def _flush() -> None:
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(AttributeError, OSError, ValueError):  # none, or closed
            stream.flush()


def _run(actuator: Actuator, config: str) -> int:
    try:
        actuator._prepare(config)
    except ConfigError as error:
        actuator.log.error(error.reason)
        return 2
    code = actuator._actuator.check(config)
    if code != 0:
        return code
    try:
        actuator.start(config)
    except Failure as error:
        actuator.log.error(f"not started: {error}")
        return 1
    return actuator.wait()


def _snake(name: str) -> str:
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()


# Kept until their end, since the native side refers to them weakly.
_started: Set[Actuator] = set()


@atexit.register
def _end() -> None:
    """Before the interpreter ends: no thread of Musher may need it any more. A callback that does not end
    within two seconds cannot be waited for, so the process ends at once."""
    left = list(_started)
    if not left:
        return
    enders = [threading.Thread(target=actuator.shutdown, daemon=True) for actuator in left]
    for ender in enders:
        ender.start()
    for ender in enders:
        ender.join(_LONGEST_END_S)
    if any(ender.is_alive() for ender in enders):
        for actuator in list(_started):
            actuator.log.error("the program ends while a callback is still running")
        _flush()
        os._exit(1)


def _leave_to_parent() -> None:
    """In a fork, which has none of the threads: the parent keeps the actuators, and their names."""
    for actuator in list(_started):
        actuator._actuator.leave_to_parent()
    _started.clear()


os.register_at_fork(after_in_child=_leave_to_parent)


__all__ = ["Actuator", "Key", "run", "state"]
