#pragma once
// The commands of `musher`, in the order of its help. A command is a file of this folder with its
// options, its help and what it does; its Add…() is named here and nowhere else. wake, keep,
// low-power, poweroff and reboot are in policy.cpp; view, record and play in external.cpp.

namespace musher::cli {

class Grammar;

// Calls `group` with each heading of the help, and `command` with each function below it.
// clang-format off
#define MUSHER_CLI_COMMANDS(group, command) \
  group("Prepare a config")                 \
  command(AddCheck)                         \
  command(AddDiff)                          \
  command(AddDoctor)                        \
  command(AddExplain)                       \
  command(AddGraph)                         \
  command(AddNew)                           \
  command(AddProve)                         \
  command(AddSimulate)                      \
  command(AddTree)                          \
  group("Start and stop")                   \
  command(AddUp)                            \
  command(AddDown)                          \
  command(AddPowerOff)                      \
  command(AddReboot)                        \
  group("Operate the machine")              \
  command(AddStatus)                        \
  command(AddDescribe)                      \
  command(AddTop)                           \
  command(AddCapabilities)                  \
  command(AddSet)                           \
  command(AddWait)                          \
  command(AddRestart)                       \
  command(AddEstop)                         \
  command(AddPermit)                        \
  command(AddPlan)                          \
  command(AddWake)                          \
  command(AddKeep)                          \
  command(AddLowPower)                      \
  command(AddBehavior)                      \
  command(AddSkill)                         \
  group("Inspect the past")                 \
  command(AddHistory)                       \
  command(AddLogs)                          \
  command(AddReplay)                        \
  command(AddTimes)                         \
  group("Look and record")                  \
  command(AddTopic)                         \
  command(AddExternal)                      \
  group("Install and upgrade")              \
  command(AddKeys)                          \
  command(AddOta)                           \
  command(AddDeploy)                        \
  command(AddCompletion)
// clang-format on

#define MUSHER_CLI_NOTHING(heading)
#define MUSHER_CLI_DECLARE(add) void add(Grammar& grammar);
MUSHER_CLI_COMMANDS(MUSHER_CLI_NOTHING, MUSHER_CLI_DECLARE)
#undef MUSHER_CLI_NOTHING
#undef MUSHER_CLI_DECLARE

// All of them.
void AddCommands(Grammar& grammar);

}  // namespace musher::cli
