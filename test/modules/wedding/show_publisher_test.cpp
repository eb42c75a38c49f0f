// Several publishers of one topic, and topics that take precedence over others.

#include <gmock/gmock.h>

#include <string>

#include "musher/test/modules/wedding/show_rig.hpp"

namespace musher::wedding::show_publisher_test {

class ShowPublishers : public ShowRig {
 protected:
  static constexpr PublisherId kFrontCamera = 11;
  static constexpr PublisherId kSideCamera = 12;
  static constexpr PublisherId kSuccessor = 13;

  void TooCloseBy(PublisherId publisher, bool too_close) {
    show_->OnTooClose(too_close, now_, publisher);
  }
  void Lose(PublisherId publisher) { show_->OnTooClosePublisherLost(publisher, now_); }
  void Faces(const std::string& faces) { show_->OnFaces("{\"faces\": [" + faces + "]}", now_); }
  // Longer than it takes to leave SAFE_STOP.
  void TickLong() { Tick(Ticks(Milliseconds(5000))); }
};

TEST_F(ShowPublishers, AFalseOfOneCameraDoesNotCancelTheTrueOfAnother) {
  TooCloseBy(kFrontCamera, true);
  TooCloseBy(kSideCamera, false);
  TickLong();
  EXPECT_EQ(state(), "SAFE_STOP");
  TooCloseBy(kFrontCamera, false);
  TickLong();
  EXPECT_EQ(state(), "IDLE");
}

TEST_F(ShowPublishers, BothHaveToReportThatNoGuestIsTooClose) {
  TooCloseBy(kFrontCamera, true);
  TooCloseBy(kSideCamera, true);
  TooCloseBy(kFrontCamera, false);
  TickLong();
  EXPECT_EQ(state(), "SAFE_STOP");
  TooCloseBy(kSideCamera, false);
  TickLong();
  EXPECT_EQ(state(), "IDLE");
}

TEST_F(ShowPublishers, TheTrueOfALostCameraHoldsBesideOneThatSawNothingAllAlong) {
  TooCloseBy(kSideCamera, false);
  Tick();
  TooCloseBy(kFrontCamera, true);
  Tick();
  Lose(kFrontCamera);
  for (int i = 0; i < 300; ++i) {
    TooCloseBy(kSideCamera, false);
    Tick();
  }
  EXPECT_EQ(state(), "SAFE_STOP");
}

TEST_F(ShowPublishers, TheSuccessorOfALostCameraMayCancelItsTrue) {
  TooCloseBy(kFrontCamera, true);
  Tick();
  Lose(kFrontCamera);
  TickLong();
  ASSERT_EQ(state(), "SAFE_STOP");
  TooCloseBy(kSuccessor, false);
  TickLong();
  EXPECT_EQ(state(), "IDLE");
}

TEST_F(ShowPublishers, TheSuccessorMayPublishBeforeTheLossIsDetected) {
  TooCloseBy(kFrontCamera, true);
  Tick();
  TooCloseBy(kSuccessor, false);
  TickLong();
  ASSERT_EQ(state(), "SAFE_STOP");
  Lose(kFrontCamera);
  TickLong();
  EXPECT_EQ(state(), "IDLE");
}

TEST_F(ShowPublishers, TheLossOfACameraThatPublishedNothingChangesNothing) {
  Lose(kSideCamera);
  TooCloseBy(kFrontCamera, false);
  Lose(kFrontCamera);
  TickLong();
  EXPECT_EQ(state(), "IDLE");
}

TEST_F(ShowPublishers, ATrueIsCancelledAlsoAfterTimeWentBack) {
  TooCloseBy(kFrontCamera, true);
  Tick();
  Lose(kFrontCamera);
  now_ = Time(Milliseconds(10));
  TooCloseBy(kSuccessor, false);
  TickLong();
  EXPECT_EQ(state(), "IDLE");
}

TEST_F(ShowPublishers, ARecordingOfSeveralReplaysIdentically) {
  TooCloseBy(kFrontCamera, true);
  Tick();
  TooCloseBy(kSideCamera, false);
  Tick();
  Lose(kFrontCamera);
  TickLong();
  Faces(R"({"is_frontal": true, "area": 0.1, "center_x": 0.25, "center_y": 0.75})");
  Tick();
  ExpectReplays({});
}

TEST_F(ShowPublishers, AFrontalFaceOfFacesJsonIsAFaceWithoutATarget) {
  Faces(R"({"is_frontal": true, "area": 0.1, "center_x": 0.25, "center_y": 0.75, "face_id": 3})");
  Tick();
  EXPECT_EQ(state(), "TRACKING");
  EXPECT_EQ(data().perception.face_position, (Gaze{0.25, 0.75}));
  EXPECT_EQ(data().perception.face_id, 3);
}

TEST_F(ShowPublishers, TheCentreOfAFaceDefaultsToThatOfItsBox) {
  Faces(R"({"is_frontal": true, "area": 0.1, "x": 0.2, "y": 0.4, "width": 0.1, "height": 0.2})");
  Tick();
  EXPECT_EQ(state(), "TRACKING");
  EXPECT_NEAR(data().perception.face_position.x, 0.25, 1e-12);
  EXPECT_NEAR(data().perception.face_position.y, 0.5, 1e-12);
}

TEST_F(ShowPublishers, AFaceWithoutAPlaceOrThatLooksAwayIsNotGreeted) {
  Faces(R"({"is_frontal": true, "area": 0.1})");
  Tick();
  Faces(R"({"is_frontal": false, "center_x": 0.5, "center_y": 0.5})");
  Tick();
  EXPECT_EQ(state(), "IDLE");
}

TEST_F(ShowPublishers, AFaceOutsideThePictureIsRefused) {
  Faces(R"({"is_frontal": true, "center_x": 320, "center_y": 240})");
  Tick();
  EXPECT_EQ(state(), "IDLE");
  ASSERT_EQ(script_.log.size(), 1U);
  EXPECT_THAT(script_.log[0], ::testing::HasSubstr("is not in the picture: x and y are 0 to 1"));
}

TEST_F(ShowPublishers, ATargetTakesPrecedenceOverTheFacesOfFacesJson) {
  Face({0.5, 0.5});
  Faces(R"({"is_frontal": true, "area": 0.1, "center_x": 0.1, "center_y": 0.1})");
  Tick();
  EXPECT_EQ(data().perception.face_position, (Gaze{0.5, 0.5}));
}

TEST_F(ShowPublishers, ADetectorThatPublishesOnlyFacesJsonIsFollowedAndItsLossIsDetected) {
  for (int i = 0; i < 100; ++i) {
    Faces(R"({"is_frontal": true, "area": 0.1, "center_x": 0.4, "center_y": 0.5})");
    Tick();
  }
  EXPECT_EQ(state(), "TRACKING");
  EXPECT_NEAR(data().motion.look_at_target.x, 0.4, 0.01);
  Faces("");
  EXPECT_GE(TicksTo("FAREWELL", 100), 70) << "1.5 s after the last face";
}

}  // namespace musher::wedding::show_publisher_test
