// Random trees in the engine and in an interpreter that was written from the documentation
// (interpreter.hpp): in each tick the same result, calls of the leaves, entries and running nodes;
// where a node fails, the same node with its path, and the same halts. In a third of the trees
// nodes fail: in a tick, in a halt, by a result that is none, in a script whose entry has no value.
//
// MUSHER_SEEDS=1000000 tries more of them. Of those that differ, the smallest is shown.

#include <algorithm>
#include <cstdlib>
#include <random>
#include <set>
#include <stdexcept>

#include "musher/behavior/tree/factory.hpp"
#include "musher/test/behavior/tree/conformance/interpreter.hpp"
#include "musher/test/behavior/tree/trees.hpp"
#include "musher/test/support/nightly.hpp"

namespace musher::tree::conformance_random_trees_test {

using conformance::Assignment;
using conformance::Comparison;
using conformance::Failure;
using conformance::Interpreter;
using conformance::kEntries;
using conformance::Model;
using conformance::Outcome;

// What the leaves have in common.
struct Robot {
  std::string log;
  std::vector<WakeUp> wake_ups;  // of each Say
};

// The result of a tick by its letter; see interpreter.hpp.
Status ResultOf(char letter) {
  switch (letter) {
    case '!':
      throw std::runtime_error("it broke");
    case '*':
      throw 42;  // NOLINT(misc-throw-by-value-catch-by-reference,hicpp-exception-baseclass)
    case '?':
      return static_cast<Status>(99);
    case 'I':
      return Status::kIdle;
    case 'S':
      return Status::kSuccess;
    case 'F':
      return Status::kFailure;
    case '-':
      return Status::kSkipped;
    default:
      return Status::kRunning;
  }
}

// What a leaf does in its ticks.
class Routine {
 public:
  Routine(Setup& setup, Robot& robot)
      : name_(setup.name()), does_(setup.Input<std::string>("does")), robot_(robot) {}
  // Logs the name, with `how` behind it. The letter of this tick.
  char Next(const std::string& how) {
    const std::string& does = does_.Get();
    Log(how);
    return does[ticks_++ % does.size()];
  }
  void Log(const std::string& how) { robot_.log += name_ + how; }

 private:
  const std::string name_;
  InPort<std::string> does_;
  Robot& robot_;
  std::size_t ticks_ = 0;
};

class Say : public StatefulAction {
 public:
  Say(Setup& setup, Robot& robot)
      : routine_(setup, robot),
        halts_(setup.OptionalInput<std::string>("halts")),
        wake_up_(setup.wake_up()) {
    robot.wake_ups.push_back(wake_up_);
  }

 private:
  Status OnStart(const Tick&) override { return Do("^ "); }
  Status OnRunning(const Tick&) override { return Do(" "); }
  void OnHalted(const Tick&) override {
    routine_.Log("! ");
    if (halts_.Find() != nullptr) throw std::runtime_error("its halt broke");
  }
  Status Do(const std::string& how) {
    const char letter = routine_.Next(how);
    if (letter == 'w') wake_up_.Request();
    return ResultOf(letter);
  }

  Routine routine_;
  InPort<std::string> halts_;
  WakeUp wake_up_;
};

// A leaf whose ticks end at once.
template <class Leaf>
class Short : public Leaf {
 public:
  Short(Setup& setup, Robot& robot) : routine_(setup, robot) {}

 protected:
  Status Next() { return ResultOf(routine_.Next(" ")); }

 private:
  Routine routine_;
};

class Act : public Short<Action> {
  using Short::Short;
  Status Do(const Tick&) override { return Next(); }
};

class Look : public Short<Condition> {
  using Short::Short;
  Status Evaluate(const Tick&) override { return Next(); }
};

class Generator {
 public:
  explicit Generator(std::uint32_t seed) : random_(seed), fails_(seed % 3 == 0) {}

  // A number from `from` to `to`.
  int Number(int from, int to) {
    return from + static_cast<int>(random_() % static_cast<std::uint32_t>(to - from + 1));
  }
  bool OneIn(int times) { return Number(1, times) == 1; }

