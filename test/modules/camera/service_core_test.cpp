// The decision of camera_service on a request.

#include "musher/modules/camera/service_core.hpp"

#include <gmock/gmock.h>

#include <string>
#include <vector>

namespace musher::camera::service_core_test {

using msg::CameraService;

const ServiceState kReady = {true, std::nullopt, false, false};

CameraService::Response Refused(const CameraService::Request& request,
                                const ServiceState& state = kReady) {
  const Decision decision = Decide(request, state, {});
  const auto* refusal = std::get_if<CameraService::Response>(&decision);
  EXPECT_NE(refusal, nullptr) << int{request.command} << " " << request.args;
  return refusal == nullptr ? CameraService::Response{} : *refusal;
}

TEST(CameraService, ExecutesItsCommands) {
  EXPECT_EQ(Decide({0, "", 320, 240, 5}, kReady, {}), Decision(SetShape{{320, 240, 5}}));
  EXPECT_EQ(Decide({1, "a.jpg", 0, 0, 0}, kReady, {320, 240, 5}),
            Decision(TakePicture{{320, 240, 5}, "a.jpg"}));
  EXPECT_EQ(Decide({2, "", 640, 480, 0}, kReady, {320, 240, 5}),
            Decision(StartRecording{{640, 480, 5}, ""}));
  EXPECT_EQ(Decide({4, "", 0, 0, 0}, kReady, {}), Decision(ReportState{}));
  EXPECT_EQ(Decide({5, "a.jpg", 0, 0, 0}, kReady, {}), Decision(DeleteFile{"a.jpg"}));
  EXPECT_EQ(Decide({6, "", 0, 0, 0}, kReady, {}), Decision(ListFiles{}));
  EXPECT_EQ(Decide({9, "", 640, 480, 0}, kReady, {320, 240, 5}),
            Decision(StartImage{{640, 480, 0}}))
      << "fps 0 is as the source has it";
}

TEST(CameraService, RefusesWhatIsUnsupportedOrUndefinedWithItsResultAndCode) {
  EXPECT_EQ(Refused({7, "", 0, 0, 0}).result, CameraService::kUnsupported);
  EXPECT_THAT(Refused({7, "", 0, 0, 0}).msg,
              ::testing::StartsWith("command 7 (start live) is not supported"));
  EXPECT_THAT(Refused({8, "", 0, 0, 0}).msg,
              ::testing::StartsWith("command 8 (stop live) is not supported"));
  EXPECT_EQ(Refused({8, "", 0, 0, 0}).code, 4408);
  EXPECT_EQ(Refused({11, "", 0, 0, 0}).result, CameraService::kUndefined);
  EXPECT_EQ(Refused({255, "", 0, 0, 0}).result, CameraService::kUndefined);
}

TEST(CameraService, RefusesImpossibleSizes) {
  for (const CameraService::Request& request :
       {CameraService::Request{9, "", 640, 0, 0}, CameraService::Request{9, "", 0, 480, 0},
        CameraService::Request{1, "", 5000, 480, 0}, CameraService::Request{2, "", 641, 480, 0},
        CameraService::Request{0, "", 640, 480, 1000}}) {
    const auto refusal = Refused(request);
    EXPECT_EQ(refusal.result, CameraService::kInvalidArguments) << refusal.msg;
    EXPECT_EQ(refusal.code, 4410);
  }
}

TEST(CameraService, NeverLeavesItsFolder) {
  const std::vector<std::string> names = {
      "../passwd", "/etc/passwd", "a/../../b.jpg", "..",       ".",
      "",          ".hidden",     "a\\b.jpg",      "a\nb.jpg", std::string(1000, 'a')};
  for (const std::string& name : names) {
    EXPECT_TRUE(FaultOfName(name)) << name;
    EXPECT_EQ(Refused({5, name, 0, 0, 0}).result, CameraService::kInvalidArguments) << name;
    if (name.empty()) continue;  // for a new picture: one by the time
    EXPECT_EQ(Refused({1, name, 0, 0, 0}).result, CameraService::kInvalidArguments) << name;
    EXPECT_EQ(Refused({2, name, 0, 0, 0}).result, CameraService::kInvalidArguments) << name;
  }
  EXPECT_TRUE(FaultOfName(std::string("a\0b", 3)));
  EXPECT_FALSE(FaultOfName("a b-c_1.jpg"));
  EXPECT_EQ(Refused({1, "script.sh", 0, 0, 0}).result, CameraService::kInvalidArguments);
  EXPECT_EQ(Refused({2, "video.jpg", 0, 0, 0}).result, CameraService::kInvalidArguments);
}

TEST(CameraService, BeginsNothingWhileTheCameraIsOffButEndsAndLooks) {
  const ServiceState off = {false, std::nullopt, true, true};
  for (const auto command : {CameraService::kTakePicture, CameraService::kStartRecording,
                             CameraService::kStartImagePublish}) {
    EXPECT_EQ(Refused({command, "", 0, 0, 0}, off).result, CameraService::kInvalidState);
    EXPECT_EQ(Refused({command, "", 0, 0, 0}, off).code, 4403);
  }
  EXPECT_EQ(Decide({3, "", 0, 0, 0}, off, {}), Decision(StopRecording{}));
  EXPECT_EQ(Decide({10, "", 0, 0, 0}, off, {}), Decision(StopImage{}));
  EXPECT_EQ(Decide({6, "", 0, 0, 0}, off, {}), Decision(ListFiles{}));
}

TEST(CameraService, RefusesWithTheReasonAndCodeOfTheMachine) {
  ServiceState gated = kReady;
  gated.refusal = Error{4413, "the battery is too low"};
  const auto refusal = Refused({1, "", 0, 0, 0}, gated);
  EXPECT_EQ(refusal, (CameraService::Response{CameraService::kInvalidState,
                                              "the battery is too low", 4413}));
}

TEST(CameraService, RecordsOneVideoAtATime) {
  ServiceState recording = kReady;
  recording.recording = true;
  EXPECT_EQ(Refused({2, "", 0, 0, 0}, recording).result, CameraService::kBusy);
  EXPECT_EQ(Refused({2, "", 0, 0, 0}, recording).code, 4411);
  EXPECT_EQ(Refused({3, "", 0, 0, 0}).result, CameraService::kInvalidState);
  EXPECT_EQ(Refused({10, "", 0, 0, 0}).result, CameraService::kInvalidState);
}

}  // namespace musher::camera::service_core_test
