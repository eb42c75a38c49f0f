#pragma once
// Where the body is in its lane: an estimate of the lane's middle as an arc in the odometry's
// frame, corrected by each line that is seen, and continued by odometry between pictures. Pure.
// Metres, radians, to the left positive. Any thread.

#include <optional>

#include "musher/modules/line_walker/line_fit.hpp"
#include "musher/modules/line_walker/odometry_track.hpp"

namespace musher::line_walker {

// The body seen from the lane.
struct InLane {
  double offset_m = 0;         // to the left of the lane's middle
  double heading_rad = 0;      // from the lane's direction beside the body
  double curvature_per_m = 0;  // of the lane's middle there
};

// By one line of the lane alone, whose width is known.
InLane InLaneBy(const SideLine& line, Side side, double lane_width_m);

struct LaneRules {
  double width_m = 0.83;         // between the inner edges of its lines
  double left_gain = 0.5;        // share of a new sight of the leading line in the estimate
  double right_gain = 0.2;       // the same of the line that helps
  double curvature_share = 0.6;  // of these gains, for the curvature
  double jump_m = 0.2;           // a sight farther from the estimate is not believed at once
  double jump_rad = kDegree * 28;
  int jumps = 4;               // such sights in a row of one side are believed
  double first_aside_m = 0.3;  // the first line of a walk shows the body at most so far beside the
  double first_rad = kDegree * 35;  // middle and turned by so much; others are of another lane

  friend bool operator==(const LaneRules&, const LaneRules&) = default;
};

class LaneEstimate {
 public:
  explicit LaneEstimate(const LaneRules& rules) : rules_(rules) {}

  bool known() const { return known_; }
  // Whether a line may be of the lane that begins ahead of the body.
  bool MayBeFirst(const SideLine& line, Side side) const;
  void Forget() { *this = LaneEstimate(rules_); }

  // A line seen from `pose`. `alone`: the other side is not seen at present, so this one leads.
  // False where it contradicts the estimate and is not believed.
  bool See(const Pose& pose, const SideLine& line, Side side, bool alone);

  // From `pose` on the lane is straight.
  void Straighten(const Pose& pose);

  // Not before it is known.
  InLane At(const Pose& pose) const;

 private:
  void Set(const Pose& pose, const InLane& in_lane);

  LaneRules rules_;
  bool known_ = false;
  Pose middle_;  // a point of the lane's middle, and the lane's direction there
  double curvature_per_m_ = 0;
  int jumps_left_ = 0;  // sights in a row that were not believed
  int jumps_right_ = 0;
};

}  // namespace musher::line_walker
