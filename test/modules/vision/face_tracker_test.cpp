#include "musher/modules/vision/faces/face_tracker.hpp"

#include <gmock/gmock.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <limits>
#include <set>

#include "musher/test/modules/vision/faces.hpp"

namespace musher::vision::face_tracker_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// A picture each 100 ms.
class FaceTrackerTest : public ::testing::Test {
 protected:
  std::vector<int> See(const std::vector<FaceBox>& boxes, std::int64_t after_ms = 100) {
    now_ns_ += after_ms * kMs;
    tracker_.OnPicture(now_ns_, boxes);
    return Seen();
  }
  // The numbers of the tracks that are confirmed and seen.
  std::vector<int> Seen() const {
    std::vector<int> ids;
    for (const Track& track : tracker_.tracks()) {
      if (track.seen && track.confirmed) ids.push_back(track.id);
    }
    return ids;
  }

  TrackerRules rules_;
  FaceTracker tracker_{rules_};
  std::int64_t now_ns_ = 0;
};

TEST_F(FaceTrackerTest, ConfirmsAFaceWhenEnoughPicturesShowIt) {
  EXPECT_THAT(See({FaceAt(0.5, 0.5)}), IsEmpty());
  EXPECT_THAT(See({FaceAt(0.5, 0.5)}), ElementsAre(1));
}

TEST_F(FaceTrackerTest, ConfirmsNoFaceThatFlickers) {
  for (int i = 0; i < 10; ++i) {
    EXPECT_THAT(See({FaceAt(0.5, 0.5)}), IsEmpty());
    EXPECT_THAT(See({}, 600), IsEmpty());
  }
}

TEST_F(FaceTrackerTest, ConfirmsAFaceInPicturesThatAreFartherApartThanConfirmWithin) {
  EXPECT_THAT(See({FaceAt(0.5, 0.5)}, 600), IsEmpty());
  for (int i = 0; i < 10; ++i) EXPECT_THAT(See({FaceAt(0.5, 0.5)}, 600), ElementsAre(1));
}

TEST_F(FaceTrackerTest, KeepsTheNumberOfAFaceThatMoves) {
  for (double x = 0.1; x < 0.9; x += 0.05) See({FaceAt(x, 0.5)});
  EXPECT_THAT(Seen(), ElementsAre(1));
}

TEST_F(FaceTrackerTest, KeepsTheNumberOverALeapWithoutOverlap) {
  See({FaceAt(0.3, 0.5)});
  See({FaceAt(0.3, 0.5)});
  EXPECT_EQ(Iou(FaceAt(0.3, 0.5), FaceAt(0.55, 0.5)), 0);
  EXPECT_THAT(See({FaceAt(0.55, 0.5)}), ElementsAre(1));
  EXPECT_THAT(See({FaceAt(0.9, 0.5)}), IsEmpty()) << "beyond the distance it is another one";
}

TEST_F(FaceTrackerTest, GivesAFaceOfAnotherSizeAnotherNumber) {
  See({FaceAt(0.3, 0.5, 0.5)});
  See({FaceAt(0.3, 0.5, 0.5)});
  EXPECT_EQ(Iou(FaceAt(0.3, 0.5, 0.5), FaceAt(0.55, 0.5, 0.1)), 0);
  EXPECT_THAT(See({FaceAt(0.55, 0.5, 0.1)}), IsEmpty());
}

TEST_F(FaceTrackerTest, DistinguishesTwoFacesSideBySide) {
  for (int i = 0; i < 5; ++i) See({FaceAt(0.4, 0.5), FaceAt(0.6, 0.5)});
  EXPECT_THAT(See({FaceAt(0.61, 0.5), FaceAt(0.41, 0.5)}), ElementsAre(1, 2));
  EXPECT_NEAR(tracker_.tracks()[0].box.center_x(), 0.41, 1e-9);
}

