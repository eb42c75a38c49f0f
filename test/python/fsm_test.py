"""State machines with states of Python, in virtual time."""

import dataclasses
import enum
import gc
import unittest
import weakref

import musher
from musher import fsm

LOG = []


class Scene(fsm.State):
    """Goes to `next` after `time_s`, or by the command "skip"; writes what is called into LOG."""

    def __init__(self, name, next, time_s=1.0, raises=()):
        self.name, self.next, self.time_s, self.raises = name, next, time_s, raises

    def note(self, call):
        LOG.append(f"{self.name} {call}")
        if call in self.raises:
            raise ValueError(f"no {call}")

    def declare(self, transitions):
        if self.next:
            transitions.to(self.next, f"after {self.time_s} s")
        if transitions.find("skip"):
            transitions.on("skip")

    def on_enter(self, tick):
        self.note("on_enter")

    def run(self, tick):
        self.note("run")

    def check_transition(self, tick):
        if self.next and (tick.command == "skip" or tick.elapsed_s >= self.time_s):
            return fsm.Next.to(self.next)

    def on_exit(self, tick):
        self.note("on_exit")


class WithMachine(unittest.TestCase):
    def setUp(self):
        LOG.clear()
        self.now_s = 100.0

    def machine(self, *states, name="show", start=None, safe=None, begin=True, **options):
        machine = fsm.Machine(name, **options)
        machine.add_event("skip")
        for state in states:
            machine.add(state.name, state, fsm.Role.SAFE if state is safe else fsm.Role.NORMAL)
        machine.build(start or states[0].name)
        if begin:
            machine.start(self.now_s)
        return machine

    def tick(self, machine, times=1, step_s=0.1):
        for _ in range(times):
            self.now_s += step_s
            machine.run_once(self.now_s)


