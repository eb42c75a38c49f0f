#include "musher/modules/skills/skills/recovery.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace musher::skills {
namespace {

struct NamedRecovery {
  RecoveryKind kind;
  const char* name;
  Duration longest;
};
constexpr std::array<NamedRecovery, 4> kRecoveries = {{
    {RecoveryKind::kLeave, "leave", std::chrono::seconds(10)},
    {RecoveryKind::kWait, "wait", std::chrono::seconds(3)},
    {RecoveryKind::kBackUp, "back_up", std::chrono::seconds(6)},
    {RecoveryKind::kSpin, "spin", std::chrono::seconds(16)},
}};

constexpr double kRecoveryMS = 0.15;
constexpr double kRecoveryRadS = 0.6;
constexpr double kLeaveM = 0.3;
constexpr double kBackM = 0.4;
constexpr double kStraightRad = 0.2;
constexpr Duration kRecoveryHeldLimit = std::chrono::seconds(1);

const NamedRecovery& RecoveryOf(RecoveryKind kind) {
  return *std::find_if(kRecoveries.begin(), kRecoveries.end(),
                       [&](const NamedRecovery& named) { return named.kind == kind; });
}

// Away from what is near: what is nearest counts most.
double DirectionAway(const std::vector<navigation::Point>& around) {
  double x = 0, y = 0;
  for (const navigation::Point& point : around) {
    const double away_m = std::max(std::hypot(point.x_m, point.y_m), 0.01);
    x -= point.x_m / std::pow(away_m, 4);
    y -= point.y_m / std::pow(away_m, 4);
  }
  return std::atan2(y, x);
}

}  // namespace

Result<std::vector<RecoveryKind>> Recovery::Parse(const std::string& text) {
  std::vector<RecoveryKind> kinds;
  std::string word;
  for (const char letter : text + ",") {
    if (letter != ',' && letter != ' ') {
      word += letter;
      continue;
    }
    if (word.empty()) continue;
    const auto named = std::find_if(kRecoveries.begin(), kRecoveries.end(),
                                    [&](const NamedRecovery& one) { return one.name == word; });
    if (named == kRecoveries.end()) {
      return Error{kCodeParametersInvalid, "recoveries has '" + word.substr(0, 40) +
                                               "'; expected leave, wait, back_up and spin"};
    }
    kinds.push_back(named->kind);
    word.clear();
  }
  return kinds;
}

std::string Recovery::NameOf(RecoveryKind kind) {
  return RecoveryOf(kind).name;
}

void Recovery::Begin(RecoveryKind kind) {
  kind_ = kind;
  passed_ = held_ = {};
  begin_.reset();
  turned_rad_ = 0;
  turns_ = true;
}

navigation::Velocity Recovery::Command(const std::vector<navigation::Point>& around) const {
  switch (kind_) {
    case RecoveryKind::kWait:
      return {};
    case RecoveryKind::kBackUp:
      return {.x_m_s = -kRecoveryMS};
    case RecoveryKind::kSpin:
      return {.yaw_rad_s = kRecoveryRadS};
    case RecoveryKind::kLeave:
      break;
  }
  if (around.empty()) return {};
  if (!turns_) return {.x_m_s = kRecoveryMS};
  const double away_rad = DirectionAway(around);
  return {.yaw_rad_s = std::clamp(2 * away_rad, -kRecoveryRadS, kRecoveryRadS)};
}

bool Recovery::Step(const std::vector<navigation::Point>& around, Duration step) {
  passed_ += step;
  const auto pose = robot_.pose();
  if (!pose) {
    robot_.StopMotion();
    return passed_ >= RecoveryOf(kind_).longest;
  }
  if (!begin_) {
    begin_ = pose;
    last_yaw_rad_ = pose->yaw_rad;
  }
  turned_rad_ += std::abs(navigation::Wrapped(pose->yaw_rad - last_yaw_rad_));
  last_yaw_rad_ = pose->yaw_rad;
  const bool looks_away = around.empty() || std::abs(DirectionAway(around)) < kStraightRad;
  if (kind_ == RecoveryKind::kLeave && looks_away) turns_ = false;
  const double moved_m = std::hypot(pose->at.x_m - begin_->at.x_m, pose->at.y_m - begin_->at.y_m);
  const bool moved = (kind_ == RecoveryKind::kLeave && (moved_m >= kLeaveM || around.empty())) ||
                     (kind_ == RecoveryKind::kBackUp && moved_m >= kBackM) ||
                     (kind_ == RecoveryKind::kSpin && turned_rad_ >= 2 * M_PI);
  robot_.SetVelocity(moved ? navigation::Velocity{} : Command(around));
  held_ = robot_.HeldBy().empty() ? Duration{} : held_ + step;
  if (!moved && held_ < kRecoveryHeldLimit && passed_ < RecoveryOf(kind_).longest) return false;
  robot_.StopMotion();  // the base is free for the next drive
  return true;
}

}  // namespace musher::skills
