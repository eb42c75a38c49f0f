// [ros2].

#include "musher/lifecycle/config/toml/draft.hpp"

namespace musher::config_toml {
namespace {

// The state of the machine that a transition of its node switches to.
void ReadTransitionTarget(std::string_view key, TableReader& ros2, Draft& draft, State& target) {
  const auto state = ros2.String(key);
  if (!state || !CheckState(*state, key, ros2, draft)) return;
  if (state->text == kSetUp) {
    ros2.Fault(state->at, key,
               "\"SetUp\" cannot be commanded: it runs only at the start of a process");
    return;
  }
  target = State(state->text);
}

void ReadRos2Table(TableReader& root, Draft& draft) {
  const Table* table = root.SubTable("ros2");
  if (table == nullptr) return;
  TableReader ros2(*table, root.At("ros2"), "ros2", draft.findings);
  Ros2Config& config = draft.config.ros2;
  config.managed_nodes = ros2.Bool("managed_nodes").value_or(config.managed_nodes);
  config.started_by_manager =
      ros2.Choice<bool>("start", {{"self", false}, {"manager", true}}).value_or(false);
  if (config.started_by_manager && !config.managed_nodes) {
    ros2.Fault(ros2.At("start"), "start", "\"manager\" needs managed_nodes = true");
  }
  ReadTransitionTarget("configure", ros2, draft, config.configure);
  ReadTransitionTarget("activate", ros2, draft, config.activate);
  ReadTransitionTarget("deactivate", ros2, draft, config.deactivate);
  ReadTransitionTarget("cleanup", ros2, draft, config.cleanup);
  ReadTransitionTarget("shutdown", ros2, draft, config.shutdown);
  config.diagnostics = ros2.Bool("diagnostics").value_or(config.diagnostics);
  config.rosout = ros2.Bool("rosout").value_or(config.rosout);
  ros2.RefuseOthers();
}

}  // namespace

void ReadRos2(TableReader& root, Draft& draft) {
  ReadRos2Table(root, draft);
  for (const Word& name : draft.actuator_names.value_or(std::vector<Word>())) {
    if (name.text != "musher" || !draft.config.ros2.managed_nodes) continue;
    draft.findings.Warning(
        name.at,
        "controller.actuators: \"musher\" is also the name of the machine's ROS 2 node; rename the "
        "actuator, or set managed_nodes = false in [ros2]");
  }
}

}  // namespace musher::config_toml
