// A tree whose node is a lambda, with a topic: the least that an application needs.

#include <fstream>

#include "musher/application/tree_actuator.hpp"
#include "musher/test/application/show.hpp"

namespace musher::tree_tutorial_test {

class Patrol : public TreeActuator {
 public:
  explicit Patrol(const std::string& file)
      : TreeActuator("show", {.rate_hz = 50, .begin = Begin::kAtActive, .file = file}) {}

 private:
  Result<> RegisterNodes(tree::Factory& factory) override {
    return factory.AddAction("Step", [this](const tree::Tick&) {
      ++steps_;
      return tree::Status::kSuccess;
    });
  }
  void OpenTopics(transport::Endpoints& topics) override {
    publish_ = topics.PublishFunction<msg::String>("patrol/steps");
  }
  void AfterTick(Time, tree::Status) override { publish_({std::to_string(steps_)}); }

  int steps_ = 0;
  std::function<void(const msg::String&)> publish_;
};

class Peeked : public Patrol, public testing::Inspected<Peeked> {
 public:
  using Patrol::Now;
  using Patrol::Patrol;
  using Patrol::result;
};

TEST(TreeTutorial, RunsToItsEnd) {
  testing::Harness harness;
  const TempFolder folder;
  std::ofstream(folder / "patrol.xml")
      << "<root BTCPP_format=\"4\"><BehaviorTree ID=\"P\"><Step/></BehaviorTree></root>";
  ActuatorRunner<Peeked> patrol(folder / "patrol.xml");
  harness.Open(patrol);
  ASSERT_TRUE(harness.controller().Switch("SelfCheck").done());
  ASSERT_TRUE(harness.controller().Switch("Active").done());
  harness.Tick(patrol, 2);
  EXPECT_EQ(patrol.Of([](Peeked& p) { return p.result(); }), tree::Status::kSuccess);
}

}  // namespace musher::tree_tutorial_test
