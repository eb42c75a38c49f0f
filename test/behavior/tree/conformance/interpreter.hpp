#pragma once
// An interpreter of behaviour trees for tests, written from what the documentation says of each
// node (docs/behavior-trees.md, that of BehaviorTree.CPP), and made unlike the engine: a node that
// runs has a Run, an object that is made when the node starts and is gone when it ends. It looks
// everything up in each tick, by names.
//
//   Interpreter interpreter(model);       // of the main tree
//   interpreter.Tick(at_ms);              // a Status, or the node that has failed
//   interpreter.log, interpreter.board    // what the leaves did, and the entries
//
// Leaves of the tests: Say takes several ticks, Act one, Look is a condition. A letter of their
// `does` is the result of a tick: S, F, R, - (skipped); ! and * throw, ? and I are no results; w is
// R with a wake-up. With halts="!" a Say throws when it is halted.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/behavior/tree/status.hpp"

namespace musher::tree::conformance {

// "x < 3", "s == 'n1'"
struct Comparison {
  std::string entry;
  std::string by;  // <, == or >; of a text ==
  int number = 0;
  std::optional<std::string> text{};  // instead of the number
};
// "x := 3", "x += 1", "s := 'n1'"
struct Assignment {
  std::string entry;
  std::string by;  // := or +=; of a text :=
  int number = 0;
  std::optional<std::string> text{};  // instead of the number
};
std::string TextOf(const Comparison& comparison);
std::string TextOf(const Assignment& assignment);

// A node as its document has it.
struct Model {
  std::string kind;
  std::string name{};                            // of a leaf Say, Act or Look
  std::string does{};                            // what its ticks return: "RRS"
  std::map<std::string, std::string> ports{};    // numbers, results; of a time also {z}
  std::vector<std::string> queue{};              // of LoopInt and its like, which set `value`
  std::string value{};                           // an entry; also of SetBlackboard: {y}, or a text
  std::optional<Comparison> compares{};          // ScriptCondition, Precondition
  std::optional<Assignment> assigns{};           // Script
  std::map<std::string, Comparison> before{};    // _skipIf, _failureIf, _successIf, _while
  std::map<std::string, Assignment> after{};     // _onSuccess, _onFailure, _onHalted, _post
  std::map<std::string, std::string> entries{};  // of a SubTree: those around it by its own;
                                                 // one that is missing is of the SubTree alone
  std::vector<Model> children{};                 // of a SubTree: its content

  int Number(const std::string& port) const { return std::stoi(ports.at(port)); }
};

std::string DocumentOf(const Model& main);

class Node;

// A node that has failed, by its number in the order of the document, and a part of the reason.
struct Failure {
  std::size_t node = 0;
  std::string why;
};

// Of a tick or a halt.
struct Outcome {
  Status status = Status::kIdle;
  std::optional<Failure> failure;
};

struct BoardEntry {
  std::optional<std::string> value;
  int sets = 0;
};

// The entries of a main tree, with their values before the first tick: numbers, b a truth value, s
// a text.
inline const std::map<std::string, std::string> kEntries = {{"b", "0"}, {"d", "0"}, {"s", ""},
                                                            {"x", "0"}, {"y", "0"}, {"z", "0"}};

class Interpreter {
 public:
  explicit Interpreter(const Model& main);
  ~Interpreter();
  Interpreter(const Interpreter&) = delete;
  Interpreter& operator=(const Interpreter&) = delete;

  Outcome Tick(std::int64_t at_ms);
  // As long as a node asks for another tick, 100 times at most.
  Outcome TickOnce(std::int64_t at_ms);
  Outcome Halt(std::int64_t at_ms);
  // A node asks for a tick; between two ticks the program is called: "~ " in the log.
  void WakeUp();
  // Of each node, in the order of the document.
  std::vector<bool> Running() const;

  void Set(const std::string& entry, const std::string& value);

  std::string log;
  std::map<std::string, BoardEntry> board;
  std::int64_t now_ms = 0;
  bool again = false;                    // another tick is wanted
  std::optional<Failure> failed_halt{};  // the first node that has failed in its halt
  std::size_t nodes = 0;

 private:
  void HaltAll();

  bool in_tick_ = false;
  bool called_ = false;  // since the last tick
  std::unique_ptr<Node> root_;
};

}  // namespace musher::tree::conformance
