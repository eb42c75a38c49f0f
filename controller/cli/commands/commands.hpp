#pragma once
// The commands of `musher`. Add<Command>() is in <command>.cpp, with the options of the command,
// its help and what it does; wake, keep, low-power, poweroff and reboot are in policy.cpp;
// view, record and play in external.cpp. AddCommands() calls all of them.

namespace musher::cli {

class Grammar;

void AddCheck(Grammar& grammar);
void AddDiff(Grammar& grammar);
void AddDoctor(Grammar& grammar);
void AddGraph(Grammar& grammar);
void AddNew(Grammar& grammar);
void AddSimulate(Grammar& grammar);
void AddTree(Grammar& grammar);
void AddUp(Grammar& grammar);
void AddDown(Grammar& grammar);
void AddPowerOff(Grammar& grammar);
void AddReboot(Grammar& grammar);
void AddStatus(Grammar& grammar);
void AddDescribe(Grammar& grammar);
void AddTop(Grammar& grammar);
void AddCapabilities(Grammar& grammar);
void AddSet(Grammar& grammar);
void AddRestart(Grammar& grammar);
void AddEstop(Grammar& grammar);
void AddPlan(Grammar& grammar);
void AddWake(Grammar& grammar);
void AddKeep(Grammar& grammar);
void AddLowPower(Grammar& grammar);
void AddBehavior(Grammar& grammar);
void AddSkill(Grammar& grammar);
void AddLogs(Grammar& grammar);
void AddHistory(Grammar& grammar);
void AddReplay(Grammar& grammar);
void AddExternal(Grammar& grammar);
void AddKeys(Grammar& grammar);
void AddOta(Grammar& grammar);
void AddCompletion(Grammar& grammar);

// All of them, in the order of the help.
void AddCommands(Grammar& grammar);

}  // namespace musher::cli
