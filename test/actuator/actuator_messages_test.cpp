// What an actuator takes from the network, and what it publishes: permits, heartbeats, requests and
// statuses. On the simulated network.

#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/actuator/actuator_shell.hpp"
#include "musher/base/code.hpp"
#include "musher/lifecycle/refusal.hpp"
#include "musher/messages/lifecycle_msgs/services.hpp"
#include "musher/messages/protocol/device.hpp"
#include "musher/messages/protocol/fs_machine.hpp"
#include "musher/test/support/refusals.hpp"
#include "musher/transport/service.hpp"
#include "musher/transport/sim/network.hpp"
#include "musher/wire/battery_watch.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::actuator_messages_test {

using std::chrono::seconds;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// Counts callbacks; each ends on request.
class ManualWorker : public Worker {
 public:
  void Run(Work /*work*/, Done done) override {
    ++runs;
    done_ = std::move(done);
  }
  void End(Result<> result = Ok()) { std::exchange(done_, nullptr)(std::move(result)); }
  int runs = 0;

 private:
  Done done_;
};

class AnActuator : public ::testing::Test {
 protected:
  static constexpr const char* kName = "dog";
  static constexpr const char* kId = "id-1";
  static constexpr std::uint64_t kIncarnation = 7;

  AnActuator() {
    config_.name = kName;
    config_.hash = "00112233";
    ActuatorConfig audio;
    audio.name = "audio";
    for (const BuiltInState state : {kSetUp, kSelfCheck, kActive, kDeActive, kLowPower}) {
      audio.states.emplace_back(state);
      audio.times.push_back(Milliseconds(100));
      if (const auto rank = BuiltInRank(state)) config_.ranks[state] = *rank;
    }
    config_.actuators.push_back(audio);
    statuses_ = transport::MakeSubscription<msg::ActuatorStatus>(
                    *desk_, transport::ActuatorStatusTopic(""),
                    [this](const msg::ActuatorStatus& status, const transport::SampleInfo&) {
                      received_.push_back(status);
                      received_at_.push_back(network_.now());
                    },
                    transport::kLatchedFromManyQos)
                    .value();
    heartbeats_ = transport::MakeSubscription<msg::ActuatorHeartbeat>(
                      *desk_, transport::ActuatorHeartbeatTopic(""),
                      [this](const msg::ActuatorHeartbeat& heartbeat,
                             const transport::SampleInfo&) { shown_.push_back(heartbeat); },
                      transport::kHeartbeatQos)
                      .value();
  }

  static ActuatorIdentity Identity(const std::string& id = kId, const std::string& host = "host") {
    return {Incarnation(kIncarnation), 7, host, kName, id};
  }
  // Until its SetUp is done.
  void Begin(const ActuatorIdentity& identity = Identity()) {
    Make(identity);
    EndSetUp();
  }
  void Make(const ActuatorIdentity& identity = Identity()) {
    shell_ = ActuatorShell::Make(*node_, worker_, config_, 0, identity, hooks_).value();
    network_.RunFor(Milliseconds(500));  // the readers match
    shell_->Start();
  }
  void EndSetUp() {
    worker_.End();
    network_.RunFor(Milliseconds(500));
  }
  bool Until(const std::function<bool()>& holds, Duration limit = seconds(10)) {
    return network_.RunUntil(holds, network_.now() + limit);
  }
  const ActuatorReport& report() const { return shell_->report(); }
  const msg::ActuatorStatus& status() const { return received_.back(); }
  // The next heartbeat of the actuator.
  msg::ActuatorHeartbeat NextHeartbeat() {
    const std::size_t before = shown_.size();
    EXPECT_TRUE(Until([&] { return shown_.size() > before; }));
    return shown_.back();
  }
  void CommandAsManager(BuiltInState state) {
    if (!manager_) {
      manager_ = transport::MakeClient<msg::FsMachine>(*desk_, "audiomachine_service").value();
      ASSERT_TRUE(Until([&] { return manager_->Ready(); }));
    }
    msg::FsMachine::Request request;
    request.target_state = std::string(state.name());
    code_.reset();
    manager_->Call(request, seconds(1), [this](const auto& reply) {
      if (reply) code_ = reply.value().code;
    });
  }
  // Until its callback runs.
  void RunAsManager(BuiltInState state) {
    const int runs = worker_.runs;
    CommandAsManager(state);
    ASSERT_TRUE(Until([&] { return worker_.runs == runs + 1; }));
  }

  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> node_ = network_.MakeNode("dog");
  std::unique_ptr<transport::Node> desk_ = network_.MakeNode("desk");
  ManualWorker worker_;
  MachineConfig config_;
  ActuatorShell::Hooks hooks_;
  std::vector<msg::ActuatorStatus> received_;
  std::vector<Time> received_at_;
  std::vector<msg::ActuatorHeartbeat> shown_;
  std::optional<std::int32_t> code_;  // of the last reply to a manager
  std::unique_ptr<transport::Subscription> statuses_;
  std::unique_ptr<transport::Subscription> heartbeats_;
  std::unique_ptr<transport::Client<msg::FsMachine>> manager_;
  std::unique_ptr<ActuatorShell> shell_;
};

