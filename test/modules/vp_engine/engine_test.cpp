// The actuator: programs that are added, run and stopped by its service, in the states of the
// robot.

#include "musher/modules/vp_engine/engine.hpp"
#include "musher/messages/musher_msgs/behavior.hpp"
#include "musher/test/application/show.hpp"
#include "musher/test/application/suspended_thread.hpp"
#include "musher/test/support/refusals.hpp"

namespace musher::vp_engine::engine_test {

using testing::HasRefusal;
using ::testing::HasSubstr;
using Op = msg::ManageProgram;

class Peeked : public Engine, public musher::testing::Inspected<Peeked> {
 public:
  using Engine::Engine;
  using Engine::Now;
  using Engine::Restart;
};

std::string Sequence(const std::string& content) {
  return "<root BTCPP_format=\"4\">\n<BehaviorTree ID=\"P\">\n<Sequence>\n" + content +
         "\n</Sequence>\n</BehaviorTree>\n</root>\n";
}

class AnEngine : public ::testing::Test {
 protected:
  AnEngine() {
    harness_.Open(engine_, thread_);
    harness_.node().RunOnLoop([&] {
      client_ = transport::MakeClient<Op>(harness_.node().node(), "show/manage_program").value();
      audio_ = transport::MakeServer<msg::AudioTextPlay>(harness_.node().node(), "speech_text_play",
                                                         [&](const auto& request, auto reply) {
                                                           said_.push_back(request.text);
                                                           if (request.text == "broken")
                                                             reply({1, 5012});
                                                           if (request.text == "Hello")
                                                             reply({0, 0});
                                                         })
                   .value();
    });
  }
  ~AnEngine() override {
    harness_.node().RunOnLoop([&] {
      client_.reset();
      audio_.reset();
    });
  }
  bool Go(const State& state) { return harness_.controller().Switch(state).done(); }
  void Activate() {
    ASSERT_TRUE(Go("SelfCheck"));
    ASSERT_TRUE(Go("Active"));
  }
  Op::Response Do(std::uint8_t operation, const std::string& program = "",
                  const std::string& text = "", std::vector<msg::ProgramSetting> settings = {}) {
    Op::Request request;
    request.operation = operation;
    request.program = program;
    request.text = text;
    request.settings = std::move(settings);
    std::optional<Op::Response> response;
    harness_.node().RunOnLoop([&] {
      client_->Call(request, std::chrono::seconds(120),
                    [&](const auto& reply) { response = reply.value(); });
    });
    testing::Until([&] {
      bool there = false;
      harness_.node().RunOnLoop([&] { there = response.has_value(); });
      return there;
    });
    return *response;
  }
  // Why the command START is refused; "": it is not.
  std::string SendStart() {
    std::unique_ptr<transport::Client<msg::SendCommand>> client;
    std::optional<std::string> reply;
    harness_.node().RunOnLoop([&] {
      client = transport::MakeClient<msg::SendCommand>(harness_.node().node(), "show/send_command")
                   .value();
      client->Call({kStartCommand}, std::chrono::seconds(120),
                   [&](const auto& r) { reply = r.value().message; });
    });
    testing::Until([&] {
      bool there = false;
      harness_.node().RunOnLoop([&] { there = reply.has_value(); });
      return there;
    });
    harness_.node().RunOnLoop([&] { client.reset(); });
    return *reply;
  }
  std::size_t Said() {
    std::size_t count = 0;
    harness_.node().RunOnLoop([&] { count = said_.size(); });
    return count;
  }
  std::string StateOf(const std::string& program) {
    for (const msg::ProgramInfo& each : Do(Op::kList).programs) {
      if (each.program == program)
        return each.state + (each.message.empty() ? "" : ": " + each.message);
    }
    return "none";
  }
  void AwaitState(const std::string& program, const std::string& state) {
    ASSERT_TRUE(testing::Until([&] {
      if (StateOf(program) == state) return true;
      harness_.Tick(engine_, 1);
      return false;
    })) << StateOf(program);
  }

