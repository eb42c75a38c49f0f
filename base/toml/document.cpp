#include "musher/base/toml/document.hpp"

#include <toml++/toml.h>

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "musher/base/toml/text.hpp"

namespace musher::config_toml {
namespace {

Position PositionOf(const toml::source_region& region) {
  return {static_cast<int>(region.begin.line), static_cast<int>(region.begin.column)};
}

Table Convert(const toml::table& table);

Value Convert(const toml::node& node) {
  Value value{DateOrTime{}, PositionOf(node.source())};
  if (const auto* table = node.as_table()) {
    value.content = Convert(*table);
  } else if (const auto* array = node.as_array()) {
    Array items;
    items.reserve(array->size());
    for (const toml::node& item : *array) items.push_back(Convert(item));
    value.content = std::move(items);
  } else if (const auto* text = node.as_string()) {
    value.content = text->get();
  } else if (const auto* integer = node.as_integer()) {
    value.content = integer->get();
  } else if (const auto* number = node.as_floating_point()) {
    value.content = number->get();
  } else if (const auto* boolean = node.as_boolean()) {
    value.content = boolean->get();
  }
  return value;
}

// toml++ sorts by key; diagnostics are by line.
Table Convert(const toml::table& table) {
  Table members;
  members.reserve(table.size());
  for (const auto& [key, node] : table) {
    members.push_back({std::string(key.str()), PositionOf(key.source()), Convert(node)});
  }
  std::sort(members.begin(), members.end(),
            [](const Member& a, const Member& b) { return a.at < b.at; });
  return members;
}

// On one line: toml++ quotes a word with the end of its line.
std::string OneLine(std::string_view text) {
  std::string line;
  for (const char c : text) {
    if (c == '\n') {
      line += "\\n";
    } else if (c == '\r') {
      line += "\\r";
    } else {
      line += c;
    }
  }
  return line;
}

SyntaxFault Translate(const toml::parse_error& error) {
  constexpr std::string_view kPrefix = "Error while parsing ";
  std::string message(error.description());
  if (message.starts_with(kPrefix)) message.replace(0, kPrefix.size(), "in ");
  return {PositionOf(error.source()), "not TOML: " + OneLine(message)};
}

}  // namespace

const Member* Find(const Table& table, std::string_view key) {
  const auto found = std::find_if(table.begin(), table.end(),
                                  [&](const Member& member) { return member.key == key; });
  return found == table.end() ? nullptr : &*found;
}

std::string_view TypeName(const Value& value) {
  constexpr std::string_view kNames[] = {"a date or time", "a boolean", "an integer", "a float",
                                         "a string",       "an array",  "a table"};
  static_assert(std::size(kNames) == std::variant_size_v<decltype(value.content)>);
  return kNames[value.content.index()];
}

std::variant<Table, SyntaxFault> ParseDocument(std::string_view text) {
  if (std::optional<SyntaxFault> fault = FindTextFault(text)) return *std::move(fault);
  try {
    return Convert(toml::parse(text));
  } catch (const toml::parse_error& error) {
    return Translate(error);
  }
}

}  // namespace musher::config_toml