// --- permits ---

class APermit : public AnActuator {
 protected:
  static constexpr Duration kPeriod = Milliseconds(500);

  APermit() {
    config_.permit = kPeriod;
    permit_.participant = desk_->participant().value();
    permit_.machine = kName;
    permit_.machine_id = kId;
    permit_.by = "remote";
    Begin();
    Stamp();
  }
  void Stamp() { permit_.stamp_ns = transport::ToNanoseconds(network_.now()); }
  // Returns until when the actuator is permitted to move.
  Time Receive() {
    EXPECT_TRUE(permits_->Publish(permit_));
    network_.RunFor(Milliseconds(50));
    return shell_->core().permit.until;
  }

  msg::Permit permit_;
  std::unique_ptr<transport::Publisher<msg::Permit>> permits_ =
      transport::MakePublisher<msg::Permit>(*desk_, transport::PermitTopic(""),
                                            transport::kHeartbeatQos)
          .value();
};

TEST_F(APermit, OfItsMachineCountsAndNamesItsSender) {
  EXPECT_GT(Receive(), network_.now());
  EXPECT_EQ(shell_->core().permit.by, "remote");
}

TEST_F(APermit, ThatNamesNoMachineOrAnotherOneDoesNotCount) {
  permit_.machine.clear();
  permit_.machine_id.clear();
  EXPECT_EQ(Receive(), Time());
  permit_.machine = "cat";
  EXPECT_EQ(Receive(), Time());
  permit_.machine = kName;
  permit_.machine_id = "id-2";
  EXPECT_EQ(Receive(), Time()) << "of a robot with the same name";
}

TEST_F(APermit, ThatAnotherParticipantRepeatsDoesNotCount) {
  permit_.participant = node_->participant().value();
  EXPECT_EQ(Receive(), Time());
}

// It was given once: what repeats or delays it gives no more time.
TEST_F(APermit, ThatArrivesAgainLaterLastsNoLonger) {
  const Time until = Receive();
  network_.RunFor(Milliseconds(200));
  EXPECT_LT(Receive() - until, Milliseconds(20)) << "the network is not always as fast";
  Stamp();
  EXPECT_GT(Receive() - until, Milliseconds(200));
}

// --- heartbeats of controllers ---

class AControllersHeartbeat : public AnActuator {
 protected:
  AControllersHeartbeat() {
    hooks_.leads_here = [this](std::int32_t pid) {
      called_for_.push_back(pid);
      return pid == leads_here_;
    };
    heartbeat_.machine = "cat";
    heartbeat_.machine_id = "id-2";
    heartbeat_.epoch = 3;
    heartbeat_.pid = 42;
    heartbeat_.host = "host";
    heartbeat_.participant = desk_->participant().value();
  }
  bool Counts() {
    EXPECT_TRUE(controllers_->Publish(heartbeat_));
    network_.RunFor(Milliseconds(50));
    return !shell_->core().announced.empty();
  }

  std::int32_t leads_here_ = 42;
  std::vector<std::int32_t> called_for_;
  msg::ControllerHeartbeat heartbeat_;
  std::unique_ptr<transport::Publisher<msg::ControllerHeartbeat>> controllers_ =
      transport::MakePublisher<msg::ControllerHeartbeat>(
          *desk_, transport::ControllerHeartbeatTopic(""), transport::kLatchedQos)
          .value();
};

TEST_F(AControllersHeartbeat, OfItsMachineCountsFromAnyHost) {
  Begin();
  heartbeat_.machine = kName;
  heartbeat_.machine_id = kId;
  heartbeat_.host = "elsewhere";
  EXPECT_TRUE(Counts());
  EXPECT_THAT(called_for_, IsEmpty());
}

TEST_F(AControllersHeartbeat, ThatAnotherParticipantRepeatsDoesNotCount) {
  Begin();
  heartbeat_.machine = kName;
  heartbeat_.machine_id = kId;
  heartbeat_.participant = node_->participant().value();
  EXPECT_FALSE(Counts());
}

TEST_F(AControllersHeartbeat, OfAnotherMachineOnAnotherHostDoesNotCount) {
  Begin();
  heartbeat_.host = "elsewhere";
  EXPECT_FALSE(Counts());
  EXPECT_EQ(status().machine, kName);
}

TEST_F(AControllersHeartbeat, OfAnotherMachineDoesNotCountWhereBothHostsAreUnknown) {
  Begin(Identity(kId, ""));
  heartbeat_.host = "";
  EXPECT_FALSE(Counts());
}

TEST_F(AControllersHeartbeat, OfAnotherMachineDoesNotCountFromAProcessThatDoesNotLeadHere) {
  leads_here_ = 43;
  Begin();
  EXPECT_FALSE(Counts());
  EXPECT_THAT(called_for_, ::testing::Contains(42));
}

