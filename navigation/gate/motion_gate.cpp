#include "musher/navigation/gate/motion_gate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace musher::navigation {
namespace {

constexpr double kArcStepM = 0.02;  // of the arc that is compared
constexpr double kStandsMS = 0.02;  // a slower command is none
constexpr double kStillMS = 1e-3;   // over the ground
constexpr double kTouchM = 0.02;    // nearer than this no body comes by itself
constexpr double kLongestArcM = 20;
constexpr double kFastestMS = 20;  // a measurement beyond this is none
constexpr Duration kKeptTrack = std::chrono::seconds(3);
constexpr Duration kMeasuredStale = Milliseconds(500);
constexpr Duration kClockSetBack = Milliseconds(100);
constexpr Duration kCommandStale = Milliseconds(200);
constexpr double kLongestTrackS = 0.5;

bool IsFinite(const Velocity& velocity) {
  return std::isfinite(velocity.x_m_s) && std::isfinite(velocity.y_m_s) &&
         std::isfinite(velocity.z_m_s) && std::isfinite(velocity.yaw_rad_s);
}

double OverGround(const Velocity& velocity) {
  return std::hypot(velocity.x_m_s, velocity.y_m_s);
}

// The place on the arc of a velocity after a time.
Pose OnArc(const Velocity& velocity, double seconds) {
  const double turned = velocity.yaw_rad_s * seconds;
  if (std::abs(turned) < 1e-6) {
    return {{velocity.x_m_s * seconds, velocity.y_m_s * seconds, 0}, turned};
  }
  const double along = std::sin(turned) / velocity.yaw_rad_s;
  const double aside = (1 - std::cos(turned)) / velocity.yaw_rad_s;
  return {{velocity.x_m_s * along - velocity.y_m_s * aside,
           velocity.x_m_s * aside + velocity.y_m_s * along, 0},
          turned};
}

// The first of the points that a body at this place is nearer to than it may be.
template <class Nears>
std::optional<Point> Touched(const Nears& near, const Point& centre) {
  for (const auto& one : near) {
    const double x = one.point.x_m - centre.x_m, y = one.point.y_m - centre.y_m;
    if (x * x + y * y < one.square) return one.point;
  }
  return std::nullopt;
}

// A point in the frame of `frame`.
Point SeenFrom(const Pose& frame, const Point& point) {
  const double c = std::cos(frame.yaw_rad), s = std::sin(frame.yaw_rad);
  const double x = point.x_m - frame.at.x_m, y = point.y_m - frame.at.y_m;
  return {c * x + s * y, c * y - s * x, point.z_m};
}

// Of a pose in a frame, in the frame in which that frame is given.
Pose Composed(const Pose& frame, const Pose& in_it) {
  const double c = std::cos(frame.yaw_rad), s = std::sin(frame.yaw_rad);
  return {{frame.at.x_m + c * in_it.at.x_m - s * in_it.at.y_m,
           frame.at.y_m + s * in_it.at.x_m + c * in_it.at.y_m, 0},
          frame.yaw_rad + in_it.yaw_rad};
}

// "something 1.6 m high is 0.42 m below it: it does not descend".
std::string TextOf(const DescentVerdict& descent, const std::string& topic) {
  using Kind = DescentVerdict::Kind;
  if (descent.kind == Kind::kBlind) {
    return fmt::format("no recent range on {}: it {}", topic,
                       descent.z_m_s < 0 ? "descends slowly" : "does not descend blindly");
  }
  if (descent.kind == Kind::kAside) {
    return fmt::format("its sensor does not see below where it flies to: it {}",
                       descent.z_m_s < 0 ? "descends slowly" : "stays level");
  }
  if (descent.kind == Kind::kLow) return "a person may come below it: it descends slowly";
  if (descent.kind == Kind::kBeside) {
    const std::string high =
        descent.height_m ? fmt::format(" {:.1f} m high or higher", *descent.height_m) : "";
    return fmt::format("something{} is below it, or {:.2f} m beside it: it {}", high, descent.gap_m,
                       descent.z_m_s < 0 ? "descends slowly" : "does not descend");
  }
  const std::string what =
      descent.height_m ? fmt::format("something {:.1f} m high", *descent.height_m) : "something";
  return fmt::format("{} is {:.2f} m below it: it {}", what, descent.gap_m,
                     descent.kind == Kind::kHeld ? "does not descend" : "descends slowly");
}

// "12 degrees to the left".
std::string DirectionTo(const Point& at) {
  const double degrees = std::atan2(at.y_m, at.x_m) * 180 / M_PI;
  if (std::abs(degrees) < 0.5) return "straight ahead";
  if (std::abs(degrees) > 179.5) return "straight behind";
  return fmt::format("{:.0f} degrees to the {}", std::abs(degrees), degrees > 0 ? "left" : "right");
}

}  // namespace