  Model Tree(int depth) {
    Model model = Node(depth);
    if (OneIn(6)) {
      model.before[OneOf({"_skipIf", "_failureIf", "_successIf", "_while"})] = Compares();
    }
    if (OneIn(12)) model.before["_while"] = Compares();
    if (OneIn(6))
      model.after[OneOf({"_onSuccess", "_onFailure", "_onHalted", "_post"})] = Assigns();
    if (OneIn(12)) model.after["_onHalted"] = Assigns();
    return model;
  }
  // What a person may write into the entry of a ManualSelector.
  std::string Selection() {
    return OneIn(4) ? OneOf({"", "SUCCESS", "FAILURE", "nothing", "Sequence", "Parallel"})
                    : "n" + std::to_string(Number(0, 5));
  }

 private:
  std::string OneOf(const std::vector<std::string>& texts) {
    return texts[static_cast<std::size_t>(Number(0, static_cast<int>(texts.size()) - 1))];
  }
  std::string Entry() { return OneOf({"x", "y", "z"}); }
  Comparison Compares() {
    if (OneIn(8)) return {"s", "==", 0, Selection()};
    if (OneIn(8)) return {OneOf({"b", "d"}), OneOf({"<", "==", ">"}), Number(0, 2)};
    return {Entry(), OneOf({"<", "==", ">"}), Number(0, 3)};
  }
  Assignment Assigns() {
    if (OneIn(6)) return {"s", ":=", 0, Selection()};
    const std::string entry = Entry();
    const int unit = entry == "z" ? 10 : 1;  // ms
    return OneIn(2) ? Assignment{entry, "+=", unit} : Assignment{entry, ":=", unit * Number(0, 3)};
  }
  std::string Milliseconds() { return OneIn(3) ? "{z}" : std::to_string(10 * Number(0, 3)); }

