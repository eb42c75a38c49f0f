#pragma once
// All nodes of a match, for a tree's factory:
//
//   Move, Fetch                                                    move.hpp, fetch.hpp
//   GetOffEdge                                                     get_off_edge.hpp
//   Align, MoveToPose, SuspensionControl, ArmAction, SpearAction   action_nodes.hpp
//   PopNextMeilinSegment, PopNextSegment, SwitchSegmentType, ForEachSegment, RetrySegment
//                                                                  segment_nodes.hpp
//   WaitArmIdle, WaitForR1Signal, WaitSeconds, SetDebugStatus, IsSegmentType, IsStringEmpty,
//   IsStringNonEmpty                                               wait_nodes.hpp

#include "musher/base/result.hpp"
#include "musher/behavior/tree/factory.hpp"
#include "musher/modules/meilin/nodes/settings.hpp"
#include "musher/modules/meilin/robot.hpp"

namespace musher::meilin {

// Both must outlive the trees. Fails where the factory has one of the names.
Result<> RegisterNodes(tree::Factory& factory, Robot& robot, const Settings& settings);

}  // namespace musher::meilin
