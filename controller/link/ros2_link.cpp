#include "musher/controller/link/ros2_link.hpp"

#include <algorithm>
#include <utility>

#include "musher/base/code.hpp"

namespace musher {
namespace {

// The period of get_state until the node replies, and the timeout of each call.
constexpr Duration kLookPeriod = Milliseconds(500);
constexpr Duration kLookTimeout = std::chrono::seconds(10);
// A node publishes the event of a transition's end before the reply; the time the reply may take.
constexpr Duration kReplyGrace = Milliseconds(50);
// A node that is unconfigured for so long has not received the request to configure.
constexpr Duration kSetUpTimeout = std::chrono::seconds(2);
// Less than the coordinator's timeout of a query.
constexpr Duration kStateQueryTimeout = Milliseconds(200);

// How long the first of two nodes with one name may take to answer.
constexpr Duration kCompareTimeout = std::chrono::seconds(1);

std::string Is(Ros2State state) {
  return "the node is " + std::string(Ros2StateName(state));
}

}  // namespace

Result<std::unique_ptr<ActuatorLink>> Ros2Link::Make(transport::Node& node,
                                                     const MachineConfig& config,
                                                     ActuatorIndex actuator, Emit emit) {
  std::unique_ptr<Ros2Link> link(new Ros2Link(node, config, actuator, std::move(emit)));
  if (auto opened = link->Open(); !opened) return opened.error();
  return std::unique_ptr<ActuatorLink>(std::move(link));
}

Result<> Ros2Link::Open() {
  const std::string name = transport::ResolveName(machine().name_space, actuator().name);
  auto change = transport::MakeClient<msg::ChangeState>(node(), name + "/change_state",
                                                        [this] { OnMatchChanged(); });
  if (!change) return change.error();
  change_ = std::move(change).value();
  auto get = transport::MakeClient<msg::GetState>(node(), name + "/get_state",
                                                  [this] { OnMatchChanged(); });
  if (!get) return get.error();
  get_ = std::move(get).value();
  auto events = transport::MakeSubscription<msg::TransitionEvent>(
      node(), name + "/transition_event",
      [this](const msg::TransitionEvent& event, const transport::SampleInfo& info) {
        OnEvent(event, info);
      });
  if (!events) return events.error();
  events_ = std::move(events).value();
  return Ok();
}

// A node is available when both services are matched.
void Ros2Link::OnMatchChanged() {
  if (!change_ || !get_) return;
  std::vector<transport::ParticipantId> servers = change_->Servers();
  const std::vector<transport::ParticipantId> others = get_->Servers();
  std::erase_if(servers, [&](transport::ParticipantId server) {
    return std::find(others.begin(), others.end(), server) == others.end();
  });
  OnServers(std::move(servers));
}

void Ros2Link::OnAppeared() {
  report().target = State(kSetUp);
  ReportStatus();
  Look();
}

// Whether the first node still answers. In a callback it need not.
void Ros2Link::Compare() {
  get_->Call(
      {}, kCompareTimeout,
      [this, first = server()](const Result<msg::GetState::Response>& reply) {
        if (first != server()) return;
        if (!reply && MayBeInCallback()) return Compare();
        EndComparison(reply.ok());
      },
      server());
}

void Ros2Link::OnLost() {
  ++era_;
  known_ = Ros2State::kUnknown;
  set_up_ = step_over_ = stray_ = strayed_ = mute_ = false;
  step_.reset();
  queries_.clear();
  look_ = nullptr;
}

void Ros2Link::Drive() {
  steps_done_ = 0;
  // A command that needs no transition is not done before get_state confirms the state.
  if (pending()->target == kSelfCheck || known_ == GoalOf(pending()->target)) return Look();
  Proceed();
}

// For a node in a callback the answer is given long before the health monitor misses it.
void Ros2Link::Inquire(const QueryCommand& query) {
  const Duration in_callback =
      std::min(kStateQueryTimeout, actuator().checkpoint.value_or(kStateQueryTimeout) / 4);
  const std::uint64_t serial = next_query_++;
  queries_.push_back(
      {query.number, serial, Now() + kStateQueryTimeout, QueryTimer(serial, Now() + in_callback)});
  Look();
}

transport::LoopHandlePtr Ros2Link::QueryTimer(std::uint64_t serial, Time when) {
  return node().loop().At(when, [this, serial] { OnQueryUnanswered(serial); });
}

void Ros2Link::OnQueryUnanswered(std::uint64_t serial) {
  const auto query = std::find_if(queries_.begin(), queries_.end(),
                                  [&](const PendingQuery& one) { return one.serial == serial; });
  if (query == queries_.end()) return;
  if (!MayBeInCallback() && Now() < query->until) {
    query->timeout = QueryTimer(serial, query->until);
    return;
  }
  const CommandNumber number = query->number;
  queries_.erase(query);
  if (MayBeInCallback()) return AnswerQuery(number);
  mute_ = true;
}

// During a callback the node's only thread replies to no query. After the deadline of the command
// it must answer within its checkpoint, if it has one.
bool Ros2Link::MayBeInCallback() const {
  if (!step_) return false;
  const auto checkpoint = actuator().checkpoint;
  const bool set_up = pending() && pending()->number == 0;  // the coordinator limits its time
  return !checkpoint || !pending() || set_up || Now() < pending()->deadline + *checkpoint;
}

void Ros2Link::AnswerQueries() {
  for (const PendingQuery& query : std::exchange(queries_, {})) AnswerQuery(query.number);
}

void Ros2Link::LookAt(Time when) {
  look_ = node().loop().At(when, [this] { Look(); });
}

void Ros2Link::Look() {
  LookAt(Now() + kLookPeriod);
  get_->Call(
      {}, kLookTimeout,
      [this, era = era_](const Result<msg::GetState::Response>& reply) {
        if (reply && era == era_) OnLooked(static_cast<Ros2State>(reply.value().current_state.id));
      },
      server());
}

void Ros2Link::OnLooked(Ros2State state) {
  const bool revived = std::exchange(mute_, false);
  look_ = nullptr;
  if (!IsPrimary(state)) {
    LookAt(Now() + kLookPeriod);
    if (revived) ReportStatus();
    return AnswerQueries();
  }
  const Ros2State before = std::exchange(known_, state);
  if (pending()) {
    OnLookedWhileDriving();
    if (revived) ReportStatus();
  } else if (before == Ros2State::kUnknown) {
    OnFirstLook();
  } else {
    OnLookedWhileFree(before, revived);
  }
  AnswerQueries();
}

void Ros2Link::OnFirstLook() {
  const bool may_be_adopted = !ours() && known_ != Ros2State::kUnconfigured;
  const auto adopted = may_be_adopted ? AdoptedState(known_) : std::nullopt;
  if (!adopted) return BeginSetUp(kSetUpTimeout);
  set_up_ = true;
  report().target = {};
  report().state = *adopted;
  ReportStatus();
}

void Ros2Link::OnLookedWhileDriving() {
  if (!step_) return Proceed();
  const Ros2Transition step = *step_;
  if (known_ == step.to) {
    step_.reset();
    ++steps_done_;
    ++era_;
    return Proceed();
  }
  if (known_ != step.from || step_over_) {
    return Finish(Verdict::kFailed, kCodeFailed,
                  std::string(step.name) + " failed; " + Is(known_) + " now");
  }
  // It may not have begun yet. The coordinator does not query a superseded command.
  const bool over = pending()->queried || pending()->stopped || Now() >= pending()->deadline;
  if (!over) return LookAt(Now() + kLookPeriod);
  if (pending()->number == 0) return BeginSetUp(kSetUpTimeout);
  stray_ = true;
  if (steps_done_ > 0) {
    return Finish(Verdict::kFailed, kCodeTimeout,
                  std::string(step.name) + " has not begun; " + Is(known_));
  }
  step_.reset();
  ++era_;
  look_ = nullptr;
  DropPending();
}

void Ros2Link::OnLookedWhileFree(Ros2State before, bool revived) {
  const bool strayed = stray_ && (known_ != before || strayed_);
  if (known_ == before && !strayed && !revived) return;
  if (!set_up_ && known_ == Ros2State::kInactive) {  // another client has configured it
    set_up_ = true;
    report().state = State(kSetUp);
  } else {
    report().state = StateIn(known_);
  }
  if (revived && report().state == machine().default_state) {
    set_up_ = false;
    return BeginSetUp(kSetUpTimeout);
  }
  if (strayed) {
    stray_ = strayed_ = false;
    report().target = report().state;
    ReportStatus();
    report().target = {};
  }
  ReportStatus();
}

void Ros2Link::OnEvent(const msg::TransitionEvent& event, const transport::SampleInfo& info) {
  const auto from = static_cast<Ros2State>(event.start_state.id);
  const auto to = static_cast<Ros2State>(event.goal_state.id);
  if (!available() || info.participant != server() || !IsPrimary(to)) return;
  if (step_) {
    if (from != step_->by && from != Ros2State::kErrorProcessing)
      return;  // event of an earlier step
    step_over_ = true;
    LookAt(Now() + kReplyGrace);
  } else if (!pending() && known_ != Ros2State::kUnknown && to != known_) {
    Look();
  }
}

void Ros2Link::Proceed() {
  const Ros2State goal = GoalNow();
  if (known_ == goal) return Finish(Verdict::kDone);
  if (pending()->stopped || has_waiting()) {
    return Finish(Verdict::kFailed, kCodeTimeout, "stopped on its way; " + Is(known_));
  }
  const auto step = NextTransition(known_, goal);
  if (!step) {
    return Finish(Verdict::kFailed, kCodeStateInvalid,
                  Is(known_) + "; only a new start brings it back: " +
                      (actuator().command.empty() ? "start it again where it was started"
                                                  : "musher restart " + actuator().name));
  }
  Transit(*step);
}

// For the command under way. A SelfCheck keeps the primary state, unless the node has left its
// configuration.
Ros2State Ros2Link::GoalNow() const {
  if (pending()->target != kSelfCheck) return GoalOf(pending()->target);
  const State& at = report().state;
  const bool may_stay = known_ == Ros2State::kInactive || known_ == Ros2State::kActive ||
                        (at != machine().default_state && known_ == GoalOf(at));
  return may_stay ? known_ : Ros2State::kInactive;
}

void Ros2Link::Transit(const Ros2Transition& step) {
  step_ = step;
  step_over_ = false;
  ++era_;
  LookAt(Now() + kLookPeriod);
  change_->Call(
      {{step.id, ""}}, kCallTimeout,
      [this, era = era_](const Result<msg::ChangeState::Response>& reply) {
        if (era == era_) return OnChanged(reply);
        if (!stray_) return;
        strayed_ = true;
        if (!pending()) Look();
      },
      server());
}

void Ros2Link::OnChanged(const Result<msg::ChangeState::Response>& reply) {
  if (reply && reply.value().success) {
    known_ = step_->to;
    step_.reset();
    ++steps_done_;
    ++era_;
    look_ = nullptr;
    return Proceed();
  }
  // It may have failed, or the node was already in that state: get_state shows it.
  step_over_ = true;
  Look();
}

void Ros2Link::Finish(Verdict verdict, std::int32_t code, const std::string& message) {
  step_.reset();
  step_over_ = false;
  ++era_;
  look_ = nullptr;
  if (verdict == Verdict::kDone) {
    set_up_ = true;
    if (report().state == machine().default_state) report().state = State(kSetUp);
  } else {
    report().state = StateIn(known_);
  }
  auto queries = std::exchange(queries_, {});
  End(verdict, code, message);
  for (const PendingQuery& query : queries) AnswerQuery(query.number);
}

// The state of an actuator whose node is in `state`: its last one, if that maps to `state`.
State Ros2Link::StateIn(Ros2State state) const {
  if (state == Ros2State::kFinalized) return State(kTearDown);
  const State& last = report().state;
  if (!set_up_) return machine().default_state;
  if (last != machine().default_state && GoalOf(last) == state) return last;
  return AdoptedState(state).value_or(machine().default_state);
}

// A primary state may stand for several states of the config. DeActive is taken, else the least
// active one, so that adoption activates nothing. Never Error.
std::optional<State> Ros2Link::AdoptedState(Ros2State state) const {
  std::optional<State> least;
  for (const State& candidate : actuator().states) {
    const auto rank = machine().RankOf(candidate);
    if (!rank || candidate == kError || candidate == kTearDown || GoalOf(candidate) != state) {
      continue;
    }
    if (candidate == kDeActive) return candidate;
    if (!least || *rank < *machine().RankOf(*least)) least = candidate;
  }
  return least;
}

}  // namespace musher
