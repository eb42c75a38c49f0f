#pragma once
// What a body has seen around it lately: a square grid that moves with it, in the frame of the map.
// A point marks its cell; a ray that passes a mark clears it; a mark that nothing confirms decays.
// So a dead end of things that the map does not have stays known while it is out of sight. Planner
// and controller have the same grid of the same scans, so a way around what one has seen is one
// that the other drives.
//
// A map does not change it: what is seen is not erased by what is believed. A jump of the
// localisation clears it: what was seen is elsewhere. Metres; pure; one thread.

#include <cstdint>
#include <optional>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/navigation/controller/obstacle_watch.hpp"

namespace musher::navigation {

struct LocalGridRules {
  double side_m = 10;
  double resolution_m = 0.05;
  Duration decay = std::chrono::seconds(30);
};

class LocalGrid {
 public:
  explicit LocalGrid(const LocalGridRules& rules);

  // Where the body is, by each odometry.
  void NotePlace(const Point& place);
  // `sensor`: where the scan was taken, in the map.
  void Add(const Scan& scan, const Pose& sensor, Time now);
  void Clear();

  // The marks that have not decayed, of the square around the last sensor.
  std::vector<Point> Points(Time now) const;

 private:
  struct Mark {
    Point at;
    std::optional<Time> seen;
  };
  struct Index {
    std::int64_t x = 0;
    std::int64_t y = 0;
  };

  Index IndexOf(double x_m, double y_m) const;
  Mark& At(const Index& index);
  // Of the square around the sensor; another place may share its mark.
  bool IsNear(const Point& point) const;
  // Of the scan, whether one of its rays passes the mark.
  bool IsPassed(const Mark& mark, const Scan& scan, const Pose& sensor) const;

  const LocalGridRules rules_;
  const std::int64_t cells_;  // along a side
  std::vector<Mark>
      marks_;  // of a cell at its index modulo the side: nothing is copied as it moves
  Point middle_;
  std::optional<Point> place_;
};

}  // namespace musher::navigation
