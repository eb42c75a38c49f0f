#include "musher/modules/meilin/servers/suspension_server.hpp"
#include "musher/base/words.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace musher::meilin::servers {
namespace {

constexpr std::size_t kHeightsAt = 4;  // in the message of the chassis

template <class Values>
std::vector<float> Floats(const Values& values) {
  return {values.begin(), values.end()};
}

}  // namespace

SuspensionServer::SuspensionServer(const Dependencies& dependencies, SuspensionConfig config)
    : OneGoalServer(dependencies, false), config_(std::move(config)), core_(config_.settings) {}

SuspensionServer::~SuspensionServer() {
  Interrupt("Node shutdown");
}

Result<std::unique_ptr<Server>> SuspensionServer::Make(const Dependencies& dependencies,
                                                       const SuspensionConfig& config) {
  std::unique_ptr<SuspensionServer> server(new SuspensionServer(dependencies, config));
  if (const Result<> opened = server->Open(); !opened) return opened.error();
  return std::unique_ptr<Server>(std::move(server));
}

Result<> SuspensionServer::Open() {
  command_ = endpoints().Advertise<msg::Float32MultiArray>(config_.command);
  state_ = endpoints().Advertise<msg::Int32>(config_.state, transport::kLatchedQos);
  endpoints().Subscribe<msg::Float32MultiArray>(
      config_.chassis, [this](const msg::Float32MultiArray& message) { OnChassis(message); });
  endpoints().Subscribe<msg::Float32MultiArray>(
      config_.distances, [this](const msg::Float32MultiArray& message) { OnDistances(message); });
  Serve(config_.action);
  if (endpoints().opened()) PublishState();
  return endpoints().opened();
}

void SuspensionServer::OnChassis(const msg::Float32MultiArray& message) {
  if (message.data.size() < kHeightsAt + kWheels) {
    return Warn("chassis", fmt::format("a message of {} is ignored: it has {}, expected 12",
                                       config_.chassis, Counted(message.data.size(), "number")));
  }
  std::array<bool, kWheels> switches{};
  WheelHeights heights{};
  for (std::size_t i = 0; i < kWheels; ++i) {
    switches[i] = message.data[config_.switch_order[i]] > 0.5F;
    heights[i] = message.data[kHeightsAt + config_.wheel_order[i]];
  }
  core_.OnChassis(switches, heights, Now());
}

void SuspensionServer::OnDistances(const msg::Float32MultiArray& message) {
  if (message.data.size() < kDistances) {
    return Warn("distances",
                fmt::format("a message of {} is ignored: it has {}, expected 8", config_.distances,
                            Counted(message.data.size(), "number")));
  }
  std::array<double, kDistances> mm{};
  for (std::size_t i = 0; i < kDistances; ++i) mm[i] = message.data[i];
  core_.OnDistances(mm, Now());
}

std::string SuspensionServer::WhyMalformed(const msg::SuspensionControl::Goal& goal) const {
  if (goal.mode > 3) return fmt::format("mode {} is not one of 0 to 3", goal.mode);
  if (goal.direction > 3) return fmt::format("direction {} is not one of 0 to 3", goal.direction);
  if (!std::isfinite(goal.height)) return "height is not a finite number";
  return std::isfinite(goal.timeout_sec) ? "" : "timeout_sec is not a finite number";
}

std::string SuspensionServer::Begin(const msg::SuspensionControl::Goal& goal) {
  SuspensionGoal begun;
  begun.mode = static_cast<SuspensionMode>(goal.mode);
  begun.direction = static_cast<ClimbDirection>(goal.direction);
  begun.height_mm = goal.height;
  begun.limit_s = goal.timeout_sec;
  return core_.Begin(begun, Now());
}

msg::SuspensionControl::Result SuspensionServer::ResultNow() const {
  msg::SuspensionControl::Result result;
  result.final_state = static_cast<std::int32_t>(core_.state());
  result.elapsed_sec = static_cast<float>(core_.ElapsedSeconds(Now()));
  return result;
}

msg::SuspensionControl::Result SuspensionServer::StopWork() {
  msg::SuspensionControl::Result result = ResultNow();
  core_.Stop();
  SendTargets();
  PublishState();
  return result;
}

bool SuspensionServer::Tick() {
  const auto end = core_.Update(Now());
  if (end || core_.running()) SendTargets();
  PublishState();
  if (!end) {
    Report();
    return !core_.running();
  }
  msg::SuspensionControl::Result result = ResultNow();
  result.success = end->success;
  result.message = end->message;
  if (!end->success) {
    Log(LogLevel::kWarning,
        std::string("the sequence has ended in ") + SuspensionStateName(core_.state()));
  }
  Conclude(std::move(result));
  return true;
}

void SuspensionServer::SendTargets() {
  if (!core_.targets()) return;
  msg::Float32MultiArray message;
  message.data.resize(kWheels);
  for (std::size_t i = 0; i < kWheels; ++i) {
    message.data[config_.wheel_order[i]] = static_cast<float>((*core_.targets())[i]);
  }
  static_cast<void>(command_->Publish(message));  // the next one comes soon
}

// 0 while nothing runs: move_to_pose then drives at its own speed.
void SuspensionServer::PublishState() {
  const std::int32_t state = core_.running() ? static_cast<std::int32_t>(core_.state()) : 0;
  if (state == published_) return;
  published_ = state;
  msg::Int32 message;
  message.data = state;
  static_cast<void>(state_->Publish(message));
}

void SuspensionServer::Report() {
  msg::SuspensionControl::Feedback feedback;
  feedback.current_state = static_cast<std::int32_t>(core_.state());
  feedback.elapsed_sec = static_cast<float>(core_.ElapsedSeconds(Now()));
  feedback.distance_data = Floats(core_.distances());
  feedback.photoelectric_data = Floats(core_.switches());
  feedback.wheel_heights_current = Floats(core_.heights());
  feedback.wheel_heights_target = Floats(core_.targets().value_or(core_.heights()));
  Feedback(feedback);
}

std::string SuspensionServer::Missing() const {
  std::string missing;
  const auto add = [&](const std::string& what) {
    missing += (missing.empty() ? "" : "; ") + what;
  };
  const std::string wheels = core_.SilentChassis(Now());
  if (!wheels.empty()) add(wheels + " of the wheels on " + config_.chassis);
  const std::string distances = core_.SilentDistances(Now());
  if (!distances.empty()) add(distances + " of the distances on " + config_.distances);
  if (command_->MatchedReaders() == 0) add("no subscriber of " + config_.command);
  return missing;
}

}  // namespace musher::meilin::servers
