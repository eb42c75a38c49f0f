#include "musher/navigation/gate/descent_watch.hpp"

#include <algorithm>

namespace musher::navigation {
namespace {

constexpr double kMostKeptM = 1.5;  // above what a narrow cone sees
constexpr double kNarrowestRad = 0.02, kWidestRad = 2.8;
constexpr double kHeightJumpM = 0.2;  // more than it can have moved
constexpr double kStandingM = 0.1;    // of height, in which a range has to change
constexpr double kDescentMS = 0.02;   // a slower one is none
constexpr Duration kHeightStale = Milliseconds(500);
constexpr Duration kJumpCounts = std::chrono::minutes(1);
// Of two ranges which say together that something comes nearer by itself.
constexpr Duration kLeastBetween = Milliseconds(40), kMostBetween = Milliseconds(350);
constexpr double kRangeErrorM = 0.03;
constexpr double kComesMS = 0.3;  // a slower one counts as standing
constexpr Duration kComesFor = std::chrono::seconds(1);
constexpr double kStepsOffMS2 = 2;  // of a person who stood
constexpr double kSameDistanceM = 0.05;

double HalfCone(double cone_rad) {
  const double usable = std::isfinite(cone_rad) ? cone_rad : 0;
  return std::clamp(usable, kNarrowestRad, kWidestRad) / 2;
}

// Until a person who stands, or walks slower than kComesMS, has come so far.
double TimeToStepOff(double way_m) {
  if (way_m <= 0) return 0;
  return (std::sqrt(kComesMS * kComesMS + 2 * kStepsOffMS2 * way_m) - kComesMS) / kStepsOffMS2;
}

}  // namespace

double DescentWatch::KeepOf(double cone_rad) const {
  const double covered_m =
      rim_m() / std::tan(HalfCone(cone_rad)) - rules_.on_body.z_m - rules_.foot_m;
  return std::max(rules_.margin_m, std::min(covered_m, kMostKeptM));
}

std::optional<double> DescentWatch::HeightAt(Time now) const {
  if (!height_ || now - height_->at > kHeightStale) return std::nullopt;
  const bool counts = now - jumped_at_ <= kJumpCounts;
  return height_->z_m + (counts ? std::max(0.0, -jumped_m_) : 0);
}

bool DescentWatch::Stands(double range_m, std::optional<double> height_m) {
  if (!height_m || same_range_m_ != range_m) {
    same_range_m_ = range_m;
    same_since_m_ = height_m;
    return false;
  }
  if (!same_since_m_) same_since_m_ = height_m;
  return std::abs(*height_m - *same_since_m_) > kStandingM;
}

bool DescentWatch::Take(const DownReading& reading, Duration stamp, Time now) {
  const double least_m = rules_.least_m.value_or(reading.least_m);
  const double most_m = rules_.most_m.value_or(reading.most_m);
  const double range_m = reading.range_m;
  const bool negative = std::isfinite(range_m) && range_m < 0;
  if (std::isnan(range_m) || negative || !std::isfinite(most_m) || !(most_m > 0)) return false;
  const auto taken = age_.Take(stamp, now);
  if (!taken) return false;
  const auto height_m = HeightAt(now);
  const double counted_m = range_m < least_m ? 0 : std::min(range_m, most_m);
  if (counted_m > 0 && counted_m < most_m && Stands(range_m, height_m)) return false;
  const double cone_rad = rules_.cone_rad.value_or(reading.cone_rad);
  Sample sample{.taken = *taken, .keep_m = KeepOf(cone_rad)};
  if (height_m) {
    sample.surface_m = *height_m + rules_.on_body.z_m - counted_m;
    const bool nothing = range_m >= most_m;
    if (nothing && *sample.surface_m < ground_m() - rules_.ground_tolerance_m) return false;
  }
  // The nearest thing may be at the edge of the cone.
  const double edge = std::cos(std::clamp(cone_rad, 0.0, kWidestRad) / 2);
  sample.gap_m = counted_m * (std::isfinite(edge) ? edge : 1) - rules_.on_body.z_m - rules_.foot_m -
                 sinking_m_s_ * ToSeconds(now - *taken);
  sample.cone_sine = std::sin(HalfCone(cone_rad));
  sample.most_m = most_m;
  sample.side_m = counted_m * sample.cone_sine;
  if (ComesNearer(counted_m, sample.cone_sine, *taken)) came_nearer_ = now;
  last_[1] = last_[0];
  last_[0] = sample;
  return true;
}

// By more than the body itself has moved. Without an earlier range it is not known.
bool DescentWatch::ComesNearer(double range_m, double cone_sine, Time taken) {
  while (!ranges_.empty() && taken - ranges_.front().taken > kMostBetween) ranges_.pop_front();
  bool known = false, nearer = false;
  for (const Range& before : ranges_) {
    const Duration between = taken - before.taken;
    if (between < kLeastBetween) continue;
    known = true;
    const double sunk_m = std::max(0.0, sunk_m_ - before.sunk_m);
    const double nearer_m = before.range_m - sunk_m - range_m;
    const double by_itself_m = nearer_m * cone_sine - (moved_m_ - before.moved_m);
    nearer = nearer || by_itself_m > kComesMS * ToSeconds(between) + kRangeErrorM * cone_sine;
  }
  ranges_.push_back({taken, range_m, sunk_m_, moved_m_});
  return nearer || !known;
}

void DescentWatch::OnHeight(double z_m, double climb_m_s, Time now) {
  if (!std::isfinite(z_m) || !std::isfinite(climb_m_s)) return;
  if (height_ && now - height_->at <= kHeightStale) {
    const double moved_m = (height_->climb_m_s + climb_m_s) / 2 * ToSeconds(now - height_->at);
    const double jump_m = z_m - height_->z_m - moved_m;
    if (std::abs(jump_m) > kHeightJumpM) {
      jumped_m_ = jump_m + (now - jumped_at_ <= kJumpCounts ? jumped_m_ : 0);
      jumped_at_ = now;
      level_m_.reset();
    }
  }
  height_ = Height{z_m, climb_m_s, now};
}

void DescentWatch::Move(double climb_m_s, double over_ground_m_s, double seconds) {
  sinking_m_s_ = std::max(0.0, -climb_m_s);
  sunk_m_ -= climb_m_s * seconds;
  moved_m_ += over_ground_m_s * seconds;
  for (auto& sample : last_) {
    if (sample) sample->gap_m -= sinking_m_s_ * seconds;
  }
}

void DescentWatch::Forget() {
  last_ = {};
  age_.Forget();
  height_.reset();
  level_m_.reset();
  jumped_m_ = sinking_m_s_ = 0;
  same_range_m_.reset();
  same_since_m_.reset();
  ranges_.clear();
  came_nearer_.reset();
}

bool DescentWatch::IsRecent(const std::optional<Sample>& sample, Time now) const {
  return sample && now - sample->taken <= rules_.stale;
}

bool DescentWatch::IsBlind(Time now) const {
  return !rules_.topic.empty() && !(IsRecent(last_[0], now) && IsRecent(last_[1], now));
}

void DescentWatch::LimitAside(DescentVerdict& verdict, std::optional<double> height_m) const {
  const double free_m = height_m && level_m_ ? *height_m - *level_m_ : 0;
  const double level_m_s = StoppingSpeed(free_m, brake_m_s2_, reaction_s_);
  const double safe_m_s = std::max(level_m_s, must_land_ ? rules_.blind_m_s : 0);
  if (-verdict.z_m_s <= safe_m_s) return;
  verdict.z_m_s = safe_m_s < kDescentMS ? 0 : -safe_m_s;
  verdict.kind = DescentVerdict::Kind::kAside;
}

// The body has to stand before a person is below its rim.
void DescentWatch::LimitBeside(DescentVerdict& verdict, const Sample& sample,
                               std::optional<double> wall_m, Time now) const {
  if (rules_.person_m_s <= 0) return;
  const bool comes = came_nearer_ && now - *came_nearer_ <= kComesFor;
  const double off_m = std::hypot(rules_.on_body.x_m, rules_.on_body.y_m);
  const bool is_wall = wall_m && std::abs(*wall_m - sample.side_m) <= kSameDistanceM + off_m;
  if (!comes && is_wall) return;
  const double way_m = sample.side_m - rim_m();
  const double least_s = comes ? way_m / rules_.person_m_s : TimeToStepOff(way_m);
  const double left_s = least_s - ToSeconds(now - sample.taken) - reaction_s_;
  double safe_m_s = std::max(0.0, brake_m_s2_ * left_s);
  if (must_land_ && !comes) safe_m_s = std::max(safe_m_s, rules_.low_m_s);
  if (-verdict.z_m_s <= safe_m_s) return;
  verdict.z_m_s = safe_m_s < kDescentMS ? 0 : -safe_m_s;
  verdict.kind = DescentVerdict::Kind::kBeside;
  verdict.gap_m = std::max(0.0, way_m);
  verdict.height_m.reset();
  if (sample.surface_m) verdict.height_m = *sample.surface_m - ground_m();
}

// A person is seen once the rim of the cone meets one above ground_tolerance_m: so far from the
// middle at least, and no earlier than with the next range.
void DescentWatch::LimitLow(DescentVerdict& verdict, Time now) const {
  if (rules_.person_m_s <= 0) return;
  double safe_m_s = rules_.low_m_s;
  if (height_ && now - height_->at <= kHeightStale) {
    const double above_m = height_->z_m - ground_m();
    const double along_m = above_m + rules_.on_body.z_m - rules_.ground_tolerance_m;
    const double seen_m = std::min(along_m, last_[0]->most_m) * last_[0]->cone_sine;
    const Duration next = std::max(now - last_[0]->taken, last_[0]->taken - last_[1]->taken);
    const double left_s = (seen_m - rim_m()) / rules_.person_m_s - ToSeconds(next) - reaction_s_;
    safe_m_s = std::max(safe_m_s, brake_m_s2_ * left_s);
    const double free_m = above_m - rules_.foot_m - rules_.person_m;
    if (free_m > 0) {
      safe_m_s = std::max(safe_m_s, StoppingSpeed(free_m, brake_m_s2_, reaction_s_));
    }
  }
  if (-verdict.z_m_s <= safe_m_s) return;
  verdict.z_m_s = -safe_m_s;
  verdict.kind = DescentVerdict::Kind::kLow;
}

DescentVerdict DescentWatch::Check(double z_m_s, double aside_m_s, std::optional<double> wall_m,
                                   Time now) {
  using Kind = DescentVerdict::Kind;
  DescentVerdict verdict{.z_m_s = z_m_s};
  if (rules_.topic.empty()) return verdict;
  const auto height_m = HeightAt(now);
  const bool aside = aside_m_s > kAsideMS;
  if (!aside || z_m_s > 0 || !level_m_) level_m_ = height_m;
  if (!(z_m_s < 0)) return verdict;
  if (height_m && IsGround(*height_m - rules_.foot_m)) return verdict;
  if (IsBlind(now)) {
    verdict.kind = Kind::kBlind;
    verdict.z_m_s = must_land_ ? std::max(z_m_s, -rules_.blind_m_s) : 0;
    return verdict;
  }
  LimitLow(verdict, now);
  if (aside) LimitAside(verdict, height_m);
  for (const auto& sample : last_) {
    if (sample->surface_m && IsGround(*sample->surface_m)) continue;
    LimitBeside(verdict, *sample, wall_m, now);
    const double safe_m_s = StoppingSpeed(sample->gap_m - sample->keep_m, brake_m_s2_, reaction_s_);
    if (-verdict.z_m_s <= safe_m_s) continue;
    verdict.z_m_s = safe_m_s < kDescentMS ? 0 : -safe_m_s;
    verdict.kind = verdict.z_m_s < 0 ? Kind::kSlowed : Kind::kHeld;
    verdict.gap_m = std::max(0.0, sample->gap_m);
    verdict.height_m.reset();
    if (sample->surface_m) verdict.height_m = *sample->surface_m - ground_m();
  }
  return verdict;
}

}  // namespace musher::navigation
