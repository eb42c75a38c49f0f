// The policy alone: every order of samples of a battery and its charger, motions, requests and
// time, up to a number of events, on the real decision code. Each switch succeeds before the next
// event. The battery has six values, one of each class that LevelAt() distinguishes. By hand:
//
//   MUSHER_POLICY_EVENTS=5   orders of so many events

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <optional>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

#include "musher/base/check.hpp"
#include "musher/lifecycle/machine/machine_invariants.hpp"
#include "musher/search/harness.hpp"
#include "musher/test/lifecycle/coordination/policy.hpp"
#include "musher/test/support/nightly.hpp"

namespace musher::search::policy_search_test {

using ::testing::HasSubstr;

constexpr Duration kSecond = std::chrono::seconds(1);
constexpr std::int64_t kKeptS = 2;
constexpr Duration kForceAfter = std::chrono::seconds(3);
constexpr int kMostSteps = 10'000;
constexpr std::int32_t kLying = 101;  // ids of motions
constexpr std::int32_t kWalking = 5;

// Levels at 20, 5 and 0 %, left at 22 and 7 %; each of the policy's times is a second.
MachineConfig ConfigWithPolicy() {
  MachineConfig config = testing::WithPolicy(1);
  PolicyConfig& policy = *config.policy;
  policy.low_power->lying_still = kSecond;
  policy.low_power->enabled = true;
  policy.power.delay = kSecond;
  policy.power.force_after = kForceAfter;
  return config;
}

// One event of the environment, or (none) a second that passes.
using InputStep = std::optional<Event>;

// What the search chooses from: steps that follow each other.
struct Input {
  std::string name;
  std::vector<InputStep> steps;
};

std::vector<Input> Inputs() {
  std::vector<Input> inputs = {{"1 s passes", {std::nullopt}},
                               {"the battery is silent", {event::InputSilent{}}},
                               {"lies still", {event::MotionSeen{kLying}}},
                               {"walks", {event::MotionSeen{kWalking}}}};
  for (const int percent : {100, 21, 15, 6, 3, 0}) {
    for (const bool charging : {false, true}) {
      const std::string name = std::to_string(percent) + (charging ? " %, being charged" : " %");
      const Event sample = event::BatterySeen{percent, charging, 0};
      inputs.push_back({name, {sample}});
      inputs.push_back({name + ", 3 samples in 1 s", {sample, sample, sample, std::nullopt}});
    }
  }
  const auto request = [&](const std::string& name, PolicyRequest what, const State& state,
                           std::int64_t ticks, bool enable) {
    const event::PolicyRequested requested{RequestId(1), what, state, ticks, enable, "a person"};
    inputs.push_back({"a person requests " + name, {requested}});
  };
  for (const BuiltInState state : {kActive, kProtected, kLowPower}) {
    request(State(state).name(), PolicyRequest::kSwitch, state, 0, false);
  }
  request("a keep in Active", PolicyRequest::kKeep, kActive, kKeptS, false);
  request("a keep in LowPower", PolicyRequest::kKeep, kLowPower, kKeptS, false);
  request("the end of the keep", PolicyRequest::kKeep, State(), 0, false);
  request("OTA", PolicyRequest::kOta, State(), 0, true);
  request("the end of OTA", PolicyRequest::kOta, State(), 0, false);
  request("to wake up", PolicyRequest::kWakeUp, State(), 0, false);
  request("LowPower when lying still", PolicyRequest::kLowPowerSwitch, State(), 0, true);
  request("no LowPower when lying still", PolicyRequest::kLowPowerSwitch, State(), 0, false);
  request("power-off", PolicyRequest::kPowerOff, State(), 0, false);
  return inputs;
}

const event::PolicyRequested* RequestIn(const InputStep& step) {
  return step ? std::get_if<event::PolicyRequested>(&*step) : nullptr;
}

// Samples in a row with something in common.
struct SampleRun {
  int samples = 0;
  Time since{};

