#pragma once
// Reads gripper.toml.

#include <string>

#include "musher/base/toml/module_file.hpp"

// [config]
struct GripperConfig {
  double opening_mm = 80;
  double speed_mm_s = 40;
  int hottest_c = 70;
};

inline musher::Result<GripperConfig> ReadGripper(const std::string& file) {
  GripperConfig config;
  const auto read = musher::ReadModuleFile(file, [&](auto& table) {
    config.opening_mm = table.Number("opening_mm", 1, 500).value_or(config.opening_mm);
    config.speed_mm_s = table.Number("speed_mm_s", 0.1, 1000).value_or(config.speed_mm_s);
    config.hottest_c =
        static_cast<int>(table.Integer("hottest_c", 0, 120).value_or(config.hottest_c));
  });
  if (!read) return read.error();
  return config;
}
// [config end]
