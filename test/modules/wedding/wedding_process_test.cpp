// musher-wedding as a controller and a plain ROS 2-style program use it: driven through the topics
// of the show.

#include "musher/test/modules/wedding/wedding_process.hpp"
#include "musher/messages/musher_msgs/behavior.hpp"
#include "musher/messages/protocol/camera.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/messages/std_srvs/set_bool.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::wedding::wedding_process_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// A writer keeps the last ten samples for a reader that has no CPU: repeated messages are rare
// here, so that no change is lost.
constexpr const char* kSeldom = "state_rate_hz = 1\n";

TEST_F(WeddingProcess, PlaysTheShowFromGreetingOverPhotoToFarewell) {
  StartActive(std::string(kSeldom) + kFile);
  ASSERT_TRUE(AwaitWithFace("TRACKING")) << peer_.Output();
  ASSERT_TRUE(gesture_->Publish({"heart"}));
  ASSERT_TRUE(AwaitWithFace("PHOTO_POSING")) << peer_.Output();
  ASSERT_TRUE(AwaitWithFace("TRACKING")) << peer_.Output();
  ASSERT_TRUE(AwaitShown("FAREWELL")) << peer_.Output();
  ASSERT_TRUE(AwaitShown("IDLE")) << peer_.Output();
  ASSERT_TRUE(peer_.Until([&] { return poses_.size() >= 5 && sounds_.size() >= 7; }))
      << peer_.Output();
  EXPECT_THAT(sounds_, ElementsAre("greeting", "photo_confirm", "countdown", "shutter",
                                   "photo_done", "greeting", "farewell"));
  EXPECT_THAT(poses_, ElementsAre("neutral", "heart", "neutral", "wave", "neutral"));
  EXPECT_THAT(peer_.Output(), HasSubstr("no photo: there is no camera service"));
}

// Whether two times that follow each other are `gap` apart, give or take a quarter. A busy machine
// leaves out periods; it makes none that are shorter all the time.
bool HasGap(const std::vector<Duration>& times, Duration gap) {
  return std::adjacent_find(times.begin(), times.end(), [&](Duration first, Duration second) {
           const Duration between = second - first;
           return between > gap - gap / 4 && between < gap + gap / 4;
         }) != times.end();
}

TEST_F(WeddingProcess, PublishesItsStateFiveTimesASecondAndItsGazeFiftyTimes) {
  std::vector<Duration> published;
  const auto states = transport::MakeSubscription<msg::String>(
                          peer_.node(), "wedding/fsm/state",
                          [&](const msg::String&, const auto&) {
                            published.push_back(peer_.node().loop().Now().time_since_epoch());
                          })
                          .value();
  const Time began = peer_.node().loop().Now();
  StartActive();
  std::vector<Duration> stamps;
  ASSERT_TRUE(peer_.Until([&] {
    for (std::size_t i = stamps.size(); i < looks_.size(); ++i) {
      stamps.push_back(msg::FromStamp(looks_[i].header.stamp));
    }
    return stamps.size() > 50 && HasGap(published, Milliseconds(200)) &&
           HasGap(stamps, Milliseconds(20));
  }));
  const Duration long_ago = peer_.node().loop().Now() - began;
  EXPECT_LE(published.size(), long_ago / Milliseconds(200) + 3) << "two of them are changes";
  EXPECT_LE(stamps.size(), (stamps.back() - stamps.front()) / Milliseconds(20) + 3);
  EXPECT_EQ(looks_.back().header.frame_id, "camera");
  EXPECT_GT(looks_.back().header.stamp.sec, 0);
  EXPECT_NEAR(looks_.back().point.x, 0.5, 0.036);
  EXPECT_EQ(looks_.back().point.z, 0);
}

