"""The client of docs/python.md; the commands of that page are typed by test/docs."""

import contextlib
import copy
import os
import select
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from unittest import mock

from robot import DEADLINE_S, SOURCE, Robot  # also sets the domain

import musher  # noqa: E402
from musher import _machine  # noqa: E402
from musher.musher_msgs.msg import ActuatorInfo, ActuatorStatus, EmergencyStop, MachineStatus  # noqa: E402
from musher.musher_msgs.srv import ReleaseEmergencyStop  # noqa: E402

DOG = "d0900000-0000-4000-8000-000000000002"
SECOND_DOG = "d0910000-0000-4000-8000-000000000003"


class Client(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="musher-client-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.environment = {**os.environ, "XDG_STATE_HOME": os.path.join(self.folder, "state")}
        self.robot = os.path.join(self.folder, "robot")
        shutil.copytree(os.path.join(SOURCE, "examples/python_module"), self.robot)

    def run_client(self, state):
        return subprocess.run([sys.executable, "client.py", state], cwd=self.robot, env=self.environment, text=True,
                              capture_output=True, timeout=DEADLINE_S, check=False)

    def musher(self, *arguments):
        # A file: what `up --detach` leaves running would keep a pipe open.
        with open(os.path.join(self.folder, "said"), "w+", encoding="utf-8") as said:
            ended = subprocess.run(["musher", *arguments], cwd=self.robot, env=self.environment,
                                   stdin=subprocess.DEVNULL, stdout=said, stderr=said, timeout=DEADLINE_S, check=False)
            said.seek(0)
            self.assertEqual(ended.returncode, 0, f"musher {' '.join(arguments)}: {said.read()}")

    def test_it_prints_each_state_and_says_why_a_state_is_refused(self):
        self.musher("up", "--detach", "robot.toml")
        self.addCleanup(self.musher, "down")
        follower = subprocess.Popen([sys.executable, "client.py"], cwd=self.robot, env=self.environment, text=True,
                                    stdout=subprocess.PIPE)
        self.addCleanup(follower.stdout.close)
        self.addCleanup(follower.wait, DEADLINE_S)
        self.addCleanup(follower.kill)
        self.assertEqual(follower.stdout.readline(), "Active\n")
        self.assertIn("done, the machine is in LowPower", self.run_client("LowPower").stdout)
        self.assertEqual(follower.stdout.readline(), "LowPower\n")
        refused = self.run_client("LowPwer")
        self.assertEqual(refused.returncode, 1)
        self.assertIn("did you mean 'LowPower'?", refused.stderr)

    # It waited for ever for the thread of the loop, which a fork does not have: also the emergency stop.
    def test_a_fork_of_its_program_gets_a_failure_and_ends_while_the_parent_goes_on(self):
        program = ("import os, musher\n"
                   "from musher.std_msgs.msg import String\n"
                   "machine, node = musher.Machine(machine='absent'), musher.Node('parent')\n"
                   "chat = node.publisher('chat', String)\n"
                   "child = os.fork()\n"
                   "if child == 0:\n"
                   "    __import__('signal').alarm(110)\n"
                   "    for call in (lambda: machine.estop('test'), machine.status, lambda: chat.publish(String('a'))):\n"
                   "        try: call()\n"
                   "        except musher.Failure as failure: print(failure.reason, flush=True)\n"
                   "    raise SystemExit(5)\n"
                   "print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)\n"
                   "chat.publish(String('b'))\n"
                   "print('published')\n")
        ended = subprocess.run([sys.executable, "-c", program], env=self.environment, text=True, capture_output=True,
                               timeout=DEADLINE_S, check=False)
        lines = ended.stdout.splitlines()
        self.assertEqual(lines[3:], ["5", "published"], ended.stdout + ended.stderr)
        for line in lines[:3]:
            self.assertRegex(line, r"^process \d+ has made this node, and this is a fork of it: make a node or a Machine")

    def test_it_is_meant_by_its_name_beside_a_copy_of_it_on_another_host(self):
        self.musher("up", "--detach", "robot.toml")
        self.addCleanup(self.musher, "down")
        with musher.Machine() as machine:
            robot = machine.status()
        repeated = musher.Node()
        self.addCleanup(repeated.close)
        status = MachineStatus(machine=robot.machine, machine_id="d0910000-0000-4000-8000-000000000003",
                               host="another boot/1", pid=7, phase="running", state="Active")
        repeated.publisher("musher/machine_status", MachineStatus, latched=True).publish(status)
        with musher.Machine(machine=robot.machine) as machine:
            self.assertEqual(machine.status().machine_id, robot.machine_id)
            machine.set("LowPower")
            self.assertEqual(machine.status().state, "LowPower")

    def test_a_controller_that_is_stopped_is_named(self):
        self.musher("up", "--detach", "robot.toml")
        self.addCleanup(self.musher, "down")
        with musher.Machine() as machine:
            pid = machine.status().pid
        os.kill(pid, signal.SIGSTOP)
        self.addCleanup(os.kill, pid, signal.SIGCONT)
        silent = rf"the controller of \w+ \(pid {pid}\) leads on this host, but does not answer"
        with musher.Machine() as machine:
            for call in (machine.status, lambda: machine.set("LowPower", timeout_s=1.0),
                         lambda: machine.restart("gripper", timeout_s=1.0)):
                with self.assertRaisesRegex(musher.Failure, silent):
                    call()

    def test_without_a_robot_it_says_that_there_is_no_controller(self):
        refused = self.run_client("Active")
        self.assertEqual(refused.returncode, 1)
        self.assertIn("client.py: no controller in the default namespace", refused.stderr)


class Choice(unittest.TestCase):
    """Machines of other hosts, which publish their statuses."""

    NAMESPACE = "python_choice"

    def setUp(self):
        patch = mock.patch.object(musher.Machine, "_publisher", lambda _: [])  # the tests share a namespace
        patch.start()
        self.addCleanup(patch.stop)

    def publish(self, machine, machine_id, **more):
        node = musher.Node(namespace=self.NAMESPACE)
        self.addCleanup(node.close)
        status = MachineStatus(**{"machine": machine, "machine_id": machine_id, "name_space": self.NAMESPACE,
                                  "host": "another boot/1", "pid": 7, "phase": "running", "state": "Active", **more})
        node.publisher("musher/machine_status", MachineStatus, latched=True).publish(status)
        return node

    def refusals(self, **chosen):
        """Of each method that speaks to one machine."""
        with musher.Machine(namespace=self.NAMESPACE, **chosen) as machine:
            for call in (machine.status, lambda: machine.set("Active"), lambda: machine.restart("legs")):
                with self.assertRaises(musher.Failure) as refused:
                    call()
                yield refused.exception

    def test_of_several_machines_none_is_chosen(self):
        self.publish("cat", "cafe0000-0000-4000-8000-000000000001")
        self.publish("dog", "d0900000-0000-4000-8000-000000000002")
        for refused in self.refusals():
            self.assertEqual(refused.code, 111)  # target busy
            self.assertIn("several machines answer, none of them on this host: ", refused.reason)
            self.assertIn("cat (id cafe0000)", refused.reason)
            self.assertIn("dog (id d0900000)", refused.reason)
            self.assertIn("Machine(machine=NAME) chooses one", refused.reason)
        with musher.Machine(namespace=self.NAMESPACE, machine="dog") as dog:
            self.assertEqual(dog.status().machine, "dog")

    def test_of_two_machines_of_one_name_none_is_chosen(self):
        self.publish("cat", "cafe0000-0000-4000-8000-000000000001")
        self.publish("dog", "d0900000-0000-4000-8000-000000000002")
        self.publish("dog", "d0910000-0000-4000-8000-000000000003")
        for refused in self.refusals(machine="dog"):
            self.assertEqual(refused.code, 111)
            self.assertIn("several machines are named dog: ", refused.reason)
            self.assertIn("dog (id d0900000)", refused.reason)
            self.assertIn("dog (id d0910000)", refused.reason)
            self.assertNotIn("cat", refused.reason)

    def files_of_cat(self):
        """A place with the state folder of cat, which does not run."""
        place = tempfile.mkdtemp(prefix="musher-python-")
        self.addCleanup(shutil.rmtree, place)
        state = os.path.join(place, "musher", f"cat@{self.NAMESPACE}")
        os.makedirs(state)
        with open(os.path.join(state, "machine"), "w", encoding="utf-8") as file:
            file.write(f"name cat\nnamespace {self.NAMESPACE}\ndomain {os.environ['ROS_DOMAIN_ID']}\n"
                       f"file {place}/robot.toml\nid cafe0000-0000-4000-8000-000000000001\n")
        return mock.patch.dict(os.environ, {"XDG_STATE_HOME": place})

    def test_where_the_machine_of_this_host_does_not_run_no_other_one_is_driven(self):
        self.publish("dog", "d0900000-0000-4000-8000-000000000002")
        with self.files_of_cat(), musher.Machine(namespace=self.NAMESPACE) as machine:
            self.assertEqual(machine.status().machine, "dog", "looking is free")
            for call in (lambda: machine.set("Active"), lambda: machine.restart("legs"),
                         lambda: machine.set("Active", "legs")):
                with self.assertRaises(musher.Failure) as refused:
                    call()
                self.assertIn("the machine of this host, cat, does not run; found dog. Nothing was done",
                              refused.exception.reason)
        with musher.Machine(namespace=self.NAMESPACE) as machine:
            self.assertEqual(machine._meant(acts=True)[0], "dog", "a host without files of a machine")

    # A program without the namespace of its robot moved the one in range.
    def test_where_the_machine_of_this_host_runs_in_another_namespace_no_other_one_is_driven(self):
        node = musher.Node()
        self.addCleanup(node.close)
        status = MachineStatus(machine="dog", machine_id=DOG, host="another boot/1", pid=7, phase="running",
                               state="Active")
        node.publisher("musher/machine_status", MachineStatus, latched=True).publish(status)
        with contextlib.closing(socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)) as held, musher.Machine() as machine:
            self.assertEqual(machine.status().machine, "dog", "looking is free")
            held.bind(f"\0musher/{os.environ['ROS_DOMAIN_ID']}/dogA/musher/controller")
            for call in (lambda: machine.set("Active"), lambda: machine.restart("legs")):
                with self.assertRaises(musher.Failure) as refused:
                    call()
                self.assertIn("the machine of this host runs in namespace 'dogA'; found dog in the default namespace. "
                              "Nothing was done; Machine(namespace=…)", refused.exception.reason)
        with musher.Machine(machine="dog") as machine:
            self.assertEqual(machine._meant(acts=True)[0], "dog", "a name says which one is meant")

    # It returned the status of the other one: the robot that was awaited had not even started.
    def test_where_the_machine_of_this_host_does_not_run_no_other_one_is_awaited(self):
        self.publish("dog", DOG)
        with self.files_of_cat(), musher.Machine(namespace=self.NAMESPACE) as machine:
            machine.status()
            with self.assertRaisesRegex(musher.Failure, "the machine of this host, cat, does not run; found dog"):
                machine.wait_until("Active", timeout_s=0.5)
            waited = []
            waiting = threading.Thread(target=lambda: waited.append(machine.wait_until("Active", DEADLINE_S)))
            waiting.start()
            self.publish("cat", "cafe0000-0000-4000-8000-000000000001")
            waiting.join(DEADLINE_S)
            self.assertEqual([status.machine for status in waited], ["cat"])

    def test_the_machine_of_the_files_of_this_host_is_meant_where_another_one_answers_too(self):
        self.publish("cat", "cafe0000-0000-4000-8000-000000000001")
        self.publish("dog", DOG)
        with self.files_of_cat(), musher.Machine(namespace=self.NAMESPACE) as machine:
            self.assertEqual(machine._meant(acts=True)[0], "cat")

    def led_by_another_user(self):
        """Its processes and files cannot be read."""
        hidden = mock.patch.object(_machine._native, "machine_here", lambda *_: ("", ""))
        leads = mock.patch.object(_machine._native, "leads_here", lambda *_: True)
        for patch in (hidden, leads):
            patch.start()
            self.addCleanup(patch.stop)

    # The other one was driven, or none: both had answered, and neither counted as of this host.
    def test_the_machine_of_a_controller_of_another_user_of_this_host_is_the_one_that_is_meant(self):
        self.publish("fox", "f0c50000-0000-4000-8000-000000000001")
        self.publish("dog", DOG, host=_machine._native.host_id(), pid=os.getpid())
        self.led_by_another_user()
        with self.files_of_cat():  # older ones, of this user
            with musher.Machine(namespace=self.NAMESPACE) as machine:
                self.assertEqual(machine.status().machine, "dog")
            with musher.Machine(namespace=self.NAMESPACE) as machine:
                self.assertEqual(machine._meant(acts=True), ("dog", DOG))
            with musher.Machine(namespace=self.NAMESPACE) as machine:
                self.assertEqual(machine.wait_until("Active", DEADLINE_S).machine, "dog")
            with musher.Machine(namespace=self.NAMESPACE) as machine:
                self.assertEqual(next(machine.watch()).machine, "dog")

    def test_while_a_controller_of_another_user_of_this_host_is_silent_no_other_one_is_meant(self):
        self.publish("fox", "f0c50000-0000-4000-8000-000000000001")
        self.led_by_another_user()
        with musher.Machine(namespace=self.NAMESPACE) as machine:
            for call in (machine.status, lambda: machine.set("Active"), lambda: machine.restart("legs"),
                         lambda: machine.wait_until("Active", timeout_s=0.5)):
                with self.assertRaisesRegex(musher.Failure, "a controller of this host leads, but does not answer"):
                    call()
        with musher.Machine(namespace=self.NAMESPACE, machine="fox") as fox:
            self.assertEqual(fox.status().machine, "fox")

    def test_the_environment_names_the_machine_where_the_program_names_none(self):
        self.publish("cat", "cafe0000-0000-4000-8000-000000000001")
        self.publish("dog", DOG)
        with mock.patch.dict(os.environ, {"MUSHER_MACHINE": "dog"}):
            with musher.Machine(namespace=self.NAMESPACE) as machine:
                self.assertEqual(machine.status().machine, "dog")
            with musher.Machine(namespace=self.NAMESPACE, machine="cat") as machine:
                self.assertEqual(machine.status().machine, "cat")

    def test_the_first_characters_of_its_id_choose_one_of_two_machines_of_a_name(self):
        self.publish("dog", DOG)
        self.publish("dog", SECOND_DOG)
        with musher.Machine(namespace=self.NAMESPACE, machine="d091") as second:
            self.assertEqual(second.status().machine_id, SECOND_DOG)
            self.assertEqual(second._meant(acts=True), ("dog", SECOND_DOG))
            self.assertEqual(second.wait_until("Active", DEADLINE_S).machine_id, SECOND_DOG)
            self.assertEqual(next(second.watch()).machine_id, SECOND_DOG)
        for refused in self.refusals(machine="d09"):
            self.assertEqual(refused.code, 105, "too short for an id")

    # It was bound to the first id: a robot that systemd starts instead of a person has another one.
    def test_a_machine_that_is_started_again_with_another_id_is_the_same_by_its_name(self):
        for chosen in ({"machine": "dog"}, {}):
            first = self.publish("dog", "d0900000-0000-4000-8000-000000000002")
            with musher.Machine(namespace=self.NAMESPACE, **chosen) as dog:
                self.assertEqual(dog.status().machine_id[:4], "d090")
                followed = dog.watch()
                self.assertEqual(next(followed).machine_id[:4], "d090")
                first.close()
                second = self.publish("dog", "d0910000-0000-4000-8000-000000000003")
                self.assertEqual(next(followed).machine_id[:4], "d091")
                self.assertEqual(dog.status().machine_id[:4], "d091")
                second.close()

    def stop_of(self, machine):
        """The stop that it publishes."""
        node = musher.Node(namespace=self.NAMESPACE)
        self.addCleanup(node.close)
        stops = node.subscribe("musher/emergency_stop", EmergencyStop, latched=True)
        with self.assertRaises(musher.Failure):
            machine.estop("smoke", timeout_s=0.1)  # no actuator is there
        return stops.take(DEADLINE_S)

    def test_a_stop_goes_to_each_id_of_the_name_whatever_was_found_before(self):
        self.publish("dog", "d0900000-0000-4000-8000-000000000002")
        for chosen in ({"machine": "dog"}, {}):
            with musher.Machine(namespace=self.NAMESPACE, **chosen) as dog:
                dog.status()
                stop = self.stop_of(dog)
                self.assertEqual((stop.machine, stop.machine_id), ("dog", ""))

    def test_a_stop_waits_for_no_search_of_the_processes_of_this_host(self):
        hangs = mock.patch.object(_machine._native, "machine_here", lambda *_: time.sleep(2 * DEADLINE_S))
        with hangs, musher.Machine(namespace=self.NAMESPACE, machine="dog") as dog:
            self.assertEqual(self.stop_of(dog).machine, "dog")
        with hangs, musher.Machine(namespace=self.NAMESPACE) as any_machine:
            self.assertEqual(self.stop_of(any_machine).machine, "")

    # Each machine of the namespace was stopped.
    def test_a_stop_on_a_host_where_nothing_runs_goes_to_the_machine_of_its_files(self):
        self.publish("dog", DOG)
        with self.files_of_cat(), musher.Machine(namespace=self.NAMESPACE) as machine:
            self.assertEqual(self.stop_of(machine).machine, "cat")

    # Each looked for it twice, one after the other.
    def test_a_machine_that_is_not_up_is_looked_for_once(self):
        with musher.Machine(namespace=self.NAMESPACE, machine="dog") as dog:
            dog._find_at_most_s = 3.0
            for call in (dog.status, lambda: dog.set("Active"), lambda: dog.restart("legs"), dog.release_estop):
                begin = time.monotonic()
                with self.assertRaises(musher.Failure) as refused:
                    call()
                self.assertLess(time.monotonic() - begin, 5.0)
                self.assertEqual(refused.exception.code, 105)

    # The time was over before the first status of the machine that it had found was looked at.
    def test_a_state_is_awaited_while_machines_are_looked_for(self):
        self.publish("dog", "d0900000-0000-4000-8000-000000000002")
        with mock.patch.object(_machine, "_OTHERS_S", 10.0):
            with musher.Machine(namespace=self.NAMESPACE, machine="dog") as dog:
                dog._find_at_most_s = 10.0
                self.assertEqual(dog.wait_until("Active", timeout_s=8.0).machine, "dog")

    def assert_no_controller(self, **chosen):
        with musher.Machine(namespace=self.NAMESPACE, **chosen) as machine:
            for call in (machine.status, lambda: machine.wait_until("Active", timeout_s=0.5)):
                with self.assertRaisesRegex(musher.Failure, "no controller in namespace 'python_choice'"):
                    call()

    def test_a_status_that_another_participant_repeats_is_none(self):
        self.publish("dog", DOG, participant=12345)
        self.assert_no_controller()
        self.assert_no_controller(machine="dog")

    def test_a_status_of_a_process_of_this_host_that_has_exited_is_none(self):
        with subprocess.Popen(["true"]) as ended:
            pass
        self.publish("dog", DOG, host=_machine._native.host_id(), pid=ended.pid)
        self.assert_no_controller()

    def test_a_controller_that_exits_while_a_state_is_awaited_is_named(self):
        with subprocess.Popen(["sleep", "60"]) as controller:
            self.publish("dog", DOG, host=_machine._native.host_id(), pid=controller.pid, state="SetUp")

            def is_active(status):
                controller.kill()
                return status.state == "Active"

            with musher.Machine(namespace=self.NAMESPACE, machine="dog") as dog:
                with self.assertRaisesRegex(musher.Failure, "no controller leads: that of dog .* was in SetUp"):
                    dog.wait_until(is_active, timeout_s=5.0)


