"""Skills in Python: the manager by itself, and the actuator in a real process, with the commands of `musher`."""

import json
import os
import time
import unittest
import warnings
from unittest import mock

import musher
from musher.skill import SkillError, SkillManager
from robot import DEADLINE_S, Robot


class Drone:
    height = 0.0
    climb = 0.0
    ends = 0


def _stop(robot, status):
    robot.climb = 0.0
    robot.ends += 1
    robot.last = status


def _hover(robot):
    robot.climb = 0.0


def _has_landed(robot):
    return "it has landed" if robot.height <= 0 else None


# [take_off]
@SkillManager.register(timeout=30.0, uses=("base",), on_end=_stop, on_pause=_hover, may_resume=_has_landed)
def take_off(robot, altitude=1.0, **kwargs):
    """Climbs to an altitude"""
    skills = kwargs["skill_manager"]
    if skills.get_skill_state("take_off") is None:
        if altitude <= 0:
            return skills.form_feedback("failed", "Invalid altitude")
        skills.set_skill_data("take_off", "target_altitude", altitude)
        skills.set_skill_state("take_off", "EXECUTING")
    if robot.height >= skills.get_skill_data("take_off", "target_altitude") - 0.1:
        return skills.form_feedback("completed", "Reached altitude")
    robot.climb = 0.5
    return skills.form_feedback("processing", f"{robot.height:.1f}m", 100 * robot.height / altitude)
# [take_off end]


@SkillManager.register(uses=("base",))
def walk(robot, to, skill_manager):
    return skill_manager.form_feedback("processing", f"to {to}")


def _again(robot, status):
    if robot.again:
        robot.again.pop()
        robot.skills.start("short")


@SkillManager.register(on_end=_again)
def short(robot, skill_manager):
    skill_manager.set_skill_state("short", "RUNNING")
    return skill_manager.form_feedback("completed", "Done")


def _land(robot, status):
    robot.refused = ""
    try:
        robot.skills.start("land")
    except SkillError as error:
        robot.refused = str(error)


@SkillManager.register(on_end=_land)
def fly(robot, skill_manager):
    return skill_manager.form_feedback("processing", "flies")


@SkillManager.register()
def land(robot, skill_manager):
    return skill_manager.form_feedback("processing", "lands")


def _stick(*arguments):
    raise OSError("the valve is stuck")


def _leave(*arguments, **parameters):
    raise SystemExit(3)


@SkillManager.register(on_end=_stick, on_pause=_stick)
def grip(robot, skill_manager):
    return skill_manager.form_feedback("processing", "grips")


@SkillManager.register()
def odd(robot, returns=None, raises=None, **kwargs):
    if raises:
        raise ValueError(raises)
    return returns


