// The part of docs/behavior-trees.md about nav2, as a program has it.

#include "musher/test/behavior/tree/nav2/fake_robot.hpp"

namespace musher::nav2_tutorial_test {

TEST(Nav2Tutorial, ATreeOfNav2Runs) {
  tree::nav2::FakeRobot robot;
  // [add]
  tree::Factory factory;
  tree::nav2::AddNodes(factory, robot);
  // [add end]
  const auto tree = tree::MakeTree(tree::Main("<GoalReached goal=\"0;0;0\"/>"), factory);
  EXPECT_EQ(tree::Letter(tree->TickOnce(tree::At(0))), 'S');
}

}  // namespace musher::nav2_tutorial_test
