#include "musher/modules/motion/motion_config.hpp"

#include <array>
#include <utility>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/table_reader.hpp"

namespace musher::motion {
namespace {

using config_toml::Findings;
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

MotionConfig Read(const Table& table, const std::string& path, Findings& findings) {
  MotionConfig config;
  TableReader root(table, {1, 1}, "", findings);
  const auto motions = root.String("motions");
  config.motions =
      config_toml::Absolute(config_toml::FolderOf(path), motions ? motions->text : "motions.toml");
  if (const Table* priority = root.SubTable("priority")) {
    TableReader reader(*priority, root.At("priority"), "priority", findings);
    for (const auto& [name, source] : kSources) {
      const auto value = reader.Integer(name, -kFarthestPriority, kFarthestPriority);
      if (value) config.priorities[source] = static_cast<std::int32_t>(*value);
    }
    reader.RefuseOthers();
  }
  if (const Table* board = root.SubTable("board")) {
    TableReader reader(*board, root.At("board"), "board", findings);
    config.board_wait = reader.Time("wait_ms").value_or(config.board_wait);
    config.board_silent = reader.Time("silent_ms").value_or(config.board_silent);
    config.board_feedback = reader.Time("feedback_ms").value_or(config.board_feedback);
    reader.RefuseOthers();
  }
  root.RefuseOthers();
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
