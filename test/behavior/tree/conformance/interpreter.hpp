#pragma once
// An interpreter of behaviour trees for tests, written from what the documentation says of each
// node (docs/behavior-trees.md, that of BehaviorTree.CPP), and made unlike the engine: a node that
// runs has a Run, an object that is made when the node starts and is gone when it ends. It looks
// everything up in each tick, by names.
//
//   Interpreter interpreter(model);       // of the main tree
//   interpreter.Tick(at_ms);              // Status
//   interpreter.log, interpreter.board    // what the leaves `Say` did, and the entries
//
// It knows no faults: the trees that it interprets have none.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/behavior/tree/status.hpp"

namespace musher::tree::conformance {

// "x < 3"
struct Comparison {
  std::string entry;
  std::string by;  // <, == or >
  int number = 0;
};
// "x := 3", "x += 1"
struct Assignment {
  std::string entry;
  std::string by;  // := or +=
  int number = 0;
};
std::string TextOf(const Comparison& comparison);
std::string TextOf(const Assignment& assignment);

// A node as its document has it.
struct Model {
  std::string kind;
  std::string name{};                            // of a leaf Say
  std::string does{};                            // what its ticks return: "RRS"
  std::map<std::string, std::string> ports{};    // numbers, results; of a time also {z}
  std::vector<int> queue{};                      // of LoopInt, which sets x
  std::optional<Comparison> compares{};          // ScriptCondition, Precondition
  std::optional<Assignment> assigns{};           // Script
  std::map<std::string, Comparison> before{};    // _skipIf, _failureIf, _successIf, _while
  std::map<std::string, Assignment> after{};     // _onSuccess, _onFailure, _onHalted, _post
  std::map<std::string, std::string> entries{};  // of a SubTree: those around it by its own
  std::vector<Model> children{};                 // of a SubTree: its content

  int Number(const std::string& port) const { return std::stoi(ports.at(port)); }
};

std::string DocumentOf(const Model& main);

class Node;

class Interpreter {
 public:
  explicit Interpreter(const Model& main);
  ~Interpreter();
  Interpreter(const Interpreter&) = delete;
  Interpreter& operator=(const Interpreter&) = delete;

  Status Tick(std::int64_t at_ms);
  void Halt(std::int64_t at_ms);
  // Of each node, in the order of the document.
  std::vector<bool> Running() const;

  std::string log;
  std::map<std::string, int> board{{"x", 0}, {"y", 0}, {"z", 0}};
  std::int64_t now_ms = 0;

 private:
  std::unique_ptr<Node> root_;
};

}  // namespace musher::tree::conformance
