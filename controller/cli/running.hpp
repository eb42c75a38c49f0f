#pragma once
// The actuators of a namespace that run, with or without a controller: by their latched status, and
// on this host by the name that each process holds.
//
// Threads: loop thread only.

#include <map>
#include <memory>
#include <string>
#include <vector>

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

  transport::EventLoop& loop_;
  const std::string name_space_;
  std::map<std::string, Actuator> heard_;
  std::unique_ptr<transport::Subscription> statuses_;  // last: its callbacks use all of the above
};

}  // namespace musher::cli
