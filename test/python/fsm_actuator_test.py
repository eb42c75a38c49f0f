"""Applications in Python that are state machines: in real processes, with the commands of `musher`."""

import contextlib
import json
import os
import shutil
import signal
import time
import unittest

import musher
from musher.musher_msgs.srv import SendCommand
from musher.std_msgs.msg import Bool, Float32, String
from robot import DEADLINE_S, SOURCE, Robot, end, freeze, run_python

SHOW = """
from musher import fsm
from musher.std_msgs.msg import String

class Scene(fsm.State):
    def __init__(self, show, name, next):
        self.show, self.name, self.next = show, name, next

    def declare(self, transitions):
        transitions.to(self.next, "next")
        transitions.on("next")

    def check_transition(self, tick):
        return fsm.Next.to(self.next) if tick.command == "next" else None

    def run(self, tick):
        self.show.in_scene(self.name, tick)

class Show(musher.FsmActuator):
    name = "show"
    safe = True

    def in_scene(self, name, tick): pass

    def build_machine(self, machine):
        machine.add_event("next")
        machine.add("GREET", Scene(self, "GREET", "PLAY"))
        machine.add("PLAY", Scene(self, "PLAY", "GREET"))
        if self.safe:
            machine.add("STOP", Scene(self, "STOP", "GREET"), fsm.Role.SAFE)
        machine.build("GREET")
"""


def program(methods=""):
    return SHOW + "".join(f"    {line}\n" for line in methods.splitlines()) + "musher.run(Show)\n"


# Of a show: blocks the thread of the node until the pipe has a writer.
HOLD = """    self.node.subscribe('hold', String, self.hold)
def hold(self, word):
    self.log.info('held')
    open(word.data).close()"""


class WithRobot(unittest.TestCase):
    def start(self, robot):
        self.addCleanup(robot.close)
        robot.up()
        machine = musher.Machine(robot.file)
        self.addCleanup(machine.close)
        machine.wait_until(lambda status: status.phase in ("running", "failed"), DEADLINE_S)
        self.robot, self.machine = robot, machine
        self.node = musher.Node()
        self.addCleanup(self.node.close)

    def behavior(self, name):
        ran = self.robot.run("behavior", name, "--json")
        self.assertEqual(ran.returncode, 0, ran.stderr)
        return json.loads(ran.stdout)

    def await_behavior(self, name, holds):
        end = time.monotonic() + DEADLINE_S
        while True:
            report = self.behavior(name)
            if holds(report):
                return report
            self.assertLess(time.monotonic(), end, report)

    def states_of(self, name):
        return self.node.subscribe(f"{name}/behavior_state", String, latched=True, depth=100)

    def await_state(self, states, path):
        while True:
            state = states.take(DEADLINE_S)
            if state is None:
                self.fail(f"it does not become {path}: {self.robot.run('describe', 'show').stdout}")
            if state.data == path:
                return


class Door(WithRobot):
    """The example."""

    def setUp(self):
        robot = Robot({})
        shutil.copytree(os.path.join(SOURCE, "examples/python_application"), robot.folder, dirs_exist_ok=True)
        self.start(robot)

    def test_it_is_commanded_and_drawn_by_the_commands_of_musher(self):
        states = self.states_of("door")
        self.await_state(states, "CLOSED")
        report = self.behavior("door")
        self.assertEqual((report["state"], report["mode"]), ("CLOSED", "NORMAL"))
        self.assertEqual(self.robot.run("behavior", "door", "--send", "open").returncode, 0)
        self.await_state(states, "OPEN")
        report = self.behavior("door")
        self.assertEqual([(change["from"], change["to"], change["cause"], change["command"])
                          for change in report["history"]],
                         [(None, "CLOSED", "started", None), ("CLOSED", "OPEN", "decided", "open")])
        refused = self.robot.run("behavior", "door", "--send", "opne")
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("did you mean 'open'", refused.stderr)
        picture = self.robot.run("graph", "--behavior", "door")
        self.assertIn("digraph", picture.stdout)
        self.assertIn("BLOCKED", picture.stdout)

    def test_its_topics_and_its_states_share_data(self):
        opening = self.node.subscribe("door/opening", Float32)
        obstacle = self.node.publisher("door/obstacle", Bool, latched=True)
        states = self.states_of("door")
        self.await_state(states, "CLOSED")
        # The door's subscription is volatile: it gets what is published once both know each other.
        end = time.monotonic() + DEADLINE_S
        while not obstacle.matched:
            self.behavior("door")
            self.assertLess(time.monotonic(), end, "the door does not subscribe to door/obstacle")
        obstacle.publish(Bool(True))
        self.await_state(states, "BLOCKED")
        self.assertEqual(self.behavior("door")["unsafe"], "an obstacle")
        obstacle.publish(Bool(False))
        self.await_state(states, "OPEN")
        sample = Float32()
        while sample.data != 1:
            sample = opening.take(DEADLINE_S)
            self.assertIsNotNone(sample)


