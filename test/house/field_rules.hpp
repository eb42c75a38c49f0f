#pragma once
// Every field of the IDL (messages/*/*.idl) has a comment: it goes into the C++ header and the ROS
// 2 package, where a reader looks for units, frames and special values.
//
// Only the fields that ROS 2 adds need none; messages/README.md explains them once:
//
//   in every struct                        client_id, sequence_number,
//                                          structure_needs_at_least_one_member
//   in <Action>_SendGoal_Request           goal_id, goal
//   in <Action>_SendGoal_Response          accepted, stamp
//   in <Action>_GetResult_Request          goal_id
//   in <Action>_GetResult_Response         result
//   in <Action>_FeedbackMessage            goal_id, feedback

#include "musher/test/house/source_tree.hpp"

namespace musher::house {

// Fields of an IDL file without a comment behind or directly above them, and those whose comment
// only repeats the name.
std::vector<std::string> UncommentedFields(const SourceFile& idl);

}  // namespace musher::house
