#pragma once
// The motion manager's own config file (config/motion/motion_manager.toml explains every key).

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/base/time.hpp"
#include "musher/modules/motion/motion_source.hpp"

namespace musher::motion {

struct MotionConfig {
  std::string motions;  // the file of the motion id table, absolute
  Priorities priorities = DefaultPriorities();
  Duration board_wait = Milliseconds(10'000);   // how long SetUp waits for the first report
  Duration board_silent = Milliseconds(500);    // timeout without a report
  Duration board_feedback = Milliseconds(200);  // within which a command must be taken

  friend bool operator==(const MotionConfig&, const MotionConfig&) = default;
};

struct ConfigReading {
  std::optional<MotionConfig> config;   // present exactly when no diagnostic is an error
  std::vector<Diagnostic> diagnostics;  // by line
};

// Never throws; an unreadable file is a diagnostic.
ConfigReading ReadMotionConfigFile(const std::string& path);
// The same for a text; `path` is what diagnostics and relative paths refer to.
ConfigReading ReadMotionConfigText(std::string_view text, const std::string& path);

}  // namespace musher::motion