  Model Node(int depth) {
    const int which = depth == 0 ? 0 : Number(0, 9);
    if (which < 2) return Leaf();
    return which < 7 ? Control(depth - 1) : Decorator(depth - 1);
  }
  Model Leaf() {
    const std::string kind =
        OneOf({"Say", "Say", "Say", "Say", "Say", "Say", "Say", "Act", "Look", "Script",
               "ScriptCondition", "Sleep", "AlwaysSuccess", "AlwaysFailure", "SetBlackboard",
               "UnsetBlackboard", "WasEntryUpdated", "EntryUpdated"});
    Model leaf{.kind = kind};
    if (kind == "Sleep") leaf.ports["msec"] = Milliseconds();
    if (kind == "Script") leaf.assigns = Assigns();
    if (kind == "ScriptCondition") leaf.compares = Compares();
    if (kind == "SetBlackboard") {
      const bool text = OneIn(2);
      leaf.ports["output_key"] = text ? "s" : Entry();
      leaf.value = text ? "n" + std::to_string(Number(0, 5)) : "{" + Entry() + "}";
    }
    // Where no node is to fail, an entry that no other node uses.
    if (kind == "UnsetBlackboard") {
      leaf.ports["key"] = fails_ ? OneOf({"x", "y", "z", "b", "d", "s"}) : "u";
    }
    if (kind.ends_with("EntryUpdated")) leaf.ports["entry"] = AnyEntry();
    if (kind != "Say" && kind != "Act" && kind != "Look") return leaf;
    leaf.name = "n" + std::to_string(names_++);
    leaf.does = Does(kind == "Act");
    if (kind == "Say" && fails_ && OneIn(8)) leaf.ports["halts"] = "!";
    return leaf;
  }
  std::string AnyEntry() { return "{" + OneOf({"x", "y", "z", "b", "d", "s"}) + "}"; }
  std::string Does(bool at_once) {
    std::string does;
    const int letters = Number(1, 4);
    for (int i = 0; i < letters; ++i) {
      if (fails_ && OneIn(10)) {
        does += OneOf({"!", "*", "?", "I"});
      } else {
        does += at_once && !fails_ ? OneOf({"S", "S", "F", "-"})
                                   : OneOf({"S", "S", "S", "F", "F", "R", "R", "w", "-"});
      }
    }
    return does;
  }
  Model Control(int depth) {
    const std::string kind =
        OneOf({"Sequence", "AsyncSequence", "SequenceWithMemory", "ReactiveSequence", "Fallback",
               "AsyncFallback", "ReactiveFallback", "Parallel", "ParallelAll", "IfThenElse",
               "WhileDoElse", "Switch", "Switch", "TryCatch", "Finally", "ManualSelector"});
    Model control{.kind = kind};
    int count = Number(1, 4);
    if (kind == "IfThenElse" || kind == "WhileDoElse") count = Number(2, 3);
    if (kind == "TryCatch") count = Number(2, 4);
    if (kind == "Finally") count = 2;
    if (kind == "Switch") {
      count = OneIn(2) ? Number(3, 4) : Number(5, 7);
      control.kind += std::to_string(count - 1);
    }
    if (kind == "Parallel") {
      control.ports["success_count"] = std::to_string(Number(-2, count));
      control.ports["failure_count"] = std::to_string(Number(1, count));
    }
    if (kind == "ParallelAll") control.ports["max_failures"] = std::to_string(Number(-1, count));
    if (kind == "TryCatch") control.ports["catch_on_halt"] = OneOf({"true", "false"});
    if (kind == "ManualSelector") {
      control.ports["selection"] = "{s}";
      control.ports["repeat_last_selection"] = OneOf({"true", "false"});
    }
    if (kind == "Switch") AddCases(count - 1, control);
    for (int i = 0; i < count; ++i) control.children.push_back(Tree(depth));
    return control;
  }
  void AddCases(int cases, Model& control) {
    const bool of_text = OneIn(3);
    if (!OneIn(10)) control.ports["variable"] = of_text ? "{s}" : "{x}";
    for (int i = 1; i <= cases; ++i) {
      if (OneIn(8)) continue;
      control.ports["case_" + std::to_string(i)] =
          of_text ? "n" + std::to_string(Number(0, 5)) : std::to_string(Number(0, 3));
    }
  }
  Model Decorator(int depth) {
    const std::string kind =
        OneOf({"Inverter", "ForceSuccess", "ForceFailure", "Repeat", "RetryUntilSuccessful",
               "KeepRunningUntilFailure", "Delay", "Timeout", "RunOnce", "Precondition", "Loop",
               "SkipUnlessUpdated", "WaitValueUpdate", "SubTree", "SubTree"});
    Model decorator{.kind = kind};
    auto& ports = decorator.ports;
    if (kind == "Repeat") ports["num_cycles"] = std::to_string(Number(-1, 3));
    if (kind == "RetryUntilSuccessful") ports["num_attempts"] = std::to_string(Number(-1, 3));
    if (kind == "Delay") ports["delay_msec"] = Milliseconds();
    if (kind == "Timeout") ports["msec"] = Milliseconds();
    if (kind == "RunOnce") ports["then_skip"] = OneOf({"true", "false"});
    if (kind == "Precondition") {
      decorator.compares = Compares();
      ports["else"] = OneOf({"SUCCESS", "FAILURE", "RUNNING", "SKIPPED"});
    }
    if (kind.ends_with("Update") || kind.ends_with("Updated")) ports["entry"] = AnyEntry();
    if (kind == "Loop") AddLoop(decorator);
    if (kind == "SubTree") AddEntries(decorator);
    decorator.children.push_back(Tree(depth));
    return decorator;
  }
  void AddLoop(Model& loop) {
    const std::string of = OneOf({"Int", "Bool", "Double", "String"});
    loop.kind += of;
    loop.value = of == "Int" ? "x" : of == "Bool" ? "b" : of == "Double" ? "d" : "s";
    const int values = Number(1, 3);
    for (int i = 0; i < values; ++i) {
      loop.queue.push_back(of == "Bool"     ? OneOf({"true", "false"})
                           : of == "String" ? "n" + std::to_string(Number(0, 5))
                                            : std::to_string(Number(0, 3)));
    }
    loop.ports["if_empty"] = OneOf({"SUCCESS", "FAILURE", "SKIPPED"});
  }
  // Of a SubTree.
  void AddEntries(Model& subtree) {
    for (const auto& [entry, value] : kEntries) subtree.entries[entry] = entry;
    const int how = Number(0, fails_ ? 3 : 2);
    if (how == 0) subtree.ports["_autoremap"] = "true";
    if (how == 1) std::swap(subtree.entries["x"], subtree.entries["y"]);
    if (how == 3) subtree.entries.erase("y");  // one of its own, without a value
  }

