#pragma once
// What ROS 2's tools see of the machine, each part where [ros2] of the config wants it: a managed
// node, /diagnostics, /rosout. There while the controller leads.
//
// Threads: loop thread only.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "musher/controller/diagnostics.hpp"
#include "musher/controller/managed_machine.hpp"
#include "musher/controller/rosout.hpp"

namespace musher {

class Ros2Tools {
 public:
  // `wall_ns`: since 1970; `instance` tells this controller from others. All must outlive it. What
  // cannot be opened is missing, with a record that says why.
  Ros2Tools(transport::Node& node, ControllerShell& shell,
            const std::function<std::int64_t()>& wall_ns, const std::string& instance);

  void OnRecord(const action::Record& record);
  // A manager has not got all that it will ask for after a shutdown.
  bool Holds() const { return managed_ && managed_->Holds(); }

 private:
  std::unique_ptr<ManagedMachine> managed_;
  std::unique_ptr<Diagnostics> diagnostics_;
  std::unique_ptr<Rosout> rosout_;
};

}  // namespace musher
