#include "musher/wire/node_services.hpp"

#include <utility>

#include "musher/wire/type_descriptions.hpp"

namespace musher::transport {

NodeServices::NodeServices(Node& node, const std::string& node_name,
                           std::vector<NodeParameter> parameters) {
  if (auto made = ParameterEndpoints::Make(node, node_name, std::move(parameters))) {
    parameters_ = std::move(made).value();
  }
  if (auto made = MakeServer<msg::GetTypeDescription>(
          node, node_name + "/get_type_description",
          [](const auto& request, auto reply) { reply(Describe(request)); })) {
    describe_type_ = std::move(made).value();
  }
}

}  // namespace musher::transport
