"""Topics, services and actions between two nodes of a process."""

import os
import pwd
import threading
import time
import unittest
from unittest import mock

import musher
from musher._message import Message
from musher._node import default_by
from musher.example_interfaces.action import Fibonacci
from musher.rcl_interfaces.srv import ListParameters
from musher.std_msgs.msg import String
from musher.std_srvs.srv import Trigger
from robot import DEADLINE_S, run_python


class Nodes(unittest.TestCase):
    def setUp(self):
        self.here, self.there = musher.Node(), musher.Node()
        self.addCleanup(self.here.close)
        self.addCleanup(self.there.close)

    def test_a_client_waits_for_its_server_until_its_timeout(self):
        client = self.here.client("begin", Trigger)
        self.assertFalse(client.wait_until_ready(0.05))
        waited = []
        waiting = threading.Thread(target=lambda: waited.append(client.wait_until_ready(DEADLINE_S)))
        waiting.start()
        self.there.serve("begin", Trigger, lambda request: Trigger.Response(True, "begun"))
        waiting.join(DEADLINE_S)
        self.assertEqual(waited, [True])
        self.assertEqual(client.call(Trigger.Request()).message, "begun")

    # `ros2 param list` waits 5 s for each node of its list without them.
    def test_a_node_with_a_name_answers_the_services_of_parameters_with_none(self):
        for there in (musher.Node("planner"), musher.Node("dock", namespace="dog1")):
            self.addCleanup(there.close)
        for service in ("/planner/list_parameters", "/dog1/dock/list_parameters"):
            client = self.here.client(service, ListParameters)
            self.assertTrue(client.wait_until_ready(DEADLINE_S), service)
            self.assertEqual(client.call(ListParameters.Request()).result.names, [])

    def test_a_handler_gets_the_messages_and_an_exception_of_it_does_not_stop_the_next(self):
        received, all_there = [], threading.Event()

        def hear(message):
            received.append(message.data)
            if len(received) == 2:
                all_there.set()
            raise ValueError("expected by the test")

        self.there.subscribe("chat", String, hear, latched=True)
        publisher = self.here.publisher("chat", String, latched=True)
        publisher.publish(String("one"))
        publisher.publish(String("two"))
        self.assertTrue(all_there.wait(DEADLINE_S))
        self.assertEqual(received, ["one", "two"])

    def test_a_subscription_without_a_handler_is_iterated_until_it_is_closed(self):
        subscription = self.there.subscribe("chat", String, latched=True)
        self.assertIsNone(subscription.take(0))
        self.here.publisher("chat", String, latched=True).publish(String("one"))
        for message in subscription:
            self.assertEqual(message, String("one"))
            subscription.close()

    # Each of them started the timeout again.
    def test_malformed_messages_do_not_prolong_the_wait_for_one(self):
        class Number(Message):
            """Of another type than the topic says."""

            __slots__ = ("data",)
            _dds_type = String._dds_type
            _fields = (("data", "uint8", 0, None),)

            def __init__(self):
                self.data = 7

        subscription = self.there.subscribe("chat", String, latched=True)
        publisher = self.here.publisher("chat", Number, latched=True)
        ended = threading.Event()

        def publish():
            for _ in range(400):
                publisher.publish(Number())
                if ended.wait(0.05):
                    return

        publishing = threading.Thread(target=publish)
        publishing.start()
        begin = time.monotonic()
        self.assertIsNone(subscription.take(0.3))
        self.assertLess(time.monotonic() - begin, 10.0)
        ended.set()
        publishing.join(DEADLINE_S)
        self.assertGreater(subscription.malformed, 0)

    def test_a_service_replies_and_a_bad_handler_leaves_its_client_to_the_timeout(self):
        self.there.serve("good", Trigger, lambda request: Trigger.Response(True, "fine"))
        self.there.serve("bad", Trigger, lambda request: 5)
        reply = self.here.client("good", Trigger).call(Trigger.Request(), DEADLINE_S)
        self.assertEqual(reply, Trigger.Response(True, "fine"))
        with self.assertRaisesRegex(musher.Failure, "no reply in time"):
            self.here.client("bad", Trigger).call(Trigger.Request(), 0.2)
        with self.assertRaisesRegex(TypeError, "a std_srvs/srv/Trigger_Request is expected, not 5"):
            self.here.client("good", Trigger).call(5)

    def test_a_call_inside_of_a_handler_does_not_block_the_loop(self):
        self.there.serve("inner", Trigger, lambda request: Trigger.Response(True, "inner"))
        client = self.here.client("inner", Trigger)
        self.here.serve("outer", Trigger, lambda request: client.call(request, DEADLINE_S))
        reply = self.there.client("outer", Trigger).call(Trigger.Request(), DEADLINE_S)
        self.assertEqual(reply.message, "inner")

    def test_an_action_has_feedback_a_result_and_cancellation(self):
        def compute(goal):
            sequence = [0, 1]
            for _ in range(goal.goal.order):
                sequence.append(sequence[-1] + sequence[-2])
                goal.feedback(Fibonacci.Feedback(sequence))
                if goal.goal.order > 20 and goal.wait_for_cancel(DEADLINE_S):
                    raise musher.GoalCanceled(Fibonacci.Result(sequence))
            if goal.goal.order == 0:
                raise ValueError("expected by the test")
            return Fibonacci.Result(sequence)

        self.there.serve_action("fibonacci", Fibonacci, compute)
        client = self.here.action_client("fibonacci", Fibonacci)
        self.assertEqual(list(client.send(Fibonacci.Goal(3), DEADLINE_S).result(DEADLINE_S).sequence), [0, 1, 1, 2, 3])
        goal = client.send(Fibonacci.Goal(30), DEADLINE_S)
        self.assertEqual(list(next(iter(goal)).sequence), [0, 1, 1])
        goal.cancel(DEADLINE_S)
        with self.assertRaises(musher.GoalFailed) as raised:
            goal.result(DEADLINE_S)
        self.assertEqual((raised.exception.end, list(raised.exception.result.sequence)), ("canceled", [0, 1, 1]))
        with self.assertRaisesRegex(musher.GoalFailed, "the goal was aborted"):
            client.send(Fibonacci.Goal(0), DEADLINE_S).result(DEADLINE_S)

    def test_an_action_handler_that_exits_aborts_its_goal_and_logs_the_reason(self):
        ended = run_python(
            "import sys\nfrom musher.example_interfaces.action import Fibonacci\n"
            "here, there = musher.Node(), musher.Node()\n"
            "there.serve_action('fibonacci', Fibonacci, lambda goal: sys.exit('no paper'))\n"
            "goal = here.action_client('fibonacci', Fibonacci).send(Fibonacci.Goal(3), 100)\n"
            "try: goal.result(100)\nexcept musher.GoalFailed as failed: print(failed.end)")
        self.assertEqual((ended.returncode, ended.stdout), (0, "aborted\n"), ended.stderr)
        self.assertIn("action fibonacci: the handler raised an exception; the goal is aborted", ended.stderr)
        self.assertIn("SystemExit: no paper", ended.stderr)

    def test_what_is_closed_leaves_no_handler_behind_and_those_opened_later_work(self):
        before = len(self.here._delivery._handlers)
        for _ in range(3):
            closed = (self.here.subscribe("chat", String, lambda message: None),
                      self.here.serve("begin", Trigger, lambda request: Trigger.Response(True, "closed")),
                      self.here.serve_action("fibonacci", Fibonacci, lambda goal: Fibonacci.Result()))
            opened = self.here.serve("open", Trigger, lambda request: Trigger.Response(True, "open"))
            for endpoint in closed:
                endpoint.close()
                endpoint.close()
            again = self.here.serve("again", Trigger, lambda request: Trigger.Response(True, "again"))
            for name in ("open", "again"):
                reply = self.there.client(name, Trigger).call(Trigger.Request(), DEADLINE_S)
                self.assertEqual(reply.message, name)
            for endpoint in (opened, again):
                endpoint.close()
        self.assertEqual(len(self.here._delivery._handlers), before)

    def test_without_a_file_descriptor_a_call_fails_at_once_with_a_sentence(self):
        ended = run_python(
            "import resource\nfrom musher.std_srvs.srv import Trigger\n"
            "node = musher.Node()\nclient = node.client('begin', Trigger)\n"
            "resource.setrlimit(resource.RLIMIT_NOFILE, (3, resource.getrlimit(resource.RLIMIT_NOFILE)[1]))\n"
            "try: client.call(Trigger.Request(), 0.1)\nexcept musher.Failure as failure: print(failure.reason)",
            deadline_s=DEADLINE_S)
        self.assertEqual(ended.stdout, "no file descriptor for what is received: Too many open files\n", ended.stderr)

    def test_wrong_arguments_and_use_after_the_end_are_refused_with_a_sentence(self):
        async def obey(message):
            pass

        publisher = self.here.publisher("chat", String)
        for call, text in ((lambda: self.here.publisher("chat", str), "a message class is expected"),
                           (lambda: self.here.publisher("", String), "the name of a topic or service"),
                           (lambda: self.here.subscribe("chat", String, 5), "the handler of a subscription"),
                           (lambda: self.here.subscribe("chat", String, obey), "a subscription is .* without async"),
                           (lambda: self.here.serve("begin", Trigger, obey), "a service is .* without async"),
                           (lambda: self.here.serve_action("count", Fibonacci, obey), "an action is .* without async"),
                           (lambda: self.here.subscribe("chat", String, depth=-1), "depth is how many samples"),
                           (lambda: self.here.client("x", String), "a service class is expected"),
                           (lambda: publisher.publish("hello"), "a std_msgs/msg/String is expected, not 'hello'")):
            with self.assertRaisesRegex((TypeError, ValueError), text):
                call()
        self.here.close()
        with self.assertRaisesRegex(musher.Failure, "this Publisher is closed"):
            publisher.publish(String("late"))
        with self.assertRaisesRegex(musher.Failure, "the node is closed"):
            self.here.publisher("chat", String)

    # A program that systemd starts has neither variable, and the database may be on a server that does not answer.
    def test_the_user_of_a_request_is_known_without_the_user_database(self):
        of_this = pwd.getpwuid(os.getuid()).pw_name
        asked = mock.patch.object(pwd, "getpwuid", side_effect=AssertionError("the user database was read"))
        with asked, mock.patch.dict(os.environ):
            for name in ("LOGNAME", "USER", "LNAME", "USERNAME"):
                os.environ.pop(name, None)
            self.assertTrue(default_by().startswith(f"{of_this}@{os.uname().nodename} ("), default_by())
            os.environ["USER"] = "anna"
            self.assertTrue(default_by().startswith("anna@"), default_by())

    def test_a_program_ends_while_its_threads_wait_and_its_handler_computes(self):
        ended = run_python(
            "import threading\nfrom musher.std_msgs.msg import String\n"
            "node = musher.Node()\ncomputing = threading.Event()\n"
            "def compute(message):\n    computing.set()\n    while True: pass\n"
            "node.subscribe('chat', String, compute, latched=True)\n"
            "silent = node.subscribe('silent', String)\n"
            "threading.Thread(target=lambda: list(silent), daemon=True).start()\n"
            "node.publisher('chat', String, latched=True).publish(String('x'))\n"
            "computing.wait()\nprint('ends')")
        self.assertEqual((ended.returncode, ended.stdout), (0, "ends\n"), ended.stderr)


