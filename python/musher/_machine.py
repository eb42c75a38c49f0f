"""A client of a machine: what `musher status`, `set`, `plan`, `history`, `watch` and `estop` do."""

import contextlib
import dataclasses
import datetime
import errno
import functools
import logging
import os
import select
import sys
import threading
import time
from typing import Any, Callable, Dict, Iterator, List, Optional, Set, Tuple, TypeVar, Union

from musher import _native
from musher._errors import Failure
from musher._message import codec_of
from musher._node import Node, Subscription, default_by
from musher.musher_msgs.msg import HistoryEntry, MachineStatus
from musher.musher_msgs.srv import (GetHistory, GetPlan, ReleaseEmergencyStop, RestartActuator, SetState)

T = TypeVar("T")
_Place = Tuple[int, str]  # domain and namespace
_BesideEnd = Union[None, List[str], Failure]  # of a stop in another one: which actuators have stopped, or why not all
_NEWS, _END = range(2)  # as in native/client.cpp
_TIMEOUT = 107  # Robot (100) + TIMEOUT
_NET_ERROR = 105
_TARGET_BUSY = 111
_LOG = logging.getLogger("musher")
_LOOK_S = 0.1  # between two looks at the processes of this host
_STOPS_KEPT = 8
_SHORTEST_ID = 4  # characters of an id that a person gives
_SAVED_S = 1.0  # a save takes less on a disk that works
_OTHERS_S = 0.3  # machines of other hosts are found one after the other
# Its arguments: the folder of the extension, and those of publish_stop().
_PUBLISHER = ("import sys; sys.path.insert(0, sys.argv[1]); import _native; "
              "_native.publish_stop(*sys.argv[2:7], int(sys.argv[7]), *sys.argv[8:])")
_RELEASED_S = 1.0  # from the answer to a release until its publication is received
_AGAIN_S = 0.02
_BESIDE_S = 3.0  # to join another namespace or domain, beside the time of the stop
_SEARCH_S = 1.0  # for the controller of this host, before a stop goes to each machine


@dataclasses.dataclass(frozen=True)
class ActuatorOutcome:
    """What a switch did to one actuator."""

    name: str
    outcome: str  # "done", "refused", "failed", "overdue", "lost", "undone", "skipped", "unsupported"
    code: int
    reason: str
    duration_ms: float
    state: str  # it is in now


@dataclasses.dataclass(frozen=True)
class Outcome:
    """The definite outcome of a switch."""

    outcome: str  # "done", "refused", "undone", "done-degraded", "superseded", "interrupted", or "" (unknown)
    state: str  # the machine is in now
    code: int
    reason: str
    number: int  # of the switch
    degraded: List[str]  # left out
    actuators: List[ActuatorOutcome]

    @property
    def done(self) -> bool:
        return self.outcome == "done"


class SwitchFailed(Failure):
    """A switch did not end as done; `outcome` has all that is known."""

    outcome: Outcome

    def __init__(self, outcome: Outcome) -> None:
        text = outcome.reason or f"the machine is in {outcome.state}"
        super().__init__(outcome.code or 101, f"{outcome.outcome or 'unknown'}: {text}")
        self.outcome = outcome


