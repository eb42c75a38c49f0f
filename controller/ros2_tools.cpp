#include "musher/controller/ros2_tools.hpp"

#include <utility>

namespace musher {

Ros2Tools::Ros2Tools(transport::Node& node, ControllerShell& shell,
                     const std::function<std::int64_t()>& wall_ns, const std::string& instance) {
  // A robot is led all the same: keys that were made before a tool, say, do not permit its topics.
  const auto keep = [&shell](auto& tool, auto made, const char* what) {
    if (made) {
      tool = std::move(made).value();
    } else {
      shell.Remark(made.error().code, std::string("no ") + what + ": " + made.error().message);
    }
  };
  const Ros2Config& wanted = shell.config().ros2;
  if (wanted.managed_nodes) {
    keep(managed_, ManagedMachine::Make(node, shell, instance), "ROS 2 managed node");
  }
  if (wanted.diagnostics) {
    keep(diagnostics_, Diagnostics::Make(node, shell, wall_ns), "/diagnostics");
  }
  if (wanted.rosout) keep(rosout_, Rosout::Make(node, shell.config(), wall_ns), "/rosout");
}

void Ros2Tools::OnRecord(const action::Record& record) {
  if (managed_) managed_->OnRecord();
  if (diagnostics_) diagnostics_->OnRecord();
  if (rosout_) rosout_->OnRecord(record);
}

}  // namespace musher
