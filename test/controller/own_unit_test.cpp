// The process of an actuator that runs as a unit of this host: the kernel reports its exit, and
// systemd how it has exited.

#include <gmock/gmock.h>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/simulation/simulated_processes.hpp"
#include "musher/test/controller/empty_host.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::testing::own_unit_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr pid_t kGone = 99;  // has exited before it is looked at
constexpr Duration kTearDownTakes = Milliseconds(900);

// The kernel.
class Here : public EmptyHost {
 public:
  Result<> Adopt(pid_t pid, std::uint64_t, OnExit on_exit) override {
    if (pid == kGone) return Error{kCodeStateInvalid, "no such process"};
    exits[pid] = std::move(on_exit);
    return Ok();
  }
  Result<> Watch(pid_t pid, OnExit on_exit) override { return Adopt(pid, 1, std::move(on_exit)); }
  std::uint64_t StartTimeOf(pid_t pid) override { return pid == kGone ? 0 : 1; }
  void Exit(pid_t pid) { std::exchange(exits[pid], nullptr)({}); }

  std::map<pid_t, OnExit> exits;
};

// Its systemd, which does what the test does.
class There : public HostProcesses {
 public:
  void Open(Hooks to) override { hooks = std::move(to); }
  void Start(const ProcessSpec&) override { ++starts; }
  void Signal(const std::string&, pid_t, int) override {}
  void Find(std::function<void(const std::vector<Found>&)> done) override { done(found); }
  void Close() override {}

  Hooks hooks;
  std::vector<Found> found;
  int starts = 0;
};

class SlowTearDown : public simulation::Module {
 public:
  simulation::Act Run(const State& state) override {
    return {.takes = state == kTearDown ? kTearDownTakes : Milliseconds(5)};
  }
};

class OwnUnit : public ::testing::Test {
 protected:
  OwnUnit()
      : network_(1),
        config_(MakeConfig()),
        hosts_(network_, layout_.hosts),
        processes_(network_, config_, hosts_, layout_),
        node_(network_.MakeNode("second")) {
    processes_.make_module = [](const std::string&) { return std::make_unique<SlowTearDown>(); };
    ControllerShell::Dependencies dependencies = here_.DependenciesOf(*node_);
    dependencies.hosts = &there_;
    dependencies.own_units = true;
    shell_ = ControllerShell::Make(std::move(dependencies), config_, {}).value();
    event::Begin begin;
    begin.by_hand = true;
    shell_->Begin(begin);
    EXPECT_TRUE(network_.RunUntil([this] { return there_.starts == 1; },
                                  network_.now() + std::chrono::seconds(30)));
  }
  static MachineConfig MakeConfig() {
    MachineConfig config = MachineOf(1);
    config.actuators[0].command = {"run"};
    config.actuators[0].restart.policy = RestartPolicy::kOnFailure;
    config.shutdown_budget = std::chrono::seconds(10);
    for (Duration& time : config.actuators[0].times) time = std::chrono::seconds(5);
    return config;
  }
  static simulation::Layout Second() {
    simulation::Layout layout;
    layout.hosts = {"second"};
    return layout;
  }

  const std::string& Name() const { return config_.actuators[0].name; }
  const KnownActuator& Known() const { return shell_->machine().actuators[0]; }
  std::string Fault() const { return Known().fault ? Known().fault->message : ""; }
  void Start(pid_t pid) { there_.hooks.on_started(Name(), pid, "", false); }
  void End(pid_t pid, const ProcessExit& exit) { there_.hooks.on_ended(Name(), pid, exit); }
  // Launches it, and waits until its status has arrived.
  pid_t Launch() {
    const pid_t pid = processes_.Launch(Name());
    Start(pid);
    EXPECT_TRUE(network_.RunUntil([this] { return Known().presence == Presence::kPresent; },
                                  network_.now() + std::chrono::seconds(30)));
    return pid;
  }

  transport::sim::Network network_;
  const MachineConfig config_;
  const simulation::Layout layout_ = Second();
  simulation::Hosts hosts_;
  simulation::SimulatedProcesses processes_;
  Here here_;
  There there_;
  std::unique_ptr<transport::Node> node_;
  std::unique_ptr<ControllerShell> shell_;
};