class AManager(unittest.TestCase):
    def setUp(self):
        self.now = 100.0
        self.drone = Drone()
        self.skills = SkillManager(self.drone, clock=lambda: self.now)

    def test_a_run_is_reported_before_it_is_removed(self):
        """The goal of such a run never ended."""
        manager = SkillManager(Drone(), ["walk"])
        removed = []
        manager.on_removal = lambda skill: removed.append((skill, manager.feedback_of(skill)["status"]))
        manager.start("walk", {"to": "a"})
        manager.reset_skill("walk")
        manager.start("walk", {"to": "b"})
        manager.cancel_skill("walk", "by its client")
        manager.step("walk")
        manager.start("walk", {"to": "c"})
        self.assertEqual(removed, [("walk", "cancelled"), ("walk", "cancelled")])

    def step(self, skill="take_off", **parameters):
        self.now += 0.1
        self.drone.height += 0.1 * self.drone.climb
        return self.skills.execute_skill(skill, **parameters)

    def test_a_run_that_the_end_of_the_one_before_has_started_is_another_one(self):
        robot = Drone()
        robot.again, ends = [1], []
        robot.skills = manager = SkillManager(robot, clock=lambda: 0.0)
        manager.on_removal = lambda skill: ends.append(dict(manager.feedback_of(skill)))
        manager.start("short")
        first = manager._run("short")
        self.assertEqual(manager.step("short")["state"], "SUCCEEDED")
        self.assertEqual([(end["status"], end["state"], end["progress"]) for end in ends],
                         [("completed", "SUCCEEDED", 100)])
        second = manager._run("short")
        self.assertGreater(second.number, first.number)
        self.assertIsNone(manager.get_skill_state("short"), "its end is not that of the new run")
        self.assertEqual(manager.running(), ["short"])
        self.assertEqual(manager.step("short")["status"], "completed")

    def test_runs_a_skill_to_its_end(self):
        changes = []
        self.skills.on_state_changed = lambda *change: changes.append(change)
        feedback = self.step(altitude=2.0)
        self.assertEqual((feedback["status"], feedback["state"]), ("processing", "EXECUTING"))
        for _ in range(100):
            if feedback["status"] != "processing":
                break
            feedback = self.step()
        self.assertEqual((feedback["status"], feedback["message"], feedback["progress"], feedback["state"]),
                         ("completed", "Reached altitude", 100, "SUCCEEDED"))
        self.assertEqual((self.drone.climb, self.drone.ends), (0.0, 1))
        self.assertEqual(changes, [("take_off", None, "EXECUTING"), ("take_off", "EXECUTING", "SUCCEEDED")])
        self.assertEqual(self.skills.get_skill_data("take_off", "target_altitude"), 2.0)

    def test_fails_with_the_reason(self):
        feedback = self.step(altitude=-1.0)
        self.assertEqual((feedback["status"], feedback["message"]), ("failed", "Invalid altitude"))
        self.assertEqual(self.skills.skill_errors, {"take_off": "Invalid altitude"})
        self.assertEqual(self.step("odd", raises="no hand")["message"], "ValueError: no hand")
        for returned in (None, True, "completed", {"status": "done"}, {}):
            feedback = self.step("odd", returns=returned)
            self.assertEqual(feedback["status"], "failed", returned)
            self.assertIn("expected form_feedback()", feedback["message"])

    def test_ends_a_run_after_its_timeout_which_a_request_may_give(self):
        self.drone.height = -1e9
        feedback = self.step(altitude=1.0, timeout=2.0)
        for _ in range(21):
            feedback = self.step()
        self.assertEqual((feedback["status"], feedback["message"]), ("failed", "Timeout: not ended after 2.0 s"))
        self.assertEqual(self.step(altitude=1.0, timeout=0.0)["message"],
                         "a timeout is a number of seconds above 0, not 0.0")

    def test_counts_no_time_of_a_pause_and_none_of_a_clock_that_is_set_back(self):
        self.drone.height = -1e9
        self.step(timeout=2.0)
        self.skills.pause()
        self.now += 1000
        self.assertEqual(self.step()["status"], "processing")
        self.now -= 500
        self.assertEqual(self.step()["status"], "processing")

    def test_refuses_what_it_cannot_start(self):
        refused = {
            "there is no skill 'take_of'; did you mean 'take_off'?": ("take_of", {}),
            "walk: the parameter to is missing": ("walk", {}),
            "walk: there is no parameter too; did you mean 'to'?": ("walk", {"too": 1}),
        }
        for message, (skill, parameters) in refused.items():
            with self.assertRaises(SkillError) as error:
                self.skills.start(skill, parameters)
            self.assertEqual(str(error.exception), message)
        self.step()
        with self.assertRaises(SkillError) as error:
            self.skills.start("take_off", {})
        self.assertEqual(str(error.exception), "take_off is running already")
        with self.assertRaises(SkillError) as error:
            self.skills.start("walk", {"to": "door"})
        self.assertIn("walk needs the base, which take_off is using", str(error.exception))
        self.assertEqual(self.step("walk", to="door")["status"], "failed")

    def test_never_reports_a_cancelled_run_as_completed(self):
        self.step(altitude=2.0)
        self.skills.cancel_skill("take_off", "by its client")
        self.drone.height = 5.0
        feedback = self.step()
        self.assertEqual((feedback["status"], feedback["message"]), ("cancelled", "by its client"))
        self.assertEqual(self.drone.ends, 1)
        with self.assertRaises(SkillError):
            self.skills.cancel_skill("take_off")
        self.step(altitude=9.0)
        self.skills.cancel_all_now("emergency stop")
        self.assertEqual(self.skills.running(), [])
        self.assertEqual((self.drone.last, self.drone.climb), ("cancelled", 0.0))

    def test_pauses_one_skill_until_it_is_resumed(self):
        self.step(altitude=2.0)
        self.step()
        self.skills.pause_skill("take_off")
        self.assertEqual(self.drone.climb, 0.0)
        height = self.drone.height
        for _ in range(400):
            self.step()
        self.assertEqual((self.drone.height, self.skills.running()), (height, ["take_off"]))
        self.assertTrue(self.skills.is_paused("take_off"))
        self.skills.pause()
        self.assertTrue(self.skills.is_paused("take_off"))
        self.skills.resume_skill("take_off")
        self.step()
        self.assertEqual(self.drone.climb, 0.5)
        self.skills.pause_skill("take_off")
        self.skills.cancel_skill("take_off", "by its client")
        self.assertEqual(self.step()["status"], "cancelled")
        self.assertFalse(self.skills.is_paused("take_off"))

    def test_the_end_of_a_paused_skill_leaves_its_parts_to_the_skill_that_uses_them_meanwhile(self):
        for end in (lambda: self.skills.cancel_skill("take_off"), lambda: self.skills.cancel_all_now("stop"),
                    lambda: self.skills.reset_skill("take_off")):
            self.step(altitude=2.0)
            self.skills.pause_skill("take_off")
            self.drone.climb = 0.7  # by the other skill
            end()
            if "take_off" in self.skills.running():
                self.assertEqual(self.step()["status"], "cancelled")
            self.assertEqual((self.drone.climb, self.skills.running()), (0.7, []))
            self.drone.height = 0.0

    def test_refuses_a_pause_or_a_resumption_with_the_reason(self):
        def why(call, skill):
            with self.assertRaises(SkillError) as error:
                call(skill)
            return str(error.exception)

        self.assertEqual(why(self.skills.pause_skill, "take_of"),
                         "there is no skill 'take_of'; did you mean 'take_off'?")
        self.assertEqual(why(self.skills.pause_skill, "take_off"), "take_off does not run")
        self.step("walk", to="door")
        self.assertEqual(why(self.skills.pause_skill, "walk"),
                         "walk cannot be paused: it is registered without on_pause")
        self.skills.cancel_all_now("the test")
        self.step(altitude=2.0)
        self.step()
        self.assertEqual(why(self.skills.resume_skill, "take_off"), "take_off is not paused by a request")
        self.skills.pause_skill("take_off")
        self.assertEqual(why(self.skills.pause_skill, "take_off"), "take_off is paused already")
        self.skills.start("walk", {"to": "door"})  # the base is free meanwhile
        self.assertIn("take_off stays paused: take_off needs the base, which walk is using",
                      why(self.skills.resume_skill, "take_off"))
        self.skills.reset_skill("walk")
        self.drone.height = 0.0
        self.assertEqual(why(self.skills.resume_skill, "take_off"), "take_off stays paused: it has landed")

    # It was stepped once Active was set again, without a request.
    def test_the_end_of_a_skill_starts_none_while_all_are_cancelled(self):
        self.drone.skills = self.skills
        self.step("fly")
        self.skills.cancel_all_now("emergency stop")
        self.assertEqual((self.skills.running(), self.drone.refused),
                         ([], "land: no skill is started while all are cancelled or paused"))
        self.step("fly")
        self.skills.cancel_skill("fly")
        self.step("fly")
        self.assertEqual((self.skills.running(), self.drone.refused), (["land"], ""))

    # The motor of a skill ran on in LowPower.
    def test_a_pause_of_all_brings_the_outputs_of_each_to_neutral_once(self):
        pauses = []
        self.step(altitude=2.0)
        self.step()
        with mock.patch.object(self.skills.skills["take_off"], "on_pause", pauses.append):
            self.skills.pause()
            self.skills.pause()
            self.skills.pause_skill("take_off")
            self.assertEqual(pauses, [self.drone])
            self.skills.resume_skill("take_off")
            self.step()
            self.skills.pause()
        self.assertEqual(pauses, [self.drone] * 2)
        self.assertEqual(self.skills.running(), ["take_off"])

    def test_a_skill_whose_on_pause_raises_has_failed(self):
        self.step("grip")
        self.skills.pause()
        self.assertEqual(self.skills.running(), [])
        self.assertEqual(self.skills.feedback_of("grip")["status"], "failed")

    def test_a_skill_whose_end_is_a_coroutine_has_failed(self):
        async def end(robot, status):
            pass

        self.step("grip")
        with mock.patch.object(self.skills.skills["grip"], "on_end", end), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # it is never awaited
            self.assertIn("grip: on_end: TypeError: on_end returned <coroutine",
                          self.skills.cancel_all_now("emergency stop")[0])
        self.step("grip")
        with mock.patch.object(self.skills.skills["grip"], "on_pause", lambda robot: 5):
            self.skills.pause()
        self.assertEqual(self.skills.running(), [])

    def test_names_the_skills_whose_end_has_failed_as_all_are_cancelled(self):
        self.step("grip")
        self.step(altitude=2.0)
        self.assertEqual(self.skills.cancel_all_now("emergency stop"),
                         ["grip: on_end: OSError: the valve is stuck"])
        self.assertEqual(self.skills.cancel_all_now("emergency stop"), [])

    # The others were neither ended nor paused, and moved on once Active was set after the stop.
    def test_all_are_cancelled_or_paused_although_a_hook_of_one_exits(self):
        pauses = []
        grip, take_off = self.skills.skills["grip"], self.skills.skills["take_off"]
        self.step("grip")
        self.step(altitude=2.0)
        with mock.patch.object(grip, "on_pause", _leave), mock.patch.object(take_off, "on_pause", pauses.append):
            self.skills.pause()
        self.assertEqual((pauses, self.skills.running()), ([self.drone], ["take_off"]))
        self.step("grip")
        with mock.patch.object(grip, "on_end", _leave), mock.patch.object(take_off, "on_end", _leave):
            self.assertEqual(self.skills.cancel_all_now("emergency stop"),
                             ["take_off: on_end: SystemExit: 3", "grip: on_end: SystemExit: 3"])
        self.assertEqual(self.skills.running(), [])
        self.assertEqual(self.skills.feedback_of("grip")["status"], "failed")

    def test_all_are_cancelled_although_what_watches_their_states_raises(self):
        self.step("grip")
        self.step(altitude=2.0)
        self.skills.on_state_changed = _stick
        self.skills.cancel_all_now("emergency stop")
        self.assertEqual(self.skills.running(), [])

    # It was called again in each step, and what had moved moved on.
    def test_a_skill_that_exits_has_failed_and_is_ended_before(self):
        ends = []
        fly = self.skills.skills["fly"]
        fly.on_end, before = lambda *end: ends.append(end), fly.on_end
        self.addCleanup(setattr, fly, "on_end", before)
        with mock.patch.object(fly, "function", _leave), self.assertRaises(SystemExit):
            self.step("fly")
        self.assertEqual(ends, [(self.drone, "failed")])
        self.assertEqual(self.skills.feedback_of("fly")["message"], "SystemExit: 3")

    # It ended twice, the second time as completed.
    def test_a_skill_that_cancels_all_in_its_step_is_cancelled(self):
        ends = []

        def abort(robot, skill_manager):
            skill_manager.cancel_all_now("enough")
            return skill_manager.form_feedback("completed", "Done")

        fly = self.skills.skills["fly"]
        fly.on_end, before = lambda *end: ends.append(end), fly.on_end
        self.addCleanup(setattr, fly, "on_end", before)
        with mock.patch.object(fly, "function", abort):
            self.assertEqual(self.step("fly")["status"], "cancelled")
        self.assertEqual(ends, [(self.drone, "cancelled")])

    def test_registers_only_what_is_a_skill(self):
        with self.assertRaises(SkillError):
            SkillManager.register()(lambda: None)
        with self.assertRaises(SkillError):
            SkillManager.register("no_manager")(lambda robot: None)
        with self.assertRaises(SkillError):
            SkillManager.register("take_off")(lambda robot, **kwargs: None)
        with self.assertRaises(TypeError):
            SkillManager.register(take_off)
        with self.assertRaises(SkillError):
            SkillManager(self.drone, ["take_of"])


