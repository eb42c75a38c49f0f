// The cameras with their topics, through the lifecycle and through faults.

#include "musher/modules/camera/cameras.hpp"

#include <gmock/gmock.h>

#include "musher/test/modules/camera/cameras_fixture.hpp"

namespace musher::camera::cameras_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class CamerasTest : public CamerasOnANetwork {
 protected:
  CamerasTest() { config_.silence = Milliseconds(1000); }
};

TEST_F(CamerasTest, PublishTheWorldsPicturesUnderTheirOwnName) {
  MakeWorld();
  Start();
  std::vector<msg::Image> seen;
  const auto eye = Listen("dog1/image_front", seen);
  Run(Milliseconds(1500));
  ASSERT_GE(seen.size(), 15u);
  EXPECT_EQ(seen.back().header.frame_id, "camera_front");
  EXPECT_EQ(seen.back().data, shot_.data);
  EXPECT_NE(seen.back().header.stamp, seen[seen.size() - 2].header.stamp) << "the shot's own time";
}

TEST_F(CamerasTest, PublishTheWorldsCameraInfoInThePublishedSize) {
  MakeWorld();
  config_.cameras[0].format = {32, 24, "mono8"};
  const auto infos = test::Must(transport::MakePublisher<msg::CameraInfo>(
      *desk_, "dog1/world/camera/front/info", transport::kLatchedQos));
  msg::CameraInfo info;
  info.width = 64;
  info.height = 48;
  info.distortion_model = msg::CameraInfo::kEquidistant;
  info.k[0] = 100;
  ASSERT_TRUE(infos->Publish(info));
  Start();
  std::vector<msg::Image> seen;
  std::vector<msg::CameraInfo> scaled;
  const auto eye = Listen("dog1/image_front", seen);
  const auto subscription = Listen("dog1/image_front/camera_info", scaled);
  Run(Milliseconds(1000));
  ASSERT_FALSE(scaled.empty());
  EXPECT_EQ(scaled.back().width, 32u);
  EXPECT_EQ(scaled.back().k[0], 50);
  EXPECT_EQ(scaled.back().distortion_model, "equidistant");
  EXPECT_EQ(scaled.back().header, seen.back().header);
  EXPECT_EQ(seen.back().encoding, "mono8");
  EXPECT_EQ(seen.back().data.size(), 32u * 24u);
}

TEST_F(CamerasTest, AreOffInLowPowerSoThatTheWorldDrawsNothing) {
  MakeWorld();
  Start();
  std::vector<msg::Image> seen;
  const auto eye = Listen("dog1/image_front", seen);
  for (const BuiltInState state : {kLowPower, kOta, kDeActive, kTearDown}) {
    cameras_->Enter(state);
    Run(Milliseconds(500));
    drawn_ = 0;
    seen.clear();
    Run(Milliseconds(1000));
    EXPECT_EQ(drawn_, 0) << state;
    EXPECT_THAT(seen, IsEmpty()) << state;
    EXPECT_FALSE(device_.open) << state;
    cameras_->Enter("Protected");
    EXPECT_TRUE(device_.open) << state;
    Run(Milliseconds(900));
    EXPECT_FALSE(seen.empty()) << state;
  }
}

TEST_F(CamerasTest, OnDemandAreOffWithoutASubscriber) {
  MakeWorld();
  config_.cameras[0].on_demand = true;
  Start();
  Run(Milliseconds(2000));
  EXPECT_EQ(drawn_, 0);
  EXPECT_THAT(Lines(), ::testing::Not(::testing::Contains(HasSubstr("front"))))
      << "no subscriber misses its pictures";
  std::vector<msg::Image> seen;
  auto eye = Listen("dog1/image_front", seen);
  Run(Milliseconds(1000));
  EXPECT_FALSE(seen.empty());
  eye.reset();
  Run(Milliseconds(500));
  drawn_ = 0;
  Run(Milliseconds(1000));
  EXPECT_EQ(drawn_, 0);
}

