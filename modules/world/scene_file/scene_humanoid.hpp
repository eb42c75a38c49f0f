#pragma once
// Reads a humanoid of a scene file, and the file of its poses.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/base/toml/table_reader.hpp"
#include "musher/modules/world/scene/humanoid_specs.hpp"

namespace musher::world {

// [humanoid], if present. Its file of poses is relative to `folder`, and not read yet.
std::optional<HumanoidSpec> ReadHumanoid(config_toml::TableReader& root, const std::string& folder);

struct PosesReading {
  std::optional<std::vector<PoseSpec>> poses;  // present exactly when no diagnostic is an error
  std::vector<Diagnostic> diagnostics;
};

// Never throws; an unreadable file is a diagnostic.
PosesReading ReadPosesFile(const std::string& path);
PosesReading ReadPosesText(std::string_view text, const std::string& path);

}  // namespace musher::world
