#include "musher/modules/motion/motion_config.hpp"

#include <array>
#include <filesystem>
#include <utility>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/rows.hpp"

namespace musher::motion {
namespace {

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::Rows;
using config_toml::Table;
using config_toml::TableReader;

constexpr std::int64_t kFarthestPriority =
    100;  // that of an idle body: every source may control it

constexpr std::array<std::pair<const char*, std::int32_t>, 6> kSources = {
    {{"debug", kFromDebug},
     {"app", kFromApp},
     {"audio", kFromAudio},
     {"vis", kFromVision},
     {"blutele", kFromBluetooth},
     {"algo", kFromAlgorithm}}};

// The priorities of all sources.
Rows PriorityRows(Priorities& priorities) {
  Rows rows;
  for (const auto& [name, source] : kSources) {
    rows.emplace_back([&priorities, name = name, source = source](TableReader& reader) {
      const auto value = reader.Integer(name, -kFarthestPriority, kFarthestPriority);
      if (value) priorities[source] = static_cast<std::int32_t>(*value);
    });
  }
  return rows;
}

MotionConfig Read(const Table& table, const std::string& path, Findings& findings) {
  MotionConfig config;
  const std::filesystem::path folder = config_toml::FolderOf(path);
  config.motions = config_toml::Absolute(folder, "motions.toml");
  TableReader root(table, {1, 1}, "", findings);
  ReadRows(root, {row::File("motions", config.motions, folder),
                  row::Sub("priority", PriorityRows(config.priorities)),
                  row::Sub("board", {row::Time("wait_ms", config.board_wait),
                                     row::Time("silent_ms", config.board_silent),
                                     row::Time("feedback_ms", config.board_feedback)})});
  return config;
}

}  // namespace

ConfigReading ReadMotionConfigText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<ConfigReading>(
      text, path,
      [&](const Table& root, Findings& findings) { return Read(root, path, findings); });
}

ConfigReading ReadMotionConfigFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadMotionConfigText);
}

}  // namespace musher::motion
