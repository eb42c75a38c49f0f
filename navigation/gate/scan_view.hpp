#pragma once
// What one scanner of a body sees: its last scan as points in the frame of the body (x forward, y
// to the left, z up from its base), the directions that it covers, and when it was taken.
//
// A scan without a single measurement (no rays, or all of them NaN or nearer than its least range)
// says nothing and is refused, and so are one whose rays have no directions (an angle step of 0)
// and a repeated and a late one (sample_age.hpp). Metres; one thread.

#include <bitset>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/navigation/controller/obstacle_watch.hpp"
#include "musher/navigation/gate/sample_age.hpp"

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
  // Why the last scan was refused; empty: it was not.
  const std::string& why_refused() const { return why_refused_; }
  // Whether a ray with a measurement points to this place of the same frame: what is there, or
  // before it, is seen.
  bool Covers(const Point& place) const;

 private:
  void NoteCovered(const Scan& counted);

  ScanMount mount_;
  std::vector<Point> points_;
  Point sensor_;              // of the last scan
  std::bitset<360> covered_;  // its degrees, around the sensor
  std::optional<Time> taken_;
  SampleAge age_;
  std::string why_refused_;
};

}  // namespace musher::navigation
