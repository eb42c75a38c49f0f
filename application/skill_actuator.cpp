#include "musher/application/skill_actuator.hpp"

#include <algorithm>
#include <chrono>
#include <functional>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "musher/application/application_impl.hpp"
#include "musher/application/refusal.hpp"
#include "musher/application/saved_skills.hpp"
#include "musher/application/skill_report.hpp"
#include "musher/base/check.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/messages/plan_msgs/skill.hpp"
#include "musher/transport/endpoints.hpp"
#include "musher/transport/goal_id_text.hpp"

namespace musher {
namespace {

using Goal = transport::ServerGoal<msg::SkillExecution>;
using CancelReply = transport::Server<msg::CancelSkill>::Reply;

constexpr std::size_t kLongestName = 80;  // of a requester, in texts

// The request of a goal: the skill and its parameters.
struct Request {
  std::string skill;
  std::vector<std::pair<std::string, std::string>> parameters;
};

Result<Request> RequestOf(const Goal& goal) {
  const auto& skills = goal.goal().skill_request.skill_list;
  if (skills.size() != 1) {
    return Refused<ApplicationRefusal::kNotOneSkill>(skills.size());
  }
  Request request{skills.front().skill, {}};
  for (const msg::SkillParameter& parameter : skills.front().params) {
    request.parameters.emplace_back(parameter.key, parameter.value);
  }
  return request;
}

// ", requested by alice@dog1"; empty: the client does not say who it is.
std::string OfRequester(const std::string& by) {
  return by.empty() ? "" : ", requested by " + by;
}

}  // namespace

class SkillActuator::Impl final : public ApplicationImpl {
 public:
  Impl(SkillActuator& owner, Options options)
      : ApplicationImpl(owner, options.rate_hz), owner_(owner), options_(std::move(options)) {}

  // For calls that are on the loop only.
  Impl& OnLoop() {
    CheckThread();
    return *this;
  }

  skill::Manager& manager() {
    MUSHER_CHECK(manager_ != nullptr, "SetUp of", owner_.name(), "has not run");
    return *manager_;
  }

  Result<> CheckTicking() const {
    if (ticking()) return Ok();
    return Refused<ApplicationRefusal::kRunsNoSkills>(owner_.name(), Whereabouts());
  }
  Result<> CheckMayStart() const {
    Result<> may = CheckTicking();
    return may ? CheckNotLate() : may;
  }

  void CancelAtOnce(const std::string& why) {
    StopTicks();
    if (!manager_) return;
    std::vector<const skill::Run*> runs = manager_->Runs();
    std::erase_if(runs, [](const skill::Run* run) { return !run->running(); });
    manager_->CancelAllNow(why);
    if (!runs.empty()) NoteEndFaults(runs);
    AfterPause();
  }

 private:
  // The goal and the requests that a run replies to, until the run is removed.
  struct Watched {
    std::optional<Goal> goal;          // that has started it, until its end
    std::string shown;                 // the last feedback of the goal
    std::vector<CancelReply> cancels;  // until its end
    msg::SkillFeedback published{};    // last
  };

  Result<> SetUp() override {
    skill::Registry registry;
    if (Result<> registered = owner_.RegisterSkills(registry); !registered) return registered;
    if (registry.All().empty()) {
      return Error{kCodeFailed, "RegisterSkills() has not added a skill"};
    }
    watched_.clear();
    manager_ = std::make_unique<skill::Manager>(registry.All());
    RestoreRuns();
    manager_->OnRemoval([this](const skill::Run& run) { ReportRemoved(run); });
    return Open([this](transport::Endpoints& topics) {
      transport::ActionHandlers<msg::SkillExecution> handlers;
      handlers.start = [this](const Goal& goal) { Start(goal); };
      handlers.cancel = [this](const Goal& goal) { Cancel(goal); };
      topics.ServeAction<msg::SkillExecution>(options_.action, std::move(handlers));
      OpenReports(topics);
      if (saved_) WatchStops(topics);
      owner_.OpenTopics(topics);
    });
  }
  Result<> SelfCheck() override { return owner_.SelfCheck(); }