class Machines(WithMachine):
    def test_the_functions_of_a_state_are_called_in_the_order_of_the_engine(self):
        machine = self.machine(Scene("A", "B", 0.15), Scene("B", "A", 9))
        self.tick(machine, 3)
        self.assertEqual(LOG, ["A on_enter", "A run", "A on_exit", "B on_enter", "B run"])
        self.assertEqual([(change.from_state, change.to_state, change.cause) for change in machine.history],
                         [("", "A", "started"), ("A", "B", "decided")])
        machine.stop()
        self.assertEqual((LOG[-1], machine.running, machine.path), ("B on_exit", False, ""))

    def test_a_tick_has_the_times_of_the_machine_and_the_command(self):
        seen = []

        class Sees(Scene):
            def check_transition(self, tick):
                seen.append((round(tick.now_s, 3), round(tick.step_s, 3), round(tick.elapsed_s, 3), tick.command,
                             tick.target))

        machine = self.machine(Sees("A", "A"))
        self.tick(machine)
        machine.send("skip")
        self.tick(machine, step_s=0.5)
        machine.pause()
        self.tick(machine, step_s=60)
        self.assertEqual(seen, [(0.1, 0.1, 0.1, None, None), (0.6, 0.5, 0.6, "skip", None), (0.6, 0, 0.6, None, None)])
        self.assertEqual(machine.counts["unhandled"], 1)

    def test_a_gradual_transition_has_its_progress_and_ends_after_its_time(self):
        progress = []

        class Slow(Scene):
            def check_transition(self, tick):
                return fsm.Next.to("B", gradually_s=0.2)

            def transition(self, tick):
                progress.append((tick.target, round(tick.progress, 3)))
                return super().transition(tick)

        machine = self.machine(Slow("A", "B"), Scene("B", "A"))
        self.tick(machine, 2)
        self.assertEqual((machine.path, machine.mode), ("A", "TRANSITIONING"))
        self.tick(machine)
        self.assertEqual((machine.path, machine.mode), ("B", "NORMAL"))
        self.assertEqual(progress, [("B", 0.0), ("B", 0.5), ("B", 1.0)])

    def test_a_command_is_handled_kept_or_reported_as_unhandled(self):
        class Keeps(Scene):
            next_answer = fsm.Next.stay().keep_command()

            def check_transition(self, tick):
                return self.next_answer if tick.command else None

        state = Keeps("A", "A")
        machine = self.machine(state)
        machine.send("skip")
        self.tick(machine, 3)
        self.assertEqual(machine.waiting_commands, 1)
        state.next_answer = fsm.Next.handle()
        self.tick(machine)
        self.assertEqual((machine.waiting_commands, machine.counts["unhandled"]), (0, 0))

    def test_an_urgent_command_drops_the_others_and_a_full_queue_refuses(self):
        machine = fsm.Machine(commands=2)
        machine.add_event("go")
        machine.add_event("stop", urgent=True)
        machine.add("A", Scene("A", "A", 9))
        machine.build("A")
        machine.start(0)
        machine.send("go")
        machine.send("go")
        with self.assertRaisesRegex(musher.Failure, "the queue is full"):
            machine.send("go")
        machine.send("stop")
        self.assertEqual([machine.is_urgent(name) for name in ("stop", "go", "none")], [True, False, False])
        self.assertEqual(machine.waiting_commands, 1)
        with self.assertRaisesRegex(musher.Failure, "did you mean 'stop'"):
            machine.send("stopp")

    def test_what_a_state_raises_leads_to_the_safe_state_with_its_type_text_and_line(self):
        safe = Scene("STOP", "A", 0.15)
        machine = self.machine(Scene("A", "STOP", 9, raises=("run",)), safe, safe=safe)
        self.tick(machine)
        self.assertEqual((machine.path, machine.mode), ("STOP", "SAFE_STOP"))
        self.assertRegex(machine.fault, r"^A: Run: ValueError: no run \(fsm_test\.py:\d+\)$")
        self.tick(machine, 2)
        self.assertEqual(machine.path, "A")

    def test_a_failure_of_the_safe_state_stops_the_machine(self):
        safe = Scene("STOP", "A", raises=("on_enter",))
        machine = self.machine(Scene("A", "STOP", 9, raises=("on_enter",)), safe, safe=safe, begin=False)
        with self.assertRaisesRegex(musher.Failure, "STOP: OnEnter: ValueError: no on_enter"):
            machine.start(0)
        self.assertFalse(machine.running)

    def test_a_safety_check_that_fails_or_raises_leads_to_the_safe_state(self):
        for check, cause in (((lambda tick: False), "unsafe"), ((lambda tick: 1 / 0), "fault"),
                             ((lambda tick: "yes"), "fault")):
            machine = fsm.Machine()
            machine.add("A", Scene("A", "STOP", 9))
            machine.add("STOP", Scene("STOP", "A", 0), fsm.Role.SAFE)
            machine.add_safety_check("too close", check)
            machine.build("A")
            machine.start(0)
            machine.run_once(0.1)
            machine.run_once(0.2)
            self.assertEqual((machine.path, machine.unsafe, machine.history[-1].cause), ("STOP", "too close", cause))

    def test_nonsense_that_a_state_returns_is_a_fault_with_a_sentence(self):
        class Wrong(Scene):
            def check_transition(self, tick):
                return self.answer

            def transition(self, tick):
                return None

            def run(self, tick):
                return 5

        for answer, text in (("B", "check_transition returned 'B'; it returns a musher.fsm.Next, or nothing"),
                             (fsm.Next.to("C"), "it went to C, which is no state"),
                             (fsm.Next.to("A"), "it went to A, which it has not declared"),
                             (fsm.Next.to("B", gradually_s=1), "transition returned None; it returns whether"),
                             (None, "run returned 5; it returns nothing")):
            state = Wrong("A", "B")
            state.answer = answer
            machine = self.machine(state, Scene("B", "A"))
            self.tick(machine)
            self.assertIn(text, machine.fault)

    def test_an_exception_that_ends_the_program_ends_it(self):
        class Interrupted(Scene):
            def run(self, tick):
                raise KeyboardInterrupt

        machine = self.machine(Interrupted("A", "A", 9))
        with self.assertRaises(KeyboardInterrupt):
            self.tick(machine)
        self.assertFalse(machine.running)

    def test_build_reports_all_errors(self):
        machine = fsm.Machine("show")
        machine.add("A", Scene("A", "B"))
        machine.add("END", Scene("END", "A"), fsm.Role.FINAL)
        machine.add_safety_check("too close", lambda tick: True)
        with self.assertRaises(musher.Failure) as raised:
            machine.build("AA")
        self.assertEqual(raised.exception.reason.splitlines(),
                         ["show: A: there is no state B; did you mean 'A'?",
                          "show: the start state: there is no state AA; did you mean 'A'?",
                          "show: the safety check too close has no safe state to go to"])
        self.assertFalse(machine.built)

    def test_a_build_that_failed_can_be_repeated_once_the_missing_state_is_added(self):
        scenes = fsm.Machine("scenes")
        scenes.add("FIRST", Scene("FIRST", "END"))
        scenes.add("END", fsm.State(), fsm.Role.FINAL)
        machine = fsm.Machine("show")
        machine.add("SHOW", fsm.Nested(scenes, "FIRST", finished="A"))
        machine.add("A", Scene("A", "B"))
        with self.assertRaisesRegex(musher.Failure, "there is no state B"):
            machine.build("A")
        machine.add("B", Scene("B", "SHOW"))
        machine.build("A")
        machine.start(self.now_s)
        self.tick(machine, 11)
        self.assertEqual(machine.state, "B")

    def test_a_listener_gets_changes_faults_and_unhandled_commands_and_cannot_disturb(self):
        received = []

        class Records(fsm.Listener):
            def on_change(self, change):
                received.append(repr(change))
                raise ValueError("a listener")

            def on_unhandled(self, command, state):
                received.append((command, state))

            def on_fault(self, fault):
                received.append(fault.partition(" (")[0])

        safe = Scene("STOP", "A", 9)
        machine = self.machine(Scene("A", "STOP", 9, raises=("run",)), safe, safe=safe, begin=False)
        machine.listen(Records())
        machine.start(0)
        machine.run_once(0.1)
        machine.send("skip")
        machine.run_once(0.2)
        self.assertEqual(received, ["Change(0.000000 s:  -> A, started)", "A: Run: ValueError: no run",
                                    "Change(0.100000 s: A -> STOP, fault)",
                                    "Change(0.200000 s: STOP -> A, decided by skip)"])
        self.assertEqual(machine.counts["listener_faults"], 3)

    def test_a_picture_marks_the_present_state(self):
        machine = self.machine(Scene("A", "B"), Scene("B", "A"))
        self.assertIn("digraph", machine.picture())
        self.assertIn("stateDiagram", machine.picture("mermaid"))
        with self.assertRaisesRegex(ValueError, '"dot" or "mermaid", not "svg"'):
            machine.picture("svg")
        before = machine.picture()
        machine.force("B")
        self.assertNotEqual(machine.picture(), before)

    def test_calls_at_the_wrong_time_have_a_sentence(self):
        kept = []

        class Keeps(Scene):
            def declare(self, transitions):
                super().declare(transitions)
                kept.append(transitions)

        unbuilt = fsm.Machine("show")
        machine = self.machine(Keeps("A", "A", 9))
        for call, text in ((lambda: unbuilt.start(0), "build\\(\\) comes first"),
                           (lambda: unbuilt.run_once(0), "build\\(\\) comes first"),
                           (lambda: machine.add("B", Scene("B", "A")), "is built already"),
                           (lambda: machine.build("A"), "is built already"),
                           (lambda: machine.start(0), "runs already"),
                           (lambda: machine.force("B"), "there is no state B"),
                           (lambda: kept[0].to("A", "x"), "in declare\\(\\) only"),
                           (lambda: machine.add("B", Scene), "an object of a class derived from"),
                           (lambda: machine.add_safety_check("x", 5), "is a function, not 5"),
                           (lambda: machine.listen(print), "an object of a class derived from"),
                           (lambda: fsm.Next.to(""), "the name of a state"),
                           (lambda: fsm.Next.to("A", gradually_s=-1), "0 or more")):
            with self.assertRaisesRegex((musher.Failure, TypeError, ValueError), text):
                call()

    def test_a_machine_whose_state_refers_to_it_is_collected(self):
        scene = Scene("A", "A")
        scene.machine = self.machine(scene)
        gone = weakref.ref(scene)
        del scene
        gc.collect()
        self.assertIsNone(gone())


