#include <gmock/gmock.h>

#include "musher/base/code.hpp"
#include "musher/test/protocols/cyberdog_module.hpp"
#include "musher/test/protocols/link_harness.hpp"

namespace musher::testing::cyberdog_link_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class DrivingACyberdogModule : public LinkStage {
 protected:
  DrivingACyberdogModule() : LinkStage(Protocol::kCyberdog) {
    OpenLink();
    StartModule("a");
  }

  void StartModule(const std::string& heartbeats_as, Duration set_up_takes = Milliseconds(5)) {
    process_ = network_.MakeNode("robot");
    module_ = std::make_unique<CyberdogModule>(*process_, "", "a", heartbeats_as, set_up_takes);
  }
  void EndModule() {
    module_ = nullptr;
    process_ = nullptr;
  }
  void SetUp() override {
    ASSERT_TRUE(Until([&] { return IsIn("SetUp"); }));
  }

  std::unique_ptr<transport::Node> process_;
  std::unique_ptr<CyberdogModule> module_;
};

TEST_F(DrivingACyberdogModule, AServiceThatIsVisibleIsAModuleThatIsSetUp) {
  EndModule();
  ASSERT_TRUE(Until([&] { return !losses_.empty(); }));
  const Incarnation first = status_.incarnation;
  StartModule("a", std::chrono::seconds(3));
  network_.RunFor(std::chrono::seconds(2));
  EXPECT_EQ(status_.incarnation, first);
  EXPECT_TRUE(Until([&] { return status_.incarnation != first && IsIn("SetUp"); }));
}

TEST_F(DrivingACyberdogModule, TheCodeIsTheOutcomeAndCurrentStateIsIgnored) {
  EXPECT_EQ(Do("SelfCheck").report.state, "SelfCheck");
  EXPECT_EQ(Do("Active").report.state, "Active");
  EXPECT_EQ(Do("LowPower").report.state, "LowPower");
  EXPECT_THAT(module_->log(), ElementsAre("SelfCheck", "Active", "LowPower"));
}

TEST_F(DrivingACyberdogModule, ACallbacksCodeIsAFailureAndTheModuleIsWhereItWas) {
  module_->script["Active"].code = 5001;
  const event::Replied reply = Do("Active");
  EXPECT_EQ(reply.verdict, Verdict::kFailed);
  EXPECT_EQ(reply.code, 5001);
  EXPECT_EQ(reply.report.state, "SetUp");
}

TEST_F(DrivingACyberdogModule, ANakedEightIsARefusal) {
  module_->unknown_states = {"OTA"};
  const event::Replied reply = Do("OTA");
  EXPECT_EQ(reply.verdict, Verdict::kRefused);
  EXPECT_EQ(reply.code, 8);
  EXPECT_NE(reply.report.outcome_number, number_) << "nothing ran";
}

TEST_F(DrivingACyberdogModule, WhenQueriedItIsBusyUntilItsReplyAndNothingMoreIsSent) {
  module_->script["Active"].takes = std::chrono::seconds(1);
  const CommandNumber active = Switch("Active");
  network_.RunFor(Milliseconds(100));
  ASSERT_TRUE(Query());
  EXPECT_EQ(answer_->report.busy_number, active);
  Switch("LowPower");
  network_.RunFor(Milliseconds(100));
  ASSERT_TRUE(Query());
  EXPECT_EQ(reply_->verdict, Verdict::kRefused) << "fenced before it had begun";
  ASSERT_TRUE(Until([&] { return !status_.busy() && status_.outcome_number == active; }));
  EXPECT_EQ(status_.state, "Active");
  EXPECT_THAT(module_->log(), ElementsAre("Active"));
}

TEST_F(DrivingACyberdogModule, ALateFailureIsReportedAsAFailure) {
  module_->script["Active"] = {std::chrono::seconds(1), 5001};
  Switch("Active");
  network_.RunFor(Milliseconds(100));
  ASSERT_TRUE(Query());
  ASSERT_TRUE(Until([&] { return !status_.busy() && status_.outcome_number == number_; }));
  EXPECT_EQ(status_.outcome_code, 5001);
  EXPECT_EQ(status_.state, "SetUp");
}

TEST_F(DrivingACyberdogModule, TheNewestCommandWaitsBehindTheRunningCommand) {
  module_->script["Active"].takes = Milliseconds(50);
  Switch("Active");
  Switch("LowPower");
  const CommandNumber error = Switch("Error");
  ASSERT_TRUE(Until([&] { return reply_ && reply_->number == error; }));
  EXPECT_EQ(reply_->verdict, Verdict::kDone);
  EXPECT_THAT(module_->log(), ElementsAre("Active", "Error"));
}

