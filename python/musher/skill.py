"""Skills in Python: functions that are called in each step until they have ended.

    from musher.skill import SkillManager

    @SkillManager.register(uses=("base",))
    def take_off(robot, altitude: float = 1.0, **kwargs):
        "Climbs to an altitude"
        skills = kwargs["skill_manager"]
        if skills.get_skill_state("take_off") is None:
            if altitude <= 0:
                return skills.form_feedback("failed", "Invalid altitude")
            skills.set_skill_state("take_off", "EXECUTING")
        if robot.height >= altitude - 0.1:
            return skills.form_feedback("completed", "Reached altitude")
        robot.climb(0.5)
        return skills.form_feedback("processing", f"{robot.height:.1f}m", 100 * robot.height / altitude)

    skills = SkillManager(robot)
    feedback = skills.execute_skill("take_off", altitude=2.0, timeout=60.0)  # again and again until it has ended

musher.SkillActuator runs the registered skills as goals of the action skill_execution, while its robot is Active.

No thread and no DDS: one thread at a time. Times are seconds of the clock that the manager is given.
"""

import contextlib
import difflib
import inspect
import math
import time
from typing import Any, Callable, Dict, Iterable, Iterator, List, Mapping, Optional, Tuple

from musher._log import call_hook, log

PROCESSING, COMPLETED, FAILED, CANCELLED = "processing", "completed", "failed", "cancelled"
_STATUSES = (PROCESSING, COMPLETED, FAILED, CANCELLED)
_ENDS = {COMPLETED: "SUCCEEDED", FAILED: "FAILED", CANCELLED: "CANCELLED"}

Feedback = Dict[str, Any]
_Function = Callable[..., Feedback]
#: (name, status) at each end of a run: bring the outputs to neutral.
_OnEnd = Callable[[Any, str], None]
#: Of the robot, when a run is paused: bring the outputs to neutral.
_OnPause = Callable[[Any], None]


class SkillError(Exception):
    """A skill that cannot be registered, or a request that is refused; nothing has changed."""


class Skill:
    """A registered function with what its requests may and have to give."""

    def __init__(self, name: str, function: _Function, timeout_s: float, uses: Tuple[str, ...],
                 on_end: Optional[_OnEnd], on_pause: Optional[_OnPause] = None,
                 may_resume: Optional[Callable[[Any], Optional[str]]] = None) -> None:
        self.name = name
        self.function = function
        self.timeout_s = timeout_s
        self.uses = uses
        self.on_end = on_end
        self.on_pause = on_pause
        self.may_resume = may_resume
        self.summary = (inspect.getdoc(function) or "").split("\n")[0]
        parameters = list(inspect.signature(function).parameters.values())
        if not parameters or parameters[0].kind not in (inspect.Parameter.POSITIONAL_ONLY,
                                                        inspect.Parameter.POSITIONAL_OR_KEYWORD):
            raise SkillError(f"{name}: the first parameter of a skill is its robot")
        self.takes_others = any(one.kind is inspect.Parameter.VAR_KEYWORD for one in parameters)
        self.parameters = {one.name: one for one in parameters[1:]
                           if one.kind in (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)}
        if not self.takes_others and "skill_manager" not in self.parameters:
            raise SkillError(f"{name}: a skill takes **kwargs, or skill_manager, in which its manager is given")
        self.parameters.pop("skill_manager", None)

    def check(self, given: Mapping[str, Any]) -> None:
        """Raises SkillError for a parameter that it does not take, with the nearest, and for a missing one."""
        for name in given:
            if name in self.parameters or self.takes_others:
                continue
            near = difflib.get_close_matches(name, self.parameters, 1)
            raise SkillError(f"{self.name}: there is no parameter {name}" + (f"; did you mean '{near[0]}'?" if near
                                                                            else ""))
        missing = [name for name, one in self.parameters.items()
                   if one.default is inspect.Parameter.empty and name not in given]
        if missing:
            raise SkillError(f"{self.name}: the parameter {missing[0]} is missing")

    def offers(self) -> List[str]:
        """The parameters of its requests as texts: "altitude: default 1.0"."""
        offered = [f"{name}: required" if one.default is inspect.Parameter.empty else f"{name}: default {one.default!r}"
                   for name, one in self.parameters.items()]
        if "timeout" not in self.parameters:
            offered.append(f"timeout: a number, default {self.timeout_s} (s; a run that takes longer fails)")
        return offered