bool GateZone::Has(const Point& point) const {
  bool inside = false;
  for (std::size_t i = 0, j = corners.size() - 1; i < corners.size(); j = i++) {
    const Point &a = corners[i], &b = corners[j];
    if ((a.y_m > point.y_m) == (b.y_m > point.y_m)) continue;
    const double along = (point.y_m - a.y_m) / (b.y_m - a.y_m);
    if (point.x_m < a.x_m + along * (b.x_m - a.x_m)) inside = !inside;
  }
  return inside;
}

std::string Describe(const GateVerdict& verdict) {
  using Kind = GateVerdict::Kind;
  if (verdict.kind == Kind::kFree) return "";
  if (verdict.kind == Kind::kBlind) {
    const std::string refused = verdict.refused.empty() ? "" : " (" + verdict.refused + ")";
    return fmt::format("no recent scan on {}{}: it does not move blindly", verdict.scanner,
                       refused);
  }
  if (!verdict.descent.empty() && !verdict.at) return verdict.descent;
  const Point at = verdict.at.value_or(Point{});
  const bool stops = verdict.kind == Kind::kStopped;
  if (verdict.unknown) {
    return fmt::format("no scanner covers the way {}: it {}", DirectionTo(at),
                       stops ? "stops" : "goes slowly");
  }
  std::string text =
      fmt::format("an obstacle {:.2f} m away, {}, ", std::hypot(at.x_m, at.y_m), DirectionTo(at));
  if (!verdict.zone.empty()) text += "in the zone " + verdict.zone + ", ";
  return text + (stops ? "stops it" : "slows it down");
}

void MotionGate::Track::Advance(const Velocity& velocity, Time from, Time to) {
  if (places_.empty()) places_.push_back({from, {}});
  const double seconds = std::clamp(ToSeconds(to - from), 0.0, kLongestTrackS);
  places_.push_back({to, Composed(places_.back().pose, OnArc(velocity, seconds))});
  while (places_.size() > 2 && places_.front().at < to - kKeptTrack) places_.pop_front();
}

Pose MotionGate::Track::Since(Time then) const {
  if (places_.empty()) return {};
  const auto first_after =
      std::lower_bound(places_.begin(), places_.end(), then,
                       [](const Place& place, Time at) { return place.at < at; });
  const Pose& was = first_after == places_.end()     ? places_.back().pose
                    : first_after == places_.begin() ? first_after->pose
                                                     : std::prev(first_after)->pose;
  const Pose& now = places_.back().pose;
  return {SeenFrom(was, now.at), now.yaw_rad - was.yaw_rad};
}

void MotionGate::Track::AddMoved(const std::vector<Point>& points, Time then,
                                 std::vector<Point>& moved) const {
  const Pose now = Since(then);
  for (const Point& point : points) moved.push_back(SeenFrom(now, point));
}

MotionGate::MotionGate(const GateRules& rules)
    : rules_(rules),
      views_(rules.scanners.begin(), rules.scanners.end()),
      watches_(rules.scanners.size()),
      descent_(rules.down, rules.radius_m, rules.brake_m_s2, rules.reaction_s) {}

void MotionGate::Mount(std::size_t scanner, const Pose& on_body, bool upside_down) {
  if (!mount(scanner).given) views_[scanner].Mount(on_body, upside_down);
}

