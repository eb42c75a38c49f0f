#pragma once
// How a body on the ground comes to stand at a wanted distance and bearing of a target that its
// detectors see: a velocity for each look, or the reason to stand. Pure; time enters with each
// look.
//
// It turns to the target and drives until the distance is right, then turns on the spot until the
// bearing is right, and stands there until it has been right for a while. It moves only
//
//   - on a sighting of the last 0.3 s, by when its picture was taken,
//   - of the only thing of that name in the picture,
//   - that was seen twice in a row at places between which a body can move in that time.
//
// A target that jumps is not followed: what is seen counts again once it is near the place from
// which it has jumped. So it never moves on an older sighting, whatever it commanded before.
//
// Metres, radians, in the frame of the body: x forward, y to the left; the bearing is positive to
// the left. Distances are level, from the middle of the body to that of the target. Threads: one at
// a time.

#include <deque>
#include <optional>
#include <string>
#include <utility>

#include "musher/base/time.hpp"
#include "musher/modules/skills/robot/robot.hpp"

namespace musher::skills {

// A sighting that is older moves nothing.
inline constexpr Duration kSightingCounts = std::chrono::milliseconds(300);

struct ServoRules {
  std::string target;  // its name, for reasons
  double distance_m = 1;
  double bearing_rad = 0;
  double tolerance_m = 0.05;
  double bearing_tolerance_rad = 0.1;
  double speed_m_s = 0.2;
  double turn_rad_s = 0.6;
};

struct ServoStep {
  enum class Kind : std::uint8_t {
    kMoves,
    kSettles,  // the target is right; it has to stay so
    kReached,
    kStands,  // `why` it must not move
  };

  Kind kind = Kind::kStands;
  navigation::Velocity command{};  // 0 but for kMoves
  std::string why{};
  // The last sighting that counts, also an older one; of kReached the mean of those that were
  // right.
  std::optional<navigation::Point> target{};
};

double LevelDistanceTo(const navigation::Point& target);
double BearingOf(const navigation::Point& target);

class VisualServo {
 public:
  explicit VisualServo(ServoRules rules) : rules_(std::move(rules)) {}

  // `look`: the last one, which may be the same as before; nullopt: none, for the reason
  // `why_none`. `stands`: whether the body stands.
  ServoStep Update(const std::optional<Look>& look, const std::string& why_none, bool stands,
                   Time now);

 private:
  struct Sighting {
    navigation::Point at;
    Time time;
  };

  // A look that is newer than the last one.
  void Take(const Look& look);
  void Doubt(std::string why);
  // How far the target may be from its last place after this time, as the body sees it.
  double FarthestMove(double seconds) const;
  std::string WhyStand(Time now) const;
  // Within this share of the tolerances.
  bool IsRight(const navigation::Point& target, double share) const;
  ServoStep Decide(bool stands);
  navigation::Velocity Command();

  const ServoRules rules_;
  std::optional<Time> looked_;    // of the last look
  std::optional<Sighting> last_;  // that counts
  int agree_ = 0;                 // sightings in a row, up to the last one
  std::string doubt_;             // of the last look; empty: none
  bool jumped_ = false;
  bool near_ = false;           // the distance is right: it turns on the spot
  bool rests_ = false;          // the target is right: it stands
  std::deque<Sighting> right_;  // while it stood and the target was right
};

}  // namespace musher::skills
