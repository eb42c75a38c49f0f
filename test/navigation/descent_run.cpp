#include "musher/test/navigation/descent_run.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <random>
#include <vector>

#include "musher/navigation/gate/motion_gate.hpp"

namespace musher::navigation::testing {
namespace {

constexpr double kFlyerM = 0.2;    // its radius
constexpr double kPersonM = 0.25;  // theirs
constexpr double kFlightStepS = 0.01;
constexpr double kFlightLagS = 0.1;
constexpr double kFlyerBrakeMS2 = 2.5;
constexpr double kRoomM = 1.5;      // to each side
constexpr double kSeenLongS = 0.7;  // in which a descent at 0.5 m/s stops
constexpr double kNearM = 0.25;     // above a head
constexpr double kSinksMS = 0.03;
constexpr double kMostDriftM = 0.2;   // of its height
constexpr double kNothingM = 4;       // beyond it the sensor sees nothing
constexpr double kHalfConeRad = 0.5;  // of the sensor

struct Person {
  Point at;  // its height is z
  Point to;
  double speed_m_s = 0;
  double seen_s = 0;  // in the cone, without a break
  bool sunk_onto = false;
};

class Flight {
 public:
  explicit Flight(std::uint64_t seed) : random_(seed) {
    const int count = 2 + static_cast<int>(random_() % 5);
    for (int i = 0; i < count; ++i) {
      persons_.push_back({{Between(-kRoomM, kRoomM), Between(-kRoomM, kRoomM), Between(0.6, 1.9)},
                          {Between(-kRoomM, kRoomM), Between(-kRoomM, kRoomM), 0},
                          OneIn(4) ? 0 : Between(0.2, 1.2)});
    }
    drift_m_s_ = OneIn(3) ? Between(-0.004, 0.004) : 0;
  }

  double Between(double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random_);
  }
  bool OneIn(int count) { return random_() % static_cast<std::uint64_t>(count) == 0; }

  // Descents, drives that lead down, climbs where it is low, and a person's stick.
  Velocity Choose() {
    if (at_.z_m < 0.8) return {0, 0, Between(0.3, 0.8), 0};
    if (OneIn(3)) return {0, 0, -Between(0.1, 0.5), 0};
    return {Between(-0.3, 0.3), Between(-0.3, 0.3), Between(-0.5, 0.3), Between(-1, 1)};
  }

  // `measures`: its sensor.
  void Move(const Velocity& command, bool measures) {
    for (Person& person : persons_) Walk(person);
    const double share = 1 - std::exp(-kFlightStepS / kFlightLagS);
    const auto follow = [&](double& wanted, double by, double& has) {
      wanted += share * (by - wanted);
      has +=
          std::clamp(wanted - has, -kFlyerBrakeMS2 * kFlightStepS, kFlyerBrakeMS2 * kFlightStepS);
    };
    follow(wanted_.x_m_s, command.x_m_s, velocity_.x_m_s);
    follow(wanted_.y_m_s, command.y_m_s, velocity_.y_m_s);
    follow(wanted_.z_m_s, command.z_m_s, velocity_.z_m_s);
    const double was_m = at_.z_m;
    at_.x_m = std::clamp(at_.x_m + velocity_.x_m_s * kFlightStepS, -kRoomM, kRoomM);
    at_.y_m = std::clamp(at_.y_m + velocity_.y_m_s * kFlightStepS, -kRoomM, kRoomM);
    at_.z_m = std::clamp(at_.z_m + velocity_.z_m_s * kFlightStepS, 0.0, 3.0);
    sunk_m_ += std::max(0.0, was_m - at_.z_m);
    drifted_m_ = std::clamp(drifted_m_ + drift_m_s_ * kFlightStepS, -kMostDriftM, kMostDriftM);
    for (Person& person : persons_) Touch(person, was_m, measures);
  }

  // The nearest of the rays of its cone.
  double Look() const {
    double nearest_m = kNothingM;
    for (int ring = 0; ring <= 6; ++ring) {
      const double off_rad = kHalfConeRad * ring / 6;
      for (int i = 0; i < std::max(1, 6 * ring); ++i) {
        const double turn_rad = 2 * M_PI * i / std::max(1, 6 * ring);
        nearest_m = std::min(nearest_m, Along(off_rad, turn_rad));
      }
    }
    return nearest_m;
  }

  const Velocity& velocity() const { return velocity_; }
  double height_m() const { return at_.z_m; }
  double measured_height_m() const { return at_.z_m + drifted_m_; }
  double sunk_m() const { return sunk_m_; }
  int sunk_onto() const { return sunk_onto_; }
  int touched() const { return touched_; }
  void Empty() { persons_.clear(); }

 private:
  static double Flat(const Point& a, const Point& b) {
    return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
  }

