// Only the leading controller answers clients: not a controller that is still listening, and not a
// fenced controller that continues to run inside a program.

#include <gmock/gmock.h>

#include <map>
#include <optional>

#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/test/controller/two_controllers.hpp"
#include "musher/test/support/refusals.hpp"
#include "musher/transport/service.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::testing::leading_test {

using ::testing::Each;
using ::testing::IsEmpty;

constexpr Duration kLookAround = Milliseconds(1000);

class Leading : public TwoControllers {
 protected:
  Leading() {
    statuses_ = transport::MakeSubscription<msg::MachineStatus>(
                    *desk_, transport::MachineStatusTopic(""),
                    [this](const msg::MachineStatus& status, const transport::SampleInfo& info) {
                      status_of_[info.writer] = Epoch(status.epoch);
                      latest_ = status;
                    },
                    transport::kLatchedFromManyQos,
                    {[this](transport::EndpointId writer) { status_of_.erase(writer); }, nullptr})
                    .value();
    get_status_ = Client<msg::GetStatus>("get_status");
    set_state_ = Client<msg::SetState>("set_state");
  }

  template <class S>
  std::unique_ptr<transport::Client<S>> Client(const char* name) {
    return transport::MakeClient<S>(*desk_, transport::MachineService("", name)).value();
  }

  void SecondTakesOver() {
    Open(second_, "second");
    network_.RunFor(kLookAround);
    second_.process->Begin(true);
    ASSERT_TRUE(RunUntil([this] {
      return first_.machine().phase == Phase::kFenced &&
             second_.machine().phase == Phase::kRunning && get_status_->Servers().size() == 1;
    }));
  }

  // The epochs that the answers of the next `duration` come from, one request each 20 ms.
  std::vector<Epoch> EpochsThatAnswer(Duration duration) {
    auto epochs = std::make_shared<std::vector<Epoch>>();
    const Time end = network_.now() + duration;
    while (network_.now() < end) {
      get_status_->Call({}, kEnough, [epochs](const Result<msg::GetStatus::Response>& reply) {
        epochs->emplace_back(reply ? reply.value().status.epoch : 0);
      });
      network_.RunFor(Milliseconds(20));
    }
    return *epochs;
  }
  std::string OutcomeOfSet(const State& target) {
    auto outcome = std::make_shared<std::string>();
    set_state_->Call({target, ""}, kEnough, [outcome](const auto& reply) {
      *outcome = reply ? reply.value().outcome : reply.error().message;
    });
    RunUntil([&] { return !outcome->empty(); }, kEnough + kEnough);
    return *outcome;
  }

  std::map<transport::EndpointId, Epoch> status_of_;  // epoch of the latched status, by writer
  msg::MachineStatus latest_;                         // that was received
  std::unique_ptr<transport::Subscription> statuses_;
  std::unique_ptr<transport::Client<msg::GetStatus>> get_status_;
  std::unique_ptr<transport::Client<msg::SetState>> set_state_;
};

TEST_F(Leading, AControllerThatLooksAroundAnswersNoClient) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  Open(second_, "second");
  EXPECT_THAT(EpochsThatAnswer(kLookAround), Each(Epoch(1)));
  EXPECT_EQ(get_status_->Servers().size(), 1U);
  EXPECT_EQ(status_of_.size(), 1U) << "its status is latched by the leader alone";
  EXPECT_EQ(OutcomeOfSet("LowPower"), "done");
}

TEST_F(Leading, AControllerThatIsRefusedBesideTheLeaderAnswersNoClient) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  Open(second_, "second");
  network_.RunFor(kLookAround);
  second_.process->Begin(false);
  EXPECT_THAT(EpochsThatAnswer(kLookAround), Each(Epoch(1)));
  SwitchResult result;
  second_.process->shell().SetState("LowPower", std::nullopt, [&](const auto& r) { result = r; });
  EXPECT_EQ(result.outcome, SwitchOutcome::kRefused);
  EXPECT_THAT(result, IsRefused(Refusal::kAlreadyLed)) << "a caller in its own process gets it";
}

