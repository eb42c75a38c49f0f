// A race with an empty battery, by the real programs: the controller's rule of the battery takes
// the machine to LowPower, and the race stands. What it does when the battery is charged is
// robot.resume of its course.

#include <gmock/gmock.h>

#include <fstream>
#include <memory>

#include "musher/messages/protocol/device.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/support/machine_fixture.hpp"
#include "musher/test/support/wait.hpp"
#include "musher/transport/dds/node_thread.hpp"
#include "musher/transport/service.hpp"

namespace musher::testing::race_battery_test {

// A walk that takes minutes.
std::string CourseText(const std::string& resume) {
  return R"(
start = "START"
end = "END"
error = "ERROR"
stand = "stand"
[robot]
audio = "none"
self_check_ms = 20000
resume = ")" +
         resume + R"("
[body]
silent_ms = 30000
[movement.forward]
motion = 303
twist = [0.4, 0.0, 0.0]
[movement.stand]
motion = 111
[state.START]
number = 0
next = "DRIVE"
[state.DRIVE]
number = 1
steps = [{ move = "forward", count = 5000 }]
next = "END"
[state.END]
number = 2
[state.ERROR]
number = 3
)";
}

class EmptyBattery : public MachineFixture {
 protected:
  EmptyBattery() {
    const std::string states =
        R"(["SetUp", "TearDown", "SelfCheck", "Active", "Protected", "LowPower"])";
    std::ofstream(config_) << "[controller]\nname = \"robot\"\nactuators = [\"race\"]\nstates = "
                           << states
                           << "\ndefault_time = 5000\ndefault_state = \"Uninitialized\"\n"
                              "namespace = \""
                           << name_space_ << "\"\nstate_dir = \"state\"\n"
                           << "[policy.battery]\nraise_after_s = 0\n"
                           << "[actuator.race]\nstates = " << states
                           << "\ntimes = [60000, 20000, 30000, 20000, 20000, 20000]\n"
                              "command = [\"musher-race\", \"course.toml\"]\ncwd = \".\"\n";
    node_->RunOnLoop([this] { OpenBody(); });
  }
  ~EmptyBattery() override {
    node_->RunOnLoop([this] {
      ticker_.reset();
      command_.reset();
      status_.reset();
      battery_.reset();
      motion_.reset();
      servo_.reset();
    });
  }

  void OpenBody() {
    transport::Node& node = node_->node();
    const auto name = [this](const char* topic) { return name_space_ + "/" + topic; };
    command_ =
        transport::MakePublisher<msg::String>(node, name("state_machine/start_command")).value();
    status_ = transport::MakePublisher<msg::MotionStatus>(node, name("motion_status")).value();
    battery_ = transport::MakePublisher<msg::BmsStatus>(node, name("bms_status")).value();
    motion_ = transport::MakeServer<msg::MotionResultCmd>(
                  node, name("motion_result_cmd"),
                  [](const auto& request, const auto& reply, auto) {
                    reply({request.motion_id, true, 0});
                  })
                  .value();
    servo_ = transport::MakeSubscription<msg::MotionServoCmd>(
                 node, name("motion_servo_cmd"),
                 [this](const msg::MotionServoCmd& frame, const auto&) {
                   walks_ = frame.cmd_type != msg::MotionServoCmd::kEnd;
                   if (walks_) ++frames_;
                 })
                 .value();
    ticker_ = node_->loop().Every(Milliseconds(50), [this] {
      ++reports_;
      static_cast<void>(status_->Publish({}));
      msg::BmsStatus status;
      status.batt_soc = percent_;
      status.power_normal = true;
      status.power_wired_charging = charges_;
      static_cast<void>(battery_->Publish(status));
    });
  }

