#include <algorithm>
#include <utility>

#include "musher/base/toml/file.hpp"
#include "musher/base/toml/table_reader.hpp"
#include "musher/behavior/skill/run.hpp"
#include "musher/behavior/skill/toml/read_compositions.hpp"
#include "musher/behavior/skill/toml/read_value.hpp"
#include "musher/behavior/skill/toml/skills_toml.hpp"

namespace musher::skill {
namespace {

using config_toml::Findings;
using config_toml::Member;
using config_toml::TableReader;
using config_toml::Word;

constexpr int kMostRetries = 1000;

class ConfigReader {
 public:
  ConfigReader(const Registry& registry, Findings& findings)
      : compositions_(registry, findings), findings_(findings) {}

  Config Read(const config_toml::Table& root) {
    TableReader table(root, {1, 1}, "", findings_);
    Config config;
    const config_toml::Table& skills = Members(table, "skill");
    for (const Member& member : skills) compositions_.Note(member);
    for (const Member& member : Members(table, "group")) ReadGroup(member, config);
    for (const Member& member : skills) {
      if (!compositions_.Has(member.key)) ReadSkill(member, config);
    }
    config.compositions = compositions_.Read([&](TableReader& reader, const Run& probe) {
      config.settings.emplace_back(probe.name(), ReadSettings(reader, probe.table()));
    });
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
    const std::vector<std::string> names = compositions_.Names();
    for (const Word& skill : table.Strings("skills").value_or(std::vector<Word>())) {
      if (std::ranges::find(names, skill.text) == names.end()) {
        UnknownName(findings_, skill.at, path + ".skills", "skill", skill.text, names);
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
    const Entry* entry = compositions_.known().Find(member.key);
    if (entry == nullptr) {
      return UnknownName(findings_, member.at, "skill", "skill", member.key, compositions_.Names());
    }
    const Run probe(entry->name, entry->make());
    TableReader table(*content, member.at, path, findings_);
    config.settings.emplace_back(member.key, ReadSettings(table, probe.table()));
  }

  Settings ReadSettings(TableReader& table, const Table& skill) {
    Settings settings;
    settings.run = Limit(table, "time_limit_ms");
    settings.cancel = Limit(table, "cancel_limit_ms");
    if (const auto retries = table.Integer("retries", 0, kMostRetries)) {
      settings.retries = static_cast<int>(*retries);
    }
    ReadStates(table, skill, settings);
    for (const Member& member : Members(table, "parameters")) {
      ReadParameter(findings_, member, skill, table.path() + ".parameters", settings.parameters);
    }
    table.RefuseOthers();
    return settings;
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
        UnknownName(findings_, member.at, path, "state", member.key, states);
      } else if (const auto limit = Limit(limits, member.key)) {
        settings.states.emplace_back(member.key, *limit);
      }
    }
  }

  CompositionReader compositions_;
  Findings& findings_;
};

}  // namespace

Parsed<Config> ReadConfig(std::string_view text, const std::string& file,
                          const Registry& registry) {
  return config_toml::ReadTextWith<Parsed<Config>>(
      text, file, [&](const config_toml::Table& root, Findings& findings) {
        return ConfigReader(registry, findings).Read(root);
      });
}

Parsed<Config> ReadConfigFile(const std::string& path, const Registry& registry) {
  return config_toml::ReadFileWith(path, [&](const std::string& text, const std::string& file) {
    return ReadConfig(text, file, registry);
  });
}

}  // namespace musher::skill
