#pragma once
// suspension_control on the network: switches, wheel heights and distances in, wheel heights out,
// an action r2_interfaces/SuspensionControl. One goal at a time.
//
// Threads: the loop's. Runs on any transport.

#include <memory>
#include <string>

#include "musher/messages/r2_interfaces/suspension_control.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_msgs/multi_array.hpp"
#include "musher/modules/meilin/servers/one_goal.hpp"
#include "musher/modules/meilin/servers/suspension.hpp"

namespace musher::meilin::servers {

struct SuspensionConfig {
  SuspensionSettings settings;
  // Where front-left, front-right, rear-left and rear-right are in the messages of the hardware.
  Corners wheel_order{0, 1, 2, 3};
  Corners switch_order{0, 1, 2, 3};
  std::string action = "suspension_control";
  std::string command = "t0x0102_action";
  std::string chassis = "r0x0201";
  std::string distances = "sensor_distances";
  std::string state = "current_state";
};

class SuspensionServer final : public OneGoalServer<msg::SuspensionControl> {
 public:
  static Result<std::unique_ptr<Server>> Make(const Dependencies& dependencies,
                                              const SuspensionConfig& config);
  ~SuspensionServer() override;

  std::string Missing() const override;

 protected:
  std::string WhyMalformed(const msg::SuspensionControl::Goal& goal) const override;
  std::string Begin(const msg::SuspensionControl::Goal& goal) override;
  msg::SuspensionControl::Result StopWork() override;
  std::string CancelText() const override { return "Cancelled"; }
  bool Tick() override;
  Duration Period() const override { return Milliseconds(10); }
  void Forget() override { core_.Forget(); }

 private:
  SuspensionServer(const Dependencies& dependencies, SuspensionConfig config);
  Result<> Open();
  void OnChassis(const msg::Float32MultiArray& message);
  void OnDistances(const msg::Float32MultiArray& message);
  void SendTargets();
  void PublishState();
  void Report();
  msg::SuspensionControl::Result ResultNow() const;

  const SuspensionConfig config_;
  Suspension core_;
  transport::Publisher<msg::Float32MultiArray>* command_ = nullptr;
  transport::Publisher<msg::Int32>* state_ = nullptr;
  std::int32_t published_ = -1;  // of the states
};

}  // namespace musher::meilin::servers
