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
// R with a wake-up. With halts="!" a Say throws when it is halted. Leaves with ports, which are
// actions: Use logs the whole number of `in` (x where it is left out), writes one that follows it
// to `out`, and their sum to `keeps` (y); Print logs the text of `what`, and writes it with a dot
// to `to`; Carry logs the place of `place`, and writes the one beside it to `to`.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/behavior/tree/status.hpp"
#include "musher/test/behavior/tree/conformance/expression.hpp"

namespace musher::tree::conformance {

// A node as its document has it. A port's value is a text, or an entry: "{x}".
struct Model {
  std::string kind;
  std::string name{};
  std::string does{};  // of Say, Act and Look, what ticks return: "RRS"
  std::map<std::string, std::string> ports{};
  std::vector<std::string> queue{};             // of LoopInt and its like, unless it is a port
  std::string value{};                          // the port of LoopInt and its like, SetBlackboard
  std::optional<Expression> code{};             // of Script, ScriptCondition, Precondition
  std::map<std::string, Expression> scripts{};  // _skipIf, _while, ..., _onSuccess, _post
  std::vector<Model> children{};                // of a SubTree: its content

  // Of a SubTree. An own key is one of the board around it, begins with a text, has a default of
  // <TreeNodesModel>, has the same name around it by _autoremap, or is of the SubTree alone.
  std::string id{};
  std::map<std::string, std::string> entries{};   // own, around
  std::map<std::string, std::string> fixed{};     // own, text
  std::map<std::string, std::string> defaults{};  // own, a text or an entry around it
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

// The type of an entry, by the ports that use it.
enum class Holds { kAnything, kText, kWhole, kFromZero, kNumber, kTruth, kPlace };

struct BoardEntry {
  std::optional<Datum> value;  // of a place its text: "1;2"
  int sets = 0;
  Holds holds = Holds::kAnything;
  bool mixed = false;     // ports of several types use it, one of them of texts
  bool declared = false;  // a port uses it
};

// The entries of a main tree, with their values before the first tick: b is a truth value, p a
// place, s and t are texts, _p is never shared with a subtree.
inline const std::map<std::string, Datum> kEntries = {
    {"_p", 0.0}, {"b", 0.0}, {"d", 0.0}, {"k", 1.0}, {"n", 0.0}, {"p", "0;0"},
    {"s", ""},   {"t", ""},  {"x", 0.0}, {"y", 0.0}, {"z", 0.0}};

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

  void Set(const std::string& entry, const Datum& value);
  // The values of all entries, as they are now, and as they were once.
  std::map<std::string, BoardEntry> Backup() const { return board; }
  void Restore(const std::map<std::string, BoardEntry>& backup);

  std::string log;
  std::map<std::string, BoardEntry> board;
  std::int64_t now_ms = 0;
  bool again = false;                                          // another tick is wanted
  std::vector<std::pair<std::string, std::string>> constants;  // entries, texts at the beginning
  std::optional<Failure> failed_halt{};  // the first node that has failed in its halt
  std::size_t nodes = 0;

 private:
  void HaltAll();

  bool in_tick_ = false;
  bool called_ = false;  // since the last tick
  std::unique_ptr<Node> root_;
};

}  // namespace musher::tree::conformance