TEST_F(WeddingProcess, IsDrivenByTheCommandsOfItsManual) {
  StartActive(LongPose());
  Face();
  ASSERT_TRUE(AwaitShown("TRACKING"));
  Command("photo");
  ASSERT_TRUE(AwaitShown("PHOTO_POSING"));
  Command("stop");
  ASSERT_TRUE(AwaitShown("IDLE"));
  ASSERT_TRUE(voice_->Publish({"photo"}));
  ASSERT_TRUE(AwaitShown("PHOTO_POSING"));
  EXPECT_TRUE(AwaitPose("thumbs_up"));
}

TEST_F(WeddingProcess, StopsForAGuestWhoIsTooCloseAndContinues) {
  StartActive();
  ASSERT_TRUE(too_close_->Publish({true}));
  ASSERT_TRUE(AwaitShown("SAFE_STOP"));
  ASSERT_TRUE(too_close_->Publish({false}));
  ASSERT_TRUE(AwaitShown("IDLE"));
  ASSERT_TRUE(peer_.Until([&] { return !sounds_.empty(); }));
  EXPECT_THAT(sounds_, ElementsAre("too_close"));
}

TEST_F(WeddingProcess, StaysStoppedForOneCameraThoughAnotherReportsNoGuestTooClose) {
  StartActive();
  auto side = Publisher<msg::Bool>("wedding/perception/too_close");
  ASSERT_TRUE(peer_.Until([&] { return side->MatchedReaders() == 1; }));
  ASSERT_TRUE(too_close_->Publish({true}));
  ASSERT_TRUE(AwaitShown("SAFE_STOP"));
  ASSERT_TRUE(side->Publish({false}));
  const std::size_t states = states_.size();
  ASSERT_TRUE(peer_.Until([&] { return states_.size() >= states + 5; })) << "1 s";
  EXPECT_EQ(states_.back(), "SAFE_STOP");
  too_close_.reset();  // this camera exits; its successor replaces it
  side.reset();
  side = Publisher<msg::Bool>("wedding/perception/too_close");
  ASSERT_TRUE(peer_.Until([&] { return side->MatchedReaders() == 1; }));
  ASSERT_TRUE(side->Publish({false}));
  EXPECT_TRUE(AwaitShown("IDLE"));
}

TEST_F(WeddingProcess, AnswersItsServices) {
  StartActive(LongPose());
  Command("photo");
  ASSERT_TRUE(AwaitShown("PHOTO_POSING"));
  const auto idle = Call<msg::SetBool>("wedding/fsm/set_idle", {true});
  EXPECT_TRUE(idle.success);
  EXPECT_EQ(idle.message, "Set to IDLE");
  ASSERT_TRUE(AwaitShown("IDLE"));
  Command("photo");
  ASSERT_TRUE(AwaitShown("PHOTO_POSING"));
  const auto reset = Call<msg::Trigger>("wedding/fsm/reset", {});
  EXPECT_TRUE(reset.success);
  EXPECT_EQ(reset.message, "FSM reset to IDLE");
  ASSERT_TRUE(AwaitShown("IDLE"));
  Command("photo");
  ASSERT_TRUE(AwaitShown("PHOTO_POSING"));
  EXPECT_EQ(Call<msg::Trigger>("wedding/fsm/stop", {}).message, "FSM stop command sent");
  ASSERT_TRUE(AwaitShown("IDLE"));
}

TEST_F(WeddingProcess, HasTheCameraTakeThePictureAtTheShutter) {
  int calls = 0;
  const auto camera = transport::MakeServer<msg::CameraService>(
                          peer_.node(), "camera_service",
                          [&](const msg::CameraService::Request& request, const auto& reply) {
                            EXPECT_EQ(request.command, msg::CameraService::kTakePicture);
                            ++calls;
                            if (calls == 1) return reply({0, "/photos/1.jpg", 0});
                            reply({msg::CameraService::kInvalidState, "the camera is off", 4403});
                          })
                          .value();
  StartActive(std::string(kSeldom) + kFile);
  Command("photo");
  ASSERT_TRUE(AwaitShown("PHOTO_POSING"));
  ASSERT_TRUE(peer_.Until([&] { return calls == 1; })) << peer_.Output();
  ASSERT_TRUE(AwaitShown("TRACKING"));
  Command("photo");
  ASSERT_TRUE(peer_.Until([&] { return calls == 2; }));
  ASSERT_TRUE(AwaitWithFace("TRACKING"));
  EXPECT_TRUE(AwaitOutput("no photo: the camera is off (result 5, 4403")) << peer_.Output();
  EXPECT_THAT(peer_.Output(), HasSubstr("photo 1: /photos/1.jpg"));
}