@dataclasses.dataclass(frozen=True)
class Photo:
    count: int = 1
    zoom: float = 1.0
    flash: bool = False
    of: str = ""


class Cook(fsm.State):
    """Goes on at 100 degrees, or by the command "photo" of more than two."""

    def __init__(self, pot, next):
        self.pot, self.next = pot, next

    def declare(self, transitions):
        transitions.to(self.next, "hot")

    def check_transition(self, tick):
        if self.pot["degrees"] >= 100 or (tick.command == "photo" and tick.data.count > 2):
            return fsm.Next.to(self.next)


class Recordings(WithMachine):
    """A run that is recorded, and repeated without its robot."""

    def kitchen(self, name="kitchen"):
        pot = {"degrees": 20}
        machine = fsm.Machine(name)
        machine.add_event("photo", data=Photo)
        machine.add("COLD", Cook(pot, "HOT"))
        machine.add("HOT", Cook(pot, "COLD"))
        machine.build("COLD")
        return machine, pot

    def recorded(self):
        machine, pot = self.kitchen()
        lines = []
        machine.record(lines.append)
        machine.start(self.now_s)
        self.tick(machine)
        machine.send("photo", Photo(count=3, of="a \"pot\""))
        self.tick(machine)
        pot["degrees"] = 120
        machine.record_input("degrees", "120")
        self.tick(machine, 2)
        return machine, "".join(lines)

    @staticmethod
    def into(pot):
        return lambda name, text: pot.update({name: int(text)})

    def test_a_recording_gives_the_same_changes_again(self):
        recorded, text = self.recorded()
        machine, pot = self.kitchen()
        self.assertEqual(machine.replay(text, self.into(pot)), fsm.Replayed(ticks=4, changes=4, difference=None))
        self.assertEqual(machine.path, recorded.path)
        self.assertEqual([c.to_state for c in machine.history], ["COLD", "HOT", "COLD", "HOT"])

    def test_the_first_change_that_differs_is_named_with_its_line(self):
        _, text = self.recorded()
        machine, _ = self.kitchen()
        difference = machine.replay(text, lambda name, text: None, file="monday.record").difference
        self.assertRegex(difference, r"^monday\.record:\d+: ")

    def test_what_does_not_fit_is_refused_with_a_sentence(self):
        _, text = self.recorded()
        with self.assertRaisesRegex(ValueError, "the recording has the input degrees, and nothing applies it"):
            self.kitchen()[0].replay(text)
        with self.assertRaisesRegex(musher.Failure, "recording:1"):
            self.kitchen("garage")[0].replay(text)
        with self.assertRaisesRegex(musher.Failure, "monday:2"):
            self.kitchen()[0].replay(text.split("\n")[0] + "\nfly\n", file="monday")
        with self.assertRaisesRegex(TypeError, "is a function, not 'a file'"):
            self.kitchen()[0].record("a file")
        machine, _ = self.kitchen()
        with self.assertRaisesRegex(musher.Failure, "record\\(\\) comes first"):
            machine.record_input("degrees", "1")
        machine.record(lambda line: None)
        with self.assertRaisesRegex(musher.Failure, "is recorded already"):
            machine.record(lambda line: None)
        machine.start(0)
        with self.assertRaisesRegex(musher.Failure, "runs already: a replay starts it"):
            machine.replay(text)
        late, _ = self.kitchen()
        late.start(0)
        with self.assertRaisesRegex(musher.Failure, "a recording begins with its start"):
            late.record(lambda line: None)

    def test_what_writes_cannot_disturb(self):
        def full(line):
            if line.startswith("tick"):
                raise OSError("the disk is full")

        machine, _ = self.kitchen()
        machine.record(full)
        machine.start(self.now_s)
        self.tick(machine, 3)
        self.assertEqual((machine.path, machine.counts["listener_faults"]), ("COLD", 3))

    def test_a_machine_that_writes_into_what_has_it_is_collected(self):
        class Owner:
            pass

        owner = Owner()
        owner.machine, _ = self.kitchen()
        owner.machine.record(lambda line: owner)
        gone = weakref.ref(owner)
        del owner
        gc.collect()
        self.assertIsNone(gone())


