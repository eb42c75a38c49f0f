"""The base class of an actuator that offers skills which are written in Python (musher.skill)."""

import ast
import threading
from typing import Any, Dict, Iterable, List, Optional

from musher import _native
from musher._action import GoalCanceled, ServerGoal
from musher._actuator import LONGEST_BREAK_S, Actuator
from musher._errors import Failure, ProcessKilled
from musher._log import call_hook, where
from musher.musher_msgs.msg import SkillDetail, SkillFeedback, SkillOffer, SkillOffers
from musher.musher_msgs.srv import CancelSkill, GetSkill, PauseSkill
from musher.plan_msgs.action import SkillExecution
from musher.skill import CANCELLED, COMPLETED, FAILED, PROCESSING, SkillError, SkillManager, text_of
from musher.builtin_interfaces.msg import Time

_FAILED = 101  # Robot (100) + FAILED
_STATE_INVALID = 103
_STATUS_CODES = {"processing": 0, "completed": 1, "failed": 2, "cancelled": 3}
_LONGEST = 200  # of a text from outside, in messages


class SkillActuator(Actuator):
    """Derive from it, and register skills (musher.skill.SkillManager.register):

        class Arm(musher.SkillActuator):
            name = "arm"

            def open_topics(self) -> None: ...  # of the gripper

        musher.run(Arm)

        robot          skills
        SetUp          topics are opened
        SelfCheck      self_check() is called
        Active         are started by goals, and stepped; paused ones go on
        DeActive, Protected, LowPower, and states of the config
                       are paused: their time stands still
        OTA, Error, TearDown, an emergency stop
                       are cancelled at once; on_pause()
        its process, or the node's thread, could not run for more than a minute: are cancelled

    Interfaces, in the namespace of the machine, as those of musher-skills: the action skill_execution
    (plan_msgs/SkillExecution, `musher skill run`), the topics skills and skill_feedback, the services <name>/get_skill,
    <name>/pause_skill (`musher skill pause`, `musher skill resume`) and <name>/cancel_skill.
    A goal has one skill with its parameters as texts ("[10, 20, 0]"); `timeout` limits the run, in seconds, unless the
    skill takes a parameter of that name.

    In a fault-injection test there is neither transport nor clock: skills are not stepped.

    Threads: skills, hooks and handlers of topics run on the node's thread, one at a time. self_check() runs on the
    worker. Times are the machine's, see [controller] clock.
    """

    #: Of steps.
    rate_hz: float = 10.0
    #: Goals whose robot_id is another one, and not the actuator's name, are refused; empty: none.
    robot_name: str = ""
    #: Names of registered skills; none: all.
    skills: Optional[Iterable[str]] = None

    def __init__(self, name: str = "") -> None:
        super().__init__(name)
        if not self.rate_hz > 0:
            raise ValueError(f"the rate of steps is more than 0 Hz, not {self.rate_hz}")
        self._manager: Optional[SkillManager] = None
        self._ticks: Optional[_native.FsmTicks] = None
        self._tick_key = 0
        self._now_s = 0.0
        self._stepping = False
        self._end_faults = ""  # of the last skills that were cancelled at once, until Active
        self._is_set_up = False
        self._goals: Dict[int, "_Request"] = {}  # by the number of the run, as what was shown of it
        self._shown: Dict[int, str] = {}

    # What a derived class writes.

    def make_robot(self) -> Any:
        """What skills get as their robot; by default this actuator. In SetUp, on the node's thread."""
        return self

    def open_topics(self) -> None:
        """After that: topics and services of self.node."""

    def self_check(self) -> None:
        """Whether its dependencies are available; raises musher.Failure if not. May block: it runs on the worker."""

    def before_step(self) -> None:
        """An exception cancels all skills."""

    def after_step(self) -> None:
        """As before_step()."""

    def on_pause(self) -> None:
        """No skill is stepped from now on: bring the outputs to neutral. Must return at once and be idempotent. An
        exception is logged, and the status shows it until on_pause() succeeds; an emergency stop is then not confirmed."""

    # What it uses, on the node's thread.

    @property
    def manager(self) -> SkillManager:
        """From SetUp on."""
        if self._manager is None:
            raise Failure(_STATE_INVALID, f"{self.name} has no skills before SetUp")
        return self._manager

    @property
    def stepping(self) -> bool:
        """Whether skills are stepped now."""
        return self._stepping

    # Inside.

    def _callbacks(self) -> Dict[str, str]:
        callbacks = super()._callbacks()
        for state, method in callbacks.items():
            if state or getattr(type(self), method) is not SkillActuator.on_state:
                raise TypeError(f"{type(self).__name__}.{method} would replace the callback that runs the skills; "
                                "override on_pause() or self_check()")
        return callbacks

    def on_state(self, state: str) -> None:
        """Runs the skills: do not override it."""
        if state == "SetUp":
            self._is_set_up = False
            self.node._run(self._set_up)
            self._is_set_up = True
        elif state == "SelfCheck":
            self._named("self_check", self.self_check)
        elif state == "Active":
            self.node._run(self._go_on)
        elif state in ("TearDown", "Error", "OTA"):
            self.node._run(lambda: self._pause(f"the robot goes to {state}"))
        else:
            self.node._run(self._pause)

    def on_emergency_stop(self) -> None:
        """Cancels the skills: do not override it, but on_pause()."""
        if not self._is_set_up:
            return
        self._stepping = False  # at once: no further step begins
        self.node._run(self._pause_at_stop, first=True)

    def _set_up(self) -> None:
        node = self.node
        self._named("make_robot", self._make)
        if not self._tick_key:
            self._tick_key = node._handle(self._on_tick)
            node.serve_action("skill_execution", SkillExecution, self._on_goal)
            node.serve(f"{self.name}/get_skill", GetSkill, self._report)
            node.serve(f"{self.name}/pause_skill", PauseSkill, self._pause_requested)
            node.serve(f"{self.name}/cancel_skill", CancelSkill, self._cancel_requested)
            self._feedback_topic = node.publisher("skill_feedback", SkillFeedback)
            offers_topic = node.publisher("skills", SkillOffers, latched=True, depth=1)
            self._ticks = _native.FsmTicks(self._actuator, node._mailbox, self._tick_key)
            self._named("open_topics", self.open_topics)
            offers = [SkillOffer(one.name, one.summary, one.offers()) for one in self.manager.skills.values()]
            offers_topic.publish(SkillOffers(self.name, "/" + _joined(node.namespace, "skill_execution"), offers))

    def _make(self) -> None:
        try:
            self._manager = SkillManager(self.make_robot(), self.skills, lambda: self._now_s)
            self._manager.on_removal = self._on_removal
        except SkillError as error:
            raise Failure(_FAILED, str(error)) from None
        if not self._manager.skills:
            raise Failure(_FAILED, "no skill is registered: @SkillManager.register()")
        for request in self._goals.values():
            request.end(False, "cancelled: the skills are set up again")
        self._goals.clear()
        self._shown.clear()

    def _on_removal(self, skill: str) -> None:
        self._publish()
        run = self.manager._run(skill)
        self._shown.pop(run.number, None)

    def _go_on(self) -> None:
        if self.emergency_stopped:
            raise Failure(_STATE_INVALID, "an emergency stop was engaged meanwhile")
        if self._stepping:
            return
        self._end_after_break()
        self._end_faults = ""
        self._stepping = True
        if self._ticks is not None:
            self._ticks.start(self.rate_hz)

    def _pause_at_stop(self) -> None:
        well = self._rest("emergency stop")
        if self._end_faults:
            raise Failure(_FAILED, self._end_faults)
        if not well:
            raise Failure(_FAILED, self._pause_fault)

    def _pause(self, cancels: str = "") -> None:
        self._rest(cancels)

    def _rest(self, cancels: str) -> bool:
        """False: on_pause has failed."""
        self._stepping = False
        if self._ticks is not None:
            self._ticks.stop()
        if self._manager is not None:
            if cancels and self._manager.running():
                self._note_end_faults(self._manager.cancel_all_now(cancels))
            self._manager.pause()
        well = self._call_on_pause(self.on_pause)
        self._publish()
        return well

    def _note_end_faults(self, faults: List[str]) -> None:
        self._end_faults = "; ".join(faults) + "; its outputs may not be neutral" if faults else ""
        if faults:
            self.log.error(f"fault: {self._end_faults}")

    def _on_tick(self, item: _native.Item) -> None:
        if not self._stepping:
            return
        self._now_s = item.token / 1e9
        self._end_after_break(item.waited_s())
        well = self._guard("before_step", self.before_step)
        for name in self.manager.running() if well else ():
            if not self._stepping:  # an emergency stop was engaged on another thread
                return
            self.manager.step(name)
        if not self._stepping:
            return
        well = self._guard("after_step", self.after_step) and well
        if not well:
            self.manager.cancel_all_now("a hook of the actuator has failed")
        self._publish()

    def _on_goal(self, goal: ServerGoal) -> "SkillExecution.Result":
        """On a thread of the goal."""
        request = _Request(goal)
        self.node._run(lambda: self._start(request))
        asked = False
        while not request.ended.wait(0.05):
            if goal._server._closed:
                raise GoalCanceled(None)
            if goal.cancel_requested and not asked:
                asked = True
                self.node._post(lambda: self._cancel(request))
        result = SkillExecution.Result(request.completed, request.text)
        if request.completed:
            return result
        raise GoalCanceled(result)  # aborted, unless its client has cancelled it

    def _start(self, request: "_Request") -> None:
        try:
            self._check_stepping()
            wanted = request.goal.goal.skill_request
            own = self.robot_name
            if own and wanted.robot_id not in ("", own, self.name):
                raise SkillError(f"the skill is for the robot '{wanted.robot_id[:80]}', and this is {own}")
            self._check_not_late()
            if request.goal.cancel_requested:  # while the node's thread was busy
                raise SkillError("cancelled before it started")
            if len(wanted.skill_list) != 1:
                raise SkillError(f"expected one skill in skill_list, found {len(wanted.skill_list)}")
            self._begin(wanted.skill_list[0], request)
            request.skill = wanted.skill_list[0].skill
            request.run = self.manager._run(request.skill).number
            self._goals[request.run] = request
            self.log.info(f"{request.skill} started" + (f", requested by {request.by}" if request.by else ""))
        except SkillError as error:
            self.log.warning(f"goal refused: {error}")
            request.end(False, str(error))
        self._publish()

    def _begin(self, wanted: Any, request: "_Request") -> None:
        parameters = {one.key: _value(one.value) for one in wanted.params}
        known = self.manager.skills.get(wanted.skill)
        timeout = None
        if known is not None and "timeout" not in known.parameters:
            timeout = parameters.pop("timeout", None)
        self.manager.start(wanted.skill, parameters, timeout)
        run = self.manager._run(wanted.skill)
        run.goal_id, run.requested_by = request.id, request.by

    def _cancel(self, request: "_Request") -> None:
        if self._goals.get(request.run) is not request:
            return
        try:
            self.manager.cancel_skill(request.skill, "by its client")
        except SkillError:
            return  # it has ended
        if not self._stepping:  # no step would see it
            self.manager.step(request.skill)
            self._publish()

    def _publish(self) -> None:
        """The feedback of each run that has changed, and the ends of goals."""
        if self._manager is None or self._ticks is None:
            return
        for name, run in list(self._manager._runs.items()):
            feedback = run.feedback
            text = self._text_of(name)
            request = self._goals.get(run.number)
            if self._shown.get(run.number) != text + feedback["state"]:
                self._shown[run.number] = text + feedback["state"]
                self._feedback_topic.publish(self._message(name))
                if request is not None and feedback["status"] == PROCESSING:
                    request.goal.feedback(SkillExecution.Feedback(text))
            if request is not None and feedback["status"] != PROCESSING:
                del self._goals[run.number]
                self.log.info(f"{name} {text}")
                request.end(feedback["status"] == COMPLETED, text)

    def _text_of(self, name: str) -> str:
        feedback = dict(self.manager.feedback_of(name) or {})
        if self.manager.is_paused(name):
            feedback["message"] = f"paused: {feedback['message']}"
        return text_of(feedback)

    def _pause_requested(self, request: "PauseSkill.Request") -> "PauseSkill.Response":
        try:
            if request.pause:
                self.manager.pause_skill(request.skill)
            else:
                self._check_stepping()
                self._check_not_late()
                self.manager.resume_skill(request.skill)
        except SkillError as error:
            self.log.warning(f"{'pause' if request.pause else 'resume'} refused: {error}")
            self._publish()
            return PauseSkill.Response(False, str(error))
        self._publish()
        state = (self.manager.feedback_of(request.skill) or {})["state"]
        self.log.info(f"{request.skill} {'paused in' if request.pause else 'goes on from'} {state}")
        return PauseSkill.Response(True, state)

    def _cancel_requested(self, request: "CancelSkill.Request") -> "CancelSkill.Response":
        try:
            self.manager.cancel_skill(request.skill, f"by {request.by[:_LONGEST] or 'a request'}")
        except SkillError as error:
            self.log.warning(f"cancellation refused: {error}")
            return CancelSkill.Response(False, str(error))
        feedback = self.manager.step(request.skill)  # its last one
        text = self._text_of(request.skill)
        self._publish()
        return CancelSkill.Response(feedback["status"] == CANCELLED, text)

    def _check_stepping(self) -> None:
        if not self._stepping:
            held = ", held by the emergency stop" if self.held_by_stop else ""
            raise SkillError(f"{self.name} runs no skills in {self.current_state}{held}")

    def _end_after_break(self, waited_s: float = 0.0) -> None:
        """As after a restart: what ran long ago does not go on by itself."""
        could_not_run_s = self._take_break_s(self._ticks, waited_s)
        if could_not_run_s > LONGEST_BREAK_S:
            self.manager.cancel_all_now(f"it does not go on: its process could not run for {could_not_run_s:.0f} s")

    def _check_not_late(self) -> None:
        try:
            self.check_not_late()
        except Failure as failure:
            raise SkillError(failure.reason) from None

    def _message(self, name: str) -> SkillFeedback:
        feedback = self.manager.feedback_of(name) or {"status": PROCESSING, "state": "IDLE", "progress": 0,
                                                      "message": "", "details": {}}
        message = SkillFeedback()
        if self._ticks is not None:
            message.header.stamp = Time(*self._ticks.stamp())
        message.actuator, message.skill = self.name, name
        run = self.manager._runs.get(name)
        message.goal_id = run.goal_id if run is not None else ""
        message.status = _STATUS_CODES[feedback["status"]]
        message.state, message.progress = feedback["state"], feedback["progress"]
        paused = self.manager._why_paused(name)
        message.message = ("" if paused is None else "paused: ") + feedback["message"]
        message.details = [SkillDetail(str(key), str(value)[:_LONGEST]) for key, value in feedback["details"].items()]
        if paused is not None:
            message.details.append(SkillDetail("paused", paused))
        if run is not None and run.requested_by:
            message.details.append(SkillDetail("requested_by", run.requested_by))
        return message

    def _report(self, request: "GetSkill.Request") -> "GetSkill.Response":
        response = GetSkill.Response()
        response.stepping = self._stepping
        if request.skill not in self.manager.skills:
            response.error = f"there is no skill '{request.skill[:80]}'"
            return response
        response.feedback = self._message(request.skill)
        error = self.manager.skill_errors.get(request.skill)
        if error is not None and response.feedback.status == _STATUS_CODES[FAILED]:
            response.errors = [error]
        if request.format:
            response.error = "a skill in Python has no graph"
        return response

    def _named(self, name: str, hook: Any) -> None:
        """An exception becomes the failure of the state's callback, with the name of the hook."""
        try:
            call_hook(name, hook)
        except (Failure, ProcessKilled):
            raise
        except BaseException as error:
            self.log.exception(f"{name} raised an exception")
            raise Failure(_FAILED, f"{name} raised {where(error)}") from None

    def _guard(self, name: str, hook: Any) -> bool:
        try:
            call_hook(name, hook)
        except ProcessKilled:
            raise
        except BaseException:
            self.log.exception(f"fault: {name}")
            return False
        return True


class _Request:
    """A goal, until its skill has ended."""

    def __init__(self, goal: ServerGoal) -> None:
        self.goal = goal
        self.id = "".join(f"{byte:02x}" for byte in goal._id.uuid)
        self.by = goal.client[:_LONGEST]
        self.skill = ""
        self.run = 0  # its number
        self.completed = False
        self.text = ""
        self.ended = threading.Event()

    def end(self, completed: bool, text: str) -> None:
        self.completed, self.text = completed, text
        self.ended.set()


def _value(text: str) -> Any:
    """ "[10, 20, 0]", "2.0", "true" as values; all others are texts."""
    if text in ("true", "false"):
        return text == "true"
    try:
        value: Any = ast.literal_eval(text)
    except (ValueError, SyntaxError, MemoryError, RecursionError):
        return text
    return value if isinstance(value, (bool, int, float, str, list, tuple)) else text


def _joined(name_space: str, name: str) -> str:
    parts: List[str] = [part for part in (name_space.strip("/"), name) if part]
    return "/".join(parts)


__all__ = ["SkillActuator"]
