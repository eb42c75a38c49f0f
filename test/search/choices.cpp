// What may happen next.

#include <algorithm>
#include <utility>

#include "musher/test/search/harness.hpp"

namespace musher::search {
namespace {

bool Expects(const World& world, const Actor& actor) {
  const auto& tokens = actor.core.running_for;
  return std::any_of(tokens.begin(), tokens.end(),
                     [&](RequestToken token) { return (token & 127) == world.generation + 1; });
}

class Listing {
 public:
  Listing(const Model& model, const World& world) : model_(model), world_(world) {}

  std::vector<Choice> Make() && {
    if (!world_.outbox.empty()) {
      ListSending();
      return std::move(choices_);
    }
    ListStop();
    if (world_.at_start) {
      Free(Deed::kAsk);
      if (world_.stop_seen_due) Free(Deed::kSeeStop);
      return std::move(choices_);
    }
    for (std::size_t i = 0; i < kActuators; ++i) ListActuator(i);
    if (world_.stop_seen_due && Leads()) Free(Deed::kSeeStop);
    ListTime();
    if (world_.faults_left > 0 && Leads()) {
      Fault(Deed::kRestart);
      Fault(Deed::kAskError);
      if (world_.machine.phase != Phase::kStopping) Fault(Deed::kAskTearDown);
    }
    return std::move(choices_);
  }

 private:
  bool Leads() const { return world_.machine.phase != Phase::kStopped; }

  void Free(Deed deed, std::size_t i = 0, std::size_t index = 0) {
    choices_.push_back({deed, static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(index), 0});
  }
  void Fault(Deed deed, std::size_t i = 0) {
    if (world_.faults_left > 0) choices_.push_back({deed, static_cast<std::uint8_t>(i), 0, 1});
  }

  void ListStop() {
    if (world_.stopped || !Leads()) return;
    Fault(Deed::kEngageStop);
    for (std::size_t i = 0; i < kActuators && world_.faults_left > 1; ++i) {
      if (!world_.actors[i].alive) continue;
      choices_.push_back({Deed::kEngageStopLate, static_cast<std::uint8_t>(i), 0, 2});
    }
  }

  void ListSending() {
    const Message& first = world_.outbox.front();
    const Actor& actor = world_.actors[first.to];
    Free(Deed::kDeliver, first.to);
    ListStop();
    Fault(Deed::kRestart);
    if (!actor.alive || !actor.visible) return;
    Fault(Deed::kLose, first.to);
    Fault(Deed::kHold, first.to);
    Fault(Deed::kDouble, first.to);
    if (actor.core.controller != first.sender) Fault(Deed::kUnheard, first.to);
  }

  void ListActuator(std::size_t i) {
    const Actor& actor = world_.actors[i];
    if (actor.end) Free(Deed::kEnd, i);
    for (std::size_t k = 0; k < actor.late.size(); ++k) Free(Deed::kLate, i, k);
    if (!actor.replies.empty()) {
      Free(Deed::kReply, i);
      for (const Deed d : {Deed::kReplyHeld, Deed::kReplyDoubled}) Fault(d, i);
      // The last word of a dead process may be lost with it.
      actor.alive ? Fault(Deed::kReplyLost, i) : Free(Deed::kReplyLost, i);
    }
    if (actor.status_due) {
      Free(Deed::kStatus, i);
      Fault(Deed::kStatusLost, i);
      Fault(Deed::kStatusHeld, i);
      Fault(Deed::kStatusDoubled, i);
    }
    if (!actor.alive) return;
    Fault(Deed::kCrash, i);
    if (actor.work == Work::kNone) return;
    Free(Deed::kEndOk, i);
    if (actor.core.report.target == kTearDown) Free(Deed::kEndFirst, i);
    Fault(Deed::kEndFailed, i);
    if (actor.work == Work::kOverdue && actor.stop_requested) Free(Deed::kEndAsked, i);
    if (!Expects(world_, actor) || !actor.replies.empty()) return;
    if (actor.core.report.target != kTearDown) Fault(Deed::kEndCrash, i);
    Fault(Deed::kEndReplyLost, i);
    Fault(Deed::kEndReplyHeld, i);
    Fault(Deed::kEndReplyDoubled, i);
  }

  // Time passes when nothing is on its way; what still runs then is overdue.
  void ListTime() {
    if (world_.stop_seen_due && Leads()) return;
    std::uint8_t cost = 0;
    for (const Actor& actor : world_.actors) {
      if (actor.end || actor.status_due || !actor.replies.empty()) return;
      if (actor.work == Work::kRunning) ++cost;
    }
    if (cost > world_.faults_left || !NextDeadline(model_.config, world_.machine)) return;
    choices_.push_back({Deed::kTime, 0, 0, cost});
  }

  const Model& model_;
  const World& world_;
  std::vector<Choice> choices_;
};

}  // namespace

std::vector<Choice> Choices(const Model& model, const World& world) {
  return Listing(model, world).Make();
}

bool IsQuiet(const World& world, const std::vector<Choice>& choices) {
  return std::all_of(choices.begin(), choices.end(), [&](const Choice& choice) {
    const bool overdue = world.actors[choice.actuator].work == Work::kOverdue &&
                         (choice.deed == Deed::kEndOk || choice.deed == Deed::kEndAsked);
    const auto& late = world.actors[choice.actuator].late;
    // The latch is repeated until it has come.
    const bool lost =
        choice.deed == Deed::kLate && (std::holds_alternative<Message>(late[choice.index]) ||
                                       std::holds_alternative<event::Replied>(late[choice.index]));
    return choice.cost > 0 || lost || overdue;
  });
}

}  // namespace musher::search