class Machine:
    """A machine and its controller.

        with musher.Machine("robot.toml") as machine:
            machine.set("Active")

    `config`: its state config, which has the namespace; or pass the namespace itself. The defaults are those of
    the `musher` program: $MUSHER_NAMESPACE, $MUSHER_MACHINE, $ROS_DOMAIN_ID, $MUSHER_KEYS. `machine`: its name, or the
    first characters of its id, at least 4. It is that machine, else the one of the config, else that of the
    environment; without either, the one whose controller runs on this host, else the only one that answers.
    `interface`: the one network by which it reaches the machine, as of musher.Node.
    """

    def __init__(self, config: "str | os.PathLike[str]" = "", *, namespace: Optional[str] = None,
                 domain: Optional[int] = None, keys: str = "", identity: str = "", machine: str = "",
                 interface: str = "") -> None:
        path = os.fspath(config)
        if path:
            of_config, name = _native.read_machine(path)
            namespace = of_config if namespace is None else namespace
            machine = machine or name
        self._config = path
        self._domain = domain
        # That the caller gave, or the beginning of an id, else of the only machine that answered; empty: none has.
        self._name = machine or os.environ.get("MUSHER_MACHINE", "")
        self._given = bool(self._name)  # else the name is the one of the machine that was found
        self._found = ("", "")  # name and id of the machine that answered last; a new start may have another id
        self._stops: List[_native.Stop] = []  # that are published
        self.node = Node(namespace=namespace, domain=domain, keys=keys, identity=identity, interface=interface)
        self._status_topic = "/" + _native.machine_status_topic(self.node.namespace)
        self._find_at_most_s: Optional[float] = None  # of a test
        self._secured = bool(keys or os.environ.get("MUSHER_KEYS"))
        self._names_namespace = namespace is not None or bool(self.node.namespace)
        self._joined_with = {"keys": keys, "identity": identity, "interface": interface}
        self._beside: Dict[_Place, Machine] = {}  # that an emergency stop has reached, too

    @property
    def _find_s(self) -> float:
        """The time of a discovery; longer where a controller leads on this host, which may lack CPU for a while."""
        if self._find_at_most_s is not None:
            return self._find_at_most_s
        if self._name or not self._leads_here():
            return 4.0 if self._secured else 1.2
        return 9.0 if self._secured else 4.0

    def status(self) -> MachineStatus:
        """Raises musher.Failure if no controller is found."""
        end = time.monotonic() + self._find_s
        with _Closing(self._watch()) as statuses:
            meant, chosen = self._choose(statuses, self._find_s)
            left = end - time.monotonic() if chosen is None else 0.0
            found = self._next(statuses, meant, max(left, 0.0)) or chosen
        if found is None:
            raise self._not_found()
        return found

    def watch(self) -> Iterator[MachineStatus]:
        """Each new status of the machine, the present one first."""
        with _Closing(self._watch()) as statuses:
            meant, status = self._choose(statuses, self._find_s)
            if status is not None and self._name:
                meant = (self._name, "")  # also once it is started again with another id
            while True:
                if status is not None:
                    yield status
                status = self._next(statuses, meant, None)

    def wait_until(self, condition: Any, timeout_s: float = 60.0) -> MachineStatus:
        """The first status for which condition(status) holds; or pass the name of a state that it is in. Where this
        host has a machine that does not run, it waits for that one, and not for another one that answers."""
        end = time.monotonic() + timeout_s
        holds = (lambda status: status.state == condition) if isinstance(condition, str) else condition
        last: Optional[MachineStatus] = None
        meant = ("", "")
        with _Closing(self._watch()) as statuses:
            statuses.accepts = lambda status: meant[0] != "" or not self._is_beside(status)
            meant, status = self._choose(statuses, min(self._find_s, timeout_s))
            while True:
                left = end - time.monotonic()
                if status is None and left > 0:
                    status = self._next(statuses, meant, left)
                if status is None:
                    break
                if not meant[0]:
                    meant = (status.machine, "")  # the first that answers
                last = status
                if holds(status):
                    return status
                status = None
            beside = statuses.refused
        if last is None:
            raise self._not_found(beside)
        if _has_ended(last):
            raise Failure(_NET_ERROR, f"after {timeout_s} s no controller leads: that of {last.machine} "
                                      f"(pid {last.pid}) has exited, it was in {last.state}")
        raise Failure(_TIMEOUT, f"after {timeout_s} s the machine is in {last.state} ({last.phase})")

    def set(self, state: str, actuator: str = "", *, timeout_s: float = 60.0, by: str = "") -> Outcome:
        """Switches the machine, or one actuator, and waits for the outcome, also if the controller that was
        called exits meanwhile. Raises musher.SwitchFailed unless it is done."""
        outcome = self.request(state, actuator, timeout_s=timeout_s, by=by)
        if not outcome.done:
            raise SwitchFailed(outcome)
        return outcome

    def request(self, state: str, actuator: str = "", *, timeout_s: float = 60.0, by: str = "") -> Outcome:
        """As set(), but returns any outcome. Raises musher.Failure if no controller is found."""
        for given in (state, actuator):
            if not isinstance(given, str):
                raise TypeError(f"a state and an actuator are names, not {given!r}")
        mailbox = _native.Mailbox()
        switch = _native.Switch(self._native(), state, actuator, by or default_by(), timeout_s,
                                min(self._find_s, timeout_s), mailbox, *self._meant(acts=True))
        try:
            while True:
                item = mailbox.pop(None)
                if item is not None and item.kind == _END:
                    break
        finally:
            switch.close()
        response = item.decode(codec_of(SetState.Response), False)
        if response.outcome == "" and not self._leads():
            raise self._silent() or Failure(_NET_ERROR, response.reason or self._not_found().reason)
        return Outcome(response.outcome, response.state, response.code, response.reason, response.switch_number,
                       list(response.degraded),
                       [ActuatorOutcome(one.name, one.outcome, one.code, one.message, one.duration_ms, one.state)
                        for one in response.actuators])

    def plan(self, state: str, actuator: str = "") -> "GetPlan.Response":
        """What a switch would do; changes nothing."""
        reply: GetPlan.Response = self._call("get_plan", GetPlan, GetPlan.Request(state, actuator))
        return reply

    def history(self, limit: int = 1000, since: Optional[datetime.datetime] = None) -> List[HistoryEntry]:
        """The machine's journal, oldest first: the newest so many entries, after this time."""
        since_ns = 0 if since is None else int(since.timestamp() * 1e9)
        reply = self._call("get_history", GetHistory, GetHistory.Request(since_ns, limit))
        if reply.error:
            raise Failure(_NET_ERROR, reply.error)
        return list(reply.entries)

    def restart(self, actuator: str, *, timeout_s: float = 60.0, by: str = "") -> None:
        """Starts an actuator's process again; returns when it is back where the machine is. Raises musher.Failure
        if it is not, also if the controller that was called exits meanwhile."""
        mailbox = _native.Mailbox()
        call = _native.Restart(self._native(), actuator, by or default_by(), timeout_s, mailbox,
                               *self._meant(acts=True))
        try:
            item = mailbox.pop(min(self._find_s, timeout_s))
            if (item is None or item.text) and not call.found():
                raise self._not_found()
            while item is None:
                item = mailbox.pop(None)
        finally:
            call.close()
        if item.text:
            raise Failure(item.code, item.text)
        reply = item.decode(codec_of(RestartActuator.Response), False)
        if reply.code != 0:
            raise Failure(reply.code, reply.reason)

    def estop(self, reason: str = "", *, timeout_s: float = 2.0, by: str = "") -> List[str]:
        """Engages the emergency stop, with or without a controller. Without a namespace it also stops the machines
        that run on this host in other ones, as `musher estop` does. Returns the actuators that have stopped, those of
        another namespace as "namespace/name"; raises musher.Failure if one of them or a controller has not confirmed it
        in time, or if a machine may have more of them. The stop stays engaged in any case, and reaches actuators that join until this machine is
        closed. One that not all have confirmed is then published for a minute by a process of its own, however this
        one ends; so is one that is on no disk, because no controller leads or its disk fails: a warning of the logger
        "musher" says so."""
        end = time.monotonic() + timeout_s
        engaged = _native.NewStop(by or default_by(), reason)
        self._native()  # raises where it is closed
        if not self._secured:
            engaged.hand_over(self.node.namespace, self._domain, self._name)
        beside = _StopsBeside(lambda: self._hand_over_beside(engaged),
                              lambda place: self._machine_at(place)._stop_own(engaged, end, timeout_s))
        own: "List[str] | Failure"
        try:
            own = self._stop_own(engaged, end, timeout_s)
        except Failure as failure:
            own = failure
        return self._with_beside(own, beside.ended(end + _BESIDE_S))

    def _stop_own(self, engaged: _native.NewStop, end: float, timeout_s: float) -> List[str]:
        """Of the machine of its namespace."""
        native = self._native()
        meant = self._to_stop()
        mailbox = _native.Mailbox()
        stop = _native.Stop(native, engaged, mailbox, *meant, self._domain, self._config, self._name)
        stop.publish_after_end(self._publisher())
        self._stops = [*self._stops[-_STOPS_KEPT + 1:], stop]
        with contextlib.ExitStack() as opened:
            statuses: Optional[_Statuses] = None  # of the machine whose id begins with the given word
            if _may_begin_id(self._name):
                with contextlib.suppress(Failure):  # the stop is published without it
                    statuses = opened.enter_context(_Closing(self._watch()))
            over, led, actuators, unknown, not_on_disk = self._await_stop(stop, mailbox, statuses, end, not meant[1])
        missing = [f"{name} ({trouble})" if trouble else name for name, stopped, _, trouble in actuators if not stopped]
        if missing:
            raise Failure(_TIMEOUT, f"the emergency stop is engaged, but not confirmed by {', '.join(missing)}")
        if not actuators and not (unknown and stop.searches()):
            silent = None if led else _found_within(_SEARCH_S, self._silent)
            raise silent or _NothingFound(_NET_ERROR, self._nothing("no actuator").reason)
        if not over and not unknown:
            unknown = ("not confirmed by the controller" if led else
                       f"in {timeout_s} s without a controller not every actuator may have been found")
        if unknown:
            raise Failure(_TIMEOUT, f"the emergency stop is engaged, but {unknown}")
        if not led:
            not_on_disk = "no controller leads that saves the emergency stop"
        if not_on_disk:
            _LOG.warning("not on disk: %s; it is lost if the %sactuators end; it stays published for a minute after the "
                         "end of this program", not_on_disk, "controller and the " if led else "")
        else:
            stop.confirm()
        return [name for name, _, _, _ in actuators]

    def _hand_over_beside(self, engaged: _native.NewStop) -> "List[_Place]":
        """To the controllers of this host that are meant beside the one of its namespace; where they are."""
        places = self._places_to_stop()
        for domain, name_space in places if not self._secured else []:
            engaged.hand_over(name_space, domain, self._name if self._given else "")
        return places

    def _places_to_stop(self) -> "List[_Place]":
        """Reads the disk only where nothing runs in its domain, and other processes only for a name."""
        places = _native.places_to_stop(self.node.namespace, self._domain, self._names_namespace)
        if not self._given:
            return places
        of_places = ((place, _native.machine_here(place[1], place[0])) for place in places)
        return [place for place, (name, id) in of_places
                if name == self._name or (len(self._name) >= _SHORTEST_ID and id.startswith(self._name))]

    def _machine_at(self, place: "_Place") -> "Machine":
        known = self._beside.get(place)
        if known is None:
            known = Machine(namespace=place[1], domain=place[0], machine=self._name if self._given else "",
                            **self._joined_with)
            self._beside[place] = known
        return known

    def _with_beside(self, own: "List[str] | Failure", beside: "Optional[Dict[_Place, _BesideEnd]]") -> List[str]:
        """The actuators of all. Raises musher.Failure where one of the machines is not stopped."""
        stopped: List[str] = []
        failures: List[str] = []
        if beside is None:
            failures.append("this host is still being searched for machines in other namespaces")
        for (domain, name_space), end in (beside or {}).items():
            if isinstance(end, list):
                stopped += [f"{name_space}/{name}" if name_space else name for name in end]
            else:
                where = _native.place_text(domain, name_space, self._domain)
                failures.append(f"the machine of this host in {where}: {end.reason if end else 'not confirmed in time'}")
        if isinstance(own, _NothingFound) and beside:
            for stop in self._stops[-1:]:  # none that comes later is meant
                stop.confirm()
                stop.close()
            self._stops = self._stops[:-1]
            own = []
        if isinstance(own, Failure):
            if failures:
                raise Failure(own.code, "; ".join([own.reason, *failures]))
            raise own
        if failures:
            raise Failure(_TIMEOUT, "; ".join(failures))
        return [*own, *stopped]

    def _publisher(self) -> List[str]:
        """The program of the process that goes on to publish a stop. It loads nothing but the extension."""
        if not sys.executable:
            return []
        folder = os.path.dirname(os.path.abspath(_native.__file__))
        return [sys.executable, "-I", "-c", _PUBLISHER, folder, *self.node._joined_with]

    def _await_stop(self, stop: _native.Stop, mailbox: _native.Mailbox, statuses: "Optional[_Statuses]", end: float,
                    others: bool) -> Tuple[bool, bool, List[Tuple[str, bool, float, str]], str, str]:
        """Its report once it is over and saved. `others`: other machines may be meant, too, and are found after the
        first."""
        since: Optional[float] = None  # each actuator that is known has stopped
        while True:
            status = statuses.take(0.0) if statuses is not None else None
            if status is not None and status.machine != self._name and _begins_id(status, self._name):
                stop.follow(status.machine, status.machine_id)
                statuses = None
            report = over, _, actuators, _, not_on_disk = stop.report()
            now = time.monotonic()
            since = (now if since is None else since) if over and actuators else None
            wait_s = max(_OTHERS_S if others else 0.0, _SAVED_S if not_on_disk else 0.0)
            until = end if since is None else min(end, since + wait_s)
            if now >= until:
                return report
            mailbox.pop(min(until - now, _LOOK_S))

    def release_estop(self, by: str = "", seen: Optional[MachineStatus] = None) -> None:
        """Releases the emergency stops of `seen`, the status that the program, or a person, has decided by; without it,
        those that are engaged now. Changes no state. Raises musher.Failure, and releases none, if another one has been
        engaged since."""
        if seen is None:
            self._meant(acts=True)  # raises where another machine would answer
            seen = self.status()
        request = ReleaseEmergencyStop.Request(by or default_by())
        # Not empty, which means all stops: one that is engaged after a status without any was not seen.
        request.seen_stops = list(seen.stop_ids) if seen.emergency_stop else ["0" * 16]
        reply = self._call("release_emergency_stop", ReleaseEmergencyStop, request, acts=True)
        if reply.code != 0:
            raise Failure(reply.code, reply.reason)
        for stop in self._stops:
            if stop.is_one_of(request.seen_stops):
                stop.confirm()
                stop.close()
                self._stops = [one for one in self._stops if one is not stop]
        self._drop_withdrawn(_RELEASED_S)

    def _drop_withdrawn(self, within_s: float) -> None:
        """The controller publishes the release of the stops that newer ones have replaced, too. Others go on: those
        that were not released, and those that are for other machines, too."""
        end = time.monotonic() + within_s
        while any(stop.names_machine() and not stop.withdrawn() for stop in self._stops) and time.monotonic() < end:
            time.sleep(_AGAIN_S)
        withdrawn = [stop for stop in self._stops if stop.withdrawn()]
        self._stops = [stop for stop in self._stops if stop not in withdrawn]
        for stop in withdrawn:
            stop.close()

    def close(self) -> None:
        self._drop_stops()
        self.node.close()

    def _drop_stops(self) -> None:
        for stop in self._stops:
            stop.close()
        self._stops = []
        for machine in list(self._beside.values()):
            machine.close()
        self._beside = {}

    def __enter__(self) -> "Machine":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _native(self) -> _native.Node:
        self.node._check("musher")
        assert self.node._native is not None
        return self.node._native

    def _watch(self) -> "_Statuses":
        self.node._check(self._status_topic)
        statuses = _Statuses(self.node, self._status_topic)
        statuses.accepts = lambda status: not self._is_elsewhere(status)
        return statuses

    def _next(self, statuses: "Subscription[MachineStatus]", meant: Tuple[str, str],
              timeout_s: Optional[float]) -> Optional[MachineStatus]:
        """The newest status of that machine that was not taken yet; none after this time without one."""
        end = None if timeout_s is None else time.monotonic() + timeout_s
        newest: Optional[MachineStatus] = None
        while True:
            left = None if end is None else max(end - time.monotonic(), 0.0)
            status = statuses.take(0.0 if newest is not None else left)
            if status is None:
                return newest
            if _is_of(status, meant):
                newest = status

    def _known(self) -> Tuple[str, str]:
        """Name and id of the machine that is meant, without discovery; empty: not known."""
        here = _native.machine_here(self.node.namespace, self._domain)
        by_id = len(self._name) >= _SHORTEST_ID and here[1].startswith(self._name)
        return here if by_id or self._name in ("", here[0]) else (self._name, "")

    def _to_stop(self) -> Tuple[str, str]:
        """The same for a stop, which goes to each machine that may be meant before anything can hold it up: to every
        id of a name, and to each machine of the namespace where a process hangs the search for the one here."""
        if self._name:
            return self._name, ""
        if not self._leads_here() and _native.runs_here(self.node.namespace, self._domain):
            return "", ""  # actuators run here, of any machine
        return _found_within(_SEARCH_S, self._machine_here) or ("", "")

    def _machine_here(self) -> Tuple[str, str]:
        """The machine whose controller runs here; where nothing runs here, the only one with files on this host."""
        known = self._known()
        if known != ("", "") or _native.runs_here(self.node.namespace, self._domain):
            return known
        here = _native.machines_here(self.node.namespace, self._domain)
        only = next((one for one in here if one[1]), here[0] if here else ("", ""))
        return only if all(_is_one(one, only) for one in here) else ("", "")

    def _choose(self, statuses: "Subscription[MachineStatus]",
                within_s: float) -> Tuple[Tuple[str, str], Optional[MachineStatus]]:
        """Name and id of the machine that is meant, and the newest status of it that was taken meanwhile. Raises
        musher.Failure where the choice is open."""
        known = self._known()
        if known[1]:
            return known, None
        found: Dict[Tuple[str, str], MachineStatus] = {}
        end = time.monotonic() + within_s
        while (left := end - time.monotonic()) > 0:
            status = statuses.take(left)
            if status is None:
                break
            if not _is_of(status, known):
                continue
            machine = (status.machine, status.machine_id)
            if machine == self._found:  # it answers as before
                return machine, status
            found[next((one for one in found if _is_one(machine, one)), machine)] = status
            if len(found) == 1:
                end = min(end, time.monotonic() + _OTHERS_S)
        if len(found) > 1:
            found = {one: status for one, status in found.items() if not self._is_beside(status)} or found
        if len(found) > 1:
            names = ", ".join(f"{name} (id {id[:8]})" if id else name for name, id in found)
            of_hosts = "" if any(map(_is_of_this_boot, found.values())) else ", none of them on this host"
            what, cure = ((f"several machines are named {known[0]}",
                           "Machine(machine=ID) chooses one by the first characters of its id") if known[0] else
                          ("several machines answer" + of_hosts, "Machine(machine=NAME) chooses one"))
            raise Failure(_TARGET_BUSY, f"{what}: {names}. Nothing was done; {cure}")
        for machine, status in found.items():
            self._found = machine
            if not self._name and not self._is_beside(status):
                self._name = machine[0]
            return machine, status
        return known, None

    def _meant(self, acts: bool = False) -> Tuple[str, str]:
        """Name and id of the machine that is meant. Raises musher.Failure if it does not answer, or where the choice
        is open. `acts`: also where this host has a machine that does not run: a robot that is down does not steer the
        one beside it."""
        with _Closing(self._watch()) as statuses:
            meant, status = self._choose(statuses, self._find_s)
        if not meant[1] and status is None:
            raise self._not_found()
        if acts and status is not None:
            self._check_namespace(status)
            if self._is_beside(status):
                raise self._not_here(status)
        return meant

    def _check_namespace(self, status: MachineStatus) -> None:
        """Raises musher.Failure where neither a name nor a namespace was given, the machine is of another host, and
        one of this host runs in another namespace: that one may be meant."""
        if self._given or self.node.namespace or _is_of_this_boot(status):
            return
        why = _native.why_not_here(status.machine, self._domain)
        if why:
            raise Failure(_NET_ERROR, f"{why}; Machine(namespace=…), or MUSHER_NAMESPACE, chooses it")

    def _is_beside(self, status: MachineStatus) -> bool:
        """Whether no name was given, and this host has machines of which it is none."""
        if self._is_elsewhere(status):
            return True
        if _is_of_this_boot(status):
            return False
        here = [] if self._name else _native.machines_here(self.node.namespace, self._domain)
        return bool(here) and not any(_is_one((status.machine, status.machine_id), one) for one in here)

    def _is_elsewhere(self, status: MachineStatus) -> bool:
        """Whether no name was given, and a controller of this host leads, of which it is none. Of one of another user,
        or container, only the computer is known."""
        return not self._name and self._leads_here() and not _is_of_this_boot(status)

    def _leads_here(self) -> bool:
        return _native.leads_here(self.node.namespace, self._domain)

    def _not_here(self, beside: MachineStatus) -> Failure:
        here = _native.machines_here(self.node.namespace, self._domain)
        own = f"the machine of this host, {here[0][0]}," if here else "the machine of this host"
        return Failure(_NET_ERROR, f"{own} does not run; found {beside.machine}. "
                                   "Nothing was done; Machine(machine=NAME) speaks to another machine")

    def _leads(self) -> bool:
        with _Closing(self._watch()) as statuses:
            return self._next(statuses, self._known(), self._find_s) is not None

    def _call(self, name: str, service: Any, request: Any, timeout_s: float = 5.0, acts: bool = False) -> Any:
        with _Closing(self.node.client("/" + _native.machine_service(self.node.namespace, name), service)) as client:
            request.machine, request.machine_id = self._meant(acts)
            if not client.wait_until_ready(self._find_s):
                raise self._not_found()
            return client.call(request, timeout_s)

    def _not_found(self, beside: Optional[MachineStatus] = None) -> Failure:
        """Why no controller answers. `beside`: of another machine, which does."""
        return self._silent() or (self._nothing("no controller") if beside is None else self._not_here(beside))

    def _silent(self) -> Optional[Failure]:
        """The controller that is meant leads on this host, but was not found."""
        if not self._leads_here():
            return None
        name, id = self._known()
        if id:
            pid = _native.leader_here(self.node.namespace, self._domain)
            return Failure(_NET_ERROR, f"the controller of {name} (pid {pid}) leads on this host, but does not answer; "
                                       "`musher status` says why")
        if self._name:
            return None
        return Failure(_NET_ERROR, "a controller of this host leads, but does not answer; "
                                   "`sudo musher status` says why")

    def _nothing(self, what: str) -> Failure:
        place = f"namespace '{self.node.namespace}'" if self.node.namespace else "the default namespace"
        return Failure(_NET_ERROR, f"{what} in {place}; is the machine up "
                                   "(`musher up robot.toml`), and are namespace and ROS_DOMAIN_ID right?")


