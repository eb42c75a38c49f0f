#pragma once
// What the body can do: the motion id table, read from a TOML file (config/motion/motions.toml
// explains each column). Immutable once read, and small: read from the loop thread only.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/base/time.hpp"
#include "musher/messages/protocol/motion.hpp"

namespace musher::motion {

// The motions that the motion manager itself commands or distinguishes.
inline constexpr std::int32_t kEmergencyStop = msg::MotionId::kEmergencyStop;
inline constexpr std::int32_t kGetDown = msg::MotionId::kGetDown;
inline constexpr std::int32_t kPassiveGetDown = msg::MotionId::kPassiveGetDown;
inline constexpr std::int32_t kRecoveryStand = msg::MotionId::kRecoveryStand;
inline constexpr std::int32_t kWalkStand = msg::MotionId::kWalkStand;
inline constexpr std::int32_t kGroundStand = 118;
inline constexpr std::int32_t kForceControl = msg::MotionId::kForceControlAbsolute;
inline constexpr std::int32_t kUserTrot = msg::MotionId::kWalkUserTrot;
inline constexpr std::int32_t kFromGroundStand = 309;  // begins from kGroundStand
inline constexpr std::int32_t kUserSequence =
    msg::MotionId::kSequenceCustom;  // plays a gait of a user

inline constexpr std::int32_t kNoMotion = -1;  // of a silent or unknown board

// The highest speed in each direction, either way: x and y in m/s, yaw in rad/s.
using SpeedLimit = std::array<float, 3>;

struct Motion {
  std::int32_t id = 0;
  std::string name;
  std::int8_t mode = 0;
  std::int8_t gait = 0;
  // > 0: the time it may take, and a command gives no duration; < 0: a command must give one; 0:
  // may.
  std::int64_t min_exec_time_ms = 0;
  std::vector<std::int8_t> next;    // modes that may follow
  std::string capability;           // that a result command needs; empty: none
  std::string servo;                // that a servo command needs; empty: not a servo motion
  std::optional<SpeedLimit> limit;  // none: no speeds

  bool MayGoTo(std::int8_t mode) const;

  friend bool operator==(const Motion&, const Motion&) = default;
};

class MotionTable {
 public:
  MotionTable() = default;
  // By id; ids and pairs of mode and gait are unique.
  explicit MotionTable(std::vector<Motion> motions);

  const Motion* Find(std::int64_t id) const;
  // The motion with the board's mode and gait.
  const Motion* Find(std::int8_t mode, std::int8_t gait) const;
  const std::vector<Motion>& motions() const { return motions_; }

 private:
  std::vector<Motion> motions_;  // by id
};

struct TableReading {
  std::optional<MotionTable> table;     // present exactly when no diagnostic is an error
  std::vector<Diagnostic> diagnostics;  // by line
};

// Never throws; an unreadable file is a diagnostic.
TableReading ReadTableFile(const std::string& path);
// The same for a text; `path` is what diagnostics refer to.
TableReading ReadTableText(std::string_view text, const std::string& path);

}  // namespace musher::motion
