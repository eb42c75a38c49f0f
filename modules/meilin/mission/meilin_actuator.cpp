#include "musher/modules/meilin/mission/meilin_actuator.hpp"

#include <chrono>
#include <utility>

#include "musher/actuator/program/await.hpp"
#include "musher/application/groot2/groot2_server.hpp"
#include "musher/modules/meilin/nodes/register.hpp"
#include "musher/modules/meilin/plan/segments_json.hpp"

namespace musher::meilin {
namespace {

constexpr Duration kAskEvery = Milliseconds(500);

MissionConfig WithSide(MissionConfig config, const MatchConfig& match) {
  if (match.side) config.settings.grid.side = *match.side;
  return config;
}

}  // namespace

void MeilinActuator::Status::Set(const std::string& text) {
  if ((sent && last == text) || !publish) return;
  publish({text});
  last = text;
  sent = true;
}

MeilinActuator::MeilinActuator(const std::string& name, MissionConfig config, MatchConfig match)
    : TreeActuator(name,
                   {.rate_hz = config.tick_frequency_hz,
                    .file = config.tree_file,
                    .record = {.file = config.record, .most_bytes = config.record_mib << 20}}),
      config_(WithSide(std::move(config), match)),
      robot_(config_.pose_topic),
      mission_(robot_, config_.settings, std::move(match)) {}

Result<> MeilinActuator::RegisterNodes(tree::Factory& factory) {
  return meilin::RegisterNodes(factory, robot_, config_.settings);
}

void MeilinActuator::OpenTopics(transport::Endpoints& topics) {
  robot_.Open(topics, [this](const std::string& text) { Log(LogLevel::kWarning, text); });
  const transport::Qos latched = transport::kLatchedQos;
  state_ = {topics.PublishFunction<msg::String>("meilin/state", latched), "", false};
  error_ = {topics.PublishFunction<msg::String>("meilin/last_error", latched), "", false};
  plan_id_ = {topics.PublishFunction<msg::String>("meilin/plan_id", latched), "", false};
  topics.Subscribe<msg::Float32MultiArray>(
      config_.action_topic, [this](const msg::Float32MultiArray& plan) { OnPlan(plan); }, latched);
  topics.Subscribe<msg::String>(
      config_.segment_topic, [this](const msg::String& text) { OnSegments(text.data); }, latched);
  topics.Subscribe<msg::String>("meilin/command",
                                [this](const msg::String& text) { OnCommand(text.data); });
  plans_ =
      config_.plan_service ? topics.OpenClient<msg::GetActionSeq>(config_.buffer_service) : nullptr;
  asking_ = false;
  Publish();
  if (config_.groot2_port == 0) return;
  const Result<> served = groot2::Serve(
      topics, {.port = config_.groot2_port, .hooks = config_.groot2_hooks},
      [this] { return view(); }, factory());
  if (!served) Log(LogLevel::kWarning, served.error().message);
}

Result<> MeilinActuator::SelfCheck() {
  const auto here = node();
  if (!here) return Ok();  // a fault-injection test: there is no transport
  const std::chrono::duration<double> time(config_.self_check_s);
  return program::AwaitOnLoop(
      *here, std::chrono::duration_cast<Duration>(time),
      [this]() -> Result<> {
        const std::string missing = robot_.Missing();
        if (missing.empty()) return Ok();
        return Error{kCodeFailed, missing};
      },
      [this] { return StopRequested(); });
}

void MeilinActuator::BeforeTick(Time now) {
  robot_.Tend();
  mission_.BeforeTick();
  RequestPlan(now);
}

void MeilinActuator::AfterTick(Time, tree::Status status) {
  mission_.AfterTick(status, last_fault());
  Publish();
}

void MeilinActuator::OnPause() {
  mission_.OnPause();
  robot_.CancelAll();
  Follow();
  Publish();
}

void MeilinActuator::OnResume() {
  robot_.CancelAll();
}

void MeilinActuator::OnPlan(const msg::Float32MultiArray& plan) {
  const bool accepted = mission_.OfferPlan(plan, Now());
  Log(accepted ? LogLevel::kInfo : LogLevel::kWarning,
      accepted ? "plan " + mission_.plan_id() + " accepted"
               : "plan refused: " + mission_.last_error());
  Follow();
}

void MeilinActuator::OnSegments(const std::string& text) {
  SegmentsReading reading = ReadSegmentsJson(text);
  for (const std::string& warning : reading.warnings) Log(LogLevel::kWarning, warning);
  if (reading.ok()) {
    mission_.OfferSegments(std::move(reading.segments), reading.plan_id);
  } else {
    mission_.RefusePlan(reading.message());
    Log(LogLevel::kWarning, "plan refused: " + reading.message());
  }
  Follow();
}

void MeilinActuator::OnCommand(const std::string& command) {
  if (command == "RESET") Restart();  // halts what runs, before the blackboard is made new
  const Result<> done = mission_.Command(command);
  Log(done ? LogLevel::kInfo : LogLevel::kWarning,
      done ? command : "command refused: " + done.error().message);
  Follow();
}

void MeilinActuator::Follow() {
  if (mission_.TakeRestart()) Restart();
  if (mission_.TakeStop()) Halt();
  Publish();
}

void MeilinActuator::RequestPlan(Time now) {
  if (plans_ == nullptr || asking_ || !mission_.WantsPlan()) return;
  if (now >= asked_ && now - asked_ < kAskEvery) return;
  asked_ = now;
  asking_ = true;
  plans_->Call({}, std::chrono::seconds(2),
               [this](const Result<msg::GetActionSeq::Response>& reply) {
                 asking_ = false;
                 if (reply && reply.value().has_data) OnPlan(reply.value().data);
               });
}

void MeilinActuator::Publish() {
  state_.Set(mission_.state());
  error_.Set(mission_.last_error());
  plan_id_.Set(mission_.plan_id());
}

}  // namespace musher::meilin
