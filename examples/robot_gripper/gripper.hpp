// [head]
#pragma once
// A gripper as a module of the robot.
//
// Threads: state callbacks run on the actuator's worker, everything else on the loop. Data that
// both use is accessed on the loop.

#include <cmath>
#include <fstream>
#include <functional>
#include <string>
#include <thread>
#include <utility>

#include "gripper_config.hpp"
#include "jaw.hpp"
#include "musher/actuator/machine_actuator.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_srvs/set_bool.hpp"
#include "musher/transport/endpoints.hpp"

// Codes of this module are 6100 plus a key: 6109 is "self-check failed".
constexpr auto kGripper = static_cast<musher::ModuleCode>(6100);
// [head end]

// [states]
class Gripper : public musher::MachineActuator {
 public:
  explicit Gripper(const GripperConfig& config = {})
      : MachineActuator("gripper"), config_(config), jaw_(0, config.speed_mm_s) {
    RegisterStateCallback("SetUp", [this] { return SetUp(); });
    RegisterStateCallback("SelfCheck", [this] { return CheckTemperature(); });
    RegisterStateCallback("Active", [this] { return SetPower(true); });
    RegisterStateCallback("Protected", [this] { return Open(); });
    RegisterStateCallback("DeActive", [this] { return SetPower(false); });
    // LowPower, OTA, Error, TearDown
    RegisterStateCallback([this](const musher::State&) { return OpenAndSleep(); });
  }
  // [states end]

  // [seen]
  // For tests.
  bool powered() const { return powered_; }
  bool moves() const { return jaw_.MovesAt(Now()); }
  double width_mm() const { return jaw_.WidthAt(Now()); }
  // [seen end]

  // [estop]
 protected:
  // Runs on the loop, concurrently with any callback.
  void OnEmergencyStop() override {
    jaw_.Halt(Now());
    AnswerWaiting(false, "an emergency stop is engaged");
  }
  // [estop end]

  // [setup]
 private:
  using SetBool = musher::msg::SetBool;
  using Reply = musher::transport::Server<SetBool>::Reply;

  musher::Result<> SetUp() {
    return OpenEndpoints([this](musher::transport::Endpoints& wire) {
      clock_ = &wire.clock();
      publish_width_ = wire.PublishFunction<musher::msg::Float32>("gripper/width_mm");
      wire.Subscribe<musher::msg::Float32>("gripper/wanted_mm", [this](const auto& wanted) {
        const auto begun = Grip(wanted.data);
        if (!begun) Log(begun.error().message);
      });
      wire.Serve<SetBool>("gripper/close", [this](const auto& request, const Reply& reply) {
        OnClose(request.data, reply);
      });
      wire.Every(musher::Milliseconds(50), [this] { Cycle(); });
    });
  }
  // [setup end]

  // [grip]
  // For commands by topic and by service: checks whether the gripper may do this now.
  musher::Result<> Grip(double width_mm) {
    if (auto allowed = Allowed("grip", kGripper); !allowed) return allowed;
    if (!(width_mm >= 0) || width_mm > config_.opening_mm) {
      return musher::Error{
          MakeCode(kGripper, musher::KeyCode::kParametersInvalid),
          "the gripper opens from 0 to " + std::to_string(std::lround(config_.opening_mm)) + " mm"};
    }
    AnswerWaiting(false, "replaced by another command");
    jaw_.MoveTo(width_mm, Now());
    return musher::Ok();
  }
  // [grip end]

  // [service]
  // Replies once the jaw has arrived, which takes seconds: the reply is kept, the loop continues.
  void OnClose(bool close, const Reply& reply) {
    if (auto begun = Grip(close ? 0 : config_.opening_mm); !begun) {
      return reply(
          {false, begun.error().message + " (" + std::to_string(begun.error().code) + ")"});
    }
    waiting_ = reply;
  }

  void Cycle() {
    publish_width_({static_cast<float>(width_mm())});
    if (!moves()) AnswerWaiting(true, "");
  }

  void AnswerWaiting(bool done, const std::string& why) {
    if (const Reply reply = std::exchange(waiting_, nullptr)) reply({done, why});
  }
  // [service end]

  // [open]
  // Releases the object. A callback may block; it checks whether it should stop, and reports its
  // progress by Checkpoint().
  musher::Result<> Open() {
    if (EmergencyStopped()) {
      return musher::Error{MakeCode(kGripper, musher::KeyCode::kStateInvalid),
                           "the gripper does not open during an emergency stop"};
    }
    RunOnLoop([this] {
      AnswerWaiting(false, "the gripper opens");
      jaw_.MoveTo(config_.opening_mm, Now());
    });
    while (Moves()) {
      if (StopRequested()) {
        return musher::Error{MakeCode(kGripper, musher::KeyCode::kTimeout), "still not open"};
      }
      Checkpoint();
      std::this_thread::sleep_for(musher::Milliseconds(10));
    }
    return musher::Ok();
  }
  // [open end]

  // [rest]
  // Without power the jaw can be moved by hand: so an emergency stop ends here, too.
  musher::Result<> OpenAndSleep() {
    if (EmergencyStopped()) return SetPower(false);
    if (auto open = Open(); !open) return open;
    return SetPower(false);
  }

  musher::Result<> SetPower(bool on) {
    RunOnLoop([&] { powered_ = on; });
    return musher::Ok();
  }

  // A thermometer that is easy to break: a file in the robot's folder.
  musher::Result<> CheckTemperature() const {
    int temperature_c = 20;
    std::ifstream("temperature") >> temperature_c;
    if (temperature_c <= config_.hottest_c) return musher::Ok();
    return musher::Error{MakeCode(kGripper, musher::KeyCode::kSelfCheckFailed),
                         "its motor has " + std::to_string(temperature_c) + " °C"};
  }
  // [rest end]

  // [time]
  // The world's time, if the robot uses /clock. A fault test has no wire, and uses the computer's
  // time.
  musher::Time Now() const {
    return clock_ != nullptr ? clock_->Now() : std::chrono::steady_clock::now();
  }
  // [time end]

  // [members]
  bool Moves() {
    bool moves = false;
    RunOnLoop([&] { moves = jaw_.MovesAt(Now()); });
    return moves;
  }

  const GripperConfig config_;
  Jaw jaw_;
  bool powered_ = false;
  Reply waiting_;  // of the caller that is not answered yet
  std::function<void(const musher::msg::Float32&)> publish_width_;
  musher::transport::Clock* clock_ = nullptr;  // from SetUp on
};
// [members end]
