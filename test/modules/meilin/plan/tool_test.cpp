// The command-line tools check and plan.

#include "musher/modules/meilin/plan/tool.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "musher/modules/meilin/plan/plan_text.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::meilin::tool_test {
namespace {

using ::testing::HasSubstr;

class PlanToolTest : public ::testing::Test {
 protected:
  struct Ran {
    int code = 0;
    std::string out;
    std::string err;
  };

  static Ran Run(std::vector<std::string> words, const FileCheck& others = {}) {
    std::vector<const char*> argv;
    argv.reserve(words.size());
    for (const std::string& word : words) argv.push_back(word.c_str());
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    Ran ran;
    ran.code = RunPlanTool(static_cast<int>(argv.size()), argv.data(), others);
    ran.out = ::testing::internal::GetCapturedStdout();
    ran.err = ::testing::internal::GetCapturedStderr();
    return ran;
  }
  std::string File(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }

  const std::string map_file_ = SourceDir() + "/config/meilin/boxes.toml";
  const std::string plan_file_ = SourceDir() + "/config/meilin/plan.toml";
  const TempFolder folder_;
};

TEST_F(PlanToolTest, AcceptsTheShippedFiles) {
  const Ran ran = Run({"check", map_file_, plan_file_});
  EXPECT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("boxes.toml: no errors"));
}

TEST_F(PlanToolTest, ReportsTheErrorsOfEachKindOfFile) {
  const std::string old_plan = File("old.json", R"({"segments": [{"segment_type": "ALIGNN"}]})");
  const std::string map = File("map.json", R"({"grid": [], "team": "red"})");
  const std::string plan = File("plan.toml", "[[step]]\nmove = [1, 1]\n");
  const std::string toml_map = File("map.toml", "team = \"red\"\n");
  const Ran ran = Run({"check", old_plan, map, plan, toml_map, folder_ / "nothing.toml", "a.txt"});
  EXPECT_EQ(ran.code, 2);
  EXPECT_THAT(ran.err, HasSubstr("segments[0].segment_type: unknown value 'ALIGNN'"));
  EXPECT_THAT(ran.err, HasSubstr("map.json: error: grid: expected six rows"));
  EXPECT_THAT(ran.err, HasSubstr("plan.toml:1:1: error: move with height change requires"));
  EXPECT_THAT(ran.err, HasSubstr("the key \"grid\" is missing"));
  EXPECT_THAT(ran.err, HasSubstr("nothing.toml"));
  EXPECT_THAT(ran.err, HasSubstr("a.txt: error: expected a plan or a map of boxes"));
}

TEST_F(PlanToolTest, LeavesOtherFilesToItsCaller) {
  const FileCheck trees = [](const std::string& path) {
    return std::optional(std::vector<Diagnostic>{{path, 3, 1, Severity::kWarning, "a tree"}});
  };
  const Ran ran = Run({"check", "a.xml"}, trees);
  EXPECT_EQ(ran.code, 0);
  EXPECT_THAT(ran.err, HasSubstr("a.xml:3:1: warning: a tree"));
}

TEST_F(PlanToolTest, PrintsThePlanOfAMapAsTableAndDrawing) {
  const Ran ran = Run({"plan", map_file_});
  EXPECT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("3 KFS2: "));
  EXPECT_THAT(ran.out, HasSubstr("2 KFS2, "));
  EXPECT_THAT(ran.out, HasSubstr("   1  move (0, "));
  EXPECT_THAT(ran.out, HasSubstr("400 mm KFS2"));
  const Ran none = Run({"plan", map_file_, "--kfs2", "0", "--index", "2"});
  EXPECT_THAT(none.out, HasSubstr("\n0 KFS2, "));
}

TEST_F(PlanToolTest, PlansFromTheEntranceThatIsChosen) {
  const std::string map = File("map.json", R"({"grid": [[0,1,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],
      [0,0,0]], "team": "blue"})");
  EXPECT_THAT(Run({"plan", map}).out, HasSubstr("   1  move (0, 0)"));
  EXPECT_THAT(Run({"plan", map, "--entrance", "2"}).out, HasSubstr("   1  move (0, 2)"));
  EXPECT_EQ(Run({"plan", map, "--entrance", "3"}).code, 2);
}

TEST_F(PlanToolTest, PrintsADrawnPlan) {
  const Ran ran = Run({"plan", plan_file_});
  EXPECT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("   2  fetch (1, 1)  forward     +200 mm    0 deg   1 1 1 200 0"));
  EXPECT_THAT(ran.out,
              HasSubstr("   4  fetch (1, 2)  left        +200 mm   90 deg   1 1 2 200 1.571"));
  const Ran json = Run({"plan", plan_file_, "--json"});
  EXPECT_THAT(json.out, HasSubstr("[[0,0,1,0.0,0.0,0,0,0],[1,1,1,200.0"));
}

TEST_F(PlanToolTest, ExitsWithTwoForUsageAndForAMapWithoutAPlan) {
  EXPECT_EQ(Run({"check"}).code, 2);
  EXPECT_EQ(Run({"plan", map_file_, "--kfs2", "7"}).code, 2);
  EXPECT_EQ(Run({"plan", map_file_, "--kfs2", "4"}).code, 2);
  const Ran closed = Run({"plan", File("closed.json", R"({"grid": [[0,0,0],[3,3,3],[0,0,0],[0,0,0],
      [0,0,0],[0,0,0]], "team": "red"})")});
  EXPECT_EQ(closed.code, 2);
  EXPECT_THAT(closed.err, HasSubstr("no plan for this map: no path leads to row 5: fake boxes"));
  EXPECT_EQ(Run({"plan", "--help"}).code, 0);
  EXPECT_TRUE(IsPlanTool("plan"));
  EXPECT_FALSE(IsPlanTool("models"));
}

TEST(FieldDrawing, HasColumnZeroAtTheRight) {
  BoxMap map;
  map.boxes[1][0] = Box::kFake;
  const std::string drawing = FieldDrawing(map, {{false, {0, 2}, 0, 0}});
  EXPECT_THAT(drawing, HasSubstr("row 1| 400 mm         | 200 mm         | 400 mm fake    |"));
  EXPECT_THAT(drawing, HasSubstr("| to 1           |                |                |"));
}

}  // namespace
}  // namespace musher::meilin::tool_test