  // `stays`: what is confirmed is not ended by this sample (hysteresis).
  void Count(bool belongs, bool stays, Time now) {
    if (!belongs && !(stays && IsConfirmed(now))) {
      samples = 0;
    } else if (samples++ == 0) {
      since = now;
    }
  }
  // What one sample may not decide.
  bool IsConfirmed(Time now) const { return samples >= 3 && now >= since + kSecond; }
};

// What has happened, by the inputs, and by which requests were accepted.
struct Seen {
  State wanted = State(kActive);  // the most that a person has requested, and not since ended
  std::optional<event::BatterySeen> battery;
  SampleRun empty;        // at most 0 %, not being charged
  SampleRun leaves_low;   // 7 % or more, and above 5 % since
  SampleRun leaves_half;  // 22 % or more, and above 20 % since
  std::optional<Time> still_since;
  bool low_power = true;  // the switch
  std::optional<Time> kept_until;

  bool IsAtMost(int percent) const {
    return battery && battery->percent <= percent && !battery->charging;
  }
  bool IsKept(Time now) const { return kept_until && now < *kept_until; }
};

struct Situation {
  World world;
  Seen seen;
};

struct Before {
  State state;
  bool power = false;
  bool keep = false;
};

bool IsEnding(const Machine& machine) {
  return machine.phase == Phase::kStopping || machine.phase == Phase::kStopped;
}

class PolicySearch {
 public:
  explicit PolicySearch(Rules rules = {})
      : model_(ConfigWithPolicy(), State(), std::move(rules)), inputs_(Inputs()) {}

  // Every order of so many inputs, from Active and from LowPower, up to the first violation.
  void Run(int events) {
    for (const State& from : {State(kActive), State(kLowPower)}) {
      std::vector<Node> layer;
      layer.push_back({Root(from), "from " + from});
      for (int made = 0; made < events && !layer.empty() && violation_.empty(); ++made) {
        std::vector<Node> next;
        for (const Node& node : layer) Expand(node, made + 1 < events ? &next : nullptr);
        layer = std::move(next);
      }
      states_ += known_.size();
      known_.clear();  // the other root may reach the last of them sooner
    }
    std::cout << events << " events: " << states_ << " states, " << transitions_
              << " transitions\n";
  }

  // The first one, with what leads to it; empty: none.
  const std::string& violation() const { return violation_; }
  std::size_t transitions() const { return transitions_; }
  // At most, of a search with so many events from both roots.
  std::size_t MostTransitions(int events) const {
    std::size_t most = 0;
    for (int made = 0; made < events; ++made) most = inputs_.size() * (1 + most);
    return 2 * most;
  }
  // Whether the policy has been seen to do it.
  bool has_powered_off() const { return has_powered_off_; }
  bool has_raised() const { return has_raised_; }
  bool has_lowered() const { return has_lowered_; }

 private:
  struct Node {
    Situation situation;
    std::string path;
  };

  // A person has requested the state.
  Situation Root(const State& state) const {
    const Model correct(model_.config);
    Situation root;
    root.world = NewWorld(correct);
    Notes notes;
    Begin(correct, root.world, false, notes);
    RunUntilStable(correct, root.world, notes);
    if (state != root.world.machine.state) {
      search::RequestSwitch(correct, root.world, state, notes);
      RunUntilStable(correct, root.world, notes);
    }
    MUSHER_CHECK(root.world.machine.state == state, "the machine is in ",
                 root.world.machine.state.name());
    root.world.requests.clear();
    root.world.requests.push_back({State(), 0, false});  // 1, the id of all requests
    root.seen.wanted = state;
    return root;
  }

  // `next`: where the situations after this one are kept; null: they are the last ones.
  void Expand(const Node& node, std::vector<Node>* next) {
    for (const Input& input : inputs_) {
      if (!violation_.empty()) return;
      Node after{node.situation, node.path + "\n" + input.name};
      ++transitions_;
      for (const InputStep& step : input.steps) {
        const std::string violation = Make(after.situation, step);
        if (!violation.empty()) {
          violation_ = after.path + "\nVIOLATION: " + violation;
          return;
        }
        if (IsEnding(after.situation.world.machine)) break;
      }
      if (!known_.insert(KeyOf(after.situation)).second || next == nullptr) continue;
      if (!IsEnding(after.situation.world.machine)) next->push_back(std::move(after));
    }
  }

