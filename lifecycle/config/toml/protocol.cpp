// `protocol` of one [actuator.<name>] and the keys that belong to one protocol only.

#include <algorithm>
#include <vector>

#include "musher/lifecycle/config/toml/draft.hpp"

namespace musher::config_toml {
namespace {

// Whether `key` is present and applies to this actuator; reports it where it does not apply.
bool Applies(std::string_view key, Protocol protocol, Protocol needed, std::string_view word,
             TableReader& reader) {
  if (!reader.Has(key) || protocol == needed) return reader.Has(key);
  reader.Fault(reader.At(key), key, "needs protocol = " + Quote(word));
  return false;
}

// The key may name the states that the actuator can be switched to. SetUp is the configure
// transition, and a self-check has no transition.
void ReadRos2States(const ActuatorConfig& config, TableReader& reader, Draft& draft,
                    std::map<State, Ros2State>& ros2_states) {
  const Table* table = reader.SubTable("ros2_states");
  if (table == nullptr) return;
  TableReader states(*table, reader.At("ros2_states"), reader.path() + ".ros2_states",
                     draft.findings);
  for (const Member& member : *table) {
    const auto goal =
        states.Choice<Ros2State>(member.key, {{"unconfigured", Ros2State::kUnconfigured},
                                              {"inactive", Ros2State::kInactive},
                                              {"active", Ros2State::kActive},
                                              {"finalized", Ros2State::kFinalized}});
    if (!CheckState({member.key, member.at}, "ros2_states", reader, draft)) continue;
    if (member.key == kSetUp || member.key == kSelfCheck) {
      reader.Fault(member.at, "ros2_states",
                   Quote(member.key) +
                       " cannot be mapped: SetUp configures the node, and a "
                       "self-check leaves it where it is");
    } else if (!MayList(config.name, State(member.key), draft)) {
      reader.Fault(member.at, "ros2_states", Quote(member.key) + " is not among its states");
    } else if (goal == Ros2State::kFinalized && member.key != kTearDown) {
      reader.Fault(member.at, "ros2_states",
                   "only TearDown can be \"finalized\", which a node cannot leave");
    } else if (goal) {
      ros2_states.emplace(member.key, *goal);
    }
  }
}

}  // namespace

void ReadProtocol(TableReader& reader, ActuatorConfig& config, Draft& draft) {
  const auto protocol =
      reader.Choice<Protocol>("protocol", {{"musher", Protocol::kMusher},
                                           {"cyberdog", Protocol::kCyberdog},
                                           {"ros2_lifecycle", Protocol::kRos2Lifecycle}});
  config.protocol = protocol.value_or(config.protocol);
  if (config.protocol == Protocol::kCyberdog) config.heartbeat_name = config.name;
  if (Applies("heartbeat_name", config.protocol, Protocol::kCyberdog, "cyberdog", reader)) {
    if (const auto name = reader.String("heartbeat_name")) {
      if (name->text.empty()) {
        reader.Fault(name->at, "heartbeat_name", "expected a name, found an empty string");
      }
      config.heartbeat_name = name->text;
    }
  }
  if (Applies("ros2_states", config.protocol, Protocol::kRos2Lifecycle, "ros2_lifecycle", reader)) {
    ReadRos2States(config, reader, draft, config.ros2_states);
  }
}

}  // namespace musher::config_toml
