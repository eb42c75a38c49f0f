// Movements: servo streams in steps, remainders, corrections, walks until a sight.

#include <gmock/gmock.h>

#include <cmath>
#include <utility>

#include "musher/base/files.hpp"
#include "musher/test/modules/race/race_rig.hpp"

namespace musher::race::walk_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr int kFramesOfAStep = 4;  // 200 ms at 20 Hz

TEST(Walk, OfTwelveStepsHas48FramesAndOneEnd) {
  Rig rig;
  rig.Command("START");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.ends == 1; }));
  EXPECT_THAT(rig.field.motions, ElementsAre(111));
  EXPECT_THAT(rig.field.frames_of_stream, ElementsAre(12 * kFramesOfAStep));
  const ServoFrame& frame = rig.field.frames.front();
  EXPECT_EQ(frame.motion_id, 303);
  EXPECT_EQ(frame.twist, (Twist{0.4, 0, 0}));
  EXPECT_THAT(frame.step_height_m, ElementsAre(0.05, 0.05));
  EXPECT_TRUE(rig.field.frames.back().end);
}

TEST(Walk, LastsAsLongAtAnUnevenPace) {
  Rig rig;
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.streaming; }));
  const Time begin = rig.now;
  const Index light = FindByName(rig.course_.detectors, "light").value();
  const std::vector<int> steps_ms = {50, 51, 90, 10};
  for (std::size_t i = 0; rig.field.ends == 0 && i < 1000; ++i) {
    rig.now += Milliseconds(steps_ms[i % steps_ms.size()]);
    rig.race->OnBody(0, 303, rig.now);
    rig.race->OnSighting(light, {false, kUnknown, "", ""}, rig.now, rig.now);
    rig.machine->RunOnce(rig.now);
  }
  EXPECT_GE(rig.now - begin, 23 * Milliseconds(200));
  EXPECT_LE(rig.now - begin, 23 * Milliseconds(200) + Milliseconds(90));
}

// A process that did not run for a moment has sent no frames, and the body has stood.
TEST(Walk, CountsNoStepsWhileNoFramesAreSent) {
  Course course = TheCourse();
  course.light.reset();
  Rig rig(course);
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.FramesOf({0.4, 0, 0}) == 20; }));
  rig.now += Milliseconds(3000);
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.ends == 1; }));
  EXPECT_GE(rig.FramesOf({0.4, 0, 0}), 23 * kFramesOfAStep - 5);
}

TEST(Walk, OfALyingRobotBeginsWhenItStands) {
  Rig rig;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(300));
  EXPECT_THAT(rig.field.motions, ElementsAre(111));
  EXPECT_FALSE(rig.field.streaming);
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.ends == 1; }));
  EXPECT_THAT(rig.field.frames_of_stream, ElementsAre(23 * kFramesOfAStep));
}

// The reply of the lie-down was lost, or came after its limit: the walk was refused.
TEST(Walk, AfterALieDownThatFailedBeginsWhenItStands) {
  Rig rig;
  rig.script.motion = [](std::int32_t motion) -> Result<> {
    return motion == 101 ? Result<>(Error{3028, "failed"}) : Ok();
  };
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.streaming; }));
  rig.Command("START:IN_A1");
  ASSERT_TRUE(rig.RunTo("ERROR"));
  rig.Run(std::chrono::seconds(20));
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.streaming; }));
  EXPECT_THAT(rig.field.motions, ElementsAre(111, 101, 101, 111));
}

TEST(Walk, OfL1IsSlowAndLow) {
  Rig rig;
  rig.Command("START:IN_L1");
  ASSERT_TRUE(rig.RunTo("L1_TO_QRB"));
  EXPECT_EQ(rig.field.frames_of_stream.front(), 10 * kFramesOfAStep);
  EXPECT_EQ(rig.field.frames.front().twist, (Twist{0.2, 0, 0}));
  EXPECT_THAT(rig.field.frames.front().step_height_m, ElementsAre(0.03, 0.03));
}

TEST(Walk, UntilTheBarrierIsAtTheTopStoresItsStepsForTheRemainder) {
  Rig rig;
  rig.script.sight = [&](const std::string& detector) -> Sighting {
    const bool top = rig.field.streaming && rig.field.frames_of_stream.back() >= 120;
    return {true, 1, detector == "barrier" && top ? "top" : "seen", ""};
  };
  rig.Command("SET_ARROW:left");
  rig.Command("START:S2_TO_L1");
  ASSERT_TRUE(rig.RunTo("IN_L1"));
  EXPECT_TRUE(rig.field.Logged("S2_TO_L1: barrier after 30 steps"));
  ASSERT_TRUE(rig.RunTo("L1_TO_QRB"));
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.streaming; }));
  const int before = rig.field.streams;
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.ends == before; }));
  // 85 - (30 + 5 of the special gait); 15 more follow.
  EXPECT_EQ(rig.field.frames_of_stream[before - 1], 50 * kFramesOfAStep);
}

TEST(Walk, UntilASightTakesItsPhaseInAnyCase) {
  Rig rig;
  rig.script.sight = [&](const std::string&) -> Sighting {
    return {true, 1, rig.FramesOf({0.4, 0, 0}) > 40 ? "Top" : "SEEN", ""};
  };
  rig.Command("START:S2_TO_L1");
  ASSERT_TRUE(rig.RunTo("IN_L1"));
  EXPECT_TRUE(rig.field.Logged("S2_TO_L1: barrier after 10 steps"));
}

TEST(Walk, UntilABarrierThatIsNotFoundEndsAfter85StepsAndSaysSo) {
  Rig rig;
  rig.Command("START:S2_TO_L1");
  ASSERT_TRUE(rig.RunTo("IN_L1"));
  EXPECT_TRUE(rig.field.Logged("no barrier within 85 steps; it continues"));
  EXPECT_EQ(rig.field.frames_of_stream.back(), 85 * kFramesOfAStep);
  // No step is left, which stalls nothing.
  ASSERT_TRUE(rig.RunTo("IN_QRB"));
  EXPECT_TRUE(rig.field.Logged("L1_TO_QRB: forward 85 - 85: no step is left"));
}