bool MotionGate::OnScan(std::size_t scanner, const Scan& scan, Duration stamp, Time now) {
  Advance(now);
  if (scanner >= views_.size() || !views_[scanner].Take(scan, stamp, now)) return false;
  watches_[scanner].Take(views_[scanner],
                         [this](Time then) { return measured_track_.Since(then); });
  return true;
}

void MotionGate::OnVelocity(const Velocity& velocity, Time now) {
  const bool plausible = IsFinite(velocity) && OverGround(velocity) < kFastestMS &&
                         std::abs(velocity.yaw_rad_s) < kFastestMS;
  if (!plausible) return;
  Advance(now);
  measured_ = velocity;
  measured_at_ = now;
}

bool MotionGate::OnRange(const DownReading& reading, Duration stamp, Time now) {
  Advance(now);
  return descent_.Take(reading, stamp, now);
}

void MotionGate::OnHeight(double z_m, Time now) {
  Advance(now);
  descent_.OnHeight(z_m, Measured(now).z_m_s, now);
}

void MotionGate::Forget() {
  descent_.Forget();
  for (ScanView& view : views_) view.Forget();
  for (ApproachWatch& watch : watches_) watch.Forget();
  measured_track_.Clear();
  commanded_track_.Clear();
  measured_at_.reset();
  assumed_ = {};
  last_.reset();
  last_checked_.reset();
  held_since_.reset();
}

Velocity MotionGate::Measured(Time now) const {
  const bool recent = measured_at_ && now >= *measured_at_ && now - *measured_at_ <= kMeasuredStale;
  return recent ? measured_ : assumed_;
}

void MotionGate::Advance(Time now) {
  if (last_ && now < *last_ - kClockSetBack) Forget();
  // Without commands it stands.
  const bool commanded = last_checked_ && now - *last_checked_ <= kCommandStale;
  if (last_ && now > *last_ && !commanded) Assume({}, ToSeconds(now - *last_));
  if (last_ && now > *last_) {
    const double climb_m_s = std::min(Measured(*last_).z_m_s, assumed_.z_m_s);
    const double over_ground_m_s = std::max(OverGround(Measured(*last_)), OverGround(assumed_));
    descent_.Move(climb_m_s, over_ground_m_s, std::min(ToSeconds(now - *last_), kLongestTrackS));
    measured_track_.Advance(Measured(*last_), *last_, now);
    commanded_track_.Advance(assumed_, *last_, now);
  }
  if (!last_ || now > *last_) last_ = now;
}

bool MotionGate::IsRecent(const ScanView& view, Time now) const {
  return view.taken() && now - *view.taken() <= rules_.scan_stale;  // Advance() forgets the future
}

const ScanView* MotionGate::BlindView(Time now) const {
  for (const ScanView& view : views_) {
    if (!IsRecent(view, now)) return &view;
  }
  return nullptr;
}

const ScanMount* MotionGate::Blind(Time now) const {
  const ScanView* blind = BlindView(now);
  return blind == nullptr ? nullptr : &blind->mount();
}

// As far as a body with this speed has to look.
double MotionGate::AheadM(double speed_m_s) const {
  const double braking_m = speed_m_s * speed_m_s / (2 * rules_.brake_m_s2);
  return std::min(kLongestArcM, kArcStepM + braking_m +
                                    speed_m_s * std::max(rules_.reaction_s, rules_.approach_s));
}

double MotionGate::FastestMS(const Velocity& wanted) const {
  return std::max(
      {OverGround(wanted), OverGround(assumed_), measured_at_ ? OverGround(measured_) : 0});
}

// From which it stops within so much of its arc.
double MotionGate::SafeMS(double free_m) const {
  const double safe_m_s = StoppingSpeed(free_m, rules_.brake_m_s2, rules_.reaction_s);
  return rules_.approach_s > 0 ? std::min(safe_m_s, free_m / rules_.approach_s) : safe_m_s;
}

