#include "musher/behavior/fsm/replay.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "musher/behavior/fsm/recorder.hpp"
#include "musher/behavior/fsm/snapshot.hpp"
#include "musher/test/behavior/fsm/machine_fixture.hpp"
#include "musher/test/behavior/fsm/random_states.hpp"

namespace musher::fsm::replay_test {

using ::testing::HasSubstr;

Recording Read(const std::string& text) {
  const Result<Recording> read = ReadRecording(text, "show.record");
  EXPECT_TRUE(read) << read.error().message;
  return read ? read.value() : Recording{};
}

std::string FaultOf(const std::string& text) {
  const Result<Recording> read = ReadRecording(text, "show.record");
  return read ? "none" : read.error().message;
}

// Goes from IDLE to TRACKING when a target is near, and back on command.
class Show {
 public:
  Show() {
    machine.AddEvent("stop now", Urgency::kUrgent);
    auto idle = std::make_unique<LoggingState>("IDLE", log, std::vector<std::string>{"TRACKING"});
    idle->check = [this](const Tick&) {
      return near ? Next::To(*machine.FindState("TRACKING")) : Next::Stay();
    };
    auto tracking =
        std::make_unique<LoggingState>("TRACKING", log, std::vector<std::string>{"IDLE"});
    tracking->check = [this](const Tick& tick) {
      return tick.command != kNoEvent ? Next::To(*machine.FindState("IDLE")) : Next::Stay();
    };
    machine.Add("IDLE", std::move(idle));
    machine.Add("TRACKING", std::move(tracking));
    EXPECT_TRUE(machine.Build("IDLE"));
  }

  Result<> Apply(std::string_view name, std::string_view text) {
    if (name != "target") return Error{kCodeFailed, "unknown input " + std::string(name)};
    near = text == "near";
    return Ok();
  }
  Result<Replayed> Again(const Recording& recording) {
    return Replay(recording, machine, [this](std::string_view name, std::string_view text) {
      return Apply(name, text);
    });
  }

