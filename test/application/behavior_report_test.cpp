// The status message of a state machine.

#include "musher/application/behavior_report.hpp"

#include <gmock/gmock.h>

#include <memory>
#include <stdexcept>

#include "musher/behavior/fsm/nested.hpp"

namespace musher::behavior_report_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Continues on its command, and throws on another.
class Waiting : public fsm::State {
 public:
  explicit Waiting(std::string next) : next_name_(std::move(next)) {}

  void Declare(fsm::Transitions& transitions) override {
    next_ = transitions.To(next_name_, "on command");
    go_ = transitions.On("go");
    fail_ = transitions.On("fail");
  }
  fsm::Next CheckTransition(const fsm::Tick& tick) override {
    if (tick.command == fail_) throw std::runtime_error("no light");
    return tick.command == go_ ? fsm::Next::To(next_) : fsm::Next::Stay();
  }

 private:
  const std::string next_name_;
  fsm::StateId next_ = fsm::kNoState;
  fsm::EventId go_ = fsm::kNoEvent;
  fsm::EventId fail_ = fsm::kNoEvent;
};

std::unique_ptr<fsm::Machine> Inner() {
  auto inner = std::make_unique<fsm::Machine>(fsm::Machine::Options{.name = "photo"});
  for (const char* event : {"go", "fail"}) inner->AddEvent(event);
  inner->Add("COUNT", std::make_unique<Waiting>("SHOOT"));
  inner->Add("SHOOT", std::make_unique<fsm::State>(), fsm::Role::kFinal);
  return inner;
}

class BehaviorReport : public ::testing::Test {
 protected:
  BehaviorReport() {
    for (const char* event : {"go", "fail"}) machine_.AddEvent(event);
    machine_.Add("IDLE", std::make_unique<Waiting>("SHOW"));
    machine_.Add("SHOW", std::make_unique<Waiting>("PHOTO"));
    machine_.Add("PHOTO", std::make_unique<fsm::Nested>(Inner(), "COUNT",
                                                        fsm::Nested::Options{.finished = "IDLE"}));
    machine_.Add("STOP", std::make_unique<Waiting>("IDLE"), fsm::Role::kSafe);
    machine_.AddSafetyCheck("too close", [this](const fsm::Tick&) { return safe_; });
    const Result<> built = machine_.Build("IDLE");
    EXPECT_TRUE(built) << built.error().message;
  }
  void Tick(const char* command = nullptr) {
    if (command != nullptr) {
      EXPECT_TRUE(machine_.Send(command));
    }
    machine_.RunOnce(now_ += Milliseconds(500));
  }
  msg::GetBehavior::Response Report(const msg::GetBehavior::Request& request = {}) const {
    return ReportBehavior(machine_, true, request);
  }

  Time now_{std::chrono::hours(1)};
  fsm::Machine machine_{{.name = "show"}};
  bool safe_ = true;
};

TEST_F(BehaviorReport, OfAMachineThatDoesNotRunHasNoState) {
  const auto report = ReportBehavior(machine_, false, {"", 10});
  EXPECT_FALSE(report.running);
  EXPECT_FALSE(report.ticking);
  EXPECT_EQ(report.current_state, "");
  EXPECT_EQ(report.operating_mode, "NORMAL");
  EXPECT_THAT(report.history, IsEmpty());
}

TEST_F(BehaviorReport, HasStateModeTicksTimesAndTheNewestChanges) {
  ASSERT_TRUE(machine_.Start(now_));
  Tick();
  Tick("go");
  Tick();
  const auto report = Report({"", 1});
  EXPECT_TRUE(report.running);
  EXPECT_TRUE(report.ticking);
  EXPECT_EQ(report.current_state, "SHOW");
  EXPECT_EQ(report.operating_mode, "NORMAL");
  EXPECT_EQ(report.iter_count, 3U);
  EXPECT_EQ(report.time_s, 1.5);
  EXPECT_EQ(report.time_in_state_s, 0.5);
  EXPECT_THAT(report.history,
              ElementsAre(msg::BehaviorChange{1.0, 2, "IDLE", "SHOW", "decided", "go"}));
  EXPECT_THAT(Report({"", 9}).history.at(0),
              (msg::BehaviorChange{0, 0, "", "IDLE", "started", ""}));
  EXPECT_THAT(Report().history, IsEmpty());
}

TEST_F(BehaviorReport, NamesTheStateOfTheMachineInside) {
  ASSERT_TRUE(machine_.Start(now_));
  ASSERT_TRUE(machine_.Force("PHOTO"));
  EXPECT_EQ(Report().current_state, "PHOTO/COUNT");
}

TEST_F(BehaviorReport, HasTheReasonOfTheSafeState) {
  ASSERT_TRUE(machine_.Start(now_));
  safe_ = false;
  Tick();
  EXPECT_EQ(Report().operating_mode, "SAFE_STOP");
  EXPECT_TRUE(Report().safety_triggered);
  EXPECT_EQ(Report().unsafe, "too close");
  EXPECT_EQ(Report({"", 1}).history.at(0).cause, "unsafe");
}

TEST_F(BehaviorReport, HasTheLastFaultWithItsStateAndFunction) {
  ASSERT_TRUE(machine_.Start(now_));
  Tick("fail");
  EXPECT_EQ(Report().last_fault, "IDLE: CheckTransition: no light");
  EXPECT_EQ(Report({"", 1}).history.at(0).cause, "fault");
}

TEST_F(BehaviorReport, DrawsTheMachineWithItsPresentStateMarked) {
  ASSERT_TRUE(machine_.Start(now_));
  const std::string idle = Report({"dot", 0}).graph;
  EXPECT_THAT(idle, HasSubstr("digraph"));
  EXPECT_THAT(Report({"mermaid", 0}).graph, HasSubstr("stateDiagram-v2"));
  Tick("go");
  EXPECT_NE(Report({"dot", 0}).graph, idle) << "another one is marked now";
}

TEST_F(BehaviorReport, RefusesAnUnknownFormat) {
  EXPECT_EQ(Report({"png", 0}).error, "unknown graph format; expected dot or mermaid");
}

}  // namespace musher::behavior_report_test
