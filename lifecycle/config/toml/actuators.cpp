// [actuator.*] as a whole: its tables have to match the names that [controller] lists.

#include <algorithm>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "musher/base/suggest.hpp"
#include "musher/lifecycle/config/toml/draft.hpp"

namespace musher::config_toml {
namespace {

using NameSet = std::unordered_set<std::string_view>;

// The tables that controller.actuators does not list; none where its names are unknown.
std::vector<const Member*> FindUnlisted(const Table& tables, const Draft& draft) {
  std::vector<const Member*> unlisted;
  if (!draft.actuator_names) return unlisted;
  NameSet listed;
  for (const Word& name : *draft.actuator_names) listed.insert(name.text);
  for (const Member& table : tables) {
    if (!listed.contains(table.key)) unlisted.push_back(&table);
  }
  return unlisted;
}

// A name that is near to an unlisted table may be a typing error, or both may be missing: each
// error is reported at its position, with the other as the suggestion.
void MatchNamesAndTables(const Table& tables, Draft& draft) {
  const std::vector<const Member*> unlisted = FindUnlisted(tables, draft);
  std::vector<std::string_view> candidates;
  candidates.reserve(unlisted.size());
  for (const Member* table : unlisted) candidates.push_back(table->key);
  NameSet known;
  for (const Member& table : tables) known.insert(table.key);
  std::unordered_map<std::string, std::string> meant_by;  // table -> name
  for (const Word& name : draft.actuator_names.value_or(std::vector<Word>{})) {
    if (known.contains(name.text)) continue;
    const std::string guess = draft.findings.Guess(name.text, candidates);
    if (!guess.empty()) meant_by.emplace(Nearest(name.text, candidates), name.text);
    draft.findings.Error(name.at, "controller.actuators: " + Quote(name.text) +
                                      " has no table [actuator." + name.text + "]" + guess);
  }
  for (const Member* table : unlisted) {
    const auto meant = meant_by.find(table->key);
    draft.findings.Error(
        table->value.at,
        "actuator." + table->key + ": is not listed in controller.actuators" +
            (meant == meant_by.end() ? "" : "; did you mean it by " + Quote(meant->second) + "?"));
  }
}

// False where `critical` is false or missing. A misspelt key may mean it.
bool MayBeCritical(const Member& actuator) {
  const std::vector<std::string_view> word = {"critical"};
  const auto* table = actuator.value.As<Table>();
  return table != nullptr && std::any_of(table->begin(), table->end(), [&](const Member& member) {
           if (member.key != word.front()) return !Nearest(member.key, word).empty();
           const auto* value = member.value.As<bool>();
           return value == nullptr || *value;
         });
}

// Sorts the actuators into the order of controller.actuators.
void Collect(std::vector<ActuatorDraft> actuators, Draft& draft) {
  std::unordered_map<std::string, std::size_t> places;
  for (std::size_t i = 0; i < actuators.size(); ++i) places.emplace(actuators[i].config.name, i);
  for (const Word& name : draft.actuator_names.value_or(std::vector<Word>{})) {
    const auto place = places.find(name.text);
    if (place == places.end()) continue;
    draft.config.actuators.push_back(std::move(actuators[place->second].config));
  }
}

}  // namespace

void ReadActuators(TableReader& root, Draft& draft) {
  const Table empty;
  const bool is_table = root.SubTable("actuator") != nullptr;
  if (root.Has("actuator") && !is_table) return;
  const Table& tables = is_table ? *root.SubTable("actuator") : empty;
  MatchNamesAndTables(tables, draft);
  std::vector<ActuatorDraft> actuators;
  actuators.reserve(tables.size());
  TableReader all(tables, root.At("actuator"), "actuator", draft.findings);
  for (const Member& member : tables) {
    if (const auto* table = member.value.As<Table>()) {
      actuators.push_back(ReadActuator(member, *table, draft));
    } else {
      all.Fault(member.value.at, member.key,
                "expected a table, found " + std::string(TypeName(member.value)));
    }
  }
  CheckOrder(actuators, tables, draft.findings);
  Collect(std::move(actuators), draft);
  if (!tables.empty() && !std::any_of(tables.begin(), tables.end(), MayBeCritical)) {
    draft.findings.Warning(draft.actuators_at,
                           "controller.actuators: no actuator is critical: none of them can keep "
                           "the machine from starting or bring it down when lost");
  }
}

}  // namespace musher::config_toml