  testing::Harness harness_;
  const TempFolder folder_;
  const std::shared_ptr<testing::SuspendedThread> thread_ =
      std::make_shared<testing::SuspendedThread>();
  ActuatorRunner<Peeked> engine_{"show", VpConfig{.folder = folder_ / "programs"}};
  std::unique_ptr<transport::Client<Op>> client_;
  std::unique_ptr<transport::Server<msg::AudioTextPlay>> audio_;
  std::vector<std::string> said_;
};

TEST_F(AnEngine, AddsRunsAndStopsPrograms) {
  Activate();
  ASSERT_TRUE(Do(Op::kAdd, "greet", Sequence("<Say text=\"{sentence}\"/>")).success);
  ASSERT_TRUE(Do(Op::kAdd, "wait", Sequence("<WaitSeconds seconds=\"100\"/>")).success);
  EXPECT_THAT(Do(Op::kGet, "greet").text, HasSubstr("{sentence}"));
  ASSERT_TRUE(Do(Op::kRun, "greet", "", {{"sentence", "Hello"}}).success);
  AwaitState("greet", "succeeded");
  ASSERT_TRUE(Do(Op::kRun, "greet", "", {{"sentence", "broken"}}).success);
  AwaitState("greet", "failed: its tree ended with FAILURE");
  ASSERT_TRUE(Do(Op::kRun, "greet").success);
  harness_.Tick(engine_, 2);
  EXPECT_THAT(StateOf("greet"),
              HasSubstr("failed: greet.xml:4:1: P/Sequence/Say: port 'text': the blackboard"));
  ASSERT_TRUE(Do(Op::kRun, "wait").success);
  EXPECT_EQ(StateOf("wait"), "running");
  EXPECT_FALSE(Do(Op::kStop, "greet").success);
  EXPECT_TRUE(Do(Op::kStop, "wait").success);
  EXPECT_EQ(StateOf("wait"), "stopped: stopped on request");
  EXPECT_FALSE(Do(Op::kStop).success);
  ASSERT_TRUE(Do(Op::kDelete, "wait").success);
  EXPECT_EQ(StateOf("wait"), "none");
  EXPECT_FALSE(Do(9).success);
}

TEST_F(AnEngine, RefusesAWrongProgramWithAllItsErrors) {
  const auto refused = Do(Op::kAdd, "bad", Sequence("<Sya text=\"a\"/>\n<Say txt=\"a\"/>"));
  EXPECT_FALSE(refused.success);
  EXPECT_THAT(refused.message, HasSubstr("bad.xml:4:"));
  EXPECT_THAT(refused.message, HasSubstr("did you mean 'Say'?"));
  EXPECT_THAT(refused.message, HasSubstr("\nbad.xml:5:"));
  const auto other =
      Do(Op::kAdd, "other", "<root BTCPP_format=\"4\"><include path=\"/etc/passwd\"/></root>");
  EXPECT_THAT(other.message, HasSubstr("a program is one file"));
  EXPECT_EQ(Do(Op::kList).programs.size(), 0U);
}

TEST_F(AnEngine, AnswersWhileAProgramOf20000NodesIsAdded) {
  std::string says;
  for (int i = 0; i < 20'000; ++i) says += "<Say text=\"a\"/>\n";
  std::vector<std::string> replies;
  const auto call = [&](std::uint8_t operation, const std::string& name, const std::string& text) {
    Op::Request request;
    request.operation = operation;
    request.program = name;
    request.text = text;
    client_->Call(request, std::chrono::seconds(120), [&replies, operation](const auto& reply) {
      replies.push_back(operation == Op::kAdd ? "added " + reply.value().message : "listed");
    });
  };
  const std::string program = Sequence(says);
  harness_.node().RunOnLoop([&] {
    call(Op::kAdd, "long", program);
    call(Op::kList, "", "");
  });
  ASSERT_TRUE(testing::Until([&] {
    std::size_t count = 0;
    harness_.node().RunOnLoop([&] { count = replies.size(); });
    return count == 2;
  }));
  EXPECT_THAT(replies, ::testing::ElementsAre("listed", "added "));
  EXPECT_EQ(StateOf("long"), "ready");
}

TEST_F(AnEngine, RunsProgramsInActiveOnlyAndStopsThemInEveryOtherState) {
  ASSERT_TRUE(Do(Op::kAdd, "wait", Sequence("<WaitSeconds seconds=\"100\"/>")).success);
  EXPECT_THAT(Do(Op::kRun, "wait").message, HasSubstr("runs programs in Active only"));
  Activate();
  ASSERT_TRUE(Do(Op::kRun, "wait").success);
  harness_.Tick(engine_, 2);
  ASSERT_TRUE(Go("Protected"));
  EXPECT_EQ(StateOf("wait"), "stopped: the robot left Active");
  ASSERT_TRUE(Go("Active"));
  harness_.Tick(engine_, 2);
  EXPECT_EQ(StateOf("wait"), "stopped: the robot left Active") << "it does not go on by itself";
  ASSERT_TRUE(Do(Op::kRun, "wait").success);
  EXPECT_EQ(StateOf("wait"), "running");
}

// A program drove on when the robot's computer was opened an hour later.
TEST_F(AnEngine, StopsItsProgramAfterALongSuspensionAndSaysWhy) {
  Activate();
  const std::string wait_and_greet = "<WaitSeconds seconds=\"0.2\"/>\n<Say text=\"Hello\"/>";
  ASSERT_TRUE(Do(Op::kAdd, "greet", Sequence(wait_and_greet)).success);
  ASSERT_TRUE(Do(Op::kRun, "greet").success);
  harness_.Tick(engine_, 2);
  thread_->Suspend(std::chrono::seconds(50));
  harness_.Tick(engine_, 1);
  EXPECT_EQ(StateOf("greet"), "running") << "less than a minute";
  thread_->Suspend(std::chrono::minutes(2));
  harness_.Tick(engine_, 20);
  const std::string stopped = "stopped: its process could not run for more than a minute";
  EXPECT_EQ(StateOf("greet"), stopped);
  ASSERT_TRUE(Go("Protected"));
  ASSERT_TRUE(Go("Active"));
  harness_.Tick(engine_, 20);
  EXPECT_EQ(StateOf("greet"), stopped) << "it does not go on by itself";
  EXPECT_EQ(Said(), 0U);
}

// A program that was requested from a tablet, in vain, began when the computer was opened.
TEST_F(AnEngine, BeginsNoProgramByARequestThatWaitedWhileItsComputerWasSuspended) {
  Activate();
  ASSERT_TRUE(Do(Op::kAdd, "wait", Sequence("<WaitSeconds seconds=\"100\"/>")).success);
  thread_->SuspendEachTime(std::chrono::seconds(9));
  const Op::Response late = Do(Op::kRun, "wait");
  EXPECT_FALSE(late.success);
  EXPECT_THAT(late.message, HasRefusal(ApplicationRefusal::kMayBeLate));
  EXPECT_EQ(StateOf("wait"), "ready");
  thread_->SuspendEachTime({});
  ASSERT_TRUE(testing::Until([&] { return Do(Op::kRun, "wait").success; })) << "it is a new one";
  thread_->SuspendEachTime(std::chrono::seconds(9));
  EXPECT_TRUE(Do(Op::kStop, "wait").success) << "however late";
  thread_->SuspendEachTime({});
}

TEST_F(AnEngine, RefusesStartSoThatNoProgramRunsThatItsTableDoesNotShow) {
  Activate();
  ASSERT_TRUE(Do(Op::kAdd, "greet", Sequence("<Say text=\"Hello\"/>")).success);
  ASSERT_TRUE(Do(Op::kRun, "greet").success);
  AwaitState("greet", "succeeded");
  EXPECT_EQ(SendStart(), "a program is run by show/manage_program");
  harness_.Tick(engine_, 5);
  EXPECT_EQ(Said(), 1U);
  EXPECT_EQ(StateOf("greet"), "succeeded");
}

TEST_F(AnEngine, BeginsNothingAtTheNextActiveAlsoWhereItsTreeRanWithoutAProgram) {
  Activate();
  ASSERT_TRUE(Do(Op::kAdd, "greet", Sequence("<Say text=\"Hello\"/>")).success);
  ASSERT_TRUE(Do(Op::kRun, "greet").success);
  AwaitState("greet", "succeeded");
  engine_.RunOnLoop([&] { engine_.Restart(); });
  ASSERT_TRUE(Go("Protected"));
  ASSERT_TRUE(Go("Active"));
  harness_.Tick(engine_, 5);
  EXPECT_EQ(Said(), 1U);
}

TEST_F(AnEngine, StandsInActiveAfterItsStartWhateverProgramsThereAre) {
  ASSERT_TRUE(Do(Op::kAdd, "greet", Sequence("<Say text=\"Hello\"/>")).success);
  Activate();
  harness_.Tick(engine_, 5);
  EXPECT_EQ(StateOf("greet"), "ready");
  EXPECT_TRUE(said_.empty());
}

}  // namespace musher::vp_engine::engine_test
