#include "musher/modules/vp_engine/service_robot.hpp"

#include <utility>

namespace musher::vp_engine {
namespace {

constexpr std::int32_t kStoredBehindAnother = 1125;  // a light of higher precedence is shown

Error FailedWith(const std::string& service, std::int32_t code) {
  return {code == 0 ? kCodeFailed : code,
          service + " reports " + std::to_string(code) + (code == 0 ? " and no success" : "")};
}

}  // namespace

void ServiceRobot::Open(transport::Endpoints& topics) {
  calls_.clear();
  speech_ = topics.OpenClient<msg::AudioTextPlay>(config_.speech);
  motion_ = topics.OpenClient<msg::MotionResultCmd>(config_.motion);
  light_ = topics.OpenClient<msg::LedExecute>(config_.light);
}

template <class S, class Verdict>
Robot::Call ServiceRobot::Begin(transport::Client<S>* client, const typename S::Request& request,
                                Duration time, const std::string& service, Verdict verdict) {
  const Call call = ++last_;
  auto& end = calls_[call];
  if (client == nullptr) {
    end = Error{kCodeFailed, service + " is not open"};
    return call;
  }
  client->Call(request, time, [this, call, service, verdict](const auto& reply) {
    const auto found = calls_.find(call);
    if (found == calls_.end()) return;  // forgotten
    found->second =
        reply ? verdict(reply.value())
              : Result<>(Error{reply.error().code, service + ": " + reply.error().message});
  });
  return call;
}

Robot::Call ServiceRobot::Speak(const std::string& text) {
  msg::AudioTextPlay::Request request;
  request.module_name = "vp_engine";
  request.is_online = true;
  request.text = text;
  return Begin(speech_, request, config_.speech_time, config_.speech,
               [service = config_.speech](const msg::AudioTextPlay::Response& reply) -> Result<> {
                 if (reply.status == msg::AudioTextPlay::kFinished) return Ok();
                 return FailedWith(service, reply.code);
               });
}

Robot::Call ServiceRobot::Move(const MotionOrder& order) {
  msg::MotionResultCmd::Request request;
  request.motion_id = order.id;
  request.cmd_source = 2;  // visual programming
  request.duration = order.duration_ms;
  request.vel_des = {order.forwards_mps, order.left_mps, order.turn_radps};
  return Begin(motion_, request, config_.motion_time, config_.motion,
               [service = config_.motion](const msg::MotionResultCmd::Response& reply) -> Result<> {
                 if (reply.result && reply.code == 0) return Ok();
                 return FailedWith(service, reply.code);
               });
}

Robot::Call ServiceRobot::Light(const LightOrder& order) {
  msg::LedExecute::Request request;
  request.occupation = order.on;
  request.client = "vp";
  request.target = order.target;
  request.mode = msg::LedExecute::kUserColor;
  request.effect = order.effect;
  request.r_value = order.red;
  request.g_value = order.green;
  request.b_value = order.blue;
  return Begin(light_, request, config_.light_time, config_.light,
               [service = config_.light](const msg::LedExecute::Response& reply) -> Result<> {
                 if (reply.code == 0 || reply.code == kStoredBehindAnother) return Ok();
                 return FailedWith(service, reply.code);
               });
}

std::optional<Result<>> ServiceRobot::EndOf(Call call) {
  const auto found = calls_.find(call);
  if (found == calls_.end()) return Result<>(Error{kCodeFailed, "the call was dropped"});
  if (!found->second) return std::nullopt;
  std::optional<Result<>> end = std::move(found->second);
  calls_.erase(found);
  return end;
}

}  // namespace musher::vp_engine
