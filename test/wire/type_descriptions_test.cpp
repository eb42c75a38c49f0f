// Types as ROS 2 describes them: a description is right if its hash is that of the type.

#include "musher/wire/type_descriptions.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <openssl/sha.h>

#include <array>
#include <string>

#include "musher/messages/definitions.hpp"
#include "musher/messages/type_hash.hpp"

namespace musher::transport::type_descriptions_test {

using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string Json(const msg::IndividualTypeDescription& type) {
  std::string fields;
  for (const msg::DescribedField& field : type.fields) {
    if (!fields.empty()) fields += ", ";
    fields += "{\"name\": \"" + field.name +
              "\", \"type\": {\"type_id\": " + std::to_string(field.type.type_id) +
              ", \"capacity\": " + std::to_string(field.type.capacity) +
              ", \"string_capacity\": " + std::to_string(field.type.string_capacity) +
              ", \"nested_type_name\": \"" + field.type.nested_type_name + "\"}}";
  }
  return "{\"type_name\": \"" + type.type_name + "\", \"fields\": [" + fields + "]}";
}

// As rosidl computes it (REP 2011).
std::string HashOf(const msg::TypeDescription& description) {
  std::string referenced;
  for (const auto& type : description.referenced_type_descriptions) {
    referenced += (referenced.empty() ? "" : ", ") + Json(type);
  }
  const std::string json = "{\"type_description\": " + Json(description.type_description) +
                           ", \"referenced_type_descriptions\": [" + referenced + "]}";
  std::array<unsigned char, SHA256_DIGEST_LENGTH> digest{};
  SHA256(reinterpret_cast<const unsigned char*>(json.data()), json.size(), digest.data());
  std::string hash = "RIHS01_";
  for (const unsigned char byte : digest) hash += fmt::format("{:02x}", byte);
  return hash;
}

TEST(TypeDescriptions, HaveTheHashOfEveryTypeInTheIdl) {
  ASSERT_GT(msg::Definitions().size(), 200U);
  for (const msg::MessageDefinition& definition : msg::Definitions()) {
    const auto description = DescribeType(definition.ros_type);
    ASSERT_TRUE(description) << definition.ros_type;
    EXPECT_EQ(HashOf(*description), msg::TypeHashOf(definition.dds_type)) << definition.ros_type;
  }
}

msg::GetTypeDescription::Request RequestOf(const std::string& type, const std::string& hash) {
  msg::GetTypeDescription::Request request;
  request.type_name = type;
  request.type_hash = hash;
  return request;
}

TEST(TypeDescriptions, AreAnsweredWithTheirSourcesForTheHashOfTheType) {
  auto request = RequestOf("std_msgs/msg/Header",
                           std::string(msg::TypeHashOf("std_msgs::msg::dds_::Header_")));
  const auto response = Describe(request);
  EXPECT_TRUE(response.successful) << response.failure_reason;
  EXPECT_THAT(response.type_sources,
              ElementsAre(Field(&msg::TypeSource::raw_file_contents,
                                "builtin_interfaces/Time stamp\nstring frame_id\n"),
                          Field(&msg::TypeSource::type_name, "builtin_interfaces/msg/Time")));
  request.include_type_sources = false;
  EXPECT_THAT(Describe(request).type_sources, IsEmpty());
}

TEST(TypeDescriptions, AreRefusedWithTheReasonForAnotherHashAndAnUnknownType) {
  const auto other = Describe(RequestOf("std_msgs/msg/Header", "RIHS01_00"));
  EXPECT_FALSE(other.successful);
  EXPECT_THAT(other.failure_reason, HasSubstr("the hash of std_msgs/msg/Header is RIHS01_"));
  const auto unknown = Describe(RequestOf("robot_msgs/msg/Own", "RIHS01_00"));
  EXPECT_EQ(unknown.failure_reason, "Musher has no definition of robot_msgs/msg/Own");
}

}  // namespace musher::transport::type_descriptions_test
