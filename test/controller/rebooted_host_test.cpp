// A remote host that reboots: its boot clock starts at zero again, so its processes have smaller
// incarnations than those before.

#include <gmock/gmock.h>

#include <memory>
#include <string>
#include <utility>

#include "musher/actuator/actuator_shell.hpp"
#include "musher/controller/process/host_processes.hpp"
#include "musher/controller/process/unit_end.hpp"
#include "musher/simulation/simulated_controller.hpp"
#include "musher/simulation/simulated_processes.hpp"
#include "musher/test/controller/empty_host.hpp"
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

// The systemd of another host, which does what the test does.
class There : public HostProcesses {
 public:
  void Open(Hooks to) override { hooks = std::move(to); }
  void Start(const ProcessSpec&) override { ++starts; }
  void Signal(const std::string&, pid_t, int) override {}
  void Find(std::function<void(const std::vector<Found>&)> done) override { done({}); }
  void Close() override {}

  Hooks hooks;
  int starts = 0;
};

class UnitOfRebootedHost : public ::testing::Test {
 protected:
  UnitOfRebootedHost()
      : network_(1), config_(testing::MachineOf(1)), node_(network_.MakeNode("controller")) {
    config_.transport = TransportProfile::kLan;
    config_.hosts.emplace_back().name = "vision";
    ActuatorConfig& actuator = config_.actuators[0];
    actuator.host = "vision";
    actuator.command = {"run"};
    actuator.restart.policy = RestartPolicy::kOnFailure;
    ControllerShell::Dependencies dependencies = here_.DependenciesOf(*node_);
    dependencies.hosts = &there_;
    shell_ = ControllerShell::Make(std::move(dependencies), config_, {}).value();
    shell_->Begin({});
    AwaitStarts(1);
    Run("first", 5'000'000);
    AwaitActive();
  }
  void AwaitStarts(int count) {
    ASSERT_TRUE(network_.RunUntil([&] { return there_.starts == count; },
                                  network_.now() + std::chrono::seconds(30)));
  }
  // Its process runs on that boot of its host.
  void Run(const std::string& boot, Incarnation incarnation) {
    there_.hooks.on_started(Name(), 100, boot, false);
    actuator_ = std::make_unique<RemoteActuator>(network_, config_, boot, incarnation);
  }
  void End(const std::string& system_state) {
    actuator_.reset();
    const ProcessExit exit{ProcessExit::Kind::kExited, 0};
    there_.hooks.on_ended(Name(), 100, EndOfUnit(exit, system_state, false));
  }
  void AwaitActive() {
    ASSERT_TRUE(network_.RunUntil([&] { return actuator_->report().state == "Active"; },
                                  network_.now() + std::chrono::seconds(30)))
        << actuator_->report().state;
  }
  const std::string& Name() const { return config_.actuators[0].name; }

  transport::sim::Network network_;
  MachineConfig config_;
  testing::EmptyHost here_;
  There there_;
  std::unique_ptr<transport::Node> node_;
  std::unique_ptr<ControllerShell> shell_;
  std::unique_ptr<RemoteActuator> actuator_;
};

TEST_F(UnitOfRebootedHost, IsStartedAgainAndDrivenOnceItsHostIsBack) {
  End("stopping");
  AwaitStarts(2);
  there_.hooks.on_not_started(Name(), "host vision is shutting down", true);
  network_.RunFor(std::chrono::minutes(10));  // it checks its disks
  EXPECT_EQ(there_.starts, 2);
  EXPECT_EQ(shell_->machine().actuators[0].restart.count, 1);
  Run("second", 1'000);
  AwaitActive();
}

TEST_F(UnitOfRebootedHost, IsNotStartedAgainWhenItHasDoneItsWork) {
  End("running");
  network_.RunFor(std::chrono::minutes(10));
  EXPECT_EQ(there_.starts, 1);
}

TEST(EndOfUnit, IsItsHostsIfThatShutsDownOrWasBootedAgain) {
  const ProcessExit done{ProcessExit::Kind::kExited, 0};
  const ProcessExit killed{ProcessExit::Kind::kKilled, 9};
  const ProcessExit host{ProcessExit::Kind::kHostWentDown};
  EXPECT_EQ(EndOfUnit(done, "stopping", false), host);
  EXPECT_EQ(EndOfUnit(done, "", true), host);
  for (const char* state : {"running", "degraded", "maintenance", "starting", ""}) {
    EXPECT_EQ(EndOfUnit(done, state, false), done) << state;
  }
  EXPECT_FALSE(host.clean());
  EXPECT_TRUE(NeedsSystemState(done, /*wanted=*/false));
  EXPECT_TRUE(NeedsSystemState(ProcessExit{}, /*wanted=*/false));  // its unit was dropped
  EXPECT_FALSE(NeedsSystemState(done, /*wanted=*/true));
  EXPECT_FALSE(NeedsSystemState(killed, /*wanted=*/false));  // is started again in any case
}

}  // namespace musher::rebooted_host_test
