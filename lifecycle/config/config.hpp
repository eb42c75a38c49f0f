#pragma once
// The state config as one validated, immutable value. A MachineConfig that exists is consistent:
// the readers that make one (config_toml.hpp) report every error and then give none. The file is
// not read again after that.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/network_profile.hpp"
#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/lifecycle/config/policy_config.hpp"
#include "musher/lifecycle/config/process_limits.hpp"
#include "musher/lifecycle/config/ros2_config.hpp"
#include "musher/lifecycle/config/ros2_states.hpp"
#include "musher/lifecycle/per_actuator.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher {

// How an actuator is driven.
enum class Protocol {
  kMusher,         // Musher's own contract, with fencing and definite outcomes
  kCyberdog,       // CyberDog's FsMachine service and heartbeats
  kRos2Lifecycle,  // an unmodified ROS 2 managed node
};

std::string_view ProtocolName(Protocol protocol);  // as the config writes it

// Whether the outcome of a command can be queried. Of an actuator that cannot be queried and is
// overdue nothing is known until it answers or is restarted.
bool HasQuery(Protocol protocol);

enum class RestartPolicy { kNo, kOnFailure, kAlways };

// The exit code of a program that was called or configured wrongly: a restart does not help.
inline constexpr int kUsageExitCode = 2;

