#include "musher/modules/skills/plan/dispatcher_config.hpp"

#include "musher/base/toml/file.hpp"
#include "musher/base/toml/rows.hpp"

namespace musher::skills {
namespace {

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::Row;
using config_toml::Table;
using config_toml::TableReader;

Row Action(std::string_view key, std::string& name, bool relative) {
  return row::Topic(key, name, "skill_execution", {.of = "an action", .relative = relative});
}

}  // namespace

Parsed<DispatcherConfig> ReadDispatcherText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<Parsed<DispatcherConfig>>(
      text, path, [](const Table& root, Findings& findings) {
        DispatcherConfig config;
        TableReader reader(root, {1, 1}, "", findings);
        PlanRules& rules = config.rules;
        ReadRows(reader, {Action("action", config.action, false),
                          Action("robot_action", config.robot_action, true),
                          row::Time("server_wait_ms", rules.server_wait),
                          row::Time("cancel_limit_ms", rules.cancel_limit)});
        return config;
      });
}

Parsed<DispatcherConfig> ReadDispatcherFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadDispatcherText);
}

}  // namespace musher::skills
