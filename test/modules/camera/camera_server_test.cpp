// camera_service as a client meets it.

#include "musher/modules/camera/camera_server.hpp"

#include <gmock/gmock.h>

#include "musher/test/modules/camera/cameras_fixture.hpp"

namespace musher::camera::camera_server_test {

using msg::CameraService;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class CameraServerTest : public CamerasOnANetwork {
 protected:
  CameraServerTest() {
    config_.cameras.pop_back();
    MakeWorld();
  }
};

TEST_F(CameraServerTest, TakesAPictureAndRepliesWithItsPath) {
  Start();
  const auto taken = Call({CameraService::kTakePicture, "me.jpg", 32, 24, 0});
  EXPECT_EQ(taken, (CameraService::Response{0, "/saved/me.jpg", 0}));
  ASSERT_THAT(saved_.pictures, SizeIs(1));
  EXPECT_EQ(saved_.pictures["me.jpg"].width, 32u);
}

TEST_F(CameraServerTest, NamesPicturesByTheirTime) {
  Start();
  EXPECT_THAT(Call({CameraService::kTakePicture, "", 0, 0, 0}).msg, HasSubstr("/saved/picture_"));
  EXPECT_THAT(Call({CameraService::kTakePicture, "", 0, 0, 0}).msg, HasSubstr(".jpg"));
  EXPECT_THAT(saved_.pictures, SizeIs(2));
  EXPECT_TRUE(saved_.files.back().counts_on) << "that time may have been before";
  EXPECT_EQ(Call({CameraService::kTakePicture, "me.jpg", 0, 0, 0}).result, 0);
  EXPECT_FALSE(saved_.files.back().counts_on) << "a requested name is used as it is";
}

TEST_F(CameraServerTest, SwitchesACameraOnThatIsOnDemand) {
  config_.cameras[0].on_demand = true;
  Start();
  EXPECT_EQ(drawn_, 0);
  EXPECT_EQ(Call({CameraService::kTakePicture, "", 0, 0, 0}).result, 0);
  Run(Milliseconds(500));
  drawn_ = 0;
  Run(Milliseconds(500));
  EXPECT_EQ(drawn_, 0) << "and off again";
}

TEST_F(CameraServerTest, TimesOutAfterTwoSecondsWithoutAPicture) {
  ticker_.reset();
  Start();
  const Time requested = network_.now();
  const auto late = Call({CameraService::kTakePicture, "", 0, 0, 0});
  EXPECT_EQ(late, (CameraService::Response{CameraService::kTimeout,
                                           config_.cameras[0].name + ": no picture within 2000 ms",
                                           4407}));
  EXPECT_GE(network_.now() - requested, Milliseconds(2000));
}

TEST_F(CameraServerTest, RecordsAVideoAtItsRate) {
  Start();
  const auto begun = Call({CameraService::kStartRecording, "walk.avi", 0, 0, 10});
  EXPECT_EQ(begun, (CameraService::Response{0, "/saved/walk.avi", 0}));
  EXPECT_THAT(Call({CameraService::kGetState, "", 0, 0, 0}).msg, "front: on, recording walk.avi");
  EXPECT_EQ(Call({CameraService::kStartRecording, "", 0, 0, 0}).result, CameraService::kBusy);
  Run(Milliseconds(3000));
  EXPECT_EQ(Call({CameraService::kStopRecording, "", 0, 0, 0}).msg, "/saved/walk.avi");
  EXPECT_NEAR(static_cast<double>(saved_.videos["walk.avi"].size()), 31, 2);
  EXPECT_EQ(Call({CameraService::kStopRecording, "", 0, 0, 0}).result,
            CameraService::kInvalidState);
}

TEST_F(CameraServerTest, EndsAVideoWhenTheCameraIsSwitchedOff) {
  Start();
  EXPECT_EQ(Call({CameraService::kStartRecording, "walk.avi", 0, 0, 0}).result, 0);
  cameras_->Enter("LowPower");
  EXPECT_EQ(saved_.recording, "");
  EXPECT_THAT(Lines(), ElementsAre(HasSubstr("walk.avi is ended")));
  const auto refused = Call({CameraService::kTakePicture, "", 0, 0, 0});
  EXPECT_EQ(refused.result, CameraService::kInvalidState);
  EXPECT_EQ(refused.msg, "the camera is off");
}

TEST_F(CameraServerTest, PublishesImageInTheRequestedSizeUntilItIsStopped) {
  Start();
  std::vector<msg::Image> seen;
  const auto eye = Listen("dog1/image", seen);
  Run(Milliseconds(500));
  EXPECT_THAT(seen, IsEmpty());
  EXPECT_EQ(Call({CameraService::kStartImagePublish, "", 32, 24, 0}).result, 0);
  Run(Milliseconds(1000));
  EXPECT_NEAR(static_cast<double>(seen.size()), 20, 2) << "fps 0: as the source has it";
  ASSERT_FALSE(seen.empty());
  EXPECT_EQ(seen.back().width, 32u);
  EXPECT_EQ(seen.back().header.frame_id, "camera_front");
  EXPECT_EQ(Call({CameraService::kStartImagePublish, "", 64, 48, 5}).result, 0);
  seen.clear();
  Run(Milliseconds(2000));
  EXPECT_NEAR(static_cast<double>(seen.size()), 10, 1);
  EXPECT_EQ(seen.back().width, 64u);
  EXPECT_EQ(Call({CameraService::kStopImagePublish, "", 0, 0, 0}).result, 0);
  seen.clear();
  Run(Milliseconds(500));
  EXPECT_THAT(seen, IsEmpty());
}

TEST_F(CameraServerTest, ContinuesWithImageWhenTheCameraIsOnAgain) {
  Start();
  std::vector<msg::Image> seen;
  const auto eye = Listen("dog1/image", seen);
  EXPECT_EQ(Call({CameraService::kStartImagePublish, "", 32, 24, 0}).result, 0);
  cameras_->Enter("LowPower");
  Run(Milliseconds(500));
  seen.clear();
  Run(Milliseconds(500));
  EXPECT_THAT(seen, IsEmpty());
  cameras_->Enter("Active");
  Run(Milliseconds(1000));
  EXPECT_FALSE(seen.empty());
}

TEST_F(CameraServerTest, ListsAndDeletesFiles) {
  Start();
  EXPECT_EQ(Call({CameraService::kTakePicture, "b.jpg", 0, 0, 0}).result, 0);
  EXPECT_EQ(Call({CameraService::kTakePicture, "a.png", 0, 0, 0}).result, 0);
  EXPECT_EQ(Call({CameraService::kListFiles, "", 0, 0, 0}).msg, "a.png\nb.jpg");
  EXPECT_EQ(Call({CameraService::kDeleteFile, "b.jpg", 0, 0, 0}).result, 0);
  EXPECT_EQ(Call({CameraService::kDeleteFile, "b.jpg", 0, 0, 0}).result,
            CameraService::kInvalidArguments);
  EXPECT_EQ(Call({CameraService::kListFiles, "", 0, 0, 0}).msg, "a.png");
}

TEST_F(CameraServerTest, RepliesWhyItCannotSave) {
  Start();
  saved_.error = Error{4401, "/saved: the disk is full"};
  const auto full = Call({CameraService::kTakePicture, "", 0, 0, 0});
  EXPECT_EQ(full, (CameraService::Response{CameraService::kInnerError, "/saved: the disk is full",
                                           4401}));
  EXPECT_EQ(Call({CameraService::kStartRecording, "", 0, 0, 0}).code, 4401);
  saved_.error.reset();
  EXPECT_EQ(Call({CameraService::kStartRecording, "", 0, 0, 0}).result, 0);
}

TEST_F(CameraServerTest, RefusesWhatTheMachineDoesNotAllow) {
  Start();
  may_ = Error{4403, "camera runs in Active only"};
  EXPECT_EQ(Call({CameraService::kTakePicture, "", 0, 0, 0}).code, 4403);
  EXPECT_THAT(Lines(), ElementsAre("4403 camera_service: refused: camera runs in Active only"));
  EXPECT_EQ(Call({CameraService::kListFiles, "", 0, 0, 0}).result, 0) << "looking is free";
}

}  // namespace musher::camera::camera_server_test