  // Returns what it violates.
  std::string Make(Situation& situation, const InputStep& step) {
    World& world = situation.world;
    const PolicyState& policy = world.machine.policy;
    const Before before{world.machine.state, policy.power.has_value(), policy.keep.has_value()};
    if (step) {
      Feed(world, *step);
    } else {
      Pass(world, kSecond);
    }
    NoteInput(situation.seen, step, world.now);
    NoteKeep(situation, before, RequestIn(step));
    std::string violation = Violation(situation, before, RequestIn(step));
    NoteOutcome(situation, before, RequestIn(step));
    return violation;
  }

  // --- the machine ---

  void Feed(World& world, const Event& event) const {
    Notes notes;  // the rules of the search know no policy
    Harness(model_, world, notes).Feed(event);
    WaitUntilStable(world);
  }

  // Callbacks end, and messages arrive, before time passes.
  void WaitUntilStable(World& world) const {
    for (int made = 0; made < kMostSteps; ++made) {
      const std::vector<Choice> choices = Choices(model_, world);
      const auto next = std::ranges::find_if(
          choices, [](const Choice& choice) { return choice.kind != ChoiceKind::kTime; });
      if (next == choices.end()) return;
      Notes notes;
      search::Make(model_, world, *next, notes);
    }
    MUSHER_CHECK(false, "the machine never comes to rest");
  }

  void Pass(World& world, Duration duration) const {
    const Time until = world.now + duration;
    for (int made = 0; made < kMostSteps; ++made) {
      const auto next = NextDeadline(model_.config, world.machine);
      if (!next || *next > until) break;
      world.now = std::max(world.now, *next);
      Feed(world, event::TimePassed{});
    }
    world.now = until;
  }

  // --- the invariants, computed from the inputs ---

  static void NoteInput(Seen& seen, const InputStep& step, Time now) {
    if (!step) return;
    if (const auto* sample = std::get_if<event::BatterySeen>(&*step)) {
      seen.battery = *sample;
      seen.empty.Count(seen.IsAtMost(0), false, now);
      seen.leaves_low.Count(sample->percent >= 7, sample->percent > 5, now);
      seen.leaves_half.Count(sample->percent >= 22, sample->percent > 20, now);
    } else if (const auto* motion = std::get_if<event::MotionSeen>(&*step)) {
      if (motion->motion != kLying) {
        seen.still_since.reset();
      } else if (!seen.still_since) {
        seen.still_since = now;
      }
    } else if (const auto* request = RequestIn(step)) {
      if (request->what == PolicyRequest::kLowPowerSwitch) seen.low_power = request->enable;
    }
  }

  // `request`: the step; null: another one.
  std::string Violation(const Situation& situation, const Before& before,
                        const event::PolicyRequested* request) {
    const Machine& machine = situation.world.machine;
    const std::string broken = BrokenInvariant(model_.config, machine);
    if (!broken.empty()) return broken;
    const bool begins_to_end = machine.policy.power && !before.power;
    if (begins_to_end || IsEnding(machine)) {
      const std::string of_the_end = ViolationOfTheEnd(situation, before, request);
      if (!of_the_end.empty() || IsEnding(machine)) return of_the_end;
    }
    const std::string violation = ViolationOfTheCeiling(situation);
    if (!violation.empty() || machine.state == before.state) return violation;
    return ViolationOfTheSwitch(situation, before, request);
  }

  // Nothing undoes a TearDown and a power-off: one sample decides neither, and once it has begun,
  // the command comes in time, also where the TearDown is delayed.
  std::string ViolationOfTheEnd(const Situation& situation, const Before& before,
                                const event::PolicyRequested* request) {
    const bool requested = request != nullptr && request->what == PolicyRequest::kPowerOff;
    const bool confirmed = situation.seen.empty.IsConfirmed(situation.world.now);
    if (!before.power && !requested && !confirmed) {
      return "a TearDown or a power-off after too few samples";
    }
    World after = situation.world;
    Pass(after, kForceAfter);
    const auto& power = after.machine.policy.power;
    if (!power || !power->commanded) return "no power command in time";
    has_powered_off_ = true;
    return "";
  }