TEST_F(Leading, AFencedControllerThatKeepsRunningAnswersNoClient) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  ASSERT_NO_FATAL_FAILURE(SecondTakesOver());
  EXPECT_THAT(EpochsThatAnswer(kLookAround), Each(second_.machine().epoch));
  ASSERT_EQ(status_of_.size(), 1U);
  EXPECT_EQ(status_of_.begin()->second, second_.machine().epoch);
  EXPECT_EQ(OutcomeOfSet("LowPower"), "done") << "the robot can be commanded after the takeover";
}

TEST_F(Leading, ACallerInsideTheFencedProgramIsRefusedWithTheReason) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  ASSERT_NO_FATAL_FAILURE(SecondTakesOver());
  std::optional<SwitchResult> result;
  first_.process->shell().SetState("LowPower", std::nullopt, [&](const auto& r) { result = r; });
  ASSERT_TRUE(result);
  EXPECT_THAT(*result, IsRefused(Refusal::kLedByAnother));
}

TEST_F(Leading, EveryCallerIsNotifiedOfATakeoverDuringASwitch) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  std::optional<SwitchResult> result;
  Open(second_, "second");
  network_.RunFor(kLookAround);
  first_.process->shell().SetState("LowPower", std::nullopt, [&](const auto& r) { result = r; });
  second_.process->Begin(true);
  RunUntil([&] { return result.has_value(); });
  ASSERT_TRUE(result);
}

TEST_F(Leading, ARequestThatComesWhileNoControllerLeadsReachesTheNextLeader) {
  Open(first_, "first");
  auto state = std::make_shared<std::string>();
  get_status_->Call({}, kEnough, [state](const auto& reply) {
    *state = reply ? reply.value().status.phase : reply.error().message;
  });
  network_.RunFor(kLookAround);
  EXPECT_THAT(*state, IsEmpty());
  first_.process->Begin(false);
  RunUntil([&] { return !state->empty(); });
  EXPECT_EQ(*state, "starting");
}

TEST_F(Leading, ACallerInAControllerThatIsReplacedBeforeItBeginsIsRefused) {
  Open(first_, "first");
  first_.process->shell().ReleaseControl("the second");
  std::optional<SwitchResult> result;
  first_.process->shell().SetState("LowPower", std::nullopt, [&](const auto& r) { result = r; });
  ASSERT_TRUE(result);
  EXPECT_THAT(*result, IsRefused(Refusal::kRivalTakesOver));
}

TEST_F(Leading, ARequestThatStillWaitsWhenTheMachineHasStoppedIsRefused) {
  callback_takes_ = std::chrono::seconds(1);  // the actuators are not set up
  Open(first_, "first");
  first_.process->Begin(false);
  network_.RunFor(Milliseconds(100));
  first_.process->shell().TearDown(AfterTearDown::kStaysDown);
  std::optional<Result<>> answer;
  first_.process->shell().AwaitSetUp([&](const Result<>& result) { answer = result; });
  ASSERT_TRUE(RunUntil([&] { return answer.has_value(); }));
  ASSERT_FALSE(answer->ok());
  EXPECT_THAT(answer->error(), IsRefused(Refusal::kMachineStopped));
}

TEST_F(Leading, ARequestForTearDownIsAnsweredBeforeTheServicesGo) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  EXPECT_EQ(OutcomeOfSet("TearDown"), "done");
  RunUntil([this] { return !set_state_->Ready(); });
  EXPECT_FALSE(set_state_->Ready());
  network_.RunFor(std::chrono::seconds(1));
  EXPECT_THAT(status_of_, IsEmpty());
}