// 15 more steps, and those under the barrier, led 1.6 m beyond the lane.
TEST(Walk, AfterABarrierThatIsNotFoundIsNoLongerThanTheLane) {
  Rig rig;
  rig.Command("START:S2_TO_L1");
  ASSERT_TRUE(rig.RunTo("IN_QRB"));
  EXPECT_EQ(rig.FramesOf({0.4, 0, 0}), 100 * kFramesOfAStep);
  EXPECT_EQ(rig.FramesOf({0.2, 0, 0}), 0) << "no barrier, under which it would crouch";
  EXPECT_TRUE(rig.field.Logged("IN_L1: special_gait is left out: no barrier was found"));
}

TEST(Walk, AfterAMarkerThatIsNotFoundIsNoLongerThanTheLane) {
  Rig rig;
  rig.Command("START:S2_TO_R1");
  ASSERT_TRUE(rig.RunTo("IN_QRB"));
  EXPECT_EQ(rig.FramesOf({0.4, 0, 0}), 100 * kFramesOfAStep);
}

TEST(Walk, BackWithoutItsSightIsNoLongerThanItsWay) {
  for (const char* from : {"B1_TO_L1", "B1_TO_R1", "B2_TO_L1", "B2_TO_R1"}) {
    Rig rig;
    rig.Command("START:" + std::string(from));
    ASSERT_TRUE(rig.RunTo("IN_S2_R")) << from;
    EXPECT_EQ(rig.FramesOf({0.4, 0, 0}), 107 * kFramesOfAStep) << from;
  }
}

TEST(Walk, AfterABarrierThatIsFoundLateHasTheRestOfTheLane) {
  for (const int found_after : {70, 79, 83}) {
    Rig rig;
    rig.script.sight = [&](const std::string& detector) -> Sighting {
      const bool top = rig.field.streaming && rig.state() == "S2_TO_L1" &&
                       rig.FramesOf({0.4, 0, 0}) >= found_after * kFramesOfAStep;
      return {true, 1, detector == "barrier" && top ? "top" : "seen", ""};
    };
    rig.Command("START:S2_TO_L1");
    ASSERT_TRUE(rig.RunTo("IN_QRB"));
    EXPECT_EQ(rig.FramesOf({0.2, 0, 0}), 10 * kFramesOfAStep);
    const double steps = rig.FramesOf({0.4, 0, 0}) / double(kFramesOfAStep);
    EXPECT_NEAR(steps, 95, 1) << "5 are those under the barrier";
  }
}

TEST(Walk, KeepsInTheMiddleOfALaneWhileItIsSeen) {
  Lines seen{2, LineWord::kCenter, LineWord::kCenter, 0.05};
  Rig rig;
  rig.script.lines = [&seen](const std::string&) { return seen; };
  rig.Command("START:S2_TO_L1");
  const auto turn = [&rig] { return rig.field.frames.back().twist.yaw_rad_s; };
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.streaming && turn() != 0; }));
  EXPECT_DOUBLE_EQ(turn(), -0.1);  // the middle is to the right
  EXPECT_EQ(rig.field.frames.back().twist.forward_m_s, 0.4);
  seen.middle_offset = -0.4;
  rig.Run(Milliseconds(500));
  EXPECT_DOUBLE_EQ(turn(), 0.3);  // at most
  seen.contours = 1;              // by the camera's mount
  seen.middle_offset = 0.05;
  rig.Run(Milliseconds(500));
  EXPECT_DOUBLE_EQ(turn(), -0.1);
}

