// The exit of a ROS 2 process that Musher did not start: which process it is, its participant says.

#include <gmock/gmock.h>

#include "musher/test/controller/empty_host.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"
#include "musher/test/protocols/ros_managed_node.hpp"
#include "musher/test/transport/node_with_peers.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::testing::program_watch_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr pid_t kPid = 41;  // of this host

class HostOfAProgram : public EmptyHost {
 public:
  bool SharesDomain(pid_t) override { return sockets_are_listed; }
  Result<> Watch(pid_t pid, OnExit) override {
    watched.push_back(pid);
    return Ok();
  }

  bool sockets_are_listed = true;
  std::vector<pid_t> watched;
};

class AProgramOfRos2 : public ::testing::Test {
 protected:
  AProgramOfRos2() {
    config_.actuators[0].protocol = Protocol::kRos2Lifecycle;
    config_.actuators[0].checkpoint = Milliseconds(400);
    ControllerShell::Dependencies dependencies = host_.DependenciesOf(node_);
    dependencies.host_name = "dog1";
    shell_ = ControllerShell::Make(std::move(dependencies), config_, {}).value();
    event::Begin begin;
    begin.by_hand = true;
    shell_->Begin(begin);
  }
  // Its participant, as discovery has it.
  transport::PeerInfo Itself() const {
    return {launched_->participant(), kPid, "dog1", 0x0110, ""};
  }

  transport::sim::Network network_{1};
  MachineConfig config_ = MachineOf(1);
  HostOfAProgram host_;
  NodeWithPeers node_{network_.MakeNode("robot")};
  std::unique_ptr<transport::Node> launched_ = network_.MakeNode("robot");
  std::unique_ptr<RosManagedNode> program_ = std::make_unique<RosManagedNode>(*launched_, "a");
  std::unique_ptr<ControllerShell> shell_;
};

TEST_F(AProgramOfRos2, IsWatchedByTheProcessOfItsParticipant) {
  node_.peers = {Itself()};
  network_.RunFor(std::chrono::seconds(2));
  EXPECT_THAT(host_.watched, ElementsAre(kPid));
}

TEST_F(AProgramOfRos2, IsWatchedAlsoIfAReadOfTheSocketsHasMissedIts) {
  node_.peers = {Itself()};
  host_.sockets_are_listed = false;
  network_.RunFor(Milliseconds(500));
  host_.sockets_are_listed = true;
  network_.RunFor(std::chrono::seconds(2));
  EXPECT_THAT(host_.watched, ElementsAre(kPid));
}

TEST_F(AProgramOfRos2, OfAContainerWithTheSameNumberIsNotWatched) {
  node_.peers = {Itself()};
  host_.sockets_are_listed = false;
  network_.RunFor(std::chrono::seconds(20));
  host_.sockets_are_listed = true;
  network_.RunFor(std::chrono::seconds(20));
  EXPECT_THAT(host_.watched, IsEmpty()) << "the answer is looked for a few times, not for ever";
}

}  // namespace musher::testing::program_watch_test
