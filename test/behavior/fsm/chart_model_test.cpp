// The engine against an interpreter of state charts that was written from UML's rules alone
// (OMG UML 2.5.1, 14.2.3): whatever the chart and the events, both leave and enter the same states
// in the same order.
//
// Where UML leaves a choice open, the interpreter takes that of the engine: regions react in their
// order, a region that leaves the state around it ends the reaction of the later ones, and they are
// left in the reverse order.

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <map>
#include <optional>

#include "musher/behavior/fsm/recorder.hpp"
#include "musher/behavior/fsm/replay.hpp"
#include "musher/behavior/fsm/snapshot.hpp"
#include "musher/test/behavior/fsm/hierarchy_fixture.hpp"
#include "musher/test/behavior/fsm/random_states.hpp"

namespace musher::fsm::chart_model_test {

constexpr int kEvents = 4;

struct Arrow {
  int to = 0;
  Into into = Into::kStart;
};

struct TestState {
  int region = 0;  // that it is in
  std::vector<int> regions{};
  std::map<int, Arrow> arrows{};  // by event
  std::vector<int> defers{};
};

struct TestRegion {
  int around = -1;            // the state that holds it; -1: the outermost
  std::vector<int> states{};  // the first is the start
};

struct TestChart {
  std::vector<TestState> states;
  std::vector<TestRegion> regions;
  bool inner_first = false;
  int per_tick = 1;

  // The states around `state` and itself, outermost first.
  std::vector<int> PathTo(int state) const {
    std::vector<int> path;
    for (; state >= 0; state = regions[states[state].region].around) {
      path.insert(path.begin(), state);
    }
    return path;
  }
};

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(Mix(seed + 1)) {}
  int Below(int end) {
    state_ = Mix(state_ + 0x9e3779b97f4a7c15U);
    return static_cast<int>((state_ >> 8) % static_cast<std::uint64_t>(end));
  }

 private:
  std::uint64_t state_;
};

void AddRegion(TestChart& chart, Random& random, int around, int depth) {
  const int region = static_cast<int>(chart.regions.size());
  chart.regions.push_back({around});
  if (around >= 0) chart.states[around].regions.push_back(region);
  const int count = 1 + random.Below(3);
  for (int i = 0; i < count; ++i) {
    const int state = static_cast<int>(chart.states.size());
    chart.states.push_back({region});
    chart.regions[region].states.push_back(state);
    if (depth == 0 || random.Below(2) == 0) continue;
    const int inside = 1 + random.Below(2);
    for (int j = 0; j < inside; ++j) AddRegion(chart, random, state, depth - 1);
  }
}

TestChart AnyChart(Random& random) {
  TestChart chart;
  AddRegion(chart, random, -1, 3);
  chart.inner_first = random.Below(2) == 0;
  chart.per_tick = 1 + random.Below(3);
  const int states = static_cast<int>(chart.states.size());
  for (TestState& state : chart.states) {
    state.arrows[0] = {chart.regions[0].states[0]};  // so that no state is a trap
    for (int event = 1; event < kEvents; ++event) {
      if (random.Below(2) == 0) {
        const int to = random.Below(states);
        const bool holds = !chart.states[to].regions.empty();
        state.arrows[event] = {to, holds ? static_cast<Into>(random.Below(3)) : Into::kStart};
      } else if (random.Below(4) == 0) {
        state.defers.push_back(event);
      }
    }
  }
  return chart;
}

// UML's rules, on the chart.
class Interpreter {
 public:
  explicit Interpreter(const TestChart& chart) : chart_(chart) { EnterRegion(0, {}, Into::kStart); }

  void Send(int event) { queue_.push_back(event); }
  void Tick() {
    for (int i = 0; i < chart_.per_tick; ++i) {
      const auto next = std::ranges::find_if(queue_, [&](int event) { return !Deferred(event); });
      if (next == queue_.end()) return;
      const int event = *next;
      queue_.erase(next);
      React(0, event);
    }
  }
  std::string Path() const { return PathOf(0); }
  std::size_t waiting() const { return queue_.size(); }

  Log log;

