#pragma once
// The metrics of one robot: it is given what the robot publishes and writes what a monitoring
// system reads (exposition.hpp). docs/many-robots.md lists the families.
//
// Counters begin with this object, and only grow. They count the entries of the controller's
// history that are handed over: each has to be once (JournalCursor). A restarted controller
// continues them.
// Outcomes and faults are recognised by event names and by the data of an entry, never by
// its sentence.
//
// The number of time series is bounded: only the actuators of the last status have any, at most
// kMostActuators, and at most kMostStates states are known beside the built-in ones. Other names
// are dropped and counted.
//
// Threads: any, one at a time; no clock, no IO. Times are of one steady clock.

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "musher/base/process_usage.hpp"
#include "musher/base/time.hpp"
#include "musher/lifecycle/ids.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"
#include "musher/view/metrics/exposition.hpp"

namespace musher::view {

class RobotMetrics {
 public:
  static constexpr std::size_t kMostActuators = 512;
  static constexpr std::size_t kMostStates = 32;   // of the config's own
  static constexpr std::size_t kLongestName = 64;  // bytes

  RobotMetrics();

  void On(const msg::MachineStatus& status, Time now);
  // No controller publishes any more: the state of the machine is not known, counters stay.
  void OnControllerLost();
  // After the first status. `event` is the entry's event name; "" from an older controller.
  void On(const msg::HistoryEntry& entry, std::string_view event);
  // Before the first status heartbeats are ignored.
  void On(const msg::ActuatorHeartbeat& heartbeat, Time now);
  // Nothing: its process is not on this host, or has exited.
  void OnProcess(std::string_view actuator, const std::optional<ProcessUsage>& usage);
  // Lost by the readers of this process since its start.
  void OnLostSamples(std::uint64_t total) { lost_samples_ = total; }
  void OnClients(std::size_t pages, std::size_t foxglove) { clients_ = {pages, foxglove}; }
  // `complete`: with the newest history, if there is a controller.
  void OnScrape(bool complete);

  std::string Text(Time now, MetricsFormat format) const;

 private:
  static constexpr std::array<std::string_view, 5> kHealths = {"well", "starved", "hung", "crashed",
                                                               "partitioned"};
  static constexpr std::array<std::string_view, 5> kOutcomes = {"done", "done-degraded", "refused",
                                                                "undone", "superseded"};
  using PerOutcome = std::array<std::uint64_t, kOutcomes.size()>;

  struct Heartbeat {
    Time received;
    Duration period;
  };
  struct Actuator {
    msg::ActuatorInfo info;
    std::optional<Heartbeat> heartbeat;
    std::optional<ProcessUsage> usage;
    double cpu_seconds = 0;
    std::uint64_t restarts = 0;
    std::array<std::uint64_t, kHealths.size()> faults{};
    bool hung = false;  // and not recovered; its exit is not another fault
    PerOutcome switches{};
    std::map<std::string, DurationHistogram> commands;  // that were done, by target
    std::uint64_t overdue_commands = 0;
  };
  struct Target {
    PerOutcome switches{};
    DurationHistogram durations;
  };

  Actuator* Find(std::string_view name);
  // The name of the state as it is exposed: kUnknownState if there are too many.
  const std::string& Know(const std::string& state);
  void OnSwitch(const msg::HistoryEntry& entry, std::string_view event);
  void OnCommand(const msg::HistoryEntry& entry, bool is_done);
  void OnFault(const msg::HistoryEntry& entry, std::string_view event);
  void WriteMachine(Exposition& text) const;
  void WriteSwitches(Exposition& text) const;
  void WriteCommands(Exposition& text) const;
  void WriteStates(Exposition& text) const;
  void WriteFaults(Exposition& text) const;
  void WriteHeartbeats(Exposition& text, Time now) const;
  void WriteProcesses(Exposition& text) const;
  void WriteView(Exposition& text) const;
  std::vector<std::string_view> States() const;

  std::optional<msg::MachineStatus> status_;  // without its actuators
  bool has_controller_ = false;
  std::vector<Actuator> actuators_;  // in the order of the config
  std::vector<std::string> states_;  // the built-in ones, then others in the order of arrival
  std::map<std::string, Target> targets_;
  std::map<CommandNumber, std::int64_t> begun_;  // switch number -> wall_ns
  std::uint64_t lost_samples_ = 0;
  std::pair<std::size_t, std::size_t> clients_;
  std::uint64_t scrapes_ = 0;
  std::uint64_t incomplete_scrapes_ = 0;
  std::uint64_t dropped_actuators_ = 0;
  std::uint64_t dropped_states_ = 0;
};

}  // namespace musher::view