TEST_F(WeddingProcess, RestsNeutralInEveryOtherStateAndContinuesFromIdle) {
  StartActive(LongPose());
  for (const BuiltInState rest : {kLowPower, kDeActive, kProtected, kOta, kError}) {
    Command("photo");
    ASSERT_TRUE(AwaitShown("PHOTO_POSING")) << rest;
    ASSERT_TRUE(AwaitPose("thumbs_up"));
    ExpectDone(rest);
    ASSERT_TRUE(AwaitPose("neutral")) << rest;
    ASSERT_TRUE(AwaitShown("IDLE")) << rest;
    ASSERT_TRUE(AwaitNoMoreLooks()) << rest;
    EXPECT_EQ(looks_.back().point.x, 0.5) << rest;
    const std::size_t looks = looks_.size();
    const std::size_t states = states_.size();
    Command("photo");
    ASSERT_TRUE(peer_.Until([&] { return states_.size() >= states + 2; }));
    EXPECT_EQ(states_.back(), "IDLE") << rest;
    EXPECT_EQ(looks_.size(), looks) << rest << ": nothing moves it";
    const auto stop = Call<msg::Trigger>("wedding/fsm/stop", {});
    EXPECT_FALSE(stop.success) << rest;
    EXPECT_EQ(stop.message, "the show is paused: there is nothing to stop");
    ExpectDone("Active");
    ASSERT_TRUE(peer_.Until([&] { return looks_.size() > looks; })) << rest;
  }
  EXPECT_THAT(peer_.Output(), HasSubstr("command photo is refused: the show is paused"));
}

TEST_F(WeddingProcess, PublishesNothingDuringAnEmergencyStop) {
  StartActive(LongPose());
  Command("photo");
  ASSERT_TRUE(AwaitPose("thumbs_up"));
  const auto stop =
      Publisher<msg::EmergencyStop>(transport::EmergencyStopTopic(""), transport::kLatchedQos);
  msg::EmergencyStop engaged;
  engaged.id = 1;
  engaged.engaged = true;
  ASSERT_TRUE(stop->Publish(engaged));
  ASSERT_TRUE(AwaitShown("IDLE")) << peer_.Output();
  EXPECT_TRUE(AwaitNoMoreLooks());
  EXPECT_EQ(poses_.back(), "thumbs_up");
}