 private:
  // Of the active states, the innermost that has something to say of an event decides; a reaction
  // of one region has priority over a deferral of another.
  bool Deferred(int event) const { return WordOf(0, event) == 'd'; }
  char WordOf(int region, int event) const {
    const int state = active_.at(region);
    const TestState& here = chart_.states[state];
    char word = ' ';
    for (const int inside : here.regions) {
      const char inner = WordOf(inside, event);
      if (inner == 'h') return inner;
      if (inner == 'd') word = inner;
    }
    if (word != ' ') return word;
    if (here.arrows.contains(event)) return 'h';
    return std::ranges::find(here.defers, event) != here.defers.end() ? 'd' : ' ';
  }

  // Whether a state in `region` has reacted.
  bool React(int region, int event) {
    const int state = active_.at(region);
    const TestState& here = chart_.states[state];
    const auto arrow = here.arrows.find(event);
    if (!chart_.inner_first && arrow != here.arrows.end()) {
      Go(state, arrow->second);
      return true;
    }
    bool reacted = false;
    const std::uint64_t before = left_[state];
    for (const int inside : here.regions) {
      if (WordOf(inside, event) == 'd') continue;
      if (React(inside, event)) reacted = true;
      if (left_[state] != before) return true;
    }
    if (!chart_.inner_first || reacted || arrow == here.arrows.end()) return reacted;
    Go(state, arrow->second);
    return true;
  }

  // From the least common ancestor: leave, innermost first; enter, outermost first.
  void Go(int from, const Arrow& arrow) {
    const std::vector<int> source = chart_.PathTo(from);
    std::vector<int> target = chart_.PathTo(arrow.to);
    std::size_t common = 0;  // the last place where both are in the same region
    for (std::size_t i = 0; i < std::min(source.size(), target.size()); ++i) {
      if (chart_.states[source[i]].region == chart_.states[target[i]].region) common = i;
    }
    const int region = chart_.states[source[common]].region;
    Leave(region);
    target.erase(target.begin(), target.begin() + static_cast<std::ptrdiff_t>(common));
    EnterState(region, target, arrow.into);
  }

  void Leave(int region) {
    const int state = active_.at(region);
    const std::vector<int>& inside = chart_.states[state].regions;
    for (auto it = inside.rbegin(); it != inside.rend(); ++it) Leave(*it);
    log.push_back("S" + std::to_string(state) + " exit");
    history_[region] = state;
    active_.erase(region);
    ++left_[state];
  }

  // `path`: from the state in `region` down to the target.
  void EnterState(int region, const std::vector<int>& path, Into into) {
    const int state = path.front();
    active_[region] = state;
    log.push_back("S" + std::to_string(state) + " enter");
    const std::vector<int> rest(path.begin() + 1, path.end());
    for (const int inside : chart_.states[state].regions) {
      if (rest.empty()) {
        EnterRegion(inside, {}, into);
      } else if (chart_.states[rest.front()].region == inside) {
        EnterRegion(inside, rest, into);
      } else {
        EnterRegion(inside, {}, Into::kStart);
      }
    }
  }

  void EnterRegion(int region, std::vector<int> path, Into into) {
    if (path.empty()) {
      const bool by_history = into != Into::kStart && history_.contains(region);
      path = {by_history ? history_[region] : chart_.regions[region].states[0]};
      if (into != Into::kDeepHistory || !by_history) into = Into::kStart;
    }
    EnterState(region, path, into);
  }

  std::string PathOf(int region) const {
    const int state = active_.at(region);
    const std::vector<int>& inside = chart_.states[state].regions;
    std::string path = "S" + std::to_string(state);
    if (inside.empty()) return path;
    std::string below;
    for (const int one : inside) below += (below.empty() ? "" : "|") + PathOf(one);
    return path + "/" + (inside.size() > 1 ? "(" + below + ")" : below);
  }

  const TestChart& chart_;
  std::map<int, int> active_;   // by region
  std::map<int, int> history_;  // by region
  std::map<int, std::uint64_t> left_;
  std::deque<int> queue_;
};

// --- the same chart for the engine ---

struct Reactions {
  void Declare(Transitions& transitions, const TestChart& chart, int state) {
    for (const auto& [event, arrow] : chart.states[state].arrows) {
      std::string path;
      for (const int step : chart.PathTo(arrow.to)) path += "/S" + std::to_string(step);
      to[transitions.On("e" + std::to_string(event))] = transitions.To(path, "event", arrow.into);
    }
    for (const int event : chart.states[state].defers) {
      transitions.Defer("e" + std::to_string(event));
    }
  }
  Next Decide(const Tick& tick) const {
    const auto found = to.find(tick.command);
    return found == to.end() ? Next::Stay() : Next::To(found->second);
  }