TEST_F(AControllersHeartbeat, OfAnotherMachineDoesNotCountWhereNothingKnowsWhichProcessLeads) {
  hooks_.leads_here = nullptr;
  Begin();
  EXPECT_FALSE(Counts());
}

// Its config has another name now, or its state folder was lost. The controller that was followed
// until then reads it in the status.
TEST_F(AControllersHeartbeat, FromTheProcessThatLeadsHereGivesTheActuatorItsMachine) {
  Begin();
  EXPECT_TRUE(Counts());
  EXPECT_EQ(status().machine, "cat");
  EXPECT_EQ(status().machine_id, "id-2");
}

// --- requests of a controller ---

// A process that announces itself as a controller, as long as it is not silent.
class Controller {
 public:
  Controller(transport::sim::Network& network, const std::string& host, std::uint64_t epoch)
      : network_(network), node_(network.MakeNode(host)) {
    heartbeat_.machine = "dog";
    heartbeat_.epoch = epoch;
    heartbeat_.participant = node_->participant().value();
    Announce();
    request.epoch = epoch;
    request.machine = "dog";
    request.machine_id = "id-1";
    request.incarnation = 7;
    request.kind = msg::ActuatorCommand::kKindQuery;
  }
  void Announce() {
    sending_ = node_->loop().Every(Milliseconds(500), [this] {
      EXPECT_TRUE(heartbeats_->Publish(heartbeat_));
      announced_at_ = network_.now();
    });
  }
  void FallSilent() { sending_ = nullptr; }
  void Send() {
    reply_.reset();
    client_->Call(request, seconds(5), [this](const auto& reply) {
      if (reply) reply_ = reply.value();
    });
  }
  msg::ActuatorCommand::Response Call() {
    EXPECT_TRUE(
        network_.RunUntil([this] { return client_->Ready(); }, network_.now() + seconds(5)));
    Send();
    return Reply();
  }
  msg::ActuatorCommand::Response Reply() {
    EXPECT_TRUE(
        network_.RunUntil([this] { return reply_.has_value(); }, network_.now() + seconds(5)));
    return reply_.value_or(msg::ActuatorCommand::Response());
  }
  Time announced_at() const { return announced_at_; }

  // A switch to that state, of the age 0 by the clock of the actuator.
  void Switch(std::uint64_t number, const std::string& target) {
    request.kind = msg::ActuatorCommand::kKindSwitch;
    request.number = number;
    request.target = target;
    request.budget_ns = Duration(seconds(2)).count();
    request.status_stamp_ns = transport::ToNanoseconds(network_.now());
    request.since_status_ns = 0;
  }
  void Query(std::uint64_t number, bool stop = false) {
    request.kind = msg::ActuatorCommand::kKindQuery;
    request.number = number;
    request.target.clear();
    request.stop = stop;
  }
  transport::Node& node() { return *node_; }

  msg::ActuatorCommand::Request request;

 private:
  transport::sim::Network& network_;
  std::unique_ptr<transport::Node> node_;
  msg::ControllerHeartbeat heartbeat_;
  std::unique_ptr<transport::Publisher<msg::ControllerHeartbeat>> heartbeats_ =
      transport::MakePublisher<msg::ControllerHeartbeat>(
          *node_, transport::ControllerHeartbeatTopic(""), transport::kLatchedQos)
          .value();
  std::unique_ptr<transport::Client<msg::ActuatorCommand>> client_ =
      transport::MakeClient<msg::ActuatorCommand>(*node_, transport::CommandService("", "audio"))
          .value();
  transport::LoopHandlePtr sending_;
  Time announced_at_{};  // last
  std::optional<msg::ActuatorCommand::Response> reply_;
};

class AControlled : public AnActuator {
 protected:
  AControlled() {
    hooks_.set_stop_requested = [this](bool requested) { stop_requested_ = requested; };
  }
  // Until the controller has control.
  void BeginControlled(const ActuatorIdentity& identity = Identity()) {
    Begin(identity);
    network_.RunFor(seconds(1));
    EXPECT_EQ(controller_.Call().verdict, msg::ActuatorCommand::kVerdictDone);
  }
  // Runs that switch to its end.
  void RunSwitch(std::uint64_t number, const std::string& target) {
    controller_.Switch(number, target);
    const int runs = worker_.runs;
    controller_.Send();
    ASSERT_TRUE(Until([&] { return worker_.runs == runs + 1; }));
    worker_.End();
    EXPECT_EQ(controller_.Reply().verdict, msg::ActuatorCommand::kVerdictDone);
  }
  void Release(std::uint64_t id, std::uint64_t last_command) {
    stops_ = transport::MakePublisher<msg::EmergencyStop>(
                 controller_.node(), transport::EmergencyStopTopic(""), transport::kLatchedQos)
                 .value();
    network_.RunFor(Milliseconds(500));
    msg::EmergencyStop stop;
    stop.id = id;
    stop.last_command = last_command;
    ASSERT_TRUE(stops_->Publish(stop));
    network_.RunFor(Milliseconds(500));
  }