# Opens a file so that no other process can until the input of this one ends.
HOLD_FILE = """import fcntl, signal, sys
signal.signal(signal.SIGIO, signal.SIG_IGN)
file = open(sys.argv[1])
fcntl.fcntl(file, fcntl.F_SETLEASE, fcntl.F_WRLCK)
print("held", flush=True)
sys.stdin.read()
"""


# Stops dog in a namespace, prints the process that goes on to publish it, and ends as its input says.
STOP_DOG = """import sys
import musher
machine = musher.Machine(namespace=sys.argv[1], machine="dog")
try:
    machine.estop("smoke", timeout_s=float(sys.argv[2]))
except musher.Failure:
    print(machine._stops[-1].publisher_pid(), flush=True)
sys.stdin.readline()
machine.close()
"""


def publish_dog(node, namespace, machine_id, latched, host="another boot/1", pid=7, stop_ids=(), receives=True,
                not_on_disk=()):
    """The statuses of dog's controller and of its only actuator, which is stopped, and latches further stops if it
    `receives` them; so does the controller, if it is `latched`."""
    legs = ActuatorInfo(name="legs", presence="present", health="well", protocol="musher", pid=7)
    status = MachineStatus(machine="dog", machine_id=machine_id, name_space=namespace, host=host, pid=pid,
                           phase="running", state="Active", actuators=[legs], emergency_stop=latched,
                           emergency_stop_by="anna" if latched else "", stop_ids=list(stop_ids),
                           not_on_disk=list(not_on_disk))
    statuses = node.publisher("musher/machine_status", MachineStatus, latched=True)
    statuses.publish(status)
    shown = copy.deepcopy(status)

    def list_stop(stop):
        if latched:
            shown.stop_ids.append(f"{stop.id:016x}")
            statuses.publish(shown)

    publish_legs(node, machine_id, list_stop, receives)
    return status


