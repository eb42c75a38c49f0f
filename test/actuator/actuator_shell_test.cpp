// The shell of an actuator at its end, on the simulated network.

#include "musher/actuator/actuator_shell.hpp"

#include <gmock/gmock.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/break_watch.hpp"
#include "musher/lifecycle/refusal.hpp"
#include "musher/messages/lifecycle_msgs/services.hpp"
#include "musher/messages/protocol/fs_machine.hpp"
#include "musher/test/support/refusals.hpp"
#include "musher/transport/service.hpp"
#include "musher/transport/sim/network.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::actuator_shell_test {

// Counts callbacks; each ends with success on request.
class CountingWorker : public Worker {
 public:
  void Run(Work /*work*/, Done done) override {
    ++runs;
    done_ = std::move(done);
  }
  void End() { std::exchange(done_, nullptr)(Ok()); }
  int runs = 0;

 private:
  Done done_;
};

MachineConfig OneActuatorConfig() {
  MachineConfig config;
  ActuatorConfig audio;
  audio.name = "audio";
  for (const BuiltInState state : {kSetUp, kActive}) {
    audio.states.emplace_back(state);
    audio.times.push_back(Milliseconds(100));
  }
  config.actuators.push_back(audio);
  return config;
}

// Shutdown() drops the worker while the loop still serves commands.
TEST(ActuatorShell, ACommandThatArrivesDuringItsShutdownBeginsNoCallback) {
  transport::sim::Network network(1);
  const auto node = network.MakeNode("dog");
  const auto other = network.MakeNode("desk");
  CountingWorker worker;
  const MachineConfig config = OneActuatorConfig();
  auto shell = ActuatorShell::Make(*node, worker, config, 0, {7, 7, "dog"}, {}).value();
  shell->Start();
  worker.End();
  auto client = transport::MakeClient<msg::FsMachine>(*other, "audiomachine_service").value();
  const auto deadline = [&] { return network.now() + std::chrono::seconds(1); };
  ASSERT_TRUE(network.RunUntil([&] { return client->Ready(); }, deadline()));
  msg::FsMachine::Request request;
  request.target_state = "Active";
  client->Call(request, std::chrono::seconds(1), [](const auto&) {});
  shell->Close();
  network.RunFor(std::chrono::seconds(2));
  EXPECT_EQ(worker.runs, 1) << "SetUp only";
}

// Its manager had given up long before.
TEST(ActuatorShell, AManagersCommandThatWaitedWhileItsProcessWasStoppedSwitchesNothingOn) {
  transport::sim::Network network(1);
  const auto node = network.MakeNode("dog");
  const auto other = network.MakeNode("desk");
  CountingWorker worker;
  MachineConfig config = OneActuatorConfig();
  for (const BuiltInState state : {kDeActive, kActive}) {
    config.ranks.emplace(state, *BuiltInRank(state));
  }
  auto shell = ActuatorShell::Make(*node, worker, config, 0, {7, 7, "dog"}, {}).value();
  shell->Start();
  worker.End();
  auto client = transport::MakeClient<msg::FsMachine>(*other, "audiomachine_service").value();
  const auto deadline = [&] { return network.now() + std::chrono::seconds(3); };
  ASSERT_TRUE(network.RunUntil([&] { return client->Ready(); }, deadline()));
  msg::FsMachine::Request request;
  request.target_state = "Active";
  network.Pause(*node);
  client->Call(request, std::chrono::seconds(1), [](const auto&) {});
  network.RunFor(std::chrono::seconds(20));
  network.Resume(*node);
  std::optional<std::int32_t> code;
  client->Call(request, std::chrono::seconds(1),
               [&](const auto& reply) { code = reply ? reply.value().code : kCodeNetError; });
  ASSERT_TRUE(network.RunUntil([&] { return code.has_value(); }, deadline()));
  EXPECT_EQ(*code, FormOf(Refusal::kActuatorMayBeLate).code);
  EXPECT_EQ(worker.runs, 1) << "SetUp only";
  network.RunFor(std::chrono::seconds(2));
  client->Call(request, std::chrono::seconds(1), [](const auto&) {});
  EXPECT_TRUE(network.RunUntil([&] { return worker.runs == 2; }, deadline()));
}