TEST_F(DrivingACyberdogModule, AfterALostReplyItStaysUnknownUntilItIsStartedAgain) {
  module_->lost_replies = 1;
  Switch("Active");
  network_.RunFor(std::chrono::minutes(1));
  ASSERT_TRUE(Query());
  EXPECT_EQ(answer_->report.busy_number, number_);
  const Incarnation first = status_.incarnation;
  EndModule();
  StartModule("a");
  ASSERT_TRUE(Until([&] { return status_.incarnation != first; }));
  EXPECT_EQ(Do("Active").verdict, Verdict::kDone);
}

TEST_F(DrivingACyberdogModule, ASuccessorIsDrivenBeforeTheLeaseOfThePreviousProcessExpires) {
  const Incarnation first = status_.incarnation;
  network_.Crash(*process_);
  EndModule();
  StartModule("a");
  ASSERT_TRUE(Until([&] { return IsIn("SetUp") && status_.incarnation != first; },
                    std::chrono::seconds(1)));
  EXPECT_EQ(Do("Active").verdict, Verdict::kDone);
  network_.RunFor(std::chrono::seconds(20));
  EXPECT_THAT(losses_, IsEmpty());
}

class CyberdogHeartbeats : public DrivingACyberdogModule {
 protected:
  void ReceiveHeartbeat() { network_.RunFor(std::chrono::seconds(1)); }
};

TEST_F(CyberdogHeartbeats, AModuleWithoutHeartbeatsIsNotLost) {
  EndModule();
  ASSERT_TRUE(Until([&] { return !losses_.empty(); }));
  losses_.clear();
  StartModule("");
  network_.RunFor(std::chrono::minutes(5));
  EXPECT_THAT(losses_, IsEmpty());
}

TEST_F(CyberdogHeartbeats, HeartbeatsUnderAnotherNameAreReceivedUnderIt) {
  config_.actuators[0].heartbeat_name = "device";
  EndModule();
  OpenLink();
  StartModule("device");
  ReceiveHeartbeat();
  module_->sends_heartbeats = false;
  EXPECT_TRUE(Until([&] { return !losses_.empty(); }));
}

TEST_F(CyberdogHeartbeats,
       AModuleWhoseHeartbeatsStopIsLostAfterFivePeriodsOnceUntilTheNextHeartbeat) {
  ReceiveHeartbeat();
  module_->sends_heartbeats = false;
  const Time ceased = network_.now();
  ASSERT_TRUE(Until([&] { return !losses_.empty(); }));
  EXPECT_THAT(losses_, ElementsAre("its heartbeats have stopped"));
  EXPECT_LE(network_.now() - ceased, Milliseconds(2600));
  EXPECT_GE(network_.now() - ceased, Milliseconds(1900));
  const int before = statuses_;
  network_.RunFor(std::chrono::minutes(10));
  EXPECT_THAT(losses_, SizeIs(1));
  EXPECT_EQ(statuses_, before) << "a dead module does not read alive now and then";
}

TEST_F(CyberdogHeartbeats, AModuleWhoseHeartbeatsResumeIsTheSameIncarnation) {
  ReceiveHeartbeat();
  const Incarnation incarnation = status_.incarnation;
  module_->sends_heartbeats = false;
  ASSERT_TRUE(Until([&] { return !losses_.empty(); }));
  const int before = statuses_;
  module_->sends_heartbeats = true;
  ASSERT_TRUE(Until([&] { return statuses_ > before; }));
  EXPECT_EQ(status_.incarnation, incarnation);
  module_->sends_heartbeats = false;
  EXPECT_TRUE(Until([&] { return losses_.size() == 2; })) << "it is watched again";
}

TEST_F(CyberdogHeartbeats, AModuleNeedsNoHeartbeatWhileACommandRunsWithinItsTimeLimit) {
  ReceiveHeartbeat();
  module_->script["Active"].takes = std::chrono::seconds(22);
  Switch("Active", std::chrono::seconds(30));
  EXPECT_EQ(Outcome(std::chrono::seconds(25)).verdict, Verdict::kDone);
  network_.RunFor(std::chrono::seconds(10));
  EXPECT_THAT(losses_, IsEmpty());
}

TEST_F(CyberdogHeartbeats, AModuleThatIsSilentBeyondItsTimeLimitIsLostUntilItsLateReply) {
  ReceiveHeartbeat();
  module_->script["Active"].takes = std::chrono::seconds(22);
  Switch("Active", std::chrono::seconds(10));
  ASSERT_TRUE(Until([&] { return !losses_.empty(); }, std::chrono::seconds(11)));
  EXPECT_TRUE(Until([&] { return IsIn("Active"); }, std::chrono::seconds(13)));
}

}  // namespace musher::testing::cyberdog_link_test
