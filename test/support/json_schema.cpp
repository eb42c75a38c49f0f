#include "musher/test/support/json_schema.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "musher/test/support/paths.hpp"

namespace musher::testing {
namespace {

using Json = nlohmann::json;
using Faults = std::vector<std::string>;

}  // namespace

const Json& Schema() {
  static const Json schema = [] {
    std::ifstream file(SourceDir() + "/docs/cli.schema.json");
    return Json::parse(file);
  }();
  return schema;
}

namespace {

bool HasType(const Json& value, const std::string& type) {
  if (type == "null") return value.is_null();
  if (type == "string") return value.is_string();
  if (type == "boolean") return value.is_boolean();
  if (type == "integer") return value.is_number_integer();
  if (type == "number") return value.is_number();
  if (type == "array") return value.is_array();
  return type == "object" && value.is_object();
}

Faults Check(const Json& schema, const Json& value, const std::string& place);

Faults CheckObject(const Json& schema, const Json& value, const std::string& place) {
  Faults faults;
  for (const Json& key : schema.value("required", Json::array())) {
    if (!value.contains(key)) faults.push_back(place + ": no key " + key.get<std::string>());
  }
  const Json properties = schema.value("properties", Json::object());
  const Json others = schema.value("additionalProperties", Json(false));
  for (const auto& [key, member] : value.items()) {
    const std::string here = place + "." + key;
    const auto known = properties.find(key);
    Faults more;
    if (known != properties.end()) {
      more = Check(*known, member, here);
    } else if (others.is_object()) {
      more = Check(others, member, here);
    } else if (others == false) {
      more = {here + ": the schema has no such key"};
    }
    faults.insert(faults.end(), more.begin(), more.end());
  }
  return faults;
}

Faults CheckAny(const Json& all, const Json& value, const std::string& place) {
  Faults faults;
  for (const Json& one : all) {
    Faults of_one = Check(one, value, place);
    if (of_one.empty()) return {};
    if (faults.empty() || of_one.size() < faults.size()) faults = std::move(of_one);
  }
  return faults;
}

Faults Check(const Json& schema, const Json& value, const std::string& place) {
  if (const auto to = schema.find("$ref"); to != schema.end()) {
    const std::string name = to->get<std::string>().substr(std::string("#/$defs/").size());
    return Check(Schema().at("$defs").at(name), value, place);
  }
  if (const auto any = schema.find("anyOf"); any != schema.end()) {
    return CheckAny(*any, value, place);
  }
  if (const auto values = schema.find("enum"); values != schema.end()) {
    if (std::find(values->begin(), values->end(), value) != values->end()) return {};
    return {place + ": " + value.dump() + " is none of " + values->dump()};
  }
  const Json& type_of = schema.at("type");
  const Json types = type_of.is_array() ? type_of : Json::array({type_of});
  if (std::none_of(types.begin(), types.end(),
                   [&](const Json& type) { return HasType(value, type.get<std::string>()); })) {
    return {place + ": " + value.dump() + " is no " + types.dump()};
  }
  if (value.is_object()) return CheckObject(schema, value, place);
  Faults faults;
  if (value.is_array() && schema.contains("items")) {
    for (std::size_t i = 0; i < value.size(); ++i) {
      const Faults more =
          Check(schema.at("items"), value[i], place + "[" + std::to_string(i) + "]");
      faults.insert(faults.end(), more.begin(), more.end());
    }
  }
  return faults;
}

// "skill run", "status": the command that the words name; empty: none.
std::string CommandIn(const std::vector<std::string>& words) {
  const Json& known = Schema().at("$defs");
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i + 1 < words.size() && known.contains(words[i] + " " + words[i + 1])) {
      return words[i] + " " + words[i + 1];
    }
    if (known.contains(words[i])) return words[i];
  }
  return "";
}

std::vector<Json> DocumentsIn(const std::string& out) {
  std::vector<Json> documents;  // each on a line
  std::istringstream lines(out);
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty()) documents.push_back(Json::parse(line, nullptr, false));
  }
  return documents;
}

}  // namespace

Faults SchemaFaults(const std::string& name, const Json& document) {
  return Check(Schema().at("$defs").at(name), document, "");
}

std::vector<std::string> SchemaNames() {
  std::vector<std::string> names;
  for (const auto& [name, schema] : Schema().at("$defs").items()) names.push_back(name);
  return names;
}

void CheckDocuments(const std::vector<std::string>& words, const std::string& out) {
  if (std::find(words.begin(), words.end(), "--json") == words.end()) return;
  const std::string command = CommandIn(words);
  for (const Json& document : DocumentsIn(out)) {
    if (document.is_discarded()) {
      ADD_FAILURE() << "no JSON: " << out;
      continue;
    }
    const bool of_all = document.contains("error") && !document.contains("actuators");
    if (document.is_object() && of_all) {
      EXPECT_EQ(SchemaFaults("error", document), Faults()) << document;
    } else if (command.empty()) {
      ADD_FAILURE() << "docs/cli.schema.json has no such command: " << document;
    } else {
      EXPECT_EQ(SchemaFaults(command, document), Faults()) << command << ": " << document;
    }
  }
}

}  // namespace musher::testing
