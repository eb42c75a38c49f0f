#pragma once
// The commands of musher-audio, one function each: prints the outcome and returns the exit code.

#include <string>

#include "musher/base/result.hpp"
#include "musher/modules/audio/tool/options.hpp"

namespace musher::audio::tool {

ExitCode Run(const GlobalOptions& global, const PlayOptions& options);
ExitCode Run(const GlobalOptions& global, const StopOptions& options);
ExitCode Run(const GlobalOptions& global, const VolumeOptions& options);
ExitCode Run(const GlobalOptions& global, const PhrasesOptions& options);

// "musher-audio: <why>" on stderr.
ExitCode Fail(ExitCode exit, const Error& error);

// "unknown phrase number".
std::string CodeMeaning(std::int32_t code);

}  // namespace musher::audio::tool
