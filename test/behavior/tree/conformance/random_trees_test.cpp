// Random trees in the engine and in an interpreter that was written from the documentation
// (interpreter.hpp): in each tick the same result, calls of the leaves, entries and running nodes.
//
// MUSHER_SEEDS=1000000 tries more of them. Of those that differ, the smallest is shown.

#include <algorithm>
#include <cstdlib>
#include <random>
#include <set>

#include "musher/test/behavior/tree/conformance/interpreter.hpp"
#include "musher/test/behavior/tree/trees.hpp"
#include "musher/test/support/nightly.hpp"

namespace musher::tree::conformance_random_trees_test {

using conformance::Assignment;
using conformance::Comparison;
using conformance::Interpreter;
using conformance::Model;

class Generator {
 public:
  explicit Generator(std::uint32_t seed) : random_(seed) {}

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

 private:
  std::string OneOf(const std::vector<std::string>& texts) {
    return texts[static_cast<std::size_t>(Number(0, static_cast<int>(texts.size()) - 1))];
  }
  std::string Entry() { return OneOf({"x", "y", "z"}); }
  Comparison Compares() { return {Entry(), OneOf({"<", "==", ">"}), Number(0, 3)}; }
  Assignment Assigns() {
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
    const std::string kind = OneOf({"Say", "Say", "Say", "Say", "Script", "ScriptCondition",
                                    "Sleep", "AlwaysSuccess", "AlwaysFailure"});
    Model leaf{.kind = kind};
    if (kind == "Sleep") leaf.ports["msec"] = Milliseconds();
    if (kind == "Script") leaf.assigns = Assigns();
    if (kind == "ScriptCondition") leaf.compares = Compares();
    if (kind != "Say") return leaf;
    leaf.name = "n" + std::to_string(names_++);
    const int letters = Number(1, 4);
    for (int i = 0; i < letters; ++i)
      leaf.does += OneOf({"S", "S", "S", "F", "F", "R", "R", "R", "-"});
    return leaf;
  }
  Model Control(int depth) {
    const std::string kind =
        OneOf({"Sequence", "AsyncSequence", "SequenceWithMemory", "ReactiveSequence", "Fallback",
               "AsyncFallback", "ReactiveFallback", "Parallel", "ParallelAll", "IfThenElse",
               "WhileDoElse", "Switch2", "Switch3", "TryCatch", "Finally"});
    Model control{.kind = kind};
    int count = Number(1, 4);
    if (kind == "IfThenElse" || kind == "WhileDoElse") count = Number(2, 3);
    if (kind == "TryCatch") count = Number(2, 4);
    if (kind == "Finally") count = 2;
    if (kind == "Switch2") count = 3;
    if (kind == "Switch3") count = 4;
    if (kind == "Parallel") {
      control.ports["success_count"] = std::to_string(Number(-2, count));
      control.ports["failure_count"] = std::to_string(Number(1, count));
    }
    if (kind == "ParallelAll") control.ports["max_failures"] = std::to_string(Number(-1, count));
    if (kind == "TryCatch") control.ports["catch_on_halt"] = OneOf({"true", "false"});
    if (kind.starts_with("Switch")) {
      control.ports["variable"] = "{x}";
      for (int i = 1; i < count; ++i) {
        control.ports["case_" + std::to_string(i)] = std::to_string(Number(0, 3));
      }
    }
    for (int i = 0; i < count; ++i) control.children.push_back(Tree(depth));
    return control;
  }
  Model Decorator(int depth) {
    const std::string kind = OneOf({"Inverter", "ForceSuccess", "ForceFailure", "Repeat",
                                    "RetryUntilSuccessful", "KeepRunningUntilFailure", "Delay",
                                    "Timeout", "RunOnce", "Precondition", "LoopInt", "SubTree"});
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
    if (kind == "LoopInt") {
      const int values = Number(1, 3);
      for (int i = 0; i < values; ++i) decorator.queue.push_back(Number(0, 3));
      ports["if_empty"] = OneOf({"SUCCESS", "FAILURE", "SKIPPED"});
    }
    if (kind == "SubTree") {
      const bool crossed = OneIn(2);
      decorator.entries = {{"x", crossed ? "y" : "x"}, {"y", crossed ? "x" : "y"}, {"z", "z"}};
      if (!crossed && OneIn(2)) ports["_autoremap"] = "true";
    }
    decorator.children.push_back(Tree(depth));
    return decorator;
  }

  std::mt19937 random_;
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

// "S n0^ n1 | x=1 y=0 z=0 | R..R"
std::string ShownOf(Interpreter& interpreter, Status status) {
  return std::string(1, Letter(status)) + " " + std::exchange(interpreter.log, "") +
         "| x=" + std::to_string(interpreter.board.at("x")) +
         " y=" + std::to_string(interpreter.board.at("y")) +
         " z=" + std::to_string(interpreter.board.at("z")) + " | " + TextOf(interpreter.Running());
}
std::string ShownOf(Tree& tree, std::string log, const Result<Status>& status) {
  if (!status) return status.error().message;
  const auto number = [&](const char* key) {
    return std::to_string(static_cast<int>(tree.board().Get<double>(key).value()));
  };
  std::vector<bool> running;
  for (NodeId id = 0; id < tree.size(); ++id)
    running.push_back(tree.status(id) == Status::kRunning);
  return std::string(1, Letter(status)) + " " + std::move(log) + "| x=" + number("x") +
         " y=" + number("y") + " z=" + number("z") + " | " + TextOf(running);
}

// Where both differ; "" for nowhere.
std::string DifferenceOf(const Model& model, Generator& random) {
  Logged logged;
  const std::string document = DocumentOf(model);
  const auto tree = MakeTree(document, logged.factory);
  if (tree == nullptr) return "the tree is not built:\n" + document;
  for (const char* key : {"x", "y", "z"}) {
    if (const Result<> set = tree->board().Set(key, 0); !set) return set.error().message;
  }
  Interpreter interpreter(model);
  std::string before;
  std::int64_t at_ms = 0;
  for (int i = 0; i < 30; ++i) {
    if (random.OneIn(10)) {
      EXPECT_TRUE(tree->Halt(At(at_ms)));
      interpreter.Halt(at_ms);
      before += "halt\n";
    }
    const Result<Status> status = tree->TickExactlyOnce(At(at_ms));
    const std::string engine = ShownOf(*tree, logged.Take(), status);
    const std::string expected = ShownOf(interpreter, interpreter.Tick(at_ms));
    if (engine != expected) {
      return document + before + "expected at " + std::to_string(at_ms) + " ms: " + expected +
             "\nthe engine:     " + engine;
    }
    before += std::to_string(at_ms) + " ms: " + expected + "\n";
    at_ms += 10 * random.Number(0, 2);
  }
  return "";
}

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
    const std::string difference = DifferenceOf(model, random);
    if (difference.empty()) continue;
    const std::string found = "seed " + std::to_string(seed) + ":\n" + difference;
    if (smallest.empty() || found.size() < smallest.size()) smallest = found;
  }
  EXPECT_EQ(smallest, "");
  EXPECT_EQ(kinds.size(), 33U) << "each kind of node was there";
}

}  // namespace musher::tree::conformance_random_trees_test