  Log log;
  bool near = false;
  Machine machine{{.name = "show"}};
};

std::string RecordedShow() {
  Show show;
  std::string text;
  Recorder recorder(show.machine, [&](std::string_view line) { text += line; });
  const Time start = Time(std::chrono::hours(9));
  EXPECT_TRUE(show.machine.Start(start));
  show.machine.RunOnce(start + Milliseconds(20));
  recorder.Input("target", "near");
  EXPECT_TRUE(show.Apply("target", "near"));
  show.machine.RunOnce(start + Milliseconds(40));
  recorder.Input("target", "a \"long\"\nway\x01 off");
  EXPECT_TRUE(show.Apply("target", "far"));
  EXPECT_TRUE(show.machine.Send("stop now"));
  show.machine.Pause();
  show.machine.RunOnce(start - Milliseconds(1500));
  EXPECT_TRUE(show.machine.Force("TRACKING"));
  EXPECT_TRUE(show.machine.Reset());
  EXPECT_TRUE(show.machine.Stop());
  return text;
}

constexpr const char* kRecorded =
    "musher-fsm-recording 2 show\n"
    "start 0 IDLE\n"
    "changed 0 0 \"\" IDLE started\n"
    "tick 0.02\n"
    "input target near\n"
    "tick 0.04\n"
    "changed 2 0.04 IDLE TRACKING decided\n"
    "input target \"a \\\"long\\\"\\nway\\x01 off\"\n"
    "command \"stop now\"\n"
    "pause\n"
    "tick -1.5\n"
    "changed 3 0.04 TRACKING IDLE decided \"stop now\"\n"
    "force TRACKING\n"
    "changed 3 0.04 IDLE TRACKING forced\n"
    "reset\n"
    "changed 3 0.04 TRACKING IDLE reset\n"
    "stop\n"
    "changed 3 0.04 IDLE \"\" stopped\n";

TEST(Recorder, WritesALineForEachInputAndForEachChangeThatFollows) {
  EXPECT_EQ(RecordedShow(), kRecorded);
}

TEST(Recorder, DoesNotRecordWhatStatesSendThemselves) {
  Show show;
  std::string text;
  const Recorder recorder(show.machine, [&](std::string_view line) { text += line; });
  ASSERT_TRUE(show.machine.Start(Time{}));
  show.near = true;
  class Sender : public Listener {
    void OnChange(const Machine&, const Change&) override { (void)machine.Send("stop now").ok(); }

   public:
    explicit Sender(Machine& of) : machine(of) {}
    Machine& machine;
  } sender(show.machine);
  show.machine.Listen(&sender);
  show.machine.RunOnce(Time{});
  EXPECT_EQ(show.machine.waiting_commands(), 1U);
  EXPECT_THAT(text, ::testing::Not(HasSubstr("command")));
}

// The first tick used the time of a start that had not happened.
TEST(Recorder, MarksWhereTheMachineWentOnFromASnapshotInsteadOfAStart) {
  Show show;
  ASSERT_TRUE(show.machine.Start(Time{}));
  const Snapshot saved = show.machine.Save().value();
  ASSERT_TRUE(show.machine.Stop());
  std::string text;
  const Recorder recorder(show.machine, [&](std::string_view line) { text += line; });
  const Time now = Time(std::chrono::hours(9));
  ASSERT_TRUE(show.machine.Restore(saved, now).empty());
  show.machine.RunOnce(now + kStep);
  show.machine.RunOnce(now + 2 * kStep);
  EXPECT_EQ(text, "musher-fsm-recording 2 show\nrestored\ntick 0\ntick 0.02\n");
  EXPECT_EQ(FaultOf(text),
            "show.record:2:1: error: from here on the machine was restored from a snapshot, "
            "which is not recorded");

  ASSERT_TRUE(show.machine.Stop());
  text.clear();
  ASSERT_TRUE(show.machine.Restore(saved, now).empty());
  ASSERT_TRUE(show.machine.Send("stop now"));
  EXPECT_EQ(text, "restored\ncommand \"stop now\"\n");
}

TEST(Replay, GivesTheSameHistoryAgain) {
  Show show;
  const Result<Replayed> replayed = show.Again(Read(kRecorded));
  ASSERT_TRUE(replayed) << replayed.error().message;
  EXPECT_EQ(replayed.value().difference.value_or("none"), "none");
  EXPECT_EQ(replayed.value().ticks, 3U);
  EXPECT_EQ(replayed.value().changes, 6U);
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string DifferenceOf(const std::string& text) {
  Show show;
  const Result<Replayed> replayed = show.Again(Read(text));
  return replayed ? replayed.value().difference.value_or("none") : replayed.error().message;
}

TEST(Replay, ReportsTheFirstChangeThatDiffers) {
  EXPECT_EQ(DifferenceOf(Replaced(kRecorded, "target near", "target far")),
            "show.record:7: recorded: 2 0.04 IDLE TRACKING decided; now: nothing");
  EXPECT_EQ(DifferenceOf(Replaced(kRecorded, "changed 2 0.04 IDLE TRACKING decided\n", "")),
            "show.record:6: recorded: nothing; now: 2 0.04 IDLE TRACKING decided");
  EXPECT_EQ(
      DifferenceOf(Replaced(kRecorded, "IDLE reset", "SAFE reset")),
      "show.record:16: recorded: 3 0.04 TRACKING SAFE reset; now: 3 0.04 TRACKING IDLE reset");
}

TEST(Replay, FailsWhereTheMachineLacksARecordedStateOrCommand) {
  EXPECT_EQ(DifferenceOf(Replaced(kRecorded, "stop now", "stop mow")),
            "show.record:9: error: show: there is no event stop mow; did you mean 'stop now'?");
  EXPECT_EQ(DifferenceOf(Replaced(kRecorded, "force TRACKING", "force TRAKCING")),
            "show.record:13: error: show: there is no state TRAKCING; did you mean 'TRACKING'?");
  EXPECT_EQ(DifferenceOf(Replaced(kRecorded, "start 0 IDLE", "start 0 IDEL")),
            "show.record:2: error: show: there is no state IDEL; did you mean 'IDLE'?");
  EXPECT_EQ(DifferenceOf(Replaced(kRecorded, "tick 0.02", "start 0.02 IDLE")),
            "show.record:4: error: show: runs already");
  EXPECT_EQ(DifferenceOf(Replaced(kRecorded, "input target", "input traget")),
            "show.record:5: error: unknown input traget");
  EXPECT_EQ(DifferenceOf(Replaced(kRecorded, "2 show", "2 race")),
            "show.record:1: error: it was recorded from machine race, not from show");
}

TEST(Replay, AcceptsARecordingWhoseWriterCrashed) {
  const std::string whole(kRecorded);
  for (std::size_t size = whole.find('\n') + 1; size < whole.size(); ++size) {
    SCOPED_TRACE(size);
    const Recording recording = Read(whole.substr(0, size));
    EXPECT_EQ(recording.cut_short, whole[size - 1] != '\n');
    Show show;
    const Result<Replayed> replayed = show.Again(recording);
    ASSERT_TRUE(replayed) << replayed.error().message;
    if (recording.cut_short) {
      EXPECT_EQ(replayed.value().difference.value_or("none"), "none");
    }
  }
}

TEST(Recording, ReportsWhereALineIsInvalid) {
  const std::string head = "musher-fsm-recording 1 show\n";
  EXPECT_EQ(FaultOf(""),
            "show.record:1:1: error: a recording begins with \"musher-fsm-recording 2\" "
            "and a machine");
  EXPECT_EQ(FaultOf("musher-fsm-recording 1"), FaultOf(""));
  EXPECT_EQ(FaultOf("musher-fsm-recording 12 show\n"), FaultOf(""));
  EXPECT_EQ(FaultOf(head + "tikc 1\n"),
            "show.record:2:1: error: tikc is not a kind of line; did you mean 'tick'?");
  EXPECT_EQ(FaultOf(head + "tick\n"), "show.record:2:5: error: a word is missing");
  EXPECT_EQ(FaultOf(head + "tick 1s\n"),
            "show.record:2:6: error: invalid time 1s; expected seconds");
  EXPECT_EQ(FaultOf(head + "tick 1.\n"),
            "show.record:2:6: error: invalid time 1.; expected seconds");
  EXPECT_EQ(FaultOf(head + "tick --1\n"),
            "show.record:2:6: error: invalid time --1; expected seconds");
  EXPECT_EQ(FaultOf(head + "tick \"\"\n"),
            "show.record:2:6: error: invalid time \"\"; expected seconds");
  EXPECT_EQ(FaultOf(head + "tick 0.0000000001\n"),
            "show.record:2:6: error: invalid time 0.0000000001; expected seconds");
  EXPECT_EQ(FaultOf(head + "tick 99999999999999\n"),
            "show.record:2:6: error: invalid time 99999999999999; expected seconds");
  EXPECT_EQ(FaultOf(head + "tick 1 2\n"), "show.record:2:8: error: there are too many words");
  EXPECT_EQ(FaultOf(head + "tick  1\n"), "show.record:2:6: error: a word is missing");
  EXPECT_EQ(FaultOf(head + "tick 1 \n"),
            "show.record:2:7: error: words are separated by one space");
  EXPECT_EQ(FaultOf(head + "command \"a\"b\n"),
            "show.record:2:12: error: words are separated by one space");
  EXPECT_EQ(FaultOf(head + "command \"a\n"),
            "show.record:2:9: error: a word has no closing quotation mark");
  EXPECT_EQ(
      FaultOf(head + "command \"\\q\"\n"),
      "show.record:2:10: error: a backslash stands before \", \\, n or x with two hexadecimal "
      "digits");
  EXPECT_EQ(FaultOf(head + "changed 1 \"a\n"),
            "show.record:2:11: error: a word has no closing quotation mark");
  EXPECT_EQ(FaultOf(head + "\ntick 1\n"), "show.record:2:1: error: a word is missing");
}

TEST(Replay, ReadsARecordingOfTheFirstFormat) {
  std::string text = RecordedShow();
  text.replace(text.find(" 2 "), 3, " 1 ");
  const Result<Recording> recording = ReadRecording(text, "show.record");
  ASSERT_TRUE(recording);
  EXPECT_FALSE(recording.value().has_inside);
  EXPECT_EQ(recording.value().machine, "show");
}

RC_GTEST_PROP(Replay, RepeatsAnyRun, (std::uint64_t seed)) {
  const std::vector<RandomInput> steps = AnyInputs();
  Facts facts;
  const auto machine = RandomMachine(seed, facts, 2);
  RC_ASSERT(machine->Build("A").ok());
  std::string text;
  std::vector<Change> history;
  {
    Recorder recorder(*machine, [&](std::string_view line) { text += line; });
    Time now(std::chrono::hours(5));
    (void)machine->Start(now).ok();
    for (const RandomInput& step : steps) {
      ApplyTo(*machine, step, now, facts,
              [&](std::int64_t number) { recorder.Input("number", std::to_string(number)); });
    }
  }
  Facts again;
  const auto other = RandomMachine(seed, again, 2);
  RC_ASSERT(other->Build("A").ok());
  const Result<Recording> recording = ReadRecording(text, "random.record");
  RC_ASSERT(recording.ok());
  const Result<Replayed> replayed =
      Replay(recording.value(), *other, [&](std::string_view, std::string_view number) -> Result<> {
        again.number = std::stoll(std::string(number));
        return Ok();
      });
  RC_ASSERT(replayed.ok());
  RC_ASSERT(replayed.value().difference.value_or("none") == "none");
  RC_ASSERT(other->Path() == machine->Path());
  RC_ASSERT(other->counts() == machine->counts());
  RC_ASSERT(other->history().size() == machine->history().size());
  for (std::size_t i = 0; i < machine->history().size(); ++i) {
    RC_ASSERT(other->history()[i] == machine->history()[i]);
  }
}

RC_GTEST_PROP(Recording, IsReadOrRefusedWhateverTheTextIs, (std::string text)) {
  (void)ReadRecording(text, "any").ok();
  (void)ReadRecording("musher-fsm-recording 1 show\n" + text + "\n", "any").ok();
}

}  // namespace musher::fsm::replay_test