TEST_F(FaceTrackerTest, RemembersAFaceForItsTimeAndNotForItsPictures) {
  See({FaceAt(0.5, 0.5)});
  See({FaceAt(0.5, 0.5)});
  for (int i = 0; i < 40; ++i) See({}, 120);
  EXPECT_THAT(See({FaceAt(0.5, 0.5)}), ElementsAre(1)) << "4.9 s later";
  See({}, 5100);
  EXPECT_THAT(tracker_.tracks(), IsEmpty());
  See({FaceAt(0.5, 0.5)});
  EXPECT_THAT(See({FaceAt(0.5, 0.5)}), ElementsAre(2));
}

TEST_F(FaceTrackerTest, SeesNoFaceThatIsSmallerThanTheSmallest) {
  for (int i = 0; i < 5; ++i) EXPECT_THAT(See({FaceAt(0.5, 0.5, 0.06)}), IsEmpty()) << "0.045 wide";
  for (int i = 0; i < 2; ++i) See({FaceAt(0.5, 0.5, 0.07)});
  EXPECT_THAT(Seen(), ElementsAre(1));
}

TEST_F(FaceTrackerTest, SmoothsTheSizeByTime) {
  See({FaceAt(0.5, 0.5, 0.2)});
  See({FaceAt(0.5, 0.5, 0.3)}, 150);
  EXPECT_NEAR(tracker_.tracks()[0].height, 0.3 - 0.1 * std::exp(-1), 1e-9);
  See({FaceAt(0.5, 0.5, 0.3)}, 2000);
  EXPECT_NEAR(tracker_.tracks()[0].height, 0.3, 1e-6);
}

TEST_F(FaceTrackerTest, TakesNoInvalidBox) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinite = std::numeric_limits<double>::infinity();
  for (const FaceBox& box :
       {FaceBox{nan, 0.1, 0.2, 0.2, true, 0.5}, FaceBox{0.1, 0.1, nan, 0.2, true, 0.5},
        FaceBox{0.1, 0.1, 0.2, infinite, true, 0.5}, FaceBox{0.1, 0.1, -0.2, 0.2, true, 0.5},
        FaceBox{0.95, 0.1, 0.2, 0.2, true, 0.5}, FaceBox{0.1, 0.1, 0.2, 0.2, true, nan}}) {
    See({box});
    EXPECT_THAT(tracker_.tracks(), IsEmpty());
  }
}

rc::Gen<FaceBox> AnyFace() {
  return rc::gen::map(
      rc::gen::tuple(rc::gen::inRange(0, 101), rc::gen::inRange(0, 101), rc::gen::inRange(2, 90)),
      [](const auto& drawn) {
        const auto [x, y, height] = drawn;
        return FaceAt(x / 100.0, y / 100.0, height / 100.0);
      });
}

RC_GTEST_PROP(FaceTrackerProperty, SeesEachBoxAsOneFaceAndGivesNoNumberTwice, ()) {
  const auto pictures = *rc::gen::container<std::vector<std::vector<FaceBox>>>(
      rc::gen::container<std::vector<FaceBox>>(AnyFace()));
  FaceTracker tracker{TrackerRules{}};
  std::int64_t now_ns = 0;
  int newest = 0;
  std::set<int> gone;
  std::set<int> before;
  for (const auto& boxes : pictures) {
    const std::int64_t gap_ns = *rc::gen::inRange(1, 3000) * kMs;
    now_ns += gap_ns;
    tracker.OnPicture(now_ns, boxes);
    std::size_t seen = 0;
    std::set<int> ids;
    for (const Track& track : tracker.tracks()) {
      seen += track.seen ? 1 : 0;
      RC_ASSERT(ids.insert(track.id).second);
      RC_ASSERT(!gone.contains(track.id));
      RC_ASSERT(before.contains(track.id) || track.id > newest);
      RC_ASSERT(now_ns - track.last_ns <= std::max(5000 * kMs, 2 * gap_ns));
    }
    for (const int id : before) {
      if (!ids.contains(id)) gone.insert(id);
    }
    before = ids;
    if (!ids.empty()) newest = std::max(newest, *ids.rbegin());
    const auto large = [](const FaceBox& box) { return box.width >= 0.05 && box.height >= 0.05; };
    RC_ASSERT(seen == std::size_t(std::count_if(boxes.begin(), boxes.end(), large)));
  }
}

}  // namespace musher::vision::face_tracker_test
