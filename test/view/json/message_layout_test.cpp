#include "musher/view/json/message_layout.hpp"

#include <gtest/gtest.h>

#include "musher/messages/type_hash.hpp"

namespace musher::view::message_layout_test {

TEST(MessageLayoutTest, HasEveryTypeOfTheIdl) {
  ASSERT_EQ(msg::Definitions().size(), msg::TypeHashes().size());
  for (const msg::TypeHash& type : msg::TypeHashes()) {
    const msg::MessageDefinition* definition = msg::FindDefinition(type.type);
    ASSERT_NE(definition, nullptr) << type.type;
    EXPECT_FALSE(LayoutOf(*definition).types.empty());
  }
}

TEST(MessageLayoutTest, ReadsArraysSequencesBoundsAndNestedTypes) {
  const MessageLayout layout = LayoutOf({"", "",
                                         "my_msgs/Inner inner\nstring<=20[] names\nfloat64[36] "
                                         "covariance\nuint8[<=5] few\n====\nMSG: my_msgs/Inner\n"
                                         "bool yes\n"});
  ASSERT_EQ(layout.types.size(), 2U);
  const std::vector<MessageField>& fields = layout.types[0];
  ASSERT_EQ(fields.size(), 4U);
  EXPECT_EQ(fields[0].kind, FieldKind::kMessage);
  EXPECT_EQ(fields[0].type, 1U);
  EXPECT_EQ(fields[1].kind, FieldKind::kString);
  EXPECT_TRUE(fields[1].sequence);
  EXPECT_EQ(fields[2].length, 36U);
  EXPECT_FALSE(fields[2].sequence);
  EXPECT_TRUE(fields[3].sequence);
  EXPECT_EQ(layout.types[1][0].name, "yes");
}

TEST(MessageLayoutTest, FindsNoDefinitionOfAnUnknownType) {
  EXPECT_EQ(msg::FindDefinition("my_msgs::msg::dds_::Own_"), nullptr);
  EXPECT_EQ(msg::FindDefinition(""), nullptr);
}

}  // namespace musher::view::message_layout_test