  void RestoreRuns() {
    saved_.reset();
    if (options_.after_restart == Options::AfterRestart::kForgotten || !owner_.node()) return;
    const std::string& folder = owner_.machine_config().state_dir;
    saved_.emplace(folder + "/" + owner_.name() + "_skills.toml");
    const bool continues = options_.after_restart == Options::AfterRestart::kContinued;
    const auto restored = saved_->Restore(*manager_, continues);
    if (!restored) {
      return owner_.Log(LogLevel::kWarning,
                        "what ran before is not known: " + restored.error().message);
    }
    for (const std::string& line : restored.value()) owner_.Log(LogLevel::kWarning, line);
  }

  // Topics `skill_feedback` and `skills`, and the services for a run.
  void OpenReports(transport::Endpoints& topics) {
    node_ = &topics.node();
    publish_ = topics.PublishFunction<msg::SkillFeedback>("skill_feedback");
    const std::string action =
        "/" + transport::ResolveName(owner_.machine_config().name_space, options_.action);
    topics.PublishFunction<msg::SkillOffers>(
        "skills", transport::kLatchedQos)(OfferSkills(owner_.name(), action, *manager_));
    topics.Serve<msg::GetSkill>(owner_.name() + "/get_skill",
                                [this](const auto& request, auto reply) {
                                  reply(ReportSkill(owner_.name(), *manager_, ticking(), request));
                                });
    topics.Serve<msg::PauseSkill>(
        owner_.name() + "/pause_skill", [this](const auto& request, auto reply) {
          const Result<std::string> done =
              request.pause ? PauseOne(request.skill) : ResumeOne(request.skill);
          msg::PauseSkill::Response response;
          response.success = done.ok();
          response.message = done ? done.value() : done.error().message;
          reply(response);
        });
    topics.Serve<msg::CancelSkill>(
        owner_.name() + "/cancel_skill",
        [this](const auto& request, auto reply) { CancelOne(request, std::move(reply)); });
  }

  // Also of those that came and were released before this process: the last one is latched.
  void WatchStops(transport::Endpoints& topics) {
    topics.SubscribeWithInfo<msg::EmergencyStop>(
        "musher/emergency_stop",
        [this](const msg::EmergencyStop& stop, const transport::SampleInfo& info) {
          const auto of_sample = static_cast<std::uint64_t>(info.written_ns);
          if (saved_) saved_->NoteStop(stop.id == 0 ? of_sample : stop.id, stop.engaged);
        },
        {}, transport::kLatchedFromManyQos);
  }

  // Answers at the end of the run.
  void CancelOne(const msg::CancelSkill::Request& request, CancelReply reply) {
    const std::string why =
        "by " + (request.by.empty() ? "a request" : request.by.substr(0, kLongestName));
    if (const Result<> cancelled = CancelRun(request.skill, why); !cancelled) {
      owner_.Log(LogLevel::kWarning, "cancellation refused: " + cancelled.error().message);
      return reply(CancelAnswer(false, cancelled.error().message));
    }
    owner_.Log(request.skill + ": cancellation requested " + why);
    watched_[manager_->Find(request.skill)->number()].cancels.push_back(std::move(reply));
    if (!ticking()) ReportGoals();
  }

  static msg::CancelSkill::Response CancelAnswer(bool success, std::string message) {
    msg::CancelSkill::Response response;
    response.success = success;
    response.message = std::move(message);
    return response;
  }

  // With the next step, or at once where none comes.
  Result<> CancelRun(const std::string& skill, const std::string& why) {
    return ticking() ? manager_->Cancel(skill, why) : manager_->CancelNow(skill, why);
  }

  void AnswerCancels(const skill::Run& run) {
    if (!run.ended()) return;
    const auto waiting = std::exchange(watched_[run.number()].cancels, {});
    const bool cancelled = run.feedback().status == skill::Status::kCancelled;
    const auto answer = CancelAnswer(cancelled, skill::ToText(run.feedback()));
    for (const CancelReply& reply : waiting) reply(answer);
  }

  // The state in which it was paused.
  Result<std::string> PauseOne(const std::string& skill) {
    const Result<> paused = manager_->Pause(skill, "by a request");
    ReportGoals();
    if (!paused) {
      owner_.Log(LogLevel::kWarning, "pause refused: " + paused.error().message);
      return paused.error();
    }
    const std::string state = manager_->Find(skill)->Path();
    owner_.Log(skill + " paused in " + state);
    return state;
  }

