#pragma once
// The monitoring protocol of Groot2, the editor of BehaviorTree.CPP, as that library defines it in
// include/behaviortree_cpp/loggers/groot2_protocol.h (protocol 2): what is replied to a request
// that only looks. Those that change something are in groot2_session.hpp. Plain functions, no IO.
//
// clang-format off
//   request  part 1: uint8 protocol, uint8 type, uint32 id        (6 bytes, little endian)
//            part 2: of BLACKBOARD, names of subtrees with ';' between them
//   reply    part 1: the same 6 bytes, then 16 bytes that name the tree
//            part 2: the content
//   error    part 1: "error", part 2: why
//   T  FULLTREE    XML with the attribute _uid of each node
//   S  STATUS      of each node uint16 uid, uint8 status; 10 + the status before, where it is idle
//   B  BLACKBOARD  MessagePack: { "<subtree>": { "<key>": value } }; the main tree is "" or its name
//                 (null: an entry without a value, a board without entries)
// clang-format on

#include <array>
#include <string>
#include <vector>

#include "musher/application/tree_report.hpp"
#include "musher/behavior/tree/factory.hpp"

namespace musher::groot2 {

inline constexpr char kProtocol = 2;
using TreeId = std::array<char, 16>;
using Parts = std::vector<std::string>;

// The header alone for requests of a session. Without a tree in `view`, T, S and B are errors.
Parts Reply(const Parts& request, const TreeView& view, const tree::Factory& factory,
            const TreeId& tree_id);

}  // namespace musher::groot2
