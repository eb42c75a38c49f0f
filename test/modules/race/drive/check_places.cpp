#include "musher/test/modules/race/drive/check_places.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace musher::race::testing {
namespace {

using Eigen::Vector2d;

const Check& CheckNamed(const Course& course, const std::string& name) {
  const auto check = std::ranges::find(course.checks, name, &Check::name);
  if (check == course.checks.end()) throw std::runtime_error("no check " + name);
  return *check;
}

// Along the way that the place is beside.
double WayOf(const Twist& twist, Aside aside) {
  switch (aside) {
    case Aside::kAhead:
      return twist.forward_m_s;
    case Aside::kLeft:
      return twist.left_m_s;
    case Aside::kTurned:
      break;
  }
  return twist.yaw_rad_s;
}

class Places {
 public:
  Places(const Hall& hall, const SCurve& s) : hall_(hall) {
    const double arc = s.arc_deg * M_PI / 180;
    const double s_end = hall.bay_a_aside_m + hall.half_m() + 0.03 + 2 * s.radius_m * std::sin(arc);
    s2_y_ = -hall.s1_m + 2 * s.radius_m * (1 - std::cos(arc));
    s2_x_ = s_end + 0.98;
    board_x_ = s_end + 8.68 + hall.lane_length_m - Hall{}.lane_length_m;
  }

  std::vector<CheckPlace> All() {
    ZoneA();
    ZoneB();
    WayBack();
    return std::move(places_);
  }

 private:
  void Add(const char* state, const char* check, const Vector2d& at, double yaw_deg, Aside aside) {
    places_.push_back({state, check, {at, yaw_deg * M_PI / 180}, aside});
  }

  void ZoneA() {
    using enum Aside;
    constexpr double kSouth = -90;
    const double cross = -hall_.cross_m, bay = hall_.bay_a_aside_m, in = cross + hall_.bay_a_in_m;
    Add("START_TO_QRA", "junction_ycy", {0, 0}, 0, kAhead);
    Add("QRA_TO_A1", "right_ycy", {0, cross}, kSouth, kAhead);
    Add("QRA_TO_A1", "right_dy", {-bay, cross}, kSouth, kLeft);
    Add("QRA_TO_A1", "left_ycy", {-bay, cross}, kSouth, kAhead);
    Add("QRA_TO_A1", "bay_a_dy", {-bay, in}, kSouth, kAhead);
    Add("QRA_TO_A1", "right_dy", {-bay, in}, kSouth, kLeft);
    Add("QRA_TO_A2", "left_ycy", {0, cross}, kSouth, kAhead);
    Add("QRA_TO_A2", "left_dy", {bay, cross}, kSouth, kLeft);
    Add("QRA_TO_A2", "right_ycy", {bay, cross}, kSouth, kAhead);
    Add("QRA_TO_A2", "bay_a_dy", {bay, in}, kSouth, kAhead);
    Add("QRA_TO_A2", "left_dy", {bay, in}, kSouth, kLeft);
    Add("A1_TO_S1", "axis_right_dy", {0, cross}, kSouth, kLeft);
    Add("A2_TO_S1", "axis_left_dy", {0, cross}, kSouth, kLeft);
    Add("A1_TO_S1", "left_ycy", {0, -hall_.s1_m}, kSouth, kAhead);
    Add("A1_TO_S1", "front_ycy", {0, -hall_.s1_m}, 0, kTurned);
  }

