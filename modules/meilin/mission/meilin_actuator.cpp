#include "musher/modules/meilin/mission/meilin_actuator.hpp"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <utility>

#include <nlohmann/json.hpp>

#include "musher/actuator/program/await.hpp"
#include "musher/application/groot2/groot2_server.hpp"
#include "musher/application/load_tree.hpp"
#include "musher/base/break_watch.hpp"
#include "musher/modules/meilin/mission/plan_topic.hpp"
#include "musher/modules/meilin/nodes/drawn_form.hpp"
#include "musher/modules/meilin/nodes/register.hpp"
#include "musher/modules/meilin/plan/box_map_text.hpp"

namespace musher::meilin {
namespace {

constexpr Duration kAskEvery = Milliseconds(500);
constexpr const char* kTakenBefore =
    "a plan that was taken before is not taken again; send it once more to repeat it";
constexpr const char* kHeldUp =
    "the service has not answered for long, and the plan may be as old: look at the robot, then "
    "send it once more";

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
                    .begin = musher::Begin::kOnCommand,
                    .file = config.tree_file,
                    .record = {.file = config.record, .most_bytes = config.record_mib << 20}}),
      config_(WithSide(std::move(config), match)),
      robot_({config_.pose_topic, config_.chassis_topic, config_.wheel_order}),
      mission_(robot_, config_.settings, std::move(match), config_.autostart) {}

Result<> MeilinActuator::RegisterNodes(tree::Factory& factory) {
  return meilin::RegisterNodes(factory, robot_, config_.settings);
}

Result<tree::Document> MeilinActuator::LoadTree() {
  Result<tree::Document> document = TreeActuator::LoadTree();
  if (!document) return document;
  const std::vector<Diagnostic> found = AcceptDrawnForm(document.value());
  if (HasError(found)) return Error{kCodeParametersInvalid, ErrorLines(found)};
  mission_.SetForms(FormsOf(document.value()));
  for (const Diagnostic& each : found) Log(LogLevel::kWarning, FormatDiagnostic(each));
  return document;
}

void MeilinActuator::OpenTopics(transport::Endpoints& topics) {
  robot_.Open(topics, [this](const std::string& text) { Log(LogLevel::kWarning, text); });
  const transport::Qos latched = transport::kLatchedQos;
  status_ = {topics.PublishFunction<msg::String>("meilin/status", latched), "", false};
  state_ = {topics.PublishFunction<msg::String>("meilin/state", latched), "", false};
  error_ = {topics.PublishFunction<msg::String>("meilin/last_error", latched), "", false};
  plan_id_ = {topics.PublishFunction<msg::String>("meilin/plan_id", latched), "", false};
  LoadProgress();  // before the first plan, which may be an old one
  SubscribePlans(topics);
  topics.Serve<msg::StartAutonomy>("start_autonomy", [this](const auto& request, auto reply) {
    const auto answer = [this, reply](const Result<std::string>& begun) {
      LogStart(begun);
      reply({begun.ok(), begun ? begun.value() : begun.error().message});
    };
    if (const Result<> may = MayBegin(); !may) return answer(may.error());
    mission_.StartSoon(request.region, Now(), answer);
    Follow();
  });
  topics.Subscribe<msg::String>("meilin/command",
                                [this](const msg::String& text) { OnCommand(text.data); });
  plans_ =
      config_.plan_service ? topics.OpenClient<msg::GetActionSeq>(config_.buffer_service) : nullptr;
  asking_ = false;
  unanswered_since_.reset();
  Publish();
  if (config_.groot2_port == 0) return;
  const Result<> served = groot2::Serve(
      topics,
      {.port = config_.groot2_port,
       .hooks = config_.groot2_hooks,
       .on_lost = [this] { OnDebuggerLost(); }},
      [this] { return view(); }, factory());
  if (!served) Log(LogLevel::kWarning, served.error().message);
}