ARM = """
from musher.skill import SkillManager

@SkillManager.register(on_pause=lambda robot: robot.log.info("holds"))
def wave(robot, times=3, **kwargs):
    "Waves a few times"
    skills = kwargs["skill_manager"]
    done = skills.get_skill_data("wave", "done", 0) + 1
    skills.set_skill_data("wave", "done", done)
    skills.set_skill_state("wave", "WAVING")
    if done > times:
        return skills.form_feedback("completed", f"Waved {times} times")
    return skills.form_feedback("processing", f"Wave {done}", 100 * done / times, done=done)

class Arm(musher.SkillActuator):
    name = "arm"
    robot_name = "robot_0"

    def on_pause(self):
        self.log.info("rests")

arm = Arm()
"""
RUN = "musher.run(arm)\n"
# As if its process had been stopped, and had just gone on, whenever wave is paused.
BREAKS = """
from musher import _native
fresh = _native.Item.may_be_late
_native.Item.may_be_late = lambda item, name: fresh(item, name) or (
    "arm could not run for 9 s" if arm.manager.is_paused("wave") else None)
"""


class WithArm(unittest.TestCase):
    more = ""  # of its program

    def setUp(self):
        self.robot = Robot({"arm": ARM + self.more + RUN})
        self.addCleanup(self.robot.close)
        self.robot.up()
        self.machine = musher.Machine(self.robot.file)
        self.addCleanup(self.machine.close)
        self.machine.wait_until(lambda status: status.phase in ("running", "failed"), DEADLINE_S)

    def skill(self, *words):
        return self.robot.run("skill", "run", "--timeout", "100", *words)