std::vector<MotionGate::Near> MotionGate::NearPoints(const std::vector<Point>& points,
                                                     double ahead_m) const {
  const double keep_m = rules_.radius_m + rules_.margin_m;
  std::vector<Near> near;
  for (const Point& point : points) {
    const double away_m = std::hypot(point.x_m, point.y_m);
    if (!(away_m <= ahead_m + keep_m)) continue;
    // One that is too near already: along it, with an error of the scan, but no nearer.
    const double slack_m = std::max(0.0, (away_m - rules_.radius_m - kTouchM) / 4);
    const double kept_m = away_m >= keep_m ? keep_m : away_m - slack_m - 1e-6;
    near.push_back({point, kept_m * kept_m});
  }
  return near;
}

double MotionGate::FreeArc(const std::vector<Near>& near, const Velocity& wanted, double ahead_m,
                           std::optional<Point>& at) const {
  const double speed_m_s = OverGround(wanted);
  for (double along_m = kArcStepM; !near.empty() && along_m < ahead_m + kArcStepM;
       along_m += kArcStepM) {
    at = Touched(near, OnArc(wanted, along_m / speed_m_s).at);
    if (at) return along_m - kArcStepM;
  }
  return ahead_m;
}

// On the way from its present velocity to the command, for the time of a reaction, and then to a
// stop.
std::optional<Point> MotionGate::TouchedOnTheWay(const std::vector<Near>& near,
                                                 std::vector<MovingPoint> moving,
                                                 const Velocity& present,
                                                 const Velocity& command) const {
  constexpr double kDtS = 0.02;
  constexpr int kMostSteps = 250;
  Velocity now = present;
  Pose body;
  // What is too near already counts as what stands.
  std::erase_if(moving, [this](const MovingPoint& point) {
    return std::hypot(point.at.x_m, point.at.y_m) < rules_.radius_m + rules_.margin_m;
  });
  for (int step = 0; step < kMostSteps; ++step) {
    const bool brakes = step * kDtS >= rules_.reaction_s;
    if (brakes && OverGround(now) < kStandsMS) break;
    const Velocity towards = brakes ? Velocity{} : command;
    const double x = towards.x_m_s - now.x_m_s, y = towards.y_m_s - now.y_m_s;
    const double change = std::hypot(x, y), most = rules_.brake_m_s2 * kDtS;
    // A command to stand is executed after the time of the reaction.
    const bool waits = !brakes && OverGround(command) < kStandsMS;
    const double part = waits ? 0 : change > most ? most / change : 1;
    now.x_m_s += part * x;
    now.y_m_s += part * y;
    now.yaw_rad_s = brakes ? now.yaw_rad_s * (1 - kDtS / rules_.reaction_s) : command.yaw_rad_s;
    body = Composed(body, OnArc(now, kDtS));
    if (auto touched = Touched(near, body.at)) return touched;
    if (auto met = Met(moving, body, now, (step + 1) * kDtS)) return met;
  }
  return std::nullopt;
}

// The first of the moving points that the body runs into at this place, so many seconds from now.
// What reaches it from behind is not run into, and is removed.
std::optional<Point> MotionGate::Met(std::vector<MovingPoint>& moving, const Pose& body,
                                     const Velocity& velocity, double seconds) const {
  const double keep_m = rules_.radius_m + rules_.margin_m;
  const auto place_of = [&](const MovingPoint& point) {
    return SeenFrom(
        body, {point.at.x_m + point.x_m_s * seconds, point.at.y_m + point.y_m_s * seconds, 0});
  };
  const auto touches = [&](const MovingPoint& point) {
    const Point place = place_of(point);
    return std::hypot(place.x_m, place.y_m) < keep_m;
  };
  const auto ahead = [&](const MovingPoint& point) {
    const Point place = place_of(point);
    return place.x_m * velocity.x_m_s + place.y_m * velocity.y_m_s > 0;
  };
  for (const MovingPoint& point : moving) {
    if (touches(point) && ahead(point)) return point.at;
  }
  std::erase_if(moving, touches);
  return std::nullopt;
}