class Gesture(enum.IntEnum):
    NONE = 0
    HEART = 1


class Tracking(Scene):
    """Saves a field of each kind; raises what `fails` has instead."""

    def __init__(self, name, next, time_s=1.0):
        super().__init__(name, next, time_s)
        self.greeted, self.guests, self.share, self.last = False, 0, 0.0, ""
        self.lost_for_s, self.gesture, self.fails = 0.0, Gesture.NONE, None

    # [persist]
    def persist(self, archive):
        self.greeted = archive.field("greeted", self.greeted)
        self.guests = archive.field("guests", self.guests)
        self.share = archive.field("share", self.share)
        self.last = archive.field("last", self.last)
        self.lost_for_s = archive.duration_s("lost_for", self.lost_for_s)
        self.gesture = archive.field("gesture", self.gesture)
        # [persist end]
        if self.fails:
            raise self.fails

    def fields(self):
        return self.greeted, self.guests, self.share, self.last, self.lost_for_s, self.gesture


# As C++ writes it: test/behavior/fsm/snapshot_toml_test.cpp has such a text of a machine there.
SAVED = """# A state machine between two ticks. Times are nanoseconds of machine time.
machine = "show"
running = true
paused = false
mode = "NORMAL"
state = "TRACKING"
ticks = 2
time_ns = 200000000
step_ns = 100000000
elapsed_ns = 100000000
unsafe = ""
commands = ["photo"]
history = [
  { tick = 0, at_ns = 0, from = "", to = "IDLE", cause = "started" },
  { tick = 1, at_ns = 100000000, from = "IDLE", to = "TRACKING", cause = "decided", command = "skip" },
]

[counts]
changes = 2
unhandled = 0
superseded = 0
refused = 0
faults = 0
listener_faults = 0

[command_data.0]
count = 3
zoom = 1.0
flash = false
of = "a \\"pot\\""

[data.robot]
ready = true

[states.TRACKING]
greeted = true
guests = -7
share = 0.25
last = "Ada"
lost_for = 290000000
gesture = 1
"""


