#include "musher/behavior/fsm/nested.hpp"

#include <algorithm>
#include <utility>

#include "musher/base/check.hpp"

namespace musher::fsm {

Nested::Nested(std::unique_ptr<Machine> inner, std::string start)
    : Nested(std::move(inner), std::move(start), Options{}) {}

Nested::Nested(std::unique_ptr<Machine> inner, std::string start, Options options)
    : inner_(std::move(inner)), start_(std::move(start)), options_(std::move(options)) {
  MUSHER_CHECK(inner_ != nullptr);
}

Nested::~Nested() = default;

void Nested::Declare(Transitions& transitions) {
  if (!inner_built_) {  // Build() of the outer machine may be repeated
    if (const Result<> built = inner_->Build(start_); !built)
      return transitions.Refuse(built.error().message);
    inner_built_ = true;
  }
  if (!options_.finished.empty()) {
    finished_transition_ = transitions.To(options_.finished, "finished");
    const auto is_final = [](const Chart::Node& node) { return node.role == Role::kFinal; };
    if (std::ranges::none_of(inner_->chart().states, is_final)) {
      transitions.Refuse("never goes to " + options_.finished + ": " + inner_->name() +
                         " has no final state");
    }
  }
  for (std::size_t i = 0; i < inner_->event_count(); ++i) {
    const auto event = static_cast<EventId>(i);
    const std::optional<EventId> outer = transitions.Find(inner_->Name(event));
    if (!outer) continue;
    inner_events_.resize(std::max(inner_events_.size(), Index(*outer) + 1), kNoEvent);
    inner_events_[Index(*outer)] = event;
  }
}

void Nested::OnEnter(const Tick& tick) {
  const StateId at = options_.resumes && left_in_ ? *left_in_ : inner_->chart().start;
  if (!inner_->StartAt(at, Time(tick.now))) ThrowIfStopped();
}

void Nested::Run(const Tick& tick) {
  inner_->RunOnce(Time(tick.now));
  ThrowIfStopped();
}

Next Nested::CheckTransition(const Tick& tick) {
  const Next decided = Decide(tick);
  if (!decided.stays()) return decided;
  if (finished() && finished_transition_ != kNoState) {
    const Next on = Next::To(finished_transition_);
    return decided.handles() ? on : on.KeepCommand();
  }
  if (decided.handles() || decided.keeps()) return decided;
  if (Index(tick.command) >= inner_events_.size()) return decided;
  const EventId event = inner_events_[Index(tick.command)];
  if (event == kNoEvent) return decided;
  // The transition may lead to a final state, in which the command would not be handled.
  if (inner_->mode() == Mode::kTransitioning) return decided.KeepCommand();
  return inner_->Send(event) ? Next::Handle() : decided;
}

void Nested::OnExit(const Tick& /*tick*/) {
  left_in_.reset();
  if (inner_->running() && inner_role() == Role::kNormal) left_in_ = inner_->current();
  if (!inner_->Stop()) throw InnerFault(*inner_->fault());
}

void Nested::Persist(Archive& archive) {
  std::string name(left_in_ ? inner_->Name(*left_in_) : "");
  archive.Field("left_in", name);
  left_in_ = inner_->FindState(name);
}

bool Nested::finished() const {
  return inner_->running() && inner_role() == Role::kFinal;
}

Role Nested::inner_role() const {
  return inner_->chart().states[Index(inner_->current())].role;
}

void Nested::ThrowIfStopped() const {
  if (!inner_->running() && inner_->fault()) throw InnerFault(*inner_->fault());
}

}  // namespace musher::fsm
