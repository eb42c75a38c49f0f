#pragma once
// The last check of a velocity before it is sent to a body: how fast may it go, by what its own
// scanners see? It knows no map, no localisation, no path and no skill, so none of their errors
// leads a body into what it sees.
//
//   commands of any source ──▶ Check() ──▶ the body
//   scans ──▶ OnScan()          ▲
//   the body's own velocity ────┤ OnVelocity()
//   ranges of a sensor that     │
//   looks down, its height ─────┘ OnRange(), OnHeight()
//
// - Points are compared in the frame of the body with the arc on which a command moves it. They are
//   moved on by its motion since the scan, once by what was measured and once by what was
//   commanded; the worse of both counts, so a measurement that stands hides nothing.
// - A body may go as fast as it can stop before the first point with `brake_m_s2` after
//   `reaction_s`; slower and slower, the nearer it comes, and it stops `margin_m` before it. With
//   `approach_s` it also needs so long to get there, as by the model "approach" of nav2's collision
//   monitor. A body that is too near already may go along and away, and turn: it is round.
// - A body that moves otherwise than it is commanded keeps its momentum: a command is only let
//   through if the body, on the way from its present motion to the command and then to a stop,
//   touches nothing; else it brakes as it moves. What comes towards it by itself, as another robot
//   does that brakes for this one, is then where it will be by that time.
// - A place that no scanner covers, outside of its angles or at rays without a measurement, is
//   unknown: the body enters it with `unknown_m_s` at most, and brakes in time. A gap of fewer than
//   5 degrees counts as covered, and so does what is behind a point. The gate does not remember
//   what earlier scans have covered: a person may have come there since.
// - Zones are polygons around the body, as those of nav2: points in one slow every motion down, or
//   stop all that does not lead away from them.
// - Without a recent scan of each of its scanners a body goes `blind_m_s` at most: it stands, but
//   for a flyer whose place is held. A body without scanners is not checked.
//
// A planar scan does not see climbs. A flyer descends by a sensor that looks down, if it has one:
// descent_watch.hpp. A velocity that leads mostly down, and is held by that, counts as stopped; of
// another one the rest is let through. Metres, radians, seconds; velocities in the frame of the
// body. Pure; one thread.

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "musher/navigation/gate/approach_watch.hpp"
#include "musher/navigation/gate/descent_watch.hpp"
#include "musher/navigation/gate/scan_view.hpp"

namespace musher::navigation {

// A polygon around the body, in its frame.
struct GateZone {
  std::string name;
  std::vector<Point> corners;
  bool stops = false;    // else it slows down
  double share = 0.3;    // of the speed that is left
  int least_points = 4;  // in it; fewer are noise

  bool Has(const Point& point) const;
};

// A flyer has to hold its place also without a scan.
inline constexpr double kFlyerBlindMS = 0.5;

struct GateRules {
  double radius_m = 0.2;     // of the body
  double margin_m = 0.05;    // between it and what it sees
  double brake_m_s2 = 2;     // with which it can stop
  double reaction_s = 0.2;   // from the scan to the begin of braking
  double approach_s = 0;     // at least so long to a collision; 0: as far as it can brake
  double blind_m_s = 0;      // without a recent scan
  double unknown_m_s = 0.3;  // where no scanner covers the way; at least blind_m_s
  Duration scan_stale = Milliseconds(500);
  std::vector<ScanMount> scanners;
  std::vector<GateZone> zones;
  DownRules down;
};

struct GateVerdict {
  enum class Kind : std::uint8_t { kFree, kSlowed, kStopped, kBlind };

  Velocity command;  // for the body
  Kind kind = Kind::kFree;
  std::optional<Point> at;  // what slows it or stops it, in the frame of the body
  std::string zone;         // in which it is, if it is a zone
  bool unknown = false;     // `at` is no obstacle, but a place that no scanner covers
  std::string scanner;      // the topic without a recent scan
  std::string refused;      // why its last one is not used; empty: none came
  std::string descent;      // why it does not descend as wanted; empty: it does
  bool careful = false;     // only since a person may come below it
  Duration held{};          // so long a wanted motion has been stopped

  bool holds() const { return kind == Kind::kStopped || kind == Kind::kBlind; }
};

// "an obstacle 0.42 m away, 12 degrees to the left, stops it". Empty: it is free.
std::string Describe(const GateVerdict& verdict);

class MotionGate {
 public:
  explicit MotionGate(const GateRules& rules);

