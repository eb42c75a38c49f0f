// FromJson(): the bytes of a message that is given as JSON.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "musher/messages/definitions.hpp"
#include "musher/messages/geometry_msgs/geometry.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"
#include "musher/messages/nav_msgs/path.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/messages/sensor_msgs/range.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/messages/std_srvs/set_bool.hpp"
#include "musher/test/view/json/random_message.hpp"
#include "musher/view/json/message_json.hpp"

namespace musher::view::message_from_json_test {

using ::testing::HasSubstr;

template <class T>
T Read(std::string_view text) {
  const auto bytes = MessageJson().FromJson(T::kTypeName, text);
  EXPECT_TRUE(bytes) << bytes.error().message;
  return bytes ? msg::Decode<T>(bytes.value()).value() : T{};
}

template <class T>
std::string Refusal(std::string_view text) {
  const auto bytes = MessageJson().FromJson(T::kTypeName, text);
  if (bytes) return "accepted";
  EXPECT_EQ(bytes.error().code, kCodeParametersInvalid);
  return bytes.error().message;
}

TEST(MessageFromJson, ReadsEveryTypeAsItWasWritten) {
  MessageJson json;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    for (const msg::MessageDefinition& definition : msg::Definitions()) {
      const msg::Bytes bytes = RandomMessage(LayoutOf(definition), seed).Make();
      const auto text = json.ToJson(definition.dds_type, bytes);
      ASSERT_TRUE(text) << text.error().message;
      const auto again = json.FromJson(definition.dds_type, text.value());
      ASSERT_TRUE(again) << again.error().message;
      ASSERT_EQ(again.value(), bytes) << definition.dds_type << " of seed " << seed;
    }
  }
}

TEST(MessageFromJson, ToJsonReadsBothEndiannesses) {
  const std::vector<unsigned char> big = {0, 0, 0, 0, 0xff, 0xff, 0xff, 0xfe, 0, 0, 0, 5};
  const auto text =
      MessageJson().ToJson("builtin_interfaces::msg::dds_::Time_", std::as_bytes(std::span(big)));
  ASSERT_TRUE(text) << text.error().message;
  EXPECT_EQ(text.value(), R"({"sec":-2,"nanosec":5})");
}

TEST(MessageFromJson, AFieldThatIsNotGivenIsZeroOrEmpty) {
  EXPECT_EQ(Read<msg::String>("{}").data, "");
  const auto twist = Read<msg::Twist>(R"({"linear":{"x":0.5}})");
  EXPECT_EQ(twist.linear.x, 0.5);
  EXPECT_EQ(twist.angular.z, 0);
  const auto status = Read<msg::MachineStatus>(R"({"epoch":7,"actuators":[{"name":"audio"},{}]})");
  EXPECT_EQ(status.epoch, 7U);
  ASSERT_EQ(status.actuators.size(), 2U);
  EXPECT_EQ(status.actuators[0].name, "audio");
  EXPECT_TRUE(status.held_by_stop.empty());
}

