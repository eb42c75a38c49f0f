#include "musher/cli/config/config_diff.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <utility>

#include "musher/base/joined.hpp"

namespace musher::cli {
namespace {

using Kind = ConfigChange::Kind;
using WordKey = std::pair<std::string, std::string>;  // table, key
constexpr std::string_view kActuatorTable = "actuator.";
constexpr std::string_view kCapabilityTable = "capability.";

std::vector<std::string> Missing(const std::vector<std::string>& from,
                                 const std::vector<std::string>& in) {
  std::vector<std::string> missing;
  std::set_difference(from.begin(), from.end(), in.begin(), in.end(), std::back_inserter(missing));
  return missing;
}

ConfigChange Changed(const ConfigWord& before, const ConfigWord& after) {
  ConfigChange change{Kind::kChanged, after.table, after.key, "", "", false, after.effect};
  change.is_set = before.is_set && after.is_set;
  change.before = Joined(change.is_set ? Missing(before.values, after.values) : before.values);
  change.after = Joined(change.is_set ? Missing(after.values, before.values) : after.values);
  return change;
}

class Comparison {
 public:
  Comparison(const MachineConfig& before, const MachineConfig& after)
      : before_(WordsOf(before)), after_(WordsOf(after)) {
    for (const ConfigWord& word : before_) old_[{word.table, word.key}] = &word;
    for (const ConfigWord& word : after_) new_[{word.table, word.key}] = &word;
  }

  // In the order of the new words, where a removed one stands after those of its table.
  std::vector<ConfigChange> Run() {
    for (const ConfigWord& word : after_) {
      if (word.key.empty()) EndTable(word.table);
      AddNew(word);
    }
    EndTable("");
    for (const ConfigWord& word : before_) {
      if (!HasTable(new_, word.table) && word.key.empty()) Add(Kind::kRemoved, word);
    }
    return std::move(changes_);
  }

 private:
  using Index = std::map<WordKey, const ConfigWord*>;

  static bool HasTable(const Index& index, const std::string& table) {
    return index.contains({table, ""});
  }
  void AddNew(const ConfigWord& word) {
    const auto old = old_.find({word.table, word.key});
    if (old == old_.end()) {
      if (word.key.empty() || HasTable(old_, word.table)) Add(Kind::kAdded, word);
    } else if (old->second->values != word.values || old->second->is_set != word.is_set) {
      changes_.push_back(Changed(*old->second, word));
    }
  }
  // The removed keys of the table whose words end here; the next one is `next`.
  void EndTable(const std::string& next) {
    for (const ConfigWord& word : before_) {
      if (word.table == table_ && !new_.contains({word.table, word.key})) Add(Kind::kRemoved, word);
    }
    table_ = next;
  }
  void Add(Kind kind, const ConfigWord& word) {
    const std::string value = Joined(word.values);
    changes_.push_back({kind, word.table, word.key, kind == Kind::kRemoved ? value : "",
                        kind == Kind::kAdded ? value : "", word.is_set, word.effect});
  }

  const std::vector<ConfigWord> before_;
  const std::vector<ConfigWord> after_;
  Index old_;
  Index new_;
  std::string table_;
  std::vector<ConfigChange> changes_;
};

void AddUsers(const MachineConfig& config, std::string_view capability,
              std::set<std::string>& users) {
  const CapabilityConfig* declared = config.CapabilityOf(capability);
  if (declared != nullptr) users.insert(declared->actuators.begin(), declared->actuators.end());
}

}  // namespace

ConfigDiff Compare(const MachineConfig& before, const MachineConfig& after) {
  ConfigDiff diff;
  diff.before = before.file;
  diff.after = after.file;
  diff.changes = Comparison(before, after).Run();
  std::set<std::string> restarts;
  for (const ConfigChange& change : diff.changes) {
    diff.needs_new_start = diff.needs_new_start || change.effect == ChangeEffect::kNewStart;
    const bool of_actuator = change.table.starts_with(kActuatorTable);
    const std::string actuator = of_actuator ? change.table.substr(kActuatorTable.size()) : "";
    if (of_actuator && change.key.empty() && change.kind == Kind::kRemoved) {
      diff.left_behind.insert(actuator);
    }
    if (change.effect != ChangeEffect::kRestart) continue;
    if (of_actuator) {
      restarts.insert(actuator);
    } else if (change.table.starts_with(kCapabilityTable)) {
      AddUsers(before, change.table.substr(kCapabilityTable.size()), restarts);
      AddUsers(after, change.table.substr(kCapabilityTable.size()), restarts);
    } else {  // a rank, which every actuator uses
      for (const ActuatorConfig& each : after.actuators) restarts.insert(each.name);
    }
  }
  for (const std::string& name : restarts) {
    if (before.IndexOf(name) && after.IndexOf(name)) diff.restarts.insert(name);
  }
  return diff;
}

}  // namespace musher::cli
