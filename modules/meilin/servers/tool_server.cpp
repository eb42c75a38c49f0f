#include "musher/modules/meilin/servers/tool_server.hpp"

#include <fmt/format.h>

#include <cmath>
#include <type_traits>
#include <utility>

namespace musher::meilin::servers {
namespace {

// A client that waits for the next true of the arm, as the robot's own tree does, gets one soon.
constexpr Duration kRuntimeStatePeriod = Milliseconds(200);

template <msg::Action A>
const ToolKind& KindOf() {
  return std::is_same_v<A, msg::ArmAction> ? ArmKind() : SpearKind();
}

}  // namespace

ToolConfig DefaultArm() {
  return {Milliseconds(10'000), "arm_action", "t0x0103_", "r0x0203", "arm_runtime_state"};
}

ToolConfig DefaultSpear() {
  return {Milliseconds(5000), "spear_action", "t0x0104_", "r0x0204", ""};
}

template <msg::Action A>
ToolServer<A>::ToolServer(const Dependencies& dependencies, ToolConfig config)
    : OneGoalServer<A>(dependencies, false),
      config_(std::move(config)),
      core_(KindOf<A>(), config_.time_limit) {}

template <msg::Action A>
ToolServer<A>::~ToolServer() {
  this->Interrupt("Node shutdown");
}

template <msg::Action A>
Result<std::unique_ptr<Server>> ToolServer<A>::Make(const Dependencies& dependencies,
                                                    const ToolConfig& config) {
  std::unique_ptr<ToolServer> server(new ToolServer(dependencies, config));
  if (const Result<> opened = server->Open(); !opened) return opened.error();
  return std::unique_ptr<Server>(std::move(server));
}

template <msg::Action A>
Result<> ToolServer<A>::Open() {
  auto& endpoints = this->endpoints();
  command_ = endpoints.template Advertise<msg::Float32MultiArray>(
      config_.command, transport::kDefaultQos, {.on_match_changed = [this] { OnMatch(); }});
  report_ = endpoints.template Subscribe<msg::Float32MultiArray>(
      config_.report, [this](const msg::Float32MultiArray& message) {
        if (!message.data.empty()) core_.OnReport(message.data[0]);
      });
  if (!config_.runtime_state.empty()) {
    runtime_state_ =
        endpoints.template Advertise<msg::Bool>(config_.runtime_state, transport::kLatchedQos);
    endpoints.Every(kRuntimeStatePeriod, [this] { PublishRuntimeState(); });
  }
  this->Serve(config_.action);
  if (endpoints.opened()) PublishRuntimeState();
  return endpoints.opened();
}

template <msg::Action A>
void ToolServer<A>::OnMatch() {
  if (matched_ || command_->MatchedReaders() == 0) return;
  matched_ = true;
  if (this->busy()) return;
  Send(0);
  core_.AwaitIdle(this->Now());
}

template <msg::Action A>
std::string ToolServer<A>::WhyMalformed(const typename A::Goal& goal) const {
  const auto& commands = core_.kind().commands;
  if (goal.command >= commands.size()) {
    return fmt::format("command {} is not one of 0 to {}", goal.command, commands.size() - 1);
  }
  return std::isfinite(goal.timeout_sec) ? "" : "timeout_sec is not a finite number";
}

template <msg::Action A>
std::string ToolServer<A>::Begin(const typename A::Goal& goal) {
  core_.Begin(goal.command, goal.timeout_sec, this->Now());
  SendIfDue();
  PublishRuntimeState();
  return "";
}

template <msg::Action A>
typename A::Result ToolServer<A>::ResultNow() const {
  typename A::Result result;
  result.elapsed_sec = static_cast<float>(core_.ElapsedSeconds(this->Now()));
  if constexpr (requires { result.final_state; }) result.final_state = core_.state();
  return result;
}

template <msg::Action A>
typename A::Result ToolServer<A>::StopWork() {
  core_.Stop(this->Now());
  Send(0);
  PublishRuntimeState();
  return ResultNow();
}

template <msg::Action A>
bool ToolServer<A>::Tick() {
  SendIfDue();
  const auto end = core_.Update(this->Now());
  Report();
  if (!end) return !core_.running();
  if (!end->success) Send(0);
  PublishRuntimeState();
  typename A::Result result = ResultNow();
  result.success = end->success;
  result.message = end->message;
  this->Conclude(std::move(result));
  return true;
}

template <msg::Action A>
void ToolServer<A>::SendIfDue() {
  if (core_.TakeDue(this->Now())) Send(core_.command());
}

template <msg::Action A>
void ToolServer<A>::Send(std::uint8_t command) {
  msg::Float32MultiArray message;
  message.data = {static_cast<float>(command), 0, 0, 0};
  const Result<> sent = command_->Publish(message);
  if (!sent) this->Warn("command", "a command is not sent: " + sent.error().message);
}

template <msg::Action A>
void ToolServer<A>::PublishRuntimeState() {
  if (runtime_state_ == nullptr) return;
  msg::Bool state;
  state.data = core_.IsIdleAndWell(this->Now());
  static_cast<void>(runtime_state_->Publish(state));  // the next one comes soon
}

template <msg::Action A>
void ToolServer<A>::Report() {
  typename A::Feedback feedback;
  feedback.current_state = core_.state();
  feedback.progress = static_cast<float>(core_.Progress(this->Now()));
  if constexpr (requires { feedback.message; }) {
    feedback.message = core_.kind().commands[core_.command()].name;
  }
  this->Feedback(feedback);
}

template <msg::Action A>
std::string ToolServer<A>::Missing() const {
  if (report_->MatchedWriters() == 0) return "no publisher of " + config_.report;
  return command_->MatchedReaders() > 0 ? "" : "no subscriber of " + config_.command;
}

template class ToolServer<msg::ArmAction>;
template class ToolServer<msg::SpearAction>;

}  // namespace musher::meilin::servers