TEST_F(CamerasTest, LogOnceThatTheWorldIsSilentAndThatItIsBack) {
  config_.cameras.pop_back();
  Start();
  Run(Milliseconds(5000));
  EXPECT_THAT(Lines(), ElementsAre("4407 front: no picture for 1000 ms"));
  MakeWorld();
  Run(Milliseconds(1000));
  EXPECT_THAT(Lines(), ElementsAre(HasSubstr("4407"), "0 front: receiving pictures again"));
}

TEST_F(CamerasTest, LoseAnUnpluggedCameraAndContinueWithTheOthersUntilItIsBack) {
  MakeWorld();
  config_.retry = Milliseconds(700);
  Start();
  device_.events.on_frame(Picture());
  std::vector<msg::Image> front;
  const auto eye = Listen("dog1/image_front", front);
  std::vector<msg::Image> left;
  const auto other_eye = Listen("dog1/image_left", left);
  Run(Milliseconds(300));
  device_.events.on_failed({4412, "/dev/video0 gives no more pictures"});
  Run(Milliseconds(100));
  EXPECT_FALSE(device_.open);
  EXPECT_THAT(Lines(), ElementsAre("4412 left: /dev/video0 gives no more pictures"));
  front.clear();
  Run(Milliseconds(1000));
  EXPECT_EQ(device_.opened, 2) << "tried again";
  EXPECT_FALSE(front.empty());
  device_.events.on_frame(Picture());
  Run(Milliseconds(100));
  EXPECT_THAT(Lines(), ElementsAre(HasSubstr("4412"), "0 left: receiving pictures again"));
  ASSERT_THAT(left, SizeIs(1));
  EXPECT_NE(left[0].header.stamp, msg::Stamp{})
      << "a device's pictures get the stamp of this process";
}

TEST_F(CamerasTest, LogAVideoThatEnds) {
  Start();
  device_.events.on_frame(Picture());
  device_.events.on_ended();
  Run(Milliseconds(3000));
  EXPECT_FALSE(device_.open);
  EXPECT_EQ(device_.opened, 1);
  EXPECT_THAT(Lines(), ::testing::Contains("0 left: 0 has ended"));
}

TEST_F(CamerasTest, RefuseAnInvalidPictureAndContinue) {
  MakeWorld();
  shot_.encoding = "yuv422";
  Start();
  Run(Milliseconds(200));
  EXPECT_THAT(Lines(),
              ::testing::Contains(HasSubstr("4410 front: a picture of encoding \"yuv422\"")));
  shot_ = Picture();
  Run(Milliseconds(5000));
  EXPECT_THAT(Lines(), ::testing::Contains("0 front: receiving pictures again"));
}

TEST_F(CamerasTest, AreSwitchedOnForASelfCheckWhateverTheState) {
  MakeWorld();
  config_.skip = {"left"};
  config_.cameras[0].on_demand = true;
  Start("LowPower");
  ASSERT_THAT(cameras_->Check(), SizeIs(1));
  EXPECT_EQ(cameras_->Check()[0].result.error(),
            (Error{4409, "no picture from world/camera/front"}));
  cameras_->SetChecked(true);
  Run(Milliseconds(500));
  EXPECT_TRUE(cameras_->Check()[0].result);
  EXPECT_EQ(device_.opened, 0) << "it is skipped";
  cameras_->SetChecked(false);
  Run(Milliseconds(200));
  drawn_ = 0;
  Run(Milliseconds(500));
  EXPECT_EQ(drawn_, 0);
}

TEST_F(CamerasTest, FailTheirCheckWithWhatIsWrong) {
  Start();
  device_.events.on_failed({4412, "there is no device /dev/video0"});
  Run(Milliseconds(1));
  const auto findings = cameras_->Check();
  ASSERT_THAT(findings, SizeIs(2));
  EXPECT_EQ(findings[1].result.error(), (Error{4412, "there is no device /dev/video0"}));
}

}  // namespace musher::camera::cameras_test
