#pragma once
// arm_action and spear_action on the network: a command out, done in, the actions
// r2_interfaces/ArmAction and SpearAction. One goal at a time. Command 0 is sent once the command
// has its first subscriber: the hardware may still work on that of a process before this one.
//
// Threads: the loop's. Runs on any transport.

#include <memory>
#include <string>

#include "musher/messages/r2_interfaces/arm_action.hpp"
#include "musher/messages/r2_interfaces/spear_action.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_msgs/multi_array.hpp"
#include "musher/modules/meilin/servers/one_goal.hpp"
#include "musher/modules/meilin/servers/tool.hpp"

namespace musher::meilin::servers {

struct ToolConfig {
  Duration time_limit{};  // of a goal without one
  std::string action;
  std::string command;        // [command, 0, 0, 0]
  std::string report;         // its first number is 1 when the tool is done
  std::string runtime_state;  // of the arm; empty: not published
};
ToolConfig DefaultArm();
ToolConfig DefaultSpear();

struct ArmConfig : ToolConfig {
  ArmConfig() : ToolConfig(DefaultArm()) {}
};
struct SpearConfig : ToolConfig {
  SpearConfig() : ToolConfig(DefaultSpear()) {}
};

template <msg::Action A>
class ToolServer final : public OneGoalServer<A> {
 public:
  static Result<std::unique_ptr<Server>> Make(const Dependencies& dependencies,
                                              const ToolConfig& config);
  ~ToolServer() override;

  std::string Missing() const override;

 protected:
  std::string WhyMalformed(const typename A::Goal& goal) const override;
  std::string Begin(const typename A::Goal& goal) override;
  typename A::Result StopWork() override;
  std::string CancelText() const override { return "Cancelled"; }
  bool Tick() override;
  Duration Period() const override { return Milliseconds(20); }
  void Forget() override { core_.Forget(); }

 private:
  ToolServer(const Dependencies& dependencies, ToolConfig config);
  Result<> Open();
  void OnMatch();
  void SendIfDue();
  void Send(std::uint8_t command);
  void PublishRuntimeState();
  void Report();
  typename A::Result ResultNow() const;

  const ToolConfig config_;
  Tool core_;
  transport::Publisher<msg::Float32MultiArray>* command_ = nullptr;
  transport::Publisher<msg::Bool>* runtime_state_ = nullptr;
  transport::Subscription* report_ = nullptr;
  bool matched_ = false;  // the command has had a subscriber
};

extern template class ToolServer<msg::ArmAction>;
extern template class ToolServer<msg::SpearAction>;

}  // namespace musher::meilin::servers
