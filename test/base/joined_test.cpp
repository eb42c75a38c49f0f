#include "musher/base/joined.hpp"

#include <gtest/gtest.h>

#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "musher/lifecycle/state.hpp"

namespace musher::joined_test {

TEST(Joined, SeparatesNamesByCommas) {
  EXPECT_EQ(Joined(std::vector<std::string>{"legs"}), "legs");
  EXPECT_EQ(Joined(std::vector<std::string>{"legs", "", "arm"}), "legs, , arm");
}

TEST(Joined, TakesAnyContainerOfNames) {
  EXPECT_EQ(Joined(std::set<std::string>{"legs", "arm"}), "arm, legs");
  EXPECT_EQ(Joined(std::vector<std::string_view>{"legs", "arm"}), "legs, arm");
  EXPECT_EQ(Joined(std::vector<State>{State(kActive), State(kSetUp)}), "Active, SetUp");
}

TEST(Joined, GivesTheTextForNoNamesAtAll) {
  EXPECT_EQ(Joined(std::vector<std::string>{}), "");
  EXPECT_EQ(Joined(std::vector<std::string>{}, "none"), "none");
  EXPECT_EQ(Joined(std::vector<std::string>{""}, "none"), "");
}

}  // namespace musher::joined_test
