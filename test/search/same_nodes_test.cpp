// What counts as the same node of a search: whatever follows from the one follows from the other.

#include <gmock/gmock.h>

#include <deque>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "musher/search/explorer.hpp"
#include "musher/search/fingerprint.hpp"
#include "musher/search/reduction.hpp"
#include "musher/search/rules.hpp"
#include "musher/test/lifecycle/coordination/switching.hpp"
#include "musher/test/search/scenarios.hpp"

namespace musher::search::same_nodes_test {

// Two actuators that are restarted, the second one after the first.
MachineConfig Pair() {
  MachineConfig config = testing::Ours(2);
  for (ActuatorConfig& actuator : config.actuators) actuator.on_lost = "Active";
  testing::ActuatorNamed(config, "b").after = {"a"};
  return config;
}

// What a choice leads to.
struct Successor {
  ChoiceKind kind = ChoiceKind::kRequest;
  std::uint8_t actuator = 0;
  Fingerprint node;
  std::size_t violations = 0;

  friend bool operator==(const Successor&, const Successor&) = default;
};

struct Expanded {
  std::vector<Successor> successors;
  std::vector<World> worlds;
  std::vector<std::string> at_rest;  // violations where nothing is left to happen
};

Expanded Expand(const Model& model, const World& world) {
  Expanded expanded;
  const std::vector<Choice> choices = Choices(model, world);
  for (const Choice& choice : choices) {
    World& next = expanded.worlds.emplace_back(world);
    Notes notes;
    Make(model, next, choice, notes);
    expanded.successors.push_back({choice.kind, choice.actuator,
                                   IdentityOf(model, next).fingerprint, notes.violations.size()});
  }
  Notes notes;
  if (IsQuiet(world, choices)) CheckRest(model, world, notes);
  expanded.at_rest = std::move(notes.violations);
  return expanded;
}

// Calls `visit` with each world that a choice leads to; the first one of a node goes on.
template <typename Visit>
void ForEachWorld(const Model& model, const World& root, const Visit& visit) {
  std::map<Fingerprint, Expanded> known;
  std::deque<World> left = {root};
  for (; !left.empty(); left.pop_front()) {
    const World& world = left.front();
    const Fingerprint fingerprint = IdentityOf(model, world).fingerprint;
    const auto found = known.find(fingerprint);
    Expanded expanded = Expand(model, world);
    visit(world, expanded, found == known.end() ? nullptr : &found->second);
    if (found != known.end()) continue;
    for (World& next : expanded.worlds) left.push_back(std::move(next));
    expanded.worlds.clear();
    known.emplace(fingerprint, std::move(expanded));
  }
}

// Of switches that have every phase, with one fault.
class SameNodes : public ::testing::TestWithParam<std::pair<const char*, const char*>> {
 protected:
  SameNodes() {
    for (const ActuatorIndex i : model_.kinds.Indices()) model_.kinds[i] = i;  // no symmetry
    root_ = WorldIn(model_, State(GetParam().first));
    root_.faults = root_.faults_left = 1;
  }