class Snapshots(WithMachine):
    """A machine that continues in another process."""

    FIELDS = (True, -7, 0.25, "Ada", 0.29, Gesture.HEART)

    def show(self, name="show"):
        robot = {"ready": False}

        def persist(archive):
            robot["ready"] = archive.field("ready", robot["ready"])

        machine = fsm.Machine(name, commands=2)
        tracking = Tracking("TRACKING", "IDLE")
        machine.add_event("skip")
        machine.add_event("photo", data=Photo)
        machine.add("IDLE", Scene("IDLE", "TRACKING"))
        machine.add("TRACKING", tracking)
        machine.add_data("robot", persist)
        machine.build("IDLE")
        return machine, tracking, robot

    def ran(self):
        machine, tracking, robot = self.show()
        machine.start(self.now_s)
        machine.send("skip")
        self.tick(machine, 2)
        machine.send("photo", Photo(count=3, of="a \"pot\""))
        (tracking.greeted, tracking.guests, tracking.share, tracking.last, tracking.lost_for_s,
         tracking.gesture) = self.FIELDS
        robot["ready"] = True
        return machine, tracking, robot

    def test_a_saved_machine_is_the_text_that_a_machine_of_cpp_reads(self):
        self.assertEqual(self.ran()[0].save(), SAVED)

    def test_another_machine_continues_where_it_was_saved_without_entering_a_state(self):
        machine, tracking, robot = self.show()
        machine.restore(SAVED, 7200.0)
        self.assertEqual(LOG, [])
        self.assertEqual((machine.path, machine.ticks, machine.waiting_commands, len(machine.history)),
                         ("TRACKING", 2, 1, 2))
        self.assertEqual(tracking.fields(), self.FIELDS)
        self.assertIs(type(tracking.gesture), Gesture)
        self.assertTrue(robot["ready"])
        self.assertEqual(machine.save(), SAVED)
        machine.run_once(7200.5)  # the command is not handled there: the state stays
        self.assertAlmostEqual(machine.elapsed_s, 0.6)
        machine.run_once(7201.0)
        self.assertEqual(LOG, ["TRACKING run", "TRACKING on_exit", "IDLE on_enter"])

    def test_a_gradual_transition_continues(self):
        class Slow(Scene):
            def check_transition(self, tick):
                return fsm.Next.to(self.next, gradually_s=0.4)

        def slow():
            return self.machine(Slow("A", "B"), Scene("B", "A"), begin=False)

        first = slow()
        first.start(self.now_s)
        self.tick(first, 3)
        other = slow()
        other.restore(first.save(), self.now_s)
        self.assertEqual((other.mode, other.path), ("TRANSITIONING", "A"))
        self.tick(other, 2)
        self.assertEqual((other.mode, other.path), ("NORMAL", "B"))

    def test_the_data_of_a_waiting_command_is_restored_with_it(self):
        seen = []

        class Sees(Scene):
            def declare(self, transitions):
                super().declare(transitions)
                transitions.on("photo")

            def check_transition(self, tick):
                if tick.command:
                    seen.append(tick.data)
                    return fsm.Next.handle()

        def camera():
            machine = fsm.Machine("camera")
            machine.add_event("photo", data=Photo)
            machine.add("A", Sees("A", "B"))
            machine.add("B", Scene("B", "A"))
            machine.build("A")
            return machine

        first = camera()
        first.start(self.now_s)
        first.send("photo", Photo(count=4))
        other = camera()
        other.restore(first.save(), self.now_s)
        self.tick(other)
        self.assertEqual(seen, [Photo(count=4)])

    def test_machines_inside_and_where_they_were_left_are_restored(self):
        def outer():
            inner = fsm.Machine("scenes")
            inner.add("FIRST", Scene("FIRST", "LAST", 0.05))
            last = Tracking("LAST", "FIRST", 9)
            inner.add("LAST", last)
            machine = fsm.Machine("show")
            machine.add_event("skip")
            machine.add("SHOW", Holds(inner, "FIRST", resumes=True))
            machine.add("IDLE", Scene("IDLE", "SHOW", 9))
            machine.build("SHOW")
            return machine, last

        class Holds(fsm.Nested):
            shown = 0

            def declare(self, transitions):
                transitions.to("IDLE", "skip")
                transitions.on("skip")

            def decide(self, tick):
                return fsm.Next.to("IDLE") if tick.command == "skip" else None

            def on_enter(self, tick):
                self.shown += 1

            def persist(self, archive):
                self.shown = archive.field("shown", self.shown)

        first, last = outer()
        first.start(self.now_s)
        self.tick(first, 2)
        last.guests = 5
        other, other_last = outer()
        other.restore(first.save(), self.now_s)
        self.assertEqual((other.path, other_last.guests), ("SHOW/LAST", 5))
        first.send("skip")
        self.tick(first)
        saved = first.save()
        self.assertIn('left_in = "LAST"', saved)
        third, _ = outer()
        third.restore(saved, self.now_s)
        third.send("skip")
        self.tick(third)
        self.assertEqual(third.path, "SHOW/LAST")
        self.assertIn("shown = 2", third.save())

    def test_all_that_does_not_fit_is_named_with_its_line_and_nothing_has_changed(self):
        machine, tracking, robot = self.show()
        wrong = SAVED.replace('"photo"]', '"foto"]').replace('state = "TRACKING"', 'state = "TRACKNG"')
        with self.assertRaises(musher.Failure) as caught:
            machine.restore(wrong, 0, file="show.toml")
        self.assertRegex(caught.exception.reason, r"show\.toml:6:\d+: error: state: there is no state TRACKNG; did you "
                                                  "mean 'TRACKING'\\?")
        self.assertIn("there is no event foto", caught.exception.reason)
        with self.assertRaisesRegex(musher.Failure,
                                    "saved:37:\\d+: error: states.TRACKING.guests: has to be an integer, not a text"):
            machine.restore(SAVED.replace("guests = -7", 'guests = "Ada"'), 0)
        with self.assertRaisesRegex(musher.Failure, "states.TRACKING: Persist: ValueError: 7 is not a valid Gesture"):
            machine.restore(SAVED.replace("gesture = 1", "gesture = 7"), 0)
        with self.assertRaisesRegex(musher.Failure, "machine: it was saved from show, not from garage"):
            self.show("garage")[0].restore(SAVED, 0)
        with self.assertRaisesRegex(musher.Failure, "saved:1:"):
            machine.restore("no machine", 0)
        self.assertEqual(tracking.fields(), (False, 0, 0.0, "", 0.0, Gesture.NONE))
        self.assertEqual((robot["ready"], machine.running), (False, False))
        machine.restore(SAVED, 0)
        with self.assertRaisesRegex(musher.Failure, "running: show runs already"):
            machine.restore(SAVED, 0)

    def test_what_cannot_be_saved_has_a_sentence(self):
        machine, tracking, _ = self.ran()
        tracking.fails = OSError("no disk")
        with self.assertRaisesRegex(musher.Failure, "show: TRACKING: Persist: OSError: no disk \\(fsm_test.py:"):
            machine.save()
        tracking.fails = None
        for value, sentence in ((["Ada"], "last: a saved field is a bool, an int, a float or a str, not "),
                                (2 ** 64, "last: it is not an int of 64 bits"),
                                ("\0", "cannot be saved: it is not UTF-8, or has a NUL")):
            tracking.last = value
            with self.subTest(value=value), self.assertRaisesRegex(musher.Failure, sentence):
                machine.save()
        tracking.last = ""
        tracking.lost_for_s = float("nan")
        with self.assertRaisesRegex(musher.Failure, "lost_for: a saved time is at most 1e9 seconds, not nan"):
            machine.save()

    def test_it_is_saved_between_ticks_and_its_fields_in_persist(self):
        kept = []

        class Saves(Scene):
            def run(self, tick):
                machine.save()

            def persist(self, archive):
                kept.append(archive)
                return 5

        machine = self.machine(Saves("A", "B"), Scene("B", "A"))
        with self.assertRaisesRegex(musher.Failure, "A: Persist: persist returned 5; it returns nothing"):
            machine.save()
        with self.assertRaisesRegex(musher.Failure, "saved and restored in persist\\(\\) only"):
            kept[0].field("a", 1)
        self.tick(machine)
        self.assertIn("can be saved once it is built, and between ticks", machine.fault)
        with self.assertRaisesRegex(musher.Failure, "build\\(\\) comes first"):
            fsm.Machine().save()
        with self.assertRaisesRegex(TypeError, "is saved by a function, not by 5"):
            fsm.Machine().add_data("robot", 5)

    def test_a_machine_whose_data_refers_to_it_is_collected(self):
        class Owner:
            def persist(self, archive):
                pass

        owner = Owner()
        owner.machine = fsm.Machine("show")
        owner.machine.add_data("robot", owner.persist)
        gone = weakref.ref(owner)
        del owner
        gc.collect()
        self.assertIsNone(gone())


