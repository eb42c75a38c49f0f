// Random trees against a plain interpreter, which looks the rules up for every tick and keeps all
// it knows in a tree of its own; mutated XML; deep and large trees.

#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include "musher/test/behavior/tree/trees.hpp"

namespace musher::tree::property_test {

// What the interpreter knows of a node.
struct Plain {
  std::string kind;
  std::string does;  // of a leaf
  std::vector<Plain> children{};
  std::string name{};

  Status status = Status::kIdle;
  std::size_t at = 0;
  std::size_t step = 0;  // of a leaf
  std::vector<Status> ended{};
};

class Interpreter {
 public:
  std::string log;

  Status Tick(Plain& node) {
    const Status status = Evaluate(node);
    node.status = status;
    return status;
  }
  void Reset(Plain& node) {
    if (node.status == Status::kRunning) {
      if (node.kind == "Say") log += node.name + "! ";
      if (node.kind != "SequenceWithMemory") node.at = 0;
      node.ended.clear();
      for (Plain& child : node.children) Reset(child);
    }
    node.status = Status::kIdle;
  }

 private:
  void ResetAll(Plain& node) {
    for (Plain& child : node.children) Reset(child);
  }

  Status Evaluate(Plain& node) {
    if (node.kind == "Say") return Leaf(node);
    if (node.kind == "Sequence" || node.kind == "SequenceWithMemory") {
      return InOrder(node, Status::kSuccess);
    }
    if (node.kind == "Fallback") return InOrder(node, Status::kFailure);
    if (node.kind == "ReactiveSequence") return Reactive(node, Status::kSuccess);
    if (node.kind == "ReactiveFallback") return Reactive(node, Status::kFailure);
    if (node.kind == "Parallel") return Parallel(node);
    const Status status = Tick(node.children[0]);
    if (status == Status::kRunning) return status;
    Reset(node.children[0]);
    if (node.kind == "ForceSuccess") return Status::kSuccess;
    if (node.kind == "ForceFailure") return Status::kFailure;
    return status == Status::kSuccess ? Status::kFailure : Status::kSuccess;
  }
  Status Leaf(Plain& node) {
    log += node.name + (node.status == Status::kRunning ? " " : "^ ");
    const char letter = node.does[node.step++ % node.does.size()];
    return letter == 'S' ? Status::kSuccess : letter == 'F' ? Status::kFailure : Status::kRunning;
  }
  Status InOrder(Plain& node, Status goes_on) {
    for (; node.at < node.children.size(); ++node.at) {
      const bool fresh = node.children[node.at].status != Status::kRunning;
      const Status status = Tick(node.children[node.at]);
      if (status == Status::kRunning) return status;
      if (status == goes_on) {
        const bool yields = node.kind == "SequenceWithMemory" && fresh;
        if (!yields || node.at + 1 == node.children.size()) continue;
        ++node.at;
        return Status::kRunning;
      }
      if (node.kind != "SequenceWithMemory") node.at = 0;
      ResetFailed(node);
      return status;
    }
    node.at = 0;
    ResetAll(node);
    return goes_on;
  }
  // A sequence with memory keeps what has succeeded.
  void ResetFailed(Plain& node) {
    const std::size_t from = node.kind == "SequenceWithMemory" ? node.at : 0;
    for (std::size_t i = from; i < node.children.size(); ++i) Reset(node.children[i]);
  }
  Status Reactive(Plain& node, Status goes_on) {
    for (std::size_t i = 0; i < node.children.size(); ++i) {
      const Status status = Tick(node.children[i]);
      if (status == goes_on) continue;
      for (std::size_t k = 0; k < node.children.size(); ++k) {
        if (status != Status::kRunning || k != i) Reset(node.children[k]);
      }
      return status;
    }
    ResetAll(node);
    return goes_on;
  }
  // All have to succeed; the first failure ends it.
  Status Parallel(Plain& node) {
    node.ended.resize(node.children.size(), Status::kIdle);
    std::size_t successes = 0;
    for (std::size_t i = 0; i < node.children.size(); ++i) {
      if (node.ended[i] == Status::kIdle) {
        const Status status = Tick(node.children[i]);
        if (status != Status::kRunning) node.ended[i] = status;
      }
      if (node.ended[i] == Status::kSuccess) ++successes;
      if (node.ended[i] == Status::kFailure) return End(node, Status::kFailure);
    }
    return successes == node.children.size() ? End(node, Status::kSuccess) : Status::kRunning;
  }
  Status End(Plain& node, Status status) {
    node.ended.clear();
    ResetAll(node);
    return status;
  }
};

std::string Xml(const Plain& node) {
  if (node.kind == "Say") {
    return "<Say name=\"" + node.name + "\" does=\"" + node.does + "\"/>\n";
  }
  std::string text = "<" + node.kind + ">\n";
  for (const Plain& child : node.children) text += Xml(child);
  return text + "</" + node.kind + ">\n";
}

Plain RandomTree(int depth, int& names) {
  static const std::vector<std::string> kControls = {"Sequence",         "SequenceWithMemory",
                                                     "Fallback",         "ReactiveSequence",
                                                     "ReactiveFallback", "Parallel"};
  static const std::vector<std::string> kDecorators = {"Inverter", "ForceSuccess", "ForceFailure"};
  const int kind = depth == 0 ? 0 : *rc::gen::inRange(0, 8);
  if (kind < 3) {
    Plain leaf{.kind = "Say", .does = ""};
    const int letters = *rc::gen::inRange(1, 5);
    for (int i = 0; i < letters; ++i) leaf.does += *rc::gen::element('S', 'F', 'R');
    leaf.name = "n" + std::to_string(names++);
    return leaf;
  }
  if (kind == 3) {
    Plain node{.kind = *rc::gen::elementOf(kDecorators), .does = ""};
    node.children.push_back(RandomTree(depth - 1, names));
    return node;
  }
  Plain node{.kind = *rc::gen::elementOf(kControls), .does = ""};
  const int count = *rc::gen::inRange(1, 5);
  for (int i = 0; i < count; ++i) node.children.push_back(RandomTree(depth - 1, names));
  return node;
}

RC_GTEST_PROP(RandomTrees, BehaveLikeAPlainInterpreter, ()) {
  int names = 0;
  Plain plain = RandomTree(4, names);
  Logged logged;
  const auto tree = MakeTree(Main(Xml(plain)), logged.factory);
  RC_ASSERT(tree != nullptr);
  Interpreter interpreter;
  for (int i = 0; i < 40; ++i) {
    if (*rc::gen::inRange(0, 10) == 0) {
      RC_ASSERT(tree->Halt(At(i)).ok());
      interpreter.Reset(plain);
    }
    const Result<Status> status = tree->TickExactlyOnce(At(i));
    RC_ASSERT(status.ok());
    const Status expected = interpreter.Tick(plain);
    if (IsCompleted(expected)) interpreter.Reset(plain);
    RC_ASSERT(status.value() == expected);
    RC_ASSERT(logged.Take() == std::exchange(interpreter.log, ""));
  }
}

// A document with a bit of everything.
constexpr const char* kSeed = R"(<?xml version="1.0"?>
<root BTCPP_format="4" main_tree_to_execute="Main">
  <!-- a comment --> <TreeNodesModel><SubTree ID="Sub"><input_port name="n" default="3"/></SubTree>
  </TreeNodesModel>
  <BehaviorTree ID="Main"><Sequence name="all &lt;x&gt;">
    <Script code="x := 1; y := x &lt; 3 ? 'a' : 'b' + 'c'"/>
    <SubTree ID="Sub" m="{x}" n="{x}" _autoremap="true" _skipIf="x == 2"/>
    <Switch2 variable="{x}" case_1="1" case_2="2"><Sleep msec="1"/><AlwaysFailure/>
      <AlwaysSuccess/></Switch2>
    <LoopInt queue="1;2;3" value="{i}"><Repeat num_cycles="2"><AlwaysSuccess/></Repeat></LoopInt>
  </Sequence></BehaviorTree>
  <BehaviorTree ID="Sub"><Parallel success_count="-1" failure_count="1"><Delay delay_msec="5">
    <SetBlackboard value="{m}" output_key="@out"/></Delay>
    <Timeout msec="3"><Sequence><Sleep msec="1"/><Inverter>
    <ScriptCondition code="n &gt; 1 &amp;&amp; !false"/></Inverter></Sequence></Timeout>
    </Parallel></BehaviorTree>
</root>
)";

