// Lists of places as texts.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include "musher/modules/skills/skills/points_text.hpp"

namespace musher::skills::points_text_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::string WhyNot(std::string_view text) {
  const auto points = ParsePoints("path", text);
  return points ? "" : points.error().message;
}

TEST(PointsText, HasPlacesWithAndWithoutAHeight) {
  EXPECT_THAT(ParsePoints("path", "[[0, 1], [2,-3.5,4e0] ]").value(),
              ElementsAre(navigation::Point{0, 1, 0}, navigation::Point{2, -3.5, 4}));
  EXPECT_THAT(ParsePoints("path", "").value(), IsEmpty());
  EXPECT_THAT(ParsePoints("path", " [ ] ").value(), IsEmpty());
}

TEST(PointsText, HasListsOfPlaces) {
  EXPECT_THAT(ParseLists("holes", "[[[0, 1]], [[2, 3], [4, 5]]]").value(),
              ElementsAre(Points{{0, 1, 0}}, Points{{2, 3, 0}, {4, 5, 0}}));
  EXPECT_THAT(ParseLists("holes", "").value(), IsEmpty());
  EXPECT_FALSE(ParseLists("holes", "[[0, 1]]"));
}

TEST(PointsText, SaysWhereItIsWrongAndWhatWasExpected) {
  EXPECT_EQ(WhyNot("0, 1"), "path, character 1: expected '['");
  EXPECT_EQ(WhyNot("[0, 1]"), "path, character 2: expected '['");
  EXPECT_EQ(WhyNot("[[0, 1], [2]]"), "path, character 9: expected 2 or 3 numbers of a place");
  EXPECT_EQ(WhyNot("[[0, 1, 2, 3]]"), "path, character 11: expected 2 or 3 numbers of a place");
  EXPECT_EQ(WhyNot("[[0, x]]"), "path, character 6: expected a finite number");
  EXPECT_EQ(WhyNot("[[0, nan]]"), "path, character 6: expected a finite number");
  EXPECT_EQ(WhyNot("[[0, 1e999]]"), "path, character 6: expected a finite number");
  EXPECT_EQ(WhyNot("[[0, 1]"), "path, character 8: expected ',' or ']'");
  EXPECT_EQ(WhyNot("[[0, 1]] and"), "path, character 10: expected the end of the text");
}

TEST(PointsText, HasAtMostTenThousandPlaces) {
  std::string text = "[[0,0]";
  for (int i = 1; i < 10'000; ++i) text += ",[0,0]";
  EXPECT_EQ(WhyNot(text + "]"), "");
  EXPECT_EQ(WhyNot(text + ",[0,0]]"), "path, character 60007: expected at most 10000 places");
}

RC_GTEST_PROP(PointsText, OfAnyTextIsReadOrRefused, ()) {
  const auto text = *rc::gen::container<std::string>(rc::gen::elementOf(std::string("[[]],1.-e ")));
  const auto lists = ParseLists("holes", text);
  RC_ASSERT((lists.ok() || lists.error().message.starts_with("holes, character ")));
}

TEST(PointsText, WritesListsAsItReadsThem) {
  EXPECT_EQ(ListsText({{{0, 0.5, 3}, {1.234, -2, 0}}, {{5, 5, 0}}}),
            "[[[0.00, 0.50], [1.23, -2.00]], [[5.00, 5.00]]]");
  EXPECT_EQ(ListsText({}), "[]");
  EXPECT_EQ(ParseLists("x", ListsText({{{1, 2, 0}}, {{3, 4, 0}}})).value(),
            (std::vector<Points>{{{1, 2, 0}}, {{3, 4, 0}}}));
}

TEST(PointsText, KnowsSeveralListsFromOne) {
  EXPECT_TRUE(HasLists(" [ [[0, 0]]]"));
  for (const char* text : {"", "[[0, 0]]", "[]", "x [[[", "[[0, [0"}) EXPECT_FALSE(HasLists(text));
}

}  // namespace musher::skills::points_text_test