def publish_legs(node, machine_id, on_stop=lambda stop: None, receives=True):
    legs = ActuatorStatus(name="legs", state="Active", emergency_stop=1, machine="dog", machine_id=machine_id)
    statuses = node.publisher("musher/actuator_status", ActuatorStatus, latched=True)
    statuses.publish(legs)

    def latch(stop):
        meant = stop.machine in ("", "dog") and stop.machine_id in ("", machine_id)
        if receives and meant and stop.id not in legs.other_stops:
            legs.other_stops.append(stop.id)
            statuses.publish(legs)
            on_stop(stop)

    node.subscribe("musher/emergency_stop", EmergencyStop, latch, latched=True)


class StopsOfEndedPrograms(unittest.TestCase):
    """A stop that not all have confirmed is published for a minute after the end of its program."""

    def stop_dog(self, namespace, timeout_s=0.1):
        program = subprocess.Popen([sys.executable, "-c", STOP_DOG, namespace, str(timeout_s)], text=True,
                                   stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.addCleanup(program.communicate)
        self.addCleanup(program.kill)
        publisher = int(program.stdout.readline())
        self.assertNotEqual(publisher, 0)
        self.addCleanup(self.end, publisher)
        return program, publisher

    def end(self, pid):
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)

    def stop_in(self, namespace):
        """The stop that a participant receives which begins now."""
        with contextlib.closing(musher.Node(namespace=namespace)) as node:
            return node.subscribe("musher/emergency_stop", EmergencyStop, latched=True).take(DEADLINE_S)

    def test_one_whose_program_was_killed_is_published(self):
        program, _ = self.stop_dog("python_killed")
        program.kill()
        program.wait(DEADLINE_S)
        stop = self.stop_in("python_killed")
        self.assertEqual((stop.machine, stop.reason), ("dog", "smoke"))

    def test_one_whose_program_has_ended_is_published(self):
        program, _ = self.stop_dog("python_ended")
        program.communicate("\n", DEADLINE_S)
        self.assertEqual(self.stop_in("python_ended").reason, "smoke")

    # It stopped each robot of that name which was started in the minute.
    def test_one_goes_on_to_the_robot_that_was_found_and_to_no_other_one_of_the_name(self):
        with contextlib.closing(musher.Node(namespace="python_found")) as node:
            node.publisher("musher/actuator_status", ActuatorStatus, latched=True).publish(
                ActuatorStatus(name="legs", state="Active", machine="dog", machine_id=DOG, host="another boot/1"))
            program, _ = self.stop_dog("python_found", timeout_s=8.0)
        program.kill()
        program.wait(DEADLINE_S)
        stop = self.stop_in("python_found")
        self.assertEqual((stop.machine, stop.machine_id), ("dog", DOG))

    def test_one_that_is_confirmed_is_not(self):
        namespace = "python_confirmed"
        node = musher.Node(namespace=namespace)
        self.addCleanup(node.close)
        publish_dog(node, namespace, DOG, latched=True)
        with musher.Machine(namespace=namespace, machine="dog") as dog:
            pids = []
            confirm = _machine._native.Stop.confirm

            def note(stop):
                pids.append(stop.publisher_pid())
                confirm(stop)

            with mock.patch.object(_machine._native.Stop, "confirm", note):
                self.assertEqual(dog.estop("smoke", timeout_s=DEADLINE_S), ["legs"])
            self.assertNotEqual(pids[0], 0)
            with self.assertRaises(ProcessLookupError):
                os.kill(pids[0], 0)

    # It was lost if the robot lost its power within the minute.
    def test_one_that_the_controller_cannot_save_goes_on_to_be_published(self):
        namespace = "python_unsaved"
        node = musher.Node(namespace=namespace)
        self.addCleanup(node.close)
        publish_dog(node, namespace, DOG, latched=True, not_on_disk=["emergency stop (4 s): no space left"])
        with musher.Machine(namespace=namespace, machine="dog") as dog:
            with self.assertLogs("musher", "WARNING") as logs:
                self.assertEqual(dog.estop("smoke", timeout_s=DEADLINE_S), ["legs"])
            self.assertIn("not on disk: emergency stop (4 s): no space left; it is lost if the controller and the",
                          logs.output[0])
            publisher = dog._stops[-1].publisher_pid()
            self.assertNotEqual(publisher, 0)
            self.addCleanup(self.end, publisher)
        self.assertEqual(self.stop_in(namespace).reason, "smoke")

    # A controller ends the processes of an actuator with it, and finds them by its environment.
    def test_the_process_that_publishes_has_not_the_mark_of_an_actuator(self):
        marks = {"MUSHER_PROCESS": "1/2", "MUSHER_STARTED_AS": "0000000001/legs", "MUSHER_CONFIG": "/nowhere/robot.toml"}
        with mock.patch.dict(os.environ, marks):
            _, publisher = self.stop_dog("python_marked")
        with open(f"/proc/{publisher}/environ", encoding="utf-8") as file:
            names = {entry.split("=")[0] for entry in file.read().split("\0")}
        self.assertIn("ROS_DOMAIN_ID", names)
        self.assertEqual(names & set(marks), set())

    # The search for the machine may take a second, and each second counts.
    def test_the_controller_of_this_host_has_it_before_the_machine_is_searched_for(self):
        namespace = "python_handed_over"
        searched = threading.Event()
        controller = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.addCleanup(controller.close)
        controller.bind(f"\0musher/{os.environ['ROS_DOMAIN_ID']}/{namespace}/musher/controller")
        controller.settimeout(DEADLINE_S)
        no_process = mock.patch.object(musher.Machine, "_publisher", lambda _: [])
        hangs = mock.patch.object(_machine._native, "machine_here",
                                  lambda *_: searched.wait(DEADLINE_S) and ("", ""))
        with no_process, hangs, mock.patch.object(_machine, "_SEARCH_S", 2 * DEADLINE_S):
            with musher.Machine(namespace=namespace) as machine:
                def stop():
                    with contextlib.suppress(musher.Failure):
                        machine.estop("smoke", timeout_s=0.1)

                stopping = threading.Thread(target=stop)
                stopping.start()
                self.assertIn(b"smoke", controller.recv(4096))
                searched.set()
                stopping.join(DEADLINE_S)


