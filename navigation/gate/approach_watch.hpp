#pragma once
// What moves by itself, of what one scanner sees: a person, another robot. A point of a scan that
// is where an earlier scan has seen a free place has come there, with a velocity: from the nearest
// point of the earlier scan.
//
// A place was free where the rays of the earlier scan in its direction had gone well beyond it.
// What only comes into view, from behind something, moves not. One point alone is noise. Metres,
// radians, seconds; one thread.

#include <array>
#include <deque>
#include <functional>
#include <vector>

#include "musher/navigation/gate/scan_view.hpp"

namespace musher::navigation {

struct MovingPoint {
  Point at;
  double x_m_s = 0;
  double y_m_s = 0;
};

class ApproachWatch {
 public:
  // `since`: where the body is now, in the frame that it had at a time.
  void Take(const ScanView& scan, const std::function<Pose(Time)>& since);
  void Forget() {
    earlier_.clear();
    moving_.clear();
  }

  // Of the last scan, in the frame that the body had when it was taken.
  const std::vector<MovingPoint>& moving() const { return moving_; }

 private:
  struct Earlier {
    Time taken{};
    Point sensor;
    std::vector<Point> points;
    std::array<double, 360> free_m{};  // by degree, around the sensor; 0: not known
  };
  static double FreeOf(const Earlier& earlier, const Point& place);
  const Earlier* Reference(Time taken) const;

  std::deque<Earlier> earlier_;
  std::vector<MovingPoint> moving_;
};

}  // namespace musher::navigation
