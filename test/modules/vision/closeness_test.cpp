#include "musher/modules/vision/faces/closeness.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include "musher/test/modules/vision/faces.hpp"

namespace musher::vision::closeness_test {

// Near below 0.8 m, clear beyond 1 m, held for 10 s; a picture each 100 ms.
class ClosenessTest : public ::testing::Test {
 protected:
  bool See(const std::vector<Closeness::Sighting>& seen, std::int64_t after_ms = 100) {
    now_ns_ += after_ms * kMs;
    return closeness_.OnPicture(now_ns_, seen);
  }
  bool SeeNoFaceFor(std::int64_t ms) {
    for (std::int64_t passed = 0; passed < ms; passed += 100) See({});
    return closeness_.too_close();
  }

  Closeness closeness_{{}};
  std::int64_t now_ns_ = 0;
};

TEST_F(ClosenessTest, IsClearWithoutAPerson) {
  EXPECT_FALSE(See({}));
  EXPECT_FALSE(See({{1, 0.9}}));
}

// As after a restart next to a person whose face fills the picture.
TEST_F(ClosenessTest, IsUnknownUntilAFaceIsSeenOrTheHoldTimeHasPassed) {
  See({});
  SeeNoFaceFor(9900);
  EXPECT_FALSE(closeness_.known());
  See({});
  EXPECT_TRUE(closeness_.known());
  Closeness another{{}};
  another.OnPicture(now_ns_, {{1, 2.0}});
  EXPECT_TRUE(another.known());
  EXPECT_FALSE(another.too_close());
}

TEST_F(ClosenessTest, HasTwoLimitsSoThatItDoesNotFlicker) {
  EXPECT_TRUE(See({{1, 0.79}}));
  for (const double distance_m : {0.81, 0.99, 0.79, 0.99}) EXPECT_TRUE(See({{1, distance_m}}));
  EXPECT_FALSE(See({{1, 1.01}}));
  EXPECT_FALSE(See({{1, 0.81}}));
}

TEST_F(ClosenessTest, AMissedDetectionIsNotTreatedAsLeaving) {
  See({{1, 0.5}});
  EXPECT_TRUE(See({}));
  EXPECT_TRUE(See({{1, 0.5}}));
}

// Nearer still, the face fills the picture, and no detector finds it.
TEST_F(ClosenessTest, LosingTheFaceThatIsTooCloseDoesNotReadAsClear) {
  See({{1, 0.5}});
  See({{1, 0.3}});
  EXPECT_TRUE(SeeNoFaceFor(9900));
}

TEST_F(ClosenessTest, IsOverWhenThePicturesShowNoFaceForTheHoldTime) {
  See({{1, 0.3}});
  EXPECT_FALSE(SeeNoFaceFor(10200));
}

TEST_F(ClosenessTest, WithoutPicturesTimeShowsNothing) {
  See({{1, 0.3}});
  EXPECT_TRUE(See({}, 60000)) << "a minute without pictures: two seconds of it count";
  EXPECT_TRUE(SeeNoFaceFor(7900));
  EXPECT_FALSE(SeeNoFaceFor(300));
}

TEST_F(ClosenessTest, AnotherOneFartherAwayDoesNotClearTheFirst) {
  See({{1, 0.4}, {2, 2.0}});
  EXPECT_TRUE(See({{2, 2.0}}));
  EXPECT_FALSE(See({{1, 1.1}, {2, 2.0}}));
}

TEST_F(ClosenessTest, LastsUntilEveryPersonTooCloseHasLeft) {
  See({{1, 0.4}, {2, 0.5}});
  EXPECT_TRUE(See({{1, 1.1}, {2, 0.5}}));
  EXPECT_FALSE(See({{1, 1.1}, {2, 1.1}}));
}

RC_GTEST_PROP(ClosenessProperty, IsNeverClearOfAPersonWhoWasNotSeenToLeave, ()) {
  const ClosenessRules rules;
  Closeness closeness(rules);
  std::int64_t now_ns = 0;
  std::int64_t looked_ns = 0;  // since one was seen near, of pictures that do not show it
  bool near = false;
  const auto steps = *rc::gen::container<std::vector<std::pair<int, int>>>(
      rc::gen::pair(rc::gen::inRange(1, 5000), rc::gen::inRange(-10, 20)));
  for (const auto& [after_ms, decimetres] : steps) {
    now_ns += after_ms * kMs;
    looked_ns += std::min<std::int64_t>(after_ms, 2000) * kMs;
    const bool seen = decimetres > 0;
    const double distance_m = decimetres / 10.0;
    if (seen && distance_m < (near ? rules.clear_m : rules.near_m)) {
      near = true;
      looked_ns = 0;
    } else if (seen || looked_ns > 10'000 * kMs) {
      near = false;
    }
    std::vector<Closeness::Sighting> sightings;
    if (seen) sightings.push_back({1, distance_m});
    RC_ASSERT(closeness.OnPicture(now_ns, sightings) == near);
  }
}

}  // namespace musher::vision::closeness_test