  bool stop_requested_ = false;
  Controller controller_{network_, "brain", 1};
  std::unique_ptr<transport::Publisher<msg::EmergencyStop>> stops_;
};

TEST_F(AControlled, RefusesARequestThatIsMeantForAnotherMachine) {
  Begin();
  network_.RunFor(seconds(1));
  controller_.request.machine_id = "id-2";
  const auto reply = controller_.Call();
  EXPECT_EQ(reply.verdict, msg::ActuatorCommand::kVerdictRefused);
  EXPECT_EQ(reply.code, FormOf(Refusal::kOtherMachine).code);
  EXPECT_THAT(reply.message, HasSubstr("id-2"));
  EXPECT_EQ(report().epoch, Epoch(0));
}

TEST_F(AControlled, LearnsTheIdOfItsMachineFromTheControllerThatTakesControl) {
  BeginControlled(Identity(""));
  EXPECT_EQ(controller_.Call().status.machine_id, kId);
  controller_.request.machine_id.clear();
  controller_.Call();
  EXPECT_EQ(controller_.Call().status.machine_id, kId) << "it is learned once";
}

TEST_F(AControlled, LearnsNoIdFromAClientThatIsNotInControl) {
  Begin(Identity(""));
  Controller other(network_, "desk", 0);
  network_.RunFor(seconds(1));
  other.request.machine_id = "id-9";
  EXPECT_EQ(other.Call().verdict, msg::ActuatorCommand::kVerdictRefused);
  EXPECT_EQ(other.Call().status.machine_id, "");
  controller_.Call();
  EXPECT_EQ(controller_.Call().status.machine_id, kId);
}

TEST_F(AControlled, PassesTheStopOfAQueryToTheCallback) {
  BeginControlled();
  controller_.Switch(1, "Active");
  controller_.Send();
  ASSERT_TRUE(Until([&] { return worker_.runs == 2; }));
  controller_.Query(0);
  controller_.Call();
  EXPECT_FALSE(stop_requested_);
  controller_.Query(0, true);
  controller_.Call();
  EXPECT_TRUE(stop_requested_);
  worker_.End();
  network_.RunFor(seconds(1));
  controller_.Switch(2, "DeActive");
  controller_.Send();
  ASSERT_TRUE(Until([&] { return worker_.runs == 3; }));
  EXPECT_FALSE(stop_requested_) << "of the callback before";
}

TEST_F(AControlled, BeginsNoCommandWhoseNumberWasQueried) {
  BeginControlled();
  controller_.Query(5);
  controller_.Call();
  controller_.Switch(5, "Active");
  EXPECT_EQ(controller_.Call().code, FormOf(Refusal::kCommandOutdated).code);
  controller_.Switch(6, "Active");
  controller_.Send();
  EXPECT_TRUE(Until([&] { return worker_.runs == 2; }));
}

TEST_F(AControlled, BeginsNoCommandThatIsOlderThanItsBudget) {
  BeginControlled();
  controller_.Switch(1, "Active");
  controller_.request.status_stamp_ns -= Duration(seconds(3)).count();
  const auto late = controller_.Call();
  EXPECT_EQ(late.code, FormOf(Refusal::kCommandTooOld).code);
  EXPECT_THAT(late.message, HasSubstr("2000"));
  controller_.request.since_status_ns = Duration(Milliseconds(2500)).count();
  controller_.Send();
  EXPECT_TRUE(Until([&] { return worker_.runs == 2; })) << "it was sent half a second ago";
}

TEST_F(AControlled, ShowsWhichCommandDetachesItFromTheMachine) {
  BeginControlled();
  controller_.request.detached = true;
  RunSwitch(1, "LowPower");
  EXPECT_TRUE(report().detached);
  controller_.request.detached = false;
  RunSwitch(2, "DeActive");
  EXPECT_FALSE(report().detached);
}

