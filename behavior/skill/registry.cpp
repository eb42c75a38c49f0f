#include "musher/behavior/skill/registry.hpp"

#include <algorithm>

#include "musher/base/suggest.hpp"
#include "musher/behavior/skill/run.hpp"

namespace musher::skill {

Result<> Registry::Add(const std::string& name, Factory make) {
  if (name.empty() || name.find('/') != std::string::npos) {
    return Error{kCodeParametersInvalid,
                 "skill '" + name + "': a name is not empty, without a slash"};
  }
  if (Find(name) != nullptr) {
    return Error{kCodeParametersInvalid, "skill " + name + " is registered already"};
  }
  std::unique_ptr<Skill> skill = make ? make() : nullptr;
  if (!skill) return Error{kCodeParametersInvalid, "skill " + name + ": its factory makes none"};
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
  std::vector<Entry> configured = entries_;
  std::string errors;
  const auto refuse = [&](const std::string& error) {
    errors += (errors.empty() ? "" : "\n") + error;
  };
  for (const auto& [name, settings] : config.settings) {
    const auto found = std::ranges::find(configured, name, &Entry::name);
    if (found == configured.end()) {
      refuse(NoSuch("skill", name, Names()));
      continue;
    }
    found->settings = settings;
    const Run probe(name, found->make(), settings);
    if (!probe.built()) refuse(probe.built().error().message);
  }
  if (!errors.empty()) return Error{kCodeParametersInvalid, errors};
  entries_ = std::move(configured);
  return Ok();
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