TEST(Walk, GoesStraightOnByOneLineOfACameraWithoutAMount) {
  Course course = TheCourse();
  course.keeps.front().one_line = false;
  Rig rig(course);
  rig.script.lines = [](const std::string&) {
    return Lines{1, LineWord::kCenter, LineWord::kCenter, 0.4};
  };
  rig.Command("START:S2_TO_L1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.FramesOf({0.4, 0, 0}) > 0; }));
  rig.Run(Milliseconds(4000));
  EXPECT_TRUE(rig.field.streaming) << "one line is no reason to stand";
  EXPECT_EQ(rig.field.frames.back().twist.yaw_rad_s, 0);
}

// It walked on by 85 steps, straight ahead and without a word.
TEST(Walk, InALaneThatIsNotSeenStopsAndIsAFault) {
  Lines seen{2, LineWord::kCenter, LineWord::kCenter, 0};
  Rig rig;
  rig.script.lines = [&seen](const std::string&) { return seen; };
  rig.Command("START:S2_TO_L1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.FramesOf({0.4, 0, 0}) > 0; }));
  seen.doubt = "the floor has the colour of the lines";
  rig.Run(Milliseconds(1500));
  EXPECT_TRUE(rig.field.streaming);
  rig.Run(Milliseconds(1200));
  EXPECT_FALSE(rig.field.streaming);
  EXPECT_EQ(rig.state(), "S2_TO_L1");
  ASSERT_TRUE(rig.RunTo("ERROR", Milliseconds(3000)));
  EXPECT_THAT(rig.race->InfoText(), HasSubstr("the floor has the colour of the lines"));
}

TEST(Walk, InALaneThatIsSeenAgainGoesOn) {
  Lines seen{2, LineWord::kCenter, LineWord::kCenter, 0};
  Rig rig;
  rig.script.lines = [&seen](const std::string&) { return seen; };
  rig.Command("START:S2_TO_L1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.FramesOf({0.4, 0, 0}) > 0; }));
  for (int times = 0; times < 2; ++times) {
    seen.contours = 0;
    rig.Run(Milliseconds(4000));
    EXPECT_FALSE(rig.field.streaming);
    seen.contours = 2;
    rig.Run(Milliseconds(500));
    EXPECT_TRUE(rig.field.streaming);
  }
  EXPECT_EQ(rig.state(), "S2_TO_L1");
}

TEST(Walk, UntilAMarkerIgnoresAPictureThatWasTakenBefore) {
  Rig rig;
  rig.script.silent = {"marker"};
  rig.Command("START:B2_TO_R1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.Wants("marker"); }));
  const Index marker = FindByName(rig.course_.detectors, "marker").value();
  rig.race->OnSighting(marker, {false, 0, "disappeared", ""}, rig.now - std::chrono::seconds(9),
                       rig.now);
  rig.Tick(2);
  EXPECT_EQ(rig.state(), "B2_TO_R1");
  rig.race->OnSighting(marker, {true, 1, "tracking", ""}, rig.now, rig.now);
  rig.Tick(2);
  rig.race->OnSighting(marker, {false, 0, "disappeared", ""}, rig.now, rig.now);
  ASSERT_TRUE(rig.RunTo("IN_R1", Milliseconds(2000)));
}

// A viewer has kept the detector open since the marker of the run before: the walk ended at once.
TEST(Walk, UntilAMarkerIgnoresOneThatDisappearedBefore) {
  std::string phase = "disappeared";
  Rig rig;
  rig.script.sight = [&phase](const std::string& detector) -> Sighting {
    return {false, kUnknown, detector == "marker" ? phase : "", ""};
  };
  rig.Command("START:B2_TO_R1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.FramesOf({0.4, 0, 0}) > 10 * kFramesOfAStep; }));
  EXPECT_EQ(rig.state(), "B2_TO_R1");
  phase = "tracking";
  rig.Run(Milliseconds(1000));
  EXPECT_EQ(rig.state(), "B2_TO_R1");
  phase = "disappeared";
  ASSERT_TRUE(rig.RunTo("IN_R1", Milliseconds(1000)));
}

TEST(Walk, UntilASightStandsWithoutAFreshPicture) {
  Rig rig;
  rig.Command("START:S2_TO_L1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.FramesOf({0.4, 0, 0}) > 20; }));
  rig.script.silent = {"barrier"};
  rig.Run(Milliseconds(1300));
  EXPECT_FALSE(rig.field.streaming) << "it walks on without looking for the barrier";
  rig.script.silent.clear();
  rig.Run(Milliseconds(500));
  EXPECT_TRUE(rig.field.streaming);
  rig.script.silent = {"barrier"};
  EXPECT_TRUE(rig.RunTo("ERROR", std::chrono::seconds(11)));
}

TEST(Walk, UntilASightThatIsHiddenWaitsForItAndGoesOn) {
  Rig rig;
  rig.script.sight = [&](const std::string& detector) -> Sighting {
    const bool hidden = detector == "marker" && rig.FramesOf({0.4, 0, 0}) > 40;
    return {false, kUnknown, hidden ? "hidden" : "", ""};
  };
  rig.Command("START:S2_TO_R1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.FramesOf({0.4, 0, 0}) > 40; }));
  rig.Run(Milliseconds(500));
  const int frames = rig.FramesOf({0.4, 0, 0});
  EXPECT_FALSE(rig.field.streaming);
  rig.Run(Milliseconds(8500));
  EXPECT_EQ(rig.FramesOf({0.4, 0, 0}), frames);
  rig.Run(Milliseconds(2000));
  EXPECT_TRUE(rig.field.streaming);
  EXPECT_TRUE(rig.field.Logged("marker has been hidden for 10000 ms"));
  EXPECT_TRUE(rig.RunTo("IN_R1"));
}

// It walked up to 10 s before its detector had started.
TEST(Walk, UntilASightStandsUntilItsDetectorHasStarted) {
  Rig rig;
  rig.script.silent = {"barrier"};
  rig.Command("START:S2_TO_L1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.Wants("barrier"); }));
  rig.Run(Milliseconds(6000));
  EXPECT_EQ(rig.FramesOf({0.4, 0, 0}), 0);
  rig.script.silent.clear();
  rig.Run(Milliseconds(500));
  EXPECT_TRUE(rig.field.streaming);
}

TEST(Walk, UntilASightWhoseDetectorDoesNotStartIsAFault) {
  Rig rig;
  rig.script.silent = {"barrier"};
  rig.Command("START:S2_TO_L1");
  ASSERT_TRUE(rig.RunTo("ERROR", std::chrono::seconds(30)));
  EXPECT_THAT(rig.race->InfoText(), HasSubstr("no sample of the detector barrier"));
  EXPECT_EQ(rig.FramesOf({0.4, 0, 0}), 0);
}

TEST(Walk, UntilASightThatIsHiddenOnceMoreWaitsOnceMore) {
  Rig rig;
  bool hidden = false;
  rig.script.sight = [&](const std::string& detector) -> Sighting {
    return {false, kUnknown, hidden && detector == "marker" ? "hidden" : "", ""};
  };
  rig.Command("START:S2_TO_R1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.FramesOf({0.4, 0, 0}) > 40; }));
  for (int times = 0; times < 2; ++times) {
    hidden = true;
    rig.Run(Milliseconds(9000));
    EXPECT_FALSE(rig.field.streaming) << times;
    rig.Run(Milliseconds(2000));
    EXPECT_TRUE(rig.field.streaming) << times;
    hidden = false;
    rig.Run(Milliseconds(1000));
    EXPECT_TRUE(rig.field.streaming) << times;
  }
}

TEST(Walk, AheadIsShorterByTheStepsOfTheRetriesAtTheBoard) {
  Rig rig;
  rig.Command("START:IN_QR_A");
  rig.Run(std::chrono::seconds(46));  // two limits of 20 s, with a retry after each
  rig.script.sight = [](const std::string&) { return Text("A-1"); };
  ASSERT_TRUE(rig.RunTo("QRA_TO_A1"));
  EXPECT_TRUE(rig.field.Logged("no qr_a within 20000 ms, retry 2 of 5"));
  EXPECT_THAT(rig.field.frames_of_stream, ElementsAre(2 * kFramesOfAStep, 2 * kFramesOfAStep));
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.ends == 3; }));
  EXPECT_EQ(rig.field.frames_of_stream.back(), (23 - 4) * kFramesOfAStep);
}

// A course's state of one walk ahead and one check.
class Checked : public Rig {
 public:
  Checked(const char* state, const char* detector, LineWord word, bool dy = false) {
    script.lines = [this, detector = std::string(detector), word, dy](const std::string& seen) {
      if (seen != detector || corrected >= wrong)
        return Lines{2, LineWord::kCenter, LineWord::kCenter};
      return dy ? Lines{1, LineWord::kCenter, word} : Lines{2, word, LineWord::kCenter};
    };
    Command("START:" + std::string(state));
  }
  // The frames of the walk after the first one that the check makes.
  Twist Correction() {
    EXPECT_TRUE(RunUntil([&] { return field.Logged("correction 1"); }));
    EXPECT_TRUE(RunUntil([&] { return field.streaming; }));
    return field.frames.back().twist;
  }
  int wrong = 1;
  int corrected = 0;
};

TEST(Check, CorrectsByTheMovementBefore) {
  const Twist forward{0.4, 0, 0};
  const Twist backward{-0.3, 0, 0};
  const Twist left{0, 0.3, 0};
  const Twist right{0, -0.3, 0};
  const Twist turn_left{0, 0, 0.45};
  const Twist turn_right{0, 0, -0.45};
  const auto correction = [](const char* state, const char* detector, LineWord word,
                             bool dy = false) {
    return Checked(state, detector, word, dy).Correction();
  };
  using W = LineWord;
  EXPECT_EQ(correction("QRA_TO_A1", "right_lane", W::kLeft), backward);
  EXPECT_EQ(correction("QRA_TO_A1", "right_lane", W::kRight), forward);
  EXPECT_EQ(correction("QRA_TO_A2", "left_lane", W::kLeft), forward);
  EXPECT_EQ(correction("QRA_TO_A2", "left_lane", W::kRight), backward);
  EXPECT_EQ(correction("QRB_TO_B1", "front_lane", W::kLeft), right);
  EXPECT_EQ(correction("QRB_TO_B1", "front_lane", W::kRight), left);
  EXPECT_EQ(correction("B1_TO_L1", "front_lane", W::kLeft), turn_right);
  EXPECT_EQ(correction("B1_TO_L1", "front_lane", W::kRight), turn_left);
  EXPECT_EQ(correction("A1_TO_S1", "front_lane", W::kLeft), turn_right);
  EXPECT_EQ(correction("QRA_TO_A1", "front_bay_a", W::kFront, true), forward);
  EXPECT_EQ(correction("QRA_TO_A1", "front_bay_a", W::kBack, true), backward);
  EXPECT_EQ(correction("QRA_TO_A1", "right_edge", W::kFront, true), right);
  EXPECT_EQ(correction("QRA_TO_A1", "right_edge", W::kBack, true), left);
  EXPECT_EQ(correction("QRA_TO_A2", "left_edge", W::kFront, true), left);
  EXPECT_EQ(correction("QRA_TO_A2", "left_edge", W::kBack, true), right);
}

TEST(Check, TurnsTowardsTheBoardWhoseBoxIsBesideTheMiddle) {
  for (const double offset : {0.2, -0.2}) {
    Rig rig;
    rig.script.sight = [offset](const std::string& detector) {
      return Sighting{detector == "qr", std::nan(""), "", "A-1", offset};
    };
    rig.Command("START:S1_TO_A1");
    ASSERT_TRUE(rig.RunUntil([&] { return rig.field.Logged("check board: "); }));
    ASSERT_TRUE(rig.RunUntil([&] { return rig.field.streaming; }));
    EXPECT_EQ(rig.field.frames.back().twist, (Twist{0, 0, offset > 0 ? -0.45 : 0.45}));
  }
}

TEST(Check, CorrectsThreeTimesAtMostAndThenContinues) {
  Rig rig;
  rig.script.lines = [](const std::string& detector) {
    return Lines{2, detector == "right_lane" ? LineWord::kLeft : LineWord::kCenter,
                 LineWord::kCenter};
  };
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunTo("IN_A1"));
  EXPECT_TRUE(rig.field.Logged("check right_ycy: left after 3 corrections; it continues"));
  EXPECT_FALSE(rig.field.Logged("correction 4"));
  EXPECT_EQ(rig.field.streams, 3 + 3);
}

TEST(Check, NeedsAPictureThatIsHalfASecondNewerThanTheMovement) {
  Rig rig;
  rig.script.silent = {"right_lane"};
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.ends == 1; }));
  const Time end = rig.now;
  const Index lines = FindByName(rig.course_.detectors, "right_lane").value();
  rig.Run(Milliseconds(1000));
  rig.race->OnLines(lines, 2, "left", "center", 0.1, end + Milliseconds(499), rig.now);
  rig.Tick();
  EXPECT_FALSE(rig.field.Logged("correction"));
  rig.race->OnLines(lines, 2, "left", "center", 0.1, end + Milliseconds(500), rig.now);
  rig.Tick();
  rig.race->OnLines(lines, 2, "left", "center", 0.1, end + Milliseconds(600), rig.now);
  rig.Tick();
  EXPECT_TRUE(rig.field.Logged("QRA_TO_A1: check right_ycy: left, correction 1: backward 2"));
}

TEST(Check, NeedsAWordInTwoPictures) {
  Rig rig;
  int pictures = 0;
  rig.script.lines = [&](const std::string& detector) {
    if (detector != "right_lane") return Lines{2, LineWord::kCenter, LineWord::kCenter};
    const bool odd = ++pictures % 2 == 0;
    return Lines{2, odd ? LineWord::kLeft : LineWord::kRight, LineWord::kCenter};
  };
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunTo("IN_A1"));
  EXPECT_FALSE(rig.field.Logged("correction 1"));
  EXPECT_TRUE(rig.field.Logged("check right_ycy: no picture of it within 3000 ms"));
}

// One clear picture of many in doubt is chance.
TEST(Check, NeedsHalfOfThePicturesWithoutDoubt) {
  Rig rig;
  int pictures = 0;
  rig.script.lines = [&](const std::string& detector) {
    if (detector != "right_lane") return Lines{2, LineWord::kCenter, LineWord::kCenter};
    Lines lines{2, LineWord::kLeft, LineWord::kCenter};
    if (++pictures % 4 != 0) lines.doubt = "the floor has the colour of the lines";
    return lines;
  };
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunTo("IN_A1"));
  EXPECT_FALSE(rig.field.Logged("correction 1"));
}

