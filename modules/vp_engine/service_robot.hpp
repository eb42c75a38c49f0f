#pragma once
// A robot behind the services of CyberDog's audio, motion and device modules. A service that no
// process offers is waited for until the time of its call is over.
//
// Threads: the loop.

#include <map>

#include "musher/messages/protocol/audio.hpp"
#include "musher/messages/protocol/device.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/modules/vp_engine/robot.hpp"
#include "musher/modules/vp_engine/vp_config.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::vp_engine {

class ServiceRobot final : public Robot {
 public:
  explicit ServiceRobot(const VpConfig& config) : config_(config) {}

  // The endpoints must be dropped before this object. Before this, every call fails.
  void Open(transport::Endpoints& topics);

  Call Speak(const std::string& text) override;
  Call Move(const MotionOrder& order) override;
  Call Light(const LightOrder& order) override;
  std::optional<Result<>> EndOf(Call call) override;
  void Forget(Call call) override { calls_.erase(call); }

 private:
  // `verdict` makes a Result<> of the reply.
  template <class S, class Verdict>
  Call Begin(transport::Client<S>* client, const typename S::Request& request, Duration time,
             const std::string& service, Verdict verdict);

  const VpConfig config_;
  transport::Client<msg::AudioTextPlay>* speech_ = nullptr;
  transport::Client<msg::MotionResultCmd>* motion_ = nullptr;
  transport::Client<msg::LedExecute>* light_ = nullptr;
  std::map<Call, std::optional<Result<>>> calls_;
  Call last_ = 0;
};

}  // namespace musher::vp_engine