void MotionGate::LimitByMomentum(const std::vector<Point>& points,
                                 const std::vector<MovingPoint>& moving, const Velocity& present,
                                 const Velocity& wanted, Limit& limit) const {
  constexpr double kSlowMS = 0.05;
  // A slower body stops at once. It passes a person who walks to and fro before it.
  constexpr double kGivesWayMS = 0.3;
  if (OverGround(present) < kSlowMS || limit.share == 0) return;
  const double fastest_m_s = std::max(OverGround(present), OverGround(wanted));
  const std::vector<Near> near = NearPoints(points, AheadM(fastest_m_s));
  const bool gives_way = OverGround(present) >= kGivesWayMS && !moving.empty();
  if (near.empty() && !gives_way) return;
  for (const double part : {1.0, 0.6, 0.3}) {
    Velocity command = wanted;
    command.x_m_s *= part * limit.share;
    command.y_m_s *= part * limit.share;
    command.yaw_rad_s *= part * limit.share;
    const auto touched =
        TouchedOnTheWay(near, gives_way ? moving : std::vector<MovingPoint>(), present, command);
    if (!touched && part < 1) limit.share *= part;
    if (!touched) return;
    limit.at = touched;
    limit.unknown = false;
  }
  limit.share = 0;
}

// A moving body that is stopped stays on its arc; one that stands may turn.
double MotionGate::YawOfAStop(const Velocity& wanted, double seconds) const {
  constexpr double kMovesMS = 0.1;
  const double speed_m_s = OverGround(assumed_);
  if (speed_m_s < kMovesMS) return wanted.yaw_rad_s;
  const double left = 1 - rules_.brake_m_s2 * seconds / speed_m_s;
  return assumed_.yaw_rad_s * std::max(0.0, left);
}

void MotionGate::LimitByArc(const std::vector<Point>& points, const Velocity& wanted,
                            Limit& limit) const {
  const double speed_m_s = OverGround(wanted);
  if (speed_m_s <= kStillMS) return;
  const double ahead_m = AheadM(FastestMS(wanted));
  std::optional<Point> at;
  const double free_m = FreeArc(NearPoints(points, ahead_m), wanted, ahead_m, at);
  if (!at) return;
  const double safe_m_s = SafeMS(free_m);
  const double share = safe_m_s < kStandsMS ? 0 : safe_m_s / speed_m_s;
  if (share < limit.share) limit = {share, at, "", false};
}

void MotionGate::LimitByUnknown(const Track& track, const Velocity& wanted, Time now,
                                Limit& limit) const {
  const double speed_m_s = OverGround(wanted);
  const double unknown_m_s = std::max(rules_.unknown_m_s, rules_.blind_m_s);
  if (views_.empty() || speed_m_s <= std::max(unknown_m_s, kStillMS)) return;
  struct Sight {
    const ScanView* view;
    Pose now;  // of the body, in the frame of the scan
  };
  std::vector<Sight> sights;
  double edge_m = rules_.radius_m + rules_.margin_m;  // from the middle of the body
  for (const ScanView& view : views_) {
    if (IsRecent(view, now)) sights.push_back({&view, track.Since(*view.taken())});
    // One in front of the body looks from there.
    const Point& sensor = view.mount().on_body.at;
    edge_m = std::max(edge_m, std::hypot(sensor.x_m, sensor.y_m) + rules_.margin_m);
  }
  const int steps = static_cast<int>(std::ceil(AheadM(FastestMS(wanted)) / kArcStepM));
  for (int step = 1; step <= steps; ++step) {
    const double along_m = step * kArcStepM;
    const Pose body = OnArc(wanted, along_m / speed_m_s);
    const double heading_rad = std::atan2(wanted.y_m_s, wanted.x_m_s) + body.yaw_rad;
    const Point edge{body.at.x_m + edge_m * std::cos(heading_rad),
                     body.at.y_m + edge_m * std::sin(heading_rad), 0};
    const bool covered = IsFinite(edge) && std::ranges::any_of(sights, [&](const Sight& sight) {
                           return sight.view->Covers(Composed(sight.now, {edge, 0}).at);
                         });
    if (covered) continue;
    const double safe_m_s = std::max(unknown_m_s, SafeMS(along_m - kArcStepM));
    const double share = safe_m_s < kStandsMS ? 0 : safe_m_s / speed_m_s;
    if (share < limit.share) limit = {share, edge, "", true};
    return;
  }
}