void MeilinActuator::SubscribePlans(transport::Endpoints& topics) {
  const std::string& name_space = machine_config().name_space;
  topics.Keep(std::make_shared<PlanTopic<msg::Float32MultiArray>>(
      topics.node(), transport::ResolveName(name_space, config_.action_topic),
      [this](const msg::Float32MultiArray& plan, std::int64_t written_ns, const std::string& late) {
        OnPlan(plan, written_ns, late);
      }));
  topics.Keep(std::make_shared<PlanTopic<msg::String>>(
      topics.node(), transport::ResolveName(name_space, config_.segment_topic),
      [this](const msg::String& text, std::int64_t written_ns, const std::string& late) {
        OnSegments(text.data, written_ns, late);
      }));
  topics.Subscribe<msg::String>(
      config_.map_topic, [this](const msg::String& text) { OnMap(text.data); },
      transport::kLatchedQos);
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
  robot_.Update();
  mission_.BeforeTick(now);
  Follow();
  RequestPlan(now);
}

void MeilinActuator::AfterTick(Time now, tree::Status status) {
  mission_.AfterTick(status, last_fault(), now);
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

void MeilinActuator::OnDebuggerLost() {
  Halt();
  mission_.Stand("its debugger was lost before the match could begin");
  OnPause();
  const char* const regions = mission_.GoesOnWith().empty() ? " full, meilin or final" : "";
  Log(LogLevel::kWarning,
      std::string("Groot2 is lost, and it had hooks: halted until musher-meilin start") + regions);
}

void MeilinActuator::OnBreak() {
  mission_.Stand("its process could not run before the match could begin");
  OnPause();
}

Result<> MeilinActuator::OnStartCommand() {
  const Result<std::string> begun = mission_.Start("", Now());
  LogStart(begun);
  Follow();
  return begun ? Ok() : Result<>(begun.error());
}

Result<> MeilinActuator::MayBegin() const {
  if (ticking()) return CheckNotLate();
  return Error{kCodeStateInvalid, "the match begins in Active only; the robot is in " +
                                      CurrentState() +
                                      (HeldByStop() ? ", held by the emergency stop" : "")};
}

void MeilinActuator::LogStart(const Result<std::string>& begun) {
  Log(begun ? LogLevel::kInfo : LogLevel::kWarning,
      begun ? begun.value() : "the start is refused: " + begun.error().message);
}

void MeilinActuator::OnMap(const std::string& text) {
  const BoxMapReading reading = ReadBoxMapJson(text);
  if (reading.map) return mission_.SetBoxes(*reading.map);
  Log(LogLevel::kWarning, "a map of boxes is ignored: " + reading.faults.front());
}

// Empty: it is not, or it moves nothing before a person says so.
std::string MeilinActuator::WhyLate(const std::string& late) const {
  if (!mission_.begun()) return "";
  if (!late.empty()) return late;
  const Result<> timely = CheckNotLate();
  return timely ? "" : timely.error().message;
}

void MeilinActuator::OnPlan(const msg::Float32MultiArray& plan, std::int64_t written_ns,
                            const std::string& late) {
  if (mission_.WasTaken(written_ns)) return Log(kTakenBefore);
  if (RefusesLate(plan, late)) return;
  LogPlan(mission_.OfferPlan(plan, Now(), written_ns));
}

bool MeilinActuator::RefusesLate(const msg::Float32MultiArray& plan, const std::string& late) {
  const std::string why = WhyLate(late);
  if (why.empty()) return false;
  mission_.RefuseLate(plan, why);
  LogPlan(false);
  return true;
}

// A service that does not forget what it has handed out does so twice a second.
void MeilinActuator::OnHandedOut(const msg::Float32MultiArray& plan, const std::string& late) {
  const std::int64_t number = NumberOf(plan);
  if (!mission_.WasTaken(number)) {
    if (!RefusesLate(plan, late)) LogPlan(mission_.OfferHandedOut(plan, Now()));
    return;
  }
  if (std::exchange(handed_out_again_, number) == number) return;
  Log(LogLevel::kWarning, config_.buffer_service +
                              " hands out a plan that was taken before: it is "
                              "taken again once the service has said that it has none");
}

void MeilinActuator::OnSegments(const std::string& text, std::int64_t written_ns,
                                const std::string& late) {
  if (mission_.WasTaken(written_ns)) return Log(kTakenBefore);
  const std::string why = WhyLate(late);
  if (why.empty()) return LogPlan(mission_.OfferSegments(text, Now(), written_ns));
  mission_.RefusePlan(why);
  LogPlan(false);
}

void MeilinActuator::LogPlan(bool accepted) {
  Log(accepted ? LogLevel::kInfo : LogLevel::kWarning,
      accepted ? "plan " + mission_.plan_id() + " accepted" +
                     (mission_.begun() ? "" : "; it waits for musher-meilin start")
               : "plan refused: " + mission_.refused_plan());
  Follow();
}

void MeilinActuator::OnCommand(const std::string& command) {
  if (command == "RESET") Halt();  // what runs, before the blackboard is made new
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
                 if (!reply) {
                   unanswered_since_ = unanswered_since_.value_or(asked_);
                   return;
                 }
                 const auto since = std::exchange(unanswered_since_, std::nullopt);
                 const bool held_up = since && Now() - *since > BreakWatch::kShortest;
                 if (reply.value().has_data) {
                   return OnHandedOut(reply.value().data, held_up ? kHeldUp : "");
                 }
                 mission_.NothingHandedOut();
                 handed_out_again_ = 0;
               });
}

