#include "musher/view/json/message_json.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "musher/messages/definitions.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/messages/sensor_msgs/joint_state.hpp"
#include "musher/messages/std_msgs/string.hpp"

namespace musher::view::message_json_test {

using ::testing::HasSubstr;

template <class T>
Result<std::string> JsonOf(const T& message) {
  return MessageJson().ToJson(T::kTypeName, msg::Encode(message));
}

TEST(MessageJsonTest, HasTheFieldsOfTheMessage) {
  EXPECT_EQ(JsonOf(msg::String{"hello"}).value(), R"({"data":"hello"})");
  msg::MachineStatus status;
  status.state = "Active";
  status.epoch = 7;
  status.degraded = {"audio"};
  status.actuators.resize(1);
  status.actuators[0].name = "motion";
  const std::string text = JsonOf(status).value();
  EXPECT_THAT(text, HasSubstr(R"("state":"Active","target":"","epoch":7,)"));
  EXPECT_THAT(text, HasSubstr(R"("degraded":["audio"],"actuators":[{"name":"motion",)"));
}

TEST(MessageJsonTest, GivesIntegersThatJavaScriptWouldRoundAsText) {
  msg::HistoryEntry entry;
  entry.wall_ns = 1'765'432'101'234'567'890;
  entry.epoch = std::uint64_t{1} << 53;
  EXPECT_THAT(JsonOf(entry).value(), HasSubstr(R"("wall_ns":"1765432101234567890")"));
  EXPECT_THAT(JsonOf(entry).value(), HasSubstr(R"("epoch":9007199254740992)"));
  entry.wall_ns = std::numeric_limits<std::int64_t>::min();
  EXPECT_THAT(JsonOf(entry).value(), HasSubstr(R"("wall_ns":"-9223372036854775808")"));
}

TEST(MessageJsonTest, GivesTheSizeOfAPictureAlone) {
  msg::Image image;
  image.width = 640;
  image.data.resize(921600);
  EXPECT_THAT(JsonOf(image).value(), HasSubstr(R"("data":{"bytes":921600})"));
}

TEST(MessageJsonTest, LeavesOutWhatAnOlderPeerDoesNotSend) {
  const msg::MachineStatus status;
  msg::Bytes bytes = msg::Encode(status);
  bytes.resize(bytes.size() - 4);  // without held_by_stop, an empty sequence
  const auto text = MessageJson().ToJson(msg::MachineStatus::kTypeName, bytes);
  ASSERT_TRUE(text) << text.error().message;
  EXPECT_THAT(text.value(), HasSubstr(R"("not_on_disk":[])"));
}

TEST(MessageJsonTest, ReplacesTextThatIsNoUtf8) {
  EXPECT_EQ(JsonOf(msg::String{"a\xff"}).value(), "{\"data\":\"a\xef\xbf\xbd\"}");
}

TEST(MessageJsonTest, RefusesATypeThatTheIdlDoesNotDefine) {
  const auto text = MessageJson().ToJson("my_msgs::msg::dds_::Own_", {});
  ASSERT_FALSE(text);
  EXPECT_EQ(text.error().message, "Musher does not know the type my_msgs::msg::dds_::Own_");
}

TEST(MessageJsonTest, RefusesAMessageThatIsCutAnywhere) {
  msg::MachineStatus status;
  status.actuators.resize(2);
  status.actuators[1].name = "motion";
  status.held_by_stop = {"motion"};
  const msg::Bytes bytes = msg::Encode(status);
  MessageJson json;
  std::size_t refused = 0;
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    refused += json.ToJson(msg::MachineStatus::kTypeName, std::span(bytes).first(size)) ? 0U : 1U;
  }
  // Without an appended field it is a message of an older peer, up to three bytes of padding
  // included.
  constexpr std::size_t kAppendedWords = 16;  // held_by_stop and what follows, of four bytes
  EXPECT_GE(refused, bytes.size() - 4 * kAppendedWords);
}

TEST(MessageJsonTest, ClaimedLengthsTakeNoMemory) {
  msg::Bytes bytes = msg::Encode(msg::String{"hello"});
  for (std::size_t i = 4; i < 8; ++i) bytes[i] = std::byte{0xff};
  MessageJson json;
  EXPECT_FALSE(json.ToJson(msg::String::kTypeName, bytes));
  for (const msg::MessageDefinition& definition : msg::Definitions()) {
    const msg::Bytes claims(64, std::byte{0xff});
    msg::Bytes sample = {std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}};
    sample.insert(sample.end(), claims.begin(), claims.end());
    const auto text = json.ToJson(definition.dds_type, sample);
    EXPECT_LT(text ? text.value().size() : 0, 10000U) << definition.dds_type;
  }
}

// The values take a multiple of the message's bytes, and the text was measured after all of them.
TEST(MessageJsonTest, AMessageTooLongForTextIsRefusedBeforeItIsInMemory) {
  msg::JointState joints;
  joints.position.resize(10'000'000);
  const auto text = JsonOf(joints);
  ASSERT_FALSE(text);
  EXPECT_EQ(text.error().message,
            "a message sensor_msgs::msg::dds_::JointState_ of more than 4194304 bytes as JSON; so "
            "many are sent at most");
  joints.position.assign(300'000, -1.0 / 3);  // few enough by their number
  EXPECT_FALSE(JsonOf(joints));
  joints.position.resize(100'000);
  EXPECT_TRUE(JsonOf(joints));
}

}  // namespace musher::view::message_json_test
