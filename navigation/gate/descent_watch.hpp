#pragma once
// How fast may a flyer descend, by a range sensor that looks down? Its planar scan does not see who
// is below it.
//
//   ranges ──▶ Take()    ┐
//   heights ──▶ OnHeight() ├──▶ Check(): the part of a descent that is let through
//   motion ──▶ Move()    ┘
//
// - What is within ground_tolerance_m of the expected height of the ground, or lower, is ground: it
//   may be landed on. All else that the sensor sees is not. The body comes no nearer to it than it
//   keeps, and brakes in time. It keeps margin_m, and more where the cone of the sensor is narrower
//   than the body: what a body is about to touch is then still in the cone.
// - One sample stops, two in succession release: the nearer one of the last two counts. What the
//   body has sunk since then is subtracted.
// - NaN says nothing, and neither do these: "nothing in range" where the ground ought to be in
//   range; a range that stays exactly the same while the height changes.
// - Without two recent samples it does not descend, unless it has to land; then it goes blind_m_s.
//   Whose underside is within the tolerance of the ground has only ground below.
// - Of what is below it sees a cone, and a body that moves aside descends out of that. So it stays
//   level: it comes no lower than where it last climbed, or moved aside slower than kAsideMS. One
//   that has to land goes blind_m_s.
// - Without a recent height nothing is ground. One that jumps down may follow this sensor over a
//   head: for a minute, or until it jumps back, the body counts as high as before, too.
// - A range says nothing of the direction: what is seen may be the top of a thing below, or the
//   side of a higher one, a person, at the rim of the cone. What comes nearer by itself is taken
//   for a person who walks with person_m_s: the body descends so slowly that it stops before that
//   one is below its rim, or it does not descend. What stands may begin to walk, but for what the
//   planar scan sees at the same distance, a wall.
// - Where persons may be, lower than person_m, one may come into the cone at any time. The body
//   descends so slowly there that it stops before that one is below its rim. No sensor with a
//   narrow cone permits that near the ground: there it descends with low_m_s.
//
// Heights in the frame of the odometry; metres, radians, seconds. Pure; one thread.

#include <array>
#include <cmath>
#include <deque>
#include <optional>
#include <string>

#include "musher/base/time.hpp"
#include "musher/navigation/gate/sample_age.hpp"
#include "musher/navigation/pose.hpp"

namespace musher::navigation {

struct DownRules {
  std::string topic;  // of its sensor_msgs/Range; empty: there is no such sensor
  Point on_body{};
  double foot_m = 0;  // how far the body reaches below the zero of its frame
  double margin_m = 0.3;
  double ground_m = 0;
  double ground_tolerance_m = 0.25;
  double blind_m_s = 0.1;
  double person_m_s = 1.6;  // how fast one walks below it; 0: there are none
  double person_m = 2;      // above the ground: higher than each of them
  double low_m_s = 0.1;     // lower than that the body need not descend slower
  Duration stale = Milliseconds(500);
  // Instead of those of the messages.
  std::optional<double> cone_rad, least_m, most_m;
};

struct DownReading {
  double range_m = 0;  // -inf: nearer than least_m, +inf: nothing within most_m, as REP 117 has it
  double least_m = 0;
  double most_m = 0;
  double cone_rad = 0;  // from side to side
};

struct DescentVerdict {
  // kLow: a person may come; kBeside: what is seen may be one who is beside it.
  enum class Kind : std::uint8_t { kFree, kLow, kSlowed, kHeld, kBeside, kBlind, kAside };

  double z_m_s = 0;  // of the command for the body
  Kind kind = Kind::kFree;
  double gap_m = 0;                  // between the body and what is below, or beside
  std::optional<double> height_m{};  // of that, above the ground
};

// From which a body stops within so much of its way.
inline double StoppingSpeed(double free_m, double brake_m_s2, double reaction_s) {
  const double lost_m_s = brake_m_s2 * reaction_s;
  return std::sqrt(lost_m_s * lost_m_s + 2 * brake_m_s2 * std::max(0.0, free_m)) - lost_m_s;
}

class DescentWatch {
 public:
  DescentWatch(const DownRules& rules, double radius_m, double brake_m_s2, double reaction_s)
      : rules_(rules), radius_m_(radius_m), brake_m_s2_(brake_m_s2), reaction_s_(reaction_s) {}

