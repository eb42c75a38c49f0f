#pragma once
// The command-line tools of musher-meilin for trees, beside the actuator and the tools for plans
// (plan/tool.hpp). Each gets the command line from its own name on, and returns the exit code.

#include <string>

namespace musher::meilin {

// musher-meilin check TREE.xml|MATCH.json|MISSION.toml: reports every error with its place. False:
// the file is none of these.
bool ChecksFile(const std::string& file);
int CheckFile(const std::string& file);
// musher-meilin models: the nodes as XML, for Groot2 and `musher tree check --models`.
int PrintModels(int argc, const char* const* argv);

}  // namespace musher::meilin