  std::string ViolationOfTheSwitch(const Situation& situation, const Before& before,
                                   const event::PolicyRequested* request) {
    const State& state = situation.world.machine.state;
    const bool rises = RankOf(state) > RankOf(before.state);
    const std::string to = " to " + state + " from " + before.state;
    if (request == nullptr) {
      if (situation.seen.IsKept(situation.world.now)) return "a switch within a keep," + to;
      (rises ? has_raised_ : has_lowered_) = true;
    } else if (IsRequested(*request, state, rises)) {
      return "";
    }
    // The end of a keep permits what the policy may do by itself.
    if (rises ? MayRise(situation) : MayFall(situation)) return "";
    if (request != nullptr) return "a request leads" + to;
    return (rises ? "the policy raises" : "the policy lowers") + to;
  }

  // Whether the request may lead to this state.
  bool IsRequested(const event::PolicyRequested& request, const State& state, bool rises) const {
    const bool up = rises && RankOf(state) <= RankOf(kActive);
    switch (request.what) {
      case PolicyRequest::kSwitch:
      case PolicyRequest::kKeep:
        return state == request.state;
      case PolicyRequest::kOta:
        return request.enable ? state == kOta : up;
      case PolicyRequest::kWakeUp:
        return up;
      case PolicyRequest::kLowPowerSwitch:
        return up && !request.enable;  // off also wakes up
      default:
        return false;
    }
  }

  // No rise without charge or a person: to what a person has requested, and as far as samples in a
  // row permit.
  bool MayRise(const Situation& situation) const {
    const State& state = situation.world.machine.state;
    const Seen& seen = situation.seen;
    const SampleRun& run = RankOf(state) > RankOf(kProtected) ? seen.leaves_half : seen.leaves_low;
    return RankOf(state) <= RankOf(seen.wanted) && run.IsConfirmed(situation.world.now);
  }

  // By the battery, or because the robot lies still.
  bool MayFall(const Situation& situation) const {
    const State& state = situation.world.machine.state;
    const Seen& seen = situation.seen;
    if (state == kProtected) return seen.battery && seen.battery->percent < 22;
    const bool still =
        seen.low_power && seen.still_since && situation.world.now >= *seen.still_since + kSecond;
    return state == kLowPower && (still || seen.IsAtMost(6));
  }

  // No actuator is above it, unless a person keeps the machine there, or the robot is about to be
  // powered off.
  std::string ViolationOfTheCeiling(const Situation& situation) const {
    const World& world = situation.world;
    const Seen& seen = situation.seen;
    if (!seen.battery || seen.IsKept(world.now) || world.machine.policy.power) return "";
    const bool halved = seen.battery->percent <= 20;
    const Rank most = seen.IsAtMost(5) ? RankOf(kLowPower) : RankOf(halved ? kProtected : kActive);
    for (const SimActuator& actuator : world.actuators) {
      const State& state = actuator.core.report.state;
      if (RankOf(state) > most) {
        return "an actuator is in " + state + " at " + std::to_string(seen.battery->percent) + " %";
      }
    }
    return "";
  }

  void NoteKeep(Situation& situation, const Before& before,
                const event::PolicyRequested* request) const {
    const bool keeps = situation.world.machine.policy.keep.has_value();
    if (request == nullptr) return;
    if (!keeps) {
      situation.seen.kept_until.reset();
    } else if (!before.keep) {
      situation.seen.kept_until = situation.world.now + std::chrono::seconds(kKeptS);
    }
  }

  void NoteOutcome(Situation& situation, const Before& before,
                   const event::PolicyRequested* request) const {
    const Machine& machine = situation.world.machine;
    Seen& seen = situation.seen;
    if (request == nullptr) {
      const bool by_battery = seen.IsAtMost(6);
      if (machine.state != before.state && machine.state == kLowPower && !by_battery) {
        seen.wanted = State(kLowPower);  // it lies still: the battery does not raise it
      }
      return;
    }
    if (machine.state == before.state) return;
    const bool names =
        request->what == PolicyRequest::kSwitch || request->what == PolicyRequest::kKeep;
    if (names && machine.state == request->state) {
      seen.wanted = machine.state;
    } else if (machine.state == kOta) {
      seen.wanted = State(kOta);
    } else if (RankOf(machine.state) > RankOf(before.state)) {
      seen.wanted = State(kActive);  // as far as the battery permits
    }
  }

  Rank RankOf(const State& state) const { return model_.config.RankOf(state).value_or(-1); }

  // --- which situations are the same ---