// The same of a manager of ROS 2, whose transitions carry no age either.
TEST(ActuatorShell, ATransitionThatWaitedWhileItsProcessWasStoppedSwitchesNothingOn) {
  constexpr std::uint8_t kConfigure = 1;
  constexpr std::uint8_t kActivate = 3;
  transport::sim::Network network(1);
  const auto node = network.MakeNode("dog");
  const auto other = network.MakeNode("desk");
  CountingWorker worker;
  MachineConfig config;
  ActuatorConfig audio;
  audio.name = "audio";
  for (const BuiltInState state : {kSetUp, kSelfCheck, kActive, kDeActive}) {
    audio.states.emplace_back(state);
    audio.times.push_back(Milliseconds(100));
    if (const auto rank = BuiltInRank(state)) config.ranks[state] = *rank;
  }
  config.actuators.push_back(audio);
  std::vector<std::string> remarks;
  ActuatorShell::Hooks hooks;
  hooks.ros2 = ActuatorShell::Hooks::Ros2::kManagedNode;
  hooks.on_remark = [&remarks](const std::string& line) { remarks.push_back(line); };
  auto shell = ActuatorShell::Make(*node, worker, config, 0, {7, 7, "dog"}, hooks).value();
  shell->Start();
  worker.End();
  auto client = transport::MakeClient<msg::ChangeState>(*other, "audio/change_state").value();
  const auto until = [&network](const std::function<bool()>& holds) {
    return network.RunUntil(holds, network.now() + std::chrono::seconds(3));
  };
  ASSERT_TRUE(until([&] { return client->Ready(); }));
  std::optional<bool> done;
  const auto request = [&](std::uint8_t transition) {
    done.reset();
    client->Call({{transition, ""}}, std::chrono::seconds(1),
                 [&done](const auto& reply) { done = reply && reply.value().success; });
  };
  request(kConfigure);
  ASSERT_TRUE(until([&] { return worker.runs == 2; }));
  worker.End();
  ASSERT_TRUE(until([&] { return done == true; }));

  network.Pause(*node);
  request(kActivate);
  network.RunFor(std::chrono::seconds(20));
  network.Resume(*node);
  network.RunFor(Milliseconds(500));
  EXPECT_THAT(remarks, ::testing::Contains(testing::HasRefusal(Refusal::kActuatorMayBeLate)));
  EXPECT_THAT(remarks, ::testing::Contains(::testing::HasSubstr("could not run for 20 s")));
  EXPECT_EQ(worker.runs, 2) << "SetUp and SelfCheck only";
  network.RunFor(std::chrono::seconds(2));
  request(kActivate);
  EXPECT_TRUE(until([&] { return worker.runs == 3; })) << "it is a new one";
}

// The first configure of a manager was refused after a stall at boot, from before its service.
TEST(ActuatorShell, AManagersCommandIsNotLateByAStallFromBeforeItsService) {
  transport::sim::Network network(1);
  const auto node = network.MakeNode("dog");
  const auto other = network.MakeNode("desk");
  CountingWorker worker;
  MachineConfig config = OneActuatorConfig();
  for (const BuiltInState state : {kDeActive, kActive}) {
    config.ranks.emplace(state, *BuiltInRank(state));
  }
  auto shell = ActuatorShell::Make(*node, worker, config, 0, {7, 7, "dog"}, {}).value();
  shell->Start();
  auto client = transport::MakeClient<msg::FsMachine>(*other, "audiomachine_service").value();
  network.RunFor(std::chrono::seconds(1));
  network.Pause(*node);
  worker.End();
  network.RunFor(std::chrono::seconds(20));
  network.Resume(*node);
  const Time resumed = network.now();
  const auto deadline = [&] { return network.now() + std::chrono::seconds(3); };
  ASSERT_TRUE(network.RunUntil([&] { return client->Ready(); }, deadline()));
  ASSERT_LT(network.now() - resumed, BreakWatch::kArriveWithin);
  msg::FsMachine::Request request;
  request.target_state = "Active";
  client->Call(request, std::chrono::seconds(1), [](const auto&) {});
  EXPECT_TRUE(network.RunUntil([&] { return worker.runs == 2; }, deadline()));
}

