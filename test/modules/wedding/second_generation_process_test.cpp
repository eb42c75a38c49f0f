// The second generation's topics, on the real program.

#include "musher/messages/protocol/camera.hpp"
#include "musher/test/modules/wedding/wedding_process.hpp"

namespace musher::wedding::second_generation_process_test {

using ::testing::HasSubstr;

class SecondGenerationProcess : public WeddingProcess {
 protected:
  // kFile, with `check` in its table of that name.
  static std::string File(const std::string& check) {
    std::string file = kFile;
    const std::string time = "time_ms = 15000\n";
    file.replace(file.find(time), time.size(), check.empty() ? time : check);
    return "second_generation = true\n" + file + "[search]\nenabled = true\n" +
           "[interview]\nenabled = true\nvideo = true\n[actions]\nenabled = true\n";
  }
  void SetUp() override {
    WeddingProcess::SetUp();
    Subscribe("wedding/motion/set_pose", set_poses_);
    Subscribe("wedding/motion/set_motion", set_motions_);
    Subscribe("wedding/fsm/target_face_id", faces_);
    Subscribe("wedding/fsm/debug_log", lines_);
  }
  bool Await(Words& words, const std::string& word) {
    return peer_.Until([&] { return words.Find(word); });
  }

  Words set_poses_;
  Words set_motions_;
  Words faces_;
  Words lines_;
};

TEST_F(SecondGenerationProcess, PublishesItsPoseItsMotionItsTargetAndItsLog) {
  const auto faces = Publisher<msg::String>(
      "wedding/perception/faces_json",
      {transport::Qos::Reliability::kBestEffort, transport::Qos::Durability::kVolatile, 1});
  StartActive(File(""));
  EXPECT_TRUE(Await(set_motions_, "sway_normal")) << peer_.Output();
  EXPECT_TRUE(Await(set_poses_, "neutral"));
  EXPECT_TRUE(Await(faces_, "-1"));
  const auto seen = peer_.node().loop().Every(Milliseconds(100), [&] {
    static_cast<void>(faces->Publish(
        {R"({"faces": [{"is_frontal": true, "area": 0.1, "center_x": 0.5, "center_y": 0.5,
             "face_id": 7}]})"}));
  });
  Command("tracking");
  EXPECT_TRUE(Await(set_motions_, "track_face"));
  EXPECT_TRUE(Await(faces_, "7"));
  Command("dance");
  EXPECT_TRUE(peer_.Until([&] {
    return std::ranges::any_of(lines_, [](const std::string& line) {
      return line.starts_with("[") && line.find("'dance'") != std::string::npos;
    });
  }));
}

TEST_F(SecondGenerationProcess, HasTheCameraRecordAnInterview) {
  std::vector<int> calls;
  const auto camera = transport::MakeServer<msg::CameraService>(
                          peer_.node(), "camera_service",
                          [&](const msg::CameraService::Request& request, const auto& reply) {
                            calls.push_back(request.command);
                            reply({0, "/videos/1.avi", 0});
                          })
                          .value();
  StartActive(File(""));
  Command("tracking");
  ASSERT_TRUE(AwaitWithFace("TRACKING"));
  Command("interview");
  ASSERT_TRUE(AwaitWithFace("INTERVIEW"));
  ASSERT_TRUE(peer_.Until([&] { return calls.size() == 1; })) << peer_.Output();
  EXPECT_EQ(calls[0], msg::CameraService::kStartRecording);
  Command("stop");
  ASSERT_TRUE(peer_.Until([&] { return calls.size() == 2; })) << peer_.Output();
  EXPECT_EQ(calls[1], msg::CameraService::kStopRecording);
}

TEST_F(SecondGenerationProcess, IsNotReadyUntilTheBodyReportsIt) {
  Start(File("time_ms = 3000\nready = \"required\"\n"));
  EXPECT_THAT(Failure(kSelfCheck), HasSubstr("wedding/system/ready is not true"));
  const auto ready = Publisher<msg::Bool>("wedding/system/ready", transport::kLatchedQos);
  ASSERT_TRUE(ready->Publish({true}));
  ASSERT_TRUE(peer_.Until([&] { return ready->MatchedReaders() == 1; }));
  ExpectDone("SelfCheck");
}

}  // namespace musher::wedding::second_generation_process_test
