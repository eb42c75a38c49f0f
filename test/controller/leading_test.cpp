// Only the leading controller answers clients: not a controller that is still listening, and not a
// fenced controller that continues to run inside a program.

#include <gmock/gmock.h>

#include <map>
#include <optional>
#include <vector>

#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/messages/musher_msgs/policy_request.hpp"
#include "musher/test/controller/two_controllers.hpp"
#include "musher/test/support/refusals.hpp"
#include "musher/transport/service.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::testing::leading_test {

using ::testing::Each;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::UnorderedElementsAre;

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

  std::vector<EventName> LateRecords() const {
    std::vector<EventName> late;
    for (const action::Record& record : records_) {
      if (HasSentence(record.message, Refusal::kMayBeLate, false)) late.push_back(record.event);
    }
    return late;
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

// A request that waited in the kernel was obeyed when the controller ran again: the person had long
// gone.
TEST_F(Leading, ARequestThatWaitedWhileItsControllerWasStoppedRaisesNothing) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  const auto restart_actuator = Client<msg::RestartActuator>("restart_actuator");
  const auto release = Client<msg::ReleaseEmergencyStop>("release_emergency_stop");
  ASSERT_TRUE(RunUntil(
      [&] { return set_state_->Ready() && restart_actuator->Ready() && release->Ready(); }));
  network_.Pause(first_.process->node());
  std::optional<msg::SetState::Response> up;
  std::optional<msg::RestartActuator::Response> restarted;
  std::optional<msg::ReleaseEmergencyStop::Response> released;
  set_state_->Call({"Active", ""}, kEnough, [&](const auto& reply) { up = reply.value(); });
  restart_actuator->Call({config_.actuators[ActuatorIndex(0)].name, "a person"}, kEnough,
                         [&](const auto& reply) { restarted = reply.value(); });
  release->Call({"a person"}, kEnough, [&](const auto& reply) { released = reply.value(); });
  network_.RunFor(std::chrono::seconds(9));
  network_.Resume(first_.process->node());
  ASSERT_TRUE(RunUntil([&] { return up && restarted && released; }));
  EXPECT_THAT(*up, IsRefused(Refusal::kMayBeLate));
  EXPECT_THAT(*restarted, IsRefused(Refusal::kMayBeLate));
  EXPECT_THAT(*released, IsRefused(Refusal::kMayBeLate));
}

TEST_F(Leading, ARequestOfThePolicyThatWaitedWhileItsControllerWasStoppedLeadsOutOfNothing) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  const auto request_policy = Client<msg::RequestPolicy>("request_policy");
  ASSERT_TRUE(RunUntil([&] { return request_policy->Ready(); }));
  network_.Pause(first_.process->node());
  std::map<std::string, msg::RequestPolicy::Response> answers;
  const auto send = [&](const std::string& name, const msg::RequestPolicy::Request& request) {
    request_policy->Call(request, kEnough,
                         [&answers, name](const auto& reply) { answers[name] = reply.value(); });
  };
  send("wake-up", {"wake-up", "", 0, false});
  send("into OTA", {"ota", "", 0, true});
  send("out of OTA", {"ota", "", 0, false});
  send("keep", {"keep", "Active", 60, false});
  send("low power", {"low-power", "", 0, true});
  network_.RunFor(std::chrono::seconds(9));
  network_.Resume(first_.process->node());
  ASSERT_TRUE(RunUntil([&] { return answers.size() == 5; }));
  for (const char* name : {"wake-up", "into OTA", "out of OTA", "keep"}) {
    EXPECT_THAT(answers[name], IsRefused(Refusal::kMayBeLate)) << name;
  }
  EXPECT_THAT(answers["low power"], Not(IsRefused(Refusal::kMayBeLate)));
}

// "Automatic LowPower: off" wakes the machine up, and a keep of no time, whose stay is over, is a
// switch: eight seconds later each of them took the machine to Active.
TEST_F(Leading, ARequestForThePolicyThatWaitedWhileItsControllerWasStoppedRaisesNothing) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  const auto policy = Client<msg::RequestPolicy>("request_policy");
  ASSERT_TRUE(RunUntil([&] { return policy->Ready(); }));
  network_.Pause(first_.process->node());
  std::vector<msg::RequestPolicy::Response> answers;
  for (const msg::RequestPolicy::Request& request :
       {msg::RequestPolicy::Request{"wake-up", "", 0, true},
        msg::RequestPolicy::Request{"low-power", "", 0, false},
        msg::RequestPolicy::Request{"low-power-store", "", 0, false},
        msg::RequestPolicy::Request{"keep", "Active", 0, true}}) {
    policy->Call(request, kEnough, [&](const auto& reply) { answers.push_back(reply.value()); });
  }
  network_.RunFor(std::chrono::seconds(9));
  network_.Resume(first_.process->node());
  ASSERT_TRUE(RunUntil([&] { return answers.size() == 4; }));
  EXPECT_THAT(answers, Each(IsRefused(Refusal::kMayBeLate)));
}