TEST(Check, ContinuesWithoutALineAfterItsLimitAndSaysSo) {
  Rig rig;
  rig.script.lines = [](const std::string&) {
    return Lines{0, LineWord::kCenter, LineWord::kCenter};
  };
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.ends == 1; }));
  const Time end = rig.now;
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.streams == 2; }));
  EXPECT_GE(rig.now - end, Milliseconds(3500));
  EXPECT_LE(rig.now - end, Milliseconds(3700));
  EXPECT_TRUE(rig.field.Logged("check right_ycy: no picture of it within 3000 ms"));
}

// It went on after 3.5 s with a reservation, past a camera that was lost.
TEST(Check, WithoutAnySampleWaitsUntilThatIsAFault) {
  Rig rig;
  rig.script.silent = {"right_lane"};
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.ends == 1; }));
  ASSERT_TRUE(rig.RunTo("ERROR", std::chrono::seconds(11)));
  EXPECT_EQ(rig.field.streams, 1);
  EXPECT_THAT(rig.race->InfoText(), HasSubstr("no sample of the detector right_lane"));
}

TEST(Check, WhoseSamplesAreAllOfBeforeItsMovementIsAFault) {
  Rig rig;
  rig.script.silent = {"right_lane"};
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.ends == 1; }));
  const Index lines = FindByName(rig.course_.detectors, "right_lane").value();
  for (Time taken = rig.now - std::chrono::seconds(5); rig.state() != "ERROR";) {
    ASSERT_LT(taken, rig.now + std::chrono::seconds(5)) << "it waits without end";
    rig.race->OnLines(lines, 2, "center", "center", 0, taken, rig.now);
    taken += Milliseconds(25);
    rig.Tick();
  }
  EXPECT_THAT(rig.race->InfoText(),
              HasSubstr("all pictures for the detector right_lane are older than the movement"));
  EXPECT_EQ(rig.field.streams, 1);
}

