#pragma once
// A match on a fake robot in virtual time: the tree is ticked by hand at 100 Hz, with the mission
// around it as the actuator has it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "musher/behavior/tree/build.hpp"
#include "musher/behavior/tree/xml/tree_xml.hpp"
#include "musher/modules/meilin/mission/mission.hpp"
#include "musher/modules/meilin/nodes/drawn_form.hpp"
#include "musher/modules/meilin/nodes/register.hpp"
#include "musher/test/modules/meilin/mission/fake_robot.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::meilin::testing {

inline std::string ConfigFile(const std::string& name) {
  return SourceDir() + "/config/meilin/" + name;
}

struct Match {
  // What a process has without the word of a person: it waits.
  struct Waiting {};

  explicit Match(const std::string& file, MatchConfig match = {}, Side side = Side::kBlue)
      : Match(Waiting{}, file, std::move(match), side) {
    Begun();
  }
  Match(Waiting, const std::string& file, MatchConfig match = {}, Side side = Side::kBlue,
        bool autostart = false)
      : settings(WithSide(side)), mission(robot, settings, std::move(match), autostart) {
    EXPECT_TRUE(RegisterNodes(factory, robot, settings));
    Load(tree::ReadTreeFile(ConfigFile(file)));
  }
  // The content of one tree.
  static Match Of(const std::string& content) { return {FromText{content}}; }

  struct FromText {
    std::string content;
  };
  Match(FromText text) : mission(robot, settings, {}) {  // NOLINT(google-explicit-constructor)
    EXPECT_TRUE(RegisterNodes(factory, robot, settings));
    Load(tree::ReadTree("<root BTCPP_format=\"4\"><BehaviorTree ID=\"Main\">" + text.content +
                            "</BehaviorTree></root>",
                        "t.xml"));
    Begun();
  }
  Match(const Match&) = delete;

  static Settings WithSide(Side side) {
    Settings settings;
    settings.grid.side = side;
    return settings;
  }

  void Load(tree::Reading reading) {
    std::string found;
    for (const Diagnostic& each : reading.diagnostics) found += FormatDiagnostic(each) + "\n";
    ASSERT_TRUE(reading.ok()) << found;
    drawn = AcceptDrawnForm(reading.document);  // as the actuator does
    mission.SetForms(FormsOf(reading.document));
    tree::Built built = tree::Build(reading.document, factory);
    for (const Diagnostic& each : built.diagnostics) found += FormatDiagnostic(each) + "\n";
    ASSERT_NE(built.tree, nullptr) << found;
    EXPECT_EQ(found, "");
    tree = std::move(built.tree);
    ASSERT_TRUE(mission.Fill(tree->board()));
    board.emplace(tree->board());
    rests = true;
  }

  // The word of a person.
  Match& Begun(const std::string& region = "full") {
    const Result<std::string> begun = mission.Start(region, robot.Now());
    EXPECT_TRUE(begun) << (begun ? "" : begun.error().message);
    Follow();
    return *this;
  }
  std::string WhyNot(const std::string& region) {
    const Result<std::string> begun = mission.Start(region, robot.Now());
    return begun ? "" : begun.error().message;
  }

  void Reset() {
    static_cast<void>(tree->Halt(robot.Now()));
    EXPECT_TRUE(mission.Command("RESET"));
    Follow();
  }
  // As the actuator does it.
  void Follow() {
    if (mission.TakeRestart()) {
      static_cast<void>(tree->Halt(robot.Now()));
      rests = false;
    }
    if (mission.TakeStop()) {
      static_cast<void>(tree->Halt(robot.Now()));
      rests = true;
    }
  }

  tree::Status Tick() {
    robot.Advance(Milliseconds(10));
    mission.BeforeTick(robot.Now());
    Follow();
    tree::Status status = tree::Status::kIdle;
    std::string fault;
    if (!rests) {
      const Result<tree::Status> ticked = tree->TickOnce(robot.Now());
      status = ticked ? ticked.value() : tree::Status::kFailure;
      if (!ticked) fault = ticked.error().message;
      rests = status != tree::Status::kRunning;
    }
    mission.AfterTick(status, fault, robot.Now());
    return last = status;
  }
  // Until the tree rests or waits for a plan, at most so many seconds.
  void Run(double seconds) {
    for (int i = 0; i < seconds * 100; ++i) {
      Tick();
      if (rests) return;
    }
  }
  void RunFor(double seconds) {
    for (int i = 0; i < seconds * 100; ++i) Tick();
  }
  void Pause() {
    static_cast<void>(tree->Halt(robot.Now()));
    mission.OnPause();
    if (mission.TakeStop()) rests = true;
  }
  void LoseDebugger() {
    static_cast<void>(tree->Halt(robot.Now()));
    rests = true;
    mission.Stand("its debugger was lost before the match could begin");
    Follow();
  }

  bool Offer(const std::vector<PlanStep>& steps, std::int64_t written_ns = 0) {
    return mission.OfferPlan(ToActionSequence(steps), robot.Now(), written_ns);
  }
  bool OfferOld(const std::string& segments, std::int64_t written_ns = 0) {
    return mission.OfferSegments(R"({"segments": [)" + segments + "]}", robot.Now(), written_ns);
  }

  FakeRobot robot;
  Settings settings;
  Mission mission;
  tree::Factory factory;
  std::unique_ptr<tree::Tree> tree;
  std::optional<MissionBoard> board;
  std::vector<Diagnostic> drawn;
  bool rests = true;
  tree::Status last = tree::Status::kIdle;
};

inline PlanStep MoveStep(int row, int col, double height_mm, double yaw_rad = 0) {
  return {false, {row, col}, height_mm, yaw_rad};
}
inline PlanStep FetchStep(int row, int col, double difference_mm, double yaw_rad = 0) {
  return {true, {row, col}, difference_mm, yaw_rad};
}

}  // namespace musher::meilin::testing