// A person who saw that nothing happened found no trace of the request in the history.
TEST_F(Leading, ARequestThatIsRefusedAsLateIsRecordedOnceHoweverOftenItIsRepeated) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  const auto restart_actuator = Client<msg::RestartActuator>("restart_actuator");
  const auto release = Client<msg::ReleaseEmergencyStop>("release_emergency_stop");
  const auto policy = Client<msg::RequestPolicy>("request_policy");
  ASSERT_TRUE(RunUntil([&] {
    return set_state_->Ready() && restart_actuator->Ready() && release->Ready() && policy->Ready();
  }));
  network_.Pause(first_.process->node());
  int answers = 0;
  const auto count = [&answers](const auto&) { ++answers; };
  for (int i = 0; i < 2; ++i) {
    set_state_->Call({"Active", ""}, kEnough, count);
    restart_actuator->Call({config_.actuators[ActuatorIndex(0)].name, "a person"}, kEnough, count);
    release->Call({"a person"}, kEnough, count);
    policy->Call({"wake-up", "", 0, true}, kEnough, count);
  }
  network_.RunFor(std::chrono::seconds(9));
  network_.Resume(first_.process->node());
  ASSERT_TRUE(RunUntil([&] { return answers == 8; }));
  EXPECT_THAT(LateRecords(),
              UnorderedElementsAre(EventName::kSwitchRefused, EventName::kPolicyRefused,
                                   EventName::kRequestRefused, EventName::kRequestRefused));
}

TEST_F(Leading, RequestsThatAreRefusedAsLateDoNotFloodTheJournal) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  const Error late = Refused<Refusal::kMayBeLate>(9);
  for (int i = 0; i < 1000; ++i) {
    first_.process->shell().RecordLateRestart("actuator " + std::to_string(i), late);
  }
  EXPECT_EQ(LateRecords().size(), ControllerShell::kMostLate);
  network_.RunFor(std::chrono::seconds(8));
  first_.process->shell().RecordLateRelease(late);
  EXPECT_EQ(LateRecords().size(), ControllerShell::kMostLate + 1) << "of another stop";
}

TEST_F(Leading, ASwitchDownIsObeyedHoweverLongItsControllerWasStopped) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  ASSERT_TRUE(RunUntil([&] { return set_state_->Ready(); }));
  network_.Pause(first_.process->node());
  std::optional<msg::SetState::Response> down;
  set_state_->Call({"TearDown", ""}, kEnough, [&](const auto& reply) { down = reply.value(); });
  network_.RunFor(std::chrono::seconds(9));
  network_.Resume(first_.process->node());
  ASSERT_TRUE(RunUntil([&] { return down.has_value(); }));
  EXPECT_EQ(down->target, "TearDown");
  EXPECT_NE(down->outcome, "refused") << down->reason;
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

// The status named it as held by the stop, like one that stands. Only the command that had engaged
// the stop said that it moved on, and a panel says nothing.
TEST_F(Leading, TheStatusNamesAnActuatorThatHasLatchedAStopAndHasNotStopped) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  ASSERT_EQ(OutcomeOfSet("LowPower"), "done");
  callback_takes_ = std::chrono::seconds(3);
  first_.process->shell().SetState("Active", std::nullopt, [](const auto&) {});
  network_.RunFor(Milliseconds(300));
  EXPECT_THAT(latest_.not_stopped, IsEmpty());
  first_.process->shell().OnStop({7, true, "alice", "smoke"});
  network_.RunFor(Milliseconds(800));
  EXPECT_THAT(latest_.not_stopped, IsEmpty()) << "a stop needs some time";
  ASSERT_TRUE(RunUntil([this] { return !latest_.not_stopped.empty(); }));
  EXPECT_THAT(latest_.not_stopped.front(),
              ::testing::HasSubstr(": its callback for Active still runs"));
  ASSERT_TRUE(RunUntil([this] { return latest_.not_stopped.empty(); }));
  EXPECT_TRUE(latest_.emergency_stop);
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