// An actuator whose Shutdown() waits for the callback of Active, which may move the robot.
class AShutdown : public ::testing::Test {
 protected:
  void Begin() {
    ActuatorShell::Hooks hooks;
    hooks.on_emergency_stop = [this] { ++stopped_; };
    shell_ = ActuatorShell::Make(*node_, worker_, config_, 0, {7, 7, "dog"}, hooks).value();
    shell_->Start();
    worker_.End();
    client_ = transport::MakeClient<msg::FsMachine>(*other_, "audiomachine_service").value();
    const auto deadline = [&] { return network_.now() + std::chrono::seconds(3); };
    ASSERT_TRUE(network_.RunUntil([&] { return client_->Ready(); }, deadline()));
    network_.RunFor(Milliseconds(500));  // permits arrive
    msg::FsMachine::Request request;
    request.target_state = "Active";
    client_->Call(request, std::chrono::seconds(1), [](const auto&) {});
    ASSERT_TRUE(network_.RunUntil([&] { return worker_.runs == 2; }, deadline()));
    shell_->Close();
  }

  // The end of the callback is the second stop: it may have switched on again.
  void ExpectASecondStopAtTheEnd() {
    EXPECT_EQ(stopped_, 1);
    worker_.End();
    network_.RunFor(std::chrono::seconds(1));
    EXPECT_EQ(stopped_, 2);
    EXPECT_EQ(worker_.runs, 2) << "nothing begins";
  }

  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> node_ = network_.MakeNode("dog");
  std::unique_ptr<transport::Node> other_ = network_.MakeNode("desk");
  CountingWorker worker_;
  MachineConfig config_ = OneActuatorConfig();
  int stopped_ = 0;
  std::unique_ptr<transport::Client<msg::FsMachine>> client_;
  std::unique_ptr<ActuatorShell> shell_;
};

TEST_F(AShutdown, IsInterruptedByAnEmergencyStop) {
  Begin();
  auto stops = transport::MakePublisher<msg::EmergencyStop>(
                   *other_, transport::EmergencyStopTopic(""), transport::kLatchedQos)
                   .value();
  msg::EmergencyStop stop;
  stop.id = 5;
  stop.engaged = true;
  ASSERT_TRUE(stops->Publish(stop));
  network_.RunFor(std::chrono::seconds(1));
  EXPECT_EQ(shell_->report().emergency_stop, StopId(5));
  ExpectASecondStopAtTheEnd();
}

// Two robots in range share the topics of one namespace.
TEST(ActuatorShell, AStopOfAnotherMachineDoesNotStopIt) {
  transport::sim::Network network(1);
  const auto node = network.MakeNode("dog");
  const auto other = network.MakeNode("desk");
  CountingWorker worker;
  MachineConfig config = OneActuatorConfig();
  config.name = "dog";
  auto shell =
      ActuatorShell::Make(*node, worker, config, 0, {7, 7, "host", "dog", "id-1"}, {}).value();
  shell->Start();
  auto stops = transport::MakePublisher<msg::EmergencyStop>(
                   *other, transport::EmergencyStopTopic(""), transport::kLatchedQos)
                   .value();
  const auto engage = [&](std::uint64_t id, const std::string& machine, const std::string& its_id) {
    msg::EmergencyStop stop;
    stop.id = id;
    stop.engaged = true;
    stop.machine = machine;
    stop.machine_id = its_id;
    ASSERT_TRUE(stops->Publish(stop));
    network.RunFor(std::chrono::seconds(1));
  };
  engage(5, "cat", "");
  EXPECT_EQ(shell->report().emergency_stop, StopId(0)) << "of another name";
  engage(6, "dog", "id-2");
  EXPECT_EQ(shell->report().emergency_stop, StopId(0)) << "of a robot with the same name";
  engage(7, "dog", "id-1");
  EXPECT_EQ(shell->report().emergency_stop, StopId(7)) << "its own";
}