class AnActuatorAfterABreak(WithArm):
    more = BREAKS

    # What had waited in the kernel of a stopped process began when it went on, however old it was.
    def test_begins_and_resumes_no_skill_by_what_waited_meanwhile(self):
        node = musher.Node()
        self.addCleanup(node.close)
        from musher.plan_msgs.action import SkillExecution
        from musher.plan_msgs.msg import Parameter, RobotSkill, SkillInfo
        client = node.action_client("skill_execution", SkillExecution)
        wave = SkillInfo(skill="wave", params=[Parameter("times", "1000")])
        goal = client.send(SkillExecution.Goal(RobotSkill("robot_0", [wave])), DEADLINE_S)
        next(iter(goal))
        self.assertEqual(self.robot.run("skill", "pause", "wave").returncode, 0)
        self.assertIn("could not run for 9 s", self.robot.run("skill", "resume", "wave").stderr)
        begun = self.skill("wave")
        self.assertNotEqual(begun.returncode, 0)
        self.assertIn("could not run for 9 s", begun.stdout + begun.stderr)
        goal.cancel()
        with self.assertRaises(musher.GoalFailed) as ended:
            goal.result(DEADLINE_S)
        self.assertEqual(ended.exception.end, "canceled")


class AnActuatorAfterALongBreak(WithArm):
    # As if its computer had been suspended after the first step.
    more = """
from musher import _native
none = _native.FsmTicks.take_break_s
_native.FsmTicks.take_break_s = lambda ticks: none(ticks) or (
    90.0 if (arm.manager.feedback_of("wave") or {}).get("progress", 0) >= 1 else None)
"""

    # It waved on by itself.
    def test_ends_the_skills_that_ran(self):
        node = musher.Node()
        self.addCleanup(node.close)
        from musher.plan_msgs.action import SkillExecution
        from musher.plan_msgs.msg import Parameter, RobotSkill, SkillInfo
        client = node.action_client("skill_execution", SkillExecution)
        wave = SkillInfo(skill="wave", params=[Parameter("times", "100")])
        goal = client.send(SkillExecution.Goal(RobotSkill("robot_0", [wave])), DEADLINE_S)
        with self.assertRaises(musher.GoalFailed) as ended:
            goal.result(DEADLINE_S)
        self.assertIn("it does not go on: its process could not run for 90 s", ended.exception.result.message)


