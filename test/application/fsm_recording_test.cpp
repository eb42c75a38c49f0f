// The file of a recording, and its replay.

#include "musher/application/fsm_recording.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <iterator>
#include <sstream>
#include <vector>

#include "musher/application/fsm_replay_file.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::fsm_recording_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

// A door that is open while something is near it.
struct Door {
  class Leaf : public fsm::State {
   public:
    Leaf(const bool& near, bool open) : near_(near), open_(open) {}
    void Declare(fsm::Transitions& transitions) override {
      other_ = transitions.To(open_ ? "SHUT" : "OPEN", "something is near or far");
    }
    fsm::Next CheckTransition(const fsm::Tick&) override {
      return near_ != open_ ? fsm::Next::To(other_) : fsm::Next::Stay();
    }

   private:
    const bool& near_;
    const bool open_;
    fsm::StateId other_ = fsm::kNoState;
  };

  Result<> Build(fsm::Machine& machine) {
    machine.Add("SHUT", std::make_unique<Leaf>(near, false));
    machine.Add("OPEN", std::make_unique<Leaf>(near, true));
    return machine.Build("SHUT");
  }
  Result<> Apply(std::string_view input, std::string_view text) {
    if (input != "near") return Error{kCodeFailed, "no input '" + std::string(input) + "'"};
    near = text == "yes";
    return Ok();
  }

  bool near = false;
};

class FsmRecordingTest : public ::testing::Test {
 protected:
  // Records a run in which the door is opened once.
  void Record(const std::string& file) {
    Door door;
    fsm::Machine machine({.name = "door"});
    ASSERT_TRUE(door.Build(machine));
    auto recording = FsmRecording::Open(machine, file, "robot.record", Log());
    ASSERT_TRUE(recording) << recording.error().message;
    ASSERT_TRUE(machine.Start(Time(Milliseconds(100))));
    for (int i = 0; i < 50; ++i) {
      if (i == 20) {
        recording.value()->recorder().Input("near", "yes");
        door.near = true;
      }
      machine.RunOnce(Time(Milliseconds(100 + 20 * i)));
    }
    recording.value().reset();
  }
  FsmRecording::Log Log() {
    return [this](const std::string& line) { log_.push_back(line); };
  }
  ReplayExit Replay(const std::string& file) {
    std::ostringstream out, err;
    const ReplayExit exit = ReplayFile(
        file,
        [](fsm::Machine& machine) -> Result<ReplayedInput> {
          const auto door = std::make_shared<Door>();
          if (const Result<> built = door->Build(machine); !built) return built.error();
          return ReplayedInput([door](std::string_view input, std::string_view text) {
            return door->Apply(input, text);
          });
        },
        out, err);
    out_ = out.str();
    err_ = err.str();
    return exit;
  }
  static std::string TextOf(const std::string& file) {
    std::ifstream stream(file);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  const TempFolder folder_;
  const std::string file_ = folder_ / "door.record";
  std::vector<std::string> log_;
  std::string out_;
  std::string err_;
};

TEST_F(FsmRecordingTest, IsReplayedIdenticallyWithItsChanges) {
  Record(file_);
  EXPECT_EQ(Replay(file_), ReplayExit::kIdentical) << err_;
  EXPECT_THAT(out_, HasSubstr("s  SHUT -> OPEN  "));
  EXPECT_THAT(out_, HasSubstr("50 ticks, 2 changes: identical"));
  EXPECT_THAT(log_, IsEmpty());
}

TEST_F(FsmRecordingTest, KeepsTheFileOfTheRunBeforeOnce) {
  std::ofstream(file_) << "the run before";
  Record(file_);
  EXPECT_EQ(TextOf(file_ + ".before"), "the run before");
  EXPECT_EQ(Replay(file_), ReplayExit::kIdentical) << err_;
}

TEST_F(FsmRecordingTest, OfAMachineThatWasNotStartedReplacesNone) {
  Record(file_);
  const std::string run = TextOf(file_);
  for (int starts = 0; starts < 3; ++starts) {
    Door door;
    fsm::Machine machine({.name = "door"});
    ASSERT_TRUE(door.Build(machine));
    ASSERT_TRUE(FsmRecording::Open(machine, file_, "robot.record", Log()));
  }
  EXPECT_EQ(TextOf(file_ + ".before"), run);
}

TEST_F(FsmRecordingTest, EndsWhereItIsAsLongAsItMayBeAndIsReplayedUpToThere) {
  Door door;
  fsm::Machine machine({.name = "door"});
  ASSERT_TRUE(door.Build(machine));
  constexpr std::size_t kMost = std::size_t{1} << 20;
  auto recording = FsmRecording::Open(machine, file_, "robot.record", Log(), kMost);
  ASSERT_TRUE(recording);
  ASSERT_TRUE(machine.Start(Time(Milliseconds(0))));
  const std::string input(5'000, 'x');
  for (int i = 0; i < 400; ++i) {
    if (i > 0) recording.value()->recorder().Input("near", input);
    machine.RunOnce(Time(Milliseconds(20 * i)));
  }
  recording.value().reset();
  EXPECT_LE(TextOf(file_).size(), kMost);
  EXPECT_GT(TextOf(file_).size(), kMost / 2);
  EXPECT_THAT(log_, ElementsAre("the recording ends here: it has 1 MiB, as much as it may have"));
  EXPECT_EQ(Replay(file_), ReplayExit::kIdentical) << err_;
}

TEST_F(FsmRecordingTest, OfAFileThatCannotBeWrittenToNamesTheKeyAndTheFile) {
  Door door;
  fsm::Machine machine({.name = "door"});
  ASSERT_TRUE(door.Build(machine));
  const auto recording = FsmRecording::Open(machine, folder_ / "no/door.record", "record.file", {});
  ASSERT_FALSE(recording);
  EXPECT_EQ(recording.error().message,
            "record.file: " + folder_ / "no/door.record" + " cannot be written to");
}

TEST_F(FsmRecordingTest, OfAFullDiskIsLoggedOnceAndTheMachineRunsOn) {
  Record("/dev/full");
  EXPECT_THAT(log_, ElementsAre("the recording ends here: its file cannot be written to"));
}

TEST_F(FsmRecordingTest, ThatIsDifferentIsReportedWithTheLine) {
  Record(file_);
  std::string text = TextOf(file_);
  text.replace(text.find("near yes"), 8, "near no");
  std::ofstream(file_) << text;
  EXPECT_EQ(Replay(file_), ReplayExit::kDifferent);
  EXPECT_THAT(out_, HasSubstr("changes: different\n" + file_ + ":"));
}

TEST_F(FsmRecordingTest, ThatIsNoneIsRefusedWithTheReason) {
  EXPECT_EQ(Replay(file_), ReplayExit::kNoRecording);
  EXPECT_THAT(err_, StartsWith(file_ + ": error: "));
  std::ofstream(file_) << "start = 1\n";
  EXPECT_EQ(Replay(file_), ReplayExit::kNoRecording);
  EXPECT_THAT(err_, StartsWith(file_ + ":1:1: error: "));
  EXPECT_EQ(Replay(folder_.path()), ReplayExit::kNoRecording) << "a folder";
  Record(file_);
  std::string text = TextOf(file_);
  text.replace(text.find("input near"), 10, "input neat");
  std::ofstream(file_) << text;
  EXPECT_EQ(Replay(file_), ReplayExit::kNoRecording);
  EXPECT_THAT(err_, HasSubstr("no input 'neat'"));
}

}  // namespace musher::fsm_recording_test