TEST_F(AShutdown, IsInterruptedWhenThePermitsEnd) {
  config_.name = "dog";
  config_.permit = Milliseconds(500);
  for (const BuiltInState state : {kDeActive, kActive}) {
    config_.ranks.emplace(state, *BuiltInRank(state));
  }
  auto permits = transport::MakePublisher<msg::Permit>(*other_, transport::PermitTopic(""),
                                                       transport::kHeartbeatQos)
                     .value();
  auto sending = other_->loop().Every(Milliseconds(100), [&] {
    msg::Permit permit;
    permit.participant = other_->participant().value();
    permit.machine = "dog";
    permit.stamp_ns = Duration(network_.now().time_since_epoch()).count();
    static_cast<void>(permits->Publish(permit));
  });
  network_.RunFor(std::chrono::seconds(1));
  Begin();
  network_.RunFor(std::chrono::seconds(2));
  EXPECT_EQ(stopped_, 0) << "permitted";
  sending = nullptr;
  network_.RunFor(std::chrono::seconds(1));
  ExpectASecondStopAtTheEnd();
}

constexpr const char* kActiveRuns = "its callback for Active still runs and may switch on again";

// An emergency stop that is engaged while a callback runs.
class AStopBesideACallback : public ::testing::Test {
 protected:
  AStopBesideACallback() {
    ActuatorShell::Hooks hooks;
    hooks.on_emergency_stop = [this] {
      if (++stopped_ == 2) trouble_ = trouble_of_second_;
    };
    hooks.stop_trouble = [this] { return trouble_; };
    hooks.set_stop_requested = [this](bool requested) { stop_requested_ = requested; };
    shell_ = ActuatorShell::Make(*node_, worker_, config_, 0, {7, 7, "dog"}, hooks).value();
    statuses_ = transport::MakeSubscription<msg::ActuatorStatus>(
                    *other_, transport::ActuatorStatusTopic(""),
                    [this](const msg::ActuatorStatus& status, const transport::SampleInfo&) {
                      status_ = status;
                      confirmed_ |= status.emergency_stop != 0 && status.stop_trouble.empty();
                    },
                    transport::kLatchedFromManyQos)
                    .value();
    stops_ = transport::MakePublisher<msg::EmergencyStop>(
                 *other_, transport::EmergencyStopTopic(""), transport::kLatchedQos)
                 .value();
    manager_ = transport::MakeClient<msg::FsMachine>(*other_, "audiomachine_service").value();
    shell_->Start();
  }

  // Its states have the ranks of a real config.
  static MachineConfig Config() {
    MachineConfig config;
    ActuatorConfig audio;
    audio.name = "audio";
    for (const BuiltInState state : {kSetUp, kSelfCheck, kActive, kDeActive, kLowPower}) {
      audio.states.emplace_back(state);
      audio.times.push_back(Milliseconds(100));
      if (const auto rank = BuiltInRank(state)) config.ranks[state] = *rank;
    }
    config.actuators.push_back(audio);
    return config;
  }

  bool Until(const std::function<bool()>& holds) {
    return network_.RunUntil(holds, network_.now() + std::chrono::seconds(3));
  }
  void EndSetUp() {
    worker_.End();
    ASSERT_TRUE(Until([&] { return manager_->Ready(); }));
  }
  // Until its callback runs.
  void Begin(BuiltInState state) {
    msg::FsMachine::Request request;
    request.target_state = std::string(state.name());
    manager_->Call(request, std::chrono::seconds(1), [](const auto&) {});
    ASSERT_TRUE(Until([&, runs = worker_.runs] { return worker_.runs == runs + 1; }));
  }
  // Until its status arrives.
  void Engage() {
    msg::EmergencyStop stop;
    stop.id = 5;
    stop.engaged = true;
    ASSERT_TRUE(stops_->Publish(stop));
    ASSERT_TRUE(Until([&] { return status_.emergency_stop == 5; }));
    EXPECT_EQ(stopped_, 1) << "at once";
  }
  void ExpectConfirmedAfterASecondStop() {
    worker_.End();
    EXPECT_TRUE(Until([&] { return confirmed_; })) << status_.stop_trouble;
    EXPECT_EQ(stopped_, 2);
  }

  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> node_ = network_.MakeNode("dog");
  std::unique_ptr<transport::Node> other_ = network_.MakeNode("desk");
  CountingWorker worker_;
  const MachineConfig config_ = Config();
  int stopped_ = 0;
  bool stop_requested_ = false;
  bool confirmed_ = false;  // by any status
  std::string trouble_;     // of the stop action
  std::string trouble_of_second_;
  msg::ActuatorStatus status_;
  std::unique_ptr<ActuatorShell> shell_;
  std::unique_ptr<transport::Subscription> statuses_;
  std::unique_ptr<transport::Publisher<msg::EmergencyStop>> stops_;
  std::unique_ptr<transport::Client<msg::FsMachine>> manager_;
};