class ReleasedStops(unittest.TestCase):
    """Of a robot that runs: what has engaged a stop publishes it no longer once it is released."""

    LEGS = """class Legs(musher.Actuator):
    def on_set_up(self): pass
    def on_self_check(self): pass
    def on_active(self): pass
    def on_low_power(self): pass
    def on_tear_down(self): pass
musher.run(Legs)"""

    def setUp(self):
        self.robot = Robot({"legs": self.LEGS})
        self.addCleanup(self.robot.close)
        self.robot.up()
        self.machine = musher.Machine(self.robot.file)
        self.addCleanup(self.machine.close)
        self.machine.wait_until("Active", DEADLINE_S)

    def engage(self, *reasons):
        """Stops of this program that count as not confirmed; returns the processes that go on with them."""
        with mock.patch.object(_machine._native.Stop, "confirm", lambda stop: None):
            for reason in reasons:
                with contextlib.suppress(musher.Failure):
                    self.machine.estop(reason, timeout_s=0.0)
        publishers = [stop.publisher_pid() for stop in self.machine._stops]
        self.assertNotIn(0, publishers)
        self.machine.wait_until(lambda status: all(reason in status.emergency_stop_reason for reason in reasons),
                                DEADLINE_S)
        return publishers

    def await_end(self, publishers):
        for pid in publishers:
            with contextlib.suppress(ProcessLookupError):
                process = os.pidfd_open(pid)
                self.addCleanup(os.close, process)
                self.assertTrue(select.select([process], [], [], DEADLINE_S)[0], "it goes on with a released stop")

    # That of the older one went on, and published it once its program ended.
    def test_a_release_ends_also_the_stops_that_newer_ones_have_replaced(self):
        publishers = self.engage("smoke", "hand in the gripper")
        self.assertEqual(len(self.machine.status().stop_ids), 1)
        self.machine.release_estop()
        self.assertEqual(self.machine._stops, [])
        self.await_end(publishers)

    # It stopped the robot again when the program ended, an hour later, too.
    def test_a_release_by_another_program_ends_them(self):
        publishers = self.engage("smoke", "hand in the gripper")
        self.assertEqual(self.robot.run("estop", "--release").returncode, 0)
        self.await_end(publishers)