bool MotionGate::Covers(const Point& place, Time now) const {
  return std::ranges::any_of(views_, [&](const ScanView& view) {
    return IsRecent(view, now) &&
           view.Covers(Composed(measured_track_.Since(*view.taken()), {place, 0}).at);
  });
}

void MotionGate::LimitByZones(const std::vector<Point>& points, const Velocity& wanted,
                              Limit& limit) const {
  for (const GateZone& zone : rules_.zones) {
    int inside = 0;
    std::optional<Point> nearest, towards;
    for (const Point& point : points) {
      if (!zone.Has(point)) continue;
      ++inside;
      if (!nearest || std::hypot(point.x_m, point.y_m) < std::hypot(nearest->x_m, nearest->y_m)) {
        nearest = point;
      }
      if (point.x_m * wanted.x_m_s + point.y_m * wanted.y_m_s > 0) towards = point;
    }
    if (inside < zone.least_points) continue;
    if (zone.stops && towards && limit.share > 0) limit = {0, towards, zone.name, false};
    if (!zone.stops && zone.share < limit.share) limit = {zone.share, nearest, zone.name, false};
  }
}

// A body executes a faster command at once, but keeps what it has of another motion until it has
// braked it.
void MotionGate::Assume(const Velocity& command, double seconds) {
  const double speed_m_s = OverGround(command), most = rules_.brake_m_s2 * seconds;
  const bool moves = speed_m_s > kStandsMS;
  const double dx = moves ? command.x_m_s / speed_m_s : 1;
  const double dy = moves ? command.y_m_s / speed_m_s : 0;
  double along = assumed_.x_m_s * dx + assumed_.y_m_s * dy;
  double aside = assumed_.y_m_s * dx - assumed_.x_m_s * dy;
  if (along < 0) {
    along = std::min(along + most, 0.0);
  } else {
    along = std::max(speed_m_s, along - most);
  }
  aside -= std::clamp(aside, -most, most);
  assumed_ = {along * dx - aside * dy, along * dy + aside * dx, command.z_m_s, command.yaw_rad_s};
}

// What the scanners with a recent scan see, where it is now by the given motion.
std::vector<Point> MotionGate::Seen(const Track& track, Time now) const {
  std::vector<Point> seen;
  for (const ScanView& view : views_) {
    if (IsRecent(view, now)) track.AddMoved(view.points(), *view.taken(), seen);
  }
  return seen;
}

// The same of what moves by itself, where it is now if it has gone on.
std::vector<MovingPoint> MotionGate::SeenMoving(const Track& track, Time now) const {
  std::vector<MovingPoint> seen;
  for (std::size_t i = 0; i < views_.size(); ++i) {
    if (!IsRecent(views_[i], now)) continue;
    const Time taken = *views_[i].taken();
    const Pose body = track.Since(taken);
    const double c = std::cos(body.yaw_rad), s = std::sin(body.yaw_rad);
    const double seconds = ToSeconds(now - taken);
    for (const MovingPoint& point : watches_[i].moving()) {
      const Point at = SeenFrom(body, {point.at.x_m + point.x_m_s * seconds,
                                       point.at.y_m + point.y_m_s * seconds, point.at.z_m});
      seen.push_back({at, c * point.x_m_s + s * point.y_m_s, c * point.y_m_s - s * point.x_m_s});
    }
  }
  return seen;
}

// How fast it moves over the ground by its own commands: what the wind does to it is no reason to
// stay in the air, and a flyer that leans against that stands.
double MotionGate::AsideMS(Time now) const {
  const double assumed_m_s = OverGround(assumed_);
  const bool measured =
      measured_at_ && now >= *measured_at_ && now - *measured_at_ <= kMeasuredStale;
  const double measured_m_s = OverGround(measured_);
  if (!measured) return assumed_m_s;
  if (measured_m_s < kStillMS) return 0;
  const double along_m_s =
      (assumed_.x_m_s * measured_.x_m_s + assumed_.y_m_s * measured_.y_m_s) / measured_m_s;
  return std::clamp(along_m_s, 0.0, measured_m_s);
}