TEST(Check, TakesAWordInAnyCase) {
  Rig rig;
  rig.script.silent = {"right_lane"};
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.ends == 1; }));
  const Index lines = FindByName(rig.course_.detectors, "right_lane").value();
  for (int i = 0; i < 20; ++i) {
    rig.race->OnLines(lines, 2, "Left", "CENTER", 0.1, rig.now, rig.now);
    rig.Tick(2);
  }
  EXPECT_TRUE(rig.field.Logged("check right_ycy: left, correction 1"));
}

// Course.toml with these lines behind [checks] and behind [check.right_ycy].
Course WithChecks(const std::string& rules, const std::string& right_ycy) {
  std::string text = ReadFile(CourseFile());
  const auto add = [&text](std::string_view header, const std::string& lines) {
    const std::size_t at = text.find(header);
    EXPECT_NE(at, std::string::npos) << header;
    text.insert(at + header.size(), lines);
  };
  add("\n[checks]\n", rules);
  add("\n[check.right_ycy]\n", right_ycy);
  const CourseReading reading = ReadCourseText(text, CourseFile());
  for (const Diagnostic& found : reading.diagnostics) ADD_FAILURE() << FormatDiagnostic(found);
  return reading.course.value_or(Course{});
}

constexpr const char* kStepsBack =
    "step_back = { away = { move = \"backward\", count = 4 }, "
    "back = { move = \"forward\", count = 3 } }\n";

// Of QRA_TO_A1, whose check right_ycy corrects ahead and back, and right_dy aside.
struct SteppingBack : Rig {
  explicit SteppingBack(std::string_view unseen) : Rig(WithChecks(kStepsBack, "")) {
    script.lines = [this, unseen](const std::string& detector) {
      const bool sees = detector != unseen || sees_when(detector);
      return Lines{sees ? 2U : 0U, LineWord::kCenter, LineWord::kCenter};
    };
  }
  int StepsBack() const { return FramesOf({-0.3, 0, 0}) / 4; }
  int StepsAhead() const { return FramesOf({0.4, 0, 0}) / 4; }
  std::function<bool(const std::string&)> sees_when = [](const std::string&) { return false; };
};

TEST(CheckThatStepsBack, LooksFromBehindOnceAndGoesOnAtItsPlace) {
  SteppingBack rig("right_edge");
  rig.sees_when = [&](const std::string&) { return rig.StepsBack() >= 4; };
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunTo("IN_A1"));
  EXPECT_TRUE(rig.field.Logged("check right_dy: no picture of it within 3000 ms; it steps back"));
  EXPECT_EQ(rig.StepsBack(), 4 + 9);
  EXPECT_EQ(rig.StepsAhead(), 23 + 3);
  EXPECT_EQ(rig.race->memory().given_up(), 0);
}

TEST(CheckThatStepsBack, NeedsNoWayBackWhereItCorrectsThatWay) {
  SteppingBack rig("right_lane");
  rig.sees_when = [&](const std::string&) { return rig.StepsBack() >= 4; };
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunTo("IN_A1"));
  EXPECT_EQ(rig.StepsBack(), 4 + 9);
  EXPECT_EQ(rig.StepsAhead(), 23);
}

