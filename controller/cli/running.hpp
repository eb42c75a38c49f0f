#pragma once
// The actuators of a namespace that run, with or without a controller: by their latched status, and
// on this host by the name that each process holds, or by the mark that a controller has given to
// the process of another protocol.
//
// Threads: loop thread only.

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/controller/child_processes.hpp"
#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/transport/node.hpp"

namespace musher::cli {

class Running {
 public:
  struct Actuator {
    msg::ActuatorStatus status;  // its name and pid alone where it is not heard
    bool heard = true;
    Time at{};  // when the status came
    transport::PeerId writer = 0;
    std::optional<ChildProcess> child;  // a controller has started it, and it holds no name
  };

  // Follows the statuses from now on. The node must outlive it.
  static Result<std::unique_ptr<Running>> Begin(transport::Node& node,
                                                const std::string& name_space, bool with_keys);

  // Those that have not been torn down, by their names.
  std::map<std::string, Actuator> Now() const;
  bool Hears(const std::string& actuator) const { return heard_.contains(actuator); }

 private:
  Running(transport::EventLoop& loop, std::string name_space)
      : loop_(loop), name_space_(std::move(name_space)) {}

  void FindChildrenHere();

  transport::EventLoop& loop_;
  const std::string name_space_;
  std::map<std::string, Actuator> heard_;
  std::vector<ChildProcess> children_;                 // with a mark when this began
  std::unique_ptr<transport::Subscription> statuses_;  // last: its callbacks use all of the above
};

}  // namespace musher::cli
