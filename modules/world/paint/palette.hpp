#pragma once
// The colours of a picture.

#include <string>

#include "musher/modules/world/paint/canvas.hpp"
#include "musher/modules/world/simulation/track.hpp"

namespace musher::world {

inline constexpr Color kPaper{255, 255, 255};
inline constexpr Color kGround{247, 246, 242};
inline constexpr Color kGrid{228, 226, 219};
inline constexpr Color kInk{38, 42, 48};
inline constexpr Color kGreyInk{112, 117, 124};
inline constexpr Color kObstacle{196, 188, 174};
inline constexpr Color kBoard{60, 72, 100};
inline constexpr Color kZone{232, 238, 248};
inline constexpr Color kZoneEdge{142, 160, 196};
inline constexpr Color kZoneName{84, 104, 148};
inline constexpr Color kPad{205, 233, 212};
inline constexpr Color kPadEdge{58, 148, 92};
inline constexpr Color kBumpRed{206, 42, 42};
inline constexpr Color kMarkInk{150, 30, 110};
inline constexpr Color kScanRed{232, 96, 40};
inline constexpr Color kSight{250, 238, 196};
inline constexpr Color kBatteryLine{40, 96, 170};

// One colour for each state; grey for an unknown one.
Color ColorOfState(const std::string& state);
// From red at 0 to green at 100.
Color ColorOfBattery(double percent);
// From blue at the beginning, 0, over green to red at the end, 1.
Color ColorOfTime(double share);
Color ColorOfMotion(const std::string& motion);

// Dark letters on light colours, light ones on dark.
Color InkOn(const Color& background);

// The colour of the body's path: by the machine's state, or by the battery without a machine.
Color ColorOfWay(const Track& track, const Sample& sample);
bool HasMachineState(const Track& track);

}  // namespace musher::world
