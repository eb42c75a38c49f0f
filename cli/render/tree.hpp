#pragma once
// A behaviour tree for people and as JSON: of a running application, and of a file. Keys of JSON
// are a contract, as in json.hpp.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "musher/cli/config/tree_file.hpp"
#include "musher/messages/musher_msgs/tree.hpp"

namespace musher::cli {

// "IDLE", "RUNNING", ...; of another number "?".
std::string_view TreeStatusName(std::uint8_t status);

// The nodes with their status, the faults, the changes and the entries that the report has.
std::string TreeText(const std::string& name, const msg::GetTree::Response& report, bool colour);
// The changes, one line each.
std::string TreeLines(const msg::GetTree::Response& report, std::int64_t wall_ns, bool colour);
std::string TreeJson(const std::string& name, const msg::GetTree::Response& report);

// A tree of a recording at a time of it.
struct RecordedMoment {
  msg::GetTree::Response report;  // without ticks
  std::size_t number = 1;         // of the recording's trees
  std::size_t trees = 1;
  double end_s = 0;           // of this tree
  std::uint64_t wall_us = 0;  // since 1970; 0: unknown
  std::uint64_t lost_lines = 0;
  int cut_at_line = 0;  // 0: the recording is complete
};
std::string RecordedTreeText(const std::string& name, const RecordedMoment& moment, bool colour);
std::string RecordedTreeJson(const std::string& name, const RecordedMoment& moment);
std::string RecordedChangeLine(const msg::GetTree::Response& report, const msg::TreeChange& change,
                               bool colour);

// Graphviz and Mermaid; nodes that have run show the time in RUNNING and how often they started.
std::string TreeDot(const std::string& name, const msg::GetTree::Response& report);
std::string TreeMermaid(const msg::GetTree::Response& report);

// The nodes of a file.
std::string FileTreeText(const std::vector<FileNode>& nodes, bool colour);
std::string FileTreeJson(const std::vector<FileNode>& nodes);

}  // namespace musher::cli
