#include "musher/controller/shell/record_writer.hpp"

#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/harness.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::testing::record_writer_test {

using ::testing::ElementsAre;

class Sink : public JournalSink {
 public:
  void Append(JournalItem item) noexcept override {
    entries.push_back(std::get<JournalEntry>(std::move(item)));
  }
  std::vector<JournalEntry> entries;
};

class RecordWriterTest : public ::testing::Test {
 protected:
  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> node_ = network_.MakeNode("desk");
  MachineConfig config_ = MachineOf(2);
  Machine machine_ = MakeMachine(config_);
  Sink sink_;
  std::vector<std::string> recorded_;
  RecordWriter writer_{node_->loop(),
                       sink_,
                       [] { return 7; },
                       config_,
                       machine_,
                       [this](const action::Record& record) { recorded_.push_back(record.message); }};
};

TEST_F(RecordWriterTest, WritesARecordWithItsActuatorAndTheControllersEpoch) {
  machine_.epoch = 4;
  action::Record record{"actuator", ActuatorIndex(1), 0, kCodeTimeout, "it is late"};
  record.id = 12;
  writer_.Write(record);
  ASSERT_EQ(sink_.entries.size(), 1U);
  const JournalEntry& entry = sink_.entries[0];
  EXPECT_EQ(entry.wall_ns, 7);
  EXPECT_EQ(entry.epoch, Epoch(4));
  EXPECT_EQ(entry.actuator, config_.actuators[ActuatorIndex(1)].name);
  EXPECT_EQ(entry.code, kCodeTimeout);
  EXPECT_EQ(entry.id, RecordId(12));
  EXPECT_THAT(recorded_, ElementsAre("it is late"));
}

TEST_F(RecordWriterTest, AnOwnRecordIsOfNoDecision) {
  writer_.Remark(kCodeFailed, "the disk is full");
  ASSERT_EQ(sink_.entries.size(), 1U);
  EXPECT_EQ(sink_.entries[0].kind, "machine");
  EXPECT_EQ(sink_.entries[0].event, NameOf(EventName::kControllerRemark));
  EXPECT_EQ(sink_.entries[0].id, RecordId(0));
  EXPECT_EQ(sink_.entries[0].cause, RecordId(0));
}

TEST_F(RecordWriterTest, KeepsTheLastRecordsOfSwitchesOnly) {
  for (int i = 0; i < 130; ++i) {
    action::Record record{"switch", std::nullopt, CommandNumber(1), kCodeOk, std::to_string(i)};
    record.of_switch.emplace();
    writer_.Write(record);
    writer_.Remark(kCodeOk, "between");
  }
  ASSERT_EQ(writer_.switches().size(), 128U);
  EXPECT_EQ(writer_.switches().front().message, "2");
  EXPECT_EQ(writer_.switches().back().message, "129");
}

}  // namespace musher::testing::record_writer_test
