#pragma once
// Where the body is when something has ended a climb in the middle, and the way off that edge. The
// hull is over two cells of different heights; `offset` is how far its centre is from their edge,
// positive over the upper one.
//
//                         wheels of the upper side        way
//   over the upper one    short                           all wheels short, to the upper centre
//   between               short, the lower ones stand     on to the upper one, then the same; where
//                                                         that is blocked, back until the wheels of
//                                                         the upper side are before the edge
//   hull on the edge      long, or still hanging          all wheels down, back to the lower centre
//
// Everything else is not certain: it moves nothing and says why. On level ground with long wheels
// the way is to the centre, then down.
//
// PlanOffEdge() gives the next step of the way; it is asked again after each, so that the way goes
// on from where the robot has come to.
//
// Pure: metres, radians, millimetres. Frame map.

#include <optional>
#include <string>

#include "musher/modules/meilin/nodes/settings.hpp"
#include "musher/modules/meilin/robot.hpp"

namespace musher::meilin {

inline constexpr double kShortWheelMm =
    20;                                     // on which the hull rests, and which rolls over an edge
inline constexpr double kOutWheelMm = 70;   // a wheel that is still out when a climb should be over
inline constexpr double kLongWheelMm = 45;  // a longer one is out
inline constexpr double kLowClimbMm = 205;  // of the wheels, as the suspension climbs low steps
inline constexpr double kHighClimbMm = 410;  // and high ones
inline constexpr double kLowStepMm = 300;

// An edge below the hull.
struct Edge {
  Cell upper;
  Cell lower;
  double step_mm = 0;
  double offset_m = 0;
  Direction up = Direction::kForward;  // from the lower to the upper cell, in the frame map
};

struct EdgeReading {
  std::optional<Edge> edge;
  std::string unclear;  // it is over more than one edge, or over that of the field; else empty
  bool on_edge() const { return edge.has_value() || !unclear.empty(); }
};
// Nothing of both: the hull is over ground of one height, or outside the grid.
EdgeReading FindEdge(const Grid& grid, Point2 at);

// A drive, or one height of all wheels.
struct OffEdgeStep {
  std::optional<MoveGoal> drive;
  double wheels_mm = 0;  // without a drive
};

struct OffEdge {
  std::optional<OffEdgeStep> next;  // nothing: there is nothing to do, or it is not certain
  bool on_edge = false;             // the hull is over two heights
  std::string unclear;              // why it is not certain; else empty
  Cell to;                          // where it ends
  std::string text;  // "on the edge of (1, 0) and (0, 0), wheels 410, 410, 20, 20 mm"
};

// `wheels`: nothing, they do not report; then an edge is not certain, and level ground is taken as
// it is.
OffEdge PlanOffEdge(const Settings& settings, const PoseFix& pose,
                    const std::optional<Wheels>& wheels, bool upper_blocked = false);

double LongestMm(const Wheels& wheels);
std::string WheelsText(const Wheels& wheels);  // "410, 410, 20, 20 mm"

}  // namespace musher::meilin
