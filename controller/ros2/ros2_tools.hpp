#pragma once
// The interfaces of the machine for ROS 2's tools: the services of every node, and, each enabled by
// [ros2] of the config, a managed node, /diagnostics, /rosout. Available while the controller
// leads.
//
// Threads: loop thread only.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/controller/ros2/diagnostics.hpp"
#include "musher/controller/ros2/managed_machine.hpp"
#include "musher/controller/ros2/other_vendors.hpp"
#include "musher/controller/ros2/rosout.hpp"
#include "musher/wire/node_services.hpp"

namespace musher {

class Ros2Tools {
 public:
  // `wall_ns`: since 1970; `instance` identifies this controller. All must outlive it. A part that
  // cannot be opened is missing, and a record states why.
  Ros2Tools(transport::Node& node, ControllerShell& shell, const transport::RosNodes& ros_nodes,
            const std::function<std::int64_t()>& wall_ns, const std::string& instance);

  void OnRecord(const action::Record& record);
  // A manager has not yet queried the state after its shutdown.
  bool Holds() const { return managed_ && managed_->Holds(); }

 private:
  std::optional<transport::NodeServices> services_;  // of a node that is not managed
  std::unique_ptr<ManagedMachine> managed_;
  std::unique_ptr<Diagnostics> diagnostics_;
  std::unique_ptr<Rosout> rosout_;
  OtherVendors other_vendors_;
};

}  // namespace musher