struct RestartConfig {
  RestartPolicy policy = RestartPolicy::kNo;
  Duration delay = Milliseconds(100);
  double growth = 2.0;
  Duration max_delay = Milliseconds(10'000);
  int limit = 5;                                // restarts in a row before the actuator is given up
  Duration reset_after = Milliseconds(60'000);  // healthy this long: the count is reset
  std::vector<int> prevent_exit_codes = {kUsageExitCode};  // not restarted after one of them

  bool finalized = false;  // a ROS 2 node that another client has finalized is restarted

  bool Prevents(int exit_code) const;

  friend bool operator==(const RestartConfig&, const RestartConfig&) = default;
};

// [host.<name>]: another host, whose systemd runs processes of this machine. The controller reaches
// it by ssh.
struct HostConfig {
  std::string name;
  std::string address;      // a name, an address, or an alias of ~/.ssh/config
  std::string user;         // empty: ssh chooses
  std::string key;          // absolute path of a private key; empty: ssh chooses
  std::string known_hosts;  // absolute path; empty: ssh's own files

  std::string Login() const;  // "root@10.0.0.2", "10.0.0.2"

  friend bool operator==(const HostConfig&, const HostConfig&) = default;
};

struct ActuatorConfig {
  std::string name;
  std::vector<State> states;         // the states it can be switched to, as the file lists them
  std::vector<Duration> times;       // what each may take, same order
  std::vector<std::string> command;  // argv; empty: not started by the controller
  std::string host;                  // that runs the command; empty: the controller's
  std::string cwd;                   // absolute; empty: the controller's own, with `host` "/"
  std::map<std::string, std::string> env;  // added to the controller's environment
  ProcessLimits limits;
  Protocol protocol = Protocol::kMusher;
  std::string heartbeat_name;              // of protocol cyberdog: its name in `manager_heartbeats`
  std::map<State, Ros2State> ros2_states;  // of ros2_lifecycle: where it differs from Ros2GoalOf()
  int stage = 1;
  std::vector<std::string> after;     // actuators that must be up first
  std::vector<std::string> binds_to;  // actuators whose restart takes this one down and up again
  bool critical = false;
  // Codes of a self-check that count as failed; with any other code the actuator is degraded and
  // continues. None: all codes count.
  std::optional<std::vector<std::int32_t>> critical_codes;
  RestartConfig restart;
  std::optional<Duration> checkpoint;       // longest silence of the work thread
  std::map<State, Duration> checkpoint_in;  // the same while the callback of a state runs
  std::optional<Duration> controller_lost;  // without a controller this long: on_controller_lost
  State on_controller_lost;                 // empty: the highest listed state up to Protected
  State on_lost;  // the machine's state once this actuator is given up; may be empty
  std::int64_t log_size_bytes = 50ll << 20;  // of its process, with older, compressed parts

  bool Lists(std::string_view state) const;
  // What a switch to `state` may take; nullopt where the state is not listed.
  std::optional<Duration> TimeFor(std::string_view state) const;

  friend bool operator==(const ActuatorConfig&, const ActuatorConfig&) = default;
};

// A transition of the run phase: the machine may go from one state to another.
struct FlowEdge {
  State from;
  State to;

  friend bool operator==(const FlowEdge&, const FlowEdge&) = default;
};

// A function of the robot, and where it may run. An undeclared one runs in Active only.
struct CapabilityConfig {
  std::string name;
  std::string description;
  std::vector<std::string> actuators;  // it uses these; all have to allow it
  std::vector<State> states;           // it runs in these, as the file lists them
  std::optional<int> min_battery;      // %; below, or where the level is unknown, it does not run

  bool RunsIn(std::string_view state) const;
  bool Takes(std::string_view actuator) const;

  friend bool operator==(const CapabilityConfig&, const CapabilityConfig&) = default;
};

// [view]: the page of the machine, served by musher-view beside the controller.
struct ViewConfig {
  int port = 8765;
  std::string bind = "127.0.0.1";  // an address of this host; "0.0.0.0": all
  std::string token_file;          // absolute; empty: view_token in the state's folder of the user
  std::vector<std::string> hosts;  // further names and origins from which browsers may connect
  bool stop_needs_login = false;   // else each person who reaches the page may engage the stop

  friend bool operator==(const ViewConfig&, const ViewConfig&) = default;
};

struct MachineConfig {
  std::string name;        // of the machine; the file's stem unless the file gives one
  std::string file;        // where it was read from, for messages only
  std::string hash;        // 16 hex digits of the file's bytes, to notice different copies
  std::string name_space;  // of all topics and services: "" or "dog1" or "fleet/dog1", no outer '/'
  std::string state_dir;   // absolute; the controller's lock, epoch, journal and logs

  std::vector<State> states;  // of the machine, as the file lists them
  Duration default_time{};
  State default_state{kUninitialized};
  Duration shutdown_budget = Milliseconds(10'000);
  std::string log;        // file of the controller's log; empty: state_dir/controller.log
  std::string log_group;  // of the host: may read state_dir; empty: the controller's user alone
  std::int64_t journal_size_bytes = 64ll << 20;  // the journal is trimmed beyond this
  std::int64_t log_size_bytes = 50ll << 20;      // of the controller's log, with its older parts
  std::int64_t logs_size_bytes = 500ll << 20;    // of all logs

  std::map<State, Rank> ranks;  // built-in ranks, and the ranks of [[state]]
  std::vector<FlowEdge> flow;   // the default flow, or the file's [[transition]]
  TransportProfile transport = TransportProfile::kLocal;
  std::vector<std::string> interfaces;  // of "lan", beside the loopback; none: chosen by the host
  std::optional<RosDistro>
      ros_distro;  // whose message layouts are used; none: of ROS_DISTRO, else of Jazzy
  ClockSource clock = ClockSource::kSteady;
  std::string
      keys;  // absolute folder of credentials: only authenticated participants; empty: no security

  // Above DeActive an actuator stops when no permit arrives for so long; none: needs no permit.
  std::optional<Duration> permit;
  std::string rules_file;  // absolute; the user's rules for stable states; empty: none

  // A standby of another host leads after this time without a controller; none: there is no
  // standby.
  std::optional<Duration> failover;
  std::vector<HostConfig> hosts;  // in the order of the file
  bool own_units = false;  // processes of the controller's host are units of its systemd, too
  std::optional<PolicyConfig> policy;  // none: no rules
  Ros2Config ros2;
  std::optional<ViewConfig> view;  // none: no page is served

  PerActuator<ActuatorConfig> actuators;       // in the order of [controller].actuators
  std::vector<CapabilityConfig> capabilities;  // in the order of the file

  // Index into `actuators`, nullopt for an unknown name.
  std::optional<ActuatorIndex> IndexOf(std::string_view actuator) const;
  // nullptr for an undeclared host, and for the controller's, "".
  const HostConfig* HostOf(std::string_view name) const;
  // nullptr for an undeclared capability.
  const CapabilityConfig* CapabilityOf(std::string_view capability) const;
  // The rank of a state of this machine; nullopt for SetUp, SelfCheck, Uninitialized and unknown
  // states.
  std::optional<Rank> RankOf(std::string_view state) const;
  bool HasState(std::string_view state) const;
  // The time an actuator may take for `state`: its own, else default_time.
  Duration TimeFor(ActuatorIndex actuator, std::string_view state) const;

  friend bool operator==(const MachineConfig&, const MachineConfig&) = default;
};

// NoSuch() (suggest.hpp) for an actuator of `config`.
Error UnknownActuator(std::string_view name, const MachineConfig& config);

// The actuators of a host that has one of `addresses` are the controller's own there: so one config
// serves on each computer that may lead.
void TakeOwnHosts(MachineConfig& config, const std::vector<std::string>& addresses);

// The flow where a config has none: all transitions among Active, Protected, DeActive, LowPower and
// OTA; from each of them and from Error to Error and TearDown; from Error to SelfCheck; and from a
// SelfCheck that followed Error to DeActive and Active. Only states that `states` lists are used.
std::vector<FlowEdge> DefaultFlow(const std::vector<State>& states);

}  // namespace musher