  // Times count from now, at most two seconds back: each of the policy's times is one second. More
  // than three samples are three.
  static std::string KeyOf(const Situation& situation) {
    const World& world = situation.world;
    const Time now = world.now;
    const PolicyState& policy = world.machine.policy;
    std::string key = world.machine.state.name();
    const auto add = [&key](auto... values) {
      ((key += " " + std::to_string(static_cast<std::int64_t>(values))), ...);
    };
    const auto add_time = [&](const std::optional<Time>& time) {
      constexpr std::int64_t kNone = 1'000'000;
      add(time ? std::max<std::int64_t>(ToMilliseconds(*time - now), -2000) : kNone);
    };
    const auto add_level = [&](const std::optional<LevelRun>& run) {
      add_time(run ? std::optional(run->since) : std::nullopt);
      if (run) add(run->level, std::min(run->samples, 3), std::min(run->higher, 3));
    };
    const auto add_fallback = [&key](const std::optional<BatteryFallback>& fallback) {
      key += fallback ? " " + fallback->from + ">" + fallback->to.name() : " -";
    };
    const auto add_run = [&](const SampleRun& run) {
      add(std::min(run.samples, 3));
      add_time(run.samples == 0 ? std::nullopt : std::optional(run.since));
    };
    for (const SimActuator& actuator : world.actuators) key += " " + actuator.core.report.state;
    add(world.machine.phase, policy.loaded, policy.battery.value_or(-1), policy.charging,
        policy.battery_silent, policy.batteries.size(), policy.level, policy.empty,
        policy.stored.level, policy.low_power, policy.still, policy.failures);
    add_level(policy.lifting);
    add_level(policy.emptying);
    add_fallback(policy.stored.lowering);
    add_fallback(policy.withheld);
    add_time(policy.still_since);
    add_time(policy.retry_at);
    key += policy.keep ? " " + policy.keep->state : " -";
    add_time(policy.keep ? std::optional(policy.keep->until) : std::nullopt);
    add_time(policy.power ? std::optional(policy.power->tear_down_at) : std::nullopt);
    add_time(policy.power ? std::optional(policy.power->force_at) : std::nullopt);
    const Seen& seen = situation.seen;
    key += " " + seen.wanted;
    add(seen.battery ? seen.battery->percent : -1, seen.battery && seen.battery->charging,
        seen.low_power);
    add_run(seen.empty);
    add_run(seen.leaves_low);
    add_run(seen.leaves_half);
    add_time(seen.still_since);
    add_time(seen.kept_until);
    return key;
  }

