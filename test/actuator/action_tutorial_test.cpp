// The action of docs/actions.md, in virtual time.

#include <gmock/gmock.h>

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "first_action/desk.hpp"
#include "first_action/fibonacci_client.hpp"
#include "musher/test/actuator/robot_file.hpp"
#include "musher/test/support/wait.hpp"
#include "musher/transport/dds/node_thread.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::action_tutorial_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class TheActionOfTheTutorial : public ::testing::Test {
 protected:
  TheActionOfTheTutorial() {
    server_.Open(*robot_topics_);
    client_.Open(desk_topics_);
    EXPECT_TRUE(robot_topics_->opened().ok());
    EXPECT_TRUE(desk_topics_.opened().ok());
  }
  void Send(int order) {
    client_.Send(order, [](bool) {});
  }
  void RunFor(int ms) { network_.RunFor(Milliseconds(ms)); }

  transport::sim::Network network_{7};
  std::unique_ptr<transport::Node> there_ = network_.MakeNode("robot");
  std::unique_ptr<transport::Node> here_ = network_.MakeNode("desk");
  FibonacciServer server_;
  std::vector<std::string> log_;
  FibonacciClient client_{[this](const std::string& line) { log_.push_back(line); }};
  std::unique_ptr<transport::Endpoints> robot_topics_ =
      std::make_unique<transport::Endpoints>(*there_, "");
  transport::Endpoints desk_topics_{*here_, ""};
};

TEST_F(TheActionOfTheTutorial, ReportsEachNumberAndSucceeds) {
  Send(4);
  RunFor(1000);
  EXPECT_THAT(log_, ElementsAre("up to 1", "up to 2", "up to 3", "succeeded"));
}

TEST_F(TheActionOfTheTutorial, RejectsAGoalThatIsTooLarge) {
  Send(47);
  RunFor(1000);
  ASSERT_EQ(log_.size(), 1U);
  EXPECT_THAT(log_.front(), HasSubstr("rejected: fibonacci: the server rejects the goal"));
}

TEST_F(TheActionOfTheTutorial, IsCancelledOnRequest) {
  Send(40);
  RunFor(350);
  client_.Cancel();
  RunFor(1000);
  EXPECT_EQ(log_.back(), "canceled");
}

TEST_F(TheActionOfTheTutorial, IsLostForItsClientWithItsServer) {
  Send(40);
  RunFor(350);
  robot_topics_.reset();
  RunFor(10'000);
  EXPECT_THAT(log_.back(), HasSubstr("lost: "));
}

TEST(TheActuatorOfTheTutorial, ServesTheActionFromItsSetUp) {
  const testing::RobotFile file({"desk"}, {"SetUp"});
  ActuatorRunner<Desk> desk;
  ASSERT_TRUE(desk.Init(file.path()).ok());
  ASSERT_TRUE(desk.Start().ok());
  const auto node = transport::NodeThread::Start().value();
  std::unique_ptr<transport::Endpoints> topics;
  std::atomic<bool> succeeded = false;
  FibonacciClient client([](const std::string&) {});
  node->RunOnLoop([&] {
    topics = std::make_unique<transport::Endpoints>(node->node(), file.name_space());
    client.Open(*topics);
    client.Send(2, [&succeeded](bool success) { succeeded = success; });
  });
  testing::Until([&succeeded] { return succeeded.load(); });
  EXPECT_TRUE(succeeded);
  node->RunOnLoop([&topics] { topics.reset(); });
}

}  // namespace musher::action_tutorial_test