TEST_F(AControlled, RefusesAStateOfAnyLengthWithAShortSentence) {
  BeginControlled();
  controller_.Switch(1, std::string(100'000, 'x'));
  const auto reply = controller_.Call();
  EXPECT_EQ(reply.code, FormOf(Refusal::kStateMissing).code);
  EXPECT_LT(reply.message.size(), 1000U);
}

TEST_F(AControlled, SwitchesNothingOnByACommandFromBeforeTheReleaseOfAStop) {
  BeginControlled();
  Release(5, 3);
  controller_.Switch(3, "Active");
  EXPECT_EQ(controller_.Call().code, FormOf(Refusal::kCommandBeforeRelease).code);
  controller_.Switch(4, "Active");
  controller_.Send();
  EXPECT_TRUE(Until([&] { return worker_.runs == 2; }));
}

TEST_F(AControlled, PublishesByWhomItIsStoppedAndWhy) {
  Begin();
  auto stops = transport::MakePublisher<msg::EmergencyStop>(
                   *desk_, transport::EmergencyStopTopic(""), transport::kLatchedQos)
                   .value();
  msg::EmergencyStop stop;
  stop.id = 5;
  stop.engaged = true;
  stop.by = "button";
  stop.reason = "a person is near";
  ASSERT_TRUE(stops->Publish(stop));
  network_.RunFor(seconds(1));
  EXPECT_EQ(status().emergency_stop_by, "button");
  EXPECT_EQ(status().emergency_stop_reason, "a person is near");
}

TEST_F(AControlled, AnswersWithTheCodeAndTheMessageOfACallbackThatFails) {
  BeginControlled();
  controller_.Switch(1, "Active");
  controller_.Send();
  ASSERT_TRUE(Until([&] { return worker_.runs == 2; }));
  worker_.End(Error{3009, "joint 7 is hot"});
  const auto reply = controller_.Reply();
  EXPECT_EQ(reply.verdict, msg::ActuatorCommand::kVerdictFailed);
  EXPECT_EQ(reply.code, 3009);
  EXPECT_EQ(reply.message, "joint 7 is hot");
}

TEST_F(AControlled, PublishesWhatASelfCheckReportsAsDegraded) {
  hooks_.take_degraded = [] { return Error{3010, "one lidar is dark"}; };
  BeginControlled();
  RunSwitch(1, "SelfCheck");
  network_.RunFor(seconds(1));
  EXPECT_EQ(status().degraded_code, 3010);
  EXPECT_EQ(status().degraded_reason, "one lidar is dark");
}

// --- its own heartbeats ---

TEST_F(AControlled, SaysInItsHeartbeatsThatItHasNoControllerOrHasLostIt) {
  controller_.FallSilent();
  Begin();
  network_.RunFor(seconds(3));
  EXPECT_TRUE(NextHeartbeat().controller_lost) << "it has none";
  controller_.Announce();
  network_.RunFor(seconds(1));
  controller_.Call();
  network_.RunFor(seconds(1));
  shown_.clear();
  network_.RunFor(seconds(10));
  EXPECT_THAT(shown_, ::testing::Each(::testing::Field(&msg::ActuatorHeartbeat::controller_lost,
                                                       ::testing::IsFalse())));
  EXPECT_GE(shown_.size(), 19U);

  const Controller standby(network_, "vision", 2);  // announces itself, and commands nothing
  controller_.FallSilent();
  network_.RunFor(controller_.announced_at() + Milliseconds(1400) - network_.now());
  EXPECT_FALSE(shown_.back().controller_lost) << "three heartbeats in a row have to be missing";
  network_.RunFor(Milliseconds(1300));
  EXPECT_TRUE(shown_.back().controller_lost);
}

class ACallbackThatHangs : public AnActuator {
 protected:
  // Begins Active right after a heartbeat, which comes every 500 ms.
  void BeginActive() {
    Begin();
    RunAsManager(kDeActive);
    worker_.End();
    network_.RunFor(Milliseconds(100));
    const std::size_t before = shown_.size();
    ASSERT_TRUE(Until([&] { return shown_.size() > before; }));
    RunAsManager(kActive);
    begun_ = network_.now();
    shown_.clear();
  }
  Time begun_{};
};

TEST_F(ACallbackThatHangs, IsPublishedAtOnceAndSoIsItsEnd) {
  config_.actuators[0].checkpoint_in[State(kActive)] = Milliseconds(200);
  ASSERT_NO_FATAL_FAILURE(BeginActive());
  const auto work_is = [this](std::uint8_t work) {
    return Until([&] { return !shown_.empty() && shown_.back().work == work; }, seconds(2));
  };
  ASSERT_TRUE(work_is(msg::ActuatorHeartbeat::kWorkHung));
  EXPECT_LT(network_.now() - begun_, Milliseconds(300));
  EXPECT_THAT(shown_, SizeIs(1));
  EXPECT_EQ(shown_[0].during, "Active");
  EXPECT_GT(Duration(shown_[0].silent_ns), Milliseconds(200));
  network_.RunFor(seconds(2));
  EXPECT_LE(shown_.size(), 6U) << "with the period, not with each check";
  worker_.End();
  const Time ended = network_.now();
  ASSERT_TRUE(work_is(msg::ActuatorHeartbeat::kWorkWell));
  EXPECT_LT(network_.now() - ended, Milliseconds(100));
  EXPECT_EQ(shown_.back().during, "");
}

TEST_F(ACallbackThatHangs, IsStarvedWhereItsProcessCouldNotRun) {
  config_.actuators[0].checkpoint_in[State(kActive)] = Milliseconds(200);
  ASSERT_NO_FATAL_FAILURE(BeginActive());
  network_.RunFor(Milliseconds(100));
  network_.Pause(*node_);
  network_.RunFor(seconds(2));
  network_.Resume(*node_);
  ASSERT_TRUE(Until([&] { return !shown_.empty(); }));
  EXPECT_EQ(shown_[0].work, msg::ActuatorHeartbeat::kWorkStarved);
  EXPECT_GT(Duration(shown_[0].waited_ns), seconds(1));
}

TEST_F(ACallbackThatHangs, IsNotCheckedLessOftenThanAHeartbeatIsDue) {
  config_.actuators[0].checkpoint_in[State(kActive)] = seconds(20);
  ASSERT_NO_FATAL_FAILURE(BeginActive());
  network_.RunFor(seconds(5));
  EXPECT_GE(shown_.size(), 9U);
}

// --- statuses ---

// While a callback follows the other, each change would begin the delay again.
TEST_F(AControlled, IsPublishedSoonAlsoWhereChangesFollowEachOther) {
  BeginControlled();
  network_.RunFor(seconds(1));
  received_.clear();
  received_at_.clear();
  const Time begun = network_.now();
  for (std::uint64_t number = 1; number <= 20; ++number) {
    RunSwitch(number, number % 2 == 0 ? "DeActive" : "LowPower");
    network_.RunFor(Milliseconds(10));
  }
  ASSERT_FALSE(received_at_.empty());
  EXPECT_LT(received_at_.front() - begun, Milliseconds(100));
}

// A receiver that knows the later one ignores the other.
TEST_F(AnActuator, IsPublishedWithALaterStampEachTime) {
  Begin();
  received_.clear();
  for (int i = 0; i < 3; ++i) shell_->ReportFault({3010, "fault " + std::to_string(i)});
  network_.RunFor(seconds(1));
  ASSERT_THAT(received_, SizeIs(3));
  EXPECT_LT(received_[0].stamp_ns, received_[1].stamp_ns);
  EXPECT_LT(received_[1].stamp_ns, received_[2].stamp_ns);
}

TEST_F(AnActuator, IsPublishedAtOnceWhereNoControllerControlsIt) {
  Begin();
  RunAsManager(kActive);
  received_.clear();
  const Time ended = network_.now();
  worker_.End();
  ASSERT_TRUE(Until([&] { return !received_.empty() && status().state == "Active"; }));
  EXPECT_LT(network_.now() - ended, Milliseconds(40));
}

TEST_F(AnActuator, PublishesTheHashOfItsConfigAndTheMachineOfItsController) {
  config_.name = "the name in the config";
  Begin();
  EXPECT_EQ(status().config_hash, "00112233");
  EXPECT_EQ(status().machine, kName);
}

TEST_F(AnActuator, PublishesTheNameOfItsConfigWhereNoControllerHasStartedIt) {
  Begin({Incarnation(kIncarnation), 7, "host"});
  EXPECT_EQ(status().machine, kName);
  EXPECT_EQ(status().machine_id, "");
}

TEST_F(AnActuator, IsTroubledOnlyWhileItIsStopped) {
  hooks_.stop_trouble = [] { return std::string("the brake closes"); };
  Begin();
  EXPECT_EQ(status().stop_trouble, "");
}

TEST_F(AnActuator, PublishesNothingWhereItsTroubleIsTheSame) {
  Begin();
  received_.clear();
  shell_->CompareStopTrouble();
  network_.RunFor(seconds(1));
  EXPECT_THAT(received_, IsEmpty());
}

TEST_F(AControlled, PublishesItsLastStatusBeforeItFinishes) {
  config_.actuators[0].states.emplace_back(kTearDown);
  config_.actuators[0].times.push_back(Milliseconds(100));
  std::optional<Error> end;
  hooks_.on_finished = [&](const Error& error) { end = error; };
  BeginControlled();
  controller_.Switch(1, "TearDown");
  controller_.Send();
  ASSERT_TRUE(Until([&] { return worker_.runs == 2; }));
  network_.RunFor(seconds(1));
  worker_.End();
  ASSERT_TRUE(Until([&] { return end.has_value(); }));
  EXPECT_EQ(end->code, kCodeOk);
  shell_.reset();
  network_.RunFor(seconds(1));
  EXPECT_EQ(status().state, "TearDown");
}

TEST_F(AnActuator, FinishesWithTheCodeOfASetUpThatFails) {
  std::optional<Error> end;
  hooks_.on_finished = [&](const Error& error) { end = error; };
  Make();
  worker_.End(Error{3001, "no device"});
  network_.RunFor(seconds(1));
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, 3001);
  EXPECT_EQ(end->message, "no device");
}

// --- at its end ---

// Its worker may be gone.
TEST_F(AControlled, GoesToNoSafeStateAfterItsShutdown) {
  config_.actuators[0].controller_lost = seconds(2);
  config_.actuators[0].on_controller_lost = State(kLowPower);
  BeginControlled();
  RunSwitch(1, "Active");
  shell_->Close();
  controller_.FallSilent();
  network_.RunFor(seconds(20));
  EXPECT_EQ(worker_.runs, 2);
}

// --- managers of ROS 2 ---

class AManagedNode : public AControlled {
 protected:
  static constexpr std::uint8_t kConfigure = 1;
  static constexpr std::uint8_t kActivate = 3;
  static constexpr std::uint8_t kShutdownUnconfigured = 5;
  static constexpr std::uint8_t kIsActive = 3;

  AManagedNode() {
    controller_.FallSilent();
    hooks_.ros2 = ActuatorShell::Hooks::Ros2::kManagedNode;
    hooks_.on_remark = [this](const std::string& line) { remarks_.push_back(line); };
    hooks_.on_finished = [this](const Error&) { finished_at_ = network_.now(); };
  }
  void AddTearDown() {
    config_.actuators[0].states.emplace_back(kTearDown);
    config_.actuators[0].times.push_back(Milliseconds(100));
  }
  void Change(std::uint8_t transition) {
    ASSERT_TRUE(Until([&] { return change_->Ready(); }));
    done_.reset();
    change_->Call({{transition, ""}}, seconds(5),
                  [this](const auto& reply) { done_ = reply && reply.value().success; });
  }
  // Its callback runs, until the caller ends it.
  void BeginChange(std::uint8_t transition) {
    const int runs = worker_.runs;
    ASSERT_NO_FATAL_FAILURE(Change(transition));
    ASSERT_TRUE(Until([&] { return worker_.runs == runs + 1; }));
  }
  int StateOfNode() {
    std::optional<int> state;
    EXPECT_TRUE(Until([&] { return get_->Ready(); }));
    get_->Call({}, seconds(5), [&state](const auto& reply) {
      state = reply ? reply.value().current_state.id : -1;
    });
    EXPECT_TRUE(Until([&] { return state.has_value(); }));
    return state.value_or(-1);
  }
  void ShutDown() {
    AddTearDown();
    Begin();
    ASSERT_NO_FATAL_FAILURE(BeginChange(kShutdownUnconfigured));
    worker_.End();
    ended_at_ = network_.now();
  }
  bool IsFinished() const { return finished_at_.has_value(); }

  std::vector<std::string> remarks_;
  std::optional<bool> done_;
  std::optional<Time> finished_at_;
  Time ended_at_{};
  std::unique_ptr<transport::Client<msg::ChangeState>> change_ =
      transport::MakeClient<msg::ChangeState>(*desk_, "audio/change_state").value();
  std::unique_ptr<transport::Client<msg::GetState>> get_ =
      transport::MakeClient<msg::GetState>(*desk_, "audio/get_state").value();
};

TEST_F(AManagedNode, IsOfferedAfterTheStartOfTheRobotWhereAControllerIsThere) {
  controller_.Announce();
  network_.RunFor(seconds(1));
  Make();
  network_.RunFor(seconds(1));
  EndSetUp();
  network_.RunFor(Milliseconds(1200));
  EXPECT_FALSE(change_->Ready()) << "the endpoints that the controller needs are first";
  network_.RunFor(seconds(2));
  EXPECT_TRUE(change_->Ready());
}

TEST_F(AManagedNode, ShowsTheStateInWhichItIsOfferedAndEachLaterOne) {
  controller_.Announce();
  network_.RunFor(seconds(1));
  Make();
  network_.RunFor(seconds(1));
  EndSetUp();
  controller_.FallSilent();  // nothing happens after the callback
  RunAsManager(kActive);
  worker_.End();
  EXPECT_EQ(StateOfNode(), kIsActive);
  RunAsManager(kDeActive);
  worker_.End();
  ASSERT_TRUE(Until([&] { return code_.has_value(); }));
  EXPECT_NE(StateOfNode(), kIsActive);
}

TEST_F(AManagedNode, IsNotSwitchedByAManagerWhileAControllerControlsIt) {
  controller_.Announce();
  BeginControlled();
  ASSERT_NO_FATAL_FAILURE(Change(kConfigure));
  ASSERT_TRUE(Until([&] { return done_.has_value(); }));
  EXPECT_FALSE(*done_);
  EXPECT_THAT(remarks_, ::testing::Contains(testing::HasRefusal(Refusal::kUnderControl)));
  EXPECT_EQ(worker_.runs, 1);
}

TEST_F(AManagedNode, IsAtOnceInAStateWithoutACallback) {
  Begin();  // it has no TearDown
  ASSERT_NO_FATAL_FAILURE(Change(kShutdownUnconfigured));
  ASSERT_TRUE(Until([&] { return done_.has_value(); }));
  EXPECT_TRUE(*done_);
  EXPECT_EQ(worker_.runs, 1);
}

TEST_F(AManagedNode, NamesACallbackThatFailsWithoutAWord) {
  Begin();
  ASSERT_NO_FATAL_FAILURE(BeginChange(kConfigure));
  worker_.End(Error{3009, ""});
  ASSERT_TRUE(Until([&] { return done_.has_value(); }));
  EXPECT_FALSE(*done_);
  EXPECT_THAT(remarks_, ::testing::Contains(HasSubstr("its callback failed")));
}

// A manager of ROS 2 queries each node once more after it has shut it down.
TEST_F(AManagedNode, ThatAManagerEndsWaitsForItsLastQuery) {
  ASSERT_NO_FATAL_FAILURE(ShutDown());
  ASSERT_TRUE(Until([&] { return done_ == true; }));
  network_.RunFor(Milliseconds(500));
  EXPECT_FALSE(IsFinished());
  StateOfNode();
  EXPECT_TRUE(Until([&] { return IsFinished(); }, Milliseconds(50)));
}

TEST_F(AManagedNode, ThatAManagerEndsWaitsASecondForItsLastQuery) {
  ASSERT_NO_FATAL_FAILURE(ShutDown());
  ASSERT_TRUE(Until([&] { return IsFinished(); }));
  EXPECT_GE(*finished_at_ - ended_at_, seconds(1));
  EXPECT_LT(*finished_at_ - ended_at_, Milliseconds(1100));
}

TEST_F(AManagedNode, WaitsForNoQueryWhereNoManagerOfRos2HasEndedIt) {
  AddTearDown();
  Begin();
  ASSERT_TRUE(Until([&] { return change_->Ready(); }));
  RunAsManager(kTearDown);
  worker_.End();
  EXPECT_TRUE(Until([&] { return IsFinished(); }, Milliseconds(50)));
}

// --- the battery ---

class ABatteryOf : public AnActuator {
 protected:
  // How often the actuator learns of a level, with that capability.
  int Levels(const std::string& actuator, std::optional<int> min_battery) {
    int levels = 0;
    hooks_.on_battery = [&levels](std::optional<int> percent) { levels += percent ? 1 : 0; };
    config_.capabilities.push_back({"speak", "", {actuator}, {State(kActive)}, min_battery});
    auto battery =
        transport::MakePublisher<msg::BmsStatus>(*desk_, transport::BatteryTopic(config_)).value();
    Begin();
    msg::BmsStatus status;
    status.batt_soc = 50;
    for (int i = 0; i < 20; ++i) {
      EXPECT_TRUE(battery->Publish(status));
      network_.RunFor(Milliseconds(500));
    }
    shell_.reset();
    return levels;
  }
};

TEST_F(ABatteryOf, ACapabilityOfTheActuatorIsWatched) {
  EXPECT_GT(Levels("audio", 30), 0);
}

TEST_F(ABatteryOf, ACapabilityWithoutALeastLevelIsNotWatched) {
  EXPECT_EQ(Levels("audio", std::nullopt), 0);
}

TEST_F(ABatteryOf, ACapabilityOfAnotherActuatorIsNotWatched) {
  EXPECT_EQ(Levels("arm", 30), 0);
}

// --- managers without epochs ---

TEST_F(AnActuator, LeadsDownByAManagersCommandThatMayBeLate) {
  Begin();
  RunAsManager(kActive);
  worker_.End();
  ASSERT_TRUE(Until([&] { return code_.has_value(); }));
  network_.Pause(*node_);
  network_.RunFor(seconds(20));
  network_.Resume(*node_);
  CommandAsManager(kActive);  // the present state: it would be switched on again
  ASSERT_TRUE(Until([&] { return code_.has_value(); }));
  EXPECT_EQ(*code_, FormOf(Refusal::kActuatorMayBeLate).code);
  RunAsManager(kLowPower);
}

TEST_F(AnActuator, RefusesALateCommandOfAManagerFromBelowDeActive) {
  Begin();
  RunAsManager(kLowPower);
  worker_.End();
  ASSERT_TRUE(Until([&] { return code_.has_value(); }));
  network_.Pause(*node_);
  network_.RunFor(seconds(20));
  network_.Resume(*node_);
  CommandAsManager(kDeActive);
  ASSERT_TRUE(Until([&] { return code_.has_value(); }));
  EXPECT_EQ(*code_, FormOf(Refusal::kActuatorMayBeLate).code);
}

TEST_F(AnActuator, RefusesAStateThatItDoesNotHaveWithTheCodeThatCyberDogExpects) {
  Begin();
  CommandAsManager(kProtected);
  ASSERT_TRUE(Until([&] { return code_.has_value(); }));
  EXPECT_EQ(*code_, static_cast<std::int32_t>(KeyCode::kUnSupport));
}

TEST_F(AnActuator, SendsHeartbeatsToCyberDogsManagerWhileThereIsOne) {
  Begin();
  int written = 0;
  network_.on_write = [&](transport::ParticipantId, const std::string& topic, const msg::Bytes&) {
    if (topic.ends_with("manager_heartbeats")) ++written;
  };
  network_.RunFor(seconds(5));
  EXPECT_EQ(written, 0);
  std::vector<std::string> names;
  auto reader = transport::MakeSubscription<msg::Heartbeats>(
                    *desk_, "manager_heartbeats",
                    [&](const msg::Heartbeats& heartbeat, const transport::SampleInfo&) {
                      names.push_back(heartbeat.name);
                    },
                    transport::kSystemDefaultQos)
                    .value();
  network_.RunFor(seconds(5));
  EXPECT_GE(names.size(), 8U);
  EXPECT_THAT(names, ::testing::Each("audio"));
  reader.reset();
  network_.RunFor(seconds(1));
  written = 0;
  network_.RunFor(seconds(5));
  EXPECT_EQ(written, 0);
}

}  // namespace musher::actuator_messages_test
