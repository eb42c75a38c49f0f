#pragma once
// Where the robot looks. A gaze is what wedding/motion/look_at carries: 0.5 is straight ahead, x
// from 0 (fully to the left) to 1 (fully to the right), y from 0 (up) to 1 (down).

#include <array>
#include <cstddef>
#include <optional>

#include "musher/base/time.hpp"

namespace musher::wedding {

struct Gaze {
  double x = 0.5;
  double y = 0.5;

  friend bool operator==(const Gaze&, const Gaze&) = default;
};

// Whether a coordinate of a gaze or of a picture is valid: 0 to 1. False for NaN.
constexpr bool IsInUnitRange(double value) {
  return value >= 0 && value <= 1;
}

// Where the camera sits.
enum class Mount {
  kBody,  // it does not move: a point of its picture is a gaze
  kHead,  // it turns with the head: the head's angles at the picture's time are added
};

struct GazeRules {
  double follow = 0.3;  // share of the way to the target in each 20 ms
  Mount camera = Mount::kBody;
  double hfov_rad = 1.2;                    // opening of a camera on the head, from edge to edge
  double height_to_width = 0.75;            // of its picture
  double yaw_limit_rad = 2.0;               // of head and waist together, to each side
  double pitch_limit_rad = 0;               // up and down; 0: the robot cannot nod
  double pitch_speed_rad_s = 0.5;           // of a nod
  Duration joints_age = Milliseconds(500);  // how long the head's measured angles are valid

  friend bool operator==(const GazeRules&, const GazeRules&) = default;
};

// One step of the way to `target`: the same path at every tick rate. A long step counts as 100 ms,
// so that nothing jumps after a pause.
Gaze Follow(Gaze from, Gaze target, double follow, Duration step);

// The angles of the head: to the left and down.
struct HeadAngles {
  double yaw_rad = 0;
  double pitch_rad = 0;
};

// The gaze at a point of a picture, 0 to 1 each, taken with those head angles.
Gaze GazeAt(Gaze point, const HeadAngles& head, const GazeRules& rules);

// One step of a head that nods towards a gaze. No joint measures the nod: it is computed.
double Nod(double pitch_rad, Gaze gaze, const GazeRules& rules, Duration step);

// An angle of the head over the last second, so that a picture that arrives late is interpreted
// with the angle at its stamp.
class AngleTrail {
 public:
  // `stamp` since any epoch. A stamp before the last one starts a new trail: a clock was set back.
  void Add(Duration stamp, double angle_rad);
  // Interpolated between the two nearest entries; the last one after the end of the trail, nothing
  // before its beginning.
  std::optional<double> At(Duration stamp) const;
  std::optional<double> Last() const;
  void Clear() { size_ = 0; }

 private:
  struct Entry {
    Duration stamp{};
    double angle_rad = 0;
  };
  static constexpr std::size_t kCapacity = 128;
  static constexpr Duration kSpacing = Milliseconds(10);
  const Entry& Back(std::size_t i) const;  // 0 is the newest

  std::array<Entry, kCapacity> ring_{};
  std::size_t next_ = 0;
  std::size_t size_ = 0;
};

}  // namespace musher::wedding