  Model model_{Pair(), State(GetParam().second)};
  World root_;
};

TEST_P(SameNodes, HaveTheSameSuccessorsAndViolations) {
  std::size_t again = 0;
  ForEachWorld(model_, root_, [&](const World&, const Expanded& now, const Expanded* before) {
    if (before == nullptr) return;
    ++again;
    EXPECT_EQ(now.successors, before->successors);
    EXPECT_EQ(now.at_rest, before->at_rest);
  });
  EXPECT_GT(again, 100U);
}

// Such a reply is removed as soon as the exit is known.
TEST_P(SameNodes, AreThoseBeforeAndAfterAReplyOfAProcessWhoseExitIsKnown) {
  std::size_t replies = 0;
  ForEachWorld(model_, root_, [&](const World& world, const Expanded&, const Expanded* before) {
    for (const ActuatorIndex i : world.actuators.Indices()) {
      const KnownActuator& known = world.machine.actuators[i];
      if (before != nullptr || known.process.dead == 0) continue;
      World with = world;
      event::Replied reply{i, world.machine.number, false, Verdict::kDone, kCodeOk, "", {}};
      reply.report = with.actuators[i].core.report;
      reply.report.incarnation = known.process.dead;
      reply.report.stamp = world.now + Milliseconds(1000);
      with.actuators[i].late.emplace_back(reply);
      const auto index = static_cast<std::uint8_t>(with.actuators[i].late.size() - 1);
      Notes notes;
      Make(model_, with, {ChoiceKind::kLate, static_cast<std::uint8_t>(i.value()), index, 0},
           notes);
      EXPECT_EQ(IdentityOf(model_, with).fingerprint, IdentityOf(model_, world).fingerprint);
      ++replies;
    }
  });
  EXPECT_GT(replies, 10U);
}

// Whether the controller knows that the process has exited.
bool HasExited(const KnownActuator& known) {
  return known.presence != Presence::kPresent && !known.command && !known.control.again &&
         known.report.incarnation != 0 && known.report.incarnation == known.process.dead;
}

// Another value for all that no decision reads of an exited process. What a takeover reads of its
// epoch stays the same.
void ChangeRecord(const Machine& machine, KnownActuator& known) {
  ActuatorReport& report = known.report;
  const bool has_taken = known.control.incarnation == report.incarnation && known.met;
  const bool may_be_led = !has_taken && report.epoch >= machine.epoch;
  report.number = report.number + 100;
  report.outcome_number = report.outcome_number + 100;
  report.outcome_code = report.outcome_code == kCodeOk ? kCodeFailed : kCodeOk;
  known.writer_lost = !known.writer_lost;
  known.join_tried = !known.join_tried;
  known.control.incarnation = Incarnation(99);
  known.met = !known.met;
  if (!may_be_led) report.epoch = 0;
  if (machine.phase == Phase::kStopping) report.detached = !report.detached;
}

// The same for what the process itself knew.
void ChangeProcess(const Machine& machine, SimActuator& actuator) {
  actuator.epoch = actuator.epoch + 100;
  actuator.begun = actuator.begun + 100;
  actuator.queried = actuator.queried + 100;
  actuator.energised = !actuator.energised;
  actuator.stop_requested = !actuator.stop_requested;
  ActuatorCore& core = actuator.core;
  core.report.target = State(kActive);
  core.report.busy_number = core.report.number = core.report.number + 100;
  core.report.epoch = core.report.epoch + 100;
  core.report.detached = !core.report.detached;
  core.report.emergency_stop = 7;
  if (!machine.current || core.report.outcome_number != machine.current->number) {
    core.report.outcome_number = core.report.outcome_number + 100;
  }
  core.running_for.push_back(RequestToken(1));
  core.waiting.emplace();
  core.unsettled = !core.unsettled;
  core.half_way_down = !core.half_way_down;
  core.controller = 99;
  core.announced.clear();
  core.stops.emplace_back();
  core.stopped_meanwhile = !core.stopped_meanwhile;
}

// Changes whatever counts for nothing any more. Returns whether anything does.
bool ChangeLeftovers(const Model& model, World& world) {
  const bool is_loss_read = MayReportLoss(model, world);
  bool any = !is_loss_read;
  for (const ActuatorIndex i : world.actuators.Indices()) {
    SimActuator& actuator = world.actuators[i];
    KnownActuator& known = world.machine.actuators[i];
    if (!is_loss_read) known.lost_in = known.lost_in.empty() ? State(kActive) : State();
    if (world.machine.phase != Phase::kStopped && HasExited(known)) {
      ChangeRecord(world.machine, known);
      any = true;
    }
    if (actuator.alive || actuator.end || actuator.status_due || !actuator.replies.empty())
      continue;
    ChangeProcess(world.machine, actuator);
    any = true;
  }
  if (world.faults_left == 0) world.machine.saves.actuators.clear();
  return any;
}

struct Leftovers {
  std::size_t changed = 0;  // in so many worlds
  std::size_t read = 0;     // in so many of them something else follows
};

Leftovers ReadLeftovers(const Model& model, const World& root) {
  Leftovers leftovers;
  ForEachWorld(model, root, [&](const World& world, const Expanded& now, const Expanded* before) {
    World changed = world;
    if (before != nullptr || !ChangeLeftovers(model, changed)) return;
    ++leftovers.changed;
    const Expanded other = Expand(model, changed);
    const bool same = other.successors == now.successors && other.at_rest == now.at_rest;
    leftovers.read += same ? 0 : 1;
  });
  return leftovers;
}

// What the fingerprint leaves out of an exited process is read by no rule of the decision, of the
// search and of its harness, also where no two nodes differ by it.
TEST_P(SameNodes, DependOnNothingThatAnExitedProcessHasLeft) {
  const Leftovers leftovers = ReadLeftovers(model_, root_);
  EXPECT_GT(leftovers.changed, 300U);
  EXPECT_EQ(leftovers.read, 0U);
}

INSTANTIATE_TEST_SUITE_P(Of, SameNodes,
                         ::testing::Values(std::pair("Active", "TearDown"),
                                           std::pair("LowPower", "Active"),
                                           std::pair("Active", "Error")),
                         [](const auto& which) {
                           return std::string(which.param.first) + "To" + which.param.second;
                         });

using Reads = bool (*)(const Machine&, const KnownActuator&);

using Part = std::pair<const char*, Reads>;

// A controller that holds an exited actuator by what its process has left: seen for each part.
class LeftoversThatAreRead : public ::testing::TestWithParam<Part> {};

TEST_P(LeftoversThatAreRead, AreSeen) {
  Rules rules;
  rules.controller = [](const auto& config, Machine& machine, const Event& event, Time now) {
    for (KnownActuator& known : machine.actuators) {
      if (HasExited(known) && GetParam().second(machine, known)) known.held = true;
    }
    return Step(config, machine, event, now);
  };
  const Model correct(Pair(), State(kTearDown));
  Model model(Pair(), State(kTearDown), rules);
  for (const ActuatorIndex i : model.kinds.Indices()) model.kinds[i] = i;
  World root = WorldIn(correct, State(kActive));
  root.faults = root.faults_left = 1;
  EXPECT_GT(ReadLeftovers(model, root).read, 0U);
}

INSTANTIATE_TEST_SUITE_P(
    Of, LeftoversThatAreRead,
    ::testing::Values(
        Part{"Number",
             [](const Machine& machine, const KnownActuator& known) {
               return known.report.number > machine.number;
             }},
        Part{"Outcome",
             [](const Machine& machine, const KnownActuator& known) {
               return known.report.outcome_number > machine.number;
             }},
        Part{"Code",
             [](const Machine& /*machine*/, const KnownActuator& known) {
               return known.report.outcome_code != kCodeOk;
             }},
        Part{"Detached", [](const Machine& /*machine*/,
                            const KnownActuator& known) { return known.report.detached; }},
        Part{"Writer", [](const Machine& /*machine*/,
                          const KnownActuator& known) { return known.writer_lost; }},
        Part{"Check", [](const Machine& /*machine*/,
                         const KnownActuator& known) { return known.join_tried; }},
        Part{"Epoch", [](const Machine& /*machine*/,
                         const KnownActuator& known) { return known.report.epoch == 0; }},
        Part{"Control",
             [](const Machine& /*machine*/, const KnownActuator& known) {
               return known.control.incarnation != known.report.incarnation;
             }},
        Part{"Presence",
             [](const Machine& /*machine*/, const KnownActuator& known) { return known.met; }},
        Part{"Loss", [](const Machine& /*machine*/,
                        const KnownActuator& known) { return known.lost_in.empty(); }}),
    [](const auto& which) { return std::string(which.param.first); });

}  // namespace musher::search::same_nodes_test