class _NothingFound(Failure):
    """There was no machine to stop."""


class _StopsBeside:
    """Emergency stops of the machines of this host in other namespaces and domains. Each has a thread of its own: none
    waits for another one, nor for the search for them."""

    def __init__(self, search: "Callable[[], List[_Place]]", stop: "Callable[[_Place], List[str]]") -> None:
        self._search, self._stop = search, stop
        self._ends: Optional[Dict[_Place, _BesideEnd]] = None
        self._thread = _begin(self._run)

    def ended(self, end: float) -> "Optional[Dict[_Place, _BesideEnd]]":
        """What they have done until then; None: the search goes on."""
        if self._thread is not None:
            self._thread.join(max(end - time.monotonic(), 0.0))
        return None if self._ends is None else dict(self._ends)

    def _run(self) -> None:
        places = self._search()
        ends: Dict[_Place, _BesideEnd] = {place: None for place in places}
        self._ends = ends
        for thread in [_begin(functools.partial(self._stop_at, place, ends)) for place in places]:
            if thread is not None:
                thread.join()

    def _stop_at(self, place: "_Place", ends: "Dict[_Place, _BesideEnd]") -> None:
        try:
            ends[place] = self._stop(place)
        except Failure as failure:
            ends[place] = failure


def _begin(work: Callable[[], None]) -> Optional[threading.Thread]:
    """On a thread of its own; None: none is left, and it is done."""
    thread = threading.Thread(target=work, daemon=True)
    try:
        thread.start()
    except RuntimeError:
        work()
        return None
    return thread