class _Run:
    def __init__(self, skill: Skill, parameters: Dict[str, Any], timeout_s: float, number: int) -> None:
        self.skill = skill
        self.number = number  # of the runs of its manager, from 1 on; a later run of the same skill has another one
        self.parameters = parameters
        self.timeout_s = timeout_s
        self.elapsed_s = 0.0
        self.stepped_at: Optional[float] = None  # none: no time passes until the next step
        self.is_neutral = False  # its on_pause was called, and no step since
        self.end_fault = ""  # what on_end has raised: its outputs may not be neutral
        self.state: Optional[str] = None
        self.data: Dict[str, Any] = {}
        self.feedback: Feedback = {"status": PROCESSING, "state": "IDLE", "progress": 0, "message": "", "details": {}}
        self.cancel_why: Optional[str] = None
        self.pause_why: Optional[str] = None  # none: it is not paused by a request
        self.goal_id = ""  # that has started it; empty: none has
        self.requested_by = ""  # the client of that goal


class SkillManager:
    """The skills of one robot: each runs at most once at a time, and none beside one that uses the same part."""

    _global_skills: Dict[str, Skill] = {}

    @classmethod
    def register(cls, name: str = "", *, timeout: float = 600.0, uses: Iterable[str] = (),
                 on_end: Optional[_OnEnd] = None, on_pause: Optional[_OnPause] = None,
                 may_resume: Optional[Callable[[Any], Optional[str]]] = None
                 ) -> Callable[[_Function], _Function]:
        """Makes a function a skill of all robots. `timeout`: seconds of a run, then it fails. `uses`: parts of the
        robot that it needs for itself. `on_end(robot, status)` is called once at each end, however the run ends,
        but not of a run that is paused by pause_skill(). `on_pause(robot)` is called once in each pause of a run, by
        pause_skill() or pause(), and brings the outputs to neutral; without it a skill is not paused by pause_skill(),
        after which another skill may use them. Both return nothing; what they return or raise fails the run.
        `may_resume(robot)` returns why such a run may not go on, or None."""
        if callable(name):
            raise TypeError("write @SkillManager.register(), with parentheses")
        _check_timeout(timeout)

        def take(function: _Function) -> _Function:
            chosen = name or function.__name__
            known = cls._global_skills.get(chosen)
            if known is not None and known.function is not function:
                raise SkillError(f"there are two skills with the name {chosen}")
            cls._global_skills[chosen] = Skill(chosen, function, timeout, tuple(uses), on_end, on_pause,
                                                may_resume)
            return function

        return take

    def __init__(self, robot: Any, skills: Optional[Iterable[str]] = None,
                 clock: Callable[[], float] = time.monotonic) -> None:
        """`skills`: of those that are registered; none: all."""
        self.robot = robot
        self.skill_errors: Dict[str, str] = {}
        #: Called with the skill, its state before, and the new one. What it raises is logged.
        self.on_state_changed: Callable[[str, Optional[str], Optional[str]], None] = lambda skill, old, new: None
        #: Called with a skill before its run is removed, by a new start or a reset: its end is not known later.
        self.on_removal: Callable[[str], None] = lambda skill: None
        self._clock = clock
        self._chosen = None if skills is None else list(skills)
        for chosen in self._chosen or ():
            self._lookup(chosen)
        self._runs: Dict[str, _Run] = {}
        self._last_number = 0  # of a run
        self._resting = False  # all are being cancelled or paused

    # Of skills.

    @property
    def skills(self) -> Dict[str, Skill]:
        """By name."""
        every = self._global_skills
        return dict(every) if self._chosen is None else {name: every[name] for name in self._chosen}

    def get_skill_state(self, skill: str) -> Optional[str]:
        """None before the first step of a run has set one, and without a run."""
        run = self._runs.get(skill)
        return None if run is None else run.state

    def set_skill_state(self, skill: str, state: str) -> None:
        self._set_state(self._run(skill), state)

    def get_skill_data(self, skill: str, key: str, default: Any = None) -> Any:
        """Also after the end of the run, until it is started again or reset."""
        run = self._runs.get(skill)
        return default if run is None else run.data.get(key, default)

    def set_skill_data(self, skill: str, key: str, value: Any) -> None:
        self._run(skill).data[key] = value

    @staticmethod
    def form_feedback(status: str, message: str = "", progress: Optional[float] = None, **details: Any) -> Feedback:
        """What a skill returns in each step. Without a progress the last one stays."""
        return {"status": status, "message": message, "progress": progress, "details": details}

    # Of what runs them.

    def start(self, skill: str, parameters: Optional[Mapping[str, Any]] = None,
              timeout: Optional[float] = None) -> None:
        """Raises SkillError, and changes nothing, for an unknown skill or parameter, for one that runs, for one that
        needs a part of the robot which another one uses, and while cancel_all_now() or pause() runs."""
        if self._resting:  # it would move later without a request
            raise SkillError(f"{skill}: no skill is started while all are cancelled or paused")
        found = self._lookup(skill)
        given = dict(parameters or {})
        found.check(given)
        if timeout is not None:
            _check_timeout(timeout)
        if skill in self.running():
            raise SkillError(f"{skill} is running already")
        self._check_free(found)
        self._remove(skill)
        self._last_number += 1
        self._runs[skill] = _Run(found, given, found.timeout_s if timeout is None else timeout, self._last_number)

    def step(self, skill: str) -> Feedback:
        """One step of a run; after its end nothing but its feedback. A SystemExit or KeyboardInterrupt of the skill is
        raised once the run has failed by it."""
        run = self._run(skill)
        if run.feedback["status"] != PROCESSING:
            return run.feedback
        if run.pause_why is not None and run.cancel_why is None:
            return run.feedback
        now = self._clock()
        if run.stepped_at is not None:
            run.elapsed_s += max(0.0, now - run.stepped_at)
        run.stepped_at = now
        run.is_neutral = False
        if run.cancel_why is not None:
            return self._end(run, CANCELLED, run.cancel_why)
        if run.elapsed_s >= run.timeout_s:
            return self._end(run, FAILED, f"Timeout: not ended after {run.timeout_s:.1f} s")
        try:
            returned = run.skill.function(self.robot, **{**run.parameters, "skill_manager": self})
            status, message, progress, details = _checked(skill, returned)
        except Exception as error:
            return self._end(run, FAILED, f"{type(error).__name__}: {error}")
        except BaseException as error:  # of sys.exit(), or Ctrl-C
            self._end(run, FAILED, f"{type(error).__name__}: {error}")
            raise
        if run.feedback["status"] != PROCESSING:  # it has cancelled or reset itself
            return run.feedback
        run.feedback["details"] = details
        if status != PROCESSING:
            return self._end(run, status, message)
        if progress is not None:
            run.feedback["progress"] = int(min(max(progress, 0), 99))  # 100 is the success
        run.feedback["message"] = message
        run.feedback["state"] = run.state or "IDLE"
        return run.feedback

    def execute_skill(self, skill: str, *, timeout: Optional[float] = None, **parameters: Any) -> Feedback:
        """A step of the skill, which is started where it does not run: call it until the status is not "processing".
        What is refused is a failure, with the reason."""
        run = self._runs.get(skill)
        if run is None or run.feedback["status"] != PROCESSING:
            try:
                self.start(skill, parameters, timeout)
            except SkillError as error:
                return {"status": FAILED, "state": "IDLE", "progress": 0, "message": str(error), "details": {}}
        return self.step(skill)

    def cancel_skill(self, skill: str, why: str = "Cancelled") -> None:
        """In its next step. Raises SkillError for one that does not run."""
        run = self._runs.get(skill)
        if run is None or run.feedback["status"] != PROCESSING:
            raise SkillError(f"{skill} does not run")
        run.cancel_why = run.cancel_why or why

    def cancel_all_now(self, why: str) -> List[str]:
        """At once, without another step; what their on_end starts is refused. Returns what on_end has raised, with the
        name of each skill: its outputs may not be neutral."""
        runs = [self._runs[name] for name in self.running()]
        with self._rest():
            for run in runs:
                self._end(run, CANCELLED, why)
        return [f"{run.skill.name}: {run.end_fault}" for run in runs if run.end_fault]

    def pause_skill(self, skill: str, why: str = "by a request") -> None:
        """Until resume_skill(), also over pause() of all: its outputs are neutral, its time stands still, and others
        may use its parts of the robot. Raises SkillError for a skill that does not run, is paused already, is being
        cancelled, or has no on_pause."""
        run = self._running(skill)
        if run.pause_why is not None:
            raise SkillError(f"{skill} is paused already")
        if run.cancel_why is not None:
            raise SkillError(f"{skill} is being cancelled")
        if run.skill.on_pause is None:
            raise SkillError(f"{skill} cannot be paused: it is registered without on_pause")
        run.pause_why, run.stepped_at = why, None
        if not self._bring_to_neutral(run):
            raise SkillError(f"{skill} has failed: {run.feedback['message']}")

    def resume_skill(self, skill: str) -> None:
        """It goes on with its next step. Raises SkillError, and it stays paused, for one that is not paused so, when
        another skill uses a part of the robot that it needs, and when its may_resume says why not."""
        run = self._running(skill)
        if run.pause_why is None:
            raise SkillError(f"{skill} is not paused by a request")
        try:
            self._check_free(run.skill)
            why = None if run.skill.may_resume is None else run.skill.may_resume(self.robot)
        except Exception as error:
            why = str(error)
        if why is not None:
            raise SkillError(f"{skill} stays paused: {why}")
        run.pause_why, run.stepped_at = None, None

    def is_paused(self, skill: str) -> bool:
        """By pause_skill()."""
        return self._why_paused(skill) is not None

    def pause(self) -> None:
        """Until the next step: the time until then does not count, and the outputs are neutral. A skill whose on_pause
        raises has failed."""
        with self._rest():
            for run in list(self._runs.values()):
                run.stepped_at = None
                if run.feedback["status"] == PROCESSING:
                    self._bring_to_neutral(run)

    def reset_skill(self, skill: str) -> None:
        """Removes its run and data; a running one is cancelled before."""
        run = self._runs.get(skill)
        if run is not None and run.feedback["status"] == PROCESSING:
            self._end(run, CANCELLED, "it is reset")
        self._remove(skill)

    def _remove(self, skill: str) -> None:
        if skill in self._runs:
            self.on_removal(skill)
        self._runs.pop(skill, None)
        self.skill_errors.pop(skill, None)

    def running(self) -> List[str]:
        """The names of the skills that run, in the order of their starts."""
        return [name for name, run in self._runs.items() if run.feedback["status"] == PROCESSING]

    def feedback_of(self, skill: str) -> Optional[Feedback]:
        """None: it was not started since its last reset."""
        run = self._runs.get(skill)
        return None if run is None else run.feedback

    # Inside.

    def _lookup(self, skill: str) -> Skill:
        known = self._global_skills if self._chosen is None else self._chosen
        if skill in known and skill in self._global_skills:
            return self._global_skills[skill]
        near = difflib.get_close_matches(skill, known, 1)
        raise SkillError(f"there is no skill '{skill}'" + (f"; did you mean '{near[0]}'?" if near else ""))

    def _check_free(self, skill: Skill) -> None:
        for name in self.running():
            shared = set(skill.uses) & set(self.skills[name].uses)
            if name != skill.name and shared and not self.is_paused(name):
                raise SkillError(f"{skill.name} needs the {min(shared)}, which {name} is using; cancel {name} first or "
                                 "wait for its end")

    def _why_paused(self, skill: str) -> Optional[str]:
        run = self._runs.get(skill)
        return run.pause_why if run is not None and run.feedback["status"] == PROCESSING else None

    def _running(self, skill: str) -> _Run:
        self._lookup(skill)
        run = self._runs.get(skill)
        if run is None or run.feedback["status"] != PROCESSING:
            raise SkillError(f"{skill} does not run")
        return run

    def _run(self, skill: str) -> _Run:
        run = self._runs.get(skill)
        if run is None:
            raise SkillError(f"{skill} was not started")
        return run

    @contextlib.contextmanager
    def _rest(self) -> Iterator[None]:
        before, self._resting = self._resting, True
        try:
            yield
        finally:
            self._resting = before

    def _bring_to_neutral(self, run: _Run) -> bool:
        """False: its on_pause has failed, and the run with it."""
        if run.is_neutral or run.skill.on_pause is None:
            return True
        run.is_neutral = True
        try:
            call_hook("on_pause", run.skill.on_pause, self.robot)
        except BaseException as error:  # also sys.exit(): the outputs may not be neutral
            run.pause_why, run.is_neutral = None, False
            self._end(run, FAILED, f"on_pause: {type(error).__name__}: {error}")
            return False
        return True

    def _end(self, run: _Run, status: str, message: str) -> Feedback:
        if run.feedback["status"] != PROCESSING:  # its own step has ended it
            return run.feedback
        name = run.skill.name
        if status == COMPLETED and run.cancel_why is not None:
            status, message = CANCELLED, run.cancel_why
        progress = run.feedback["progress"]
        run.feedback.update(status=status, message=message, state=_ENDS[status])
        if status == COMPLETED:
            run.feedback["progress"] = 100
        if run.skill.on_end is not None and run.pause_why is None:
            try:
                call_hook("on_end", run.skill.on_end, self.robot, status)
            except BaseException as error:  # also sys.exit(): the outputs may not be neutral, no success
                run.end_fault = f"on_end: {type(error).__name__}: {error}"
                run.feedback.update(status=FAILED, message=run.end_fault, state=_ENDS[FAILED], progress=progress)
        status = run.feedback["status"]
        if status == FAILED and self._runs.get(name) is run:  # on_end may have started the skill again
            self.skill_errors[name] = run.feedback["message"]
        self._set_state(run, _ENDS[status])
        return run.feedback

    def _set_state(self, run: _Run, state: str) -> None:
        if run.state == state:
            return
        old, run.state = run.state, state
        try:
            self.on_state_changed(run.skill.name, old, state)
        except BaseException:  # it only watches: what ends at a stop does end
            log.exception("on_state_changed raised an exception")


def text_of(feedback: Feedback) -> str:
    """ "processing: Moving (30%)"."""
    return f"{feedback['status']}: {feedback['message']} ({feedback['progress']}%)"


def _check_timeout(timeout: float) -> None:
    if not (isinstance(timeout, (int, float)) and timeout > 0):
        raise SkillError(f"a timeout is a number of seconds above 0, not {timeout!r}")


def _checked(skill: str, returned: Any) -> Tuple[str, str, Optional[float], Dict[str, Any]]:
    """A failure is never taken for a success: only the word itself is one."""
    if not isinstance(returned, dict) or returned.get("status") not in _STATUSES:
        raise SkillError(f"{skill} returned {str(returned)[:80]}; expected form_feedback() with one of "
                         + ", ".join(_STATUSES))
    progress = returned.get("progress")
    if progress is not None and not (isinstance(progress, (int, float)) and math.isfinite(progress)):
        progress = None
    return returned["status"], str(returned.get("message", "")), progress, dict(returned.get("details") or {})


__all__ = ["Skill", "SkillError", "SkillManager"]