TEST(MutatedXml, IsReportedOrRuns) {
  const std::string seed = kSeed;
  ASSERT_EQ(Findings(seed), "");
  std::uint64_t state = 42;
  const auto random = [&state](std::size_t below) {
    state = state * 6364136223846793005U + 1442695040888963407U;
    return static_cast<std::size_t>(state >> 33U) % below;
  };
  const std::string_view letters = "<>\"'{}=&;:/ \n()!-+*|@_x1SR\xff";
  int ran = 0;
  for (int i = 0; i < 2000; ++i) {
    std::string text = seed;
    for (std::size_t k = random(4) + 1; k > 0; --k) {
      const std::size_t at = random(text.size());
      switch (random(4)) {
        case 0:
          text[at] = letters[random(letters.size())];
          break;
        case 1:
          text.erase(at, random(20) + 1);
          break;
        case 2:
          text.insert(at, 1, letters[random(letters.size())]);
          break;
        default:
          text.insert(at, seed.substr(random(seed.size()), random(60)));
          break;
      }
    }
    const Reading reading = ReadTree(text, "m.xml");
    if (!reading.ok()) continue;
    const Built built = Build(reading.document, Factory());
    ASSERT_EQ(built.tree == nullptr, HasError(built.diagnostics));
    if (built.tree == nullptr) continue;
    ++ran;
    for (int tick = 0; tick < 20; ++tick) static_cast<void>(built.tree->TickOnce(At(tick)));
    static_cast<void>(built.tree->Halt(At(100)));
  }
  EXPECT_GT(ran, 50);
}