  Result<std::string> ResumeOne(const std::string& skill) {
    Result<> resumed = CheckMayStart();
    if (resumed) resumed = manager_->Resume(skill);
    if (!resumed) {
      owner_.Log(LogLevel::kWarning, "resume refused: " + resumed.error().message);
      return resumed.error();
    }
    SaveRuns();
    const std::string state = manager_->Find(skill)->Path();
    owner_.Log(skill + " goes on from " + state);
    return state;
  }

  Result<> Activate() override {
    if (Result<> checked = CheckNoStop(); !checked) return checked;
    if (ticking()) return Ok();
    if (const std::string over = saved_ ? saved_->TakeOver() : ""; !over.empty()) {
      manager_->CancelAllNow("it does not go on: " + over);
      ReportGoals();
    }
    EndAfterBreak();
    end_faults_.clear();
    StartTicks();
    return Ok();
  }
  void Leave(const State& state) override {
    if (state == kTearDown || state == kError || state == kOta) {
      CancelAtOnce("the robot goes to " + state);
    } else {
      Pause(state);
    }
  }
  std::string StopAtOnce() override {
    CancelAtOnce("emergency stop");
    return end_faults_;
  }

  void Pause(const State& state) {
    if (options_.cancels_when_paused) return CancelAtOnce("the robot goes to " + state);
    StopTicks();
    if (!manager_) return;
    manager_->Pause();
    AfterPause();
  }

  void NoteEndFaults(const std::vector<const skill::Run*>& runs) {
    end_faults_.clear();
    for (const skill::Run* run : runs) {
      const std::string fault = run->EndFault();
      if (!fault.empty()) end_faults_ += (end_faults_.empty() ? "" : "; ") + fault;
    }
    if (end_faults_.empty()) return;
    end_faults_ += "; its outputs may not be neutral";
    owner_.Log(LogLevel::kError, "fault: " + end_faults_);
  }

  void AfterPause() {
    CallOnPause([&] { owner_.OnPause(); });
    ReportGoals();
  }

  void Start(const Goal& goal) {
    const Result<Request> request = RequestOf(goal);
    Result<> started = request ? CheckRobot(goal) : Result<>(request.error());
    if (started) started = CheckMayStart();
    Goal own = goal;
    const std::string by = transport::NameOf(*node_, goal.caller());
    if (started) {
      started = manager_->StartWithTexts(request.value().skill, request.value().parameters,
                                         {transport::GoalIdText(goal.id()), by});
    }
    if (!started) {
      owner_.Log(LogLevel::kWarning,
                 "goal refused" + OfRequester(by) + ": " + started.error().message);
      own.Abort({false, started.error().message});
      return;
    }
    const std::string& skill = request.value().skill;
    owner_.Log(skill + " started" + OfRequester(by));
    own.Execute();
    own.PublishFeedback({"processing: Skill " + skill + " started (0%)"});
    watched_[manager_->Find(skill)->number()].goal = std::move(own);
    SaveRuns();
    PublishChanges();
  }

  Result<> CheckRobot(const Goal& goal) const {
    const std::string& asked = goal.goal().skill_request.robot_id;
    const std::string& own = options_.robot;
    if (own.empty() || asked.empty() || asked == own || asked == owner_.name()) return Ok();
    return Refused<ApplicationRefusal::kOtherRobot>(asked.substr(0, 80), own);
  }

  void Cancel(const Goal& goal) {
    for (const skill::Run* run : manager_->Runs()) {
      const std::optional<Goal>& own = watched_[run->number()].goal;
      if (!own || own->id() != goal.id()) continue;
      static_cast<void>(CancelRun(run->name(), "by its client"));
      if (!ticking()) ReportGoals();
      return;
    }
    Goal own = goal;  // canceled before it was started
    own.Canceled({false, "cancelled: before it was started"});
  }

  // As after a restart: what ran long ago does not go on by itself.
  void EndAfterBreak() {
    const auto could_not_run = TakeLongBreak();
    if (manager_ && could_not_run) manager_->CancelAllNow("it does not go on: " + *could_not_run);
  }

