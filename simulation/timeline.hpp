#pragma once
// The timeline of a scenario, or of what a search has found, as text (a line for each event) or as
// a picture (SVG, a band for the machine and for each actuator).

#include <map>
#include <string>
#include <vector>

#include "musher/simulation/scenario.hpp"

namespace musher::simulation {

class Timeline {
 public:
  // Observes a scenario, which has not run yet and must outlive it.
  Timeline(Scenario& scenario, const MachineConfig& config);
  Timeline(const Timeline&) = delete;
  Timeline& operator=(const Timeline&) = delete;

  // Call after the run.
  void End(const ScenarioEnd& ending);

  enum class Source : std::uint8_t { kInjection, kOperator, kController, kActuator, kChecker };
  struct Line {
    Duration at{};
    Source source = Source::kController;
    std::string text;
  };
  // One state of the machine or of an actuator.
  struct Span {
    Duration from{};
    Duration to{};
    std::string state;   // empty: not available
    std::string target;  // of the running callback; empty: none
    friend bool operator==(const Span&, const Span&) = default;
  };
  struct Band {
    std::string name;
    std::vector<Span> spans;
  };

  const std::vector<Line>& lines() const { return lines_; }
  const std::vector<Band>& bands() const { return bands_; }
  Duration end() const { return end_; }

  std::string Text() const { return TextOf(lines_); }
  std::string Svg(const std::string& title) const {
    return SvgOf(config_, lines_, bands_, end_, title);
  }

  // Renders lines and bands that were made elsewhere; the picture ends at `end`.
  static std::string TextOf(const std::vector<Line>& lines);
  static std::string SvgOf(const MachineConfig& config, const std::vector<Line>& lines,
                           const std::vector<Band>& bands, Duration end, const std::string& title);

 private:
  void Update(const SimRobot& robot);
  void Show(std::size_t band, const std::string& state, const std::string& target);
  void Add(Source source, std::string text);

  const Scenario& scenario_;
  const MachineConfig& config_;
  std::vector<Line> lines_;
  std::vector<Band> bands_;  // the machine, then the actuators
  Duration end_{};
};

}  // namespace musher::simulation
