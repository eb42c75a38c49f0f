#pragma once
// The nodes of nav2, so that its trees run here:
//
//   tree::Factory factory;
//   tree::nav2::AddNodes(factory, robot);   // robot.hpp
//
// docs/nav2-nodes.md lists them with their ports. Nodes of nav2 that need a server which no robot
// of ours has (DockRobot, UndockRobot, ...) have models only: a tree with them is checked, and
// their tick fails.
//
// Threads: one at a time, like the trees.

#include "musher/behavior/tree/factory.hpp"
#include "musher/behavior/tree/nav2/robot.hpp"

namespace musher::tree::nav2 {

// A node that the factory has already is kept. The robot must outlive the trees.
void AddNodes(Factory& factory, Robot& robot);
// Nodes that only a model describes. They fail in their tick.
void AddModels(Factory& factory);
// The same for a program without a robot, that reads trees and ticks none.
void AddForCheck(Factory& factory);

}  // namespace musher::tree::nav2
