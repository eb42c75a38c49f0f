#pragma once
// The services that the tools of ROS 2 call on every node, whatever it is: those of parameters, and
// get_type_description. `ros2 param list` waits 5 s for each node of its list without them.
//
// Threads: loop thread only.

#include <memory>
#include <string>
#include <vector>

#include "musher/messages/type_description_interfaces/get_type_description.hpp"
#include "musher/transport/node.hpp"
#include "musher/transport/service.hpp"
#include "musher/wire/parameter_endpoints.hpp"

namespace musher::transport {

class NodeServices {
 public:
  // `node_name` with its namespace, "dog1/legs"; without `parameters` the node has none. What
  // cannot be opened is missing: permissions from an earlier version do not include it. `node` must
  // outlive it.
  NodeServices(Node& node, const std::string& node_name, std::vector<NodeParameter> parameters);

 private:
  std::unique_ptr<ParameterEndpoints> parameters_;
  std::unique_ptr<Server<msg::GetTypeDescription>> describe_type_;
};

}  // namespace musher::transport
