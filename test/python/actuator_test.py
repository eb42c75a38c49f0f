"""Actuators in Python in real processes: their callbacks, failures, ends."""

import os
import signal
import subprocess
import sys
import tempfile
import unittest

import musher
from musher.example_interfaces.action import Fibonacci
from musher.musher_msgs.msg import MachineStatus
from musher.std_msgs.msg import String
from robot import DEADLINE_S, DOMAIN, Robot, end, freeze, run_python

ALL = """
class A(musher.Actuator):
    def on_set_up(self): pass
    def on_self_check(self): pass
    def on_active(self): pass
    def on_low_power(self): pass
    def on_tear_down(self): pass
"""
RUN = "musher.run(A)"


def program(methods=""):
    return ALL + "".join(f"    {line}\n" for line in methods.splitlines()) + RUN


class Actuators(unittest.TestCase):
    def start(self, programs, more="", config=""):
        if isinstance(programs, str):
            programs = {"a": programs}
        robot = Robot(programs, more, config)
        self.addCleanup(robot.close)
        robot.up()
        machine = musher.Machine(robot.file)
        self.addCleanup(machine.close)
        self.assertTrue(machine.wait_until(lambda status: status.phase in ("running", "failed"), DEADLINE_S))
        return robot, machine

    def test_a_failure_has_its_code_and_reason(self):
        robot, machine = self.start(program('def on_low_power(self): raise musher.Failure(6112, "the valve is stuck")'))
        with self.assertRaises(musher.SwitchFailed) as raised:
            machine.set("LowPower")
        self.assertEqual(raised.exception.outcome.outcome, "done-degraded")
        self.assertEqual([(one.code, one.reason) for one in raised.exception.outcome.actuators],
                         [(6112, "the valve is stuck")])

    def test_an_exception_is_a_failure_with_its_type_text_and_line_and_a_traceback_in_the_log(self):
        robot, machine = self.start(program('def on_low_power(self):\n    return {}["valve"]'))
        outcome = machine.request("LowPower")
        self.assertRegex(outcome.actuators[0].reason, r"^on_low_power raised KeyError: 'valve' \(a\.py:\d+\)$")
        robot.await_log("a", r"Traceback \(most recent call last\)")

    def test_nonsense_that_a_callback_returns_is_a_failure(self):
        robot, machine = self.start(program("def on_low_power(self): return 5"))
        self.assertRegex(machine.request("LowPower").actuators[0].reason, "on_low_power returned 5; a callback returns")

    def test_a_callback_that_exits_is_a_failure_and_the_process_continues(self):
        robot, machine = self.start(program("def on_low_power(self):\n    import sys; sys.exit(3)"))
        self.assertIn("SystemExit: 3", machine.request("LowPower").actuators[0].reason)
        self.assertTrue(machine.set("Active").done)

    def test_a_failed_self_check_keeps_the_machine_in_self_check_and_a_degraded_one_does_not(self):
        robot, machine = self.start({
            "a": program('def on_self_check(self): self.report_degraded(6105, "one finger is weak")')})
        status = machine.status()
        self.assertEqual(status.state, "Active")
        self.assertIn("one finger is weak", status.actuators[0].message)

    def test_the_gate_refuses_a_function_outside_of_its_states(self):
        robot, machine = self.start(program(
            'def on_low_power(self):\n    try:\n        with self.allowed("grip"): pass\n'
            "    except musher.NotAllowed as refusal: self.log.info(f'refused {refusal.code} {refusal.reason}')"),
            config='\n[capability.grip]\ndescription = "grip"\nactuators = ["a"]\nstates = ["Active"]\n')
        machine.set("LowPower")
        robot.await_log("a", r"refused 1(03|13) \S+")

    def test_an_emergency_stop_runs_beside_a_callback(self):
        robot, machine = self.start(program(
            "import threading\nstopped = threading.Event()\n"
            "def on_emergency_stop(self): self.stopped.set()\n"
            f"def on_low_power(self):\n    if not self.stopped.wait({DEADLINE_S}): raise musher.Failure(1, 'no stop')"),
            )
        client = musher.Machine(robot.file)
        self.addCleanup(client.close)
        import threading
        outcome = []
        switch = threading.Thread(target=lambda: outcome.append(machine.request("LowPower")))
        switch.start()
        client.wait_until(lambda status: status.actuators[0].target == "LowPower", DEADLINE_S)
        self.assertEqual(client.estop("test", timeout_s=DEADLINE_S), ["a"])
        switch.join(DEADLINE_S)
        self.assertEqual(outcome[0].outcome, "done")
        client.release_estop()

    def test_a_stop_is_not_confirmed_before_a_callback_that_may_switch_on_has_ended_and_runs_again_then(self):
        robot, machine = self.start(program(
            "switched_on = 0\n"
            "def on_active(self):\n    while __import__('os').path.exists('wait'): __import__('time').sleep(0.01)\n"
            "    self.switched_on += 1\n"
            "def on_emergency_stop(self): self.log.info(f'off after {self.switched_on}')"))
        machine.set("LowPower")
        robot.write("wait", "")
        client = musher.Machine(robot.file)
        self.addCleanup(client.close)
        import threading
        switch = threading.Thread(target=lambda: machine.request("Active"))
        switch.start()
        client.wait_until(lambda status: status.actuators[0].target == "Active", DEADLINE_S)
        with self.assertRaisesRegex(musher.Failure, "not confirmed by a .its callback for Active still runs"):
            client.estop("test", timeout_s=5.0)
        os.remove(os.path.join(robot.folder, "wait"))
        robot.await_log("a", "off after 2")
        self.assertEqual(client.estop("again", timeout_s=DEADLINE_S), ["a"])
        switch.join(DEADLINE_S)
        client.release_estop()

    def test_a_stop_whose_function_raises_is_not_confirmed(self):
        _, machine = self.start(program("def on_emergency_stop(self): raise ValueError('no brake')"))
        with self.assertRaisesRegex(musher.Failure, "ValueError: no brake"):
            machine.estop("test", timeout_s=5.0)
        machine.release_estop()  # it would be published for a minute, to the robots of the next tests, too

    # Nothing had run of it, and the stop was confirmed.
    def test_a_stop_whose_function_is_a_coroutine_or_a_generator_is_not_confirmed(self):
        _, machine = self.start({"a": program("async def on_emergency_stop(self): pass"),
                                 "b": program("def on_emergency_stop(self): yield")})
        with self.assertRaisesRegex(musher.Failure, "not confirmed by a .*on_emergency_stop returned <coroutine .*, "
                                                    "b .*on_emergency_stop returned <generator"):
            machine.estop("test", timeout_s=5.0)
        machine.release_estop()

    def test_a_stop_without_a_controller_waits_for_all_actuators_of_the_host_and_reaches_a_frozen_one_later(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        news = os.path.join(folder.name, "news")
        os.mkfifo(news)
        robot, machine = self.start({"a": program(), "b": program(
            f"def on_emergency_stop(self):\n    with open('{news}', 'w') as file: file.write('stopped')")})
        status = machine.status()
        pids = {one.name: one.pid for one in status.actuators}
        for pid in pids.values():
            self.addCleanup(end, pid)
        end(robot._up.pid)
        end(status.pid)
        freeze(pids["b"])
        with self.assertRaisesRegex(musher.Failure, "not confirmed by b"):
            machine.estop("test", timeout_s=5.0)  # for a
        publisher = machine._stops[-1].publisher_pid()
        self.assertNotEqual(publisher, 0)
        self.addCleanup(end, publisher)  # it reaches the robots of the next tests, too
        os.kill(pids["b"], signal.SIGCONT)
        with open(news, encoding="utf-8") as file:  # once b has opened it
            self.assertEqual(file.read(), "stopped")

    def test_a_restart_ends_with_the_controller_that_was_called(self):
        robot, machine = self.start(program(
            "def on_set_up(self):\n    while __import__('os').path.exists('wait'): __import__('time').sleep(0.01)"))
        first = machine.status()
        robot.write("wait", "")
        self.addCleanup(os.remove, os.path.join(robot.folder, "wait"))
        client = musher.Machine(robot.file)
        self.addCleanup(client.close)
        failures = []

        def restart():
            try:
                client.restart("a")
            except musher.Failure as failure:
                failures.append(failure)
        import threading
        thread = threading.Thread(target=restart)
        thread.start()
        status = machine.wait_until(lambda now: now.actuators[0].pid not in (0, first.actuators[0].pid), DEADLINE_S)
        self.addCleanup(end, status.actuators[0].pid)
        end(first.pid)
        thread.join(DEADLINE_S / 3)
        self.assertFalse(thread.is_alive(), "it waits on for a controller that has exited")
        self.assertIn("before it answered", str(failures[0]))

    def test_a_client_speaks_to_its_machine_beside_another_one(self):
        robot, machine = self.start(program())
        other = musher.Node("other")
        self.addCleanup(other.close)
        cat = other.publisher("/musher/machine_status", MachineStatus, latched=True, depth=1)
        cat.publish(MachineStatus(machine="cat", machine_id="c4f3", state="OTA", epoch=99))
        self.assertEqual(machine.status().machine, "robot")
        with musher.Machine() as of_this_host:
            self.assertEqual(of_this_host.status().machine, "robot")
            self.assertTrue(of_this_host.set("LowPower").done)
        with musher.Machine(machine="cat") as named:
            self.assertEqual(named.status().state, "OTA")
        robot.run("down")
        with musher.Machine() as left:
            self.assertEqual(left.status().machine, "cat", "the only one that answers")

    def test_with_keys_an_emergency_stop_is_confirmed_too(self):
        robot = Robot({"a": program()}, config='\n[security]\nkeys = "keys"\n')
        self.addCleanup(os.environ.pop, "MUSHER_KEYS", None)
        self.addCleanup(robot.close)
        self.assertEqual(robot.run("keys", "init", robot.file).returncode, 0)
        os.environ["MUSHER_KEYS"] = os.path.join(robot.folder, "keys")
        robot.up()
        with musher.Machine(robot.file) as machine:
            machine.wait_until("Active", DEADLINE_S)
            self.assertEqual(machine.estop("test", timeout_s=DEADLINE_S), ["a"])

    def test_the_status_is_answered_while_a_callback_computes_and_without_checkpoints_it_is_hung(self):
        robot, machine = self.start(
            program("def on_low_power(self):\n    while not __import__('os').path.exists('end'): pass"),
            more="checkpoint_ms = 300")
        first = machine.status().actuators[0].pid
        import threading
        switch = threading.Thread(target=lambda: machine.request("LowPower"))
        switch.start()
        hung = machine.wait_until(
            lambda status: status.actuators[0].health == "hung" or status.actuators[0].restarts > 0, DEADLINE_S)
        self.assertTrue(hung)
        machine.wait_until(lambda status: status.actuators[0].pid not in (0, first), DEADLINE_S)
        robot.write("end", "")
        machine.wait_until(lambda status: not status.degraded and status.actuators[0].state == "LowPower", DEADLINE_S)
        self.assertTrue(any("hung" in entry.message for entry in machine.history()))
        switch.join(DEADLINE_S)

    def test_a_topic_handler_that_computes_for_ever_is_hung_and_a_long_goal_of_an_action_is_not(self):
        robot, machine = self.start(
            program("def on_set_up(self):\n    from musher.std_msgs.msg import String\n"
                    "    from musher.example_interfaces.action import Fibonacci\n"
                    "    self.node.subscribe('chat', String, self.compute, latched=True)\n"
                    "    self.node.serve_action('fibonacci', Fibonacci, self.run_long)\n"
                    "def run_long(self, goal):\n    from musher.example_interfaces.action import Fibonacci\n"
                    "    goal.wait_for_cancel(3.0)\n    return Fibonacci.Result()\n"
                    "def compute(self, message):\n    while True: pass"),
            more="checkpoint_ms = 1000")
        node = musher.Node()
        self.addCleanup(node.close)
        node.action_client("fibonacci", Fibonacci).send(Fibonacci.Goal(1), DEADLINE_S).result(DEADLINE_S)
        self.assertFalse(any("hung" in entry.message for entry in machine.history()))
        first = machine.status().actuators[0].pid
        chat = node.publisher("chat", String, latched=True)
        chat.publish(String("compute"))
        self.assertTrue(machine.wait_until(lambda status: status.actuators[0].pid not in (0, first), DEADLINE_S))
        self.assertTrue(any("hung" in entry.message for entry in machine.history()))

    def test_checkpoints_keep_a_long_callback_well(self):
        robot, machine = self.start(
            program("def on_low_power(self):\n    import time\n    end = time.monotonic() + 3\n"
                    "    while time.monotonic() < end: self.checkpoint()"),
            more="checkpoint_ms = 1000")
        self.assertTrue(machine.set("LowPower").done)
        self.assertFalse(any("hung" in entry.message for entry in machine.history()))

    def test_topics_of_an_actuator_are_opened_in_set_up(self):
        robot, machine = self.start(
            "from musher.std_msgs.msg import String\n" +
            program("def on_set_up(self):\n    self.echo = self.node.publisher('echo', String, latched=True)\n"
                    "    self.node.subscribe('say', String, lambda said: self.echo.publish(String(said.data + '!')),"
                    " latched=True)"))
        from musher.std_msgs.msg import String
        with musher.Node() as node:
            received = node.subscribe("echo", String, latched=True)
            node.publisher("say", String, latched=True).publish(String("hello"))
            self.assertEqual(received.take(DEADLINE_S), String("hello!"))

    def test_an_own_state_and_several_states_have_a_method_by_decorator(self):
        robot, machine = self.start(program(
            '@musher.state("LowPower")\ndef rest(self): self.log.info("rests")').replace(
                "    def on_low_power(self): pass\n", ""))
        machine.set("LowPower")
        robot.await_log("a", "rests")


class Ends(unittest.TestCase):
    """How a program ends."""

    def robot(self):
        robot = Robot({"a": program()})
        self.addCleanup(robot.close)
        return robot

    def test_an_invalid_config_is_exit_code_2(self):
        ended = run_python(ALL + RUN, MUSHER_CONFIG="/nowhere.toml", MUSHER_ACTUATOR="a")
        self.assertEqual(ended.returncode, 2, ended.stderr)
        self.assertIn("/nowhere.toml", ended.stderr)

    def test_a_missing_callback_is_exit_code_2_with_the_method_to_write(self):
        ended = run_python("class A(musher.Actuator):\n    def on_set_up(self): pass\n    def on_selfcheck(self): pass\n"
                           + RUN, MUSHER_CONFIG=self.robot().file, MUSHER_ACTUATOR="a")
        self.assertEqual(ended.returncode, 2, ended.stderr)
        self.assertIn("write on_self_check(self) (its on_selfcheck is not one)", ended.stderr)

    def test_another_name_than_the_configs_is_exit_code_2_with_the_nearest_one(self):
        robot = Robot({"gripper": program()})
        self.addCleanup(robot.close)
        ended = run_python(ALL + '    name = "griper"\n' + RUN, MUSHER_CONFIG=robot.file)
        self.assertEqual(ended.returncode, 2, ended.stderr)
        self.assertIn("did you mean 'gripper'?", ended.stderr)

    def test_a_failed_set_up_is_exit_code_1(self):
        ended = run_python(ALL + "    def on_set_up(self): raise musher.Failure(6101, 'no port')\n" + RUN,
                           MUSHER_CONFIG=self.robot().file, MUSHER_ACTUATOR="a")
        self.assertEqual(ended.returncode, 1, ended.stderr)
        self.assertIn("no port", ended.stderr)

    def test_giving_up_is_exit_code_1(self):
        ended = run_python(ALL + "    def on_set_up(self): self.give_up(6101, 'the arm is gone')\n" + RUN,
                           MUSHER_CONFIG=self.robot().file, MUSHER_ACTUATOR="a")
        self.assertEqual(ended.returncode, 1, ended.stderr)
        self.assertIn("gives up: the arm is gone", ended.stderr)

    def test_signals_end_the_program_also_while_a_callback_is_stuck(self):
        stuck = "    def on_set_up(self):\n        print('stuck', flush=True)\n        while True: pass\n"
        for number in (signal.SIGTERM, signal.SIGINT):
            process = subprocess.Popen([sys.executable, "-c", "import musher\n" + ALL + stuck + RUN],
                                       stdout=subprocess.PIPE, text=True,
                                       env={**os.environ, "MUSHER_CONFIG": self.robot().file, "MUSHER_ACTUATOR": "a"})
            self.addCleanup(process.kill)  # it would use a CPU for ever
            self.assertEqual(process.stdout.readline(), "stuck\n")
            process.send_signal(number)
            self.assertEqual(process.wait(DEADLINE_S), -number)
            process.stdout.close()

    def test_a_program_ends_with_a_stuck_callback_and_without_a_shutdown(self):
        started = ("import threading\nstarted = threading.Event()\n" + ALL +
                   "    def on_set_up(self):\n        started.set()\n        while True: pass\n"
                   "a = A('a')\nthreading.Thread(target=a.start, daemon=True).start()\nstarted.wait()\n")
        ended = run_python(started, MUSHER_CONFIG=self.robot().file)
        self.assertEqual(ended.returncode, 1, ended.stderr)
        self.assertIn("the program ends while a callback is still running", ended.stderr)

    def test_a_program_ends_that_neither_waits_nor_shuts_down(self):
        ended = run_python(ALL + "a = A('a')\na.start()\nprint(a.current_state)", MUSHER_CONFIG=self.robot().file)
        self.assertEqual((ended.returncode, ended.stdout), (0, "SetUp\n"), ended.stderr)

    # It hung for ever.
    def test_a_program_exits_while_threads_of_its_own_run_on(self):
        begins = {"a thread": "threading.Thread(target=threading.Event().wait, name='reader').start()",
                  "a timer that begins the next": "again()",
                  "a pool": "pool.submit(threading.Event().wait)",
                  "a pool of a callback": "A.on_set_up = lambda a: pool.submit(threading.Event().wait) and give_up(a)"}
        for what, begin in begins.items():
            with self.subTest(what):
                ended = run_python(
                    "import atexit, threading\nfrom concurrent.futures import ThreadPoolExecutor\n"
                    "pool = ThreadPoolExecutor(thread_name_prefix='reader')\n"
                    "def again():\n    timer = threading.Timer(0.1, again)\n    timer.name = 'reader'\n"
                    "    timer.start()\n"
                    + ALL + "    def on_set_up(self): give_up(self)\n"
                    "def give_up(a): a.give_up(6101, 'the arm is gone')\n"
                    f"{begin}\n"
                    "atexit.register(print, 'at exit', end='')\n"
                    "try: musher.run(A)\nfinally: print('finally')\n",
                    MUSHER_CONFIG=self.robot().file, MUSHER_ACTUATOR="a")
                self.assertEqual((ended.returncode, ended.stdout), (1, "finally\nat exit"), ended.stderr)
                self.assertRegex(ended.stderr, r"the process exits while threads of its program still run, 2 s after "
                                               r"its end: reader.*; end them in on_tear_down\(\)")

    def test_a_program_waits_for_threads_of_its_own_that_end(self):
        ended = run_python(
            "import threading\nfrom concurrent.futures import ThreadPoolExecutor\npool = ThreadPoolExecutor()\n"
            "def last():\n    threading.main_thread().join()\n    print('last')\n"
            + ALL + "    def on_set_up(self): self.give_up(6101, 'the arm is gone')\n"
            "pool.submit(print, 'first').result()\nthreading.Thread(target=last).start()\n" + RUN,
            MUSHER_CONFIG=self.robot().file, MUSHER_ACTUATOR="a")
        self.assertEqual((ended.returncode, ended.stdout), (1, "first\nlast\n"), ended.stderr)
        self.assertNotIn("still run", ended.stderr)

    # It held the name as long as it ran, and its calls waited for threads that it does not have.
    def test_a_fork_neither_holds_the_name_of_its_actuator_nor_calls_it(self):
        ended = run_python(
            "import os\n" + ALL + "a = A('a')\na.start()\n"
            "(goes_on, go_on), (done, tell) = os.pipe(), os.pipe()\n"
            "child = os.fork()\n"
            "if child == 0:\n"
            "    __import__('signal').alarm(110)\n"
            "    os.close(go_on)\n"
            "    for call in (a.checkpoint, lambda: a.emergency_stopped, lambda: a.give_up(6101, ''), a.shutdown):\n"
            "        try: print('called', call(), flush=True)\n"
            "        except musher.Failure as failure: print(failure.reason, flush=True)\n"
            "    os.write(tell, b'1')\n"
            "    os.read(goes_on, 1)\n"
            "    raise SystemExit(5)\n"
            "os.close(tell)\n"
            "os.read(done, 1)\n"
            "a.shutdown()\n"
            "again = A('a')\n"
            "try: print(again.start())\n"
            "except musher.Failure as failure: print(failure.reason)\n"
            "os.close(go_on)\n"
            "print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))\n", MUSHER_CONFIG=self.robot().file)
        refused = "a runs in the process that this one is a fork of: make a node or a Machine of its own here"
        self.assertEqual(ended.stdout.splitlines(), [refused] * 4 + ["None", "5"], ended.stderr)

    def test_all_threads_have_the_same_node(self):
        ended = run_python(
            "import threading\nfrom concurrent.futures import ThreadPoolExecutor\n" + ALL +
            "    def on_set_up(self):\n"
            "        begin = threading.Barrier(8)\n"
            "        def get(number):\n            begin.wait()\n            return self.node\n"
            "        with ThreadPoolExecutor(8) as pool: print(len(set(pool.map(get, range(8)))))\n"
            "a = A('a')\na.start()\n", MUSHER_CONFIG=self.robot().file)
        self.assertEqual(ended.stdout, "1\n", ended.stderr)

    def test_use_before_the_constructor_and_after_the_end_has_a_sentence(self):
        ended = run_python(
            ALL + "a = A('a')\ntry: a.node\nexcept musher.Failure as e: print(e.reason)\n"
            "a.start()\na.shutdown()\ntry: a.node\nexcept musher.Failure as e: print(e.reason)\n"
            "class B(musher.Actuator):\n    def __init__(self): self.allowed('x')\n"
            "try: B()\nexcept RuntimeError as e: print(e)\n", MUSHER_CONFIG=self.robot().file)
        self.assertEqual(ended.returncode, 0, ended.stderr)
        self.assertEqual(ended.stdout.splitlines(),
                         ["a is not started: open its topics in on_set_up"] * 2 +
                         ["B.__init__ has not called super().__init__() yet"])


class Arguments(unittest.TestCase):
    def test_wrong_arguments_are_refused_with_a_sentence(self):
        for call, text in ((lambda: musher.Failure("6112"), "the code of a Failure is an int"),
                           (lambda: musher.Failure(0, "x"), "code 0 means success"),
                           (lambda: musher.Failure(1, 5), "the reason of a Failure is a str"),
                           (lambda: musher.state(), "takes names of states"),
                           (lambda: musher.Actuator("a").checkpoint(-1), "a time above 0 s"),
                           (lambda: musher.Actuator("a").report_degraded(0, "x"), "code 0 means success"),
                           (lambda: musher.run(5), "musher.run\\(\\) takes a class"),
                           (lambda: musher.Machine("/nowhere.toml"), "/nowhere.toml: error")):
            with self.assertRaisesRegex((TypeError, ValueError, musher.Failure), text):
                call()

    def test_two_callbacks_of_a_state_are_refused(self):
        class Twice(musher.Actuator):
            def on_active(self):
                pass

            @musher.state("Active")
            def run_it(self):
                pass

        with self.assertRaisesRegex(TypeError, "two callbacks for the state Active"):
            Twice("a")

    def test_without_a_controller_a_client_says_so(self):
        with musher.Machine(namespace="absent") as machine:
            with self.assertRaisesRegex(musher.Failure, "no controller in namespace 'absent'"):
                machine.status()
            with self.assertRaisesRegex(musher.Failure, "no controller"):
                machine.set("Active")
        self.assertGreater(DOMAIN, 0)


if __name__ == "__main__":
    unittest.main()
