#include "musher/controller/ros2/ros2_tools.hpp"

#include <utility>

#include "musher/base/code.hpp"

namespace musher {

Ros2Tools::Ros2Tools(transport::Node& node, ControllerShell& shell,
                     const transport::RosNodes& ros_nodes,
                     const std::function<std::int64_t()>& wall_ns, const std::string& instance)
    : other_vendors_(
          node,
          [&shell](std::vector<std::string> others) { shell.SetOtherVendors(std::move(others)); },
          [&shell](const std::string& other) {
            shell.Remark(kCodeParametersInvalid, other + ": " + kOtherVendorCure);
          }) {
  // Not fatal: permissions from an earlier version, for example, do not include the new topics.
  const auto keep = [&shell](auto& tool, auto made, const char* what) {
    if (made) {
      tool = std::move(made).value();
    } else {
      shell.Remark(made.error().code, std::string("no ") + what + ": " + made.error().message);
    }
  };
  const Ros2Config& config = shell.config().ros2;
  if (config.managed_nodes) {
    keep(managed_, ManagedMachine::Make(node, shell, ros_nodes, instance), "ROS 2 managed node");
  } else {
    services_.emplace(node, transport::ResolveName(shell.config().name_space, "musher"),
                      transport::ParametersOf(shell.config()));
  }
  if (config.diagnostics) {
    keep(diagnostics_, Diagnostics::Make(node, shell, wall_ns), "/diagnostics");
  }
  if (config.rosout) keep(rosout_, Rosout::Make(node, shell.config(), wall_ns), "/rosout");
}

void Ros2Tools::OnRecord(const action::Record& record) {
  if (managed_) managed_->OnRecord();
  if (diagnostics_) diagnostics_->OnRecord();
  if (rosout_) rosout_->OnRecord(record);
}

}  // namespace musher