class Commands(WithMachine):
    """Commands that carry data, wait for another state, or come several to a tick."""

    def asked(self, *commands, data=Photo, **options):
        """What a state gets as tick.command and tick.data."""
        got = []

        class Takes(fsm.State):
            def check_transition(self, tick):
                if tick.command:
                    got.append((tick.command, tick.data))
                    return fsm.Next.handle()

        machine = fsm.Machine("show", **options)
        machine.add_event("photo", data=data)
        machine.add_event("go")
        machine.add("A", Takes())
        machine.build("A")
        machine.start(self.now_s)
        for command in commands:
            machine.send(*command)
        self.tick(machine)
        return got

    def test_a_state_gets_the_data_of_its_command(self):
        self.assertEqual(self.asked(("photo", Photo(3, of="Ann"))), [("photo", Photo(3, 1.0, False, "Ann"))])
        self.assertEqual(self.asked(("go",)), [("go", None)])

    def test_data_that_does_not_fit_is_refused_with_a_sentence(self):
        for command, expected in ((("photo", 3), "the command carries a Photo, not 3"),
                                  (("photo", Photo(count="3")), "Photo.count is a int, not '3'"),
                                  (("go", Photo()), "the command go carries no data")):
            with self.assertRaisesRegex(TypeError, expected):
                self.asked(command)
        with self.assertRaisesRegex(musher.Failure, "carries data, which is missing"):
            self.asked(("photo",))
        with self.assertRaisesRegex(TypeError, "the data of an event is a dataclass"):
            self.asked(data=int)

    def test_a_tick_handles_as_many_commands_as_it_may(self):
        self.assertEqual(len(self.asked(("go",), ("go",), ("go",))), 1)
        self.assertEqual(len(self.asked(("go",), ("go",), ("go",), commands_per_tick=2)), 2)

    def test_a_deferred_command_waits_for_a_state_that_handles_it(self):
        got = []

        class Busy(Scene):
            def declare(self, transitions):
                super().declare(transitions)
                transitions.defer("photo")

        class Ready(Scene):
            def check_transition(self, tick):
                got.append(tick.command)

            def declare(self, transitions):
                super().declare(transitions)
                transitions.on("photo")

        machine = fsm.Machine("show")
        machine.add_event("photo")
        machine.add_event("skip")
        machine.add("BUSY", Busy("BUSY", "READY", 9))
        machine.add("READY", Ready("READY", "BUSY"))
        machine.build("BUSY")
        machine.start(self.now_s)
        machine.send("photo")
        machine.send("skip")
        self.tick(machine, 2)
        self.assertEqual((machine.path, got), ("READY", ["photo"]))

    def test_a_stay_that_keeps_a_command_is_reported_once(self):
        kept = []

        class Keeps(Scene):
            def check_transition(self, tick):
                return fsm.Next.stay().keep_command()

        class Records(fsm.Listener):
            def on_kept(self, command, state):
                kept.append((command, state))

        machine = self.machine(Keeps("A", "A"))
        machine.listen(Records())
        machine.send("skip")
        self.tick(machine, 3)
        self.assertEqual(kept, [("skip", "A")])

    def test_run_once_in_a_state_is_an_error(self):
        class Mistaken(Scene):
            def run_once(self, tick):
                pass

        with self.assertRaisesRegex(TypeError, "has a run_once.., which no machine calls; a state has run"):
            fsm.Machine().add("A", Mistaken("A", "A"))

        class Ticks(Scene):
            def run(self, tick):
                self.machine.run_once(0)

        state = Ticks("A", "A")
        state.machine = machine = self.machine(state)
        self.tick(machine)
        self.assertIn("inside of its own tick", machine.fault)