TEST_F(WeddingProcess, SurvivesTenThousandCommandsAtOnce) {
  StartActive();
  for (int i = 0; i < 10'000; ++i) Command(i % 3 == 0 ? "photo" : i % 3 == 1 ? "dance" : "idle");
  Command("stop");
  ASSERT_TRUE(command_->Flush(std::chrono::seconds(120)));
  // A pose that none of the commands requests.
  const auto guest = peer_.node().loop().Every(Milliseconds(100), [this] {
    Face();
    ASSERT_TRUE(gesture_->Publish({"v"}));
  });
  ASSERT_TRUE(AwaitPose("v_sign")) << "it continues as before";
  EXPECT_LT(peer_.Output().size(), 20'000) << "and has not filled the disk";
}

TEST_F(WeddingProcess, BeginsInIdleAndNeutralAfterItWasKilledInAPose) {
  StartActive();
  ASSERT_TRUE(gesture_->Publish({"v"}));
  ASSERT_TRUE(AwaitWithFace("PHOTO_POSING"));
  ASSERT_TRUE(AwaitPose("v_sign"));
  // So that the status of its successor is known from its own.
  ASSERT_TRUE(peer_.AwaitStatus([](const auto& report) { return report.state == "Active"; }));
  peer_.Signal(SIGKILL);
  ASSERT_EQ(peer_.AwaitExit(), -SIGKILL);
  ASSERT_TRUE(peer_.Until([&] { return subscriptions_.front()->MatchedWriters() == 0; }));
  poses_.Forget();
  states_.Forget();
  StartActive();
  ASSERT_TRUE(peer_.Until([&] { return !poses_.empty(); }));
  EXPECT_EQ(poses_.front(), "neutral");
  EXPECT_EQ(Changes().back(), "IDLE");
}

TEST_F(WeddingProcess, StandsAfterARestartUntilItIsCommanded) {
  std::string file = kFile;
  file.replace(file.find("true"), 4, "false");
  Start(file);
  ExpectDone("Active");
  const auto seen = peer_.node().loop().Every(Milliseconds(100), [this] { Face(); });
  const std::size_t states = states_.size();
  ASSERT_TRUE(peer_.Until([&] { return states_.size() >= states + 10; }));
  EXPECT_TRUE(looks_.empty()) << "a guest stands there, and no person has begun the show";
  EXPECT_EQ(states_.back(), "INVALID");
  const auto started = Call<msg::SendCommand>("wedding/send_command", {"START"});
  EXPECT_TRUE(started.success) << started.message;
  EXPECT_TRUE(AwaitShown("TRACKING"));
}

TEST_F(WeddingProcess, RunsThroughAllStates) {
  Start();
  const auto seen = peer_.node().loop().Every(Milliseconds(100), [this] { Face(); });
  for (const BuiltInState state :
       {kSelfCheck, kActive, kSelfCheck, kDeActive, kProtected, kOta, kError, kSelfCheck}) {
    ExpectDone(state);
  }
  ExpectTornDown();
  EXPECT_TRUE(peer_.Until([&] { return !states_.empty() && states_.back() == "INVALID"; }));
}

TEST_F(WeddingProcess, FailsItsSelfCheckByNameWithoutCameraAudioOrMotion) {
  target_.reset();
  subscriptions_.clear();
  ModuleProcess::Start("[check]\ntime_ms = 100\n");
  EXPECT_THAT(Failure(kSelfCheck),
              ::testing::AllOf(HasSubstr("camera: no publisher of wedding/perception/target"),
                               HasSubstr("audio: no subscriber of wedding/audio/play"),
                               HasSubstr("motion: no subscriber of wedding/motion/pose")));
}

TEST_F(WeddingProcess, RunsWithoutOptionalPartsAndLogsIt) {
  target_.reset();
  subscriptions_.clear();
  ModuleProcess::Start(
      "[check]\ntime_ms = 100\ncamera = \"optional\"\naudio = \"none\"\nmotion = \"none\"\n");
  ExpectDone("SelfCheck");
  EXPECT_THAT(peer_.Output(), HasSubstr("self-check: without camera: no publisher of"));
}

TEST_F(WeddingProcess, FailsItsSelfCheckWithFacesButWithoutTheirPositions) {
  Start("[check]\ntime_ms = 3000\n");
  const auto faces = Publisher<msg::String>("wedding/perception/faces_json");
  ASSERT_TRUE(peer_.Until([&] { return faces->MatchedReaders() == 1; }));
  ExpectDone("SelfCheck");
  target_.reset();
  ASSERT_TRUE(peer_.Until([&] {
    const auto checked = peer_.Switch("SelfCheck");
    return checked && checked.value().message.find("no publisher of wedding/perception/target") !=
                          std::string::npos;
  })) << peer_.Output();
}

TEST_F(WeddingProcess, FailsItsSelfCheckInActiveWhenVisionIsSilent) {
  StartActive("autostart = true\n[check]\ntime_ms = 100\n");
  EXPECT_THAT(Failure(kSelfCheck), HasSubstr("camera: no message on"));
}

}  // namespace musher::wedding::wedding_process_test
