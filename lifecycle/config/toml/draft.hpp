#pragma once
// A machine's config while it is being read. Sections are read in the order of the functions below,
// since later ones refer to earlier ones. All errors go into `findings`; reading continues with the
// valid parts, and with the corrected word where a word is plainly a typing error: no error hides
// another, and none is a consequence of another.

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/table_reader.hpp"
#include "musher/lifecycle/config/config.hpp"

namespace musher::config_toml {

inline constexpr std::size_t kMostStates = 64;
inline constexpr std::size_t kMostActuators = 4096;

struct Draft {
  Findings findings;
  std::filesystem::path folder;  // that relative paths start from
  MachineConfig config;

  std::vector<std::string_view> known_states;     // built in or declared by [[state]]
  std::unordered_set<std::string> listed_states;  // of the machine, typing errors corrected
  bool states_read = false;  // false: controller.states is missing or faulty as a whole

  std::optional<std::vector<Word>> actuator_names;  // of controller.actuators, nothing if faulty
  Position actuators_at;
  Position transport_at;              // of transport.profile
  Position failover_at;               // of controller.failover_ms
  std::set<std::string> known_hosts;  // all [host.*], also faulty ones
  std::set<std::string> used_hosts;
  // What each actuator lists, typing errors corrected; none where its states are missing or faulty
  // as a whole.
  std::map<std::string, std::set<State>> actuator_states;
};

// An actuator whose relations to other actuators are not yet checked.
struct ActuatorDraft {
  ActuatorConfig config;
  Position at;
  std::vector<Word> after;
  std::vector<Word> binds_to;
};

void ReadOwnStates(TableReader& root, Draft& draft);
void ReadController(TableReader& root, Draft& draft);
void ReadTransitions(TableReader& root, Draft& draft);
void ReadTransport(TableReader& root, Draft& draft);
void CheckFailover(Draft& draft);
void ReadSecurity(TableReader& root, Draft& draft);
void ReadSafety(TableReader& root, Draft& draft);
void WarnOfSharedNetwork(Draft& draft);  // after [controller], [transport] and [security]
void ReadView(TableReader& root, Draft& draft);
void ReadPolicy(TableReader& root, Draft& draft);  // after the states
void ReadRos2(TableReader& root, Draft& draft);    // after the states
void ReadHosts(TableReader& root, Draft& draft);   // after [transport]
void ReadActuators(TableReader& root, Draft& draft);
void WarnOfUnusedHosts(TableReader& root, Draft& draft);
void ReadCapabilities(TableReader& root, Draft& draft);

// One [actuator.<name>].
ActuatorDraft ReadActuator(const Member& member, const Table& table, Draft& draft);

// Its `protocol` and the keys that belong to it; name and states have been read.
void ReadProtocol(TableReader& reader, ActuatorConfig& config, Draft& draft);

// Its `host`; command and protocol have been read.
void ReadHostOf(TableReader& reader, ActuatorConfig& config, Draft& draft);

// What its process may use; the host has been read.
void ReadLimits(TableReader& reader, ActuatorConfig& config, const Draft& draft);

// `after` and `binds_to`: unknown names, the actuator itself, later stages, cycles. `tables` are
// all [actuator.*], also those that controller.actuators does not list.
void CheckOrder(const std::vector<ActuatorDraft>& actuators, const Table& tables,
                Findings& findings);

// Whether the actuator lists the state. True where its states could not be read, as that has been
// reported already.
bool MayList(const std::string& actuator, const State& state, const Draft& draft);

// Whether the machine has the state; reports it under `key` of `reader` if not. Where the machine's
// states could not be read, which has been reported already: whether the state exists at all.
bool CheckState(const Word& state, std::string_view key, TableReader& reader, Draft& draft);

// The same, and that it has a rank, so that the machine can stay in it.
bool CheckRankedState(const Word& state, std::string_view key, TableReader& reader, Draft& draft);

}  // namespace musher::config_toml
