// What `musher-meilin check` does with trees and match configs, beside plans.

#include "musher/modules/meilin/mission/tree_tool.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/modules/meilin/plan/tool.hpp"
#include "musher/test/modules/meilin/mission/match.hpp"

namespace musher::meilin::tree_tool_test {

using testing::ConfigFile;

TEST(TheCheckOfAMatch, TakesTreesMatchConfigsAndPlansInOneCommand) {
  const std::vector<std::string> files = {
      ConfigFile("full_match.xml"), ConfigFile("meilin_stage.xml"), ConfigFile("segments.xml"),
      ConfigFile("match_red.json"), ConfigFile("plan_blue.toml"),   ConfigFile("boxes.toml")};
  std::vector<const char*> arguments = {"check"};
  for (const std::string& file : files) arguments.push_back(file.c_str());
  EXPECT_EQ(RunPlanTool(static_cast<int>(arguments.size()), arguments.data(), CheckTreeOrMatch), 0);
}

TEST(TheCheckOfAMatch, LeavesPlansToTheOtherTool) {
  EXPECT_FALSE(CheckTreeOrMatch(ConfigFile("plan_blue.toml")).has_value());
}

TEST(TheCheckOfAMatch, NamesAFileThatCannotBeRead) {
  const auto found = CheckTreeOrMatch("nowhere.xml");
  ASSERT_TRUE(found.has_value());
  ASSERT_EQ(found->size(), 1U);
  EXPECT_EQ(FormatDiagnostic(found->front()),
            "nowhere.xml: error: the file cannot be read: No such file or directory");
}

}  // namespace musher::meilin::tree_tool_test