// A systemd that is short of CPU or of memory, as where the actuator has just used it up, says a
// second later how it has exited.
TEST_F(OwnUnit, HasTheExitCodeThatSystemdReportsAfterTheKernel) {
  Start(41);
  here_.Exit(41);
  network_.RunFor(Milliseconds(1900));
  EXPECT_EQ(Known().process.pid, 41);
  End(41, {ProcessExit::Kind::kExited, 3});
  EXPECT_EQ(Known().process.pid, 0);
  EXPECT_THAT(Fault(), HasSubstr("exit code 3"));
}

TEST_F(OwnUnit, WhoseEndSystemdDoesNotReportHasAnUnknownExitCode) {
  Start(41);
  here_.Exit(41);
  network_.RunFor(std::chrono::seconds(3));
  EXPECT_THAT(Fault(), HasSubstr("exit code unknown: systemd has not reported it within 2000 ms"));
  EXPECT_EQ(there_.starts, 2);
  End(41, {ProcessExit::Kind::kExited, 3});  // late: it is no second end
  EXPECT_EQ(Known().restart.count, 1);
}

// A second process would have been started beside it.
TEST_F(OwnUnit, ThatSystemdHasLostRunsOnUntilTheKernelReportsItsExit) {
  Start(41);
  End(41, {});
  network_.RunFor(std::chrono::seconds(2));
  EXPECT_EQ(Known().process.pid, 41);
  EXPECT_EQ(there_.starts, 1);
  here_.Exit(41);
  network_.RunFor(std::chrono::seconds(2));
  EXPECT_THAT(Fault(), HasSubstr("exit code unknown"));
  EXPECT_EQ(there_.starts, 2);
}

// Neither the kernel nor a silent systemd would have reported its exit.
TEST_F(OwnUnit, ThatHasExitedBeforeItIsWatchedHasEnded) {
  Start(kGone);
  EXPECT_EQ(Known().process.pid, kGone);
  network_.RunFor(std::chrono::seconds(3));
  EXPECT_THAT(Fault(), HasSubstr("exit code unknown"));
  EXPECT_EQ(there_.starts, 2);
}

// Else systemd, which has not noticed it yet, would be taken for one that runs the unit.
TEST_F(OwnUnit, WhoseExitTheKernelHasReportedIsKnownToTheSearchForIt) {
  Start(41);
  EXPECT_FALSE(there_.hooks.has_exited(Name(), 41));
  here_.Exit(41);
  EXPECT_TRUE(there_.hooks.has_exited(Name(), 41));
  network_.RunFor(std::chrono::seconds(2));
  EXPECT_TRUE(there_.hooks.has_exited(Name(), 41));  // until another one is started
  Start(42);
  EXPECT_FALSE(there_.hooks.has_exited(Name(), 41));
}

// Its exit is known before its last status arrives, and its exit code is not known at all.
TEST_F(OwnUnit, IsTornDownByItsLastStatusIfItsExitCodeIsUnknown) {
  const pid_t pid = Launch();
  shell_->TearDown(AfterTearDown::kStaysDown);
  network_.RunFor(Milliseconds(100));
  here_.Exit(pid);
  // Several may end one after the other within the shutdown budget.
  ASSERT_TRUE(network_.RunUntil([this] { return shell_->machine().phase == Phase::kStopped; },
                                network_.now() + Milliseconds(1500)));
  EXPECT_EQ(Known().state(), kTearDown);
  EXPECT_THAT(Fault(), IsEmpty());
}

// D-Bus has the start, and may deliver it after the machine is stopped.
TEST_F(OwnUnit, WhoseStartIsUnderWayIsNamedByATearDown) {
  there_.hooks.on_not_started(Name(), "given up", false);
  there_.found = {{Name(), 0, "", "musher-robot-a.service is about to start"}};
  shell_->TearDown(AfterTearDown::kStaysDown);
  network_.RunFor(config_.shutdown_budget + std::chrono::seconds(5));
  EXPECT_EQ(shell_->machine().phase, Phase::kStopped);
  EXPECT_THAT(Fault(), AllOf(HasSubstr("it may still be started: "),
                             HasSubstr("musher-robot-a.service is about to start")));
}

}  // namespace musher::testing::own_unit_test