  std::map<EventId, StateId> to;
};

std::unique_ptr<Machine> MachineOf(const TestChart& chart, int region, Log& log) {
  auto machine = std::make_unique<Machine>(
      Machine::Options{.name = "region " + std::to_string(region),
                       .commands_per_tick = static_cast<std::size_t>(chart.per_tick)});
  for (int event = 0; event < kEvents; ++event) machine->AddEvent("e" + std::to_string(event));
  for (const int state : chart.regions[region].states) {
    const std::string name = "S" + std::to_string(state);
    auto reactions = std::make_shared<Reactions>();
    const auto declare = [=, &chart](Transitions& transitions) {
      reactions->Declare(transitions, chart, state);
    };
    const auto decide = [=](const Tick& tick) { return reactions->Decide(tick); };
    if (chart.states[state].regions.empty()) {
      auto made = std::make_unique<LoggingState>(name, log);
      made->declare = declare;
      made->check = decide;
      machine->Add(name, std::move(made));
      continue;
    }
    std::vector<Nested::Region> regions;
    for (const int inside : chart.states[state].regions) {
      regions.push_back(
          {MachineOf(chart, inside, log), "S" + std::to_string(chart.regions[inside].states[0])});
    }
    auto made = std::make_unique<LoggingNested>(name, log, std::move(regions),
                                                Nested::Options{.inner_first = chart.inner_first});
    made->declare = declare;
    made->decide = decide;
    machine->Add(name, std::move(made));
  }
  return machine;
}

std::unique_ptr<Machine> Built(const TestChart& chart, Log& log) {
  auto machine = MachineOf(chart, 0, log);
  const Result<> built = machine->Build("S" + std::to_string(chart.regions[0].states[0]));
  EXPECT_TRUE(built) << (built ? "" : built.error().message);
  return machine;
}

Log WithoutRuns(const Log& log) {
  Log left;
  for (const std::string& line : log) {
    if (!line.ends_with(" run")) left.push_back(line);
  }
  return left;
}

// Both get the same events; one time in eight the engine goes on in another machine.
void Compare(std::uint64_t seed) {
  Random random(seed);
  const TestChart chart = AnyChart(random);
  Interpreter model(chart);
  Log log;
  std::string record;
  auto machine = Built(chart, log);
  auto recorder =
      std::make_unique<Recorder>(*machine, [&](std::string_view line) { record += line; });
  Time now{};
  ASSERT_TRUE(machine->Start(now));
  bool restored = false;
  for (int i = 0; i < 40; ++i) {
    for (int sent = random.Below(3); sent > 0; --sent) {
      const int event = random.Below(kEvents);
      if (model.waiting() == 30) break;
      model.Send(event);
      ASSERT_TRUE(machine->Send("e" + std::to_string(event)));
    }
    model.Tick();
    machine->RunOnce(now += kStep);
    ASSERT_EQ(WithoutRuns(log), model.log) << "tick " << i;
    ASSERT_EQ(machine->Path(), model.Path()) << "tick " << i;
    ASSERT_EQ(machine->waiting_commands(), model.waiting()) << "tick " << i;
    if (seed % 8 != 0 || random.Below(5) != 0) continue;
    const Result<Snapshot> saved = machine->Save();
    ASSERT_TRUE(saved);
    recorder.reset();
    machine = Built(chart, log);
    ASSERT_TRUE(machine->Restore(saved.value(), now).empty());
    restored = true;
  }
  if (restored) return;
  recorder.reset();
  Log again;
  const auto other = Built(chart, again);
  const auto recording = ReadRecording(record, "chart.record");
  ASSERT_TRUE(recording);
  const auto replayed = Replay(recording.value(), *other, [](auto, auto) { return Ok(); });
  ASSERT_TRUE(replayed) << replayed.error().message;
  EXPECT_EQ(replayed.value().difference, std::nullopt);
  EXPECT_EQ(again, log);
}

TEST(Hierarchy, LeavesAndEntersWhatAnInterpreterOfUmlDoes) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Compare(seed);
    if (HasFatalFailure()) return;
  }
}

}  // namespace musher::fsm::chart_model_test
