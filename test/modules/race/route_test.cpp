// Whole runs of the course of the race with a fake perception.

#include <gmock/gmock.h>

#include "musher/test/modules/race/race_replay.hpp"

namespace musher::race::route_test {

using ::testing::ElementsAre;
using ::testing::ElementsAreArray;

// Boards, a barrier after 45 steps, a marker after 40.
class Course1 : public Rig {
 public:
  Course1(std::string qr_a, std::string arrow, std::string qr_b) {
    script.sight = [this, qr_a, arrow, qr_b](const std::string& detector) -> Sighting {
      if (detector == "qr") return Text(state() == "IN_QR_A" ? qr_a : qr_b);
      if (detector == "arrow") return Text(arrow);
      const auto& walk = frames_in_stream();
      if (detector == "barrier") return {true, 1, walk >= 180 ? "top" : "seen", ""};
      if (detector == "marker")
        return {walk < 160, 1, walk >= 160 ? "disappeared" : "tracking", ""};
      return {false, kUnknown, "", ""};
    };
    script.odometry = Truth;
  }
  int frames_in_stream() const { return field.streaming ? field.frames_of_stream.back() : 0; }
};

TEST(Route, OfBayA1LeftAndB2VisitsEveryStateInOrder) {
  Course1 rig("A-1", "left", "B-2");
  rig.Command("START");
  ASSERT_TRUE(rig.RunTo("END")) << rig.state() << ": " << rig.race->InfoText();
  EXPECT_THAT(
      rig.visited,
      ElementsAre("START_TO_QRA", "IN_QR_A", "QRA_TO_A1", "IN_A1", "A1_TO_S1", "IN_S1", "S1_TO_S2",
                  "IN_S2", "S2_TO_L1", "IN_L1", "L1_TO_QRB", "IN_QRB", "QRB_TO_B2", "IN_B2",
                  "B2_TO_B1", "IN_B1", "B1_TO_R1", "IN_R1", "R1_TO_S2", "IN_S2_R", "S2_TO_S1",
                  "IN_S1_R", "S1_TO_A2", "IN_A2", "A2_TO_START", "END"));
  EXPECT_THAT(rig.field.states, ElementsAre(0, 1, 2, 3, 5, 7, 9, 10, 11, 12, 14, 16, 18, 20, 22, 24,
                                            21, 26, 15, 30, 31, 32, 33, 35, 6, 37, 45));
  EXPECT_EQ(rig.race->InfoText(), "CurrentState:45,QRResult:B-2,TaskCompleted:True,Reservations:0");
  EXPECT_THAT(rig.field.walker, ElementsAre("START", "STOP", "START", "STOP"));
  EXPECT_THAT(rig.field.spoken,
              ElementsAre("A区库位1", "已到达库位", "左侧路线", "B区库位2", "已到达库位",
                          "已到达库位", "五", "四", "三", "二", "一", "已到达库位"));
  EXPECT_EQ(rig.field.streams, rig.field.ends);
}

TEST(Route, OfBayA2RightAndB1VisitsEveryStateInOrder) {
  Course1 rig("A-2", "right", "B-1");
  rig.Command("START");
  ASSERT_TRUE(rig.RunTo("END")) << rig.state() << ": " << rig.race->InfoText();
  EXPECT_THAT(
      rig.visited,
      ElementsAre("START_TO_QRA", "IN_QR_A", "QRA_TO_A2", "IN_A2", "A2_TO_S1", "IN_S1", "S1_TO_S2",
                  "IN_S2", "S2_TO_R1", "IN_R1", "R1_TO_QRB", "IN_QRB", "QRB_TO_B1", "IN_B1",
                  "B1_TO_B2", "IN_B2", "B2_TO_L1", "IN_L1", "L1_TO_S2", "IN_S2_R", "S2_TO_S1",
                  "IN_S1_R", "S1_TO_A1", "IN_A1", "A1_TO_START", "END"));
  EXPECT_EQ(rig.race->InfoText(), "CurrentState:45,QRResult:B-1,TaskCompleted:True,Reservations:0");
}

TEST(Route, OfOneCourseIsReplayedFromItsRecording) {
  Course1 rig("A-1", "right", "B-2");
  rig.Command("SET_QR_A:A-2");
  rig.Command("START");
  rig.Run(std::chrono::seconds(20));
  rig.race->Pause(rig.now);
  rig.machine->Pause();
  rig.Run(std::chrono::seconds(5));
  rig.race->Resume(rig.now);
  rig.Run(std::chrono::seconds(60));
  rig.Command("START:IN_B2");
  rig.Run(std::chrono::seconds(2));
  rig.Command("RESET");
  rig.Run(std::chrono::seconds(20));
  rig.Command("START");
  ASSERT_TRUE(rig.RunTo("IN_L1") || rig.state() == "END") << rig.race->InfoText();
  ExpectReplays(rig);
}

}  // namespace musher::race::route_test