  void Tick() override {
    EndAfterBreak();
    const Time now = Now();
    const auto before = Thrown("BeforeTick", [&] { owner_.BeforeTick(now); });
    if (!before) manager_->RunOnce(now);
    const auto after = Thrown("AfterTick", [&] { owner_.AfterTick(now); });
    for (const auto& thrown : {before, after}) {
      if (!thrown) continue;
      if (manager_->running()) owner_.Log(LogLevel::kError, "fault: " + *thrown);
      manager_->CancelAllNow(*thrown);
    }
    ReportGoals();
  }

  // The feedback of each run that has changed.
  void PublishChanges() {
    for (const skill::Run* run : manager_->Runs()) Publish(*run);
  }

  void Publish(const skill::Run& run) {
    if (!ticks_.open()) return;
    msg::SkillFeedback feedback = ReportRun(owner_.name(), run);
    msg::SkillFeedback& last = watched_[run.number()].published;
    if (feedback == last) return;
    last = feedback;
    feedback.header.stamp = ticks_.Stamp();
    publish_(feedback);
  }

  // Feedback of the goals, and the results of those that have ended.
  void ReportGoals() {
    SaveRuns();
    PublishChanges();
    for (const skill::Run* run : manager_->Runs()) {
      ReportGoal(*run);
      AnswerCancels(*run);
    }
  }

  void SaveRuns() {
    if (!saved_ || !ticks_.open()) return;
    const Result<> saved = saved_->Save(*manager_, Now());
    if (!saved) owner_.Log(LogLevel::kWarning, saved.error().message);
  }

  void ReportGoal(const skill::Run& run) {
    Watched& watched = watched_[run.number()];
    if (!watched.goal) return;
    if (run.ended()) {
      auto goal = std::exchange(watched.goal, std::nullopt);
      return End(run, *goal);
    }
    const std::string text = skill::ToText(run.feedback());
    if (text == watched.shown) return;
    watched.shown = text;
    watched.goal->PublishFeedback({text});
  }

  void ReportRemoved(const skill::Run& run) {
    Publish(run);
    ReportGoal(run);
    AnswerCancels(run);
    watched_.erase(run.number());
  }

  void End(const skill::Run& run, Goal& goal) {
    const skill::Feedback& feedback = run.feedback();
    owner_.Log(run.name() + " " + skill::ToText(feedback));
    const bool completed = feedback.status == skill::Status::kCompleted;
    const msg::SkillExecution::Result result{completed, skill::ToText(feedback)};
    if (completed) {
      goal.Succeed(result);
    } else if (feedback.status == skill::Status::kFailed || !goal.Canceled(result)) {
      goal.Abort(result);
    }
  }

  SkillActuator& owner_;
  const Options options_;
  std::unique_ptr<skill::Manager> manager_;
  const transport::Node* node_ = nullptr;                   // of the endpoints
  std::function<void(const msg::SkillFeedback&)> publish_;  // while the ticks are open
  std::map<std::uint64_t, Watched> watched_;                // by the number of the run
  std::optional<SavedSkills> saved_;                        // nothing: they are not saved
  std::string end_faults_;  // of the skills that were ended at once, until the next Active
};

SkillActuator::SkillActuator(const std::string& actuator_name, const Options& options)
    : MachineActuator(actuator_name), impl_(std::make_unique<Impl>(*this, options)) {
  RegisterStateCallback([this](const State& state) { return impl_->Run(state); });
}

SkillActuator::~SkillActuator() {
  CheckStopped(name(), started());
}

skill::Manager& SkillActuator::manager() {
  return impl_->OnLoop().manager();
}
void SkillActuator::CancelSkills(const std::string& why) {
  impl_->OnLoop().CancelAtOnce(why);
}
bool SkillActuator::ticking() const {
  return impl_->OnLoop().ticking();
}
Result<> SkillActuator::CheckTicking() const {
  return impl_->OnLoop().CheckTicking();
}
Result<> SkillActuator::CheckMayStart() const {
  return impl_->OnLoop().CheckMayStart();
}
Time SkillActuator::Now() const {
  return impl_->OnLoop().Now();
}

void SkillActuator::OnEmergencyStop() {
  impl_->OnEmergencyStop();
}

}  // namespace musher
