#include "musher/modules/skills/plan/dispatcher_config.hpp"

#include "musher/base/toml/file.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/table_reader.hpp"

namespace musher::skills {
namespace {

using config_toml::Findings;
using config_toml::Table;
using config_toml::TableReader;

void ReadAction(TableReader& reader, std::string_view key, std::string& name, bool relative) {
  const auto action = reader.String(key);
  if (!action) return;
  name = action->text;
  if (relative ? config_toml::IsRelativeTopic(name) : config_toml::IsTopic(name)) return;
  reader.Fault(action->at, key,
               "expected the name of an action, as in \"skill_execution\", found " +
                   config_toml::Quote(name));
}

}  // namespace

DispatcherReading ReadDispatcherText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<DispatcherReading>(
      text, path, [](const Table& root, Findings& findings) {
        DispatcherConfig config;
        TableReader reader(root, {1, 1}, "", findings);
        ReadAction(reader, "action", config.action, false);
        ReadAction(reader, "robot_action", config.robot_action, true);
        PlanRules& rules = config.rules;
        rules.server_wait = reader.Time("server_wait_ms").value_or(rules.server_wait);
        rules.cancel_limit = reader.Time("cancel_limit_ms").value_or(rules.cancel_limit);
        reader.RefuseOthers();
        return config;
      });
}

DispatcherReading ReadDispatcherFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadDispatcherText);
}

}  // namespace musher::skills