class AnActuatorThatIsBusy(WithArm):
    more = """
musher._skill_actuator.LONGEST_BREAK_S = 3.0  # instead of a minute

@SkillManager.register()
def think(robot, pipe="", **kwargs):
    "Holds the thread of the node up until the pipe has a writer"
    robot.log.info("thinks")
    open(pipe).close()
    return kwargs["skill_manager"].form_feedback("completed", "Thought")
"""

    # It was begun, made a step, and was cancelled then.
    def test_begins_no_goal_that_was_cancelled_before_its_turn(self):
        node = musher.Node()
        self.addCleanup(node.close)
        from musher.plan_msgs.action import SkillExecution
        from musher.plan_msgs.msg import Parameter, RobotSkill, SkillInfo
        client = node.action_client("skill_execution", SkillExecution)

        def request(skill, *parameters):
            return SkillExecution.Goal(RobotSkill("robot_0", [SkillInfo(skill, list(parameters))]))

        thought = os.path.join(self.robot.folder, "thought")
        os.mkfifo(thought)
        thinks = client.send(request("think", Parameter("pipe", repr(thought))), DEADLINE_S)
        self.robot.await_log("arm", "thinks")
        waves = client.send(request("wave", Parameter("times", "1000")), DEADLINE_S)
        waves._next(DEADLINE_S)  # it is accepted
        waves.cancel(DEADLINE_S)
        self.robot.write("thought", "")  # waits for the reader
        with self.assertRaises(musher.GoalFailed) as ended:
            waves.result(DEADLINE_S)
        self.assertEqual((ended.exception.end, ended.exception.result.message),
                         ("canceled", "cancelled before it started"))
        self.assertEqual(thinks.result(DEADLINE_S).message[:10], "completed:")


    # It was begun as soon as the thread was free, however long its client had waited.
    def test_begins_no_goal_that_waited_for_long(self):
        node = musher.Node()
        self.addCleanup(node.close)
        from musher.plan_msgs.action import SkillExecution
        from musher.plan_msgs.msg import Parameter, RobotSkill, SkillInfo
        client = node.action_client("skill_execution", SkillExecution)
        thought = os.path.join(self.robot.folder, "thought")
        os.mkfifo(thought)
        think = SkillInfo("think", [Parameter("pipe", repr(thought))])
        thinks = client.send(SkillExecution.Goal(RobotSkill("robot_0", [think])), DEADLINE_S)
        self.robot.await_log("arm", "thinks")
        waves = client.send(SkillExecution.Goal(RobotSkill("robot_0", [SkillInfo("wave")])), DEADLINE_S)
        waves._next(DEADLINE_S)  # it is accepted
        with self.assertRaises(musher.Failure):
            waves.result(6.0)
        self.robot.write("thought", "")  # waits for the reader
        with self.assertRaises(musher.GoalFailed) as ended:
            waves.result(DEADLINE_S)
        self.assertRegex(ended.exception.result.message, r"^arm could not run for \d+ s, and the request may be as old")
        self.assertEqual(thinks.result(DEADLINE_S).message[:10], "completed:")

    # It waved on by itself, minutes after its last step.
    def test_ends_the_skills_that_could_not_run_for_long(self):
        node = musher.Node()
        self.addCleanup(node.close)
        from musher.plan_msgs.action import SkillExecution
        from musher.plan_msgs.msg import Parameter, RobotSkill, SkillInfo
        client = node.action_client("skill_execution", SkillExecution)
        thought = os.path.join(self.robot.folder, "thought")
        os.mkfifo(thought)
        wave = SkillInfo("wave", [Parameter("times", "1000")])
        waves = client.send(SkillExecution.Goal(RobotSkill("robot_0", [wave])), DEADLINE_S)
        next(iter(waves))
        think = SkillInfo("think", [Parameter("pipe", repr(thought))])
        client.send(SkillExecution.Goal(RobotSkill("robot_0", [think])), DEADLINE_S)
        self.robot.await_log("arm", "thinks")
        with self.assertRaises(musher.Failure):
            waves.result(4.0)
        self.robot.write("thought", "")  # waits for the reader
        with self.assertRaises(musher.GoalFailed) as ended:
            waves.result(DEADLINE_S)
        self.assertIn("it does not go on: its process could not run for", ended.exception.result.message)