TEST(CheckThatStepsBack, IsGivenUpAtItsPlaceWhereThatDoesNotHelp) {
  SteppingBack rig("right_lane");
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunTo("IN_A1"));
  EXPECT_EQ(rig.StepsBack(), 4 + 9) << "once";
  EXPECT_EQ(rig.StepsAhead(), 23 + 3);
  EXPECT_TRUE(rig.field.Logged("check right_ycy: no picture of it within 3000 ms; it continues"));
  EXPECT_EQ(rig.race->memory().given_up(), 1);
}

TEST(CheckThatStepsBack, DoesNotWhereItIsRequired) {
  SteppingBack rig("front_start");
  rig.Command("START");
  ASSERT_TRUE(rig.RunTo("ERROR"));
  EXPECT_EQ(rig.StepsBack(), 0);
}

// What is seen on the left of the robot and on its right is the same lane.
struct TwoCameras : Rig {
  TwoCameras(LineWord right, LineWord left) : Rig(WithChecks("", "agrees_with = \"left_ycy\"\n")) {
    script.lines = [this, right, left](const std::string& detector) {
      const bool corrected = FramesOf({-0.3, 0, 0}) > 0 || FramesOf({0.4, 0, 0}) > 23 * 4;
      const LineWord word = corrected                  ? LineWord::kCenter
                            : detector == "right_lane" ? right
                            : detector == "left_lane"  ? left
                                                       : LineWord::kCenter;
      return Lines{2, word, LineWord::kCenter};
    };
    Command("START:QRA_TO_A1");
    EXPECT_TRUE(RunTo("IN_A1"));
  }
};

TEST(CheckOfTwoCameras, CorrectsWhereTheyAgreeOrOneHasNothingToCorrect) {
  using W = LineWord;
  EXPECT_TRUE(TwoCameras(W::kLeft, W::kRight).field.Logged("correction 1: backward 2"));
  EXPECT_TRUE(TwoCameras(W::kRight, W::kLeft).field.Logged("correction 1: forward 2"));
  EXPECT_TRUE(TwoCameras(W::kLeft, W::kCenter).field.Logged("correction 1: backward 2"));
}

TEST(CheckOfTwoCameras, IsInDoubtWhereTheyContradictEachOther) {
  const TwoCameras rig(LineWord::kLeft, LineWord::kLeft);
  EXPECT_FALSE(rig.field.Logged("check right_ycy: left, correction"));
  EXPECT_TRUE(rig.field.Logged(
      "check right_ycy: no picture of it within 3000 ms: two cameras do not agree: left by "
      "right_lane, left by left_lane; it continues"));
}

TEST(Check, OpensItsDetectorShortlyBeforeTheMovementEndsAndClosesItAfterwards) {
  Rig rig;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(1000));
  EXPECT_FALSE(rig.Wants("right_lane"));
  rig.Run(Milliseconds(2500));
  EXPECT_TRUE(rig.Wants("right_lane"));
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.streams == 2; }));
  rig.Run(Milliseconds(500));
  EXPECT_FALSE(rig.Wants("right_lane"));
  EXPECT_FALSE(rig.Wants("qr"));
}

TEST(Wait, TakesTheDefaultAfterAllRetries) {
  Rig rig;
  rig.Command("START:IN_QR_A");
  ASSERT_TRUE(rig.RunTo("QRA_TO_A1"));
  EXPECT_TRUE(rig.field.Logged("no qr_a within 20000 ms: its default A-1"));
  EXPECT_EQ(rig.field.streams, 5);
  EXPECT_THAT(rig.race->InfoText(), HasSubstr("QRResult:A-1,TaskCompleted:False,Default:qr_a"));
  // It spoke of the bay as if it had read it.
  EXPECT_THAT(rig.field.spoken, ElementsAre("没有读到标牌,默认A区库位1"));
}

TEST(Wait, WhoseWordIsReadOrSetAfterADefaultIsNoDefaultAnyMore) {
  Rig rig;
  rig.Command("START:IN_QR_A");
  ASSERT_TRUE(rig.RunTo("QRA_TO_A1"));
  rig.Command("SET_QR_A:A-2");
  EXPECT_THAT(rig.race->InfoText(), ::testing::Not(HasSubstr("Default")));
}

TEST(Wait, TakesTheDefaultsOfBayAndArrow) {
  Rig rig;
  rig.Command("START:IN_QRB");
  ASSERT_TRUE(rig.RunTo("QRB_TO_B1", std::chrono::seconds(65)));
  rig.Command("START:IN_S2");
  ASSERT_TRUE(rig.RunTo("S2_TO_R1", std::chrono::seconds(20)));
}

// A reflection that was read once decided the way.
TEST(Wait, SaysTheConfidenceOfItsWordAndRecordsIt) {
  for (const double confidence : {0.9375, 0.0, 7.0}) {
    Rig rig;
    rig.script.sight = [&](const std::string&) {
      return Sighting{true, kUnknown, "", "A-1", 0, confidence};
    };
    rig.Command("START:IN_QR_A");
    ASSERT_TRUE(rig.RunTo("QRA_TO_A1"));
    const bool is_known = confidence > 0 && confidence <= 1;
    EXPECT_EQ(rig.field.Logged("qr_a is A-1 (confidence 0.94)"), is_known);
    EXPECT_EQ(rig.field.Logged("without its confidence of 7; expected 0 to 1"), confidence > 1);
    EXPECT_THAT(rig.recording, HasSubstr(is_known ? "A-1 0 0.9375" : "A-1 0 0\""));
  }
}