class Applications(WithRobot):
    def show(self, methods="", more="", config=""):
        self.start(Robot({"show": program(methods)}, more, config))

    def await_match(self, publisher):
        end = time.monotonic() + DEADLINE_S
        while not publisher.matched:
            self.behavior("show")
            self.assertLess(time.monotonic(), end, "it has no subscription")

    def hold(self):
        """The thread of the node is blocked; returns the pipe whose writer ends that."""
        hold = self.node.publisher("hold", String)
        self.await_match(hold)
        pipe = os.path.join(self.robot.folder, "pipe")
        os.mkfifo(pipe)
        hold.publish(String(pipe))
        self.robot.await_log("show", " held$")
        return pipe

    def test_the_machine_is_paused_outside_of_active_and_continues_where_it_was(self):
        self.show("def on_pause(self): self.log.info('pauses')\ndef on_resume(self): self.log.info('resumes')")
        states = self.states_of("show")
        self.await_state(states, "GREET")
        self.assertEqual(self.robot.run("behavior", "show", "--send", "next").returncode, 0)
        self.await_state(states, "PLAY")
        self.machine.set("LowPower")
        paused = self.behavior("show")
        self.assertEqual((paused["ticking"], paused["state"]), (False, "PLAY"))
        self.assertIn("show is paused in LowPower", self.robot.run("behavior", "show", "--send", "next").stderr)
        self.assertEqual(self.behavior("show")["ticks"], paused["ticks"])
        self.machine.set("Active")
        resumed = self.behavior("show")
        self.assertEqual((resumed["ticking"], resumed["state"]), (True, "PLAY"))
        lines = [line.split()[-1] for line in self.robot.await_log("show", " resumes$", count=2)]
        self.assertEqual([line for line in lines if line in ("pauses", "resumes")], ["resumes", "pauses", "resumes"])

    def test_a_machine_that_does_not_resume_begins_again(self):
        self.show("resumes = False")
        states = self.states_of("show")
        self.await_state(states, "GREET")
        self.assertEqual(self.robot.run("behavior", "show", "--send", "next").returncode, 0)
        self.await_state(states, "PLAY")
        self.machine.set("LowPower")
        self.machine.set("Active")
        self.assertEqual(self.behavior("show")["state"], "GREET")

    def test_a_machine_that_its_application_has_stopped_begins_again_by_start_only(self):
        self.show("def after_tick(self):\n    if self.machine.state == 'PLAY': self.machine.stop()")
        self.await_state(self.states_of("show"), "GREET")
        self.assertEqual(self.robot.run("behavior", "show", "--send", "next").returncode, 0)
        self.await_behavior("show", lambda report: not report["ticking"])
        self.machine.set("LowPower")
        self.machine.set("Active")
        self.assertFalse(self.behavior("show")["ticking"])
        self.assertIn("waits for START", self.robot.run("behavior", "show", "--send", "next").stderr)
        self.assertEqual(self.robot.run("behavior", "show", "--send", "START").returncode, 0)
        self.assertTrue(self.behavior("show")["ticking"])

    def test_start_begins_no_machine_that_a_released_stop_holds(self):
        self.show("def after_tick(self):\n    if self.machine.state == 'PLAY': self.machine.stop()")
        self.await_state(self.states_of("show"), "GREET")
        self.assertEqual(self.robot.run("behavior", "show", "--send", "next").returncode, 0)
        self.await_behavior("show", lambda report: not report["ticking"])
        self.assertEqual(self.machine.estop("test", timeout_s=DEADLINE_S), ["show"])
        self.machine.release_estop()
        refused = self.robot.run("behavior", "show", "--send", "START")
        self.assertIn("show is paused in Active, held by the emergency stop", refused.stderr)
        self.assertFalse(self.behavior("show")["ticking"])
        self.machine.set("Active")
        self.assertEqual(self.robot.run("behavior", "show", "--send", "START").returncode, 0)
        self.assertTrue(self.behavior("show")["ticking"])

    def test_start_that_waited_while_its_process_was_stopped_begins_no_machine(self):
        self.show("def after_tick(self):\n    if self.machine.state == 'PLAY': self.machine.stop()\n"
                  "def open_topics(self):\n"
                  "    fresh = musher._native.Item.may_be_late\n"
                  "    musher._native.Item.may_be_late = lambda item, name: fresh(item, name) or (\n"
                  "        None if self.machine.state == 'GREET' else 'it could not run for 9 s')")
        self.await_state(self.states_of("show"), "GREET")
        self.assertEqual(self.robot.run("behavior", "show", "--send", "next").returncode, 0)
        self.await_behavior("show", lambda report: not report["ticking"])
        self.assertIn("it could not run for 9 s", self.robot.run("behavior", "show", "--send", "START").stderr)
        self.assertFalse(self.behavior("show")["ticking"])

    # A door opened by a command that had waited while the computer was suspended.
    def test_a_command_that_waited_while_its_process_was_stopped_is_refused(self):
        self.show("def open_topics(self):\n"
                  "    fresh = musher._native.Item.may_be_late\n"
                  "    musher._native.Item.may_be_late = lambda item, name: fresh(item, name) or 'it could not run for 9 s'")
        self.await_state(self.states_of("show"), "GREET")
        self.assertIn("it could not run for 9 s", self.robot.run("behavior", "show", "--send", "next").stderr)
        self.assertEqual(self.behavior("show")["state"], "GREET")

    # It played on by itself when the computer was opened an hour later.
    def test_begins_at_its_start_after_a_long_break(self):
        self.show("def open_topics(self):\n"
                  "    none = musher._native.FsmTicks.take_break_s\n"
                  "    musher._native.FsmTicks.take_break_s = lambda ticks: none(ticks) or (\n"
                  "        90.0 if self.machine.state == 'PLAY' else None)")
        states = self.states_of("show")
        self.await_state(states, "GREET")
        self.assertEqual(self.robot.run("behavior", "show", "--send", "next").returncode, 0)
        self.await_state(states, "PLAY")
        self.await_state(states, "GREET")
        self.assertTrue(self.behavior("show")["ticking"])

    # It stood in Active, and neither ticked nor waited for START.
    def test_begins_at_its_start_after_a_long_break_although_its_state_exits(self):
        self.show("def open_topics(self):\n"
                  "    none = musher._native.FsmTicks.take_break_s\n"
                  "    musher._native.FsmTicks.take_break_s = lambda ticks: none(ticks) or (\n"
                  "        90.0 if self.machine.state == 'PLAY' else None)\n"
                  "def leave(scene, tick):\n"
                  "    if scene.name == 'PLAY': raise SystemExit(3)\n"
                  "Scene.on_exit = leave")
        states = self.states_of("show")
        self.await_state(states, "GREET")
        self.assertEqual(self.robot.run("behavior", "show", "--send", "next").returncode, 0)
        self.await_state(states, "PLAY")
        self.await_state(states, "GREET")
        self.assertTrue(self.behavior("show")["ticking"])

    # It was ended by its first tick, and resumed, again and again.
    def test_a_long_on_resume_is_no_break_of_the_machine(self):
        self.show("def on_resume(self):\n"
                  "    now = musher._node._since_boot_s\n"
                  "    musher._node._since_boot_s = lambda: now() + 90.0")
        states = self.states_of("show")
        self.await_state(states, "GREET")
        self.assertEqual(self.robot.run("behavior", "show", "--send", "next").returncode, 0)
        self.await_state(states, "PLAY")

    # The tests before replace what the extension finds out. Here it is the real one; a controller would end the
    # stopped process and start another one.
    def test_a_process_that_was_stopped_for_long_refuses_a_start_that_waited_and_begins_at_its_start(self):
        self.show("def open_topics(self): musher._fsm_actuator.LONGEST_BREAK_S = 5.0")  # instead of a minute
        states = self.states_of("show")
        self.await_state(states, "GREET")
        self.assertEqual(self.robot.run("behavior", "show", "--send", "next").returncode, 0)
        self.await_state(states, "PLAY")
        status = self.machine.status()
        show = status.actuators[0].pid
        self.addCleanup(end, show)
        end(self.robot._up.pid)
        end(status.pid)
        starts = self.node.client("show/send_command", SendCommand)
        self.assertTrue(starts.wait_until_ready(DEADLINE_S))
        freeze(show)
        with self.assertRaises(musher.Failure):
            starts.call(SendCommand.Request("START"), 6.0)  # it waits in the kernel for as long
        os.kill(show, signal.SIGCONT)
        refused = starts.call(SendCommand.Request("START"), DEADLINE_S)
        self.assertFalse(refused.success)
        self.assertRegex(refused.message, r"^show could not run for \d+ s, and the request may be as old")
        self.await_state(states, "GREET")

    # The loop runs on while the node's thread is blocked, and requests wait in front of it: the door opened by a command
    # that had not been answered for 20 s.
    def test_what_waited_for_the_thread_of_the_node_is_refused(self):
        self.show("def open_topics(self):\n"
                  "    self.node.subscribe('next', String, self.obey)\n" + HOLD + "\n"
                  "def obey(self, word):\n"
                  "    try: self.check_not_late()\n"
                  "    except musher.Failure as failure: return self.log.info(f'refused: {failure.reason}')\n"
                  "    self.log.info('obeyed')\n    self.send(word.data)")
        states = self.states_of("show")
        self.await_state(states, "GREET")
        obey = self.node.publisher("next", String)
        commands = self.node.client("show/send_command", SendCommand)
        self.assertTrue(commands.wait_until_ready(DEADLINE_S))
        self.await_match(obey)
        pipe = self.hold()
        obey.publish(String("next"))
        with self.assertRaises(musher.Failure):
            commands.call(SendCommand.Request("next"), 6.0)  # it waits for the thread for as long
        self.robot.write(pipe, "")  # waits for the reader
        late = r"refused: show could not run for \d+ s, and the request may be as old: look at the robot, then repeat it"
        self.robot.await_log("show", late)
        self.assertEqual(self.behavior("show")["state"], "GREET")
        self.assertTrue(commands.call(SendCommand.Request("next"), DEADLINE_S).success)
        self.await_state(states, "PLAY")
        obey.publish(String("next"))
        self.robot.await_log("show", " obeyed$")

    def test_begins_at_its_start_after_a_handler_has_blocked_its_ticks_for_long(self):
        self.show("def open_topics(self):\n"
                  "    musher._fsm_actuator.LONGEST_BREAK_S = 3.0  # instead of a minute\n" + HOLD)
        states = self.states_of("show")
        self.await_state(states, "GREET")
        commands = self.node.client("show/send_command", SendCommand)
        self.assertTrue(commands.call(SendCommand.Request("next"), DEADLINE_S).success)
        self.await_state(states, "PLAY")
        pipe = self.hold()
        with self.assertRaises(musher.Failure):
            commands.call(SendCommand.Request("nothing"), 4.0)
        self.robot.write(pipe, "")  # waits for the reader
        self.await_state(states, "GREET")

    def test_an_emergency_stop_whose_pause_fails_is_not_confirmed(self):
        self.show("def on_pause(self): raise OSError('the port is gone')")
        self.await_state(self.states_of("show"), "GREET")
        with self.assertRaisesRegex(musher.Failure, "not confirmed by show .*on_pause raised OSError: the port is gone"):
            self.machine.estop("test", timeout_s=5.0)
        self.assertFalse(self.behavior("show")["ticking"])
        self.machine.release_estop()  # it would be published for a minute, to the robots of the next tests too

    # The switch was done, and nothing but the log had the failure.
    def test_the_status_shows_a_pause_that_has_failed_until_one_succeeds(self):
        self.show("def on_pause(self):\n"
                  "    if not __import__('os').path.exists('port'): raise OSError('the port is gone')")
        self.await_state(self.states_of("show"), "GREET")
        self.machine.set("LowPower")
        fault = r"on_pause raised OSError: the port is gone \(show\.py:\d+\); its outputs may not be neutral"
        shown = self.machine.wait_until(lambda status: status.actuators[0].message != "", DEADLINE_S)
        self.assertRegex(shown.actuators[0].message, fault)
        self.machine.set("Active")
        self.robot.write("port", "")
        self.machine.set("LowPower")
        self.assertTrue(self.machine.wait_until(lambda status: status.actuators[0].message == "", DEADLINE_S))

    # Nothing of it had run, and the stop was confirmed.
    def test_an_emergency_stop_whose_pause_is_a_coroutine_is_not_confirmed(self):
        self.show("async def on_pause(self): pass")
        self.await_state(self.states_of("show"), "GREET")
        with self.assertRaisesRegex(musher.Failure, "not confirmed by show .*on_pause"):
            self.machine.estop("test", timeout_s=5.0)
        self.machine.release_estop()

    def test_set_up_fails_with_a_hook_that_is_a_coroutine(self):
        robot = Robot({"show": program()})
        self.addCleanup(robot.close)
        for hook in ("build_machine(self, machine)", "open_topics(self)"):
            ended = run_python(program(f"async def {hook}: pass"), MUSHER_CONFIG=robot.file, MUSHER_ACTUATOR="show")
            self.assertEqual(ended.returncode, 1, ended.stderr)
            self.assertIn(f"{hook.split('(')[0]} returned <coroutine", ended.stderr)

    # It ticked on during a stop that was confirmed while START was under way on its thread.
    def test_start_from_a_thread_of_the_application_begins_no_machine_during_a_stop(self):
        self.show("def after_tick(self):\n    if self.machine.state == 'PLAY': self.machine.stop()\n"
                  "def open_topics(self): __import__('threading').Thread(target=self.begin, daemon=True).start()\n"
                  "def wait_for(self, file):\n"
                  "    while not __import__('os').path.exists(file): __import__('time').sleep(0.01)\n"
                  "def begin(self):\n    self.wait_for('start')\n    self.send('START')\n    self.log.info('sent')\n"
                  "def on_resume(self):\n"
                  "    if __import__('os').path.exists('start'):\n"
                  "        self.log.info('begins')\n        self.wait_for('stopped')")
        self.await_state(self.states_of("show"), "GREET")
        self.assertEqual(self.robot.run("behavior", "show", "--send", "next").returncode, 0)
        self.await_behavior("show", lambda report: not report["ticking"])
        self.robot.write("start", "")
        self.robot.await_log("show", " begins$")
        with contextlib.suppress(musher.Failure):  # not confirmed before it has ended
            self.machine.estop("test", timeout_s=2.0)
        self.robot.write("stopped", "")
        self.robot.await_log("show", " sent$")
        self.assertFalse(self.behavior("show")["ticking"])
        self.assertEqual(self.machine.estop("again", timeout_s=DEADLINE_S), ["show"])
        self.machine.release_estop()

    def test_an_emergency_stop_pauses_the_machine_until_active_is_set_again(self):
        self.show("def on_pause(self): self.log.info('pauses')")
        self.await_state(self.states_of("show"), "GREET")
        self.assertEqual(self.machine.estop("test", timeout_s=DEADLINE_S), ["show"])
        self.assertTrue(self.await_behavior("show", lambda report: not report["ticking"])["held_by_stop"])
        self.machine.release_estop()
        self.assertFalse(self.behavior("show")["ticking"])
        self.machine.set("Active")
        self.assertTrue(self.behavior("show")["ticking"])

    def test_a_state_that_raises_leads_to_the_safe_state_with_a_traceback_in_the_log(self):
        self.show("def in_scene(self, name, tick):\n    if name == 'PLAY': raise ValueError('no music')")
        states = self.states_of("show")
        self.await_state(states, "GREET")
        self.assertEqual(self.robot.run("behavior", "show", "--send", "next").returncode, 0)
        self.await_state(states, "STOP")
        self.assertRegex(self.behavior("show")["last_fault"], r"^PLAY: Run: ValueError: no music \(show\.py:\d+\)$")
        self.robot.await_log("show", r"Traceback \(most recent call last\)")

    def test_a_state_that_exits_leads_to_the_safe_state_and_an_emergency_stop_is_still_handled(self):
        self.show("def in_scene(self, name, tick):\n    if name == 'PLAY': raise SystemExit(3)\n"
                  "def on_pause(self): self.log.info('outputs off')")
        states = self.states_of("show")
        self.await_state(states, "GREET")
        self.assertEqual(self.robot.run("behavior", "show", "--send", "next").returncode, 0)
        self.await_state(states, "STOP")
        self.assertEqual(self.machine.estop("a test", timeout_s=DEADLINE_S), ["show"])
        self.robot.await_log("show", "outputs off")

    def test_without_a_safe_state_the_process_ends_and_is_restarted(self):
        self.show("safe = False\ndef in_scene(self, name, tick):\n    if name == 'PLAY': raise ValueError('no music')")
        self.await_state(self.states_of("show"), "GREET")
        self.assertEqual(self.robot.run("behavior", "show", "--send", "next").returncode, 0)
        self.machine.wait_until(lambda status: status.actuators[0].restarts > 0, DEADLINE_S)
        self.robot.await_log("show", "gives up: PLAY: Run: ValueError: no music")

    def test_a_hook_around_the_tick_that_raises_is_logged_once_and_leads_to_the_safe_state(self):
        self.show("def after_tick(self):\n    if self.machine.ticks < 20: raise ValueError('no camera')\n"
                  "    if self.machine.ticks == 20: self.log.info('a camera')")
        self.await_state(self.states_of("show"), "STOP")
        lines = self.robot.await_log("show", " a camera$")
        self.assertEqual(sum("fault: after_tick: ValueError: no camera" in line for line in lines), 1)

    def test_a_tick_that_computes_for_ever_is_hung_and_the_status_is_answered_meanwhile(self):
        self.show("def in_scene(self, name, tick):\n"
                  "    import os\n"
                  "    while name == 'PLAY' and not os.path.exists('end'): pass", more="checkpoint_ms = 300")
        first = self.machine.status().actuators[0].pid
        self.await_state(self.states_of("show"), "GREET")
        self.assertEqual(self.robot.run("behavior", "show", "--send", "next").returncode, 0)
        self.machine.wait_until(lambda status: status.actuators[0].pid not in (0, first), DEADLINE_S)
        self.robot.write("end", "")
        self.assertTrue(any("hung" in entry.message for entry in self.machine.history()))

    def test_a_slow_rate_is_not_hung_between_its_ticks(self):
        self.show("rate_hz = 0.25", more="checkpoint_ms = 2000")  # 100 were too few for Python on a busy computer
        self.await_state(self.states_of("show"), "GREET")
        self.await_behavior("show", lambda report: report["ticks"] >= 2)
        self.assertFalse(any("hung" in entry.message for entry in self.machine.history()))

    def test_the_time_of_the_machine_is_the_worlds(self):
        from musher.builtin_interfaces.msg import Time
        from musher.rosgraph_msgs.msg import Clock
        self.show(config='clock = "topic"\n')
        self.await_state(self.states_of("show"), "GREET")
        clock = self.node.publisher("/clock", Clock, reliable=False)
        seconds = 1000

        def passed(report):
            nonlocal seconds
            seconds += 30
            clock.publish(Clock(Time(seconds, 0)))
            return report["time_s"] >= 100

        self.assertLess(self.await_behavior("show", passed)["time_s"], seconds - 1000 + 1)

    def test_set_up_fails_with_all_errors_of_the_machine(self):
        robot = Robot({"show": program()})
        self.addCleanup(robot.close)
        for method, text in (("def build_machine(self, machine): machine.build('A')", "no states are registered"),
                             ("def build_machine(self, machine): pass", "has not called machine.build\\(\\)"),
                             ("def build_machine(self, machine): 1 / 0",
                              r"build_machine raised ZeroDivisionError: division by zero \(<string>:\d+\)"),
                             ("def open_topics(self): raise musher.Failure(6105, 'no camera')", "no camera")):
            ended = run_python(program(method), MUSHER_CONFIG=robot.file, MUSHER_ACTUATOR="show")
            self.assertEqual(ended.returncode, 1, ended.stderr)
            self.assertRegex(ended.stderr, text)

    def test_a_callback_that_would_replace_the_machines_is_refused(self):
        for method in ("def on_active(self): pass", "def on_state(self, state): pass",
                       "@musher.state('Docked')\ndef rest(self): pass"):
            ended = run_python(program(method))
            self.assertEqual(ended.returncode, 1)
            self.assertIn("override on_pause(), on_resume() or self_check()", ended.stderr)


if __name__ == "__main__":
    unittest.main()
