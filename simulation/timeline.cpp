#include "musher/simulation/timeline.hpp"

#include <cstdio>
#include <utility>

namespace musher::simulation {
namespace {

std::string Seconds(Duration at) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%9.4f s", ToSeconds(at));
  return text.data();
}

std::string_view Mark(Timeline::Source source) {
  switch (source) {
    case Timeline::Source::kInjection:
      return "  ⚡ ";
    case Timeline::Source::kOperator:
      return "  ☺ ";
    case Timeline::Source::kController:
      return "      ";
    case Timeline::Source::kActuator:
      return "        · ";
    case Timeline::Source::kChecker:
      return "  ✗ ";
  }
  return {};
}

}  // namespace

Timeline::Timeline(Scenario& scenario, const MachineConfig& config)
    : scenario_(scenario), config_(config) {
  bands_.push_back({"machine", {}});
  for (const ActuatorConfig& actuator : config.actuators) bands_.push_back({actuator.name, {}});
  scenario.listener.on_injection = [this](Time, const Injection& injection) {
    Add(Source::kInjection, Describe(config_, injection));
  };
  scenario.listener.on_repair = [this](Time, const std::string& action) {
    Add(Source::kOperator, action);
  };
  scenario.listener.on_record = [this](Time, const action::Record& record) {
    Add(Source::kController, record.message);
  };
  scenario.listener.on_change = [this](Time, const SimRobot& robot) { Update(robot); };
}

void Timeline::Add(Source source, std::string text) {
  lines_.push_back({scenario_.robot().age(), source, std::move(text)});
}

void Timeline::Update(const SimRobot& robot) {
  const auto* leader = robot.leader();
  if (leader == nullptr) {
    Show(0, "", "");
  } else {
    const Machine& machine = leader->shell().machine();
    Show(0, machine.state, machine.current ? machine.current->target : State());
  }
  for (const ActuatorIndex i : config_.actuators.Indices()) {
    const std::string& name = config_.actuators[i].name;
    const ActuatorReport* report = robot.processes().ReportOf(name);
    if (report == nullptr) {
      Show(i.value() + 1, "", "");
    } else {
      Show(i.value() + 1, report->state, report->target);
    }
  }
}

void Timeline::Show(std::size_t band, const std::string& state, const std::string& target) {
  std::vector<Span>& spans = bands_[band].spans;
  const Duration now = scenario_.robot().age();
  if (!spans.empty()) {
    spans.back().to = now;
    if (spans.back().state == state && spans.back().target == target) return;
  }
  const bool was_there = !spans.empty() && !spans.back().state.empty();
  spans.push_back({now, now, state, target});
  if (band == 0) return;
  const std::string& name = bands_[band].name;
  if (state.empty()) {
    if (was_there) Add(Source::kActuator, name + " has exited");
  } else if (target.empty()) {
    Add(Source::kActuator, name + " is in " + state);
  } else {
    Add(Source::kActuator, name + " in " + state + " begins " + target);
  }
}

void Timeline::End(const ScenarioEnd& ending) {
  end_ = scenario_.robot().age();
  for (Band& band : bands_) {
    if (!band.spans.empty()) band.spans.back().to = end_;
  }
  if (ending.violation) {
    Add(Source::kChecker, ending.violation->what);
    Add(Source::kChecker, "violated: " + std::string(InvariantText(ending.violation->invariant)));
  }
}

std::string Timeline::TextOf(const std::vector<Line>& lines) {
  std::string text;
  for (const Line& line : lines) {
    text += Seconds(line.at) + std::string(Mark(line.source)) + line.text + "\n";
  }
  return text;
}

}  // namespace musher::simulation
