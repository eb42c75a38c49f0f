#pragma once
// What a controller's shell is given, and what its parts share.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "musher/base/unique_fd.hpp"
#include "musher/controller/journal/journal.hpp"
#include "musher/controller/link/actuator_link.hpp"
#include "musher/controller/process/child_processes.hpp"
#include "musher/controller/process/host_processes.hpp"
#include "musher/controller/process/process_probe.hpp"
#include "musher/controller/process/process_runner.hpp"
#include "musher/controller/shell/record_writer.hpp"
#include "musher/lifecycle/config/user_rules.hpp"
#include "musher/lifecycle/coordinator/coordinator.hpp"
#include "musher/transport/node.hpp"

namespace musher {

// All of it must outlive the shell.
struct ShellDependencies {
  transport::Node* node = nullptr;
  LinkMakers links = {};  // of the extensions
  ProcessRunner* processes = nullptr;
  ProcessProbe* process_probe = nullptr;
  // The processes of actuators with a `host`; null: `processes` starts them as well.
  HostProcesses* hosts = nullptr;
  bool own_units = false;  // `hosts` also starts those without a `host`, by the systemd of this one
  std::map<std::string, std::string> host_environment = {};  // of these processes, beside their own
  JournalSink* journal = nullptr;
  // These save what must survive this controller. Each hands its value to the disk and does not
  // wait: `done` runs on the loop, at once or later, when the value is on disk or has failed, and
  // once more when a failed save succeeds later. Each may be called again before that; then the
  // last value counts.
  using OnSaved = std::function<void(const Result<>&)>;
  std::function<void(Epoch, OnSaved done)> save_epoch;
  std::function<void(const StoredStops&, OnSaved done)> save_emergency_stops;
  std::function<void(const StoredPolicy&, OnSaved done)> save_policy;
  std::function<void(bool, OnSaved done)> save_stop_intent;
  std::function<void(const std::vector<RemoteActuator>&, OnSaved done)> save_remote_actuators;
  std::function<void(const std::vector<StoredActuator>&, OnSaved done)> save_actuators;
  // Saves the processes that the next controller has to find; may be empty.
  std::function<void(const std::vector<ChildProcess>&, OnSaved done)> save_children;
  // The mark by which the process of an actuator is found again (child_processes.hpp); may be
  // empty.
  std::function<std::string(const std::string& actuator)> child_mark;
  // The file for stdout and stderr of the process of this name; may be null.
  std::function<std::shared_ptr<const UniqueFd>(const std::string&)> output;
  std::function<std::int64_t()> wall_ns;  // since 1970
  UserRules rules = {};                   // of the user, for the actuators of the config
  std::string config_text;                // text of the config, for the journal; may be empty
  std::string host;                       // HostId()
  std::string host_name;                  // HostName(); may be empty
  std::int32_t pid = 0;
  Incarnation incarnation = 0;  // of this controller
  std::string machine_id;       // of its machine; empty: not known yet
};

// What the parts of a shell share; the shell outlives them.
struct ShellContext {
  const ShellDependencies& dependencies;
  const MachineConfig& config;
  const Machine& machine;
  RecordWriter& records;
  std::function<void(const Event&)>
      handle;  // decides on the event, at once or after the present one

  transport::EventLoop& loop() const { return dependencies.node->loop(); }
};

}  // namespace musher
