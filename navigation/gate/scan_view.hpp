#pragma once
// What one scanner of a body sees: its last scan as points in the frame of the body (x forward, y
// to the left, z up from its base), the directions that it covers, and when it was taken.
//
// A scan without a single measurement (no rays, or all of them NaN or nearer than its least range)
// says nothing and is refused, and so are a repeated and a late one: what a robot believed to see
// has to get old. How late a scan came is the age of its stamp beyond that of the fastest one, so
// the clocks need not agree. One that was set, either way, begins again. Metres; one thread.

#include <bitset>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/navigation/controller/obstacle_watch.hpp"

namespace musher::navigation {

// Where a scanner is on its body, and what of its scans counts.
struct ScanMount {
  std::string topic;  // of its scans, for messages
  Pose on_body{};
  bool upside_down = false;  // its rays turn the other way round
  bool given = false;        // else a transform on /tf counts, where there is one
  double least_m = 0;        // nearer points are of the body itself
  double most_m = std::numeric_limits<double>::infinity();
};

// The scan with the limits of the mount. One from upside down is turned, as if the scanner stood.
Scan CountedBy(const ScanMount& mount, const Scan& scan);

class ScanView {
 public:
  explicit ScanView(ScanMount mount) : mount_(std::move(mount)) {}

  // `stamp`: of the message, since the zero of its clock; 0: it has none. False: it is refused.
  bool Take(const Scan& scan, Duration stamp, Time now);
  void Forget();

  const ScanMount& mount() const { return mount_; }
  // For the scans from now on.
  void Mount(const Pose& on_body, bool upside_down) {
    mount_.on_body = on_body;
    mount_.upside_down = upside_down;
  }
  // In the frame that the body had when the scan was taken.
  const std::vector<Point>& points() const { return points_; }
  const Point& sensor() const { return sensor_; }  // of these points, in the same frame
  std::optional<Time> taken() const { return taken_; }
  // Whether a ray with a measurement points to this place of the same frame: what is there, or
  // before it, is seen.
  bool Covers(const Point& place) const;

 private:
  bool IsNew(Duration stamp, Time now);
  void NoteCovered(const Scan& counted);

  ScanMount mount_;
  std::vector<Point> points_;
  Point sensor_;              // of the last scan
  std::bitset<360> covered_;  // its degrees, around the sensor
  std::optional<Time> taken_;
  std::optional<Duration> last_stamp_;
  std::optional<Duration> offset_;  // from a stamp to our time, of the fastest scan
  Time last_at_{};
};

}  // namespace musher::navigation
