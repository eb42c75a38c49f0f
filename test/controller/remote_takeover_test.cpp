// A controller takes over from one of another host: the modules continue to run, and none is
// started a second time.

#include <gmock/gmock.h>

#include "musher/simulation/simulated_processes.hpp"
#include "musher/test/controller/empty_host.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"
#include "musher/test/lifecycle/coordination/records.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::testing::remote_takeover_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

class NoWork : public simulation::Module {
 public:
  simulation::Act Run(const State&) override { return {}; }
};

class RemoteTakeover : public ::testing::Test {
 protected:
  RemoteTakeover()
      : network_(1),
        config_(MachineOf(2)),
        hosts_(network_, layout_.hosts),
        processes_(network_, config_, hosts_, layout_) {
    for (ActuatorConfig& actuator : config_.actuators) actuator.command = {"run", actuator.name};
    processes_.make_module = [](const std::string&) { return std::make_unique<NoWork>(); };
    node_ = network_.MakeNode("second");
    ControllerShell::Dependencies dependencies = host_.DependenciesOf(*node_);
    shell_ = ControllerShell::Make(std::move(dependencies), config_, {}).value();
  }

  // That run actuators.
  static simulation::Layout TwoHosts() {
    simulation::Layout layout;
    layout.hosts = {"first", "third"};
    return layout;
  }
  void LookAround() { network_.RunFor(std::chrono::seconds(1)); }
  void Begin() {
    shell_->Begin({});
    network_.RunFor(std::chrono::seconds(3));
  }

  transport::sim::Network network_;
  MachineConfig config_;
  const simulation::Layout layout_ = TwoHosts();
  simulation::Hosts hosts_;
  simulation::SimulatedProcesses processes_;
  EmptyHost host_;
  std::unique_ptr<transport::Node> node_;
  std::unique_ptr<ControllerShell> shell_;
};

TEST_F(RemoteTakeover, StartsNoActuatorWhoseStatusWasReceivedWhileListening) {
  processes_.Launch("a");
  processes_.Launch("b");
  LookAround();
  Begin();
  EXPECT_THAT(host_.started, IsEmpty());
  EXPECT_EQ(shell_->machine().actuators[0].presence, Presence::kPresent);
  EXPECT_EQ(shell_->machine().actuators[1].presence, Presence::kPresent);
}

TEST_F(RemoteTakeover, StartsWhatRunsNowhere) {
  processes_.Launch("a");
  LookAround();
  Begin();
  EXPECT_THAT(host_.started, ElementsAre("b"));
}

TEST_F(RemoteTakeover, StartsWhatHasEndedWhileItLookedAround) {
  processes_.Launch("a");
  processes_.Launch("b");
  LookAround();
  processes_.End("b", {ProcessExit::Kind::kExited, 0});
  network_.RunFor(std::chrono::minutes(1));
  Begin();
  EXPECT_THAT(host_.started, ElementsAre("b"));
}

// A regression: of two processes of one actuator only the last status was kept, and with its end
// the other one was forgotten.
TEST_F(RemoteTakeover, StartsNoActuatorOfWhichOneOfTwoProcessesHasEnded) {
  processes_.Launch("a", 1);
  processes_.Launch("b");
  LookAround();
  processes_.Launch("a", 0);
  LookAround();
  processes_.End("a", 0, {ProcessExit::Kind::kExited, 0});
  network_.RunFor(std::chrono::minutes(1));
  Begin();
  EXPECT_THAT(host_.started, IsEmpty());
  EXPECT_EQ(shell_->machine().actuators[0].presence, Presence::kPresent);
}

TEST_F(RemoteTakeover, StartsWhatIsTornDown) {
  processes_.Launch("a");
  processes_.Launch("b");
  network_.RunFor(std::chrono::seconds(1));
  processes_.Lie("b", State(kTearDown));
  LookAround();
  Begin();
  EXPECT_THAT(host_.started, ElementsAre("b"));
}

// The reason of the one was known; the other one was given up in the same step, without a reason.
TEST_F(RemoteTakeover, ExaminesEachOfTheProcessesThatAreOverdueAtOnce) {
  host_.progress = StartProgress::kIdle;
  LookAround();
  Begin();
  ASSERT_THAT(host_.started, ElementsAre("a", "b"));
  for (const ActuatorIndex i : {ActuatorIndex(0), ActuatorIndex(1)}) {
    const ActuatorConfig& actuator = config_.actuators[i];
    const KnownActuator& known = shell_->machine().actuators[i];
    EXPECT_THAT(known.fault,
                Is(texts::NotAnnounced(actuator.name, actuator.command, config_.TimeFor(i, kSetUp),
                                       known.process.pid, StartProgress::kIdle)));
  }
}

// As by Ctrl-C in the second for which `musher up` listens for other controllers.
TEST_F(RemoteTakeover, TakesTheMachineDownOnceItHasBegunIfThatWasRequestedBefore) {
  LookAround();
  shell_->TearDown(AfterTearDown::kMayStart);
  Begin();
  EXPECT_EQ(shell_->machine().phase, Phase::kStopping);
  network_.RunFor(config_.shutdown_budget);
  EXPECT_EQ(shell_->machine().phase, Phase::kStopped);
}

}  // namespace musher::testing::remote_takeover_test
