// A wedding whose process could not run for a while: what it does with the commands that waited.
// The actuator with the real controller, on /clock.

#include <gmock/gmock.h>

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "musher/messages/std_msgs/string.hpp"
#include "musher/modules/wedding/wedding_robot.hpp"
#include "musher/test/application/show.hpp"
#include "musher/test/application/suspended_thread.hpp"
#include "musher/test/support/refusals.hpp"

namespace musher::wedding::break_test {

// Alone: it needs no camera, body or voice. Its poses do not end by themselves.
WeddingConfig Alone() {
  WeddingConfig config;
  config.autostart = true;
  config.camera_service.clear();
  config.self_check_time = Milliseconds(200);
  config.camera = config.audio = config.motion = Need::kNone;
  config.show.photo.pose = std::chrono::hours(1);
  return config;
}

// With the name of the harness's config.
class Played : public WeddingRobot {
 public:
  Played() : WeddingRobot("show", Alone()) {}
  template <class Look>
  auto Of(Look look) {
    decltype(look(*this)) found{};
    RunOnLoop([&] { found = look(*this); });
    return found;
  }
  std::string Path() {
    return Of([](Played& show) { return show.machine().Path(); });
  }
  bool IsTimely() {
    return Of([](Played& show) { return show.CheckNotLate().ok(); });
  }
  bool HasRefusedAsLate() {
    return Of([](Played& show) {
      return testing::HasSentence(show.log_, ApplicationRefusal::kMayBeLate, false);
    });
  }
  using WeddingRobot::Now;

 private:
  void Log(const std::string& line) override { log_ += line + "\n"; }

  std::string log_;
};

class AWeddingAfterASuspension : public ::testing::Test {
 protected:
  AWeddingAfterASuspension() {
    Loop([this] {
      transport::Node& node = harness_.node().node();
      command_ = transport::MakePublisher<msg::String>(node, "wedding/fsm/command").value();
      voice_ = transport::MakePublisher<msg::String>(node, "wedding/audio/voice_command").value();
    });
  }
  ~AWeddingAfterASuspension() override {
    Loop([this] {
      voice_.reset();
      command_.reset();
    });
  }
  void SetUp() override {
    harness_.Open(show_, thread_);
    ASSERT_TRUE(Go("SelfCheck"));
    ASSERT_TRUE(Go("Active"));
    ASSERT_TRUE(testing::Until([this] {
      bool matched = false;
      Loop([&] { matched = command_->MatchedReaders() == 1 && voice_->MatchedReaders() == 1; });
      return matched;
    }));
    ASSERT_EQ(show_.Path(), "IDLE");
  }

  using Words = transport::Publisher<msg::String>;
  void Loop(const std::function<void()>& work) { harness_.node().RunOnLoop(work); }
  bool Go(const State& state) { return harness_.controller().Switch(state).done(); }
  void Send(Words& words, const std::string& word) {
    Loop([&] { EXPECT_TRUE(words.Publish({word})); });
  }
  bool AwaitPath(const std::string& path) {
    return testing::Until([&] {
      harness_.Tick(show_, 1);
      return show_.Path() == path;
    });
  }
  // A command that waited begins nothing; the same one does once it cannot be late.
  void ExpectBeginsWhenTimelyOnly(Words& words) {
    thread_->SuspendEachTime(std::chrono::seconds(9));
    Send(words, "photo");
    ASSERT_TRUE(testing::Until([this] { return show_.HasRefusedAsLate(); }));
    thread_->SuspendEachTime({});
    harness_.Tick(show_, 10);
    EXPECT_EQ(show_.Path(), "IDLE");
    ASSERT_TRUE(testing::Until([this] { return show_.IsTimely(); }));
    Send(words, "photo");
    EXPECT_TRUE(AwaitPath("PHOTO_POSING"));
  }

  testing::Harness harness_;
  const std::shared_ptr<testing::SuspendedThread> thread_ =
      std::make_shared<testing::SuspendedThread>();
  ActuatorRunner<Played> show_;
  std::unique_ptr<Words> command_;
  std::unique_ptr<Words> voice_;
};

// It posed when the computer was opened, by a command of hours ago.
TEST_F(AWeddingAfterASuspension, BeginsNothingByACommandThatWaitedMeanwhile) {
  ExpectBeginsWhenTimelyOnly(*command_);
}

TEST_F(AWeddingAfterASuspension, BeginsNothingByAVoiceCommandThatWaitedMeanwhile) {
  ExpectBeginsWhenTimelyOnly(*voice_);
}

TEST_F(AWeddingAfterASuspension, IsStoppedByACommandThatWaitedMeanwhile) {
  Send(*command_, "photo");
  ASSERT_TRUE(AwaitPath("PHOTO_POSING"));
  thread_->SuspendEachTime(std::chrono::seconds(9));
  Send(*command_, "stop");
  EXPECT_TRUE(AwaitPath("IDLE"));
}

TEST_F(AWeddingAfterASuspension, DoesNotGoOnWithAPoseOfLongAgo) {
  Send(*command_, "photo");
  ASSERT_TRUE(AwaitPath("PHOTO_POSING"));
  thread_->Suspend(std::chrono::minutes(2));
  harness_.Tick(show_, 2);
  EXPECT_EQ(show_.Path(), "IDLE");
}

}  // namespace musher::wedding::break_test