  const Model model_;
  const std::vector<Input> inputs_;
  std::unordered_set<std::string> known_;  // reached from this root
  std::size_t states_ = 0;
  std::string violation_;
  std::size_t transitions_ = 0;
  bool has_powered_off_ = false;
  bool has_raised_ = false;
  bool has_lowered_ = false;
};

// With a sanitizer the search is ten times slower, and finds other errors anyway.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr int kEventsInTheGate = 2;
#else
constexpr int kEventsInTheGate = 3;
#endif

int MostEvents() {
  const char* wanted = std::getenv("MUSHER_POLICY_EVENTS");
  if (wanted != nullptr) return std::atoi(wanted);
  return kEventsInTheGate + (musher::testing::Nightly() ? 1 : 0);
}

TEST(PolicyAlone, HoldsItsInvariantsInEveryOrderOfEvents) {
  PolicySearch search;
  const int events = MostEvents();
  search.Run(events);
  EXPECT_EQ(search.violation(), "");
  // It has not ended an event earlier.
  EXPECT_GT(search.transitions(), search.MostTransitions(std::min(events, kEventsInTheGate) - 1));
  EXPECT_TRUE(search.has_powered_off());
  EXPECT_TRUE(search.has_raised());
  EXPECT_TRUE(search.has_lowered());
}

// --- planted faults ---

// Instead of the decision code.
template <typename Controller>
std::string ViolationOf(Controller controller) {
  Rules rules;
  rules.controller = controller;
  PolicySearch search(std::move(rules));
  search.Run(2);
  return search.violation();
}

// Changes the machine before it gets a sample of the battery.
template <typename Change>
std::string Planted(Change change) {
  return ViolationOf([change](const auto& config, auto& machine, const Event& event, Time now) {
    if (const auto* sample = std::get_if<event::BatterySeen>(&event)) change(machine, *sample);
    return musher::Step(config, machine, event, now);
  });
}

TEST(PolicyAlone, FindsAPowerOffByOneSample) {
  const std::string violation = Planted([](Machine& machine, const event::BatterySeen& sample) {
    machine.policy.empty |= sample.percent == 0 && !sample.charging;
  });
  EXPECT_THAT(violation,
              HasSubstr("from Active\n0 %\nVIOLATION: a TearDown or a power-off after too few "
                        "samples"));
}

TEST(PolicyAlone, FindsAPowerOffThatOneSampleBeginsAndATimeEnds) {
  const std::string violation = Planted([](Machine& machine, const event::BatterySeen& sample) {
    if (sample.percent != 0 || machine.policy.power) return;
    PowerDown power;
    power.tear_down_at = power.force_at = Time::max();
    machine.policy.power = power;
  });
  EXPECT_THAT(violation,
              HasSubstr("from Active\n0 %\nVIOLATION: a TearDown or a power-off after too few "
                        "samples"));
}

TEST(PolicyAlone, FindsAPowerCommandThatNeverComes) {
  const std::string violation =
      ViolationOf([](const auto& config, auto& machine, const Event& event, Time now) {
        auto actions = musher::Step(config, machine, event, now);
        auto& power = machine.policy.power;
        if (power) power->tear_down_at = power->force_at = Time::max();
        return actions;
      });
  EXPECT_THAT(violation, HasSubstr("VIOLATION: no power command in time"));
}

TEST(PolicyAlone, FindsALowPowerOfARobotThatDoesNotLieStill) {
  const std::string violation = Planted([](Machine& machine, const event::BatterySeen&) {
    machine.policy.still = true;
    machine.policy.still_since = Time::min();
  });
  EXPECT_THAT(violation, HasSubstr("from Active\n100 %\nVIOLATION: the policy lowers to LowPower "
                                   "from Active"));
}

TEST(PolicyAlone, FindsARequestThatLeadsToAnotherState) {
  const std::string violation =
      ViolationOf([](const auto& config, auto& machine, const Event& event, Time now) {
        Event changed = event;
        auto* request = std::get_if<event::PolicyRequested>(&changed);
        const bool is_switch = request != nullptr && request->what == PolicyRequest::kSwitch;
        if (is_switch && request->state == kLowPower) request->state = State(kActive);
        return musher::Step(config, machine, changed, now);
      });
  EXPECT_THAT(violation, HasSubstr("a person requests LowPower\nVIOLATION: a request leads to "
                                   "Active from "));
}

TEST(PolicyAlone, FindsACeilingThatOneSampleLifts) {
  const std::string violation = Planted([](Machine& machine, const event::BatterySeen& sample) {
    if (sample.percent == 100) machine.policy.level = BatteryLevel::kFree;
  });
  EXPECT_THAT(violation, HasSubstr("VIOLATION: the policy raises to Active from "));
}

TEST(PolicyAlone, FindsARaiseOfWhatAPersonHasLowered) {
  const std::string violation = Planted([](Machine& machine, const event::BatterySeen&) {
    if (machine.state != kLowPower) return;
    machine.policy.stored.lowering =
        BatteryFallback{State(kActive), State(kLowPower), machine.epoch};
  });
  EXPECT_THAT(violation, HasSubstr("VIOLATION: the policy raises to Active from LowPower"));
}

TEST(PolicyAlone, FindsABatteryThatEndsAKeep) {
  const std::string violation =
      Planted([](Machine& machine, const event::BatterySeen&) { machine.policy.keep.reset(); });
  EXPECT_THAT(violation, HasSubstr("a person requests a keep in Active\n"));
  EXPECT_THAT(violation, HasSubstr("VIOLATION: a switch within a keep, to "));
}

TEST(PolicyAlone, FindsACeilingThatDoesNotLower) {
  const std::string violation = Planted([](Machine& machine, const event::BatterySeen&) {
    machine.policy.keep = musher::Keep{machine.state, 1, Time::max(), 0};
  });
  EXPECT_THAT(violation, HasSubstr("VIOLATION: an actuator is in Active at 15 %"));
}

}  // namespace musher::search::policy_search_test
