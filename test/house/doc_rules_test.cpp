#include "musher/test/house/doc_rules.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace musher::house::doc_rules_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

const std::vector<SourceFile> kTree = {
    {"a/robot.toml", "x = 1\n"},
    {"a/main.cpp", "int a;\n  // [part]\n  int b;\n    int c;\n  // [part end]\nint d;\n"}};

SourceFile Document(const std::string& text) {
  return {"docs/guide.md", text};
}

TEST(DocRules, AcceptCodeThatEqualsItsFile) {
  const auto document = Document("<!-- a/robot.toml -->\n```toml\nx = 1\n```\n");
  EXPECT_THAT(StaleSnippets(document, kTree), IsEmpty());
}

TEST(DocRules, AcceptCodeThatEqualsItsPartMovedToTheLeft) {
  const auto document = Document("<!-- a/main.cpp [part] -->\n```cpp\nint b;\n  int c;\n```\n");
  EXPECT_THAT(StaleSnippets(document, kTree), IsEmpty());
}

TEST(DocRules, AcceptAPartThatIsTypedWithTheIndentationOfItsFile) {
  const std::string typed = "<!-- a/main.cpp +[part] -->\n```cpp\n";
  EXPECT_THAT(StaleSnippets(Document(typed + "  int b;\n    int c;\n```\n"), kTree), IsEmpty());
  EXPECT_THAT(StaleSnippets(Document(typed + "int b;\n  int c;\n```\n"), kTree),
              ElementsAre(HasSubstr("differs from a/main.cpp +[part]")));
}

TEST(DocRules, LeaveMarkersOutOfAWholeFile) {
  const auto document =
      Document("<!-- a/main.cpp -->\n```cpp\nint a;\n  int b;\n    int c;\nint d;\n```\n");
  EXPECT_THAT(StaleSnippets(document, kTree), IsEmpty());
}

TEST(DocRules, FindCodeThatDiffersAndPrintTheSource) {
  const auto document = Document("<!-- a/robot.toml -->\n```toml\nx = 2\n```\n");
  EXPECT_THAT(StaleSnippets(document, kTree),
              ElementsAre("docs/guide.md:2: differs from a/robot.toml, which is now:\nx = 1\n"));
}

TEST(DocRules, FindCodeOfUnknownOrigin) {
  EXPECT_THAT(StaleSnippets(Document("text\n```cpp\nint b;\n```\n"), kTree),
              ElementsAre(HasSubstr("without a source")));
  EXPECT_THAT(StaleSnippets(Document("text\n```python\nimport musher\n```\n"), kTree),
              ElementsAre(HasSubstr("without a source")));
  EXPECT_THAT(StaleSnippets(Document("<!-- a/b.cpp -->\n```cpp\n```\n"), kTree),
              ElementsAre(HasSubstr("there is no a/b.cpp")));
  EXPECT_THAT(StaleSnippets(Document("<!-- a/main.cpp [gone] -->\n```cpp\n```\n"), kTree),
              ElementsAre(HasSubstr("there is no a/main.cpp [gone]")));
}

TEST(DocRules, LeaveCommandsAndTheirOutputAlone) {
  EXPECT_THAT(StaleSnippets(Document("```sh\nmusher status\n```\n"), kTree), IsEmpty());
}

TEST(DocRules, FindLinksThatLeadNowhere) {
  EXPECT_THAT(
      DeadLinks(Document("[a](../a/robot.toml) [b](../a) [c](https://x.org) [d](#e)"), kTree),
      IsEmpty());
  EXPECT_THAT(DeadLinks(Document("\n[a](gone.md#there)"), kTree),
              ElementsAre("docs/guide.md:2: there is no docs/gone.md"));
  EXPECT_THAT(DeadLinks(Document("```cpp\n[&](auto& table) {}\n```\n[a](gone.md)"), kTree),
              ElementsAre("docs/guide.md:4: there is no docs/gone.md"))
      << "code has no links";
}

TEST(DocRules, FindCitedTestsThatDoNotExist) {
  const std::set<std::string> tests =
      TestsOf({{"test/a_test.cpp", "TEST_F(Doors, Open) {}\nTEST(Doors,\n     Close) {}\n"}});
  EXPECT_THAT(MissingTests(Document("`Doors.Open`, `Doors.Close`, `main.cpp`"), tests), IsEmpty());
  EXPECT_THAT(MissingTests(Document("\n`Doors.Slam`"), tests),
              ElementsAre("docs/guide.md:2: there is no test Doors.Slam"));
}

TEST(DocRules, FindWhatADocumentDoesNotExplain) {
  EXPECT_THAT(Unexplained(Document("`x` is a number"), kTree[0]), IsEmpty());
  EXPECT_THAT(Unexplained(Document("x is a number"), kTree[0]), SizeIs(1));
  const SourceFile idl = {"m.idl", "    sequence<string> names;  // all\n"};
  EXPECT_THAT(Unexplained(Document("`name`"), idl), SizeIs(1));
}

}  // namespace musher::house::doc_rules_test
