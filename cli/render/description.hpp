#pragma once
// What `musher describe` knows about one actuator, and how it is shown. Pure.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "musher/cli/machine/process_facts.hpp"
#include "musher/cli/render/log_lines.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/messages/musher_msgs/capabilities.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"

namespace musher::cli {

struct Description {
  struct Reach {
    std::string state;
    bool allowed = false;
    std::int32_t code = 0;
    std::string reason;  // why not
    bool lower = false;  // less active than its state now
  };

  std::string name;
  std::string machine;         // its name
  std::string why_no_machine;  // why no controller answers; empty: one does
  std::string machine_state;   // and its phase
  std::string machine_phase;
  std::optional<msg::ActuatorInfo> info;      // the controller's view
  std::optional<msg::ActuatorStatus> status;  // the actuator's own
  std::optional<msg::ActuatorHeartbeat> heartbeat;
  double heartbeat_age_s = 0;
  bool on_this_host = false;
  std::optional<ProcessFacts> process;
  std::optional<ActuatorConfig> config;
  std::string config_file;
  int config_line = 0;
  std::vector<Reach> reach;
  std::vector<msg::Capability> capabilities;  // those that use it
  std::vector<std::string> offers;  // "get_behavior", …: services that it is known to offer
  std::vector<msg::HistoryEntry> history;  // of the actuator, oldest first
  std::vector<std::string> events;         // of `history`, in the same order
  std::string log_file;
  std::string why_no_log;
  std::vector<LogEntry> log;  // its last lines
  std::int64_t now_wall_ns = 0;
  bool same_clock = true;  // `history` has the clock of this computer
};

// Since when it is in its state, by the history; 0: not known.
std::int64_t SinceOf(const Description& description);
// What a person does next: commands with their purpose.
struct Advice {
  std::string command;
  std::string purpose;
};
std::vector<Advice> AdviceFor(const Description& description);

std::string DescriptionText(const Description& description, bool colour);
std::string DescriptionJson(const Description& description);

// "3 s", "12 min", "5 h", "2 d"
std::string AgeText(double seconds);
// "12.3 MB"
std::string BytesText(std::uint64_t bytes);

}  // namespace musher::cli
