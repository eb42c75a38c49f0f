#include "musher/modules/skills/load_skills.hpp"

#include <utility>

#include "musher/behavior/skill/toml/skills_toml.hpp"

namespace musher::skills {
namespace {

LoadedSkills WithError(LoadedSkills loaded, const std::string& file,
                       const config_toml::Position& at, const std::string& message) {
  loaded.diagnostics.push_back({file, at.line, at.column, Severity::kError, message});
  return loaded;
}

}  // namespace

LoadedSkills LoadSkills(const SkillsConfig& config, Robot& robot, const RegisterFunction& add) {
  LoadedSkills loaded;
  skill::Registry registry;
  if (const Result<> added = add(registry, robot); !added) {
    return WithError(std::move(loaded), config.file, {}, added.error().message);
  }
  if (config.skill_config.empty()) {
    loaded.entries = registry.All();
    return loaded;
  }
  Parsed<skill::Config> reading = skill::ReadConfigFile(config.skill_config, registry);
  loaded.diagnostics = std::move(reading.diagnostics);
  if (!reading.config) return loaded;
  if (const Result<> fits = registry.Configure(*reading.config); !fits) {
    return WithError(std::move(loaded), config.skill_config, {}, fits.error().message);
  }
  Result<std::vector<skill::Entry>> entries = registry.Of(*reading.config, config.kind);
  if (!entries) {
    return WithError(std::move(loaded), config.file, config.kind_at,
                     "kind: " + entries.error().message + " (" + config.skill_config + ")");
  }
  if (entries.value().empty()) {
    return WithError(std::move(loaded), config.file, config.kind_at,
                     "kind: a " + config.kind + " has no skill by " + config.skill_config);
  }
  loaded.entries = std::move(entries).value();
  return loaded;
}

}  // namespace musher::skills