class _Statuses(Subscription[MachineStatus]):
    """Of controllers. One that a bridge, a router or a replayed recording repeats does not count, nor does what a
    process of this host had published before it was killed."""

    def __init__(self, node: Node, topic: str) -> None:
        super().__init__(node, topic, MachineStatus, None, reliable=True, latched=True, depth=0)
        self._senders: Set[int] = set()  # participants that have run while this exists
        self.accepts: Callable[[MachineStatus], bool] = lambda status: True
        self.refused: Optional[MachineStatus] = None  # the last one that it does not accept

    def _decode(self, item: _native.Item) -> Optional[MachineStatus]:
        status = super()._decode(item)
        if status is None or status.participant not in (0, item.token):
            return None
        if item.token not in self._senders:
            if _has_ended(status):
                return None
            self._senders.add(item.token)
        if self.accepts(status):
            return status
        self.refused = status
        return None


def _is_of_this_boot(status: MachineStatus) -> bool:
    """Whether its controller runs on this computer, perhaps in a container."""
    boot = _native.host_id().partition("/")[0]
    return boot != "" and status.host.startswith(boot + "/")


def _has_ended(status: MachineStatus) -> bool:
    """Whether it is of a controller of this host whose process has exited."""
    if not status.host or status.host != _native.host_id():
        return False
    try:
        process = os.pidfd_open(status.pid)
    except OSError as error:
        return error.errno == errno.ESRCH
    try:
        exited = select.poll()
        exited.register(process, select.POLLIN)
        return bool(exited.poll(0))
    finally:
        os.close(process)