TEST(LargeTrees, ADepthOf500IsTicked) {
  std::string xml = "<root BTCPP_format=\"4\" main_tree_to_execute=\"T0\">";
  for (int i = 0; i < 10; ++i) {
    xml += "<BehaviorTree ID=\"T" + std::to_string(i) + "\">";
    for (int k = 0; k < 50; ++k) xml += "<Inverter>";
    xml += i == 9 ? "<AlwaysSuccess/>" : "<SubTree ID=\"T" + std::to_string(i + 1) + "\"/>";
    for (int k = 0; k < 50; ++k) xml += "</Inverter>";
    xml += "</BehaviorTree>";
  }
  const auto tree = MakeTree(xml + "</root>");
  EXPECT_EQ(tree->size(), 510U);
  EXPECT_EQ(Ticks(*tree, 2), "SS");
}
TEST(LargeTrees, ElementsThatAreTooDeepAreReported) {
  std::string open;
  std::string close;
  for (int k = 0; k < 600; ++k) {
    open += "<Inverter>";
    close += "</Inverter>";
  }
  // 100 by tinyxml2 9, 500 by 10.
  EXPECT_THAT(Findings(Main(open + "<AlwaysSuccess/>" + close)),
              testing::ContainsRegex("elements are nested deeper than [15]00; use subtrees"));
}
TEST(LargeTrees, TenThousandNodesAreTicked) {
  std::string xml;
  for (int i = 0; i < 9999; ++i) xml += "<AlwaysSuccess/>\n";
  const auto tree = MakeTree(Main("<Sequence>" + xml + "</Sequence>"));
  EXPECT_EQ(tree->size(), 10'000U);
  EXPECT_EQ(Ticks(*tree, 2), "SS");
}

}  // namespace musher::tree::property_test
