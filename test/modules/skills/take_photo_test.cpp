#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "musher/test/modules/skills/fake_robot.hpp"

namespace musher::skills::take_photo_test {

using skill::Status;
using skill::Values;
using testing::Bench;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::Reply;

class TakePhotoSkill : public ::testing::Test {
 protected:
  TakePhotoSkill() { bench_.robot.camera_names = {"front", "down"}; }
  const skill::Feedback& Take(const Values& more = {}) {
    Values parameters{{"save_path", "a.png"}};
    for (const auto& named : more) parameters.Set(named.name, named.value);
    return bench_.Execute("take_photo", parameters);
  }
  Bench bench_{"cf2x_0", "cf2x"};
};

TEST_F(TakePhotoSkill, SavesThePictureOfTheFirstCamera) {
  const skill::Feedback& end = Take();
  EXPECT_EQ(end.status, Status::kCompleted);
  EXPECT_EQ(end.message, "Photo saved to a.png");
  EXPECT_EQ(bench_.robot.files.at("a.png").bgr, bench_.robot.picture.bgr);
  EXPECT_EQ(end.details.Text("path"), "a.png");
  EXPECT_EQ(end.details.Get<std::int64_t>("width", 0), 2);
  EXPECT_EQ(end.details.Get<std::int64_t>("height", 0), 1);
  EXPECT_THAT(bench_.messages, ElementsAre("20 Preparing camera", "40 Taking the picture",
                                           "80 Saving the picture", "100 Photo saved to a.png"));
}

TEST_F(TakePhotoSkill, TakesTheNamedCamera) {
  EXPECT_EQ(Take({{"camera_type", "down"}}).status, Status::kCompleted);
  EXPECT_EQ(Take({{"camera_type", "default"}}).status, Status::kCompleted);
}

TEST_F(TakePhotoSkill, TakesTheParametersOfOlderClients) {
  EXPECT_EQ(
      bench_.Execute("take_photo", {{"camera_name", "down"}, {"save_to_file", "b.png"}}).message,
      "Photo saved to b.png");
  EXPECT_EQ(bench_.run().parameters().Text("camera_type"), "down");
}

TEST_F(TakePhotoSkill, NamesTheCamerasWhenOneIsUnknown) {
  EXPECT_EQ(Take({{"camera_type", "rear"}}).message,
            "Camera 'rear' not available; there are front and down");
  bench_.robot.camera_names = {"front"};
  EXPECT_EQ(Take({{"camera_type", "rear"}}).message, "Camera 'rear' not available; there is front");
  bench_.robot.camera_names = {};
  EXPECT_EQ(Take().message, "Camera 'sensor.camera.rgb' not available; cf2x_0 has no camera");
  EXPECT_EQ(bench_.robot.pictures_taken, 0);
}

TEST_F(TakePhotoSkill, NeedsAPathThatEndsInPng) {
  EXPECT_EQ(Take({{"save_path", "a.jpg"}}).message,
            "Invalid save_path 'a.jpg': expected a file that ends in .png");
  EXPECT_EQ(Take({{"save_path", ".png"}}).status, Status::kFailed);
  EXPECT_EQ(Take({{"save_path", "A.PNG"}}).status, Status::kCompleted);
}

// "P6\n2 1\n255\n" and the pixels, red first.
TEST_F(TakePhotoSkill, KeepsThePictureInItsDataWithoutAPath) {
  const skill::Feedback& end = bench_.Execute("take_photo", {});
  EXPECT_EQ(end.status, Status::kCompleted);
  EXPECT_EQ(end.message, "Photo captured");
  EXPECT_THAT(bench_.robot.files, IsEmpty());
  EXPECT_EQ(end.details.Get<std::int64_t>("width", 0), 2);
  const auto saved = bench_.run().Save();
  ASSERT_TRUE(saved);
  EXPECT_EQ(saved.value().data.Text("photo_data"), "UDYKMiAxCjI1NQoDAgEGBQQ=");
}

TEST_F(TakePhotoSkill, WaitsUntilItsTargetIsInSightOrSaysWhyNot) {
  bench_.robot.seen = {{"car_1", "car", {{0, 5, 0}, 0}, ""}};  // to its left
  const skill::Feedback& missed = Take({{"target", "car"}});
  EXPECT_EQ(missed.status, Status::kFailed);
  EXPECT_EQ(missed.message,
            "Timeout: car is not in sight after 5 s: it is not ahead of the camera");
  EXPECT_EQ(bench_.robot.pictures_taken, 0);
  bench_.robot.seen = {{"car_1", "car", {{5, 1, 0}, 0}, ""}};
  EXPECT_EQ(Take({{"target", "/World/car_1"}}).message, "Photo saved to a.png");
  bench_.robot.has_objects = false;
  EXPECT_EQ(Take({{"target", "car"}}).message,
            "Timeout: car is not in sight after 5 s: no objects were received");
}

class AimedPhoto : public ::testing::Test {
 protected:
  explicit AimedPhoto(const char* name = "jetbot_0", const char* kind = "jetbot")
      : bench_(name, kind) {
    bench_.robot.camera_names = {"front"};
  }
  void Place(double x_m, double y_m) {
    bench_.robot.seen = {{"car_1", "car", {{x_m, y_m, 0}, 0}, ""}};
  }
  double OffRad() const {
    const auto& at = bench_.robot.seen.at(0).pose.at;
    const auto& own = bench_.robot.body;
    return navigation::Wrapped(std::atan2(at.y_m - own.at.y_m, at.x_m - own.at.x_m) - own.yaw_rad);
  }
  Bench bench_;
};

TEST_F(AimedPhoto, TurnsToItsTargetBeforeItIsTaken) {
  for (const auto& [x_m, y_m] : {std::pair(0.0, 5.0), {-3.0, 0.1}, {-3.0, -0.1}, {2.0, -1.0}}) {
    bench_.robot.body.yaw_rad = 0;
    bench_.robot.pictures_taken = 0;
    Place(x_m, y_m);
    bench_.Start("take_photo", {{"target", "car"}});
    while (bench_.run().running() && bench_.robot.pictures_taken == 0) bench_.Step();
    EXPECT_LE(std::abs(OffRad()), 0.12) << x_m << ", " << y_m;
    EXPECT_LT(std::abs(bench_.robot.motion.yaw_rad_s), 0.06)
        << "it stands, and the picture is sharp";
    EXPECT_EQ(bench_.RunOut().message, "Photo captured");
    EXPECT_EQ(bench_.robot.command, navigation::Velocity{});
    EXPECT_LT(std::hypot(bench_.robot.body.at.x_m, bench_.robot.body.at.y_m), 0.01);
  }
}

TEST_F(AimedPhoto, FollowsATargetThatMoves) {
  Place(0, 5);
  bench_.Start("take_photo", {{"target", "car"}});
  for (double x_m = 0; bench_.run().running() && bench_.seconds() < 60; x_m -= 0.02) {
    Place(x_m, 5);
    bench_.Step();
  }
  EXPECT_EQ(bench_.feedback().message, "Photo captured");
  EXPECT_LE(std::abs(OffRad()), 0.2);
}

TEST_F(AimedPhoto, IsRefusedWhenThePlaceOfTheTargetIsNotKnownOrIsLost) {
  EXPECT_EQ(bench_.Execute("take_photo", {{"target", "car"}}).message,
            "Timeout: car is not in sight after 5 s: the place of car is not known");
  Place(0, 5);
  bench_.robot.has_odometry = false;
  EXPECT_EQ(bench_.Execute("take_photo", {{"target", "car"}}).message,
            "Timeout: car is not in sight after 5 s: No odometry of jetbot_0");
  bench_.robot.has_odometry = true;
  Place(-5, 0.1);
  bench_.Start("take_photo", {{"target", "car"}});
  bench_.StepFor(1);
  EXPECT_EQ(bench_.run().Path(), "AIMING");
  bench_.robot.has_objects = false;  // what was seen is old
  bench_.StepFor(0.5);
  EXPECT_EQ(bench_.robot.command, navigation::Velocity{}) << "it does not turn on belief alone";
  EXPECT_EQ(bench_.RunOut().message, "It has not turned to car: no objects were received");
  EXPECT_EQ(bench_.robot.pictures_taken, 0);
}

TEST_F(AimedPhoto, TurnsOnlyAsItsGateLetsIt) {
  bench_.robot.held_by = "an obstacle 0.10 m away";
  Place(0, 5);
  EXPECT_EQ(bench_.Execute("take_photo", {{"target", "car"}}).message,
            "It has not turned to car: an obstacle 0.10 m away");
  Place(5, 1);
  EXPECT_EQ(bench_.Execute("take_photo", {{"target", "car"}}).message, "Photo captured")
      << "it is in the picture";
}

TEST_F(AimedPhoto, IsBoundedInTime) {
  Place(-5, 0.1);
  bench_.Start("take_photo", {{"target", "car"}});
  for (int i = 0; i < 300 && bench_.run().running(); ++i) {
    bench_.robot.body.yaw_rad = 0;  // the wheels slip
    bench_.Step();
  }
  EXPECT_EQ(bench_.feedback().message, "Timeout: it has not turned to car after 15 s");
  EXPECT_EQ(bench_.robot.command, navigation::Velocity{});
}

TEST_F(AimedPhoto, UsesTheBaseOnlyForATarget) {
  EXPECT_TRUE(bench_.manager().Make("take_photo").value()->table().parts() ==
              std::vector<std::string>{kCamera});
  bench_.Start("take_photo", {{"target", "car"}});
  EXPECT_THAT(bench_.run().parts(), ElementsAre(kCamera, kBase));
  ASSERT_TRUE(bench_.manager().CancelNow("take_photo", "").ok());
  bench_.Start("take_photo", {{"target", "car"}, {"turn", false}});
  EXPECT_THAT(bench_.run().parts(), ElementsAre(kCamera));
}

// Another skill may drive then.
TEST_F(AimedPhoto, DoesNotTouchTheBaseWithoutATurn) {
  for (const Values& parameters : {Values{}, Values{{"target", "car"}, {"turn", false}}}) {
    Place(5, 1);
    bench_.robot.SetVelocity({.x_m_s = 0.1});
    EXPECT_EQ(bench_.Execute("take_photo", parameters).message, "Photo captured");
    EXPECT_EQ(bench_.robot.command.x_m_s, 0.1);
  }
}

TEST_F(AimedPhoto, StandsInAPauseAndTurnsOnAfterIt) {
  Place(-5, 0.1);
  bench_.Start("take_photo", {{"target", "car"}});
  bench_.StepFor(1);
  ASSERT_TRUE(bench_.manager().Pause("take_photo", "by a request").ok());
  EXPECT_EQ(bench_.robot.command, navigation::Velocity{});
  bench_.StepFor(60);
  EXPECT_EQ(bench_.run().Path(), "AIMING");
  ASSERT_TRUE(bench_.manager().Resume("take_photo").ok());
  EXPECT_EQ(bench_.RunOut().message, "Photo captured");
}

class AimedPhotoOfAFlyer : public AimedPhoto {
 protected:
  AimedPhotoOfAFlyer() : AimedPhoto("cf2x_0", "cf2x") {}
};

TEST_F(AimedPhotoOfAFlyer, KeepsItsPlaceInWindWhileItTurns) {
  bench_.robot.body.at.z_m = 1.5;
  bench_.robot.wind = {.x_m_s = 0.1, .y_m_s = 0.1};
  Place(-5, 0.1);
  bench_.Start("take_photo", {{"target", "car"}});
  while (bench_.run().running() && bench_.robot.pictures_taken == 0) bench_.Step();
  EXPECT_LE(std::abs(OffRad()), 0.15);
  EXPECT_LT(std::hypot(bench_.robot.body.at.x_m, bench_.robot.body.at.y_m), 0.3);
  EXPECT_NEAR(bench_.robot.body.at.z_m, 1.5, 0.2);
}

TEST_F(AimedPhotoOfAFlyer, DoesNotTurnOnTheGround) {
  Place(0, 5);
  EXPECT_EQ(bench_.Execute("take_photo", {{"target", "car"}}).message,
            "Timeout: car is not in sight after 5 s: it is not ahead of the camera");
  EXPECT_EQ(bench_.robot.body.yaw_rad, 0);
}

TEST_F(TakePhotoSkill, RetriesAFailedCaptureTwice) {
  bench_.robot.camera_replies = Reply::kFails;
  EXPECT_EQ(Take().message, "gives up after 2 retries: Capture failed: the device has failed");
  EXPECT_EQ(bench_.robot.pictures_taken, 3);
  EXPECT_EQ(bench_.run().errors().size(), 4U);
  EXPECT_GT(bench_.seconds(), 1.0);  // not at once
}

TEST_F(TakePhotoSkill, SucceedsWhenTheSecondCaptureDoes) {
  bench_.robot.camera_replies = Reply::kAbandoned;
  bench_.Start("take_photo", {{"save_path", "a.png"}});
  bench_.StepFor(0.3);
  bench_.robot.camera_replies = Reply::kGiven;
  EXPECT_EQ(bench_.RunOut().status, Status::kCompleted);
  EXPECT_EQ(bench_.run().retries(), 1);
}

TEST_F(TakePhotoSkill, NeverSavesAPictureWithoutAllItsPixels) {
  for (const Picture& broken : {Picture{}, Picture{2, 2, {1, 2, 3}}, Picture{0, 4, {}},
                                Picture{0xffffffff, 0xffffffff, {1, 2, 3}}}) {
    bench_.robot.picture = broken;
    EXPECT_THAT(Take().message, ::testing::HasSubstr("Capture failed: a picture of"));
  }
  EXPECT_THAT(bench_.robot.files, IsEmpty());
}

TEST_F(TakePhotoSkill, FailsWithoutAPictureForFiveSeconds) {
  bench_.robot.camera_replies = Reply::kNever;
  EXPECT_EQ(Take().message, "Timeout: no picture of camera 'front' after 5 s");
  EXPECT_NEAR(bench_.seconds(), 5.2, 0.2);
}

TEST_F(TakePhotoSkill, FailsWhenTheFileIsNotWritten) {
  bench_.robot.file_replies = Reply::kFails;
  EXPECT_EQ(Take().message, "Save failed: the device has failed");
  bench_.robot.file_replies = Reply::kAbandoned;
  EXPECT_EQ(Take().message, "Save failed: the work was abandoned");
  bench_.robot.file_replies = Reply::kNever;
  EXPECT_EQ(Take().message, "Timeout: the file is not written after 10 s");
}

TEST_F(TakePhotoSkill, IsCancelledInEachState) {
  for (const char* state : {"INITIALIZING", "EXECUTING", "SAVING"}) {
    bench_.robot.camera_replies = std::string(state) == "EXECUTING" ? Reply::kNever : Reply::kGiven;
    bench_.robot.file_replies = Reply::kNever;
    bench_.Start("take_photo", {{"save_path", "a.png"}});
    if (std::string(state) != "INITIALIZING") bench_.StepFor(1);
    EXPECT_EQ(bench_.run().Path(), state);
    ASSERT_TRUE(bench_.manager().Cancel("take_photo", "").ok());
    bench_.Step();
    EXPECT_EQ(bench_.feedback().status, Status::kCancelled);
  }
}

// The time of a pause does not count, and the picture comes meanwhile.
TEST_F(TakePhotoSkill, GoesOnAfterAPauseInEachState) {
  for (int steps = 0; steps < 4; ++steps) {
    bench_.Start("take_photo", {{"save_path", "a.png"}});
    for (int i = 0; i < steps; ++i) bench_.Step();
    bench_.manager().Pause();
    for (int i = 0; i < 200; ++i) bench_.robot.Advance(Milliseconds(100));
    EXPECT_EQ(bench_.RunOut().status, Status::kCompleted) << steps;
  }
}

}  // namespace musher::skills::take_photo_test
