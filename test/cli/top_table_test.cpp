#include "musher/cli/render/top_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "musher/cli/console/table.hpp"

namespace musher::cli::top_table_test {

using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

TopRow Row(const std::string& name, double cpu, std::uint64_t memory) {
  TopRow row;
  row.name = name;
  row.state = "Active";
  row.health = "well";
  row.cpu_percent = cpu;
  row.memory_bytes = memory;
  row.threads = 7;
  row.heartbeat_age_s = 0.1;
  row.event = name.substr(0, name.find('*')) + ": Active done after 3.2 ms";
  row.event_age_s = 300;
  return row;
}

TopView Robot() {
  return {"dog  Active  (running)",
          {Row("(controller)", 0.5, 20'000'000), Row("legs*", 1.5, 12'300'000),
           Row("eyes", 99.9, 2'100'000'000), Row("arm", 0, 1'000'000)}};
}

std::vector<std::string> LinesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> NamesBy(TopOrder order) {
  TopView view = Robot();
  Sort(view.rows, order);
  std::vector<std::string> names;
  for (const TopRow& row : view.rows) names.push_back(row.name);
  return names;
}

TEST(TopTable, IsOneLineForEachProcess) {
  const auto lines = LinesOf(TopText(Robot(), 0, 0, false));
  ASSERT_EQ(lines.size(), 6U);
  EXPECT_EQ(lines[0], "dog  Active  (running)");
  EXPECT_EQ(lines[1], "ACTUATOR          STATE       CPU%    MEM THR  BEAT CHKPT RST LAST EVENT");
  EXPECT_EQ(
      lines[3],
      "legs*             Active       1.5  12.3M   7  0.1s    ok   0 Active done after 3.2 ms, "
      "5 min ago");
}

TEST(TopTable, FitsIntoTheTerminal) {
  for (const std::string& line : LinesOf(TopText(Robot(), 80, 0, false))) {
    EXPECT_LE(Width(line), 80U) << line;
  }
  const auto lines = LinesOf(TopText(Robot(), 80, 5, false));
  ASSERT_EQ(lines.size(), 5U);
  EXPECT_EQ(lines.back(), "and 2 more: the terminal has no room");
}

TEST(TopTable, ShowsWhatIsNotKnownAsADash) {
  TopRow row = Row("eyes", 0, 0);
  row.cpu_percent.reset();
  row.memory_bytes.reset();
  row.threads.reset();
  row.heartbeat_age_s.reset();
  row.elsewhere = true;
  row.event.clear();
  EXPECT_EQ(LinesOf(TopText({"", {row}}, 0, 0, false)).back(),
            "eyes              Active         -      -   -     -     -   0 on another host");
}

// By the clock of a controller on another computer it was hours ago.
TEST(TopTable, ShowsAnEventWithoutItsAgeWhereThatIsNotKnown) {
  TopRow row = Row("eyes", 0, 0);
  row.event_age_s.reset();
  EXPECT_THAT(LinesOf(TopText({"", {row}}, 0, 0, false)).back(), EndsWith("done after 3.2 ms"));
}

TEST(TopTable, NamesWhatIsWrong) {
  TopRow row = Row("eyes", 0, 0);
  row.health = "hung";
  row.checkpoint_age_s = 12.5;
  row.target = "LowPower";
  const std::string line = LinesOf(TopText({"", {row}}, 0, 0, false)).back();
  EXPECT_THAT(line, HasSubstr("\u2192LowPower"));
  EXPECT_THAT(line, HasSubstr("12.5s"));
  EXPECT_THAT(line, HasSubstr("hung; Active done"));
}

TEST(TopTable, IsSortedBelowTheController) {
  EXPECT_THAT(NamesBy(TopOrder::kConfig), ElementsAre("(controller)", "legs*", "eyes", "arm"));
  EXPECT_THAT(NamesBy(TopOrder::kCpu), ElementsAre("(controller)", "eyes", "legs*", "arm"));
  EXPECT_THAT(NamesBy(TopOrder::kMemory), ElementsAre("(controller)", "eyes", "legs*", "arm"));
  EXPECT_THAT(NamesBy(TopOrder::kName), ElementsAre("(controller)", "arm", "eyes", "legs*"));
}

TEST(TopTable, IsRedrawnWithoutClearingTheScreenFirst) {
  EXPECT_EQ(TopFrame("a\nbc\n"), "\x1b[Ha\x1b[K\r\nbc\x1b[K\x1b[J");
}

TEST(TopTable, HasADocumentForPrograms) {
  EXPECT_THAT(TopJson(Robot()),
              StartsWith(R"x({"title":"dog  Active  (running)","processes":[{)x"));
  EXPECT_THAT(TopJson(Robot()), HasSubstr(R"("cpu_percent":99.9,"memory_bytes":2100000000)"));
}

}  // namespace musher::cli::top_table_test