// The state last: who waits for it then has the rest.
void MeilinActuator::Publish() {
  SaveProgress();
  status_.Set(StatusText());
  error_.Set(mission_.last_error());
  plan_id_.Set(mission_.plan_id());
  state_.Set(mission_.state());
}

std::string MeilinActuator::StatusText() {
  const std::string state = mission_.state();
  const Time now = Now();
  const bool stands = !mission_.begun() || mission_.failed();
  if (state != can_start_state_ || now < can_start_at_ || now - can_start_at_ >= kAskEvery) {
    can_start_ = stands ? mission_.CanStart(now) : std::vector<std::string>();
    can_start_at_ = now;
    can_start_state_ = state;
  }
  nlohmann::ordered_json text = {{"state", state},
                                 {"last_error", mission_.last_error()},
                                 {"plan_id", mission_.plan_id()},
                                 {"refused_plan", mission_.refused_plan()},
                                 {"plans", mission_.plans()},
                                 {"refusals", mission_.refusals()},
                                 {"goes_on_with", mission_.GoesOnWith()},
                                 {"can_start", can_start_},
                                 {"last_end", mission_.last_end()}};
  return text.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

void MeilinActuator::LoadProgress() {
  const std::string& folder = machine_config().state_dir;
  progress_.Open(folder.empty() ? "" : folder + "/" + name() + "_progress.toml");
  std::error_code none;  // a folder that cannot be made is named when a file is written to it
  if (!folder.empty()) std::filesystem::create_directories(folder, none);
  saved_ = progress_.Read();
  if (saved_.empty()) return;
  const Result<Progress> progress = ReadProgress(saved_, progress_.path());
  const Result<> restored =
      progress ? mission_.Restore(progress.value()) : Result<>(progress.error());
  if (!restored) {
    return Log(LogLevel::kWarning, "the progress is not used: " + restored.error().message);
  }
  const std::string rest = mission_.GoesOnWith();
  if (!rest.empty()) Log("the match could go on with " + rest + ": musher-meilin start");
}

void MeilinActuator::SaveProgress() {
  if (progress_.path().empty()) return;
  std::string text = WriteProgress(mission_.SavedProgress());
  if (text == saved_ || text.empty()) return;
  saved_ = std::move(text);
  progress_.Write(saved_);
}

}  // namespace musher::meilin
