#pragma once
// Detects beside the loop: a detector takes some milliseconds for a picture, or many. For faces and
// for what is on a course: a detector `D` has a type `D::Input`, which derives from Shot, a type
// `D::Found`, and a function `Found Process(const Input&)`, which may throw.
//
// Threads: Load() and Busy() from any; Submit() on the loop, where the results are delivered.

#include <cstdint>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"

namespace musher::vision {

struct DetectorLimits {
  Duration hang = Milliseconds(5000);  // a picture that takes longer: the detector hangs
  int failures = 5;                    // in a row, after which the detector is lost

  friend bool operator==(const DetectorLimits&, const DetectorLimits&) = default;
};

template <class D>
struct DetectionResult {
  std::int64_t stamp_ns = 0;
  std::uint32_t width_px = 0;
  std::uint32_t height_px = 0;
  Result<typename D::Found> found;  // or how the detector failed
  Duration took{};
};

template <class D>
class DetectorWorker {
 public:
  virtual ~DetectorWorker() = default;

  // Creates the detector, unless it exists. Fails with the reason.
  virtual Result<> Load() = 0;

  // The newest picture; on_result gets its result later.
  virtual void Submit(typename D::Input shot) = 0;

  // How long the detector has been processing the same picture; zero: none.
  virtual Duration Busy() const = 0;
};

}  // namespace musher::vision
