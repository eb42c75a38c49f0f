#pragma once
// A kettle and its skill, independent of topics, threads and clocks.

#include <algorithm>
#include <chrono>

#include "musher/behavior/skill/skill.hpp"

// On a real robot a driver reads the sensors and switches the heater. This one has physics instead.
struct Kettle {
  double temperature_c = 20;
  double water_l = 1;
  bool heats = false;  // the heater is on

  void Advance(musher::Duration time) {
    const double seconds = musher::ToSeconds(time);
    temperature_c = std::clamp(temperature_c + (heats ? 15 : -0.5) * seconds, 20.0, 100.0);
  }
};

namespace skill = musher::skill;

class Heat : public skill::Skill {
 public:
  explicit Heat(Kettle& kettle) : kettle_(kettle) {}

  void Declare(skill::Table& table) override {
    table.Does("Heats the water");
    table.Takes("temperature", 95.0, "degrees Celsius, 30 to 100");
    const auto heating = table.State("HEATING", std::chrono::seconds(30));
    table.To(heating, skill::kSucceeded, "the water has the temperature");
  }
  skill::Next Step(skill::Tick& tick) override {
    const double target = tick.parameters.Number("temperature");
    if (target < 30 || target > 100) return skill::Next::Fail("the temperature is not 30 to 100");
    if (kettle_.water_l < 0.2) return skill::Next::Fail("less than 0.2 l of water");
    if (kettle_.temperature_c >= target) return skill::Next::Succeed("The water is hot");
    kettle_.heats = true;
    tick.Report(100 * (kettle_.temperature_c - 20) / (target - 20), "Heating");
    tick.Detail("temperature_c", kettle_.temperature_c);
    return skill::Next::Stay();
  }
  void OnEnd(const skill::Ended& ended) override {
    if (!ended.paused) kettle_.heats = false;
  }
  void OnPause() override { kettle_.heats = false; }

 private:
  Kettle& kettle_;
};
