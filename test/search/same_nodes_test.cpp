// What counts as the same node of a search: whatever follows from the one follows from the other.

#include <gmock/gmock.h>

#include <deque>
#include <map>
#include <vector>

#include "musher/search/explorer.hpp"
#include "musher/search/fingerprint.hpp"
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

INSTANTIATE_TEST_SUITE_P(Of, SameNodes,
                         ::testing::Values(std::pair("Active", "TearDown"),
                                           std::pair("LowPower", "Active"),
                                           std::pair("Active", "Error")),
                         [](const auto& which) {
                           return std::string(which.param.first) + "To" + which.param.second;
                         });

}  // namespace musher::search::same_nodes_test
