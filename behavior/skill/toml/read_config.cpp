#include <algorithm>
#include <utility>

#include "musher/base/toml/file.hpp"
#include "musher/base/toml/table_reader.hpp"
#include "musher/behavior/skill/run.hpp"
#include "musher/behavior/skill/toml/read_value.hpp"
#include "musher/behavior/skill/toml/skills_toml.hpp"

namespace musher::skill {
namespace {

using config_toml::Findings;
using config_toml::Member;
using config_toml::Position;
using config_toml::Quote;
using config_toml::TableReader;
using config_toml::Word;

constexpr int kMostRetries = 1000;

class ConfigReader {
 public:
  ConfigReader(const Registry& registry, Findings& findings)
      : names_(registry.Names()), registry_(registry), findings_(findings) {}

  Config Read(const config_toml::Table& root) {
    TableReader table(root, {1, 1}, "", findings_);
    Config config;
    for (const Member& member : Members(table, "group")) ReadGroup(member, config);
    for (const Member& member : Members(table, "skill")) ReadSkill(member, config);
    table.RefuseOthers();
    return config;
  }

 private:
  static const config_toml::Table& Members(TableReader& table, std::string_view key) {
    static const config_toml::Table none;
    const config_toml::Table* members = table.SubTable(key);
    return members == nullptr ? none : *members;
  }

  const config_toml::Table* TableOf(const Member& member, const std::string& path) {
    const auto* table = member.value.As<config_toml::Table>();
    if (table == nullptr) findings_.Error(member.value.at, path + ": expected a table");
    return table;
  }

  void Unknown(Position at, const std::string& path, const std::string& what,
               const std::string& name, const std::vector<std::string>& known) {
    const std::vector<std::string_view> candidates(known.begin(), known.end());
    findings_.Error(
        at, path + ": there is no " + what + " " + Quote(name) + findings_.Guess(name, candidates));
  }

  void ReadGroup(const Member& member, Config& config) {
    const std::string path = "group." + member.key;
    const config_toml::Table* content = TableOf(member, path);
    if (content == nullptr) return;
    TableReader table(*content, member.at, path, findings_);
    Config::Group group{member.key, {}, {}};
    for (const Word& robot : table.Strings("robots").value_or(std::vector<Word>())) {
      group.robots.push_back(robot.text);
    }
    table.Require("skills", "the names of its skills");
    for (const Word& skill : table.Strings("skills").value_or(std::vector<Word>())) {
      if (registry_.Find(skill.text) == nullptr) {
        Unknown(skill.at, path + ".skills", "skill", skill.text, names_);
      }
      group.skills.push_back(skill.text);
    }
    table.RefuseOthers();
    config.groups.push_back(std::move(group));
  }

  void ReadSkill(const Member& member, Config& config) {
    const std::string path = "skill." + member.key;
    const config_toml::Table* content = TableOf(member, path);
    if (content == nullptr) return;
    const Entry* entry = registry_.Find(member.key);
    if (entry == nullptr) return Unknown(member.at, "skill", "skill", member.key, names_);
    const Run probe(entry->name, entry->make());
    TableReader table(*content, member.at, path, findings_);
    Settings settings;
    settings.run = Limit(table, "time_limit_ms");
    settings.cancel = Limit(table, "cancel_limit_ms");
    if (const auto retries = table.Integer("retries", 0, kMostRetries)) {
      settings.retries = static_cast<int>(*retries);
    }
    ReadStates(table, probe.table(), settings);
    ReadParameters(table, probe.table(), settings);
    table.RefuseOthers();
    config.settings.emplace_back(member.key, std::move(settings));
  }

  static std::optional<Duration> Limit(TableReader& table, std::string_view key) {
    const auto limit = table.Time(key, 0);
    return limit == Duration{} ? std::optional(kNoLimit) : limit;
  }

  void ReadStates(TableReader& table, const Table& skill, Settings& settings) {
    constexpr std::string_view kKey = "state_limits_ms";
    const config_toml::Table* content = table.SubTable(kKey);
    if (content == nullptr) return;
    const std::string path = table.path() + "." + std::string(kKey);
    TableReader limits(*content, table.At(kKey), path, findings_);
    std::vector<std::string> states;
    const auto& all = skill.chart().states;
    for (std::size_t i = fsm::Index(skill.first()); i < all.size(); ++i) {
      states.push_back(all[i].name);
    }
    for (const Member& member : *content) {
      if (std::ranges::find(states, member.key) == states.end()) {
        Unknown(member.at, path, "state", member.key, states);
      } else if (const auto limit = Limit(limits, member.key)) {
        settings.states.emplace_back(member.key, *limit);
      }
    }
  }

  void ReadParameters(TableReader& table, const Table& skill, Settings& settings) {
    const std::string path = table.path() + ".parameters";
    std::vector<std::string> names;
    for (const Table::Parameter& parameter : skill.parameters()) names.push_back(parameter.name);
    for (const Member& member : Members(table, "parameters")) {
      const auto known = std::ranges::find(names, member.key);
      if (known == names.end()) {
        Unknown(member.at, path, "parameter", member.key, names);
        continue;
      }
      const auto index = static_cast<std::size_t>(known - names.begin());
      const Kind kind = skill.parameters()[index].kind;
      const auto read = ReadValue(member.value);
      const auto value = read ? std::optional(As(kind, *read)) : std::nullopt;
      if (value && value->ok()) {
        settings.parameters.Set(member.key, value->value());
      } else {
        findings_.Error(member.value.at,
                        path + "." + member.key + ": expected " + std::string(Name(kind)));
      }
    }
  }

  const std::vector<std::string> names_;
  const Registry& registry_;
  Findings& findings_;
};

}  // namespace

ConfigReading ReadConfig(std::string_view text, const std::string& file, const Registry& registry) {
  return config_toml::ReadTextWith<ConfigReading>(
      text, file, [&](const config_toml::Table& root, Findings& findings) {
        return ConfigReader(registry, findings).Read(root);
      });
}

ConfigReading ReadConfigFile(const std::string& path, const Registry& registry) {
  return config_toml::ReadFileWith(path, [&](const std::string& text, const std::string& file) {
    return ReadConfig(text, file, registry);
  });
}

}  // namespace musher::skill