TEST(MessageFromJson, ReadsIntegersOf64BitsAsNumberAndAsText) {
  EXPECT_EQ(Read<msg::HistoryEntry>(R"({"wall_ns":1765432101234567890})").wall_ns,
            1'765'432'101'234'567'890);
  EXPECT_EQ(Read<msg::HistoryEntry>(R"({"wall_ns":"-9223372036854775808"})").wall_ns,
            std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(Read<msg::HistoryEntry>(R"({"id":"18446744073709551615"})").id,
            std::numeric_limits<std::uint64_t>::max());
  EXPECT_THAT(Refusal<msg::HistoryEntry>(R"({"id":"18446744073709551616"})"),
              HasSubstr("id is \"18446744073709551616\"; expected an integer from 0 to "
                        "18446744073709551615"));
  EXPECT_THAT(Refusal<msg::HistoryEntry>(R"({"id":"7 "})"), HasSubstr("id is \"7 \""));
  EXPECT_THAT(Refusal<msg::HistoryEntry>(R"({"id":""})"), HasSubstr("id is \"\""));
}

TEST(MessageFromJson, RefusesAnIntegerThatTheFieldCannotHold) {
  EXPECT_THAT(Refusal<msg::ActuatorInfo>(R"({"pid":2147483648})"),
              HasSubstr("a message musher_msgs::msg::dds_::ActuatorInfo_: pid is 2147483648; "
                        "expected an integer from -2147483648 to 2147483647"));
  EXPECT_THAT(Refusal<msg::ActuatorInfo>(R"({"pid":1.5})"), HasSubstr("pid is 1.5"));
  EXPECT_THAT(Refusal<msg::ActuatorInfo>(R"({"pid":"7"})"), HasSubstr("pid is \"7\""));
  EXPECT_THAT(Refusal<msg::HistoryEntry>(R"({"id":-1})"), HasSubstr("id is -1; expected"));
}

TEST(MessageFromJson, ReadsNullAsNotANumberAndTheGreatestFloat) {
  EXPECT_TRUE(std::isnan(Read<msg::Range>(R"({"range":null})").range));
  constexpr float kMost = std::numeric_limits<float>::max();
  msg::Range range;
  range.range = kMost;
  const auto text = MessageJson().ToJson(msg::Range::kTypeName, msg::Encode(range));
  EXPECT_EQ(Read<msg::Range>(text.value()).range, kMost);
  EXPECT_THAT(Refusal<msg::Range>(R"({"range":1e39})"),
              HasSubstr("range is 1e+39; expected a number"));
  EXPECT_THAT(Refusal<msg::Twist>(R"({"linear":{"x":1e999}})"),
              HasSubstr("the text has a number that is too large"));
}

TEST(MessageFromJson, NamesTheFieldThatIsWrong) {
  EXPECT_THAT(Refusal<msg::MachineStatus>(R"({"actuators":[{},{"critical":1}]})"),
              HasSubstr("actuators[1].critical is 1; expected true or false"));
  EXPECT_THAT(Refusal<msg::MachineStatus>(R"({"actuators":[{},{"nmae":"audio"}]})"),
              HasSubstr("actuators[1] has no field \"nmae\"; its fields: name, state, target"));
  EXPECT_THAT(Refusal<msg::MachineStatus>(R"({"degraded":"audio"})"),
              HasSubstr("degraded is \"audio\"; expected an array"));
  EXPECT_THAT(Refusal<msg::Twist>(R"({"linear":[1,2,3]})"),
              HasSubstr("linear is an array of 3; expected an object"));
  EXPECT_THAT(Refusal<msg::PoseWithCovariance>(R"({"covariance":[0]})"),
              HasSubstr("covariance is an array of 1; expected an array of 36"));
  EXPECT_THAT(Refusal<msg::String>("7"), HasSubstr("the message is 7; expected an object"));
  EXPECT_THAT(Refusal<msg::String>(R"({"data":null})"), HasSubstr("data is null; expected a text"));
}

TEST(MessageFromJson, RefusesTheSizeOfAPictureInPlaceOfItsBytes) {
  EXPECT_THAT(Refusal<msg::Image>(R"({"data":{"bytes":921600}})"),
              HasSubstr("data is an object; expected an array: the bytes were left out"));
}

TEST(MessageFromJson, RefusesTextThatIsNotJsonAndSaysWhere) {
  EXPECT_THAT(Refusal<msg::String>(R"({"data":)"), HasSubstr("the text is not JSON at byte 9"));
  EXPECT_THAT(Refusal<msg::String>(""), HasSubstr("the text is not JSON at byte 1"));
  EXPECT_THAT(Refusal<msg::String>("{\"data\":\"\xff\"}"), HasSubstr("the text is not JSON"));
  EXPECT_THAT(Refusal<msg::String>(R"({"data":""} 7)"), HasSubstr("the text is not JSON"));
}

TEST(MessageFromJson, TextCutAnywhereIsRefused) {
  const std::string text = R"({"header":{"stamp":{"sec":1}},"range":1.5,"field_of_view":0})";
  for (std::size_t size = 0; size < text.size(); ++size) {
    EXPECT_THAT(Refusal<msg::Range>(text.substr(0, size)), HasSubstr("not JSON")) << size;
  }
  EXPECT_EQ(Read<msg::Range>(text).range, 1.5F);
}

TEST(MessageFromJson, BytesCutAnywhereGiveNoMessageOfAnyType) {
  MessageJson json;
  for (const msg::MessageDefinition& definition : msg::Definitions()) {
    if (definition.appended > 0) continue;  // a prefix may be a message of an older peer
    const msg::Bytes bytes = RandomMessage(LayoutOf(definition), 1).Make();
    const bool empty = LayoutOf(definition).types.front().empty();
    for (std::size_t size = 0; size + 1 < bytes.size() + (empty ? 0 : 1); ++size) {
      ASSERT_FALSE(json.ToJson(definition.dds_type, std::span(bytes).first(size)))
          << definition.dds_type << " cut at " << size;
    }
  }
}

TEST(MessageFromJson, WritesTheRequestOfAServiceWithAnIdOfZeros) {
  const std::string type(msg::SetBool::kTypeName);
  const auto bytes =
      MessageJson().FromJson(type.substr(0, type.size() - 1) + "_Request_", R"({"data":true})");
  ASSERT_TRUE(bytes) << bytes.error().message;
  msg::Bytes expected = msg::Encode(msg::RequestId{});
  expected.push_back(std::byte{1});
  EXPECT_EQ(bytes.value(), expected);
}

TEST(MessageFromJson, WritesAnEmptyRequestWithItsUnusedByte) {
  const auto bytes = MessageJson().FromJson("std_srvs::srv::dds_::Trigger_Request_", "{}");
  ASSERT_TRUE(bytes) << bytes.error().message;
  EXPECT_EQ(bytes.value().size(), 4U + 16U + 1U);
}

TEST(MessageFromJson, FewCharactersMakeNoMessageWithoutABound) {
  std::string text = R"({"poses":[{})";
  while (text.size() < MessageJson::kMostText - 10) text += ",{}";
  EXPECT_THAT(Refusal<msg::Path>(text + "]}"), HasSubstr("it has more than 16777216 bytes"));
  EXPECT_THAT(Refusal<msg::String>(std::string(MessageJson::kMostText + 1, ' ')),
              HasSubstr("at most 4194304 are read"));
}

TEST(MessageFromJson, DeepTextTakesNoStack) {
  const std::string deep(MessageJson::kMostText / 2, '[');
  EXPECT_THAT(Refusal<msg::String>(deep), HasSubstr("not JSON"));
  EXPECT_THAT(Refusal<msg::String>(deep + std::string(deep.size(), ']')),
              HasSubstr("an array of 1"));
}

TEST(MessageFromJson, RefusesATypeThatTheIdlDoesNotDefine) {
  const auto bytes = MessageJson().FromJson("my_msgs::msg::dds_::Own_", "{}");
  ASSERT_FALSE(bytes);
  EXPECT_EQ(bytes.error().message, "Musher does not know the type my_msgs::msg::dds_::Own_");
}

}  // namespace musher::view::message_from_json_test
