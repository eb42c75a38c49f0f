// The regions that can be covered, and the sentences for those that cannot.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "musher/modules/skills/coverage/region.hpp"

namespace musher::coverage::region_test {

using ::testing::IsEmpty;
using ::testing::SizeIs;

Ring Square(double x, double y, double side) {
  return {{x, y}, {x + side, y}, {x + side, y + side}, {x, y + side}};
}

std::string WhyNot(const Region& region) {
  const auto checked = Checked(region);
  return checked ? "" : checked.error().message;
}

TEST(Region, IsAPolygonWithHolesInEitherDirection) {
  EXPECT_THAT(WhyNot({Square(0, 0, 10), {}}), IsEmpty());
  Ring backwards = Square(2, 2, 3);
  std::ranges::reverse(backwards);
  EXPECT_THAT(WhyNot({Square(0, 0, 10), {backwards, Square(6, 6, 2)}}), IsEmpty());
}

TEST(Region, MayRepeatACorner) {
  Ring closed = Square(0, 0, 10);
  closed.push_back(closed.front());
  closed.insert(closed.begin() + 2, closed[1]);
  const auto checked = Checked({closed, {}});
  ASSERT_TRUE(checked) << checked.error().message;
  EXPECT_THAT(checked.value().boundary, SizeIs(4));
}

TEST(Region, HasAtLeastThreeCorners) {
  EXPECT_EQ(WhyNot({}), "the boundary has 0 corners; expected at least 3");
  EXPECT_EQ(WhyNot({{{0, 0}, {1, 0}, {1, 0}}, {}}),
            "the boundary has 2 corners; expected at least 3");
  EXPECT_EQ(WhyNot({Square(0, 0, 10), {{{1, 1}, {2, 2}}}}),
            "hole 1 has 2 corners; expected at least 3");
}

TEST(Region, HasNumbersThatAreFiniteAndNotTooLarge) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  for (const double number : {std::nan(""), kInfinite, -kInfinite, 1e300, 100001.0}) {
    EXPECT_THAT(WhyNot({{{0, 0}, {number, 0}, {1, 1}}, {}}),
                ::testing::HasSubstr("expected numbers between -100000 and 100000 m"));
  }
}

TEST(Region, DoesNotCrossOrTouchItself) {
  EXPECT_EQ(WhyNot({{{0, 0}, {10, 10}, {10, 0}, {0, 10}}, {}}),
            "the boundary crosses or touches itself near (10, 0)");
  EXPECT_EQ(WhyNot({{{0, 0}, {10, 0}, {10, 10}, {5, 0}, {0, 10}}, {}}),
            "the boundary crosses or touches itself near (10, 10)");
  EXPECT_EQ(WhyNot({{{0, 0}, {10, 0}, {5, 0}, {5, 5}}, {}}),
            "the boundary turns back on itself at (10, 0)");
  EXPECT_EQ(WhyNot({{{0, 0}, {1e-3, 0}, {0, 1e-3}}, {}}), "the boundary has no area");
}

TEST(Region, HasHolesInsideAndApart) {
  const Ring room = Square(0, 0, 10);
  EXPECT_EQ(WhyNot({room, {Square(20, 0, 2)}}), "hole 1 is outside of the boundary");
  EXPECT_EQ(WhyNot({room, {Square(9, 5, 2)}}),
            "hole 1 crosses or touches the boundary near (9, 5)");
  EXPECT_EQ(WhyNot({room, {Square(0, 5, 2)}}),
            "hole 1 crosses or touches the boundary near (0, 5)");
  EXPECT_EQ(WhyNot({room, {Square(-1, -1, 20)}}), "hole 1 is outside of the boundary");
  EXPECT_EQ(WhyNot({room, {Square(2, 2, 4), Square(5, 5, 4)}}),
            "hole 2 crosses or touches hole 1 near (5, 5)");
  EXPECT_EQ(WhyNot({room, {Square(2, 2, 6), Square(3, 3, 1)}}), "hole 2 is in hole 1");
  EXPECT_EQ(WhyNot({room, {Square(3, 3, 1), Square(2, 2, 6)}}), "hole 1 is in hole 2");
}

TEST(Region, HasAtMostFourHundredCorners) {
  Ring circle;
  for (int i = 0; i < 401; ++i) circle.push_back({std::cos(i / 64.0), std::sin(i / 64.0)});
  EXPECT_EQ(WhyNot({circle, {}}),
            "the boundary and its holes have 401 corners; expected at most 400");
}

}  // namespace musher::coverage::region_test
