#pragma once
// The parameter services of a node, for `ros2 param` and rqt: a few settings of Musher, to read.
// Without them `ros2 param list` waits 5 s for each node. As in rclcpp, an answer about a name that
// is not declared is empty.
//
// Threads: loop thread only.

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "musher/lifecycle/config/config.hpp"
#include "musher/messages/rcl_interfaces/parameters.hpp"
#include "musher/transport/node.hpp"
#include "musher/transport/service.hpp"

namespace musher::transport {

struct NodeParameter {
  std::string name;
  std::variant<bool, std::string> value;
  std::string description;
};

// The parameters that every node of a machine has.
std::vector<NodeParameter> ParametersOf(const MachineConfig& config);

class ParameterEndpoints {
 public:
  // `node_name` with its namespace. `node` must outlive it.
  static Result<std::unique_ptr<ParameterEndpoints>> Make(Node& node, const std::string& node_name,
                                                          std::vector<NodeParameter> parameters);

 private:
  explicit ParameterEndpoints(std::vector<NodeParameter> parameters)
      : parameters_(std::move(parameters)) {}

  Result<> Open(Node& node, const std::string& base);
  const NodeParameter* Find(const std::string& name) const;
  // The parameters with `names`; empty if one of the names is not declared.
  std::vector<const NodeParameter*> FindAll(const std::vector<std::string>& names) const;
  std::string WhyNotSet(const msg::Parameter& parameter) const;

  const std::vector<NodeParameter> parameters_;
  std::unique_ptr<Server<msg::ListParameters>> list_;
  std::unique_ptr<Server<msg::GetParameters>> get_;
  std::unique_ptr<Server<msg::GetParameterTypes>> get_types_;
  std::unique_ptr<Server<msg::DescribeParameters>> describe_;
  std::unique_ptr<Server<msg::SetParameters>> set_;
  std::unique_ptr<Server<msg::SetParametersAtomically>> set_atomically_;
};

}  // namespace musher::transport
