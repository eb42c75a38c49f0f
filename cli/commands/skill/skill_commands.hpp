#pragma once
// The commands of the family `musher skill`, and the arguments that several of them have.

#include <string>

#include "musher/cli/grammar/grammar.hpp"

namespace musher::cli {

void AddSkillList(Grammar& grammar, CLI::App& family);
void AddSkillRun(Grammar& grammar, CLI::App& family);
void AddSkillPlan(Grammar& grammar, CLI::App& family);
void AddSkillCancel(Grammar& grammar, CLI::App& family);
void AddSkillPause(Grammar& grammar, CLI::App& family);
void AddSkillResume(Grammar& grammar, CLI::App& family);
void AddSkillWatch(Grammar& grammar, CLI::App& family);

// NAME of a skill.
CLI::Option& AddSkillName(Grammar& grammar, CLI::App& app, std::string& name,
                          const std::string& what);
// --actuator: the one of several that offer the skill.
void AddSkillActuator(Grammar& grammar, CLI::App& app, std::string& actuator);

}  // namespace musher::cli
