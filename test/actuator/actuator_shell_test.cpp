// The shell of an actuator at its end, on the simulated network.

#include "musher/actuator/actuator_shell.hpp"

#include <gtest/gtest.h>

#include "musher/messages/protocol/fs_machine.hpp"
#include "musher/transport/service.hpp"
#include "musher/transport/sim/network.hpp"

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

}  // namespace musher::actuator_shell_test
