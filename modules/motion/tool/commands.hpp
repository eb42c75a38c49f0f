#pragma once
// The commands of musher-motion, one function each: prints the outcome and returns the exit code.

#include <string>

#include "musher/base/result.hpp"
#include "musher/modules/motion/tool/options.hpp"

namespace musher::motion::tool {

ExitCode Run(const GlobalOptions& global, const ResultOptions& options);
ExitCode Run(const GlobalOptions& global, const ServoOptions& options);
ExitCode Run(const GlobalOptions& global, const WalkOptions& options);
ExitCode Run(const GlobalOptions& global, const StatusOptions& options);
ExitCode Run(const GlobalOptions& global, const ListOptions& options);

// "musher-motion: <why>" on stderr.
ExitCode Fail(ExitCode exit, const Error& error);

// "the emergency stop is set; ...".
std::string CodeMeaning(std::int32_t code);

// The table of the options, else the table that is installed with this program.
TableReading ReadTable(const GlobalOptions& global);
// "303 (WALK_USERTROT)", "303" without a table.
std::string NameOf(const GlobalOptions& global, std::int32_t id);

}  // namespace musher::motion::tool
