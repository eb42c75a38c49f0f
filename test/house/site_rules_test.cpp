#include "musher/test/house/site_rules.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace musher::house::site_rules_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(SiteRules, ReportAPageThatNoListHas) {
  const std::vector<SourceFile> tree = {
      {"README.md", "text"},
      {"docs/README.md",
       "## Learn\n\n- [What](../README.md)\n- [Choices](choices/README.md): why\n"},
      {"docs/choices/README.md", "1. [One](01-one.md)\n"},
      {"docs/choices/01-one.md", "see [two](02-two.md)\n- [two](02-two.md)\n"},
      {"docs/choices/02-two.md", "text"},
      {"docs/site/contents.py", "BRANCHES = {\"docs/README\", \"docs/choices/README\"}\n"}};
  EXPECT_THAT(
      PagesOutsideTheContents(tree),
      ElementsAre("docs/choices/02-two.md is in no list of links of a page of the contents"));
}

const SourceFile kEnglish = {
    "a.md",
    "# A\n\n## One\n\nRun it:\n\n```sh\nmake # all\n```\n\n<!-- a.cpp -->\n"
    "```cpp\nint a;\n```\n\n## Two\n\n```sh\nmake two\n```\n"};

TEST(SiteRules, AcceptATranslationWithTheSameCode) {
  const SourceFile chinese = {
      "a.zh.md",
      "# 甲\n\n运行：\n\n```sh\nmake # all\n```\n\n<!-- a.cpp -->\n```cpp\nint a;\n```\n"};
  EXPECT_THAT(DifferingBlocks(kEnglish, "One", chinese), IsEmpty());
}

TEST(SiteRules, ReportCodeThatDiffersOrIsMissingInATranslation) {
  const SourceFile chinese = {"a.zh.md",
                              "```sh\nmake\n```\n\n<!-- a.cpp -->\n```cpp\nint a;\n```\n"};
  EXPECT_THAT(DifferingBlocks(kEnglish, "", chinese),
              ElementsAre(HasSubstr("a.zh.md: code block 1: differs"),
                          HasSubstr("a.zh.md: code block 3: missing")));
  EXPECT_THAT(DifferingBlocks(kEnglish, "Three", chinese),
              ElementsAre("a.md: there is no code in 'Three'", HasSubstr("block 1: not in a.md"),
                          HasSubstr("block 2: not in a.md")));
}

TEST(SiteRules, AcceptATranslationWithTheSameHeadings) {
  EXPECT_THAT(DifferingHeadings(kEnglish, {"a.zh.md", "# 甲\n## 一\n```sh\n# all\n```\n## 二\n"}),
              IsEmpty());
}

TEST(SiteRules, ReportHeadingsThatAreMissingNewOrOfAnotherDepth) {
  EXPECT_THAT(DifferingHeadings(kEnglish, {"a.zh.md", "# 甲\n## 一\n"}),
              ElementsAre("a.zh.md: nothing translates \"## Two\""));
  EXPECT_THAT(DifferingHeadings(kEnglish, {"a.zh.md", "# 甲\n## 一\n## 二\n### 三\n"}),
              ElementsAre("a.zh.md:4: \"### 三\" is not in a.md"));
  EXPECT_THAT(DifferingHeadings(kEnglish, {"a.zh.md", "# 甲\n### 一\n## 二\n"}),
              ElementsAre("a.zh.md:2: \"### 一\" stands where a.md has \"## One\""));
}

TEST(SiteRules, ReportAHeaderWithoutThreads) {
  const std::vector<SourceFile> tree = {
      {"a.hpp", "#pragma once\n// A.\n//\n// Threads: any.\n\nint a;\n"},
      {"b.hpp", "#pragma once\n// B.\n\n// Threads: any.\nint b;\n"},
      {"docs/api/page.md",
       "```{header} a.hpp\n```\n\n```{header} b.hpp\n```\n```{header} c.hpp\n"}};
  EXPECT_THAT(HeadersWithoutThreads(tree), ElementsAre(HasSubstr("b.hpp: its comment has no line"),
                                                       "docs/api/page.md: there is no c.hpp"));
  EXPECT_THAT(HeadersWithoutThreads({}), ElementsAre("no page of docs/api shows a header"));
}

TEST(SiteRules, ReportADrawingThatFitsNoPage) {
  const std::vector<SourceFile> tree = {
      {"docs/images/fits.svg", "<svg width=\"523pt\" height=\"770pt\"\n viewBox"},
      {"docs/images/lies.svg", "<svg width=\"770pt\" height=\"523pt\"\n viewBox"},
      {"docs/images/wide.svg", "<svg width=\"524pt\" height=\"600pt\"\n viewBox"},
      {"docs/images/long.svg", "<svg width=\"10pt\" height=\"771pt\"\n viewBox"},
      {"docs/images/screen.svg", "<svg width=\"2000\" height=\"2000\">"}};
  EXPECT_THAT(DrawingsThatFitNoPage(tree),
              ElementsAre(HasSubstr("docs/images/wide.svg fits no page: 524 x 600 pt"),
                          HasSubstr("docs/images/long.svg fits no page: 10 x 771 pt")));
}

}  // namespace musher::house::site_rules_test
