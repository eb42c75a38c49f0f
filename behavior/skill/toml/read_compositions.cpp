#include "musher/behavior/skill/toml/read_compositions.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "musher/behavior/skill/compose.hpp"
#include "musher/behavior/skill/run.hpp"
#include "musher/behavior/skill/toml/read_value.hpp"

namespace musher::skill {
namespace {

using config_toml::Member;
using config_toml::TableReader;
using config_toml::Word;

// Each run makes all of its skills, and two parts in each level would double them.
constexpr std::size_t kMostSkills = 256;
constexpr std::size_t kDeepest = 32;
constexpr std::array<std::pair<std::string_view, Order>, 3> kOrders{
    {{"in_order", Order::kInOrder},
     {"parallel", Order::kParallel},
     {"first_to_finish", Order::kFirstToFinish}}};

}  // namespace

CompositionReader::CompositionReader(const Registry& registry, config_toml::Findings& findings)
    : known_(registry), findings_(findings) {}

void CompositionReader::Note(const Member& member) {
  const auto* content = member.value.As<config_toml::Table>();
  if (content == nullptr) return;
  for (const auto& [key, order] : kOrders) {
    if (Find(*content, key) == nullptr || Has(member.key)) continue;
    drafts_[member.key] = {.member = &member, .clashes = known_.Find(member.key) != nullptr};
    order_.push_back(member.key);
  }
}

std::vector<std::string> CompositionReader::Names() const {
  std::vector<std::string> names = known_.Names();
  for (const std::string& name : order_) {
    if (known_.Find(name) == nullptr) names.push_back(name);
  }
  return names;
}

std::vector<Config::Composition> CompositionReader::Read(const ReadRest& read_rest) {
  read_rest_ = read_rest;
  for (const std::string& name : order_) {
    if (!drafts_[name].begun) drafts_[name].skills = ReadOne(name);
  }
  return std::move(read_);
}

// How many skills it has, with those inside; 0: it has errors.
std::size_t CompositionReader::ReadOne(const std::string& name) {
  Draft& draft = drafts_[name];
  draft.begun = true;
  const Member& member = *draft.member;
  TableReader table(*member.value.As<config_toml::Table>(), member.at, "skill." + name, findings_);
  if (draft.clashes) {
    findings_.Error(member.at, table.path() + ": a skill of the robot has this name");
    draft.ended = true;
    return 0;
  }
  reading_.push_back(name);
  Config::Composition composition{name, Order::kInOrder, {}};
  std::size_t skills = 0;
  std::string used;
  for (const auto& [key, order] : kOrders) {
    if (!table.Has(key)) continue;
    if (!used.empty()) table.Fault(table.At(key), key, "it has " + used + " already");
    const bool second = !used.empty();
    used = key;
    composition.order = order;
    skills = ReadParts(table, used, composition.parts);
    if (second) skills = 0;
  }
  reading_.pop_back();
  draft.ended = true;
  if (skills == 0) return 0;
  const Result<> added = known_.Add(name, Compose(composition.order, known_, composition.parts));
  if (!added) {
    findings_.Error(table.At(used), table.path() + "." + used + ": " + added.error().message);
    return 0;
  }
  read_rest_(table, Run(name, known_.Find(name)->make()));
  read_.push_back(std::move(composition));
  return skills;
}

std::size_t CompositionReader::ReadParts(TableReader& table, const std::string& key,
                                         std::vector<Part>& parts) {
  const auto* array = table.Get(key)->As<config_toml::Array>();
  if (array == nullptr || array->empty()) {
    table.Fault(table.At(key), key, "expected a list of tables, such as [{ skill = \"wait\" }]");
    return 0;
  }
  std::size_t skills = 1;
  bool sound = true;
  for (std::size_t i = 0; i < array->size(); ++i) {
    const std::string path = table.path() + "." + key + "[" + std::to_string(i) + "]";
    const std::size_t inside = ReadPart((*array)[i], path, parts);
    sound = sound && inside > 0;
    skills += inside;
  }
  if (sound && skills > kMostSkills) {
    table.Fault(table.At(key), key,
                "it has " + std::to_string(skills) + " skills, with those inside; at most " +
                    std::to_string(kMostSkills) + " are allowed");
    return 0;
  }
  return sound ? skills : 0;
}

std::size_t CompositionReader::ReadPart(const config_toml::Value& value, const std::string& path,
                                        std::vector<Part>& parts) {
  const auto* content = value.As<config_toml::Table>();
  if (content == nullptr) {
    findings_.Error(value.at, path + ": expected a table, such as { skill = \"wait\" }");
    return 0;
  }
  TableReader table(*content, value.at, path, findings_);
  table.Require("skill", "the name of a skill");
  const std::optional<Word> skill = table.String("skill");
  const std::size_t skills = skill ? SizeOf(*skill, path) : 0;
  if (skills == 0) return 0;
  const Entry* entry = known_.Find(skill->text);
  const Run probe(entry->name, entry->make());
  Part part{skill->text, {}};
  bool sound = true;
  for (const Member& member : *content) {
    if (member.key == "skill") continue;
    ReadParameter(findings_, member, probe.table(), path, part.parameters);
    sound = sound && part.parameters.Find(member.key) != nullptr;
  }
  parts.push_back(std::move(part));
  return sound ? skills : 0;
}

// Reads the skill before, if it is a composition that was not read yet.
std::size_t CompositionReader::SizeOf(const Word& skill, const std::string& path) {
  const auto draft = drafts_.find(skill.text);
  if (draft == drafts_.end() || draft->second.clashes) {
    if (known_.Find(skill.text) != nullptr) return 1;
    UnknownName(findings_, skill.at, path, "skill", skill.text, Names());
    return 0;
  }
  if (draft->second.begun && !draft->second.ended) {
    std::string cycle;
    for (auto name = std::ranges::find(reading_, skill.text); name != reading_.end(); ++name) {
      cycle += *name + " → ";
    }
    findings_.Error(skill.at, path + ": " + skill.text + " runs itself: " + cycle + skill.text);
    return 0;
  }
  if (!draft->second.begun) {
    if (reading_.size() >= kDeepest) {
      findings_.Error(skill.at, path + ": more than " + std::to_string(kDeepest) +
                                    " compositions are inside of each other");
      return 0;
    }
    draft->second.skills = ReadOne(skill.text);
  }
  return draft->second.skills;
}

}  // namespace musher::skill