// From its middle to the nearest point of recent scans.
std::optional<double> MotionGate::NearestM(Time now) const {
  std::optional<double> nearest_m;
  for (const Point& point : Seen(measured_track_, now)) {
    const double away_m = std::hypot(point.x_m, point.y_m);
    if (!nearest_m || away_m < *nearest_m) nearest_m = away_m;
  }
  return nearest_m;
}

void MotionGate::LimitDescent(GateVerdict& verdict, Time now) {
  using Kind = GateVerdict::Kind;
  const Velocity wanted = verdict.command;
  const std::optional<double> wall_m = wanted.z_m_s < 0 ? NearestM(now) : std::nullopt;
  const DescentVerdict descent = descent_.Check(wanted.z_m_s, AsideMS(now), wall_m, now);
  if (descent.kind == DescentVerdict::Kind::kFree) return;
  verdict.command.z_m_s = descent.z_m_s;
  verdict.careful = descent.kind == DescentVerdict::Kind::kLow;
  verdict.descent = TextOf(descent, descent_.rules().topic);
  const bool stops = descent.z_m_s == 0 && descent.kind != DescentVerdict::Kind::kAside &&
                     -wanted.z_m_s >= OverGround(wanted);
  if (stops && verdict.kind != Kind::kBlind) verdict.kind = Kind::kStopped;
  if (verdict.kind == Kind::kFree) verdict.kind = Kind::kSlowed;
}

GateVerdict MotionGate::Check(const Velocity& wanted, Time now) {
  using Kind = GateVerdict::Kind;
  const double passed_s = last_checked_ ? ToSeconds(now - *last_checked_) : 0;
  last_checked_ = now;
  Advance(now);
  GateVerdict verdict;
  verdict.command = IsFinite(wanted) ? wanted : Velocity{};
  const double speed_m_s = OverGround(verdict.command);
  const ScanView* blind = verdict.command == Velocity{} ? nullptr : BlindView(now);
  Limit limit;
  if (blind && rules_.blind_m_s == 0) verdict.command = {};
  if (blind && (speed_m_s > rules_.blind_m_s || rules_.blind_m_s == 0)) {
    limit.share = speed_m_s > 0 ? rules_.blind_m_s / speed_m_s : 0;
    verdict.kind = Kind::kBlind;
    verdict.scanner = blind->mount().topic;
    verdict.refused = blind->why_refused();
  } else if (speed_m_s > kStillMS || OverGround(assumed_) > kStandsMS) {
    const std::vector<Point> seen = Seen(measured_track_, now);
    const std::vector<Point> commanded = Seen(commanded_track_, now);
    LimitByArc(seen, verdict.command, limit);
    LimitByArc(commanded, verdict.command, limit);
    LimitByUnknown(measured_track_, verdict.command, now, limit);
    LimitByUnknown(commanded_track_, verdict.command, now, limit);
    LimitByZones(seen, verdict.command, limit);
    LimitByMomentum(seen, SeenMoving(measured_track_, now), Measured(now), verdict.command, limit);
    LimitByMomentum(commanded, SeenMoving(commanded_track_, now), assumed_, verdict.command, limit);
    if (limit.share < 1) verdict.kind = limit.share > 0 ? Kind::kSlowed : Kind::kStopped;
  }
  verdict.command.x_m_s *= limit.share;
  verdict.command.y_m_s *= limit.share;
  const double step_s = std::clamp(passed_s, 0.0, kLongestTrackS);
  verdict.command.yaw_rad_s = limit.share > 0 ? verdict.command.yaw_rad_s * limit.share
                                              : YawOfAStop(verdict.command, step_s);
  verdict.at = limit.at;
  verdict.zone = limit.zone;
  verdict.unknown = limit.unknown;
  LimitDescent(verdict, now);
  if (!verdict.holds()) held_since_.reset();
  if (verdict.holds() && !held_since_) held_since_ = now;
  verdict.held = held_since_ ? now - *held_since_ : Duration{};
  Assume(verdict.command, step_s);
  return verdict;
}

}  // namespace musher::navigation
