// [capability.*]: the actuators that the robot's functions use, and the states in which they run.

#include <algorithm>

#include "musher/base/toml/names.hpp"
#include "musher/lifecycle/config/toml/draft.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher::config_toml {
namespace {

class CapabilityReader {
 public:
  CapabilityReader(const Member& member, const Table& table, Draft& draft)
      : reader_(table, member.value.at, "capability." + member.key, draft.findings), draft_(draft) {
    capability_.name = member.key;
    if (IsName(member.key)) return;
    draft.findings.Error(member.at, "capability: expected " + std::string(kNameRule) + ", found " +
                                        Quote(member.key));
  }

  CapabilityConfig Read() {
    reader_.Require("actuators", "an array of strings");
    if (const auto word = reader_.String("description")) capability_.description = word->text;
    ReadActuators();
    ReadStates();
    if (const auto percent = reader_.Integer("min_battery", 1, 100, "%")) {
      capability_.min_battery = static_cast<int>(*percent);
    }
    reader_.RefuseOthers();
    return std::move(capability_);
  }

 private:
  void ReadActuators() {
    for (const Word& word : reader_.Strings("actuators").value_or(std::vector<Word>{})) {
      if (!IsActuator(word)) continue;
      const auto actuator = draft_.config.IndexOf(word.text);
      if (!actuator) continue;  // it has no table, which has been reported
      capability_.actuators.push_back(word.text);
      if (draft_.config.actuators[*actuator].protocol == Protocol::kMusher) continue;
      reader_.Warn(word.at, "actuators",
                   Quote(word.text) +
                       " has another protocol and does not enforce it; the capability is "
                       "only published");
    }
  }

  bool IsActuator(const Word& word) {
    if (!draft_.actuator_names) return false;  // unknown, which has been reported
    std::vector<std::string_view> names;
    for (const Word& name : *draft_.actuator_names) names.push_back(name.text);
    if (std::find(names.begin(), names.end(), word.text) != names.end()) return true;
    reader_.Fault(word.at, "actuators",
                  "unknown actuator " + Quote(word.text) + draft_.findings.Guess(word.text, names));
    return false;
  }

  void ReadStates() {
    if (!reader_.Has("states")) {
      capability_.states = {State(kActive)};
      return;
    }
    for (const Word& word : reader_.Strings("states").value_or(std::vector<Word>{})) {
      // A start may stop in SelfCheck.
      const bool good = word.text == kSelfCheck ? CheckState(word, "states", reader_, draft_)
                                                : CheckRankedState(word, "states", reader_, draft_);
      if (!good) continue;
      capability_.states.emplace_back(word.text);
      CheckActuatorsList(word);
      if (word.text != kError && word.text != kTearDown) continue;
      reader_.Warn(word.at, "states",
                   "in " + Quote(word.text) + " a robot is expected to rest; is that intended?");
    }
  }

  void CheckActuatorsList(const Word& state) {
    for (const std::string& name : capability_.actuators) {
      if (MayList(name, State(state.text), draft_)) continue;
      reader_.Fault(state.at, "states",
                    Quote(state.text) + " is not among the states of " + Quote(name));
    }
  }

  TableReader reader_;
  Draft& draft_;
  CapabilityConfig capability_;
};

}  // namespace

void ReadCapabilities(TableReader& root, Draft& draft) {
  const Table* tables = root.SubTable("capability");
  if (tables == nullptr) return;
  TableReader all(*tables, root.At("capability"), "capability", draft.findings);
  for (const Member& member : *tables) {
    if (const auto* table = member.value.As<Table>()) {
      draft.config.capabilities.push_back(CapabilityReader(member, *table, draft).Read());
    } else {
      all.Fault(member.value.at, member.key,
                "expected a table, found " + std::string(TypeName(member.value)));
    }
  }
}

}  // namespace musher::config_toml
