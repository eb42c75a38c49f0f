// What a client of Foxglove's protocol sends: texts and binary messages. A list is bounded, data
// lie within the message, and a refusal has a sentence.

#include "musher/test/fuzz/fuzz.hpp"
#include "musher/view/foxglove/protocol.hpp"

namespace {

using namespace musher;
using namespace musher::view;
using fuzz::Require;

void CheckWithin(std::span<const std::byte> data, std::span<const std::byte> message) {
  Require(data.size() <= message.size(), "the data are a part of the message");
  Require(data.empty() || (data.data() >= message.data() &&
                           data.data() + data.size() == message.data() + message.size()),
          "the data end with the message");
}

void Check(fuzz::Input& input) {
  const bool binary = input.Bool();
  const std::string_view rest = input.Rest();
  const std::span<const std::byte> bytes = std::as_bytes(std::span(rest));
  const auto read = binary ? foxglove::ReadBinary(bytes) : foxglove::ReadText(rest);
  if (!read) return Require(!read.error().message.empty(), "a refusal has a message");
  if (const auto* message = std::get_if<foxglove::ClientMessage>(&read.value())) {
    CheckWithin(message->data, bytes);
  } else if (const auto* call = std::get_if<foxglove::ServiceCall>(&read.value())) {
    CheckWithin(call->data, bytes);
    Require(call->encoding.size() <= rest.size(), "the encoding is a part of the message");
  } else if (const auto* subscribe = std::get_if<foxglove::Subscribe>(&read.value())) {
    Require(subscribe->subscriptions.size() <= foxglove::kMostItems, "a list is bounded");
  } else if (const auto* advertise = std::get_if<foxglove::ClientAdvertise>(&read.value())) {
    Require(advertise->channels.size() <= foxglove::kMostItems, "a list is bounded");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  Check(input);
  return 0;
}
