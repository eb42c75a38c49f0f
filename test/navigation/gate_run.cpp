#include "musher/test/navigation/gate_run.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <random>

#include "musher/navigation/gate/motion_gate.hpp"
#include "musher/test/navigation/maps.hpp"
#include "musher/test/navigation/scanned_body.hpp"

namespace musher::navigation::testing {
namespace {

// What the source of the commands and the odometry of a run do.
struct RandomSource {
  explicit RandomSource(std::uint64_t seed)
      : random(seed),
        walls(Fenced(RandomBoxes(seed, 7, 0.05, 0.05 + 0.15 * Share()))),
        body(walls, {FreePlace(walls, 0.3, random), 2 * M_PI * Share()}, {}) {}

  double Share() { return std::uniform_real_distribution<double>(0, 1)(random); }
  double Between(double least, double most) { return least + (most - least) * Share(); }
  bool OneIn(int count) { return random() % static_cast<std::uint64_t>(count) == 0; }

  // Any source: constant, wild, or led by a belief that jumps.
  void Choose() {
    omni = OneIn(3);
    wanted = {Between(-0.6, 1.5), omni ? Between(-1, 1) : 0, 0, OneIn(2) ? Between(-1, 1) : 0};
    belief = static_cast<int>(random() % 5);
  }
  Velocity Measured() {
    const Velocity& v = body.velocity();
    switch (belief) {
      case 1:
        return {};  // it stands
      case 2:
        return {1.5, 0, 0, 0};
      case 3:
        return {0.5 * v.x_m_s, 0.5 * v.y_m_s, 0, -v.yaw_rad_s};
      case 4:
        return {1e308, std::nan(""), 0, 0};
      default:
        return v;
    }
  }

  std::mt19937_64 random;
  Clearance walls;
  ScannedBody body;
  Velocity wanted;
  bool omni = false;
  int belief = 0;
};

struct ScanOnTheWay {
  Scan scan;
  Duration stamp{};
  Time due{};
};

}  // namespace

GateRun RunThroughGate(std::uint64_t seed, bool gated) {
  RandomSource run(seed);
  GateRules rules;
  rules.scanners = {{.topic = "scan"}};
  rules.reaction_s = 0.25;
  MotionGate gate(rules);
  const Duration period = Milliseconds(16);
  Time now = Time{} + std::chrono::seconds(1);
  std::deque<ScanOnTheWay> on_the_way;
  GateRun result;
  for (int i = 0; i < 1250; ++i, now += period) {
    if (i % 60 == 0) run.Choose();
    if (i % 6 == 0 && !run.OneIn(10)) {  // some are lost, some are late
      const Duration delay = run.OneIn(8) ? Milliseconds(250) : Milliseconds(15);
      on_the_way.push_back({run.body.Look(run.random), now.time_since_epoch(), now + delay});
    }
    while (!on_the_way.empty() && on_the_way.front().due <= now) {
      gate.OnScan(0, on_the_way.front().scan, on_the_way.front().stamp, now);
      on_the_way.pop_front();
    }
    if (i % 2 == 0) gate.OnVelocity(run.Measured(), now);
    run.body.Move(gated ? gate.Check(run.wanted, now).command : run.wanted, ToSeconds(period));
    result.least_room_m = std::min(result.least_room_m, run.body.room_m());
    result.driven_m +=
        std::hypot(run.body.velocity().x_m_s, run.body.velocity().y_m_s) * ToSeconds(period);
    ++result.updates;
  }
  return result;
}

}  // namespace musher::navigation::testing
