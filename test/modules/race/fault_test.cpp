// Faults: what fails, the reason, and the state ERROR, which lies down.

#include <gmock/gmock.h>

#include "musher/test/modules/race/race_replay.hpp"
#include "musher/test/modules/race/race_rig.hpp"

namespace musher::race::fault_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

void ExpectError(Rig& rig, Duration within, const std::string& reason) {
  ASSERT_TRUE(rig.RunTo("ERROR", within)) << rig.state();
  EXPECT_THAT(rig.race->InfoText(), HasSubstr("CurrentState:46,"));
  EXPECT_THAT(rig.race->InfoText(), HasSubstr(reason));
  EXPECT_FALSE(rig.field.streaming);
  const std::size_t motions = rig.field.motions.size();
  ASSERT_TRUE(
      rig.RunUntil([&] { return rig.field.motions.size() > motions; }, std::chrono::seconds(40)));
  EXPECT_EQ(rig.field.motions.back(), 101);
}

TEST(RaceFault, OfAFailedMotionLeadsToTheError) {
  Rig rig;
  rig.script.motion = [](std::int32_t) { return Error{3028, "it did not end"}; };
  rig.Command("START");
  ExpectError(rig, std::chrono::seconds(2), "the motion stand (111) failed: 3028");
  rig.Run(std::chrono::seconds(60));  // the lie-down fails, too, and is not repeated
  EXPECT_EQ(rig.state(), "ERROR");
  EXPECT_THAT(rig.field.motions, ElementsAre(111, 101));
}

TEST(RaceFault, OfAMotionWithoutAReplyLeadsToTheErrorAfterItsLimit) {
  Rig rig;
  rig.script.motion_replies = false;
  rig.Command("START");
  ExpectError(rig, std::chrono::seconds(21), "no reply within 20000 ms");
}

TEST(RaceFault, OfAFallenBodyLeadsToTheErrorWithinHalfASecond) {
  Rig rig;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(1000));
  rig.script.body_status = 8;
  ExpectError(rig, Milliseconds(500), "QRA_TO_A1: the body reports: fallen (switch_status 8)");
}

TEST(RaceFault, OfASilentMotionBoardLeadsToTheError) {
  Rig rig;
  rig.script.body_reports = false;
  rig.Command("START:QRA_TO_A1");
  ExpectError(rig, Milliseconds(3200), "no motion_status for 2000 ms");
}

TEST(RaceFault, OfRefusedServoFramesLeadsToTheError) {
  Rig rig;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(500));
  rig.race->OnServoReply(false, 3001, rig.now);
  rig.Run(Milliseconds(300));
  rig.race->OnServoReply(true, 0, rig.now);
  rig.Run(Milliseconds(1000));
  EXPECT_EQ(rig.state(), "QRA_TO_A1");
  rig.race->OnServoReply(false, 3001, rig.now);
  ExpectError(rig, Milliseconds(1500), "the motion manager refuses to walk: 3001");
}

// The motion manager could not run just before the walk, and takes no frame for 2 s then.
TEST(RaceFault, IsNoRefusalForTwoSecondsOfFramesThatMayBeLate) {
  const auto time_to_a1 = [](bool late) {
    Rig rig;
    rig.Command("START:QRA_TO_A1");
    EXPECT_TRUE(rig.RunUntil([&] { return rig.field.streaming; }));
    const Time begun = rig.now;
    if (late) rig.race->OnServoReply(false, 3007, rig.now);
    rig.Run(Milliseconds(1900));
    EXPECT_EQ(rig.state(), "QRA_TO_A1");
    rig.race->OnServoReply(true, 0, rig.now);
    EXPECT_TRUE(rig.RunTo("IN_A1", std::chrono::seconds(60)));
    return rig.now - begun;
  };
  const Duration longer = time_to_a1(true) - time_to_a1(false);
  EXPECT_GE(longer, Milliseconds(1800)) << "the body stood";
  EXPECT_LE(longer, Milliseconds(2000));
}

TEST(RaceFault, OfFramesThatAreRefusedAsLateForLongLeadsToTheError) {
  Rig rig;
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.streaming; }));
  rig.race->OnServoReply(false, 3007, rig.now);
  ExpectError(rig, Milliseconds(3500), "the motion manager refuses to walk: 3007");
}

TEST(RaceFault, OfASilentCameraLeadsToTheError) {
  Rig rig;
  rig.script.cameras = false;
  rig.Command("START:IN_QR_A");
  ExpectError(rig, std::chrono::seconds(11), "no sample of the detector qr for 10000 ms");
}

// The error said that the camera may be lost, whose pictures all came.
TEST(RaceFault, OfADetectorInDoubtAboutEachPictureNamesTheDoubt) {
  Rig rig;
  rig.script.cameras = false;
  rig.Command("START:IN_QR_A");
  rig.Run(std::chrono::seconds(1));
  const Index qr = FindByName(rig.course_.detectors, "qr").value();
  for (int i = 0; i < 2; ++i) rig.race->OnDoubt(qr, "all has the colour of the light", rig.now);
  ExpectError(rig, std::chrono::seconds(11),
              "no sample of the detector qr for 10000 ms: it is in doubt about each picture: all "
              "has the colour of the light");
  ExpectReplays(rig);
}

