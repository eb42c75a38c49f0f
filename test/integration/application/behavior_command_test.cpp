// `musher behavior` and `musher graph --behavior` with a running application.

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <future>
#include <iterator>

#include "musher/behavior/fsm/graph.hpp"
#include "musher/test/actuator/robot_file.hpp"
#include "musher/test/application/show.hpp"
#include "musher/test/cli/program.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/process.hpp"

namespace musher::behavior_command_test {

using cli::Ran;
using cli::RunProgram;
using testing::Harness;
using ::testing::HasSubstr;
using testing::Process;
using testing::RobotFile;
using testing::Show;
using testing::Until;

const std::string kMusher = BinDir() + "/musher";

class BehaviorCommand : public ::testing::Test {
 protected:
  // In PLAY for 40 ms.
  template <class Application>
  void Begin(Application& show) {
    harness_.Open(show);
    ASSERT_TRUE(harness_.controller().Switch("SelfCheck").done());
    ASSERT_TRUE(harness_.controller().Switch("Active").done());
    harness_.Tick(show, 7);
  }
  // Completion looks for some 100 ms, since a person waits at a prompt; on a busy computer it may
  // be in vain, and the key is pressed again.
  static void ExpectOffered(std::vector<std::string> words, const std::string& offered) {
    words.insert(words.begin(), "complete");
    std::string out;
    Until([&] { return (out = RunProgram(words).out) == offered; });
    EXPECT_EQ(out, offered);
  }
  std::string Dot(Show& show) {
    return show.Of([](Show& s) { return fsm::ToDot(s.machine().chart(), s.machine().Path()); });
  }

  Harness harness_;
};

TEST_F(BehaviorCommand, ShowsStateModeTicksTimeAndTheLastChanges) {
  ActuatorRunner<Show> show;
  Begin(show);
  const Ran ran = RunProgram({"behavior", "show"});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_EQ(ran.out,
            "show  PLAY  NORMAL  for 0.040 s\n"
            "7 ticks in 0.140 s of its time\n"
            "AT       TICK  FROM   TO     CAUSE\n"
            "0.000 s  0     -      GREET  started\n"
            "0.100 s  5     GREET  PLAY   decided\n");
  const Ran last = RunProgram({"behavior", "show", "--history", "1"});
  EXPECT_THAT(last.out, ::testing::Not(HasSubstr("started")));
  EXPECT_THAT(last.out, HasSubstr("decided"));
}

TEST_F(BehaviorCommand, ShowsThatTheMachineIsPausedAndWhyItIsInItsSafeState) {
  ActuatorRunner<Show> show;
  Begin(show);
  show.RunOnLoop([&] { show.data().unsafe = true; });
  harness_.Tick(show, 1);
  ASSERT_TRUE(harness_.controller().Switch("Protected").done());
  const Ran ran = RunProgram({"behavior", "show", "--history", "1"});
  EXPECT_EQ(ran.out,
            "show  STOP  SAFE_STOP  for 0.000 s  paused\n"
            "8 ticks in 0.160 s of its time\n"
            "unsafe: too close\n"
            "AT       TICK  FROM  TO    CAUSE\n"
            "0.160 s  8     PLAY  STOP  unsafe\n");
}

TEST_F(BehaviorCommand, PrintsJson) {
  ActuatorRunner<Show> show;
  Begin(show);
  const Ran ran = RunProgram({"--json", "behavior", "show", "--history", "1"});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_EQ(
      ran.out,
      R"({"actuator":"show","running":true,"ticking":true,"held_by_stop":false,"state":"PLAY",)"
      R"("mode":"NORMAL",)"
      R"("ticks":7,"safety_triggered":false,"unsafe":null,"time_s":0.14,)"
      R"("time_in_state_s":0.04,"last_fault":null,"history":[{"time_s":0.1,"tick":5,)"
      R"("from":"GREET","to":"PLAY","cause":"decided","command":null}]})"
      "\n");
}

TEST_F(BehaviorCommand, SendsACommandThatTheApplicationRegistered) {
  ActuatorRunner<Show> show;
  Begin(show);
  const Ran ran = RunProgram({"behavior", "show", "--send", "again"});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_EQ(ran.out, "sent again to show\n");
  harness_.Tick(show, 1);
  EXPECT_THAT(RunProgram({"behavior", "show"}).out, HasSubstr("decided by again"));
}

TEST_F(BehaviorCommand, PrintsWhyACommandIsRefused) {
  ActuatorRunner<Show> show;
  Begin(show);
  const Ran unknown = RunProgram({"behavior", "show", "--send", "agian"});
  EXPECT_EQ(unknown.exit, 1);
  EXPECT_EQ(unknown.err, "musher: show: there is no event agian; did you mean 'again'?\n");
  ASSERT_TRUE(harness_.controller().Switch("Protected").done());
  const Ran paused = RunProgram({"behavior", "show", "--send", "again"});
  EXPECT_EQ(paused.exit, 1);
  EXPECT_EQ(paused.err, "musher: show is paused in Protected\n");
}

TEST_F(BehaviorCommand, SendsNoCommandWithoutAName) {
  const Ran ran = RunProgram({"behavior", "show", "--send", ""});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_EQ(ran.out, "");
  EXPECT_THAT(ran.err, HasSubstr("--send"));
}

TEST_F(BehaviorCommand, DrawsNoGraphIntoAFileOfAKindThatItCannotWrite) {
  const std::string file = harness_.state_dir() + ".pdf";
  const Ran ran = RunProgram({"graph", "--behavior", "show", "-o", file});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.err,
              HasSubstr(".pdf: unknown graph format; expected .dot, .gv, .mmd, .mermaid or .svg"));
  EXPECT_FALSE(std::ifstream(file).is_open());
  EXPECT_EQ(RunProgram({"graph", harness_.path(), "-o", file}).exit, 2) << "of a config, too";
  EXPECT_EQ(RunProgram({"graph", harness_.path(), "-o", file, "--format", "dot"}).exit, 0);
}

