// Guests: their timetables, their paths, and where they look.

#include "musher/modules/world/simulation/guests.hpp"

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <cmath>

#include "musher/modules/world/sensors/gesture_sight.hpp"
#include "musher/test/modules/world/scenes.hpp"

namespace musher::world::guests_test {

using Eigen::Vector2d;
using LookAt = GuestLook::At;

GuestAct At(double seconds) {
  GuestAct act;
  act.at = Seconds(seconds);
  return act;
}
GuestAct WalkAt(double seconds, const Vector2d& to_m, LookAt look = LookAt::kRobot) {
  GuestAct act = At(seconds);
  act.walk_to_m = to_m;
  act.look = GuestLook{look};
  return act;
}
GuestAct SignAt(double seconds, Gesture gesture) {
  GuestAct act = At(seconds);
  act.gesture = gesture;
  return act;
}
GuestAct LeaveAt(double seconds) {
  GuestAct act = At(seconds);
  act.look = GuestLook{LookAt::kAhead};
  act.leave = true;
  return act;
}

// The robot stands in the middle and looks along x, with its eyes at 1.5 m.
Scene Hall(std::vector<GuestAct> acts) {
  Scene scene = EmptyYard();
  scene.humanoid.emplace();
  scene.body.stand_height_m = 0.9;
  CameraSpec& camera = scene.cameras.cameras[0];
  camera.on = CameraMount::kHead;
  camera.position_m = {0.1, 0, 0.6};
  GuestSpec guest;
  guest.from_m = {4, 3};
  guest.speed_m_s = 1;
  guest.acts = std::move(acts);
  scene.guests = {guest};
  return scene;
}

TEST(Guests, ComeAtTheirTimeWalkAtTheirSpeedAndLeaveAtTheirExit) {
  World world(Hall({WalkAt(1, {4, 1}), LeaveAt(5)}));
  const Guest& guest = world.guests()[0];
  Pass(world, Seconds(0.9));
  EXPECT_FALSE(guest.here);
  Pass(world, Seconds(1.1));  // a second on its way
  EXPECT_TRUE(guest.here);
  EXPECT_NEAR((guest.position_m - Vector2d(4, 2)).norm(), 0, 0.03);
  Pass(world, Seconds(2));
  EXPECT_EQ(guest.position_m, Vector2d(4, 1));
  Pass(world, Seconds(2));
  EXPECT_TRUE(guest.here);
  Pass(world, Seconds(1.1));
  EXPECT_FALSE(guest.here);
}

TEST(Guests, ThatHaveNoActsAreAlwaysThere) {
  World world(Hall({}));
  Pass(world, Seconds(1));
  EXPECT_TRUE(world.guests()[0].here);
  EXPECT_EQ(world.guests()[0].position_m, Vector2d(4, 3));
}

TEST(Guests, LookTheRobotInTheEyes) {
  World world(Hall({WalkAt(0, {1.5, 0})}));
  Pass(world, Seconds(10));
  const Guest& guest = world.guests()[0];
  EXPECT_TRUE(guest.looks_at_robot);
  EXPECT_NEAR(std::abs(guest.head_yaw_rad), M_PI, 1e-6);
  // The middle of its head is at 1.577 m, the camera at 1.5 m, 1.4 m away.
  EXPECT_NEAR(guest.head_pitch_rad, std::atan2(0.077, 1.4), 1e-3);
}

TEST(Guests, LookAwayFromTheRobotOrWhereTheyGo) {
  World away(Hall({WalkAt(0, {1.5, 0}, LookAt::kAway)}));
  Pass(away, Seconds(10));
  EXPECT_NEAR(away.guests()[0].head_yaw_rad, 0, 1e-6);
  EXPECT_FALSE(away.guests()[0].looks_at_robot);
  World passing(Hall({WalkAt(0, {4, -3}, LookAt::kAhead)}));
  Pass(passing, Seconds(3));
  EXPECT_NEAR(passing.guests()[0].head_yaw_rad, -M_PI / 2, 1e-6);
}

TEST(Guests, StepBackFromTheRobotWithoutTurningRound) {
  World world(Hall({WalkAt(0, {1, 0}), WalkAt(10, {2.5, 0})}));
  Pass(world, Seconds(10));
  for (int i = 0; i < 75; ++i) {
    world.Step();
    ASSERT_NEAR(std::abs(world.guests()[0].yaw_rad), M_PI, 0.01);
    ASSERT_TRUE(world.guests()[0].looks_at_robot);
  }
  EXPECT_NEAR(world.guests()[0].position_m.x(), 2.5, 0.05);
}

TEST(Guests, ComeAgainWhenTheSceneRepeats) {
  Scene scene = Hall({WalkAt(1, {4, 1}), LeaveAt(4)});
  scene.guests_repeat = Seconds(8);
  World world(scene);
  Pass(world, Seconds(2));
  const Guest first = world.guests()[0];
  EXPECT_TRUE(first.here);
  Pass(world, Seconds(5));
  EXPECT_FALSE(world.guests()[0].here);
  Pass(world, Seconds(3));
  EXPECT_EQ(world.guests()[0], first);
}

TEST(Guests, AreTheSameFromACopyAsTheWorldIs) {
  World world(Hall({WalkAt(0, {1.5, 0}), LeaveAt(5)}));
  Pass(world, Seconds(2));
  World copy = world;
  Pass(world, Seconds(3));
  Pass(copy, Seconds(3));
  EXPECT_EQ(world.guests(), copy.guests());
}

RC_GTEST_PROP(GuestsProperty, AreNeverInTheRobotsPlaceAndNeverJump, ()) {
  std::vector<GuestAct> acts;
  double at_s = 0;
  const auto ways = *rc::gen::container<std::vector<std::pair<int, int>>>(
      10, rc::gen::pair(rc::gen::inRange(-30, 30), rc::gen::inRange(-30, 30)));
  for (const auto& [x, y] : ways) {
    acts.push_back(WalkAt(at_s, {x / 10.0, y / 10.0}));
    at_s += *rc::gen::inRange(1, 6);
  }
  World world(Hall(acts));
  world.Step();
  for (int i = 0; i < at_s * 50; ++i) {
    const Guest before = world.guests()[0];
    world.Step();
    const Guest& now = world.guests()[0];
    const double least_m = world.scene().body.radius_m + kGuestRadiusM;
    RC_ASSERT(now.position_m.norm() >= least_m - 1e-9);
    RC_ASSERT((now.position_m - before.position_m).norm() <= 0.02 * 1.5);
    RC_ASSERT(std::abs(std::remainder(now.head_yaw_rad - before.head_yaw_rad, 2 * M_PI)) < 0.1);
  }
}

TEST(Guests, StepOutOfTheWayOfARobotThatIsPutDown) {
  World world(Hall({WalkAt(0, {1.5, 0})}));
  Pass(world, Seconds(8));
  ASSERT_EQ(world.PutDown({{1.4, 0}, 0}), std::nullopt);
  world.Step();
  EXPECT_NEAR(world.guests()[0].position_m.x(), 1.4 + 0.48, 1e-9);
}

TEST(GestureSight, IsOfAGuestInViewWhoGesturesAndLooksAtTheRobot) {
  World world(Hall({WalkAt(0, {1.5, 0}), SignAt(6, Gesture::kHeart), SignAt(8, Gesture::kNone)}));
  Pass(world, Seconds(5.9));
  EXPECT_EQ(SeenGesture(world), Gesture::kNone);
  Pass(world, Seconds(0.2));
  EXPECT_EQ(SeenGesture(world), Gesture::kHeart);
  Pass(world, Seconds(2));
  EXPECT_EQ(SeenGesture(world), Gesture::kNone);
}

TEST(GestureSight, IsNoneOfAGuestThatTheHeadIsTurnedFrom) {
  World world(Hall({WalkAt(0, {1.5, 0}), SignAt(5, Gesture::kV)}));
  Pass(world, Seconds(6));
  EXPECT_EQ(SeenGesture(world), Gesture::kV);
  ASSERT_EQ(world.LookAt({0, 0.5}), std::nullopt);
  Pass(world, Seconds(3));
  EXPECT_EQ(SeenGesture(world), Gesture::kNone);
  ASSERT_EQ(world.LookAt({0.5, 0.5}), std::nullopt);
  Pass(world, Seconds(5));
  EXPECT_EQ(SeenGesture(world), Gesture::kV);
}

TEST(GestureSight, IsNoneOfAGuestWhoLooksAwayIsHiddenOrTooFar) {
  World away(Hall({WalkAt(0, {1.5, 0}, LookAt::kAway), SignAt(5, Gesture::kV)}));
  Pass(away, Seconds(6));
  EXPECT_EQ(SeenGesture(away), Gesture::kNone);
  Scene walled = Hall({WalkAt(0, {1.5, 0}), SignAt(5, Gesture::kV)});
  walled.boxes = {{"screen", {1, 0}, {0.02, 0.5}, 0, 2}};
  World hidden(walled);
  Pass(hidden, Seconds(6));
  EXPECT_EQ(SeenGesture(hidden), Gesture::kNone);
  World far(Hall({WalkAt(0, {5.5, 0}), SignAt(5, Gesture::kV)}));
  Pass(far, Seconds(6));
  EXPECT_EQ(SeenGesture(far), Gesture::kNone);
}

TEST(GestureSight, IsNoneWhileTheCameraIsSilent) {
  World world(Hall({WalkAt(0, {1.5, 0}), SignAt(5, Gesture::kOk)}));
  Pass(world, Seconds(6));
  EXPECT_EQ(SeenGesture(world), Gesture::kOk);
  world.Silence("camera front");
  EXPECT_EQ(SeenGesture(world), Gesture::kNone);
}

TEST(GestureSight, IsOfTheNearestOfSeveral) {
  Scene scene = Hall({WalkAt(0, {2, 0.4}), SignAt(5, Gesture::kHeart)});
  scene.guests.push_back(scene.guests[0]);
  scene.guests[1].acts = {WalkAt(0, {1.5, -0.3}), SignAt(7, Gesture::kV)};
  World world(scene);
  Pass(world, Seconds(6));
  EXPECT_EQ(SeenGesture(world), Gesture::kHeart);
  Pass(world, Seconds(2));
  EXPECT_EQ(SeenGesture(world), Gesture::kV);
}

}  // namespace musher::world::guests_test
