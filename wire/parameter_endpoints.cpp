#include "musher/wire/parameter_endpoints.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace musher::transport {
namespace {

using Value = msg::ParameterValue;

constexpr std::size_t kLongestName = 64;  // of a name that is repeated in an answer
constexpr std::size_t kMostNames = 1000;  // in one request

msg::ParameterValue ToMessage(const NodeParameter& parameter) {
  msg::ParameterValue value;
  if (const bool* truth = std::get_if<bool>(&parameter.value)) {
    value.type = Value::kParameterBool;
    value.bool_value = *truth;
  } else {
    value.type = Value::kParameterString;
    value.string_value = std::get<std::string>(parameter.value);
  }
  return value;
}

std::string TypeName(std::uint8_t type) {
  constexpr std::array kNames = {
      "not set",      "a bool",       "an integer",       "a double",       "a string",
      "a byte array", "a bool array", "an integer array", "a double array", "a string array"};
  return type < kNames.size() ? kNames[type] : "of an unknown type";
}

bool HasPrefix(const std::string& name, const std::vector<std::string>& prefixes) {
  return prefixes.empty() || std::ranges::any_of(prefixes, [&](const std::string& prefix) {
           return name == prefix || name.starts_with(prefix + ".");
         });
}

}  // namespace

std::vector<NodeParameter> ParametersOf(const MachineConfig& config) {
  return {{"config_file", config.file, "the state config of the machine, on its host"},
          {"config_hash", config.hash, "16 hexadecimal digits, of the bytes of the config"},
          {"machine", config.name, "the name of the machine"},
          {"use_sim_time", config.clock == ClockSource::kTopic,
           "whether behaviour follows /clock ([controller] clock)"}};
}

Result<std::unique_ptr<ParameterEndpoints>> ParameterEndpoints::Make(
    Node& node, const std::string& node_name, std::vector<NodeParameter> parameters) {
  std::unique_ptr<ParameterEndpoints> endpoints(new ParameterEndpoints(std::move(parameters)));
  if (auto opened = endpoints->Open(node, node_name + "/"); !opened) return opened.error();
  return endpoints;
}

const NodeParameter* ParameterEndpoints::Find(const std::string& name) const {
  const auto found = std::ranges::find(parameters_, name, &NodeParameter::name);
  return found == parameters_.end() ? nullptr : &*found;
}

std::vector<const NodeParameter*> ParameterEndpoints::FindAll(
    const std::vector<std::string>& names) const {
  std::vector<const NodeParameter*> found;
  if (names.size() > kMostNames) return found;
  for (const std::string& name : names) {
    found.push_back(Find(name));
    if (found.back() == nullptr) return {};
  }
  return found;
}

std::string ParameterEndpoints::WhyNotSet(const msg::Parameter& parameter) const {
  const std::string name = "'" + parameter.name.substr(0, kLongestName) + "'";
  const NodeParameter* known = Find(parameter.name);
  if (known == nullptr) {
    return name + " is not declared: Musher's settings are in its config files";
  }
  const std::uint8_t type = ToMessage(*known).type;
  if (parameter.value.type != type) {
    return name + " is " + TypeName(type) + ", and the value is " + TypeName(parameter.value.type);
  }
  return name + " is read-only: change the config file, and restart the machine with it";
}

Result<> ParameterEndpoints::Open(Node& node, const std::string& base) {
  const auto open = [&]<class S>(std::unique_ptr<Server<S>>& server, const char* name,
                                 typename Server<S>::Handler handler) -> Result<> {
    auto made = MakeServer<S>(node, base + name, std::move(handler));
    if (!made) return made.error();
    server = std::move(made).value();
    return Ok();
  };
  const auto results_of = [this](const std::vector<msg::Parameter>& all) {
    std::vector<msg::SetParametersResult> results;
    for (const msg::Parameter& one : all) results.push_back({false, WhyNotSet(one)});
    return results;
  };
  auto r = open(list_, "list_parameters", [this](const auto& request, auto reply) {
    msg::ListParameters::Response response;
    for (const NodeParameter& one : parameters_) {
      if (HasPrefix(one.name, request.prefixes)) response.result.names.push_back(one.name);
    }
    reply(response);
  });
  if (r) {
    r = open(get_, "get_parameters", [this](const auto& request, auto reply) {
      msg::GetParameters::Response response;
      for (const auto* one : FindAll(request.names)) response.values.push_back(ToMessage(*one));
      reply(response);
    });
  }
  if (r) {
    r = open(get_types_, "get_parameter_types", [this](const auto& request, auto reply) {
      msg::GetParameterTypes::Response response;
      for (const auto* one : FindAll(request.names)) response.types.push_back(ToMessage(*one).type);
      reply(response);
    });
  }
  if (r) {
    r = open(describe_, "describe_parameters", [this](const auto& request, auto reply) {
      msg::DescribeParameters::Response response;
      for (const auto* one : FindAll(request.names)) {
        msg::ParameterDescriptor descriptor;
        descriptor.name = one->name;
        descriptor.type = ToMessage(*one).type;
        descriptor.description = one->description;
        descriptor.read_only = true;
        response.descriptors.push_back(std::move(descriptor));
      }
      reply(response);
    });
  }
  if (r) {
    r = open(set_, "set_parameters", [results_of](const auto& request, auto reply) {
      reply({results_of(request.parameters)});
    });
  }
  if (r) {
    r = open(set_atomically_, "set_parameters_atomically",
             [results_of](const auto& request, auto reply) {
               const auto results = results_of(request.parameters);
               reply({results.empty() ? msg::SetParametersResult{true, ""} : results.front()});
             });
  }
  return r;
}

}  // namespace musher::transport
