#include "musher/cli/commands/switch_progress.hpp"

#include <algorithm>

#include "musher/cli/console/terminal_screen.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher::cli {
namespace {

// Also before the first drawing: most switches end sooner.
constexpr Duration kDrawPeriod = Milliseconds(500);
constexpr std::size_t kMostLines = 16;  // the lines printed above stay in sight

std::string LimitedState(const msg::ActuatorInfo& actuator) {
  return actuator.presence == "starting" ? std::string(kSetUp) : actuator.target;
}

}  // namespace

SwitchProgress::SwitchProgress(transport::EventLoop& loop, Console& console, Limit limit)
    : loop_(loop), console_(console), limit_(std::move(limit)), begin_(loop.Now()) {}

void SwitchProgress::Show(const std::optional<msg::MachineStatus>& machine) {
  if (!on()) return;
  if (!machine || !IsUnderWay(*machine)) return Hide();
  const Time now = loop_.Now();
  if (!machine_ || machine_->target != machine->target || machine_->phase != machine->phase) {
    begin_ = now;
  }
  machine_ = machine;
  for (const msg::ActuatorInfo& actuator : machine->actuators) {
    Step step{StateText(actuator), LimitedState(actuator), now};
    Step& known = steps_.try_emplace(actuator.name, step).first->second;
    if (known.state != step.state || known.target != step.target) known = std::move(step);
  }
  if (!ticks_) ticks_ = loop_.Every(kDrawPeriod, [this] { Draw(); });
  if (shown_) Draw();
}

void SwitchProgress::Draw() {
  const Time now = loop_.Now();
  ProgressView view{*machine_, now - begin_, {}};
  for (const auto& [actuator, step] : steps_) {
    view.actuators[actuator] = {now - step.since, limit_(actuator, step.target)};
  }
  const std::size_t lines = std::min(TerminalScreen::SizeNow().lines - 1, kMostLines);
  console_.ShowBlock(ProgressTable(view, lines, console_.mode().colour));
  shown_ = true;
}

void SwitchProgress::Hide() {
  ticks_ = nullptr;
  machine_.reset();
  steps_.clear();
  if (shown_) console_.HideBlock();
  shown_ = false;
}

}  // namespace musher::cli