// It was up to 20 ms older: `musher status --follow` after `musher set` began with the state
// before.
TEST_F(Leading, TheLatchedStatusIsNeverOlderThanAnAnswer) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  transport::sim::LinkFaults in_order;  // of two topics, what is sent first also arrives first
  in_order.delay_min = in_order.delay_max = Milliseconds(1);
  network_.SetFaults(in_order);
  for (const char* target : {"LowPower", "Active"}) {
    std::optional<msg::MachineStatus> latched;
    set_state_->Call({target, ""}, kEnough, [&](const auto&) { latched = latest_; });
    ASSERT_TRUE(RunUntil([&] { return latched.has_value(); }));
    EXPECT_EQ(latched->state, target);
    EXPECT_EQ(latched->target, "");
    network_.RunFor(std::chrono::seconds(1));
  }
  const std::int32_t before = latest_.actuators.front().pid;
  std::optional<msg::MachineStatus> latched;
  const auto restart = Client<msg::RestartActuator>("restart_actuator");
  restart->Call({latest_.actuators.front().name}, kEnough, [&](const auto& reply) {
    EXPECT_TRUE(reply && reply.value().code == kCodeOk);
    latched = latest_;
  });
  ASSERT_TRUE(RunUntil([&] { return latched.has_value(); }));
  EXPECT_NE(latched->actuators.front().pid, before);
  EXPECT_EQ(latched->actuators.front().state, "Active");
}

// It was on the disk of the host that is taken over: what was restarted since the stop went to
// Active by itself.
TEST_F(Leading, ATakeoverOnAnotherHostSwitchesNothingOnAfterAReleasedStop) {
  BringUpFirst();
  first_.process->shell().OnStop({7, true, "alice", "smoke"});
  ASSERT_TRUE(RunUntil([this] { return first_.machine().emergency.stop.has_value(); }));
  std::optional<Result<>> released;
  first_.process->shell().ReleaseEmergencyStop(
      "alice", [&released](const Result<>& answer) { released = answer; });
  ASSERT_TRUE(RunUntil([&] { return released.has_value(); }));
  ASSERT_TRUE(*released);
  network_.RunFor(kLookAround);
  SecondTakesOver();
  EXPECT_TRUE(second_.machine().emergency.awaits_request);
  EXPECT_TRUE(RunUntil([this] { return second_.disk.stops.awaits_request; }));
  EXPECT_EQ(OutcomeOfSet("Active"), "done");
  EXPECT_FALSE(second_.machine().emergency.awaits_request);
}

// It went to Active: only the disk of the host that is taken over knew of the folder.
TEST_F(Leading, ATakeoverOnAnotherHostSwitchesNothingOnWhereAFolderOfStopsIsUnread) {
  first_.disk.unread = {{"/var/lib/musher/robot", "root", 7, false}};
  Open(first_, "first");
  first_.process->Begin(false);
  ASSERT_TRUE(RunUntil([this] { return first_.machine().phase == Phase::kFailed; }));
  network_.RunFor(kLookAround);
  Open(second_, "second");
  network_.RunFor(kLookAround);
  second_.process->Begin(true);
  ASSERT_TRUE(RunUntil([this] {
    const Phase phase = second_.machine().phase;
    return phase == Phase::kFailed || phase == Phase::kRunning;
  }));
  EXPECT_EQ(second_.machine().state, "SetUp");
  EXPECT_TRUE(second_.machine().emergency.awaits_request);
}

TEST_F(Leading, AStopThatIsEngagedAndReleasedDuringATakeoverHoldsWhatItHasSwitchedOff) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  const auto panel = transport::MakePublisher<msg::EmergencyStop>(
                         *desk_, transport::EmergencyStopTopic(""), transport::kLatchedQos)
                         .value();
  Open(second_, "second");
  network_.RunFor(kLookAround);
  ASSERT_TRUE(panel->Publish({7, true, "alice", "smoke"}));
  ASSERT_TRUE(RunUntil([this] { return first_.machine().emergency.stop.has_value(); }));
  std::optional<Result<>> released;
  first_.process->shell().ReleaseEmergencyStop(
      "alice", [&released](const Result<>& answer) { released = answer; });
  ASSERT_TRUE(RunUntil([&] { return released.has_value(); }));
  ASSERT_TRUE(*released);
  ASSERT_TRUE(second_.process->shell().rival()->awaits_request) << "said at once";
  second_.process->Begin(true);
  EXPECT_TRUE(second_.machine().emergency.awaits_request);
}

}  // namespace musher::testing::leading_test
