// Nodes of nav2 that only have a model: their servers are not on our robots.

#include <array>
#include <sstream>

#include "musher/behavior/tree/models.hpp"
#include "musher/behavior/tree/nav2/register.hpp"

namespace musher::tree::nav2 {
namespace {

struct NodeModel {
  std::string_view kind;
  std::string_view id;
  std::string_view inputs;
  std::string_view outputs;
};

constexpr std::array kNodeModels = {
    NodeModel{"Action", "ClearCostmapAroundPose", "service_name server_timeout pose reset_distance",
              ""},
    NodeModel{"Action", "ClearCostmapAroundRobot", "service_name server_timeout reset_distance",
              ""},
    NodeModel{"Action", "ClearCostmapExceptRegion", "service_name server_timeout reset_distance",
              ""},
    NodeModel{"Action", "DockRobot",
              "dock_id dock_pose dock_type max_staging_time navigate_to_staging_pose use_dock_id "
              "server_name server_timeout",
              "error_code_id error_msg num_retries success"},
    NodeModel{"Action", "ReinitializeGlobalLocalization", "service_name server_timeout", ""},
    NodeModel{"Action", "ToggleCollisionMonitor", "enable service_name server_timeout", ""},
    NodeModel{"Action", "UndockRobot", "dock_type max_undocking_time server_name server_timeout",
              "error_code_id error_msg success"},
};

Element ElementOf(std::string_view name, std::string_view attribute, std::string value) {
  Element element;
  element.name = name;
  element.attributes.push_back({std::string(attribute), std::move(value), {}, {}});
  return element;
}

// Each input may be missing: the servers have defaults.
void AddPorts(Element& node, std::string_view element, std::string_view names) {
  std::istringstream words{std::string(names)};
  for (std::string name; words >> name;) {
    Element port = ElementOf(element, "name", name);
    port.attributes.push_back({"default", "", {}, {}});
    node.children.push_back(std::move(port));
  }
}

class NoRobot : public Robot {
 public:
  std::optional<Pose> pose() const override { return std::nullopt; }
  double speed_m_s() const override { return 0; }
  std::unique_ptr<Task> ComputePath(const Pose&, const std::optional<Pose>&,
                                    const std::string&) override {
    return nullptr;
  }
  std::unique_ptr<Task> FollowPath(const Path&, const std::string&) override { return nullptr; }
  std::unique_ptr<Task> Spin(double, Duration) override { return nullptr; }
  std::unique_ptr<Task> Drive(double, double, Duration) override { return nullptr; }
  std::unique_ptr<Task> ClearCostmap(const std::string&) override { return nullptr; }
};

}  // namespace

void AddModels(Factory& factory) {
  Document document;
  for (const NodeModel& model : kNodeModels) {
    Element node = ElementOf(model.kind, "ID", std::string(model.id));
    AddPorts(node, "input_port", model.inputs);
    AddPorts(node, "output_port", model.outputs);
    document.models.push_back(std::move(node));
  }
  static_cast<void>(AddPlaceholders(factory, document));
}

void AddNodes(Factory& factory, Robot& robot) {
  AddControlNodes(factory, robot);
  AddDecoratorNodes(factory, robot);
  AddConditionNodes(factory, robot);
  AddStateNodes(factory, robot);
  AddActionNodes(factory, robot);
  AddMissionNodes(factory, robot);
  AddPlaceNodes(factory, robot);
  AddPathNodes(factory, robot);
  AddRouteNodes(factory, robot);
  AddModels(factory);
}

void AddForCheck(Factory& factory) {
  static NoRobot robot;
  AddNodes(factory, robot);
}

}  // namespace musher::tree::nav2
