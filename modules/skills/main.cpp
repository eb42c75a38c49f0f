// musher-skills: the skills of a robot. See README.md in this folder.

#include "musher/actuator/program/module_main.hpp"
#include "musher/modules/skills/load_skills.hpp"
#include "musher/modules/skills/robot/ros_robot.hpp"
#include "musher/modules/skills/skills/all.hpp"
#include "musher/modules/skills/skills_actuator.hpp"

namespace {

using musher::Parsed;
using musher::skills::LoadedSkills;
using musher::skills::LoadSkills;
using musher::skills::ReadSkillsFile;
using musher::skills::RegisterSkills;
using musher::skills::RosRobot;
using musher::skills::SkillsActuator;
using musher::skills::SkillsConfig;

int Run(const musher::program::Options& options) {
  const musher::program::EndSignals signals;  // before any thread
  const Parsed<SkillsConfig> reading = ReadSkillsFile(options.file);
  musher::program::PrintErrors(reading.diagnostics);
  if (!reading.config) return musher::program::kUsageError;
  RosRobot robot(*reading.config);
  const LoadedSkills skills = LoadSkills(robot.config(), robot, RegisterSkills);
  musher::program::PrintErrors(skills.diagnostics);
  if (!skills.entries) return musher::program::kUsageError;
  SkillsActuator actuator(options.actuator, robot, *skills.entries);
  actuator.StandAt(signals);
  return musher::program::RunToEnd(actuator, options.state_config);
}

}  // namespace

int main(int argc, char** argv) {
  return musher::program::Main(
      argc, argv,
      {"musher-skills", "Runs the skills of a robot: goals of the action <robot>/skill_execution.",
       "Exit codes: 0 torn down; 1 not started (reason on stderr); 2 usage or config."},
      Run);
}