TEST(Wait, NeedsAWordInTwoPictures) {
  Rig rig;
  rig.script.silent = {"qr"};
  rig.Command("START:IN_QR_A");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.Wants("qr"); }));
  const Index qr = FindByName(rig.course_.detectors, "qr").value();
  rig.Tick(2);
  rig.race->OnSighting(qr, Text("A-1"), rig.now, rig.now);
  const Time taken = rig.now;
  rig.Tick(2);
  rig.race->OnSighting(qr, Text("A-1"), taken, rig.now);  // the same picture
  rig.Tick(2);
  rig.race->OnSighting(qr, Text("A-2"), rig.now, rig.now);
  rig.Run(Milliseconds(500));
  EXPECT_EQ(rig.race->memory().Text(0), "None");
  rig.race->OnSighting(qr, Text("A-2"), rig.now, rig.now);
  EXPECT_TRUE(rig.RunTo("QRA_TO_A2", Milliseconds(1000)));
}

TEST(Wait, TakesAWordInAnyCase) {
  Rig rig;
  rig.script.sight = [](const std::string&) { return Text("a-2"); };
  rig.Command("START:IN_QR_A");
  ASSERT_TRUE(rig.RunTo("QRA_TO_A2", Milliseconds(3000)));
}

TEST(Wait, IgnoresATextThatIsNoneOfItsValues) {
  Rig rig;
  rig.script.sight = [](const std::string&) { return Text("B-2"); };
  rig.Command("START:IN_QR_A");
  rig.Run(std::chrono::seconds(10));
  EXPECT_EQ(rig.state(), "IN_QR_A");
}

TEST(Lane, EndsWithStopAtTheEndOfItsCourse) {
  Rig rig;
  rig.Command("START:S1_TO_S2");
  ASSERT_TRUE(rig.RunTo("IN_S2"));
  EXPECT_THAT(rig.field.walker, ElementsAre("START", "STOP"));
}

TEST(Lane, IgnoresTheEndOfAnEarlierWalk) {
  Rig rig;
  bool fresh = false;
  rig.script.walker = [&](Duration walked) -> std::string {
    if (walked > Milliseconds(500)) fresh = true;
    return walked < Milliseconds(3000) && fresh ? "State:WALKING" : "State:IDLE,End:course_end";
  };
  rig.Command("START:S1_TO_S2");
  rig.Run(Milliseconds(2500));
  EXPECT_EQ(rig.state(), "S1_TO_S2");
  ASSERT_TRUE(rig.RunTo("IN_S2", Milliseconds(2000)));
}

// After a second the end of an earlier walk counted as that of this one.
TEST(Lane, DoesNotEndWellByAWalkerThatHasNotBegun) {
  Rig rig;
  rig.script.walker = [](Duration) { return "State:IDLE,Active:False,End:course_end"; };
  rig.Command("START:S1_TO_S2");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.walking_lane; }));
  rig.Run(Milliseconds(4500));
  EXPECT_EQ(rig.state(), "S1_TO_S2");
  EXPECT_TRUE(rig.RunTo("ERROR", Milliseconds(1000)));
  EXPECT_TRUE(rig.field.Logged("the line walker has not begun to walk within 5000 ms"));
}

TEST(Lane, ThatACommandLeadsALyingRobotToIsWalkedStanding) {
  Rig rig;
  rig.Command("START:S1_TO_S2");
  rig.Tick(5);
  EXPECT_THAT(rig.field.motions, ElementsAre(111));
  EXPECT_TRUE(rig.field.walker.empty()) << "it does not stand yet";
  ASSERT_TRUE(rig.RunTo("IN_S2", std::chrono::seconds(20)));
  EXPECT_THAT(rig.field.walker, ElementsAre("START", "STOP"));
}

// A walk that ended by a fault that has healed led to the error at once.
TEST(Lane, IsStartedAgainAfterAnotherEnd) {
  Rig rig;
  int starts = 0;
  bool walking = false;
  rig.script.walker = [&](Duration walked) -> std::string {
    if (walked > Duration(0) && !std::exchange(walking, true)) ++starts;
    if (walked == Duration(0)) walking = false;
    if (walked < Milliseconds(3000)) return "State:WALKING,Active:True";
    return starts == 1 ? "State:IDLE,Active:False,End:silent"
                       : "State:IDLE,Active:False,End:course_end";
  };
  rig.Command("START:S1_TO_S2");
  ASSERT_TRUE(rig.RunTo("IN_S2", std::chrono::seconds(20)));
  EXPECT_THAT(rig.field.walker, ElementsAre("START", "STOP", "START", "STOP"));
  EXPECT_TRUE(rig.field.Logged("the line walker has ended with silent: retry 1 of 1"));
  EXPECT_EQ(rig.race->memory().reserved(), 1U);
}

// Two seconds after the STOP of a person it walked on by itself.
TEST(Lane, ThatOthersStopIsNotStartedAgain) {
  Rig rig;
  rig.script.walker = [](Duration walked) -> std::string {
    return walked < Milliseconds(3000) ? "State:WALKING,Active:True"
                                       : "State:IDLE,Active:False,End:stopped";
  };
  rig.Command("START:S1_TO_S2");
  ASSERT_TRUE(rig.RunTo("ERROR", std::chrono::seconds(10)));
  EXPECT_THAT(rig.field.walker, ElementsAre("START", "STOP"));
  EXPECT_TRUE(rig.field.Logged("the line walker has ended with stopped"));
}

// Nothing moves because a process was restarted: the new one approached the lane blindly, in it.
TEST(Lane, WhoseWalkerWasRestartedIsNotStartedAgain) {
  Rig rig;
  rig.script.walker = [](Duration walked) -> std::string {
    return walked < Milliseconds(3000) ? "State:WALKING,Active:True" : "State:IDLE,Active:False";
  };
  rig.Command("START:S1_TO_S2");
  ASSERT_TRUE(rig.RunTo("ERROR", std::chrono::seconds(10)));
  EXPECT_THAT(rig.field.walker, ElementsAre("START", "STOP"));
}