  std::mt19937 random_;
  const bool fails_;  // nodes may fail
  int names_ = 0;
};

void CollectKinds(const Model& model, std::set<std::string>& kinds) {
  kinds.insert(model.kind);
  for (const Model& child : model.children) CollectKinds(child, kinds);
}

std::string TextOf(const std::vector<bool>& running) {
  std::string text;
  for (const bool each : running) text += each ? 'R' : '.';
  return text;
}

// "S n0^ n1 | b=0 d=0 s= x=1 y=0 z=- | R..R", "! node 3: it broke n0^ n1 | ..."
std::string ShownOf(const std::string& result, const std::string& log,
                    const std::map<std::string, std::string>& entries,
                    const std::vector<bool>& running) {
  std::string text = result + " " + log + "|";
  for (const auto& [entry, value] : entries) text += " " + entry + "=" + value;
  return text + " | " + TextOf(running);
}
std::string TextOf(const Failure& failure) {
  return "! node " + std::to_string(failure.node) + ": " + failure.why;
}
std::string ShownOf(Interpreter& interpreter, const Outcome& outcome) {
  std::map<std::string, std::string> entries;
  for (const auto& [entry, value] : kEntries) {
    entries[entry] = interpreter.board.at(entry).value.value_or("-");
  }
  const std::string result =
      outcome.failure ? TextOf(*outcome.failure) : std::string(1, Letter(outcome.status));
  return ShownOf(result, std::exchange(interpreter.log, ""), entries, interpreter.Running());
}

// The message has the place and the path of the node, and why it failed.
bool Names(const Tree& tree, const Failure& failure, const std::string& message) {
  const auto node = static_cast<NodeId>(failure.node);
  return message.starts_with(tree.PlaceOf(node) + ": " + tree.Path(node) + ": ") &&
         message.find(failure.why) != std::string::npos;
}

// `expected`: how its error is shown, if it is the expected one.
std::string ShownOf(Tree& tree, const std::string& log, const Result<Status>& status,
                    const Outcome& expected) {
  std::map<std::string, std::string> entries;
  for (const auto& [entry, value] : kEntries) {
    const Entry* const found = tree.board().Find(entry);
    if (found == nullptr || found->value.empty()) {
      entries[entry] = "-";
    } else if (entry == "s") {
      entries[entry] = tree.board().Get<std::string>(entry).value();
    } else if (entry == "b") {
      entries[entry] = tree.board().Get<bool>(entry).value() ? "1" : "0";
    } else {
      entries[entry] = std::to_string(static_cast<int>(tree.board().Get<double>(entry).value()));
    }
  }
  std::vector<bool> running;
  for (NodeId id = 0; id < tree.size(); ++id)
    running.push_back(tree.status(id) == Status::kRunning);
  std::string result(1, Letter(status));
  if (!status) {
    const std::string& message = status.error().message;
    result = expected.failure && Names(tree, *expected.failure, message) ? TextOf(*expected.failure)
                                                                         : message;
  }
  return ShownOf(result, log, entries, running);
}

// A tree in the engine and in the interpreter.
class Both {
 public:
  Both(const Model& model, Generator& random)
      : document_(DocumentOf(model)), random_(random), interpreter_(model) {
    EXPECT_TRUE(factory_.Add<Say>("Say", robot_));
    EXPECT_TRUE(factory_.Add<Act>("Act", robot_));
    EXPECT_TRUE(factory_.Add<Look>("Look", robot_));
    tree_ = MakeTree(document_, factory_);
    if (tree_ == nullptr) return;
    tree_->OnWakeUp([this] { robot_.log += "~ "; });
    for (const auto& [entry, value] : kEntries) {
      EXPECT_TRUE(entry == "b"   ? tree_->board().Set(entry, value == "1")
                  : entry == "s" ? tree_->board().Set(entry, value.c_str())
                                 : tree_->board().Set(entry, std::stoi(value)));
    }
  }
  static std::vector<std::string> Kinds() {
    std::vector<std::string> kinds = Factory().Names();
    kinds.insert(kinds.end(), {"Say", "Act", "Look", "SubTree"});
    return kinds;
  }

