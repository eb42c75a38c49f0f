// The search for processes that a TearDown makes on all hosts: this one, and those whose systemd
// runs actuators.

#include <gmock/gmock.h>

#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "musher/test/controller/empty_host.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::testing::host_search_test {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr pid_t kPid = 41;  // of this host

// Holds the name of actuator a from the first search on.
class Here : public EmptyHost {
 public:
  Result<pid_t> Start(const ProcessSpec&, OnExit) override { return Error{kCodeFailed, "none"}; }
  std::vector<pid_t> Find(const std::vector<std::string>& actuators) override {
    ++searches;
    std::vector<pid_t> found(actuators.size(), 0);
    for (std::size_t i = 0; i < actuators.size(); ++i) found[i] = actuators[i] == "a" ? kPid : 0;
    return found;
  }
  Result<> Watch(pid_t pid, OnExit) override {
    watched.push_back(pid);
    return Ok();
  }
  Result<> Signal(pid_t pid, int) override {
    signalled.push_back(pid);
    return Ok();
  }

  int searches = 0;
  std::vector<pid_t> watched;
  std::vector<pid_t> signalled;
};

// Answers a search when the test does.
class There : public HostProcesses {
 public:
  using Done = std::function<void(const std::vector<Found>&)>;

  void Open(Hooks to) override { hooks = std::move(to); }
  void Start(const ProcessSpec&) override {}
  void Signal(const std::string&, pid_t, int) override {}
  void Find(Done done) override { searches.push_back(std::move(done)); }
  void Close() override {}

  Hooks hooks;
  std::vector<Done> searches;
};

class SearchOnAllHosts : public ::testing::Test {
 protected:
  SearchOnAllHosts() : network_(1), config_(MachineOf(2)), node_(network_.MakeNode("here")) {
    for (ActuatorConfig& actuator : config_.actuators) {
      actuator.command = {"run", actuator.name};
      actuator.restart.policy = RestartPolicy::kNo;
    }
    config_.actuators[1].host = "vision";
    config_.hosts.emplace_back().name = "vision";
    ControllerShell::Dependencies dependencies = here_.DependenciesOf(*node_);
    dependencies.hosts = &there_;
    shell_ = ControllerShell::Make(std::move(dependencies), config_, {}).value();
    event::Begin begin;
    begin.by_hand = true;
    shell_->Begin(begin);
    network_.RunFor(std::chrono::seconds(1));
    there_.hooks.on_not_started("b", "none", false);
    shell_->TearDown(AfterTearDown::kStaysDown);
    network_.RunFor(config_.shutdown_budget * 95 / 100);
  }
  static std::vector<HostProcesses::Found> NoneThere() { return {{"b", 0, "there", ""}}; }

  transport::sim::Network network_;
  MachineConfig config_;
  Here here_;
  There there_;
  std::unique_ptr<transport::Node> node_;
  std::unique_ptr<ControllerShell> shell_;
};

// A process of this host that is found first may have exited, and been reaped, when the others have
// answered.
TEST_F(SearchOnAllHosts, LooksAtThisHostOnceTheOthersHaveAnswered) {
  ASSERT_THAT(there_.searches, Not(IsEmpty()));
  EXPECT_EQ(here_.searches, 0);
  EXPECT_THAT(here_.watched, IsEmpty());
  there_.searches.back()(NoneThere());
  EXPECT_EQ(here_.searches, 1);
  EXPECT_THAT(here_.watched, Contains(kPid));
}

// A second request takes as long again, and may not be answered within the budget.
TEST_F(SearchOnAllHosts, IsAwaitedBeforeTheHostsAreAskedAgain) {
  EXPECT_THAT(there_.searches, SizeIs(1));  // also with SIGTERM
}

TEST_F(SearchOnAllHosts, ThatIsNotAnsweredWithinTheBudgetNamesTheHost) {
  network_.RunFor(config_.shutdown_budget * 10 / 100);
  EXPECT_EQ(shell_->machine().phase, Phase::kStopped);
  const auto& fault = shell_->machine().actuators[1].fault;
  ASSERT_TRUE(fault.has_value());
  EXPECT_THAT(fault->message, HasSubstr("host vision is out of reach"));
  EXPECT_FALSE(shell_->machine().actuators[0].fault.has_value());  // it runs here
}

}  // namespace musher::testing::host_search_test
