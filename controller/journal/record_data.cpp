#include "musher/controller/journal/record_data.hpp"

#include <nlohmann/json.hpp>

namespace musher {
namespace {

using OrderedJson = nlohmann::ordered_json;  // keys in the order they are written here

OrderedJson JsonOf(const std::vector<Argument>& arguments) {
  OrderedJson json = OrderedJson::object();
  for (const Argument& argument : arguments) {
    std::visit([&](const auto& value) { json[std::string(argument.name)] = value; },
               argument.value);
  }
  return json;
}

}  // namespace

std::string DataOf(const action::Record& record) {
  if (!record.data.empty()) return record.data;
  OrderedJson json = OrderedJson::object();
  if (record.of_switch) {
    json["target"] = record.of_switch->target.name();
    json["state"] = record.of_switch->state.name();
    if (record.of_switch->outcome) json["outcome"] = OutcomeName(*record.of_switch->outcome);
  }
  if (!record.arguments.empty()) json["arguments"] = JsonOf(record.arguments);
  return json.empty() ? "" : json.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

}  // namespace musher