  // Where both differ; "" for nowhere.
  std::string Difference() {
    if (tree_ == nullptr) return "the tree is not built:\n" + document_;
    for (int i = 0; i < 30 && found_.empty(); ++i) {
      BetweenTicks();
      const bool once = random_.OneIn(3);
      const auto status = once ? tree_->TickOnce(At(at_ms_)) : tree_->TickExactlyOnce(At(at_ms_));
      const Outcome outcome = once ? interpreter_.TickOnce(at_ms_) : interpreter_.Tick(at_ms_);
      Compare(once ? "once " : "", status, outcome);
      at_ms_ += 10 * random_.Number(0, 2);
    }
    return found_;
  }

 private:
  // A person, a program, the robot.
  void BetweenTicks() {
    if (random_.OneIn(10)) {
      const Result<> halted = tree_->Halt(At(at_ms_));
      const Outcome outcome = interpreter_.Halt(at_ms_);
      Compare("halt ", halted ? Result<Status>(Status::kIdle) : halted.error(), outcome);
    }
    if (random_.OneIn(8)) {
      const std::string selection = random_.Selection();
      EXPECT_TRUE(tree_->board().Set("s", selection.c_str()));
      interpreter_.Set("s", selection);
      before_ += "s := '" + selection + "'\n";
    }
    if (random_.OneIn(8) && !robot_.wake_ups.empty()) {
      robot_.wake_ups.back().Request();
      interpreter_.WakeUp();
      before_ += "a wake-up\n";
    }
  }
  void Compare(const std::string& what, const Result<Status>& status, const Outcome& outcome) {
    const std::string engine = ShownOf(*tree_, std::exchange(robot_.log, ""), status, outcome);
    const std::string expected = ShownOf(interpreter_, outcome);
    if (engine != expected && found_.empty()) {
      found_ = document_ + before_ + "expected of " + what + "at " + std::to_string(at_ms_) +
               " ms: " + expected + "\nthe engine:     " + engine;
    }
    before_ += what + std::to_string(at_ms_) + " ms: " + expected + "\n";
  }

  const std::string document_;
  Generator& random_;
  Robot robot_;
  Factory factory_;
  Interpreter interpreter_;
  std::unique_ptr<Tree> tree_;
  std::string before_;
  std::string found_;
  std::int64_t at_ms_ = 0;
};

TEST(RandomTreesAsDocumented, BehaveAsInTheInterpreter) {
  const char* const wanted = std::getenv("MUSHER_SEEDS");
  const std::uint32_t count =
      std::max(testing::Nightly() ? 100'000U : 2'000U,
               wanted == nullptr ? 0U : static_cast<std::uint32_t>(std::stoul(wanted)));
  std::set<std::string> kinds;
  std::string smallest;  // of the differences
  for (std::uint32_t seed = 0; seed < count; ++seed) {
    Generator random(seed);
    const Model model = random.Tree(1 + static_cast<int>(seed % 4));
    CollectKinds(model, kinds);
    const std::string difference = Both(model, random).Difference();
    if (difference.empty()) continue;
    const std::string found = "seed " + std::to_string(seed) + ":\n" + difference;
    if (smallest.empty() || found.size() < smallest.size()) smallest = found;
  }
  EXPECT_EQ(smallest, "");
  EXPECT_THAT(kinds, ::testing::UnorderedElementsAreArray(Both::Kinds()))
      << "each node that Musher has, and nothing else";
}

}  // namespace musher::tree::conformance_random_trees_test
