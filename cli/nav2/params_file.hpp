#pragma once
// A parameter file of ROS 2: the part of YAML that such files consist of. Nested keys by their
// indentation, scalars, lists in brackets or by "- ". What else there is in a file (texts of
// several lines, anchors) is skipped as a scalar: only names and lists are of interest.
//
// Threads: none; a plain value.

#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"

namespace musher::cli {

struct ParamsMember;

struct ParamsNode {
  std::string text;                   // of a scalar
  std::vector<std::string> list;      // of a list of scalars
  std::vector<ParamsMember> members;  // in the order of the file

  const ParamsNode* Find(std::string_view key) const;
};

struct ParamsMember {
  std::string key;
  ParamsNode value;
};

// `path` is what an Error refers to, with the line.
Result<ParamsNode> ReadParams(std::string_view text, const std::string& path);

}  // namespace musher::cli