class Stops(unittest.TestCase):
    """What has to be confirmed before an emergency stop is reported as done."""

    NAMESPACE = "python_stops"

    def setUp(self):
        patch = mock.patch.object(musher.Machine, "_publisher", lambda _: [])  # the tests share a namespace
        patch.start()
        self.addCleanup(patch.stop)

    def node(self):
        node = musher.Node(namespace=self.NAMESPACE)
        self.addCleanup(node.close)
        return node

    def publish(self, node, machine_id, latched, **more):
        return publish_dog(node, self.NAMESPACE, machine_id, latched, **more)

    # A stop that another person had just engaged was released, too.
    def test_a_release_covers_the_stops_that_were_seen(self):
        node = self.node()
        before = self.publish(node, DOG, latched=True, stop_ids=["00000000000000a1"])
        released = []

        def release(request):
            released.append(list(request.seen_stops))
            return ReleaseEmergencyStop.Response()

        node.serve("musher/release_emergency_stop", ReleaseEmergencyStop, release)
        dog = self.dog()
        dog.release_estop()
        self.publish(self.node(), DOG, latched=True, stop_ids=["00000000000000a1", "00000000000000b2"])
        dog.release_estop(seen=before)
        before.emergency_stop, before.stop_ids = False, []
        dog.release_estop(seen=before)
        self.assertEqual(released, [["00000000000000a1"], ["00000000000000a1"], ["0" * 16]])

    # A stop that another machine may not have received yet was not published any more.
    def test_a_release_ends_only_the_own_stops_that_it_covers(self):
        node = self.node()
        self.publish(node, DOG, latched=True, stop_ids=["00000000000000a1"], receives=False)
        node.serve("musher/release_emergency_stop", ReleaseEmergencyStop, lambda _: ReleaseEmergencyStop.Response())
        received = node.subscribe("musher/emergency_stop", EmergencyStop, latched=True)
        dog = self.dog()
        with contextlib.suppress(musher.Failure):
            dog.estop("smoke", timeout_s=0.1)
        dog.release_estop()
        self.assertEqual(len(dog._stops), 1)
        own = received.take(DEADLINE_S)
        seen = self.publish(self.node(), DOG, latched=True, stop_ids=[f"{own.id:016x}"])
        dog.release_estop(seen=seen)
        self.assertEqual(dog._stops, [])

    # It was not published any more to a second robot of the name.
    def test_a_release_by_one_of_two_robots_of_a_name_does_not_end_a_stop_of_both(self):
        node = self.node()
        self.publish(node, DOG, latched=True)
        publish_legs(self.node(), SECOND_DOG)
        node.serve("musher/release_emergency_stop", ReleaseEmergencyStop, lambda _: ReleaseEmergencyStop.Response())
        received = node.subscribe("musher/emergency_stop", EmergencyStop, latched=True)
        dog = self.dog()
        with self.assertRaisesRegex(musher.Failure, "several machines have received the stop"):
            dog.estop("smoke", timeout_s=3.0)
        own = received.take(DEADLINE_S)
        seen = MachineStatus(machine="dog", machine_id=DOG, emergency_stop=True, stop_ids=[f"{own.id:016x}"])
        with contextlib.suppress(musher.Failure):
            dog.release_estop(seen=seen)
        self.assertEqual(len(dog._stops), 1)

    def dog(self):
        machine = musher.Machine(namespace=self.NAMESPACE, machine="dog")
        self.addCleanup(machine.close)
        return machine

    # It was, at the end of the time: a controller that hangs starts actuators that are not stopped.
    def test_a_stop_that_the_controller_has_not_latched_is_not_confirmed(self):
        self.publish(self.node(), DOG, latched=False)
        with self.assertRaises(musher.Failure) as failed:
            self.dog().estop("smoke", timeout_s=1.0)
        self.assertEqual(failed.exception.code, 107)  # timeout
        self.assertEqual(failed.exception.reason,
                         "the emergency stop is engaged, but not confirmed by the controller")

    # It was: the release of the earlier one let the machine go.
    def test_a_stop_that_has_not_arrived_beside_an_earlier_one_is_not_confirmed(self):
        node = self.node()
        publish_dog(node, self.NAMESPACE, DOG, latched=True, stop_ids=["0" * 15 + "1"], receives=False)
        with self.assertRaises(musher.Failure) as failed:
            self.dog().estop("smoke", timeout_s=2.0)
        self.assertIn("this stop has not arrived; only an earlier one holds the machine", failed.exception.reason)

    def test_a_stop_that_all_have_latched_is_confirmed_before_its_time_is_over(self):
        self.publish(self.node(), DOG, latched=True)
        begin = time.monotonic()
        self.assertEqual(self.dog().estop("smoke", timeout_s=DEADLINE_S), ["legs"])
        self.assertLess(time.monotonic() - begin, DEADLINE_S / 2)

    def test_a_controller_that_was_killed_before_need_not_confirm_it(self):
        with subprocess.Popen(["true"]) as ended:
            pass
        self.publish(self.node(), DOG, latched=False, host=_machine._native.host_id(), pid=ended.pid)
        self.assertEqual(self.dog().estop("smoke", timeout_s=DEADLINE_S), ["legs"])

    def test_a_second_machine_of_the_name_that_is_found_later_is_named(self):
        self.publish(self.node(), DOG, latched=False)  # so that the stop is not over before the second one is found
        second = self.node()
        later = threading.Timer(0.1, lambda: self.publish(second, SECOND_DOG, latched=True))
        received = []  # by the name, and by the id of the first machine

        def on_stop(stop):
            if not received:
                later.start()
            received.append(stop)

        second.subscribe("musher/emergency_stop", EmergencyStop, on_stop, latched=True)
        with self.assertRaises(musher.Failure) as failed:
            self.dog().estop("smoke", timeout_s=5.0)
        later.join(DEADLINE_S)
        self.assertIn("several machines have received the stop (dog (id d0900000), dog (id d0910000))",
                      failed.exception.reason)

    def test_a_stop_goes_to_the_machine_whose_id_begins_so_and_its_controller_confirms_it(self):
        self.publish(self.node(), DOG, latched=False)
        self.publish(self.node(), SECOND_DOG, latched=True)
        stops = self.node().subscribe("musher/emergency_stop", EmergencyStop, latched=True)
        with musher.Machine(namespace=self.NAMESPACE, machine="d091") as second:
            self.assertEqual(second.estop("smoke", timeout_s=DEADLINE_S), ["legs"])
            self.assertEqual(stops.take(DEADLINE_S).machine, "d091", "it may also be a name")
            by_id = stops.take(DEADLINE_S)
            self.assertEqual((by_id.machine, by_id.machine_id), ("dog", SECOND_DOG))

    def held_file(self, of_machine):
        """Of the state folder of dog, which no other process can open; or its config."""
        folder = tempfile.mkdtemp(prefix="musher-python-")
        self.addCleanup(shutil.rmtree, folder)
        state = os.path.join(folder, "musher", f"dog@{self.NAMESPACE}.domain{os.environ['ROS_DOMAIN_ID']}")
        os.makedirs(state)
        origin = os.path.join(state, "machine")
        config = os.path.join(folder, "dog.toml")
        with open(origin, "w", encoding="utf-8") as file:
            file.write(f"name dog\nnamespace {self.NAMESPACE}\ndomain {os.environ['ROS_DOMAIN_ID']}\nfile {config}\n")
        with open(config, "w", encoding="utf-8"):
            pass
        held = origin if of_machine else config
        holder = subprocess.Popen([sys.executable, "-c", HOLD_FILE, held], text=True, stdin=subprocess.PIPE,
                                  stdout=subprocess.PIPE)
        self.addCleanup(holder.communicate)
        self.assertEqual(holder.stdout.readline(), "held\n")
        patch = mock.patch.dict(os.environ, {"XDG_STATE_HOME": folder})
        patch.start()
        self.addCleanup(patch.stop)
        return held

    def test_a_stop_ends_in_time_while_a_config_of_this_host_does_not_open(self):
        self.held_file(of_machine=False)
        publish_legs(self.node(), DOG)
        begin = time.monotonic()
        with self.assertRaises(musher.Failure) as failed:
            self.dog().estop("smoke", timeout_s=1.0)
        self.assertLess(time.monotonic() - begin, 10.0)
        self.assertEqual(failed.exception.reason,
                         "the emergency stop is engaged, but this host is still being searched")

    # It was confirmed: the folder counted as that of no machine.
    def test_a_stop_is_not_confirmed_while_the_state_folder_of_the_machine_cannot_be_read(self):
        folder = os.path.dirname(self.held_file(of_machine=True))
        publish_legs(self.node(), DOG)
        with self.assertRaises(musher.Failure) as failed:
            self.dog().estop("smoke", timeout_s=3.0)
        self.assertIn(f"no controller answers, and {folder} is not read", failed.exception.reason)


if __name__ == "__main__":
    unittest.main()
