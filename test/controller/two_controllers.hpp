#pragma once
// Two controllers of one machine on hosts of their own, in virtual time, which live on whatever
// becomes of them, and a client's node on a third host.

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/simulation/simulated_controller.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::testing {

class TwoControllers : public ::testing::Test {
 protected:
  static constexpr Duration kEnough = std::chrono::seconds(30);

  struct Controller {
    simulation::Disk disk;
    std::unique_ptr<simulation::SimulatedController> process;
    const Machine& machine() const { return process->shell().machine(); }
  };

  TwoControllers()
      : network_(1),
        config_(Robot()),
        hosts_(network_, layout_.hosts),
        processes_(network_, config_, hosts_, layout_) {
    processes_.make_module = [this](const std::string&) {
      return std::make_unique<Timed>(callback_takes_);
    };
    processes_.on_end = [this](std::size_t host, std::int32_t pid, const ProcessExit& exit) {
      for (Controller* controller : {&first_, &second_}) {
        if (controller->process) controller->process->OnEnd(host, pid, exit);
      }
    };
    desk_ = network_.MakeNode("desk");
  }
  ~TwoControllers() override { processes_.on_end = {}; }

  // `disk`: of the other one, where both are of one host.
  void Open(Controller& controller, const std::string& endpoint, simulation::Disk* disk = nullptr) {
    simulation::SimulatedController::Hooks hooks;
    hooks.on_record = [this](const action::Record& record) { records_.push_back(record); };
    controller.process = std::make_unique<simulation::SimulatedController>(
        network_, endpoint, 0, hosts_, config_, layout_.machine_id, processes_,
        disk == nullptr ? controller.disk : *disk, std::move(hooks));
  }
  void BringUpFirst() {
    Open(first_, "first");
    first_.process->Begin(false);
    ASSERT_TRUE(RunUntil([this] { return first_.machine().phase == Phase::kRunning; }));
    network_.RunFor(Milliseconds(500));
  }
  bool RunUntil(const std::function<bool()>& done, Duration limit = kEnough) {
    return network_.RunUntil(done, network_.now() + limit);
  }

  Duration callback_takes_ = Milliseconds(5);  // of every actuator
  transport::sim::Network network_;
  MachineConfig config_;
  const simulation::Layout layout_;
  simulation::Hosts hosts_;
  simulation::SimulatedProcesses processes_;
  std::vector<action::Record> records_;  // of both
  Controller first_;
  Controller second_;
  std::unique_ptr<transport::Node> desk_;

 private:
  class Timed : public simulation::Module {
   public:
    explicit Timed(const Duration& takes) : takes_(takes) {}
    simulation::Act Run(const State&) override { return {takes_, {kCodeOk, ""}}; }

   private:
    const Duration& takes_;
  };

  static MachineConfig Robot() {
    MachineConfig config = MachineOf(2);
    config.transport = TransportProfile::kLan;
    for (ActuatorConfig& actuator : config.actuators) {
      actuator.command = {"run", actuator.name};
      actuator.times.assign(actuator.times.size(), Milliseconds(2000));
    }
    return config;
  }
};

}  // namespace musher::testing
