#pragma once
// Old plans, a JSON text on planning/segments:
//
//   {"stage": "meilin", "plan_id": "7", "segments": [
//     {"segment_type": "ALIGN", "move_target": {"x": 1.0, "y": -0.3, "yaw": 3.14}, "max_speed":
//     0.3},
//     {"segment_type": "CLIMB", "move_target": {…}, "climb_mode": "UP", "climb_height": 200}]}
//
// A type sets the defaults of the other keys; the competition's system has them. Speeds m/s, times
// s, heights mm, lengths m, angles rad. Pure functions; they never throw.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/modules/meilin/field/grid.hpp"
#include "musher/modules/meilin/plan/segment.hpp"

namespace musher::meilin {

struct SegmentsReading {
  std::string stage;
  std::string plan_id;
  std::vector<Segment> segments;      // empty if there are faults
  std::string text;                   // the same JSON in one line, ASCII; empty if there are faults
  std::vector<std::string> faults;    // each with its place: "segments[2].climb_mode: …"
  std::vector<std::string> warnings;  // of what a server refuses later

  bool ok() const { return faults.empty(); }
  std::string message() const { return faults.empty() ? "" : faults.front(); }
};

SegmentsReading ReadSegmentsJson(std::string_view text);

// Why a robot at `start` (nothing: not known) does not come along the poses of these segments: a
// straight way crosses another height, or a climb is none from where the robot is then. Empty: it
// does.
std::string WhyNoWay(const std::vector<Segment>& segments, const Grid& grid, double tolerance_mm,
                     const std::optional<Point2>& start);

// Whether a robot at this point is where that climb leads to. False for other segments.
bool IsClimbTo(const Segment& segment, const Grid& grid, Point2 at);

// Whether a segment of that type drives to its pose.
bool DrivesToPose(std::string_view type);

// "SPEAR_PREP", "ALIGN", … in the order of a match.
std::vector<std::string_view> OldSegmentTypes();

}  // namespace musher::meilin
