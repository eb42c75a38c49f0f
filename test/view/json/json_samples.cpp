// For conformity_test.js: a random message of every type in the IDL, a line of JSON each: its type,
// its definition, its bytes as hexadecimal digits, and its JSON. The bytes are those that
// FromJson() writes of the JSON; of a service's request or response they are without the id before
// its fields.

#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "musher/test/view/json/random_message.hpp"
#include "musher/view/json/message_json.hpp"

namespace musher::view {
namespace {

constexpr std::size_t kHeader = 4;
constexpr std::size_t kId = 16;

Result<std::string> Sample(MessageJson& json, const msg::MessageDefinition& definition,
                           unsigned seed) {
  const auto text =
      json.ToJson(definition.dds_type, RandomMessage(LayoutOf(definition), seed).Make());
  if (!text) return text.error();
  const auto written = json.FromJson(definition.dds_type, text.value());
  if (!written) return written.error();
  msg::Bytes bytes = written.value();
  if (definition.envelope) bytes.erase(bytes.begin() + kHeader, bytes.begin() + kHeader + kId);
  std::string digits;
  for (const std::byte byte : bytes) digits += fmt::format("{:02x}", static_cast<unsigned>(byte));
  const nlohmann::json line = {{"type", definition.ros_type},
                               {"definition", definition.text},
                               {"bytes", digits},
                               {"json", text.value()}};
  return line.dump();
}

int Main() {
  MessageJson json;
  unsigned seed = 1;
  for (const msg::MessageDefinition& definition : msg::Definitions()) {
    const auto line = Sample(json, definition, seed++);
    if (!line) {
      std::fprintf(stderr, "%s\n", line.error().message.c_str());
      return 1;
    }
    std::puts(line.value().c_str());
  }
  return 0;
}

}  // namespace
}  // namespace musher::view

int main() {
  return musher::view::Main();
}
