#pragma once
// `musher new ros2 PARAMS…`: a state config from the parameter files of a nav2 stack. The nodes and
// their order are those of the lifecycle managers in the files; without one, the servers of nav2
// that the files have parameters for, in the order of nav2's own launch files.
//
// Pure: texts go in, the text of the config comes out.

#include <string>
#include <vector>

#include "musher/base/result.hpp"

namespace musher::cli {

struct NamedText {
  std::string path;  // as the config refers to it
  std::string text;
};

// The Error names a file and a line, or says that the files have no managed node.
Result<std::string> Nav2Config(const std::vector<NamedText>& files, const std::string& machine);

}  // namespace musher::cli
