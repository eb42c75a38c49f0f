#include "musher/view/foxglove/protocol.hpp"

#include <gmock/gmock.h>

namespace musher::view::foxglove::protocol_test {

using ::testing::HasSubstr;

std::vector<std::byte> Bytes(std::initializer_list<int> values) {
  std::vector<std::byte> bytes;
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

TEST(FoxgloveProtocol, ReadsWhatAClientSubscribesTo) {
  const auto read = ReadText(
      R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":7},{"id":2,"channelId":8}]})");
  const auto& subscribe = std::get<Subscribe>(read.value());
  ASSERT_EQ(subscribe.subscriptions.size(), 2U);
  EXPECT_EQ(subscribe.subscriptions[1].id, 2U);
  EXPECT_EQ(subscribe.subscriptions[1].channel, 8U);
}

TEST(FoxgloveProtocol, ReadsWhatAClientPublishes) {
  const auto read = ReadText(
      R"({"op":"advertise","channels":[{"id":3,"topic":"/chat","encoding":"cdr","schemaName":"std_msgs/String"}]})");
  EXPECT_EQ(std::get<ClientAdvertise>(read.value()).channels[0].topic, "/chat");
  const auto bytes = Bytes({1, 3, 0, 0, 0, 0xAA});
  const auto message = ReadBinary(bytes);
  EXPECT_EQ(std::get<ClientMessage>(message.value()).channel, 3U);
  EXPECT_EQ(std::get<ClientMessage>(message.value()).data.size(), 1U);
}

TEST(FoxgloveProtocol, ReadsTheCallOfAService) {
  const auto bytes = Bytes({2, 5, 0, 0, 0, 9, 0, 0, 0, 3, 0, 0, 0, 'c', 'd', 'r', 0xAA, 0xBB});
  const auto read = ReadBinary(bytes);
  const auto& call = std::get<ServiceCall>(read.value());
  EXPECT_EQ(call.service, 5U);
  EXPECT_EQ(call.call, 9U);
  EXPECT_EQ(call.encoding, "cdr");
  EXPECT_EQ(call.data.size(), 2U);
}

TEST(FoxgloveProtocol, IgnoresWhatItDoesNotOffer) {
  EXPECT_TRUE(std::holds_alternative<Ignored>(ReadText(R"({"op":"fetchAsset"})").value()));
}

TEST(FoxgloveProtocol, RefusesEveryMalformedTextWithASentence) {
  for (const std::string text :
       {"", "{", "[]", "7", R"({"op":7})", R"({"op":"subscribe"})",
        R"({"op":"subscribe","subscriptions":[7]})",
        R"({"op":"subscribe","subscriptions":[{"id":-1,"channelId":1}]})",
        R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":4294967296}]})",
        R"({"op":"unsubscribe","subscriptionIds":["a"]})", R"({"op":"unadvertise"})",
        R"({"op":"advertise","channels":[{"id":1,"topic":7}]})"}) {
    const auto read = ReadText(text);
    ASSERT_FALSE(read) << text;
    EXPECT_THAT(read.error().message, HasSubstr("malformed message: ")) << text;
  }
}

TEST(FoxgloveProtocol, RefusesAListThatIsTooLong) {
  std::string text = R"({"op":"unsubscribe","subscriptionIds":[0)";
  for (std::size_t i = 0; i < kMostItems; ++i) text += ",1";
  EXPECT_THAT(ReadText(text + "]}").error().message, HasSubstr("a list of at most 1000"));
}

TEST(FoxgloveProtocol, RefusesEveryMalformedBinaryMessage) {
  const auto call = Bytes({2, 5, 0, 0, 0, 9, 0, 0, 0, 3, 0, 0, 0, 'c', 'd', 'r'});
  for (std::size_t size = 0; size < call.size(); ++size) {
    EXPECT_FALSE(ReadBinary(std::span(call).first(size))) << size;
  }
  EXPECT_FALSE(ReadBinary(Bytes({1, 0, 0})));
  EXPECT_FALSE(ReadBinary(Bytes({9, 0, 0})));
}

}  // namespace musher::view::foxglove::protocol_test