class Forks(unittest.TestCase):
    # Its end woke the node's thread of the parent, which then polled for ever.
    def test_the_end_of_a_fork_does_not_wake_the_parent(self):
        ended = run_python(
            "import os\nfrom musher.std_msgs.msg import String\n"
            "def read(name):\n"
            "    with open(f'/proc/self/fdinfo/{name}') as file: return file.read().split()\n"
            "def quiet(names):\n"
            "    infos = {name: read(name) for name in names if os.path.exists(f'/proc/self/fdinfo/{name}')}\n"
            "    return [name for name, info in infos.items() if 'eventfd-count:' in info\n"
            "            and int(info[info.index('eventfd-count:') + 1], 16) == 0]\n"
            "node = musher.Node()\nnode.subscribe('chat', String, print)\n"
            "taken = node.subscribe('talk', String)\n"
            "before = quiet(os.listdir('/proc/self/fdinfo'))\n"
            "child = os.fork()\n"
            "if child == 0:\n"
            "    try: taken.take(0.1)\n"
            "    except musher.Failure as failure: print(failure.reason, flush=True)\n"
            "    raise SystemExit(5)\n"
            "print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))\n"
            "print(len(before), before == quiet(before))")
        reason, *others = ended.stdout.splitlines()
        self.assertRegex(reason, r"^process \d+ has made this node, and this is a fork of it: make a node or a Machine")
        self.assertEqual(others, ["5", "2 True"], ended.stderr)  # those of the node and of the subscription

    # It handled the requests that waited for the parent.
    def test_a_fork_in_a_handler_handles_nothing_more(self):
        ended = run_python(
            "import os, threading\nfrom musher.std_msgs.msg import String\n"
            "node, ended = musher.Node(), threading.Event()\n"
            "def fork(message):\n"
            "    print(message.data, flush=True)\n"
            "    child = os.fork()\n"
            "    if child == 0: return __import__('signal').alarm(110)\n"
            "    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)\n"
            "    if message.data == 'b': ended.set()\n"
            "chat = node.publisher('chat', String, latched=True)\n"
            "for word in 'ab': chat.publish(String(word))\n"
            "node.subscribe('chat', String, fork, latched=True)\n"
            "ended.wait()")
        self.assertEqual(ended.stdout.splitlines(), ["a", "0", "b", "0"], ended.stderr)


if __name__ == "__main__":
    unittest.main()