class AnActuatorWhoseSkillDoesNotEndWell(WithArm):
    more = """
def stick(robot, status):
    raise OSError("the valve is stuck")

@SkillManager.register(on_end=stick)
def grip(robot, **kwargs):
    return kwargs["skill_manager"].form_feedback("processing", "grips")
"""

    # It was confirmed, as only the run had failed.
    def test_confirms_no_stop_until_active_is_set_again(self):
        node = musher.Node()
        self.addCleanup(node.close)
        from musher.plan_msgs.action import SkillExecution
        from musher.plan_msgs.msg import RobotSkill, SkillInfo
        client = node.action_client("skill_execution", SkillExecution)
        goal = client.send(SkillExecution.Goal(RobotSkill("robot_0", [SkillInfo("grip")])), DEADLINE_S)
        next(iter(goal))
        for _ in range(2):
            with self.assertRaisesRegex(musher.Failure, "not confirmed by arm .*grip: on_end: OSError: the valve is "
                                                        "stuck; its outputs may not be neutral"):
                self.machine.estop("test", timeout_s=5.0)
        self.machine.release_estop()
        self.machine.set("Active")
        self.assertEqual(self.machine.estop("test", timeout_s=DEADLINE_S), ["arm"])
        self.machine.release_estop()  # it would be published for a minute, to the robots of the next tests too