  // To a person, who is a column on the ground, or to the ground.
  double Along(double off_rad, double turn_rad) const {
    const double down = std::cos(off_rad), aside = std::sin(off_rad);
    double nearest_m = at_.z_m / down;
    for (const Person& person : persons_) {
      const double x = person.at.x_m - at_.x_m, y = person.at.y_m - at_.y_m;
      const double c = std::cos(turn_rad), s = std::sin(turn_rad);
      const double square = kPersonM * kPersonM - std::pow(y * c - x * s, 2);
      if (square < 0) continue;
      const double enters_m = std::max(0.0, x * c + y * s - std::sqrt(square));
      const double leaves_m = x * c + y * s + std::sqrt(square);
      const double to_head_m = std::max(0.0, (at_.z_m - person.at.z_m) / down);
      if (leaves_m < 0 || (aside == 0 && enters_m > 0)) continue;
      const double along_m = aside > 0 ? std::max(enters_m / aside, to_head_m) : to_head_m;
      if (along_m * aside <= leaves_m) nearest_m = std::min(nearest_m, along_m);
    }
    return std::min(nearest_m, kNothingM);
  }

  void Walk(Person& person) {
    const double left_m = Flat(person.at, person.to);
    if (left_m < 0.05) {
      person.to = {Between(-kRoomM, kRoomM), Between(-kRoomM, kRoomM), 0};
      return;
    }
    const double share = std::min(1.0, person.speed_m_s * kFlightStepS / left_m);
    person.at.x_m += share * (person.to.x_m - person.at.x_m);
    person.at.y_m += share * (person.to.y_m - person.at.y_m);
  }

  // Whether the flyer comes down onto a head, and how near to one that is in the cone.
  void Touch(Person& person, double was_m, bool measures) {
    const double apart_m = Flat(person.at, at_), above_m = was_m - person.at.z_m;
    const bool touches = above_m >= 0 && apart_m < kFlyerM + kPersonM && at_.z_m < person.at.z_m;
    touched_ += touches;
    const bool seen = above_m > 0 && apart_m - kPersonM <= above_m * std::tan(kHalfConeRad);
    person.seen_s = seen && measures ? person.seen_s + kFlightStepS : 0;
    const bool sinks = velocity_.z_m_s < -kSinksMS && above_m < kNearM;
    const bool sinks_onto = person.seen_s >= kSeenLongS && sinks;
    sunk_onto_ += sinks_onto && !person.sunk_onto;
    person.sunk_onto = sinks_onto;
  }

  std::mt19937_64 random_;
  std::vector<Person> persons_;
  Point at_{0, 0, 2.5};
  Velocity wanted_{}, velocity_{};
  double drift_m_s_ = 0, drifted_m_ = 0;
  double sunk_m_ = 0;
  int sunk_onto_ = 0, touched_ = 0;
};

struct RangeOnTheWay {
  DownReading reading;
  Duration stamp{};
  Time due{};
};

// A sample of the sensor, which is wrong now and then, in either direction.
DownReading Measure(Flight& flight) {
  DownReading reading{flight.Look(), 0.05, kNothingM, 2 * kHalfConeRad};
  reading.range_m += flight.Between(-0.01, 0.01);
  if (flight.OneIn(40)) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const double wrong[] = {std::nan(""), kInfinity, -kInfinity, flight.Between(0, 8), -1};
    reading.range_m = wrong[static_cast<std::size_t>(flight.Between(0, 4.99))];
  }
  return reading;
}

}  // namespace

DescentRun RunDescents(std::uint64_t seed, bool gated) {
  Flight flight(seed);
  GateRules rules;
  rules.reaction_s = 0.25;
  if (gated) rules.down.topic = "range_down";
  MotionGate gate(rules);
  Time now = Time{} + std::chrono::seconds(1);
  std::deque<RangeOnTheWay> on_the_way;
  Velocity wanted;
  Time lost_until{};
  const auto run = [&](int steps, bool lands) {
    for (int i = 0; i < steps; ++i, now += FromSeconds(kFlightStepS)) {
      if (i % 100 == 0) wanted = flight.Choose();
      if (lands) wanted = {0, 0, flight.height_m() < 0.5 ? -0.2 : -0.5, 0};
      if (flight.OneIn(800)) lost_until = now + Milliseconds(1500);
      if (i % 5 == 0 && now >= lost_until && !flight.OneIn(10)) {
        const Duration delay = flight.OneIn(10) ? Milliseconds(80) : Milliseconds(15);
        on_the_way.push_back({Measure(flight), now.time_since_epoch(), now + delay});
      }
      while (!on_the_way.empty() && on_the_way.front().due <= now) {
        gate.OnRange(on_the_way.front().reading, on_the_way.front().stamp, now);
        on_the_way.pop_front();
      }
      if (i % 2 == 0) {
        gate.OnVelocity(flight.velocity(), now);
        gate.OnHeight(flight.measured_height_m(), now);
      }
      flight.Move(gate.Check(wanted, now).command, now >= lost_until);
    }
  };
  run(4000, false);
  DescentRun result{flight.sunk_onto(), flight.touched(), flight.sunk_m()};
  flight.Empty();
  run(5000, true);
  result.landed = flight.height_m() < 0.01;
  return result;
}

}  // namespace musher::navigation::testing
