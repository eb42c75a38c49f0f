// The shell of an actuator at its end, on the simulated network.

#include "musher/actuator/actuator_shell.hpp"

#include <gtest/gtest.h>

#include "musher/messages/protocol/fs_machine.hpp"
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

}  // namespace musher::actuator_shell_test