TEST_F(BehaviorCommand, FollowsEveryChangeUntilItIsInterrupted) {
  ActuatorRunner<Show> show;
  Begin(show);
  Process text({kMusher, "behavior", "show", "--follow"});
  Process json({kMusher, "--json", "behavior", "show", "--follow"});
  ASSERT_NE(text.LineWith("decided"), "");
  ASSERT_NE(json.LineWith("\"decided\""), "");
  show.RunOnLoop([&] { show.data().unsafe = true; });
  harness_.Tick(show, 1);
  EXPECT_THAT(text.LineWith("unsafe"), HasSubstr("0.160 s  PLAY -> STOP  unsafe"));
  EXPECT_THAT(json.LineWith("unsafe\""), HasSubstr(R"("from":"PLAY","to":"STOP")"));
  show.RunOnLoop([&] { show.data().unsafe = false; });
  harness_.Tick(show, 6);
  EXPECT_THAT(text.LineWith("decided"), HasSubstr("STOP -> GREET"));
  text.Signal(SIGINT);
  EXPECT_EQ(text.Wait().exit, 0);
}

TEST_F(BehaviorCommand, ReportsThatTheApplicationWasLostAndThatItIsBack) {
  auto show = std::make_unique<ActuatorRunner<Show>>();
  Begin(*show);
  Process watch({kMusher, "behavior", "show", "--follow"});
  ASSERT_NE(watch.LineWith("decided"), "");
  show.reset();
  EXPECT_NE(watch.LineWith("show is lost"), "");
  show = std::make_unique<ActuatorRunner<Show>>();
  ASSERT_TRUE(show->Prepare(harness_.path()).ok());
  ASSERT_TRUE(show->Start().ok());
  ASSERT_TRUE(Until([&] { return harness_.controller().Switch("Active").done(); }));
  EXPECT_NE(watch.LineWith("- -> GREET  started"), "");
}

TEST_F(BehaviorCommand, IsCompletedByTheNamesOfApplications) {
  ActuatorRunner<Show> show;
  Begin(show);
  ExpectOffered({"behavior", ""}, "show\t\n");
  ExpectOffered({"graph", "--behavior", "s"}, "show\t\n");
  EXPECT_EQ(RunProgram({"complete", "behavior", "x"}).out, "");
  ExpectOffered({"behavior", "show", "--send", ""}, "again\t\n");
  EXPECT_EQ(RunProgram({"complete", "behavior", "--send", ""}).out, "");
}

TEST_F(BehaviorCommand, SuggestsTheNearestActuatorWhereNoneOfThatNameRuns) {
  ActuatorRunner<Show> show;
  Begin(show);
  const Ran ran = RunProgram({"behavior", "shwo"});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_EQ(ran.err, "musher: no actuator 'shwo' in the default namespace; did you mean 'show'?\n");
  const Ran graph = RunProgram({"graph", "--behavior", "camera"});
  EXPECT_EQ(graph.exit, 2);
  EXPECT_EQ(graph.err, "musher: no actuator 'camera' in the default namespace; running: show\n");
}