  // False: the reading is refused.
  bool Take(const DownReading& reading, Duration stamp, Time now);
  // Of the zero of the body's frame; with its vertical velocity, as measured.
  void OnHeight(double z_m, double climb_m_s, Time now);
  // It has gone on for so long with this vertical velocity, and this speed over the ground.
  void Move(double climb_m_s, double over_ground_m_s, double seconds);
  // The height of the ground on which it shall land; nullopt: that of the rules.
  void ExpectGround(std::optional<double> height_m) { expected_ground_m_ = height_m; }
  // It has to land also where it does not see: its battery is low.
  void MustLand(bool must) { must_land_ = must; }
  void Forget();

  // A body that moves aside faster than this stays level.
  static constexpr double kAsideMS = 0.15;

  // `aside_m_s`: how fast it moves aside now, by its own commands. `wall_m`: from its middle to the
  // nearest point of its planar scans, if they see one.
  DescentVerdict Check(double z_m_s, double aside_m_s, std::optional<double> wall_m, Time now);
  // Whether there is a sensor, but no two recent samples.
  bool IsBlind(Time now) const;
  const DownRules& rules() const { return rules_; }

 private:
  struct Sample {
    Time taken{};
    double gap_m = 0;
    double keep_m = 0;
    std::optional<double> surface_m{};  // its height; nullopt: that of the body was not known
    double side_m = 0;     // to the middle of the body, if it is at the rim of the cone
    double cone_sine = 0;  // of half the cone
    double most_m = 0;     // the sensor sees nothing that is farther
  };
  struct Range {
    Time taken{};
    double range_m = 0;
    double sunk_m = 0, moved_m = 0;  // by the body until then
  };
  struct Height {
    double z_m = 0;  // as it was received
    double climb_m_s = 0;
    Time at{};
  };

  double ground_m() const { return expected_ground_m_.value_or(rules_.ground_m); }
  std::optional<double> HeightAt(Time now) const;
  bool IsGround(double height_m) const {
    return height_m <= ground_m() + rules_.ground_tolerance_m;
  }
  bool IsRecent(const std::optional<Sample>& sample, Time now) const;
  void LimitAside(DescentVerdict& verdict, std::optional<double> height_m) const;
  void LimitBeside(DescentVerdict& verdict, const Sample& sample, std::optional<double> wall_m,
                   Time now) const;
  void LimitLow(DescentVerdict& verdict, Time now) const;
  bool ComesNearer(double range_m, double cone_sine, Time taken);
  double rim_m() const { return radius_m_ + std::hypot(rules_.on_body.x_m, rules_.on_body.y_m); }
  bool Stands(double range_m, std::optional<double> height_m);
  double KeepOf(double cone_rad) const;

  const DownRules rules_;
  const double radius_m_, brake_m_s2_, reaction_s_;
  std::array<std::optional<Sample>, 2> last_;  // the newer one first
  SampleAge age_;
  std::optional<Height> height_;
  std::optional<double> level_m_;  // the height that it keeps while it moves aside
  double jumped_m_ = 0;            // by so much all jumps of the height together
  Time jumped_at_{};               // the last one
  double sinking_m_s_ = 0;
  std::optional<double> same_range_m_, same_since_m_;  // of which height
  std::deque<Range> ranges_;                           // of the last moments
  double sunk_m_ = 0, moved_m_ = 0;                    // by its motion, since the begin
  std::optional<Time> came_nearer_;                    // when something last did by itself
  std::optional<double> expected_ground_m_;
  bool must_land_ = false;
};

}  // namespace musher::navigation
