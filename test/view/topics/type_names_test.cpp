#include "musher/view/topics/type_names.hpp"

#include <gtest/gtest.h>

namespace musher::view::type_names_test {

TEST(TypeNames, ATypeHasOneNameInRosAndOneInDds) {
  EXPECT_EQ(RosType("std_msgs::msg::dds_::String_"), "std_msgs/msg/String");
  EXPECT_EQ(DdsType("std_msgs/msg/String"), "std_msgs::msg::dds_::String_");
}

TEST(TypeNames, AnotherNameIsNone) {
  for (const char* name : {"", "String", "a::b", "std_msgs::msg::dds_::_", "dds_::String_"}) {
    EXPECT_EQ(RosType(name), "") << name;
  }
  for (const char* name : {"", "String", "std_msgs/String", "std_msgs/msg/", "/msg/String"}) {
    EXPECT_EQ(DdsType(name), "") << name;
  }
}

}  // namespace musher::view::type_names_test