TEST_F(BehaviorCommand, ReportsThatNothingRunsAtAll) {
  const Ran ran = RunProgram({"--namespace", "nowhere", "behavior", "show"});
  EXPECT_EQ(ran.exit, 3);
  EXPECT_THAT(ran.err, HasSubstr("no actuator in namespace 'nowhere'"));
  EXPECT_EQ(RunProgram({"behavior", "not a name"}).exit, 2);
}

TEST_F(BehaviorCommand, ReportsThatNoApplicationRunsWhereThereIsOnlyAController) {
  ASSERT_TRUE(harness_.controller().Init(harness_.path()).ok());
  const Ran ran = RunProgram({"behavior", "show"});
  EXPECT_EQ(ran.exit, 3);
  EXPECT_EQ(ran.err, "musher: no actuator 'show' in the default namespace: none runs there\n");
}

TEST_F(BehaviorCommand, ReportsThatAnActuatorIsNotAStateMachine) {
  const RobotFile file({"lamp"}, {"SetUp"});
  ActuatorRunner<MachineActuator> lamp("lamp");
  lamp.RegisterStateCallback("SetUp", [] { return kCodeOk; });
  ASSERT_TRUE(lamp.Init(file.path()).ok());
  ASSERT_TRUE(lamp.Start().ok());
  const Ran ran = RunProgram({"--namespace", RobotFile::name_space(), "behavior", "lamp"});
  EXPECT_EQ(ran.exit, 1);
  EXPECT_THAT(ran.err, HasSubstr("lamp runs but is not a state machine"));
}

TEST_F(BehaviorCommand, DoesNotWaitForAnApplicationThatBlocks) {
  ActuatorRunner<Show> show;
  Begin(show);
  std::promise<void> blocked;
  std::promise<void> release;
  auto block = std::async(std::launch::async, [&] {
    show.RunOnLoop([&] {
      blocked.set_value();
      release.get_future().wait();
    });
  });
  blocked.get_future().wait();
  const Ran ran = RunProgram({"--timeout", "5", "behavior", "show"});
  release.set_value();
  EXPECT_EQ(ran.exit, 4);
  EXPECT_EQ(ran.err, "musher: show did not answer within 5 s\n");
}

TEST_F(BehaviorCommand, DrawsTheMachineWithItsPresentStateMarked) {
  ActuatorRunner<Show> show;
  Begin(show);
  const Ran dot = RunProgram({"graph", "--behavior", "show"});
  EXPECT_EQ(dot.exit, 0) << dot.err;
  EXPECT_EQ(dot.out, Dot(show));
  EXPECT_THAT(RunProgram({"graph", "--behavior", "show", "--format", "mermaid"}).out,
              HasSubstr("stateDiagram-v2"));
  const Ran json = RunProgram({"--json", "graph", "--behavior", "show"});
  EXPECT_THAT(json.out, HasSubstr(R"({"format":"dot","graph":"digraph)"));
}

TEST_F(BehaviorCommand, DrawsSvgThroughGraphvizIntoAFile) {
  if (std::system("dot -V 2>/dev/null") != 0) GTEST_SKIP() << "there is no Graphviz here";
  ActuatorRunner<Show> show;
  Begin(show);
  const TempFolder folder;
  const Ran ran = RunProgram({"graph", "--behavior", "show", "-o", folder / "now.svg"});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  std::ifstream file(folder / "now.svg");
  const std::string svg{std::istreambuf_iterator<char>(file), {}};
  EXPECT_THAT(svg, HasSubstr("PLAY"));
  EXPECT_THAT(svg, HasSubstr("</svg>"));
}

TEST_F(BehaviorCommand, NamesThePackageToInstallWithoutGraphviz) {
  ActuatorRunner<Show> show;
  Begin(show);
  const TempFolder empty;
  const char* const usual = std::getenv("PATH");
  ASSERT_NE(usual, nullptr);
  const std::string path = usual;
  setenv("PATH", empty.path().c_str(), 1);
  const Ran ran = RunProgram({"graph", "--behavior", "show", "--format", "svg"});
  setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.err, HasSubstr("install the package graphviz"));
}

TEST(GraphCommandLine, TakesAConfigOrAnApplication) {
  EXPECT_THAT(RunProgram({"graph"}).err,
              HasSubstr("FILE, or --behavior, --tree or --skill with a NAME, is required"));
  EXPECT_EQ(RunProgram({"graph"}).exit, 2);
  EXPECT_EQ(RunProgram({"graph", "robot.toml", "--behavior", "show"}).exit, 2);
  EXPECT_EQ(RunProgram({"graph", "--what", "flow", "--behavior", "show"}).exit, 2);
}

}  // namespace musher::behavior_command_test
