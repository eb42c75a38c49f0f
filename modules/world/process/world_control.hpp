#pragma once
// World control: changes a running world from the command line, with `musher-world send battery
// 18` and the like, for people and scripts without ROS.
//
// Threads: those of the caller; SendWorldCommand() blocks until the reply or the timeout.

#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/modules/world/scene/scene.hpp"

namespace musher::world {

struct Fault {
  std::string text;  // "lifted", "motor 3"
};
struct PowerKey {
  bool down = true;
};
struct Speech {  // of a person beside the robot
  std::string text;
};
struct MarkNow {  // in the picture
  std::string text;
};
struct Pause {
  bool on = true;
};
struct DrawNow {};
struct RefereeNow {
  bool json = false;  // else text
};
struct RobotsNow {
  bool json = false;  // else text
};
struct FieldNow {};  // as JSON
struct ChargeRobot {
  std::string robot;
  double percent = 0;
};
struct CarryRobot {
  std::string robot;
  Pose2 at;
};
struct OdometryNow {
  std::string robot;
  std::string text;  // "right", "freeze", "jump 30 0"
};
struct MapNow {
  bool objects = false;  // in it as well, where they stand now
};
using WorldCommand = std::variant<ChargeTo, Cable, Touch, PowerKey, Speech, Fault, Carry, Speed,
                                  Show, MarkNow, Pause, DrawNow, RefereeNow, RobotsNow, FieldNow,
                                  ChargeRobot, CarryRobot, OdometryNow, MapNow>;

// Help text: one line for each command.
extern const char* const kWorldCommands;

// Parses the words after `send`, among them `--json`; an Error lists the expected ones.
Result<WorldCommand> ParseWorldCommand(const std::vector<std::string>& words);

// Sends the command to the world of that namespace. Returns its reply: the picture's file, the
// referee's report, usually empty. Fails when there is no world within `timeout`, or when it
// refuses.
Result<std::string> SendWorldCommand(const WorldCommand& command, const std::string& name_space,
                                     Duration timeout);

}  // namespace musher::world