class Hierarchies(WithMachine):
    """Transitions from and into machines inside, and machines side by side."""

    def show(self):
        class Idle(fsm.State):
            target = {}

            def declare(self, transitions):
                transitions.to("SHOW/TELL", "straight")
                transitions.to("SHOW", "on", into=fsm.Into.HISTORY)

            def check_transition(self, tick):
                target, self.target = self.target, {}
                return fsm.Next.to(**target) if target else None

        self.idle = Idle()
        inside = fsm.Machine("inside")
        inside.add("ASK", Scene("ASK", "TELL", 9))
        inside.add("TELL", Scene("TELL", "IDLE", 0.25))
        machine = fsm.Machine("show")
        machine.add("IDLE", self.idle)
        machine.add("SHOW", fsm.Nested(inside, "ASK"))
        machine.build("IDLE")
        machine.start(self.now_s)
        return machine

    def test_a_state_goes_to_any_state_of_the_hierarchy(self):
        machine = self.show()
        self.idle.target = {"state": "SHOW/TELL"}
        self.tick(machine)
        self.assertEqual(machine.path, "SHOW/TELL")
        self.tick(machine, 3)
        self.assertEqual(machine.path, "IDLE")
        self.assertEqual(LOG[-1], "TELL on_exit")

    def test_history_enters_the_state_that_was_left(self):
        machine = self.show()
        self.idle.target = {"state": "SHOW/TELL"}
        self.tick(machine, 4)
        self.idle.target = {"state": "SHOW", "into": fsm.Into.HISTORY}
        self.tick(machine)
        self.assertEqual(machine.path, "SHOW/TELL")

    def test_machines_run_side_by_side(self):
        arms, face = fsm.Machine("arms"), fsm.Machine("face")
        arms.add("WAVE", Scene("WAVE", "DOWN", 0.15))
        arms.add("DOWN", Scene("DOWN", "WAVE", 9))
        face.add("SMILE", Scene("SMILE", "SMILE", 9))
        machine = fsm.Machine("show")
        machine.add("SHOW", fsm.Nested([(arms, "WAVE"), (face, "SMILE")]))
        machine.build("SHOW")
        machine.start(self.now_s)
        self.assertEqual(machine.path, "SHOW/(WAVE|SMILE)")
        self.tick(machine, 2)
        self.assertEqual(machine.path, "SHOW/(DOWN|SMILE)")
        self.assertIn("SMILE", machine.picture("mermaid"))

    def test_the_inner_state_decides_first_as_an_option(self):
        class Outer(fsm.Nested):
            def declare(self, transitions):
                transitions.to("IDLE", "skipped")

            def decide(self, tick):
                return fsm.Next.to("IDLE") if tick.command == "skip" else None

        for inner_first, path in ((False, "IDLE"), (True, "SHOW/TELL")):
            inside = fsm.Machine("inside")
            inside.add_event("skip")
            inside.add("ASK", Scene("ASK", "TELL", 9))
            inside.add("TELL", Scene("TELL", "ASK", 9))
            machine = fsm.Machine("show")
            machine.add_event("skip")
            machine.add("SHOW", Outer(inside, "ASK", inner_first=inner_first))
            machine.add("IDLE", Scene("IDLE", "SHOW", 9))
            machine.build("SHOW")
            machine.start(self.now_s)
            machine.send("skip")
            self.tick(machine)
            self.assertEqual(machine.path, path)


