#include "musher/modules/vision/faces/face_watch.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "musher/modules/vision/faces/faces_json.hpp"
#include "musher/test/modules/vision/faces.hpp"

namespace musher::vision::face_watch_test {

// Faces of 0.18 m before the world's front camera; a picture each 100 ms.
class FaceWatchTest : public ::testing::Test {
 protected:
  static FaceBox FaceOf(double distance_m, double center_x = 0.5) {
    return FaceAt(center_x, 0.5, HeightAt(distance_m, 0.18));
  }
  Sight See(const std::vector<FaceBox>& boxes, std::optional<Lens> lens = FrontLens()) {
    now_ns_ += 100 * kMs;
    return watch_.OnPicture(now_ns_, boxes, lens);
  }
  Sight SeeTwice(const std::vector<FaceBox>& boxes) {
    See(boxes);
    return See(boxes);
  }

  FaceWatch watch_{{}};
  std::int64_t now_ns_ = 0;
};

TEST_F(FaceWatchTest, SeesEachFaceAndItsDistance) {
  EXPECT_TRUE(See({FaceOf(1.5)}).faces.empty());
  const Sight sight = See({FaceOf(1.5)});
  ASSERT_TRUE(sight.target);
  EXPECT_NEAR(*sight.target->distance_m, 1.5, 0.01);
  EXPECT_NEAR(sight.target->box.center_x(), 0.5, 1e-9);
  EXPECT_EQ(sight.too_close, false);
  EXPECT_EQ(sight.stamp_ns, now_ns_);
}

TEST_F(FaceWatchTest, ChoosesTheNearestFaceThatLooksAtTheRobot) {
  const Sight sight = SeeTwice({TurnedAway(FaceOf(0.9, 0.2)), FaceOf(1.2, 0.5), FaceOf(2, 0.8)});
  EXPECT_EQ(sight.faces.size(), 3U);
  ASSERT_TRUE(sight.target);
  EXPECT_NEAR(sight.target->box.center_x(), 0.5, 1e-9);
}

TEST_F(FaceWatchTest, ReportsTooCloseAlsoForAPersonWhoLooksAway) {
  const Sight sight = SeeTwice({TurnedAway(FaceOf(0.4))});
  EXPECT_FALSE(sight.target);
  EXPECT_EQ(sight.too_close, true);
}

TEST_F(FaceWatchTest, ASingleFalseDetectionIsNeitherATargetNorTooClose) {
  SeeTwice({FaceOf(2, 0.2)});
  const Sight sight = See({FaceOf(2, 0.2), FaceOf(0.3, 0.7)});
  EXPECT_NEAR(sight.target->box.center_x(), 0.2, 1e-9);
  EXPECT_EQ(sight.too_close, false);
}

TEST_F(FaceWatchTest, AGuestWhoComesUntilTheFaceFillsThePictureAndGoesBack) {
  for (double distance_m = 2; distance_m > 0.3; distance_m -= 0.1) See({FaceOf(distance_m)});
  for (int i = 0; i < 80; ++i) {
    const Sight sight = See({});
    EXPECT_EQ(sight.too_close, true) << "lost for " << i / 10.0 << " s";
    EXPECT_FALSE(sight.target);
  }
  Sight sight;
  for (double distance_m = 0.35; distance_m < 1.3; distance_m += 0.05)
    sight = See({FaceOf(distance_m)});
  EXPECT_EQ(sight.too_close, false);
  EXPECT_EQ(sight.target->id, 1) << "the same guest";
}

TEST_F(FaceWatchTest, WithoutALensReportsTheNearestWithoutADistance) {
  See({FaceOf(1, 0.2), FaceOf(2, 0.8)}, std::nullopt);
  const Sight sight = See({FaceOf(1, 0.2), FaceOf(2, 0.8)}, std::nullopt);
  ASSERT_TRUE(sight.target);
  EXPECT_NEAR(sight.target->box.center_x(), 0.2, 1e-9);
  EXPECT_FALSE(sight.target->distance_m);
  EXPECT_FALSE(sight.too_close) << "unknown";
}

TEST_F(FaceWatchTest, WritesItsFacesAsJson) {
  See({FaceOf(1)});
  const Sight sight = See({FaceOf(1)});
  const auto json = nlohmann::json::parse(FacesJson(sight));
  EXPECT_EQ(json.at("count"), 1);
  EXPECT_NEAR(json.at("timestamp"), 0.2, 1e-9);
  const auto& face = json.at("faces").at(0);
  EXPECT_NEAR(face.at("center_x"), 0.5, 1e-9);
  EXPECT_NEAR(face.at("area"), face.at("width").get<double>() * face.at("height").get<double>(),
              1e-12);
  EXPECT_EQ(face.at("is_frontal"), true);
  EXPECT_EQ(face.at("face_id"), 1);
  EXPECT_NEAR(face.at("distance"), 1, 0.01);
  for (const char* key :
       {"x", "y", "center_y", "yaw", "pitch", "roll", "confidence", "timestamp"}) {
    EXPECT_TRUE(face.at(key).is_number()) << key;
  }
}

TEST(FacesJson, WithoutFacesIsAnEmptyList) {
  Sight empty;
  empty.stamp_ns = 1500 * kMs;
  EXPECT_EQ(FacesJson(empty), R"({"faces":[],"count":0,"timestamp":1.5})");
}

}  // namespace musher::vision::face_watch_test
