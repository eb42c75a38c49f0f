#pragma once
// The peer of a module's process: starts the real program in a domain of its own and drives it as
// a controller does.

#include <csignal>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/lifecycle/machine/report.hpp"
#include "musher/messages/musher_msgs/actuator_command.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/modules/exec/child.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/transport/node.hpp"
#include "musher/transport/service.hpp"

namespace musher::test {

class ActuatorPeer {
 public:
  using Reply = Result<msg::ActuatorCommand::Response>;

  // Writes a state config with that actuator. `program` is what it is the actuator of.
  ActuatorPeer(std::string actuator, const std::vector<std::string>& states, std::string program);

  // Starts the program with `module_file` as the text of its file; the output goes to a file.
  void Start(const std::string& module_file);
  // The same in a machine on the time of a world.
  void StartOnWorldTime(const std::string& module_file);
  // The same with other arguments, unchanged.
  void StartWith(std::vector<std::string> arguments);

  // Waits until the actuator is set up, so that it can be commanded.
  bool AwaitVisible();
  // Waits for a status; false when it does not come.
  bool AwaitStatus(const std::function<bool(const ActuatorReport&)>& holds);

  // Sends a switch and returns; the reply is available as reply().
  void Send(const State& target);
  // Queries the last switch, with a request to stop it.
  Reply Query();
  bool AwaitReply();
  const std::optional<Reply>& reply() const { return reply_; }
  // Sends a switch and waits for the reply.
  Reply Switch(const State& target);

  void Signal(int signal) { kill(process_->pid(), signal); }
  // The exit code (or minus the signal), -1000 when it does not exit.
  int AwaitExit();
  std::string Output() const;

  pid_t pid() const { return process_->pid(); }
  const ActuatorReport& report() const { return report_; }
  const TempFolder& folder() const { return folder_; }
  transport::Node& node() { return *node_; }
  const exec::Reaper& reaper() const { return reaper_; }
  // Waits until it holds; false on a timeout.
  bool Until(const std::function<bool()>& holds);

 private:
  bool AwaitObedience();
  msg::ActuatorCommand::Request Request(std::uint8_t kind) const;

  const TempFolder folder_;
  const std::string config_ = folder_ / "machine.toml";
  const std::string actuator_;
  const std::vector<std::string> states_;
  const std::string program_;
  const exec::Reaper reaper_;
  transport::LinuxEventLoop loop_;
  std::unique_ptr<transport::Node> node_;
  ActuatorReport report_;
  Time report_at_;
  std::uint64_t number_ = 0;
  std::optional<Reply> reply_;
  std::optional<Reply> answer_;  // to the query
  std::unique_ptr<transport::Subscription> status_;
  std::unique_ptr<transport::Publisher<msg::ControllerHeartbeat>> heartbeats_;
  std::unique_ptr<transport::Client<msg::ActuatorCommand>> client_;
  std::optional<exec::Child> process_;
};

}  // namespace musher::test
