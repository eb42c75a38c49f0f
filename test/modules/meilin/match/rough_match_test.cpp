// A match whose robot can fall, with a crash, a hang, a stop, a pause, a reset or a failed action
// at a random moment, in half of the matches with another one soon after it, also on the way off an
// edge; then the way on that is documented.
//
//   MUSHER_SEEDS=500 build/dev/bin/meilin_match_test     runs so many matches
//   MUSHER_SEED=17 …                                     runs one, and prints what happens

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>
#include <map>
#include <memory>
#include <random>

#include "musher/behavior/tree/build.hpp"
#include "musher/behavior/tree/xml/tree_xml.hpp"
#include "musher/modules/meilin/mission/mission.hpp"
#include "musher/modules/meilin/nodes/edge.hpp"
#include "musher/modules/meilin/nodes/place.hpp"
#include "musher/modules/meilin/nodes/register.hpp"
#include "musher/test/modules/meilin/match/lift_robot.hpp"
#include "musher/test/support/nightly.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::meilin::testing {
namespace {

std::string ConfigFile(const std::string& name) {
  return SourceDir() + "/config/meilin/" + name;
}

int Environment(const char* name, int otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::stoi(text);
}

// One process of the mission.
class Process {
 public:
  Process(LiftRobot& robot, Side side, const std::string& tree, const std::string& match_file)
      : robot_(robot) {
    // As config/meilin/mission.toml has them.
    settings_.grid.side = side;
    settings_.align_timeout_s = 45;
    settings_.suspension_timeout_s = 40;
    MatchConfig match;
    if (!match_file.empty()) match = ReadMatchFile(ConfigFile(match_file)).config.value();
    mission_.emplace(robot_, settings_, match);
    EXPECT_TRUE(RegisterNodes(factory_, robot_, settings_));
    const tree::Reading reading = tree::ReadTreeFile(ConfigFile(tree));
    EXPECT_TRUE(reading.ok());
    tree::Built built = tree::Build(reading.document, factory_);
    tree_ = std::move(built.tree);
    EXPECT_TRUE(mission_->Fill(tree_->board()));
  }

  void Tick() {
    robot_.Step();
    mission_->BeforeTick(robot_.Now());
    Follow();
    tree::Status status = tree::Status::kIdle;
    if (!rests_) {
      const Result<tree::Status> ticked = tree_->TickOnce(robot_.Now());
      status = ticked ? ticked.value() : tree::Status::kFailure;
      rests_ = status != tree::Status::kRunning;
    }
    mission_->AfterTick(status, "", robot_.Now());
  }
  void Pause() {
    static_cast<void>(tree_->Halt(robot_.Now()));
    mission_->OnPause();
    Follow();
  }
  void Reset() {
    static_cast<void>(tree_->Halt(robot_.Now()));
    EXPECT_TRUE(mission_->Command("RESET"));
    Follow();
  }
  Mission& mission() { return *mission_; }
  const Settings& settings() const { return settings_; }

 private:
  void Follow() {
    if (mission_->TakeRestart()) {
      static_cast<void>(tree_->Halt(robot_.Now()));
      rests_ = false;
    }
    if (!mission_->TakeStop()) return;
    static_cast<void>(tree_->Halt(robot_.Now()));
    rests_ = true;
  }