  void ZoneB() {
    using enum Aside;
    constexpr double kWest = 180;
    const double lane = hall_.lane_aside_m, bay = hall_.bay_b_aside_m;
    const double in = board_x_ + hall_.bay_b_in_m;
    for (const double side : {1, -1}) {
      const bool left = side > 0;
      Add(left ? "S2_TO_L1" : "S2_TO_R1", "front_far_ycy", {s2_x_, s2_y_ + side * lane}, 0, kLeft);
    }
    for (const double side : {1, -1}) {
      const bool left = side > 0;
      Add(left ? "L1_TO_QRB" : "R1_TO_QRB", "cross_dy", {board_x_, s2_y_ + side * lane}, 0, kAhead);
      Add(left ? "L1_TO_QRB" : "R1_TO_QRB", left ? "right_inner_dy" : "left_inner_dy",
          {board_x_, s2_y_}, 0, kLeft);
    }
    for (const double side : {1, -1}) {
      const bool left = side > 0;
      const char* const to = left ? "QRB_TO_B1" : "QRB_TO_B2";
      const char* const from = left ? "B2_TO_B1" : "B1_TO_B2";
      const double y = s2_y_ + side * bay;
      Add(to, "front_ycy", {board_x_, y}, 0, kLeft);
      Add(to, "bay_dy", {in, y}, 0, kAhead);
      Add(to, "bay_sides_dy", {in, y}, 0, kLeft);
      Add(from, "cross_dy", {board_x_, y}, 0, kAhead);
      Add(from, left ? "left_dy" : "right_dy", {board_x_, y}, 0, kLeft);
      Add(left ? "B1_TO_L1" : "B2_TO_R1", "front_ycy", {in, y}, kWest, kTurned);
      Add(left ? "B1_TO_R1" : "B2_TO_L1", left ? "left_cross_ycy" : "right_cross_ycy",
          {board_x_, y}, kWest, kAhead);
      Add(left ? "B2_TO_L1" : "B1_TO_R1", left ? "right_dy" : "left_dy", {board_x_, y}, kWest,
          kLeft);
    }
  }

  void WayBack() {
    using enum Aside;
    constexpr double kSouth = -90, kWest = 180;
    for (const double side : {1, -1}) {
      Add(side > 0 ? "L1_TO_S2" : "R1_TO_S2", "bay_dy", {s2_x_, s2_y_ + side * hall_.lane_aside_m},
          kWest, kAhead);
    }
    Add("L1_TO_S2", "front_ycy", {s2_x_, s2_y_}, kWest, kLeft);
    Add("A1_TO_START", "start_ycy", {0, 0}, kSouth, kAhead);
    Add("A1_TO_START", "front_start_ycy", {0, 0}, 0, kTurned);
    Add("A1_TO_START", "start_dy", {-hall_.start_m + 0.4, 0}, 0, kAhead);
  }

  const Hall& hall_;
  double s2_x_ = 0, s2_y_ = 0;  // where the way back ends, one metre before the line behind S2
  double board_x_ = 0;          // before board B
  std::vector<CheckPlace> places_;
};

}  // namespace

std::vector<CheckPlace> CheckPlaces(const Hall& hall, const SCurve& s) {
  return Places(hall, s).All();
}

Saying SaidFrom(CourseDrive& drive, const CheckPlace& place, double off) {
  constexpr double kAtPlace = 0.04, kFarM = 0.25, kFarRad = 0.2;
  const Check& check = CheckNamed(drive.course(), place.check);
  const double yaw = place.at.yaw_rad;
  world::Pose2 from = place.at;
  if (place.aside == Aside::kAhead) from.position_m += off * Vector2d(std::cos(yaw), std::sin(yaw));
  if (place.aside == Aside::kLeft) from.position_m += off * Vector2d(-std::sin(yaw), std::cos(yaw));
  if (place.aside == Aside::kTurned) from.yaw_rad += off;
  const msg::YellowLines lines = drive.LinesFrom(check.detector, from);
  if (!lines.doubt.empty() || lines.contours == 0) return Saying::kUnsure;
  const LineWord word =
      LineWordOf(check.by == Check::By::kDy ? lines.dy : lines.ycy).value_or(LineWord::kCenter);
  double way = 0;
  if (word != LineWord::kCenter) {
    const Corrections& all = place.aside == Aside::kTurned ? check.after_turn : check.usual;
    const auto& correction = all.at(static_cast<std::size_t>(word));
    const bool accepted = check.accepted.at(static_cast<std::size_t>(word));
    if (!correction && !accepted) return Saying::kUnsure;  // it is given up
    if (correction) way = WayOf(drive.course().movements[correction->movement].twist, place.aside);
  }
  if (way == 0) {
    const double far = place.aside == Aside::kTurned ? kFarRad : kFarM;
    return std::abs(off) >= far ? Saying::kNone : Saying::kRight;
  }
  if (std::abs(off) < kAtPlace) return Saying::kRight;  // a small step
  return way * off < 0 ? Saying::kRight : Saying::kAway;
}

}  // namespace musher::race::testing
