// What a tick of a behaviour tree costs for each node that it ticks, what a condition, a port and a
// script cost, and how long a tree takes to load, and its memory. The smallest of several turns, of
// some the median, too.
//
//   benchmark_tree [TURNS]    (300)

#include <malloc.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "musher/application/tree_report.hpp"
#include "musher/behavior/tree/build.hpp"
#include "musher/behavior/tree/xml/tree_xml.hpp"
#include "musher/messages/cdr.hpp"
#include "musher/test/behavior/fsm/counting_new.hpp"

namespace musher::benchmark {
namespace {

using tree::Status;

// Counts its ticks, so that what is measured is known.
std::uint64_t ticked = 0;

class Leaf : public tree::Action {
  Status Do(const tree::Tick&) override {
    ++ticked;
    return Status::kSuccess;
  }
};

class Copy : public tree::Action {
 public:
  explicit Copy(tree::Setup& setup)
      : from_(setup.Input<double>("from")), to_(setup.Output<double>("to")) {}

 private:
  Status Do(const tree::Tick&) override {
    for (int i = 0; i < 1000; ++i) to_.Set(from_.Get() + 1);
    return Status::kSuccess;
  }
  tree::InPort<double> from_;
  tree::OutPort<double> to_;
};

class Work : public tree::StatefulAction {
  Status OnStart(const tree::Tick&) override { return Status::kRunning; }
  Status OnRunning(const tree::Tick&) override { return Status::kSuccess; }
};

double SecondsOf(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return ToSeconds(std::chrono::steady_clock::now() - begin);
}

struct Seconds {
  double smallest = 0;
  double median = 0;
  std::size_t allocations = 0;  // in all turns
};

Seconds Measured(int turns, const std::function<void()>& work) {
  std::vector<double> seconds;
  seconds.reserve(static_cast<std::size_t>(turns));
  const std::size_t before = testing::AllocationsOfNew().times;
  for (int i = 0; i < turns; ++i) seconds.push_back(SecondsOf(work));
  const std::size_t allocations = testing::AllocationsOfNew().times - before;
  std::ranges::sort(seconds);
  return {seconds.front(), seconds[seconds.size() / 2], allocations};
}

double Smallest(int turns, const std::function<void()>& work) {
  return Measured(turns, work).smallest;
}

std::string Document(const std::string& content) {
  return "<root BTCPP_format=\"4\"><BehaviorTree ID=\"Main\">" + content + "</BehaviorTree></root>";
}

// Groups of ten nodes: a sequence, a fallback, decorators, an action that takes two ticks, leaves.
std::string Mix(int nodes) {
  std::string text = "<Sequence>\n";
  for (int i = 0; i < nodes / 10; ++i) {
    text +=
        "<Sequence>\n<Leaf/>\n<Fallback>\n<Inverter><Leaf/></Inverter>\n<Leaf/>\n</Fallback>\n"
        "<ForceSuccess><Work/></ForceSuccess>\n<Leaf/><Leaf/>\n</Sequence>\n";
  }
  return Document(text + "</Sequence>");
}

tree::Factory MakeFactory() {
  tree::Factory factory;
  static_cast<void>(factory.Add<Leaf>("Leaf"));
  static_cast<void>(factory.Add<Copy>("Copy"));
  static_cast<void>(factory.Add<Work>("Work"));
  return factory;
}

std::unique_ptr<tree::Tree> Load(const std::string& xml, std::size_t history = 256) {
  static const tree::Factory factory = MakeFactory();
  const tree::Reading reading = tree::ReadTree(xml, "benchmark.xml");
  tree::Built built = tree::Build(reading.document, factory, {.history = history});
  for (const Diagnostic& each : built.diagnostics) {
    std::fprintf(stderr, "%s\n", FormatDiagnostic(each).c_str());
  }
  if (built.tree == nullptr) std::exit(1);
  return std::move(built.tree);
}

// Of a whole run of the tree, per node that is ticked: the leaves twice, since they work two ticks.
void MeasureTicks(int turns, int nodes, std::size_t history) {
  const auto tree = Load(Mix(nodes), history);
  std::int64_t ticks = 0;
  const int runs_of_a_turn = std::max(1, 20'000 / nodes);
  const std::function<void()> run = [&] {
    for (int i = 0; i < runs_of_a_turn; ++i) {
      while (tree->TickExactlyOnce(Time(Duration(++ticks))).value() == Status::kRunning) {
      }
    }
  };
  run();
  const std::uint64_t ticks_before = static_cast<std::uint64_t>(ticks);
  const Seconds seconds = Measured(turns, run);
  const double rounds =
      static_cast<double>(static_cast<std::uint64_t>(ticks) - ticks_before) / turns;
  // Each group: ten nodes in its first tick of which two (the action, its decorator) and the two
  // around them come again in the next.
  const double groups = nodes / 10;
  const double runs = runs_of_a_turn;
  const double visited = runs * (groups * 10 + 1) + (rounds - runs) * 4;
  std::printf("tick of %6d nodes%s: %6.2f ns a ticked node, median %6.2f, %zu allocations\n", nodes,
              history == 0 ? " without history" : "", seconds.smallest / visited * 1e9,
              seconds.median / visited * 1e9, seconds.allocations);
}

// A leaf with a condition that does not skip it, beside one without a condition.
void MeasureCondition(int turns, const std::string& condition) {
  const auto tick_ns = [&](const std::string& attribute) {
    std::string text;
    for (int i = 0; i < 1000; ++i) text += "<Leaf" + attribute + "/>\n";
    const auto tree = Load(Document("<Sequence>" + text + "</Sequence>"));
    static_cast<void>(tree->board().Set("x", 5.0));
    static_cast<void>(tree->board().Set("y", 1.0));
    std::int64_t ticks = 0;
    const Seconds seconds =
        Measured(turns, [&] { static_cast<void>(tree->TickExactlyOnce(Time(Duration(++ticks)))); });
    return Seconds{seconds.smallest * 1e6, seconds.median * 1e6, 0};
  };
  const Seconds plain = tick_ns("");
  const Seconds conditional = tick_ns(" _skipIf=\"" + condition + "\"");
  std::printf("leaf with _skipIf %-16s %5.1f ns, median %5.1f; without %5.1f, median %5.1f\n",
              condition.c_str(), conditional.smallest, conditional.median, plain.smallest,
              plain.median);
}

// The state of a tree on the wire: nothing, as while no program is subscribed (a comparison a
// tick), and 20 a second at 100 ticks a second, encoded but not sent.
void MeasureReport(int turns, int nodes) {
  const auto tree = Load(Mix(nodes));
  TreeTime time;
  const std::string no_fault;
  msg::TreeState state;
  std::int64_t ticks = 0;
  std::uint64_t reported = 0;
  enum class Look { kNever, kAtChange, kPublished };
  const auto run = [&](Look look) {
    for (int i = 0; i < 100; ++i) {
      const Time now(Milliseconds(10) * ++ticks);
      const Status status = tree->TickExactlyOnce(now).value();
      if (look == Look::kNever || tree->changes() == reported) continue;
      reported = tree->changes();
      time.Continue(now);
      if (look == Look::kAtChange || i % 5 != 0) continue;
      ReportState({.tree = tree.get(), .result = status, .last_fault = &no_fault, .time = &time},
                  state);
      static_cast<void>(msg::Encode(state));
    }
  };
  const double none = Smallest(turns, [&] { run(Look::kNever); });
  const double unwatched = Smallest(turns, [&] { run(Look::kAtChange); });
  const double published = Smallest(turns, [&] { run(Look::kPublished); });
  std::printf("state of %5d nodes: a tick %.3f us, not subscribed %.3f us, 20 a second %.3f us\n",
              nodes, none * 1e4, unwatched * 1e4, published * 1e4);
}

// Timeouts whose children run. They have no timers: between two ticks nothing happens, and a tick
// compares each with its time.
void MeasureTimeouts(int turns, int count) {
  const std::string leaf = "<Sleep msec=\"3600000\"/>\n";
  const auto tick_ns = [&](const std::string& child) {
    std::string text;
    for (int i = 0; i < count; ++i) text += child;
    const auto tree = Load(Document("<ParallelAll>" + text + "</ParallelAll>"));
    std::int64_t ticks = 0;
    const auto tick = [&] {
      static_cast<void>(tree->TickExactlyOnce(Time(Milliseconds(10) * ++ticks)));
    };
    tick();
    return Smallest(turns, tick) * 1e9;
  };
  const double bare = tick_ns(leaf);
  const double limited = tick_ns("<Timeout msec=\"7200000\">" + leaf + "</Timeout>");
  std::printf(
      "%d running Timeouts: %.1f ns each a tick, of which the child %.1f; 0 between ticks\n", count,
      limited / count, bare / count);
}

void MeasureLoad(int turns, int nodes) {
  const std::string xml = Mix(nodes);
  const Seconds seconds = Measured(turns, [&xml] { Load(xml); });
  std::printf("load of %5d nodes: %.3f ms, median %.3f\n", nodes, seconds.smallest * 1e3,
              seconds.median * 1e3);
}

// What a loaded tree holds on the heap, with its history of 256 changes; without its document.
void MeasureMemory(int nodes) {
  const std::string xml = Mix(nodes);
  Load(xml);
  const std::size_t before = mallinfo2().uordblks;
  const auto tree = Load(xml);
  std::printf("memory of %5d nodes: %.0f kB\n", nodes,
              static_cast<double>(mallinfo2().uordblks - before) / 1e3);
}

void MeasureScript(int turns, const std::string& code) {
  tree::Board board;
  static_cast<void>(board.Set("x", 1.0));
  static_cast<void>(board.Set("y", 2.0));
  std::vector<tree::Script::Finding> findings;
  const tree::Script script = tree::Script::Parse(code, board, {}, false, findings);
  const double seconds = Smallest(turns, [&script] {
    for (int i = 0; i < 1000; ++i) script.Run();
  });
  std::printf("script %-32s %6.1f ns\n", code.c_str(), seconds / 1000 * 1e9);
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  using namespace musher::benchmark;
  const int turns = argc > 1 ? std::max(1, std::atoi(argv[1])) : 300;
  for (const int nodes : {100, 1000, 10'000}) {
    MeasureTicks(turns, nodes, 256);
    MeasureTicks(turns, nodes, 0);
  }
  const auto tree = Load(Document("<Copy from=\"{a}\" to=\"{a}\"/>"));
  static_cast<void>(tree->board().Set("a", 0.0));
  const double seconds = Smallest(turns, [&tree] {
    for (int i = 0; i < 100; ++i) static_cast<void>(tree->TickExactlyOnce(musher::Time{}));
  });
  std::printf("get and set of a port: %.2f ns\n", seconds / 100'000 * 1e9);
  MeasureCondition(turns, "3 > x");
  MeasureCondition(turns, "3 > x || y == 7");
  MeasureScript(turns, "x < 3 && y != 1");
  MeasureScript(turns, "x := x + y * 2; x -= 4");
  MeasureTimeouts(turns, 1000);
  MeasureReport(turns, 100);
  MeasureReport(turns, 1000);
  MeasureLoad(std::min(turns, 50), 100);
  MeasureLoad(std::min(turns, 50), 1000);
  MeasureMemory(1000);
  return 0;
}