  // Up, and under way.
  void Walk(const std::string& resume) {
    std::ofstream(folder_ / "course.toml") << CourseText(resume);
    const Ended up = UpDetached(config_);
    ASSERT_EQ(up.exit, 0) << up.err;
    AwaitStatus([](const nlohmann::json& status) { return status["state"] == "Active"; });
    ASSERT_TRUE(testing::Until([this] {
      int readers = 0;
      node_->RunOnLoop([&] { readers = command_->MatchedReaders(); });
      return readers > 0;
    }));
    node_->RunOnLoop([this] { static_cast<void>(command_->Publish({"START"})); });
    ASSERT_TRUE(testing::Until([this] { return Frames() > 10; }));
  }
  void Charge(int percent, bool charges) {
    node_->RunOnLoop([this, percent, charges] {
      percent_ = static_cast<std::uint8_t>(percent);
      charges_ = charges;
    });
  }
  static void Await(const std::string& state) {
    AwaitStatus([&](const nlohmann::json& status) { return status["state"] == state; });
  }
  int Frames() {
    int frames = 0;
    node_->RunOnLoop([&] { frames = frames_; });
    return frames;
  }
  // What was under way has arrived then: the end of the stream, or a second is over.
  void AwaitEndOfStream() {
    int begin = 0;
    node_->RunOnLoop([&] { begin = reports_; });
    EXPECT_TRUE(testing::Until([&] {
      bool ended = false;
      node_->RunOnLoop([&] { ended = !walks_ || reports_ >= begin + 20; });
      return ended;
    }));
  }
  // The frames that come during the next `reports` of the body, 20 of which are a second.
  int FramesDuring(int reports) {
    int begin = 0;
    int frames = 0;
    node_->RunOnLoop([&] {
      begin = reports_;
      frames = frames_;
    });
    EXPECT_TRUE(testing::Until([&] {
      int now = 0;
      node_->RunOnLoop([&] { now = reports_; });
      return now >= begin + reports;
    }));
    return Frames() - frames;
  }

  const std::string config_ = folder_ / "robot.toml";
  std::shared_ptr<transport::NodeThread> node_ = transport::NodeThread::Start().value();
  // On the loop.
  std::uint8_t percent_ = 80;
  bool charges_ = false;
  bool walks_ = false;
  int frames_ = 0;
  int reports_ = 0;
  std::unique_ptr<transport::Publisher<msg::String>> command_;
  std::unique_ptr<transport::Publisher<msg::MotionStatus>> status_;
  std::unique_ptr<transport::Publisher<msg::BmsStatus>> battery_;
  std::unique_ptr<transport::Server<msg::MotionResultCmd>> motion_;
  std::unique_ptr<transport::Subscription> servo_;
  transport::LoopHandlePtr ticker_;
};

TEST_F(EmptyBattery, OfARaceStopsItAndChargedItStandsInItsStart) {
  ASSERT_NO_FATAL_FAILURE(Walk("start"));
  Charge(4, false);
  Await("LowPower");
  AwaitEndOfStream();
  EXPECT_EQ(FramesDuring(30), 0) << "it walks on";
  node_->RunOnLoop([this] { EXPECT_FALSE(walks_) << "its stream has no end"; });
  Charge(80, true);
  Await("Active");
  EXPECT_EQ(FramesDuring(30), 0) << "it moves by itself";
  node_->RunOnLoop([this] { static_cast<void>(command_->Publish({"START"})); });
  EXPECT_TRUE(testing::Until([this] { return FramesDuring(2) > 0; }));
}

TEST_F(EmptyBattery, ThatWasReplacedIsFollowedByTheRestWhereItWas) {
  ASSERT_NO_FATAL_FAILURE(Walk("where_it_was"));
  Charge(4, false);
  Await("LowPower");
  AwaitEndOfStream();
  EXPECT_EQ(FramesDuring(20), 0) << "it walks on";
  Charge(80, false);
  Await("Active");
  EXPECT_TRUE(testing::Until([this] { return FramesDuring(2) > 0; }));
}

// It walked off from its charger by itself.
TEST_F(EmptyBattery, ThatWasChargedIsFollowedByTheRestOnlyAfterStart) {
  ASSERT_NO_FATAL_FAILURE(Walk("where_it_was"));
  Charge(4, false);
  Await("LowPower");
  AwaitEndOfStream();
  Charge(80, true);
  Await("Active");
  EXPECT_EQ(FramesDuring(30), 0) << "it moves by itself";
  node_->RunOnLoop([this] { static_cast<void>(command_->Publish({"START"})); });
  EXPECT_TRUE(testing::Until([this] { return FramesDuring(2) > 0; }));
}

}  // namespace musher::testing::race_battery_test