class AnActuatorWhosePauseFails(WithArm):
    more = """
def fail():
    raise OSError("the valve is stuck")

arm.on_pause = fail
"""

    # The switch was done, and nothing but the log had the failure.
    def test_shows_it_in_its_status(self):
        self.machine.set("LowPower")
        shown = self.machine.wait_until(lambda status: status.actuators[0].message != "", DEADLINE_S)
        self.assertIn("on_pause raised OSError: the valve is stuck", shown.actuators[0].message)
        self.assertIn("its outputs may not be neutral", shown.actuators[0].message)


class AnActuator(WithArm):
    def test_runs_skills_as_goals_while_the_robot_is_active(self):
        ran = self.skill("wave", "times=4")
        self.assertEqual(ran.returncode, 0, ran.stdout + ran.stderr)
        self.assertIn("Waved 4 times", ran.stdout)
        refused = self.skill("wave", "times=100", "timeout=0.5")
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("Timeout: not ended after 0.5 s", refused.stdout + refused.stderr)
        self.machine.set("LowPower")
        paused = self.skill("wave")
        self.assertNotEqual(paused.returncode, 0)
        self.assertIn("arm runs no skills in LowPower", paused.stdout + paused.stderr)
        self.robot.await_log("arm", "rests")

    def test_stands_still_in_a_pause_and_goes_on_after_it(self):
        node = musher.Node()
        self.addCleanup(node.close)
        from musher.plan_msgs.action import SkillExecution
        from musher.plan_msgs.msg import Parameter, RobotSkill, SkillInfo
        client = node.action_client("skill_execution", SkillExecution)

        def request(robot_id, times):
            info = SkillInfo(skill="wave", params=[Parameter("times", times)])
            return SkillExecution.Goal(RobotSkill(robot_id, [info]))

        end = time.monotonic() + DEADLINE_S
        while not client.ready:
            self.assertLess(time.monotonic(), end)
            self.robot.run("status")
        other = client.send(request("robot_7", "2"))
        with self.assertRaises(musher.GoalFailed) as refused:
            other.result(DEADLINE_S)
        self.assertEqual(refused.exception.result.message, "the skill is for the robot 'robot_7', and this is robot_0")
        goal = client.send(request("robot_0", "1000"))
        next(iter(goal))
        paused = self.robot.run("skill", "pause", "wave")
        self.assertEqual((paused.returncode, paused.stdout), (0, "wave of arm paused in WAVING\n"), paused.stderr)
        self.robot.await_log("arm", "holds")
        self.machine.set("LowPower")
        self.assertIn("arm runs no skills in LowPower", self.robot.run("skill", "resume", "wave").stderr)
        self.machine.set("Active")
        resumed = self.robot.run("skill", "resume", "wave")
        self.assertEqual((resumed.returncode, resumed.stdout), (0, "wave of arm goes on from WAVING\n"), resumed.stderr)
        goal.cancel()
        with self.assertRaises(musher.GoalFailed) as ended:
            goal.result(DEADLINE_S)
        self.assertEqual(ended.exception.end, "canceled")
        self.assertIn("cancelled: by its client", ended.exception.result.message)

    def test_cancels_a_run_by_hand_and_names_who_has_cancelled_it(self):
        node = musher.Node()
        self.addCleanup(node.close)
        from musher.musher_msgs.srv import CancelSkill
        from musher.plan_msgs.action import SkillExecution
        from musher.plan_msgs.msg import Parameter, RobotSkill, SkillInfo
        goals = node.action_client("skill_execution", SkillExecution)
        service = node.client("arm/cancel_skill", CancelSkill)
        end = time.monotonic() + DEADLINE_S
        while not (goals.ready and service.ready):
            self.assertLess(time.monotonic(), end)
            self.robot.run("status")
        goal = goals.send(SkillExecution.Goal(RobotSkill("robot_0", [SkillInfo(skill="wave",
                                                                              params=[Parameter("times", "1000")])])))
        next(iter(goal))
        answer = service.call(CancelSkill.Request("wave", "alice@dog1"), DEADLINE_S)
        self.assertTrue(answer.success, answer.message)
        self.assertTrue(answer.message.startswith("cancelled: by alice@dog1"), answer.message)
        with self.assertRaises(musher.GoalFailed) as ended:
            goal.result(DEADLINE_S)
        self.assertEqual((ended.exception.end, ended.exception.result.message), ("aborted", answer.message))
        again = service.call(CancelSkill.Request("wave", ""), DEADLINE_S)
        self.assertEqual((again.success, again.message), (False, "wave does not run"))

    def test_reports_the_goal_of_a_run_its_client_and_a_pause_also_after_the_end(self):
        node = musher.Node()
        self.addCleanup(node.close)
        from musher.musher_msgs.srv import GetSkill
        from musher.plan_msgs.action import SkillExecution
        from musher.plan_msgs.msg import Parameter, RobotSkill, SkillInfo
        goals = node.action_client("skill_execution", SkillExecution)
        service = node.client("arm/get_skill", GetSkill)
        end = time.monotonic() + DEADLINE_S
        while not (goals.ready and service.ready):
            self.assertLess(time.monotonic(), end)
            self.robot.run("status")

        def report():
            feedback = service.call(GetSkill.Request("wave", ""), DEADLINE_S).feedback
            return feedback, {one.key: one.value for one in feedback.details}

        wave = SkillInfo(skill="wave", params=[Parameter("times", "1000")])
        goal = goals.send(SkillExecution.Goal(RobotSkill("robot_0", [wave])))
        next(iter(goal))
        feedback, details = report()
        self.assertEqual(feedback.goal_id, goal._id.hex())
        self.assertTrue(details["requested_by"].endswith("@" + os.uname().nodename), details)
        self.assertNotIn("paused", details)
        self.robot.await_log("arm", "wave started, requested by " + details["requested_by"])
        self.assertEqual(self.robot.run("skill", "pause", "wave").returncode, 0)
        self.assertEqual(report()[1]["paused"], "by a request")
        goal.cancel()
        with self.assertRaises(musher.GoalFailed):
            goal.result(DEADLINE_S)
        feedback, ended = report()
        self.assertEqual((feedback.state, feedback.goal_id), ("CANCELLED", goal._id.hex()))
        self.assertEqual(ended["requested_by"], details["requested_by"])
        self.assertNotIn("paused", ended)

    def test_says_what_it_offers(self):
        listed = self.robot.run("skill", "list", "--json")
        self.assertIn("wave", listed.stdout, listed.stderr)
        self.assertTrue(json.loads(listed.stdout))


if __name__ == "__main__":
    unittest.main()
