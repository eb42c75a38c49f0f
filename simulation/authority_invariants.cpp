// The invariants of authority: the newest word of a person counts.

#include "musher/simulation/checker.hpp"

namespace musher::simulation {

void Checker::NoteWord(const ControllerProcess& controller, bool restarted) {
  std::uint64_t& last = last_word_on_[controller.host()];
  if (!restarted || last == 0) last = ++words_;
  Word word{last, controller.serial(), {}, {}};
  for (std::size_t which = 0; which < 2; ++which) {
    const ControllerProcess* other = robot_.controller(which);
    if (other == nullptr || other == &controller || !other->leads()) continue;
    const Machine& machine = other->shell().machine();
    if (machine.phase == Phase::kStarting) word.together.insert(other->serial());
    word.others[other->serial()] = machine.epoch;
  }
  word_of_[controller.serial()] = std::move(word);
}

void Checker::CheckRaised(const ControllerProcess& controller, Seen& seen, Epoch before) {
  const Epoch epoch = controller.shell().machine().epoch;
  if (++seen.raised == 1 && seen.starts && epoch > before) return;
  ReportViolation(Invariant::kEpochRaisedOnce,
                  "the controller on host " + robot_.hosts().name(controller.host()) +
                      " goes from epoch " + ToString(before) + " to " + ToString(epoch) +
                      (seen.starts ? " in its start" : " while it runs") + ", raise " +
                      std::to_string(seen.raised));
}

// An actuator follows a controller. It must not be one that a person has replaced, while the newer
// one leads; unless the older one had a higher epoch already, of which the person did not know.
void Checker::CheckFollows(const std::string& name, std::size_t host,
                           const ActuatorReport& report) {
  const ActuatorCore* core = robot_.processes().CoreOf(name, host);
  if (core == nullptr || core->controller == 0) return;
  Followed& followed = followed_[{name, host}];
  if (followed.incarnation != report.incarnation) followed = {report.incarnation, {}};
  const ControllerProcess* controller = nullptr;
  const ControllerProcess* newer = nullptr;
  for (std::size_t which = 0; which < 2; ++which) {
    const ControllerProcess* one = robot_.controller(which);
    if (one == nullptr) continue;
    if (Sender(one->participant().value()) == core->controller) controller = one;
    if (one->serial() == followed.word.controller && one->leads()) newer = one;
  }
  if (controller == nullptr || !word_of_.contains(controller->serial())) return;
  const Word& word = word_of_.at(controller->serial());
  if (word.number >= followed.word.number) {
    followed.word = word;
    return;
  }
  if (newer == nullptr || followed.word.together.contains(controller->serial())) return;
  const Epoch epoch = controller->shell().machine().epoch;
  const auto known = followed.word.others.find(controller->serial());
  const bool raised = known == followed.word.others.end() || known->second != epoch;
  if (!raised && epoch >= newer->shell().machine().epoch) return;
  ReportViolation(Invariant::kTakeoverLasts, name + " returns to the controller on host " +
                                                 robot_.hosts().name(controller->host()) +
                                                 ", epoch " + ToString(report.epoch) +
                                                 ", which a person has replaced");
}

}  // namespace musher::simulation
