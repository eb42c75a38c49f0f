#pragma once
// What the hardware of the lift chassis reports, filtered, and its order as seen in the direction
// of a climb. Pure. Millimetres; a switch is on when a surface is close below its wheel.
//
//   wheels and switches   0 front-left, 1 front-right, 2 rear-left, 3 rear-right, of the body
//   distances             0 and 1 at the front, 2 and 3 left, 4 and 5 rear, 6 and 7 right: the even
//                         ones look down, the odd ones ahead
//
// modules/meilin/servers/README.md has the geometry.

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

namespace musher::meilin::servers {

inline constexpr std::size_t kWheels = 4;
inline constexpr std::size_t kDistances = 8;

using WheelHeights = std::array<double, kWheels>;
using Corners = std::array<std::size_t, kWheels>;

// Of a climb, in the frame of the body, with the numbers of the action.
enum class ClimbDirection : std::uint8_t { kForward, kLeft, kRight, kBackward };

// As seen in the direction of a climb: which wheels and switches are front-left, front-right,
// rear-left and rear-right, and which distances look down in front, ahead, behind, and down behind.
struct ClimbView {
  Corners corners;
  std::array<std::size_t, 4> distances;
};
const ClimbView& ViewOf(ClimbDirection direction);

// The mean of the last five distances; none before the fifth. A reading that is not finite or not
// above 0 forgets all before it.
class DistanceFilter {
 public:
  void OnReading(double mm);
  void Clear() { last_.clear(); }
  std::optional<double> mm() const;

 private:
  std::deque<double> last_;
};

// A switch changes with the second equal reading; before, its state is not known.
class SwitchFilter {
 public:
  void OnReading(bool on);
  void Clear() { *this = {}; }
  std::optional<bool> on() const { return on_; }

 private:
  std::optional<bool> on_;
  std::optional<bool> last_;
};

}  // namespace musher::meilin::servers