def _found_within(time_s: float, search: Callable[[], Optional[T]]) -> Optional[T]:
    """What a search finds in this time. One that inspects other processes is held up for ever by one that hangs."""
    found: List[Optional[T]] = []
    thread = threading.Thread(target=lambda: found.append(search()), daemon=True)
    try:
        thread.start()
    except RuntimeError:  # no thread is left
        return None
    thread.join(time_s)
    return found[0] if found else None


def _is_of(status: MachineStatus, machine: Tuple[str, str]) -> bool:
    """Without an id the name may be the beginning of one."""
    by_id = not machine[1] and _begins_id(status, machine[0])
    return by_id or _is_one((status.machine, status.machine_id), machine)


def _begins_id(status: MachineStatus, word: str) -> bool:
    """As BeginsIdOf() in lifecycle/machine/machine_identity.hpp."""
    return len(word) >= _SHORTEST_ID and status.machine_id.startswith(word)


def _may_begin_id(word: str) -> bool:
    return len(word) >= _SHORTEST_ID and not set(word) - set("0123456789abcdef-")


def _is_one(one: Tuple[str, str], other: Tuple[str, str]) -> bool:
    """As SameMachine() in lifecycle/machine/machine_identity.hpp: what is empty is not known."""
    return all(not a or not b or a == b for a, b in zip(one, other))


class _Closing:
    """contextlib.closing, with the type of what it closes."""

    def __init__(self, endpoint: Any) -> None:
        self._endpoint = endpoint

    def __enter__(self) -> Any:
        return self._endpoint

    def __exit__(self, *_: object) -> None:
        self._endpoint.close()