// A sample since then: what is silent now was in no doubt.
TEST(RaceFault, OfACameraThatIsLostAfterADoubtNamesNoDoubt) {
  Rig rig;
  rig.Command("START:IN_QR_A");
  const Index qr = FindByName(rig.course_.detectors, "qr").value();
  rig.script.cameras = false;
  rig.Run(Milliseconds(200));
  rig.race->OnDoubt(qr, "all has the colour of the light", rig.now);
  rig.race->OnSighting(qr, {}, rig.now, rig.now);
  ExpectError(rig, std::chrono::seconds(12), "its camera or the detector is lost");
}

// The race believed both, in turn.
TEST(RaceFault, OfTwoPublishersOfADetectorNamesIt) {
  Rig rig;
  const Index qr = FindByName(rig.course_.detectors, "qr").value();
  const std::string topic = rig.course_.detectors[qr].topic;
  rig.race->OnTwoPublishers(topic, rig.now);
  rig.Command("START:IN_QR_A");
  rig.Run(Milliseconds(500));
  EXPECT_EQ(rig.state(), "IN_QR_A") << "it does not look in START";
  rig.race->OnTwoPublishers(topic, rig.now);
  ExpectError(rig, Milliseconds(200), "two publishers of " + topic);
  ExpectReplays(rig);
  // As recorded before topics without a detector counted, too.
  const std::size_t at = rig.recording.find(topic);
  ASSERT_NE(at, std::string::npos);
  rig.recording.replace(at, topic.size(), std::to_string(qr));
  ExpectReplays(rig);
}

TEST(RaceFault, OfALostWalkerLeadsToTheError) {
  Rig rig;
  rig.script.walker = [](Duration) { return std::string(); };
  rig.Command("START:S1_TO_S2");
  ExpectError(rig, std::chrono::seconds(4), "the line walker is lost");
  EXPECT_THAT(rig.field.walker, ElementsAre("START", "STOP"));
}

TEST(RaceFault, OfAWalkerThatWasRestartedLeadsToTheError) {
  Rig rig;
  rig.script.walker = [](Duration walked) -> std::string {
    return walked < Milliseconds(2000) ? "State:WALKING,Active:True" : "State:IDLE,Active:False";
  };
  rig.Command("START:S1_TO_S2");
  ExpectError(rig, std::chrono::seconds(10),
              "the line walker has ended with no walk: it was restarted");
}

TEST(RaceFault, OfAWalkerThatIgnoresItsStartLeadsToTheError) {
  Rig rig;
  rig.script.walker = [](Duration) { return std::string("State:IDLE,Active:False"); };
  rig.Command("START:S1_TO_S2");
  ExpectError(rig, std::chrono::seconds(7), "has not begun to walk within 5000 ms of its START");
}

TEST(RaceFault, OfAWalkerThatLosesItsLineLeadsToTheError) {
  Rig rig;
  rig.script.walker = [](Duration walked) -> std::string {
    return walked < Milliseconds(2000) ? "State:WALKING" : "State:IDLE,Active:False,End:lost";
  };
  rig.Command("START:S1_TO_S2");
  ExpectError(rig, std::chrono::seconds(10), "the line walker has ended with lost");
}

TEST(RaceFault, OfAWalkerThatNeverArrivesLeadsToTheErrorAfterItsLimit) {
  Rig rig;
  rig.script.walker = [](Duration) { return std::string("State:WALKING"); };
  rig.Command("START:S1_TO_S2");
  ExpectError(rig, std::chrono::seconds(61), "has not reached the end within 60000 ms");
}

TEST(RaceFault, LeadsToTheStateThatAKeyNames) {
  const CourseReading reading = ReadCourseText(
      R"(
start = "START"
end = "END"
error = "ERROR"
stand = "stand"
[movement.stand]
motion = 111
[state.START]
number = 0
next = "DRIVE"
[state.DRIVE]
number = 1
steps = [{ move = "stand" }]
on_fault = "REST"
next = "END"
[state.REST]
number = 2
next = "END"
[state.END]
number = 3
[state.ERROR]
number = 4
)",
      "small.toml");
  ASSERT_TRUE(reading.course);
  Rig rig(*reading.course);
  rig.script.motion = [](std::int32_t) { return Error{3028, "it did not end"}; };
  rig.Command("START");
  ASSERT_TRUE(rig.RunTo("END", std::chrono::seconds(5)));
  EXPECT_THAT(rig.visited, ElementsAre("DRIVE", "REST", "END"));
}

TEST(RaceFault, IsLeftByAReset) {
  Rig rig;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(1000));
  rig.script.body_status = 8;
  ASSERT_TRUE(rig.RunTo("ERROR", Milliseconds(500)));
  rig.script.body_status = 0;
  rig.Run(std::chrono::seconds(30));
  rig.Command("START");
  rig.Tick(2);
  EXPECT_EQ(rig.state(), "ERROR");
  rig.Command("RESET");
  rig.Command("START");
  rig.Tick(2);
  EXPECT_EQ(rig.state(), "START_TO_QRA");
}

}  // namespace musher::race::fault_test