// In the statuses is still the end by the STOP of before.
TEST(Lane, ThatTheRaceItselfHasStoppedIsStartedAgain) {
  Rig rig;
  rig.Command("START:S1_TO_S2");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.walking_lane; }));
  rig.Run(Milliseconds(2000));
  rig.race->Pause(rig.now);
  rig.machine->Pause();
  rig.Run(Milliseconds(1000));
  rig.script.walker = [](Duration walked) -> std::string {
    if (walked < Milliseconds(500)) return "State:IDLE,Active:False,End:stopped";
    return walked < Milliseconds(4000) ? "State:WALKING,Active:True"
                                       : "State:IDLE,Active:False,End:course_end";
  };
  rig.race->Resume(rig.now);
  ASSERT_TRUE(rig.RunTo("IN_S2", std::chrono::seconds(20)));
  EXPECT_THAT(rig.field.walker, ElementsAre("START", "STOP", "START", "STOP"));
}

class MeasuredLane : public ::testing::Test {
 protected:
  MeasuredLane() {
    rig_.script.odometry = Truth;
    rig_.Command("START:IN_S1");
  }
  Rig rig_;
};

// It took a line on the floor for the lane's end, and went on as if it were at S2.
TEST_F(MeasuredLane, WhoseEndIsTooNearIsAFault) {
  rig_.script.lane_m_s = 0.2;
  ASSERT_TRUE(rig_.RunTo("ERROR", std::chrono::seconds(15))) << rig_.state();
  EXPECT_THAT(rig_.race->InfoText(),
              HasSubstr("the line walker has ended with course_end after 1.60 m by odometry, less "
                        "than 3.50 m: another line was taken for the end of its lane"));
}

TEST_F(MeasuredLane, WhoseEndIsPassedIsAFault) {
  rig_.script.walker = [](Duration) { return std::string("State:WALKING,Active:True"); };
  ASSERT_TRUE(rig_.RunTo("ERROR", std::chrono::seconds(15))) << rig_.state();
  EXPECT_THAT(rig_.race->InfoText(), HasSubstr("more than 7.00 m: it has passed the end"));
  EXPECT_FALSE(rig_.field.walking_lane);
}

TEST_F(MeasuredLane, OfItsLengthEndsWithoutAReservation) {
  ASSERT_TRUE(rig_.RunTo("IN_S2", std::chrono::seconds(15)));
  EXPECT_EQ(rig_.race->memory().reserved(), 0U);
}

TEST_F(MeasuredLane, IsMeasuredFromItsBeginAlsoAfterAYellowLight) {
  bool light = false;
  rig_.script.sight = [&](const std::string& detector) -> Sighting {
    return {light && detector == "light", 0.5, "", ""};
  };
  rig_.script.lane_m_s = 0.3;  // 2.4 m, and as much again
  ASSERT_TRUE(rig_.RunUntil([&] { return rig_.field.walking_lane; }));
  rig_.Run(Milliseconds(6000));
  light = true;
  ASSERT_TRUE(rig_.RunTo("YELLOW_LIGHT_STOP", Milliseconds(300)));
  light = false;
  ASSERT_TRUE(rig_.RunTo("S1_TO_S2", Milliseconds(8000)));
  EXPECT_TRUE(rig_.RunTo("IN_S2", std::chrono::seconds(15))) << rig_.race->InfoText();
}

TEST_F(MeasuredLane, MayBeShorterWhereACommandHasEnteredIt) {
  rig_.Command("STOP");
  rig_.script.lane_m_s = 0.2;
  rig_.Command("START:S1_TO_S2");
  EXPECT_TRUE(rig_.RunTo("IN_S2", std::chrono::seconds(15))) << rig_.race->InfoText();
}

TEST_F(MeasuredLane, WithoutOdometryIsAReservation) {
  rig_.script.odometry = nullptr;
  ASSERT_TRUE(rig_.RunTo("IN_S2", std::chrono::seconds(15)));
  EXPECT_TRUE(rig_.field.Logged("how far it has come is not known: no odometry on odom_out"));
}

TEST_F(MeasuredLane, WhoseOdometryJumpsIsAReservation) {
  rig_.script.odometry = [this](OdometrySample truth) -> std::optional<OdometrySample> {
    if (rig_.now > Time{Milliseconds(5000)}) truth.pose.at.x_m -= 20;
    return truth;
  };
  ASSERT_TRUE(rig_.RunTo("IN_S2", std::chrono::seconds(15))) << rig_.race->InfoText();
  EXPECT_TRUE(rig_.field.Logged("how far it has come is not known"));
}

TEST(Speech, OfASightIsLeftOutWithoutIt) {
  for (const bool seen : {true, false}) {
    Rig rig;
    rig.script.sight = [&](const std::string& detector) {
      Sighting sighting{false, kUnknown, "", ""};
      if (detector != "marker") return sighting;
      sighting.phase = seen && rig.FramesOf({0.4, 0, 0}) > 40 ? "disappeared" : "searching";
      return sighting;
    };
    rig.Command("START:S2_TO_R1");
    ASSERT_TRUE(rig.RunTo("R1_TO_QRB"));
    EXPECT_EQ(rig.field.spoken.size(), seen ? 5U : 0U);
    EXPECT_EQ(rig.field.Logged("IN_R1: countdown is left out: no marker was found"), !seen);
  }
}

TEST(Speech, OfTheCountdownTakesFiveSeconds) {
  Rig rig;
  rig.Command("START:IN_R1");
  const Time begin = rig.now;
  ASSERT_TRUE(rig.RunTo("R1_TO_QRB"));
  EXPECT_THAT(rig.field.spoken, ElementsAre("五", "四", "三", "二", "一"));
  EXPECT_GE(rig.now - begin, Milliseconds(5000));
  EXPECT_LE(rig.now - begin, Milliseconds(5300));
}

TEST(Speech, ThatIsNotAnsweredEndsAtItsLimit) {
  Rig rig;
  rig.script.speech_replies = false;
  rig.Command("START:IN_R1");
  ASSERT_TRUE(rig.RunTo("R1_TO_QRB", Milliseconds(11'000)));
  EXPECT_TRUE(rig.field.Logged("the speech countdown has not ended within its limit"));
}

}  // namespace musher::race::walk_test