// It was "stopped", and its callback switched the motors on after that.
TEST_F(AStopBesideACallback, IsNotConfirmedWhileTheCallbackMaySwitchOn) {
  EndSetUp();
  Begin(kActive);
  Engage();
  EXPECT_TRUE(stop_requested_);
  network_.RunFor(std::chrono::minutes(5));
  EXPECT_EQ(status_.stop_trouble, kActiveRuns);
  EXPECT_FALSE(confirmed_);
  EXPECT_EQ(stopped_, 1);
  ExpectConfirmedAfterASecondStop();
}

TEST_F(AStopBesideACallback, IsNotConfirmedBeforeItsActionHasRunAgain) {
  EndSetUp();
  Begin(kActive);
  Engage();
  trouble_of_second_ = "the brake closes again";
  worker_.End();
  EXPECT_TRUE(Until([&] { return status_.stop_trouble == trouble_of_second_; }));
  network_.RunFor(std::chrono::seconds(1));
  EXPECT_FALSE(confirmed_);
  trouble_ = "";
  shell_->CompareStopTrouble();
  EXPECT_TRUE(Until([&] { return confirmed_; })) << status_.stop_trouble;
}

TEST_F(AStopBesideACallback, IsConfirmedAtOnceBesideACallbackThatLeadsDown) {
  EndSetUp();
  Begin(kActive);
  worker_.End();
  network_.RunFor(Milliseconds(100));
  Begin(kLowPower);
  Engage();
  EXPECT_TRUE(confirmed_) << status_.stop_trouble;
  worker_.End();
  network_.RunFor(std::chrono::seconds(1));
  EXPECT_EQ(status_.stop_trouble, "");
}

// Neither moves the robot: both also begin during a stop.
TEST_F(AStopBesideACallback, IsConfirmedAtOnceBesideSetUp) {
  Engage();
  EXPECT_TRUE(confirmed_) << status_.stop_trouble;
}

TEST_F(AStopBesideACallback, IsConfirmedAtOnceBesideASelfCheck) {
  EndSetUp();
  Begin(kSelfCheck);
  Engage();
  EXPECT_TRUE(confirmed_) << status_.stop_trouble;
}

TEST_F(AStopBesideACallback, NamesFirstWhatTheStopActionHasNotDone) {
  EndSetUp();
  Begin(kActive);
  trouble_ = "the brake closes";
  Engage();
  EXPECT_EQ(status_.stop_trouble, "the brake closes");
  trouble_ = "";
  shell_->CompareStopTrouble();
  EXPECT_TRUE(Until([&] { return status_.stop_trouble == kActiveRuns; })) << status_.stop_trouble;
  EXPECT_FALSE(confirmed_);
}

TEST_F(AStopBesideACallback, IsConfirmedAtTheEndOfTheCallbackAlsoInAShutdown) {
  EndSetUp();
  Begin(kActive);
  shell_->Close();
  Engage();
  EXPECT_EQ(status_.stop_trouble, kActiveRuns);
  ExpectConfirmedAfterASecondStop();
}

// The reply had the new status, so the change was taken for a published one.
TEST_F(AStopBesideACallback, IsConfirmedThoughAReplyHasReportedTheEndOfItsTroubleBefore) {
  EndSetUp();
  trouble_ = "the brake closes";
  Engage();
  auto client =
      transport::MakeClient<msg::ActuatorCommand>(*other_, transport::CommandService("", "audio"))
          .value();
  ASSERT_TRUE(Until([&] { return client->Ready(); }));
  trouble_ = "";
  msg::ActuatorCommand::Request request;
  request.kind = 99;  // none: refused
  std::optional<std::string> replied;
  client->Call(request, std::chrono::seconds(1), [&](const auto& reply) {
    replied = reply ? reply.value().status.stop_trouble : "no reply";
  });
  ASSERT_TRUE(Until([&] { return replied.has_value(); }));
  EXPECT_EQ(*replied, "");
  EXPECT_FALSE(confirmed_);
  shell_->CompareStopTrouble();
  EXPECT_TRUE(Until([&] { return confirmed_; })) << status_.stop_trouble;
}

}  // namespace musher::actuator_shell_test
