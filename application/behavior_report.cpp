#include "musher/application/behavior_report.hpp"

#include <algorithm>

#include "musher/behavior/fsm/graph.hpp"

namespace musher {
namespace {

msg::BehaviorChange ToMessage(const fsm::Machine& machine, const fsm::Change& change) {
  return {ToSeconds(change.at),
          change.tick,
          std::string(machine.Name(change.from)),
          std::string(machine.Name(change.to)),
          std::string(fsm::Name(change.cause)),
          std::string(machine.Name(change.command))};
}

}  // namespace

msg::GetBehavior::Response ReportBehavior(const fsm::Machine& machine, bool ticking,
                                          const msg::GetBehavior::Request& request) {
  msg::GetBehavior::Response report;
  report.running = machine.running();
  report.ticking = ticking;
  report.current_state = machine.Path();
  report.operating_mode = fsm::Name(machine.mode());
  report.iter_count = machine.ticks();
  report.safety_triggered = machine.mode() == fsm::Mode::kSafeStop;
  report.unsafe = machine.unsafe();
  report.time_s = ToSeconds(machine.time());
  if (machine.running()) report.time_in_state_s = ToSeconds(machine.elapsed());
  if (machine.fault()) report.last_fault = machine.Describe(*machine.fault());
  const fsm::History& history = machine.history();
  const std::size_t count = std::min<std::size_t>(history.size(), request.history);
  for (std::size_t i = history.size() - count; i < history.size(); ++i) {
    report.history.push_back(ToMessage(machine, history[i]));
  }
  for (std::size_t i = 0; i < machine.event_count(); ++i) {
    report.commands.emplace_back(machine.Name(static_cast<fsm::EventId>(i)));
  }
  if (request.format == "dot") {
    report.graph = fsm::ToDot(machine.chart(), report.current_state);
  } else if (request.format == "mermaid") {
    report.graph = fsm::ToMermaid(machine.chart(), report.current_state);
  } else if (!request.format.empty()) {
    report.error = "unknown graph format; expected dot or mermaid";
  }
  return report;
}

}  // namespace musher
