#pragma once
// Reads a scene file (../README.md lists its keys, config/scenes/yard.toml explains each). All
// errors are reported at once, each with its place in the file.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/modules/world/scene/scene.hpp"

namespace musher::world {

struct SceneReading {
  std::optional<Scene> scene;           // present exactly when no diagnostic is an error
  std::vector<Diagnostic> diagnostics;  // by line
};

// What the caller decides about a run instead of the file.
struct SceneRun {
  std::optional<std::uint64_t> seed;
  std::map<std::string, std::string> chosen;  // values of the scene's [choices]
};

// Never throws; an unreadable file is a diagnostic.
SceneReading ReadSceneFile(const std::string& path, const SceneRun& run = {});

// The same for a text; `path` is what diagnostics refer to, and the scene's name if it has none.
SceneReading ReadSceneText(std::string_view text, const std::string& path,
                           const SceneRun& run = {});

}  // namespace musher::world
