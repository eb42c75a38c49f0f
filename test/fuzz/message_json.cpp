// Untrusted samples and untrusted JSON of every type: a sample that is a message is JSON, which is
// read and written again without a change.

#include "musher/view/json/message_json.hpp"

#include "musher/messages/definitions.hpp"
#include "musher/test/fuzz/fuzz.hpp"

namespace {

using namespace musher;
using fuzz::Require;

// What FromJson() has written is JSON, and that gives the same bytes.
void Again(view::MessageJson& json, std::string_view type, const msg::Bytes& bytes) {
  const auto text = json.ToJson(type, bytes);
  if (!text) return Require(bytes.size() > 100'000, "what was written is read");
  if (text.value().find(R"({"bytes":)") != std::string::npos) return;  // left out
  const auto again = json.FromJson(type, text.value());
  Require(again.ok(), "what was read is written");
  Require(again.value() == bytes, "reading and writing changes nothing");
}

void Check(fuzz::Input& input) {
  static view::MessageJson json;
  const auto all = msg::Definitions();
  const bool is_json = input.Bool();
  const std::string_view type = all[input.Take<std::uint16_t>() % all.size()].dds_type;
  const std::string_view rest = input.Rest();
  const auto text = is_json ? Result<std::string>(std::string(rest))
                            : json.ToJson(type, std::as_bytes(std::span(rest)));
  if (!text) return Require(!text.error().message.empty(), "a refusal has a message");
  const auto bytes = json.FromJson(type, text.value());
  if (bytes) return Again(json, type, bytes.value());
  Require(!bytes.error().message.empty(), "a refusal has a message");
  const bool left_out = text.value().find(R"({"bytes":)") != std::string::npos;
  Require(is_json || left_out, "the JSON of a sample is read: " + bytes.error().message);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  Check(input);
  return 0;
}
