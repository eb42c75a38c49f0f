// Random trees of RecoveryNode, PipelineSequence and RoundRobin against an interpreter of their
// documentation. It shares no code with the nodes: it knows the calls of the leaves and keeps what
// it knows by the path of each node.

#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include "musher/test/behavior/tree/nav2/fake_robot.hpp"

namespace musher::tree::nav2::property_test {

struct Drawn {
  std::string kind;  // "Say": a leaf
  std::string does{};
  int number = 0;  // of a RecoveryNode; 1: a RoundRobin that wraps around
  std::vector<Drawn> children{};
  std::string name{};
};

// What a node remembers between two ticks of the tree.
struct Memory {
  bool runs = false;
  std::size_t step = 0;     // of a leaf, for ever
  std::size_t reached = 0;  // the farthest child of a pipeline; the next child of a RoundRobin
  int recoveries = 0;
  std::size_t failures = 0;
  bool recovers = false;
};

class Interpreter {
 public:
  std::string log;

  char Tick(const Drawn& node) {
    Memory& memory = memories_[node.name];
    const char result = node.kind == "Say"                ? Leaf(node, memory)
                        : node.kind == "PipelineSequence" ? Pipeline(node, memory)
                        : node.kind == "RecoveryNode"     ? Recovery(node, memory)
                                                          : Round(node, memory);
    memory.runs = result == 'R';
    return result;
  }
  void Stop(const Drawn& node) {
    Memory& memory = memories_[node.name];
    if (!memory.runs) return;
    memory.runs = false;
    if (node.kind == "Say") log += node.name + "! ";
    if (node.kind == "RoundRobin") memory.reached = 0;
    StopAll(node);
  }
  // A run of the tree has ended.
  void EndRun() {
    for (auto& [name, memory] : memories_) memory.reached = 0;
  }

 private:
  void StopAll(const Drawn& node) {
    for (const Drawn& child : node.children) Stop(child);
  }
  char Leaf(const Drawn& node, Memory& memory) {
    log += node.name + (memory.runs ? " " : "^ ");
    return node.does[memory.step++ % node.does.size()];
  }
  // Children up to the farthest one that has been reached are ticked; success of that one reaches
  // the next one.
  char Pipeline(const Drawn& node, Memory& memory) {
    if (!memory.runs) memory.reached = 0;
    for (std::size_t i = 0;; ++i) {
      const char result = Tick(node.children[i]);
      if (result == 'F') return StopAll(node), 'F';
      if (i < memory.reached) continue;
      if (result == 'R') return 'R';
      if (i + 1 == node.children.size()) return StopAll(node), 'S';
      memory.reached = i + 1;
    }
  }
  char Recovery(const Drawn& node, Memory& memory) {
    if (!memory.runs) memory.recoveries = 0, memory.recovers = false;
    while (true) {
      const char result = Tick(node.children[memory.recovers ? 1 : 0]);
      if (result == 'R') return 'R';
      if (memory.recovers && result == 'F') return 'F';
      if (!memory.recovers && result == 'S') return 'S';
      if (!memory.recovers && memory.recoveries == node.number) return 'F';
      if (memory.recovers) ++memory.recoveries;
      memory.recovers = !memory.recovers;
    }
  }
  char Round(const Drawn& node, Memory& memory) {
    const std::size_t count = node.children.size();
    if (!memory.runs) memory.failures = 0;
    while (memory.failures < count && (node.number == 1 || memory.reached < count)) {
      const char result = Tick(node.children[memory.reached % count]);
      if (result == 'R') return 'R';
      memory.reached = node.number == 1 ? (memory.reached + 1) % count : memory.reached + 1;
      if (result == 'S') return 'S';
      ++memory.failures;
    }
    memory.reached = 0;
    return 'F';
  }

  std::map<std::string, Memory> memories_;
};

Drawn RandomTree(int depth, int& names) {
  static const std::vector<std::string> kKinds = {"PipelineSequence", "RecoveryNode", "RoundRobin"};
  const int kind = depth == 0 ? 3 : *rc::gen::inRange(0, 5);
  Drawn node;
  node.name = "n" + std::to_string(names++);
  if (kind >= 3) {
    node.kind = "Say";
    node.does =
        *rc::gen::nonEmpty(rc::gen::container<std::string>(rc::gen::element('S', 'F', 'R')));
    return node;
  }
  node.kind = kKinds[static_cast<std::size_t>(kind)];
  node.number = node.kind == "RecoveryNode" ? *rc::gen::inRange(0, 4) : *rc::gen::inRange(0, 2);
  const int children = node.kind == "RecoveryNode" ? 2 : *rc::gen::inRange(1, 5);
  for (int i = 0; i < children; ++i) node.children.push_back(RandomTree(depth - 1, names));
  return node;
}

std::string Xml(const Drawn& node) {
  if (node.kind == "Say") return SayXml(node.name, node.does);
  std::string text = "<" + node.kind + " name=\"" + node.name + "\"";
  if (node.kind == "RecoveryNode") {
    text += " number_of_retries=\"" + std::to_string(node.number) + "\"";
  }
  if (node.kind == "RoundRobin") {
    text += std::string(" wrap_around=\"") + (node.number == 1 ? "true" : "false") + "\"";
  }
  text += ">";
  for (const Drawn& child : node.children) text += Xml(child);
  return text + "</" + node.kind + ">\n";
}

RC_GTEST_PROP(RandomNav2Trees, AreTickedAsTheirDocumentationSays, ()) {
  int names = 0;
  const Drawn drawn = RandomTree(3, names);
  Logged logged;
  FakeRobot robot;
  AddNodes(logged.factory, robot);
  const auto tree = MakeTree(Main(Xml(drawn)), logged.factory);
  RC_ASSERT(tree != nullptr);
  Interpreter interpreter;
  for (int i = 0; i < 30; ++i) {
    if (*rc::gen::weightedElement<bool>({{9, false}, {1, true}})) {
      RC_ASSERT(tree->Halt(At(10 * i)).ok());
      interpreter.Stop(drawn);
      interpreter.EndRun();
    }
    const char expected = interpreter.Tick(drawn);
    if (expected != 'R') interpreter.EndRun();
    RC_ASSERT(Letter(tree->TickExactlyOnce(At(10 * i))) == expected);
    RC_ASSERT(logged.Take() == std::exchange(interpreter.log, ""));
  }
}

}  // namespace musher::tree::nav2::property_test
