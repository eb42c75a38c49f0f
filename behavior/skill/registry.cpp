#include "musher/behavior/skill/registry.hpp"

#include <algorithm>

#include "musher/base/suggest.hpp"
#include "musher/behavior/skill/compose.hpp"
#include "musher/behavior/skill/run.hpp"

namespace musher::skill {
namespace {

void AddError(std::string& errors, const std::string& error) {
  errors += (errors.empty() ? "" : "\n") + error;
}

}  // namespace

Result<> Registry::Add(const std::string& name, Factory make) {
  if (name.empty() || name.find('/') != std::string::npos) {
    return Error{kCodeParametersInvalid,
                 "skill '" + name + "': a name is not empty, without a slash"};
  }
  if (Find(name) != nullptr) {
    return Error{kCodeParametersInvalid, "skill " + name + " is registered already"};
  }
  std::unique_ptr<Skill> skill = make ? make() : nullptr;
  if (!skill)
    return Error{kCodeParametersInvalid, "skill " + name + ": its factory returns no skill"};
  const Run probe(name, std::move(skill));
  if (!probe.built()) return probe.built();
  entries_.push_back({name, std::move(make)});
  return Ok();
}

const Entry* Registry::Find(std::string_view name) const {
  const auto found = std::ranges::find(entries_, name, &Entry::name);
  return found == entries_.end() ? nullptr : &*found;
}

std::vector<std::string> Registry::Names() const {
  std::vector<std::string> names;
  names.reserve(entries_.size());
  for (const Entry& entry : entries_) names.push_back(entry.name);
  return names;
}

Result<> Registry::Configure(const Config& config) {
  Registry configured = *this;
  std::string errors;
  const auto composed = [&](const std::string& name) {
    return std::ranges::find(config.compositions, name, &Config::Composition::name) !=
           config.compositions.end();
  };
  for (const auto& [name, settings] : config.settings) {
    if (!composed(name)) configured.Set(name, settings, errors);
  }
  for (const Config::Composition& composition : config.compositions) {
    const Result<> added =
        configured.Add(composition.name, Compose(composition.order, configured, composition.parts));
    if (!added) {
      AddError(errors, added.error().message);
      continue;
    }
    for (const auto& [name, settings] : config.settings) {
      if (name == composition.name) configured.Set(name, settings, errors);
    }
  }
  if (!errors.empty()) return Error{kCodeParametersInvalid, errors};
  *this = std::move(configured);
  return Ok();
}

void Registry::Set(const std::string& skill, const Settings& settings, std::string& errors) {
  const auto found = std::ranges::find(entries_, skill, &Entry::name);
  if (found == entries_.end()) return AddError(errors, NoSuch("skill", skill, Names()));
  found->settings = settings;
  const Run probe(skill, found->make(), settings);
  if (!probe.built()) AddError(errors, probe.built().error().message);
}

Result<std::vector<Entry>> Registry::Of(const Config& config, std::string_view robot) const {
  std::vector<std::string> kinds;
  std::vector<Entry> entries;
  for (const Config::Group& group : config.groups) {
    kinds.insert(kinds.end(), group.robots.begin(), group.robots.end());
    const bool of_robot = group.robots.empty() || std::ranges::count(group.robots, robot) > 0;
    for (const std::string& name : group.skills) {
      const Entry* entry = Find(name);
      if (entry == nullptr) return Error{kCodeParametersInvalid, NoSuch("skill", name, Names())};
      const bool known = std::ranges::find(entries, name, &Entry::name) != entries.end();
      if (of_robot && !known) entries.push_back(*entry);
    }
  }
  std::ranges::sort(kinds);
  kinds.erase(std::unique(kinds.begin(), kinds.end()), kinds.end());
  if (!std::ranges::binary_search(kinds, robot)) {
    return Error{kCodeParametersInvalid, NoSuch("kind of robot", robot, kinds)};
  }
  return entries;
}

}  // namespace musher::skill
