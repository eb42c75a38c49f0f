#include "musher/controller/journal/input_recorder.hpp"

#include <gmock/gmock.h>

#include <vector>

namespace musher::recording::input_recorder_test {

class Sink : public JournalSink {
 public:
  void Append(JournalItem item) noexcept override {
    inputs.push_back(std::get<JournalInput>(std::move(item)));
  }
  bool WantsSnapshot() noexcept override { return std::exchange(wants, false); }

  // One letter for each input: a config, an event, a machine.
  std::string Kinds() const {
    std::string kinds;
    for (const JournalInput& input : inputs) kinds += "cem"[input.what.index()];
    return kinds;
  }

  std::vector<JournalInput> inputs;
  bool wants = false;
};

class InputRecorderTest : public ::testing::Test {
 protected:
  InputRecorderTest() {
    config_.hash = "cafe";
    machine_.phase = Phase::kRunning;
    recorder_.Begin(1, "[controller]");
  }
  void Note(int times) {
    for (int i = 0; i < times; ++i) recorder_.Note(2, machine_, event::TimePassed{}, Time());
  }

  MachineConfig config_;
  Machine machine_;
  Sink sink_;
  InputRecorder recorder_{sink_, config_};
};

TEST_F(InputRecorderTest, RecordsTheConfigAndThenEveryEventWithItsTime) {
  recorder_.Note(2, machine_, event::SetUpAwaited{5}, Time(Milliseconds(7)));
  ASSERT_EQ(sink_.Kinds(), "ce");
  EXPECT_EQ(std::get<ConfigText>(sink_.inputs[0].what), (ConfigText{"", "cafe", "[controller]"}));
  EXPECT_EQ(std::get<TimedEvent>(sink_.inputs[1].what),
            (TimedEvent{event::SetUpAwaited{5}, Time(Milliseconds(7))}));
}

TEST_F(InputRecorderTest, TakesASnapshotEveryThousandInputs) {
  Note(2500);
  EXPECT_EQ(sink_.inputs.size(), 1U + 2500U + 2U);
  const auto* snapshot = std::get_if<SnapshotPtr>(&sink_.inputs[1001].what);
  ASSERT_NE(snapshot, nullptr) << "before the event that it is followed by";
  EXPECT_EQ((*snapshot)->machine, machine_);
  EXPECT_EQ((*snapshot)->config_hash, "cafe");
}

TEST_F(InputRecorderTest, TakesSnapshotsOfALargeMachineLessOften) {
  machine_.actuators.resize(100);
  Note(3001);
  EXPECT_EQ(sink_.inputs.size(), 1U + 3001U + 1U);
}

TEST_F(InputRecorderTest, RecordsTheConfigOnceMoreWhenTheJournalHasLostEarlierInputs) {
  Note(1);
  sink_.wants = true;
  Note(2);
  EXPECT_EQ(sink_.Kinds(), "cecmee");
  EXPECT_EQ(std::get<ConfigText>(sink_.inputs[2].what).text, "[controller]");
}

}  // namespace musher::recording::input_recorder_test
