// A remote host that reboots: its boot clock starts at zero again, so its processes have smaller
// incarnations than those before.

#include <gmock/gmock.h>

#include <memory>
#include <string>
#include <utility>

#include "musher/actuator/actuator_shell.hpp"
#include "musher/simulation/simulated_controller.hpp"
#include "musher/simulation/simulated_processes.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::rebooted_host_test {

// Runs callbacks at once.
class DirectWorker : public Worker {
 public:
  void Run(Work work, Done done) override { done(work()); }
};

// An actuator on a host of its own, with the boot and the boot clock that it is given.
class RemoteActuator {
 public:
  RemoteActuator(transport::sim::Network& network, const MachineConfig& config, std::string boot,
                 Incarnation incarnation)
      : network_(network), node_(network.MakeNode("remote")) {
    ActuatorShell::Hooks hooks;
    hooks.run_callback = [](const State&) { return Ok(); };
    hooks.on_finished = [](const Error&) {};
    shell_ = ActuatorShell::Make(*node_, worker_, config, 0, {incarnation, 100, std::move(boot)},
                                 std::move(hooks))
                 .value();
    shell_->Start();
  }
  ~RemoteActuator() { network_.Crash(*node_); }
  RemoteActuator(const RemoteActuator&) = delete;
  RemoteActuator& operator=(const RemoteActuator&) = delete;

  const ActuatorReport& report() const { return shell_->report(); }
  void FallSilent() { network_.Pause(*node_); }

 private:
  transport::sim::Network& network_;
  DirectWorker worker_;
  std::unique_ptr<transport::Node> node_;
  std::unique_ptr<ActuatorShell> shell_;
};

class RebootedHost : public ::testing::Test {
 protected:
  RebootedHost()
      : network_(1),
        config_(MakeConfig()),
        hosts_(network_, layout_.hosts),
        processes_(network_, config_, hosts_, layout_),
        controller_(network_, "controller", 0, hosts_, config_, layout_.machine_id, processes_,
                    disk_, {}) {}

  static MachineConfig MakeConfig() {
    MachineConfig config = testing::MachineOf(1);
    config.transport = TransportProfile::kLan;
    config.actuators[0].restart.limit = 100;
    return config;
  }

  // The process before ends and one of that boot begins; both are noticed.
  void Start(const std::string& boot, Incarnation incarnation) {
    actuator_.reset();
    actuator_ = std::make_unique<RemoteActuator>(network_, config_, boot, incarnation);
  }

  bool IsUp() {
    const auto up = [&] {
      return controller_.shell().machine().phase == Phase::kRunning &&
             actuator_->report().state == "Active";
    };
    return network_.RunUntil(up, network_.now() + std::chrono::seconds(30));
  }

  transport::sim::Network network_;
  const MachineConfig config_;
  const simulation::Layout layout_;
  simulation::Hosts hosts_;
  simulation::SimulatedProcesses processes_;
  simulation::Disk disk_;
  simulation::SimulatedController controller_;
  std::unique_ptr<RemoteActuator> actuator_;
};

// The controller remembered the participants of four incarnations and forgot the smallest: that of
// the new boot, at once and for ever.
TEST_F(RebootedHost, IsCommandedAfterManyProcessesOfTheBootBefore) {
  Start("remote/boot-1", 1'000'001);
  controller_.Begin(false);
  ASSERT_TRUE(IsUp());
  for (std::uint64_t restart = 2; restart <= 6; ++restart) {
    Start("remote/boot-1", Incarnation(1'000'000 + restart));
    ASSERT_TRUE(IsUp()) << restart;
  }
  for (std::uint64_t boot = 2; boot <= 6; ++boot) {
    Start("remote/boot-" + std::to_string(boot), Incarnation(100 - boot));
    ASSERT_TRUE(IsUp()) << boot;
  }
}

// It is back before the one from before is missed: its status is latched and comes once.
TEST_F(RebootedHost, IsCommandedThoughItPublishedBeforeThePreviousProcessWasLost) {
  Start("remote/boot-1", 1'000'001);
  controller_.Begin(false);
  ASSERT_TRUE(IsUp());
  actuator_->FallSilent();
  const auto before = std::move(actuator_);
  Start("remote/boot-2", 7);
  EXPECT_TRUE(IsUp());
}

}  // namespace musher::rebooted_host_test