class NestedMachines(WithMachine):
    def show(self, resumes=False, nested=fsm.Nested, **inner):
        scenes = fsm.Machine("scenes")
        scenes.add_event("skip")
        scenes.add("FIRST", Scene("FIRST", "LAST", **inner))
        scenes.add("LAST", Scene("LAST", "END"))
        scenes.add("END", fsm.State(), fsm.Role.FINAL)
        machine = fsm.Machine("show")
        machine.add_event("skip")
        machine.add("SHOW", nested(scenes, "FIRST", finished="IDLE", resumes=resumes))
        machine.add("IDLE", Scene("IDLE", "SHOW"))
        machine.build("SHOW")
        machine.start(self.now_s)
        return machine, scenes

    def test_the_inner_machine_is_ticked_gets_commands_and_finishes(self):
        machine, scenes = self.show()
        self.assertEqual(machine.path, "SHOW/FIRST")
        machine.send("skip")
        self.tick(machine)
        self.assertEqual((machine.path, scenes.path), ("SHOW/LAST", "LAST"))
        machine.send("skip")
        self.tick(machine, 2)
        self.assertEqual(machine.path, "IDLE")
        self.assertFalse(scenes.running)

    def test_it_resumes_where_it_was_left(self):
        machine, scenes = self.show(resumes=True)
        machine.send("skip")
        self.tick(machine)
        machine.force("IDLE")
        machine.force("SHOW")
        self.assertEqual(machine.path, "SHOW/LAST")

    def test_a_fault_inside_has_the_whole_path(self):
        machine, scenes = self.show(raises=("run",))
        self.tick(machine)
        self.assertRegex(machine.fault, "^SHOW/FIRST: Run: ValueError: no run")

    def test_the_outer_state_decides_first_and_its_functions_surround_those_inside(self):
        class Outer(fsm.Nested):
            def on_enter(self, tick):
                LOG.append("SHOW on_enter")

            def run(self, tick):
                LOG.append("SHOW run")

            def decide(self, tick):
                return fsm.Next.to("IDLE") if tick.command == "skip" else None

            def on_exit(self, tick):
                LOG.append("SHOW on_exit")

        machine, scenes = self.show(nested=Outer)
        self.tick(machine)
        machine.send("skip")
        self.tick(machine)
        self.assertEqual(LOG, ["SHOW on_enter", "FIRST on_enter", "SHOW run", "FIRST run", "FIRST on_exit",
                               "SHOW on_exit", "IDLE on_enter"])

    def test_the_inner_machine_belongs_to_its_state(self):
        machine, scenes = self.show()
        with self.assertRaisesRegex(musher.Failure, "scenes is inside a state"):
            scenes.force("LAST")
        with self.assertRaisesRegex(musher.Failure, "scenes is inside a state"):
            fsm.Machine().add("AGAIN", fsm.Nested(scenes, "FIRST"))
        del machine
        gc.collect()
        with self.assertRaisesRegex(musher.Failure, "the machine around this one has ended"):
            scenes.path

    def test_a_nested_state_overrides_decide_only(self):
        class Wrong(fsm.Nested):
            def check_transition(self, tick):
                return None

        with self.assertRaisesRegex(TypeError, "override decide\\(\\)"):
            self.show(nested=Wrong)
        with self.assertRaisesRegex(TypeError, "a state holds a musher.fsm.Machine"):
            fsm.Nested(5, "A")


if __name__ == "__main__":
    unittest.main()
