#include "musher/controller/journal/record_data.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace musher {
namespace {

// Each record is written on the path of a switch: the text is made at once, without a document.
void Append(std::string& json, std::string_view text) {
  const bool plain = std::ranges::all_of(
      text, [](char c) { return c >= ' ' && c <= '~' && c != '"' && c != '\\'; });
  if (plain) {
    json.append(1, '"').append(text).append(1, '"');
  } else {
    using Json = nlohmann::json;
    json += Json(text).dump(-1, ' ', false, Json::error_handler_t::replace);
  }
}
void Append(std::string& json, const std::string& text) {
  Append(json, std::string_view(text));
}
void Append(std::string& json, bool flag) {
  json += flag ? "true" : "false";
}
void Append(std::string& json, std::int64_t number) {
  json += std::to_string(number);
}
void Append(std::string& json, std::uint64_t number) {
  json += std::to_string(number);
}

// The next member of the object that `json` ends in.
template <class T>
void AppendMember(std::string& json, std::string_view name, const T& value) {
  if (json.back() != '{') json += ',';
  Append(json, name);
  json += ':';
  Append(json, value);
}

}  // namespace

std::string DataOf(const action::Record& record) {
  if (!record.data.empty()) return record.data;
  if (!record.of_switch && record.arguments.empty()) return "";
  std::string json = "{";
  if (record.of_switch) {
    AppendMember(json, "target", record.of_switch->target.name());
    AppendMember(json, "state", record.of_switch->state.name());
    if (record.of_switch->outcome) {
      AppendMember(json, "outcome", OutcomeName(*record.of_switch->outcome));
    }
  }
  if (!record.arguments.empty()) {
    json += json.back() == '{' ? "\"arguments\":{" : ",\"arguments\":{";
    for (const Argument& argument : record.arguments) {
      std::visit([&](const auto& value) { AppendMember(json, argument.name, value); },
                 argument.value);
    }
    json += '}';
  }
  return json + '}';
}

}  // namespace musher
