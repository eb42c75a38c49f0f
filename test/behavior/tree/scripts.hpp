#pragma once
// Scripts for tests: with a blackboard and the enums RED and BLUE.

#include <string>
#include <vector>

#include "musher/behavior/tree/script.hpp"

namespace musher::tree {

struct ScriptRunner {
  Board board;
  Enums enums{{"RED", 1}, {"BLUE", 2}};
  std::vector<Script::Finding> findings;

  // The value as a text, or the error; one that was found when loading begins with its place.
  std::string Run(const std::string& text) {
    findings.clear();
    const Script script = Script::Parse(text, board, enums, false, findings);
    for (const auto& finding : findings) {
      if (finding.error) return std::to_string(finding.at) + ": " + finding.what;
    }
    try {
      const Operand value = script.Evaluate();
      return value.is_number() ? NumberText(value.number()) : "'" + std::string(value.text()) + "'";
    } catch (const ScriptError& error) {
      return error.what();
    }
  }
};

}  // namespace musher::tree