  // Of the scanner with this index in the rules. False: the scan is refused.
  bool OnScan(std::size_t scanner, const Scan& scan, Duration stamp, Time now);
  const ScanMount& mount(std::size_t scanner) const { return views_[scanner].mount(); }
  // Where it is on the body, as a transform says; not one that the config gives.
  void Mount(std::size_t scanner, const Pose& on_body, bool upside_down);
  // As measured, for example by odometry.
  void OnVelocity(const Velocity& velocity, Time now);
  // Of the sensor that looks down. False: the reading is refused.
  bool OnRange(const DownReading& reading, Duration stamp, Time now);
  // Of the zero of the body's frame, above that of the odometry.
  void OnHeight(double z_m, Time now);
  // See DescentWatch.
  void ExpectGround(std::optional<double> height_m) { descent_.ExpectGround(height_m); }
  void MustLand(bool must) { descent_.MustLand(must); }
  // What was seen and measured before counts no more.
  void Forget();

  // The command that is sent instead of `wanted`. A number that is not finite stops it.
  GateVerdict Check(const Velocity& wanted, Time now);

  // What a scanner has seen last, in the frame that the body had then.
  const std::vector<Point>& PointsOf(std::size_t scanner) const { return views_[scanner].points(); }

  // Whether a recent scan covers this place, in the present frame of the body: what is there, or
  // before it, is seen.
  bool Covers(const Point& place, Time now) const;

  // Whether it has a sensor that looks down, but no recent ranges of it.
  bool BlindBelow(Time now) const { return descent_.IsBlind(now); }
  // Why the last scan of a scanner was refused; empty: it was not.
  const std::string& WhyRefused(std::size_t scanner) const { return views_[scanner].why_refused(); }
  // The scanner without a recent scan; null: there is none.
  const ScanMount* Blind(Time now) const;

 private:
  const ScanView* BlindView(Time now) const;

  // Where the body was, by a velocity, since some begin.
  class Track {
   public:
    void Advance(const Velocity& velocity, Time from, Time to);
    // Where it is now, in the frame that it had at `then`.
    Pose Since(Time then) const;
    // The points as the body sees them now, seen from where it was at `then`.
    void AddMoved(const std::vector<Point>& points, Time then, std::vector<Point>& moved) const;
    void Clear() { places_.clear(); }

   private:
    struct Place {
      Time at{};
      Pose pose;
    };
    std::deque<Place> places_;  // of the last seconds
  };
  struct Near {
    Point point;
    double square = 0;  // of the distance that it keeps
  };
  struct Limit {
    double share = 1;  // of the wanted velocity over the ground
    std::optional<Point> at;
    std::string zone;
    bool unknown = false;
  };

  void Advance(Time now);
  double AsideMS(Time now) const;
  std::optional<double> NearestM(Time now) const;
  void LimitDescent(GateVerdict& verdict, Time now);
  void Assume(const Velocity& command, double seconds);
  bool IsRecent(const ScanView& view, Time now) const;
  std::vector<Point> Seen(const Track& track, Time now) const;
  std::vector<MovingPoint> SeenMoving(const Track& track, Time now) const;
  Velocity Measured(Time now) const;
  void LimitByArc(const std::vector<Point>& points, const Velocity& wanted, Limit& limit) const;
  void LimitByUnknown(const Track& track, const Velocity& wanted, Time now, Limit& limit) const;
  void LimitByZones(const std::vector<Point>& points, const Velocity& wanted, Limit& limit) const;
  double FreeArc(const std::vector<Near>& near, const Velocity& wanted, double ahead_m,
                 std::optional<Point>& at) const;
  double AheadM(double speed_m_s) const;
  double FastestMS(const Velocity& wanted) const;
  double SafeMS(double free_m) const;
  std::vector<Near> NearPoints(const std::vector<Point>& points, double ahead_m) const;
  void LimitByMomentum(const std::vector<Point>& points, const std::vector<MovingPoint>& moving,
                       const Velocity& present, const Velocity& wanted, Limit& limit) const;
  std::optional<Point> TouchedOnTheWay(const std::vector<Near>& near,
                                       std::vector<MovingPoint> moving, const Velocity& present,
                                       const Velocity& command) const;
  std::optional<Point> Met(std::vector<MovingPoint>& moving, const Pose& body,
                           const Velocity& velocity, double seconds) const;
  double YawOfAStop(const Velocity& wanted, double seconds) const;

  const GateRules rules_;
  std::vector<ScanView> views_;
  std::vector<ApproachWatch> watches_;  // by scanner
  DescentWatch descent_;
  Track measured_track_;
  Track commanded_track_;
  Velocity measured_;
  std::optional<Time> measured_at_;
  Velocity assumed_;  // of a body that executes its commands, and brakes as hard as it can
  std::optional<Time> last_;
  std::optional<Time> last_checked_;
  std::optional<Time> held_since_;
};

}  // namespace musher::navigation
