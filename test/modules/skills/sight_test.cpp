// object_detection and detect.

#include "musher/modules/skills/skills/sight.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "musher/test/modules/skills/fake_robot.hpp"

namespace musher::skills::sight_test {

using skill::Numbers;
using skill::Status;
using skill::Values;
using testing::Bench;
using ::testing::Contains;

class Sight : public ::testing::Test {
 protected:
  Sight() {
    bench_.robot.camera_names = {"front"};
    bench_.robot.seen = {{"car_far", "car", {{9, 0, 0}, 0}, ""},
                         {"car_near", "car", {{1.5, 0.5, 0.25}, 0}, ""},
                         {"car_behind", "car", {{-1, 0, 0}, 0}, ""},
                         {"box_red", "box", {{1, 0, 0}, 0}, "jetbot_0"}};
  }
  Bench bench_{"cf2x_0", "cf2x"};
};

TEST_F(Sight, ObjectDetectionFindsWhatIsInViewNearestFirst) {
  const skill::Feedback& end = bench_.Execute("object_detection");
  EXPECT_EQ(end.status, Status::kCompleted);
  EXPECT_EQ(end.message, "Detected: 1 x car, nearest car_near at (1.50, 0.50, 0.25), 1.6m away");
  EXPECT_EQ(end.details.Get<std::int64_t>("count", 0), 1);
  EXPECT_EQ(end.details.Text("name"), "car_near");
  EXPECT_EQ(end.details.Get<Numbers>("position", {}), (Numbers{1.5, 0.5, 0.25}));
  EXPECT_NEAR(end.details.Number("distance_m"), 1.601, 0.001);
}

TEST_F(Sight, ObjectDetectionLooksWhereTheRobotLooks) {
  bench_.robot.body.yaw_rad = M_PI;
  EXPECT_EQ(bench_.Execute("object_detection").details.Text("name"), "car_behind");
}

TEST_F(Sight, ObjectDetectionHasAViewThatCanBeWidened) {
  const skill::Feedback& all =
      bench_.Execute("object_detection", {{"radius", 0.0}, {"angle", 0.0}});
  EXPECT_EQ(all.details.Text("names"), "car_behind, car_near, car_far");
  const skill::Feedback& any = bench_.Execute("object_detection", {{"target_class", ""}});
  EXPECT_EQ(any.message, "Detected: 2 x object, nearest box_red at (1.00, 0.00, 0.00), 1.0m away");
}

TEST_F(Sight, ObjectDetectionTakesANameAndAPathAsWell) {
  const skill::Feedback& end =
      bench_.Execute("object_detection", {{"target_class", "/World/box_red"}});
  EXPECT_EQ(end.details.Text("name"), "box_red");
}

// That there is none is what it has observed.
TEST_F(Sight, ObjectDetectionCompletesWithNone) {
  const skill::Feedback& end = bench_.Execute("object_detection", {{"target_class", "cup"}});
  EXPECT_EQ(end.status, Status::kCompleted);
  EXPECT_EQ(end.message, "Detected: no cup in view");
  EXPECT_EQ(end.details.Get<std::int64_t>("count", -1), 0);
}

TEST_F(Sight, ObjectDetectionNeedsItsCameraAndAView) {
  EXPECT_EQ(bench_.Execute("object_detection", {{"camera_name", "rear"}}).message,
            "Camera 'rear' not available; there is front");
  EXPECT_EQ(bench_.Execute("object_detection", {{"radius", -1.0}}).message,
            "Invalid radius: it is negative");
  EXPECT_EQ(bench_.Execute("object_detection", {{"angle", -1.0}}).message,
            "Invalid angle: it is negative");
}

TEST_F(Sight, BothWaitForObjectsAndFailAfterFiveSeconds) {
  for (const std::string skill : {"object_detection", "detect"}) {
    const Values parameters = skill == "detect" ? Values{{"target_prim", "car"}} : Values{};
    bench_.robot.has_objects = false;
    const double start_s = bench_.seconds();
    EXPECT_EQ(bench_.Execute(skill, parameters).message,
              "Timeout: no objects were received after 5 s");
    EXPECT_NEAR(bench_.seconds() - start_s, 5.2, 0.2);
    EXPECT_THAT(bench_.messages, Contains("50 Waiting for objects"));
    bench_.robot.has_objects = true;
    bench_.robot.has_odometry = false;
    EXPECT_EQ(bench_.Execute(skill, parameters).message,
              "Timeout: No odometry of cf2x_0 after 5 s");
    bench_.Start(skill, parameters);
    bench_.StepFor(2);
    bench_.robot.has_odometry = true;
    EXPECT_EQ(bench_.RunOut().status, Status::kCompleted);
  }
}

TEST_F(Sight, DetectFindsTheTargetHoweverFarAway) {
  const skill::Feedback& end = bench_.Execute("detect", {{"target_prim", "car_far"}});
  EXPECT_EQ(end.status, Status::kCompleted);
  EXPECT_EQ(end.message, "Detected: car_far at (9.00, 0.00, 0.00), 9.0m away");
}

TEST_F(Sight, DetectFindsAllOfACategory) {
  const skill::Feedback& end = bench_.Execute("detect", {{"target_prim", "car"}});
  EXPECT_EQ(end.details.Get<std::int64_t>("count", 0), 3);
  EXPECT_EQ(end.details.Text("names"), "car_behind, car_near, car_far");
}

TEST_F(Sight, DetectOfAnUnknownTargetFailsWithWhatThereIs) {
  const skill::Feedback& end = bench_.Execute("detect", {{"target_prim", "box_rad"}});
  EXPECT_EQ(end.status, Status::kFailed);
  EXPECT_EQ(end.message,
            "there is no object 'box_rad'; did you mean 'box_red'? There are box, box_red, car, "
            "car_behind, car_far and car_near");
  bench_.robot.seen.clear();
  EXPECT_EQ(bench_.Execute("detect", {{"target_prim", "cup"}}).message, "there is no object 'cup'");
}

TEST_F(Sight, DetectNeedsATarget) {
  EXPECT_FALSE(bench_.manager().Start("detect", {}).ok());
  EXPECT_EQ(bench_.Execute("detect", {{"target_prim", ""}}).message, "Object path required");
  EXPECT_EQ(bench_.Execute("detect", {{"target_prim", "/World/"}}).message, "Object path required");
}

TEST_F(Sight, NeitherSeesAnObjectAtNoPlace) {
  for (SeenObject& object : bench_.robot.seen) object.pose.at.x_m = std::nan("");
  EXPECT_EQ(bench_.Execute("object_detection").message, "Detected: no car in view");
  EXPECT_EQ(bench_.Execute("detect", {{"target_prim", "car"}}).status, Status::kFailed);
}

TEST_F(Sight, BothAreCancelledWhileTheyWait) {
  bench_.robot.has_objects = false;
  for (const std::string skill : {"object_detection", "detect"}) {
    bench_.Start(skill, skill == "detect" ? Values{{"target_prim", "car"}} : Values{});
    bench_.StepFor(1);
    bench_.manager().Pause();
    bench_.StepFor(1);
    ASSERT_TRUE(bench_.manager().Cancel(skill, "").ok());
    EXPECT_EQ(bench_.RunOut().status, Status::kCancelled);
  }
}

TEST(View, IncludesItsEdgeAndThePlaceOfTheRobot) {
  const std::vector<SeenObject> objects{{"a", "", {{2, 0, 0}, 0}, ""},
                                        {"b", "", {{0, 0, 1}, 0}, ""},
                                        {"c", "", {{2.01, 0, 0}, 0}, ""},
                                        {"d", "", {{0, 1, 0}, 0}, ""}};
  const auto found = Sightings(objects, "", {}, {2, M_PI / 2});
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].object.name, "b");
  EXPECT_EQ(found[1].object.name, "a");
}

}  // namespace musher::skills::sight_test
