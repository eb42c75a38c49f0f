#include "musher/cli/render/progress_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <vector>

#include "musher/cli/console/console.hpp"
#include "musher/cli/console/table.hpp"
#include "musher/cli/render/text.hpp"

namespace musher::cli {
namespace {

std::int64_t WholeSeconds(Duration duration) {
  return std::chrono::duration_cast<std::chrono::seconds>(duration).count();
}

std::string TimeText(const ProgressView::Actuator& times) {
  std::string text = fmt::format("{} s", WholeSeconds(times.elapsed));
  if (times.limit) text += fmt::format(" of {:.3g} s", ToSeconds(*times.limit));
  return text;
}

std::string Headline(const ProgressView& view) {
  const auto& actuators = view.machine.actuators;
  const std::string& target = view.machine.target;
  const auto count = [&actuators](const auto& holds) {
    return std::count_if(actuators.begin(), actuators.end(), holds);
  };
  if (!target.empty()) {
    return fmt::format("{}, {} s: {} of {} done", Printable(target), WholeSeconds(view.elapsed),
                       count([&target](const msg::ActuatorInfo& one) {
                         return one.target.empty() && one.state == target;
                       }),
                       actuators.size());
  }
  return fmt::format("{} {}, {} s: {} of {} present", Printable(view.machine.machine),
                     Printable(view.machine.phase), WholeSeconds(view.elapsed),
                     count([](const msg::ActuatorInfo& one) { return one.presence == "present"; }),
                     actuators.size());
}

}  // namespace

bool IsUnderWay(const msg::ActuatorInfo& actuator) {
  return !actuator.target.empty() || actuator.presence == "starting" || actuator.restarting;
}

bool IsUnderWay(const msg::MachineStatus& machine) {
  return !machine.target.empty() ||
         std::any_of(machine.actuators.begin(), machine.actuators.end(),
                     [](const msg::ActuatorInfo& one) { return IsUnderWay(one); });
}

std::string StateText(const msg::ActuatorInfo& actuator) {
  if (actuator.presence != "present") {
    return Printable(actuator.restarting ? "restarting" : actuator.presence);
  }
  const bool moves = !actuator.target.empty() && actuator.target != actuator.state;
  return Printable(actuator.state) + (moves ? " \u2192 " + Printable(actuator.target) : "");
}

std::string ProgressTable(const ProgressView& view, std::size_t lines, bool colour) {
  constexpr std::size_t kHead = 2;
  if (lines < kHead + 2) return Headline(view) + '\n';
  std::vector<const msg::ActuatorInfo*> shown;
  const bool all = view.machine.actuators.size() + kHead <= lines;
  for (const msg::ActuatorInfo& actuator : view.machine.actuators) {
    if (all || IsUnderWay(actuator)) shown.push_back(&actuator);
  }
  std::size_t more = 0;
  if (shown.size() + kHead > lines) {
    const std::size_t room = lines - kHead - 1;  // the last line counts them
    more = shown.size() - std::min(shown.size(), room);
    shown.resize(shown.size() - more);
  }
  Table table({"ACTUATOR", "STATE", "TIME"});
  for (const msg::ActuatorInfo* actuator : shown) {
    const auto times = view.actuators.find(actuator->name);
    const bool timed = IsUnderWay(*actuator) && times != view.actuators.end();
    table.Add(
        {{Printable(actuator->name)},
         {StateText(*actuator), IsUnderWay(*actuator)             ? Style::kBusy
                                : actuator->presence == "present" ? StyleOfState(actuator->state)
                                                                  : Style::kDim},
         {timed ? TimeText(times->second) : ""}});
  }
  return Headline(view) + '\n' + table.Text(colour) +
         (more == 0 ? "" : fmt::format("and {} more\n", more));
}

}  // namespace musher::cli