  LiftRobot& robot_;
  Settings settings_;
  tree::Factory factory_;
  std::optional<Mission> mission_;
  std::unique_ptr<tree::Tree> tree_;
  bool rests_ = true;
};

bool OnFourWheels(const LiftRobot& robot, const Settings& settings) {
  const PoseFix pose = *robot.pose();
  return !robot.fallen() && !PlanOffEdge(settings, pose, robot.wheels()).on_edge &&
         LongestMm(*robot.wheels()) <= kOutWheelMm;
}

// --- a climb that is stopped at each of its moments ---

struct Climb {
  Cell from;
  Cell to;
};

// Ends a climb `after` ticks. False: it had ended before.
bool StopClimb(LiftRobot& robot, Process& process, const Climb& climb, double yaw_rad, int after) {
  const double height_mm = process.settings().grid.HeightMm(climb.to);
  EXPECT_TRUE(process.mission().Start("meilin", robot.Now()));
  EXPECT_TRUE(process.mission().OfferPlan(ToActionSequence({{false, climb.to, height_mm, yaw_rad}}),
                                          robot.Now()))
      << process.mission().refused_plan();
  for (int tick = 0; tick < after; ++tick) {
    process.Tick();
    if (process.mission().state() == kMissionSuccess) return false;
  }
  process.Pause();
  robot.StopAll("Aborted: an emergency stop was engaged");
  for (int tick = 0; tick < 50; ++tick) process.Tick();  // whatever moves yet comes to rest
  return true;
}

// `box`: one that was not taken stands on the upper cell.
void ComesOff(const Climb& climb, double yaw_rad, int every, bool box = false) {
  for (int after = 10; after < 3000; after += every) {
    SCOPED_TRACE(CellText(climb.from) + " to " + CellText(climb.to) + ", stopped after " +
                 std::to_string(after) + " ticks, yaw " + std::to_string(yaw_rad));
    LiftRobot robot(Side::kBlue);
    robot.Put(Grid{}.Centre(climb.from), yaw_rad);
    if (box) robot.box = climb.to;
    Process process(robot, Side::kBlue, "meilin_stage.xml", "");
    if (!StopClimb(robot, process, climb, yaw_rad, after)) return;
    ASSERT_FALSE(robot.fallen()) << robot.body().fall();
    const PoseFix at = *robot.pose();
    SCOPED_TRACE("at " + std::to_string(at.x_m) + ", " + std::to_string(at.y_m) + ", z " +
                 std::to_string(at.z_m) + ", wheels " + WheelsText(*robot.wheels()));
    // A process that knows nothing but what its sensors say.
    Process next(robot, Side::kBlue, "meilin_stage.xml", "");
    const Result<std::string> begun = next.mission().Start("meilin", robot.Now());
    ASSERT_TRUE(begun) << begun.error().message;
    for (int tick = 0; tick < 12'000 && next.mission().state() != kWaitingSequence; ++tick) {
      next.Tick();
      if (next.mission().failed()) break;
    }
    ASSERT_FALSE(robot.fallen()) << robot.body().fall();
    ASSERT_EQ(next.mission().state(), kWaitingSequence) << next.mission().last_error();
    ASSERT_TRUE(OnFourWheels(robot, next.settings()));
  }
}

TEST(ARobotThatIsStoppedInAClimb, ComesOffTheEdgeFromEachOfItsMoments) {
  const int every = Environment("MUSHER_STEP", musher::testing::Nightly() ? 40 : 120);
  const std::vector<Climb> climbs = {{{0, 1}, {1, 1}}, {{0, 0}, {1, 0}}, {{1, 1}, {1, 2}},
                                     {{3, 1}, {4, 1}}, {{4, 1}, {5, 1}}, {{2, 1}, {2, 2}}};
  int at = 0;
  for (const Climb& climb : climbs) {
    // In each direction of the body, of which a climb backward has no plan.
    const double way = YawOf(*DirectionTo(climb.from, climb.to));
    const double turn = std::array{0.0, kPi / 2, -kPi / 2}.at(static_cast<std::size_t>(at++ % 3));
    ASSERT_NO_FATAL_FAILURE(ComesOff(climb, NormalizeYaw(way + turn), every));
  }
}

TEST(ARobotThatIsStoppedInAClimb, GoesBackWhereTheWayOnIsBlocked) {
  const int every = Environment("MUSHER_STEP", musher::testing::Nightly() ? 500 : 1400);
  ASSERT_NO_FATAL_FAILURE(ComesOff({{0, 1}, {1, 1}}, 0, every, true));
  ASSERT_NO_FATAL_FAILURE(ComesOff({{0, 0}, {1, 0}}, kPi / 2, every, true));
}

// --- whole matches ---

std::vector<PlanStep> PlanFrom(const Grid& grid, Cell cell, bool fetches) {
  std::vector<PlanStep> steps = {{false, cell, static_cast<double>(grid.HeightMm(cell)), 0}};
  for (Cell to{cell.row + 1, cell.col}; to.row < kRows; ++to.row) {
    const double step_mm = grid.HeightMm(to) - grid.HeightMm({to.row - 1, to.col});
    if (fetches && step_mm > 0 && to.row <= 3) {
      steps.push_back({true, to, step_mm, 0});
      const Cell here{to.row - 1, to.col};
      steps.push_back({false, here, static_cast<double>(grid.HeightMm(here)), 0});
    }
    steps.push_back({false, to, static_cast<double>(grid.HeightMm(to)), 0});
  }
  return steps;
}

enum class Trouble { kCrash, kHang, kStop, kPause, kAction, kReset, kCount };
constexpr std::array<const char*, 6> kTroubles = {"crash", "hang",          "emergency stop",
                                                  "pause", "failed action", "reset"};

class RoughMatch {
 public:
  RoughMatch(unsigned seed, bool prints)
      : random_(seed),
        prints_(prints),
        side_(seed % 2 == 0 ? Side::kBlue : Side::kRed),
        robot_(side_) {
    first_ = trouble_ = AnyTrouble();
    at_tick_ = 100 + Any(5'500);  // a match has some 60 s
    Begin();
    process_->mission().Start("full", robot_.Now()).value();
    Offer(true);
  }

  // False: it has not come to its end.
  bool Play() {
    for (int tick = 0; tick < 60'000; ++tick) {
      process_->Tick();
      if (robot_.fallen()) return false;
      if (tick == at_tick_) Happen();
      if (tick == at_tick_ && troubles_ < 2 && Any(2) == 0) {
        at_tick_ = tick + 50 + Any(2'000);
        trouble_ = AnyTrouble();
      }
      const std::string state = process_->mission().state();
      if (state == kMissionSuccess) return true;
      const bool stands = !process_->mission().begun() || process_->mission().failed();
      if (stands && !GoOn()) return false;
      if (state == kWaitingSequence && !process_->mission().failed()) Offer(false);
    }
    Say("it has not come to an end in ten minutes");
    return false;
  }

  const LiftRobot& robot() const { return robot_; }
  Process& process() { return *process_; }
  const char* first_trouble() const { return NameOf(first_); }
  int by_hand() const { return by_hand_; }

 private:
  static const char* NameOf(Trouble trouble) {
    return kTroubles.at(static_cast<std::size_t>(trouble));
  }
  int Any(int below) { return static_cast<int>(random_() % static_cast<unsigned>(below)); }
  Trouble AnyTrouble() { return static_cast<Trouble>(Any(static_cast<int>(Trouble::kCount))); }
  void Say(const std::string& text) {
    if (!prints_) return;
    const PoseFix at = robot_.pose().value_or(PoseFix{});
    std::cout << ToSeconds(robot_.Now().time_since_epoch()) << " s: " << text << "  (" << at.x_m
              << ", " << at.y_m << ", z " << at.z_m << ", "
              << (robot_.wheels() ? WheelsText(*robot_.wheels()) : "") << ")\n";
  }
  void Begin() {
    process_ = std::make_unique<Process>(robot_, side_, "full_match.xml",
                                         "simulated_" + std::string(SideText(side_)) + ".json");
  }

  // The trouble, and then some seconds without a person.
  void Happen() {
    ++troubles_;
    Say(std::string(NameOf(trouble_)) + " in " + process_->mission().state());
    Mission& mission = process_->mission();
    switch (trouble_) {
      case Trouble::kCrash:
      case Trouble::kHang: {
        const Progress progress = mission.SavedProgress();
        // Goals go on without it, also while it hangs.
        for (int tick = Any(trouble_ == Trouble::kHang ? 1'500 : 200); tick > 0; --tick) {
          robot_.Step();
        }
        Begin();
        robot_.StopAll("Cancelled");  // all that an earlier process has left, at the next Active
        EXPECT_TRUE(process_->mission().Restore(progress));
        break;
      }
      case Trouble::kStop:
      case Trouble::kPause:
        if (Any(2) == 0) {  // the servers know of it first
          robot_.StopAll("Aborted: an emergency stop was engaged");
          for (int tick = Any(20); tick > 0; --tick) process_->Tick();
        }
        process_->Pause();
        robot_.StopAll("Aborted: it is in Protected");
        for (int tick = Any(500); tick > 0; --tick) robot_.Step();
        break;
      case Trouble::kAction: {
        const int kind = Any(4);
        broken_ = false;
        robot_.breaks = [this, kind](const LiftRobot::Live& live) {
          if (static_cast<int>(live.server) != kind || broken_) return std::string();
          broken_ = true;
          return std::string("broken");
        };
        break;
      }
      default:
        process_->Reset();
    }
    const PoseFix before = *robot_.pose();
    for (int tick = 0; tick < 300; ++tick) process_->Tick();
    const bool waits =
        trouble_ == Trouble::kCrash || trouble_ == Trouble::kHang || trouble_ == Trouble::kReset;
    if (!waits) return;
    const PoseFix after = *robot_.pose();
    EXPECT_LT(std::hypot(after.x_m - before.x_m, after.y_m - before.y_m), 0.6)
        << "only what was already moving comes to rest";
  }

  // What an operator does. False: nothing helps.
  bool GoOn() {
    if (++tries_ > 12) {
      Say("no way on: " + process_->mission().last_error());
      return false;
    }
    for (int tick = 0; tick < 50; ++tick) process_->Tick();  // until a person looks, it rests
    Mission& mission = process_->mission();
    const auto start = [&](const std::string& region) {
      const Result<std::string> begun = mission.Start(region, robot_.Now());
      Say("start " + region + ": " + (begun ? begun.value() : begun.error().message));
      return begun.ok();
    };
    if (start("") || start("full") || start("meilin") || start("final")) return true;
    const std::optional<Cell> cell =
        process_->settings().grid.CellAt({robot_.pose()->x_m, robot_.pose()->y_m});
    ++by_hand_;
    robot_.Put(process_->settings().grid.Centre(cell.value_or(Cell{0, 1})), 0);
    Say("put on a cell by hand");
    return true;
  }

  void Offer(bool fetches) {
    const Grid& grid = process_->settings().grid;
    const std::optional<PoseFix> pose = robot_.pose();
    const std::optional<Cell> cell = pose ? grid.CellAt({pose->x_m, pose->y_m}) : std::nullopt;
    const auto steps = PlanFrom(grid, fetches ? Cell{0, 1} : cell.value_or(Cell{0, 1}), fetches);
    const bool taken = process_->mission().OfferPlan(ToActionSequence(steps), robot_.Now());
    Say(taken ? "a plan is sent" : "a plan is refused: " + process_->mission().refused_plan());
  }

  std::mt19937 random_;
  const bool prints_;
  const Side side_;
  LiftRobot robot_;
  std::unique_ptr<Process> process_;
  Trouble first_ = Trouble::kCrash;
  Trouble trouble_ = Trouble::kCrash;  // the next one, or the last
  int troubles_ = 0;
  int at_tick_ = 0;
  bool broken_ = false;
  int tries_ = 0;
  int by_hand_ = 0;
};

void PlayMatches(int matches) {
  const int only = Environment("MUSHER_SEED", -1);
  const int first = only >= 0 ? only : 0;
  const int last = only >= 0 ? only : Environment("MUSHER_SEEDS", matches) - 1;
  int won = 0;
  int by_hand = 0;
  int falls = 0;
  int on_wheels = 0;
  std::map<std::string, std::pair<int, int>> of;  // by trouble: matches, and those that were won
  for (int seed = first; seed <= last; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    RoughMatch match(static_cast<unsigned>(seed), only >= 0);
    const bool done = match.Play();
    won += done ? 1 : 0;
    by_hand += match.by_hand();
    ++of[match.first_trouble()].first;
    of[match.first_trouble()].second += done ? 1 : 0;
    EXPECT_FALSE(match.robot().fallen()) << match.robot().body().fall();
    const std::string state = match.process().mission().state();
    EXPECT_TRUE(state == kMissionSuccess || state == kMissionFailed || state == kWaitingStart)
        << state;
    const bool stands = OnFourWheels(match.robot(), match.process().settings());
    EXPECT_TRUE(stands);
    falls += match.robot().fallen() ? 1 : 0;
    on_wheels += stands ? 1 : 0;
    if (done) continue;
    std::cout << "seed " << seed << ", " << match.first_trouble() << ": not to the end, " << state
              << ": " << match.process().mission().last_error() << "\n";
  }
  std::cout << last - first + 1 << " matches: " << falls << " falls, " << on_wheels
            << " ended in a named state on four wheels, " << won << " to their end\n";
  for (const auto& [trouble, count] : of) {
    std::cout << trouble << ": " << count.second << " of " << count.first
              << " matches to the end\n";
  }
  std::cout << by_hand << " times put on a cell by hand\n";
  EXPECT_GE(won * 10, (last - first + 1) * 9) << "nine of ten matches come to their end";
}

TEST(ARoughMatch, EndsWithoutAFallInANamedStateOnFourWheels) {
  PlayMatches(5);
}
TEST(FiveHundredRoughMatches, EndWithoutAFallInANamedStateOnFourWheels) {
  PlayMatches(500);
}

}  // namespace
}  // namespace musher::meilin::testing
