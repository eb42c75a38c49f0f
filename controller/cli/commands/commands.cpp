#include "musher/controller/cli/commands/commands.hpp"

#include "musher/controller/cli/grammar/grammar.hpp"

namespace musher::cli {

void AddCommands(Grammar& grammar) {
  grammar.Group("Prepare a config");
  AddCheck(grammar);
  AddDiff(grammar);
  AddDoctor(grammar);
  AddGraph(grammar);
  AddNew(grammar);
  AddSimulate(grammar);
  AddTree(grammar);
  grammar.Group("Start and stop");
  AddUp(grammar);
  AddDown(grammar);
  AddPowerOff(grammar);
  AddReboot(grammar);
  grammar.Group("Operate the machine");
  AddStatus(grammar);
  AddDescribe(grammar);
  AddTop(grammar);
  AddCapabilities(grammar);
  AddSet(grammar);
  AddRestart(grammar);
  AddEstop(grammar);
  AddPlan(grammar);
  AddWake(grammar);
  AddKeep(grammar);
  AddLowPower(grammar);
  AddBehavior(grammar);
  AddSkill(grammar);
  grammar.Group("Inspect the past");
  AddHistory(grammar);
  AddLogs(grammar);
  AddReplay(grammar);
  grammar.Group("Look and record");
  AddExternal(grammar);
  grammar.Group("Install and upgrade");
  AddKeys(grammar);
  AddOta(grammar);
  AddCompletion(grammar);
}

}  // namespace musher::cli
