// The yellow light over a lane: it stops movements ahead, once.

#include <gmock/gmock.h>

#include "musher/test/modules/race/race_rig.hpp"

namespace musher::race::light_test {

using ::testing::ElementsAre;

class Lamp : public Rig {
 public:
  Lamp() {
    script.sight = [this](const std::string& detector) -> Sighting {
      if (detector != "light") return {false, kUnknown, "", ""};
      return {seen, distance_m, "tracking", ""};
    };
  }
  bool seen = false;
  double distance_m = 0.5;
};

TEST(YellowLight, StopsAMovementAheadWhichContinuesWithItsRestAfterTheCountdown) {
  Lamp rig;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(2000));
  rig.seen = true;
  ASSERT_TRUE(rig.RunTo("YELLOW_LIGHT_STOP", Milliseconds(300)));
  EXPECT_FALSE(rig.field.streaming);
  ASSERT_TRUE(rig.RunTo("QRA_TO_A1", Milliseconds(8000)));
  EXPECT_THAT(rig.field.spoken, ElementsAre("五", "四", "三", "二", "一"));
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.ends == 2; }));
  const int frames = rig.field.frames_of_stream[0] + rig.field.frames_of_stream[1];
  EXPECT_GE(frames, 23 * 4);
  EXPECT_LE(frames, 23 * 4 + 1);
  ASSERT_TRUE(rig.RunTo("IN_A1"));
  EXPECT_THAT(rig.visited, ElementsAre("QRA_TO_A1", "YELLOW_LIGHT_STOP", "YELLOW_LIGHT_COUNTDOWN",
                                       "QRA_TO_A1", "IN_A1"));
  // The way there decides, not the light.
  ASSERT_TRUE(rig.RunTo("A1_TO_S1"));
}

TEST(YellowLight, ThatIsFarOrOfUnknownDistanceStopsNothing) {
  Lamp rig;
  rig.seen = true;
  rig.distance_m = 0.71;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(2000));
  rig.distance_m = kUnknown;
  rig.Run(Milliseconds(2000));
  EXPECT_EQ(rig.state(), "QRA_TO_A1");
}

TEST(YellowLight, StopsAMovementWhileNoPictureComes) {
  Lamp rig;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(2000));
  ASSERT_TRUE(rig.field.streaming);
  rig.script.cameras = false;
  rig.Run(Milliseconds(1100));
  EXPECT_FALSE(rig.field.streaming);
  rig.Run(Milliseconds(3000));
  EXPECT_FALSE(rig.field.streaming);
  EXPECT_TRUE(rig.field.Logged("no picture for the detector light for 1000 ms"));
  rig.script.cameras = true;
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.ends == 2; }));
  const int frames = rig.field.frames_of_stream[0] + rig.field.frames_of_stream[1];
  EXPECT_GE(frames, 23 * 4);
  EXPECT_LE(frames, 23 * 4 + 1);
  EXPECT_TRUE(rig.RunTo("IN_A1"));
}

TEST(YellowLight, WithoutPicturesForTenSecondsLeadsToTheError) {
  Lamp rig;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(2000));
  rig.script.cameras = false;
  EXPECT_TRUE(rig.RunTo("ERROR", Milliseconds(10'100)));
}

TEST(YellowLight, IsOnlyWatchedDuringMovementsAhead) {
  Lamp rig;
  rig.seen = true;
  rig.Command("START:B1_TO_L1");  // stands up and turns
  rig.Run(Milliseconds(3000));
  EXPECT_TRUE(rig.field.streaming);
  EXPECT_FALSE(rig.Wants("light"));
  rig.Command("START:IN_L1");  // a walk ahead in a state without light = true
  rig.Run(Milliseconds(1000));
  EXPECT_TRUE(rig.field.streaming);
  EXPECT_FALSE(rig.Wants("light"));
}

TEST(YellowLight, StopsAgainOnlyAfterTwoSecondsOutOfSight) {
  Lamp rig;
  rig.Command("START:L1_TO_QRB");
  rig.Run(Milliseconds(1000));
  rig.seen = true;
  ASSERT_TRUE(rig.RunTo("YELLOW_LIGHT_STOP", Milliseconds(300)));
  ASSERT_TRUE(rig.RunTo("L1_TO_QRB", Milliseconds(8000)));
  rig.Run(Milliseconds(1000));
  rig.seen = false;
  rig.Run(Milliseconds(1500));
  rig.seen = true;
  rig.Run(Milliseconds(500));
  EXPECT_EQ(rig.state(), "L1_TO_QRB");
  rig.seen = false;
  rig.Run(Milliseconds(2300));
  rig.seen = true;
  EXPECT_TRUE(rig.RunTo("YELLOW_LIGHT_STOP", Milliseconds(300)));
}

TEST(YellowLight, StopsAgainAfterTenSecondsInSight) {
  Lamp rig;
  rig.seen = true;
  rig.Command("START:L1_TO_QRB");
  ASSERT_TRUE(rig.RunTo("YELLOW_LIGHT_STOP", Milliseconds(1500)));
  ASSERT_TRUE(rig.RunTo("L1_TO_QRB", Milliseconds(8000)));
  const Time again = rig.now;
  ASSERT_TRUE(rig.RunTo("YELLOW_LIGHT_STOP", Milliseconds(12'000)));
  EXPECT_GE(rig.now - again, Milliseconds(9900));
}

TEST(YellowLight, DoesNotCountTheStepsUntilTheBarrierTwice) {
  Lamp rig;
  int frames = 0;
  rig.script.sight = [&](const std::string& detector) -> Sighting {
    frames = 0;
    for (const int stream : rig.field.frames_of_stream) frames += stream;
    if (detector == "light") return {frames >= 21 * 4 + 40 && frames < 21 * 4 + 60, 0.5, "", ""};
    return {true, 1, detector == "barrier" && frames >= 21 * 4 + 120 ? "top" : "seen", ""};
  };
  rig.Command("START:S2_TO_L1");
  ASSERT_TRUE(rig.RunTo("YELLOW_LIGHT_STOP"));
  ASSERT_TRUE(rig.RunTo("IN_L1"));
  EXPECT_TRUE(rig.field.Logged("S2_TO_L1: barrier after 30 steps"));
  EXPECT_TRUE(rig.RunTo("L1_TO_QRB"));
}

TEST(YellowLight, StaysInterruptedOverAPause) {
  Lamp rig;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(2000));
  rig.seen = true;
  ASSERT_TRUE(rig.RunTo("YELLOW_LIGHT_COUNTDOWN", Milliseconds(2000)));
  rig.race->Rest(rig.now);
  rig.machine->Pause();
  rig.Run(std::chrono::seconds(5));
  rig.race->Resume(rig.now);
  EXPECT_TRUE(rig.RunTo("IN_A1"));
  const int frames = rig.field.frames_of_stream[0] + rig.field.frames_of_stream[1];
  EXPECT_GE(frames, 23 * 4);
  EXPECT_LE(frames, 23 * 4 + 1);
}

TEST(YellowLight, WithoutAnInterruptedMovementLeadsToTheError) {
  Lamp rig;
  rig.Command("START:38");
  ASSERT_TRUE(rig.RunTo("ERROR", std::chrono::seconds(10)));
  EXPECT_TRUE(rig.field.Logged("no movement was interrupted"));
}

}  // namespace musher::race::light_test
