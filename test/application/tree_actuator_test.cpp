// A behaviour tree as an actuator: when it is ticked, halted and reported, and what its exceptions
// lead to.

#include "musher/base/files.hpp"
#include "musher/behavior/tree/recording.hpp"
#include "musher/messages/musher_msgs/behavior.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/messages/musher_msgs/tree.hpp"
#include "musher/test/application/suspended_thread.hpp"
#include "musher/test/application/tree_course.hpp"
#include "musher/test/support/refusals.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::tree_actuator_test {

using ::testing::Contains;
using testing::Course;
using ::testing::Each;
using ::testing::ElementsAre;
using testing::HasRefusal;
using ::testing::HasSubstr;
using ::testing::Not;
using tree::Status;

class ATreeActuator : public ::testing::Test {
 protected:
  bool Go(const State& state) { return harness_.controller().Switch(state).done(); }
  void Begin(ActuatorRunner<Course>& course,
             std::shared_ptr<transport::NodeThread> node = nullptr) {
    harness_.Open(course, std::move(node));
    ASSERT_TRUE(Go("SelfCheck"));
    ASSERT_TRUE(Go("Active"));
  }
  void Await(const std::function<bool()>& there) {
    ASSERT_TRUE(testing::Until([&] {
      bool done = false;
      harness_.node().RunOnLoop([&] { done = there(); });
      return done;
    }));
  }
  // Why a command is refused; "": it is not.
  std::string Send(const std::string& command) {
    std::unique_ptr<transport::Client<msg::SendCommand>> client;
    std::optional<std::string> reply;
    harness_.node().RunOnLoop([&] {
      client = transport::MakeClient<msg::SendCommand>(harness_.node().node(), "show/send_command")
                   .value();
      client->Call({command}, std::chrono::seconds(120),
                   [&](const auto& r) { reply = r.value().message; });
    });
    Await([&] { return reply.has_value(); });
    harness_.node().RunOnLoop([&] { client.reset(); });
    return *reply;
  }
  // The reply of get_tree.
  msg::GetTree::Response Get(const msg::GetTree::Request& request) {
    std::unique_ptr<transport::Client<msg::GetTree>> client;
    std::optional<msg::GetTree::Response> reply;
    harness_.node().RunOnLoop([&] {
      client = transport::MakeClient<msg::GetTree>(harness_.node().node(), "show/get_tree").value();
      client->Call(request, std::chrono::seconds(120), [&](const auto& r) { reply = r.value(); });
    });
    Await([&] { return reply.has_value(); });
    harness_.node().RunOnLoop([&] { client.reset(); });
    return *reply;
  }

  testing::Harness harness_;
};

TEST_F(ATreeActuator, TicksItsTreeAtItsRateOfTheWorldsTimeWhileItIsActiveAndThenRests) {
  ActuatorRunner<Course> course({.rate_hz = 50, .begin = Begin::kAtActive});
  harness_.Open(course);
  harness_.Tick(course, 3);
  EXPECT_THAT(course.TakeTicks(), ElementsAre()) << "not before";
  ASSERT_TRUE(Go("SelfCheck"));
  ASSERT_TRUE(Go("Active"));
  harness_.Tick(course, 6);
  EXPECT_THAT(course.TakeTicks(), ElementsAre(Status::kRunning, Status::kRunning, Status::kRunning,
                                              Status::kSuccess, Status::kIdle, Status::kIdle));
  EXPECT_EQ(course.Result(), Status::kSuccess);
  EXPECT_THAT(course.TakeLog(), ElementsAre("resumes", "first starts", "second starts"));
  course.RunOnLoop([&] { course.Restart(); });
  harness_.Tick(course, 1);
  EXPECT_THAT(course.TakeLog(), ElementsAre("first starts"));
}

// A match drove on by itself when the computer was opened an hour later.
TEST_F(ATreeActuator, RestsAfterALongSuspensionUntilACommand) {
  const auto thread = std::make_shared<testing::SuspendedThread>();
  ActuatorRunner<Course> course({.rate_hz = 50, .begin = Begin::kOnCommand});
  Begin(course, thread);
  course.RunOnLoop([&] { course.Restart(); });
  harness_.Tick(course, 1);
  thread->Suspend(std::chrono::seconds(50));
  harness_.Tick(course, 1);
  EXPECT_THAT(course.TakeTicks(), ElementsAre(Status::kRunning, Status::kRunning));
  course.TakeLog();
  thread->Suspend(std::chrono::minutes(2));
  harness_.Tick(course, 1);
  EXPECT_THAT(course.TakeTicks(), ElementsAre(Status::kIdle));
  EXPECT_THAT(course.TakeLog(), ElementsAre("first halted", "pauses"));
  ASSERT_TRUE(Go("LowPower"));
  ASSERT_TRUE(Go("Active"));
  harness_.Tick(course, 1);
  EXPECT_EQ(course.Result(), Status::kIdle) << "a pause is no command";
}

TEST_F(ATreeActuator, RestsAfterALongSuspensionInAPause) {
  const auto thread = std::make_shared<testing::SuspendedThread>();
  ActuatorRunner<Course> course({.rate_hz = 50, .begin = Begin::kOnCommand});
  Begin(course, thread);
  course.RunOnLoop([&] { course.Restart(); });
  harness_.Tick(course, 1);
  ASSERT_TRUE(Go("LowPower"));
  course.TakeTicks();
  thread->Suspend(std::chrono::minutes(2));
  ASSERT_TRUE(Go("Active"));
  harness_.Tick(course, 1);
  EXPECT_THAT(course.TakeTicks(), ElementsAre(Status::kIdle));
}

TEST_F(ATreeActuator, BeginsAtItsRootAfterALongSuspensionWhereItBeginsByItself) {
  const auto thread = std::make_shared<testing::SuspendedThread>();
  ActuatorRunner<Course> course({.rate_hz = 50, .begin = Begin::kAtActive});
  Begin(course, thread);
  harness_.Tick(course, 1);
  course.TakeLog();
  thread->Suspend(std::chrono::minutes(2));
  harness_.Tick(course, 1);
  EXPECT_THAT(course.TakeLog(), ElementsAre("first halted", "pauses", "first starts"));
}

// A match was begun by a request that had waited meanwhile.
TEST_F(ATreeActuator, DoesNotBeginByAStartThatMayBeLate) {
  const auto thread = std::make_shared<testing::SuspendedThread>();
  ActuatorRunner<Course> course({.rate_hz = 50, .begin = Begin::kOnCommand});
  Begin(course, thread);
  EXPECT_TRUE(course.Of([](Course& c) { return c.CheckNotLate().ok(); }));
  thread->SuspendEachTime(std::chrono::seconds(9));
  EXPECT_FALSE(course.Of([](Course& c) { return c.CheckNotLate().ok(); }));
  EXPECT_THAT(Send(kStartCommand), HasRefusal(ApplicationRefusal::kMayBeLate));
  harness_.Tick(course, 2);
  EXPECT_THAT(course.TakeLog(), Not(Contains("first starts")));
  thread->SuspendEachTime({});
  EXPECT_TRUE(testing::Until([&] { return Send(kStartCommand).empty(); })) << "it is a new one";
  harness_.Tick(course, 2);
  EXPECT_THAT(course.TakeLog(), Contains("first starts"));
}

TEST_F(ATreeActuator, TicksAtOnceWhereANodeWakesItUp) {
  ActuatorRunner<Course> course({.rate_hz = 50, .begin = Begin::kAtActive});
  Begin(course);
  harness_.Tick(course, 1);
  EXPECT_THAT(course.TakeTicks(), ElementsAre(Status::kRunning));
  const tree::WakeUp wake_up = course.Of([](Course& c) { return c.data().wake_up; });
  course.RunOnLoop([&] { wake_up.Request(); });
  EXPECT_THAT(course.TakeTicks(), ElementsAre(Status::kRunning)) << "its time has not passed";
  course.RunOnLoop([&] {
    wake_up.Request();
    wake_up.Request();
  });
  EXPECT_THAT(course.TakeTicks(), ElementsAre(Status::kRunning)) << "once for both";
  ASSERT_TRUE(Go("LowPower"));
  course.TakeTicks();
  course.RunOnLoop([&] { wake_up.Request(); });
  EXPECT_THAT(course.TakeTicks(), ElementsAre()) << "it is paused";
  ASSERT_TRUE(Go("Active"));
  ASSERT_TRUE(
      course.LoadText("<root BTCPP_format=\"4\"><BehaviorTree ID=\"New\">"
                      "<Walk ticks=\"9\"/></BehaviorTree></root>"));
  harness_.Tick(course, 1);
  course.TakeTicks();
  course.RunOnLoop([&] { wake_up.Request(); });
  EXPECT_THAT(course.TakeTicks(), ElementsAre()) << "its tree is gone";
  const tree::WakeUp next = course.Of([](Course& c) { return c.data().wake_up; });
  course.RunOnLoop([&] { next.Request(); });
  EXPECT_THAT(course.TakeTicks(), ElementsAre(Status::kRunning));
}

// Keeps the thread on which its tree was built first.
class BuiltCourse : public Course {
 public:
  using Course::Course;
  bool WasBuiltOnLoop() {
    return Of([this](Course&) { return built_on_ == std::this_thread::get_id(); });
  }

  bool throws = false;  // before Start()

 private:
  musher::Result<> FillBlackboard(tree::Board& board) override {
    built_on_ = std::this_thread::get_id();
    if (throws) throw std::runtime_error("no map");
    return board.Set("ticks", 3);
  }

  std::thread::id built_on_;
};

TEST_F(ATreeActuator, BuildsItsTreeOnTheLoopWhereOthersMayShareTheBoardAroundIt) {
  ActuatorRunner<BuiltCourse> course(
      {.rate_hz = 50, .outer_board = std::make_shared<tree::Board>()});
  harness_.Open(course);
  EXPECT_TRUE(course.WasBuiltOnLoop());
}

TEST_F(ATreeActuator, IsNotSetUpWhereTheBuildOnTheLoopThrows) {
  ActuatorRunner<BuiltCourse> course(
      {.rate_hz = 50, .outer_board = std::make_shared<tree::Board>()});
  course.throws = true;
  ASSERT_TRUE(course.Init(harness_.path()));
  const musher::Result<> started = course.Start();
  ASSERT_FALSE(started);
  EXPECT_THAT(started.error().message, HasSubstr("no map"));
}

TEST_F(ATreeActuator, BuildsItsTreeOnItsWorkerWithoutABoardAroundIt) {
  ActuatorRunner<BuiltCourse> course({.rate_hz = 50});
  harness_.Open(course);
  EXPECT_FALSE(course.WasBuiltOnLoop());
}

TEST_F(ATreeActuator, KeepsTheBoardAroundItsTreesWhenAnotherOneIsLoaded) {
  const auto outer = std::make_shared<tree::Board>();
  ActuatorRunner<Course> course({.rate_hz = 50, .outer_board = outer});
  Begin(course);
  const auto load = [&course](const std::string& code) {
    return course.LoadText("<root BTCPP_format=\"4\"><BehaviorTree ID=\"New\"><Script code=\"" +
                           code + "\"/></BehaviorTree></root>");
  };
  ASSERT_TRUE(load("@mission := 'fetch'; own := 1"));
  harness_.Tick(course, 1);
  ASSERT_TRUE(load("seen := @mission .. '!'"));
  harness_.Tick(course, 1);
  const auto seen =
      course.Of([](Course& c) { return c.tree().board().Get<std::string>("seen").value(); });
  EXPECT_EQ(seen, "fetch!");
  EXPECT_FALSE(course.Of([](Course& c) { return c.tree().board().Get<int>("own").ok(); }));
  msg::GetTree::Request request;
  request.entries = true;
  std::vector<std::string> keys;
  for (const auto& entry : Get(request).entries) keys.push_back(entry.key);
  EXPECT_THAT(keys, ::testing::ElementsAre("@mission", "seen", "ticks"));
}

TEST_F(ATreeActuator, StandsInActiveUntilItIsCommanded) {
  ActuatorRunner<Course> course({.rate_hz = 50});
  Begin(course);
  harness_.Tick(course, 5);
  EXPECT_THAT(course.TakeLog(), ElementsAre("resumes")) << "its controller has brought it there";
  EXPECT_EQ(Send("GO"), Refused<ApplicationRefusal::kUnknownCommand>("GO", "START").message);
  ASSERT_TRUE(Go("LowPower"));
  EXPECT_EQ(Send("START"),
            Refused<ApplicationRefusal::kBeginsInActive>("show", "LowPower").message);
  ASSERT_TRUE(Go("Active"));
  harness_.Tick(course, 2);
  course.TakeLog();
  EXPECT_EQ(Send("START"), "");
  harness_.Tick(course, 1);
  EXPECT_THAT(course.TakeLog(), ElementsAre("first starts"));
  ASSERT_TRUE(Go("LowPower"));
  ASSERT_TRUE(Go("Active"));
  course.TakeLog();
  harness_.Tick(course, 1);
  EXPECT_THAT(course.TakeLog(), ElementsAre("first starts")) << "a pause is no restart";
}

// It was halted in the middle of its work, and began at its root.
TEST_F(ATreeActuator, IsNotSentBackToItsRootByASecondStart) {
  ActuatorRunner<Course> course({.rate_hz = 50});
  Begin(course);
  EXPECT_EQ(Send("START"), "");
  harness_.Tick(course, 1);
  course.TakeLog();
  EXPECT_EQ(Send("START"), Refused<ApplicationRefusal::kUnderWay>("show").message);
  harness_.Tick(course, 1);
  EXPECT_THAT(course.TakeLog(), ElementsAre());
  harness_.Tick(course, 5);
  ASSERT_EQ(course.Result(), Status::kSuccess);
  course.TakeLog();
  EXPECT_EQ(Send("START"), "") << "it has ended";
  harness_.Tick(course, 1);
  EXPECT_THAT(course.TakeLog(), ElementsAre("first starts"));
}

TEST_F(ATreeActuator, BeginsAgainAtOnceWithThatOption) {
  ActuatorRunner<Course> course(
      {.rate_hz = 50, .begin = Begin::kAtActive, .restart_after_end = true});
  Begin(course);
  harness_.Tick(course, 5);
  EXPECT_THAT(course.TakeLog(),
              ElementsAre("resumes", "first starts", "second starts", "first starts"));
}

TEST_F(ATreeActuator, IsHaltedOnceInEveryOtherStateAndBeginsAtItsRootWithItsBlackboard) {
  ActuatorRunner<Course> course;
  Begin(course);
  course.RunOnLoop([&] { EXPECT_TRUE(course.tree().board().Set("ticks", 50)); });
  for (const BuiltInState state : {kProtected, kDeActive, kLowPower, kOta}) {
    harness_.Tick(course, 2);
    course.TakeLog();
    ASSERT_TRUE(Go(state)) << state;
    EXPECT_THAT(course.TakeLog(), ElementsAre("first halted", "pauses")) << state;
    course.TakeTicks();
    harness_.Advance(course, std::chrono::hours(1));
    EXPECT_THAT(course.TakeTicks(), ElementsAre()) << state;
    ASSERT_TRUE(Go("Active"));
    harness_.Tick(course, 1);
    EXPECT_THAT(course.TakeLog(), ElementsAre("resumes", "first starts")) << state;
    EXPECT_EQ(course.Of([](Course& c) { return c.tree().board().Get<int>("ticks").value(); }), 50);
  }
  EXPECT_LT(Get({}).state.time_s, 1) << "without the hours of the pauses";
}

TEST_F(ATreeActuator, HasANewBlackboardAtEachActiveWithThatOption) {
  ActuatorRunner<Course> course(
      {.rate_hz = 50, .begin = Begin::kAtActive, .resume = TreeActuator::Resume::kNewBlackboard});
  Begin(course);
  course.RunOnLoop([&] { EXPECT_TRUE(course.tree().board().Set("ticks", 50)); });
  ASSERT_TRUE(Go("LowPower"));
  ASSERT_TRUE(Go("Active"));
  EXPECT_EQ(course.Of([](Course& c) { return c.tree().board().Get<int>("ticks").value(); }), 3);
}

TEST_F(ATreeActuator, RestsAfterItsEndAlsoOverAPause) {
  ActuatorRunner<Course> course;
  Begin(course);
  harness_.Tick(course, 5);
  ASSERT_TRUE(Go("LowPower"));
  ASSERT_TRUE(Go("Active"));
  course.TakeLog();
  harness_.Tick(course, 3);
  EXPECT_THAT(course.TakeLog(), ElementsAre());
  EXPECT_EQ(course.Result(), Status::kSuccess);
}

TEST_F(ATreeActuator, IsHaltedByAnEmergencyStopUntilActiveIsSetAgainAfterTheRelease) {
  ActuatorRunner<Course> course;
  Begin(course);
  harness_.Tick(course, 2);
  harness_.PressEmergencyStop();
  Await([&] { return !course.Of([](Course& c) { return c.ticking(); }); });
  EXPECT_THAT(course.TakeLog(), ElementsAre("resumes", "first starts", "first halted", "pauses"));
  harness_.Tick(course, 2);
  EXPECT_THAT(course.TakeLog(), ElementsAre());
}

TEST_F(ATreeActuator, DoesNotConfirmAnEmergencyStopAtWhichANodeHasThrownInItsHalt) {
  ActuatorRunner<Course> course;
  course.data().throws["first halted"] = "the leg is stuck";
  Begin(course);
  harness_.Tick(course, 2);
  harness_.PressEmergencyStop();
  EXPECT_TRUE(harness_.AwaitStop("the leg is stuck"));
  EXPECT_EQ(course.Result(), Status::kFailure);
}

TEST_F(ATreeActuator, DoesNotConfirmAnEmergencyStopAfterAPauseInWhichANodeHasThrown) {
  ActuatorRunner<Course> course;
  course.data().throws["first halted"] = "the leg is stuck";
  Begin(course);
  harness_.Tick(course, 2);
  static_cast<void>(Go("LowPower"));
  harness_.PressEmergencyStop();
  EXPECT_TRUE(harness_.AwaitStop("the leg is stuck"));
}

TEST_F(ATreeActuator, RestsAtTheNextActiveWhereANodeHasThrownInTheHaltOfThePause) {
  ActuatorRunner<Course> course;
  course.data().throws["first halted"] = "the leg is stuck";
  Begin(course);
  harness_.Tick(course, 2);
  static_cast<void>(Go("LowPower"));
  course.RunOnLoop([&] { course.data().throws.clear(); });
  static_cast<void>(Go("Active"));
  course.TakeLog();
  harness_.Tick(course, 2);
  EXPECT_THAT(course.TakeLog(), ElementsAre()) << "what moves below it is not known";
  EXPECT_EQ(Send("START"), "");
  harness_.Tick(course, 2);
  EXPECT_THAT(course.TakeLog(), ElementsAre("first starts"));
}

TEST_F(ATreeActuator, EndsWithFailureWhenANodeOrAHookThrowsAndGoesOnAfterRestart) {
  for (const std::string at : {"second starts", "before", "after"}) {
    testing::Harness harness;
    ActuatorRunner<Course> course;
    course.data().throws[at] = "the leg is stuck";
    harness.Open(course);
    ASSERT_TRUE(harness.controller().Switch("SelfCheck").done());
    ASSERT_TRUE(harness.controller().Switch("Active").done());
    harness.Tick(course, 4);
    EXPECT_EQ(course.Result(), Status::kFailure) << at;
    EXPECT_THAT(course.Of([](Course& c) { return c.last_fault(); }),
                HasSubstr(at == "second starts" ? "Course/Sequence/second: the leg is stuck"
                                                : "the leg is stuck"));
    EXPECT_THAT(course.TakeTicks(),
                at == "after" ? Contains(Status::kRunning) : Contains(Status::kFailure));
    course.RunOnLoop([&] {
      course.data().throws.clear();
      course.Restart();
    });
    harness.Tick(course, 4);
    EXPECT_EQ(course.Result(), Status::kSuccess) << at;
    EXPECT_EQ(course.Of([](Course& c) { return c.last_fault(); }), "");
  }
}

TEST_F(ATreeActuator, ShowsAFaultOfItsTreeInTheStatusUntilItBeginsAgain) {
  ActuatorRunner<Course> course;
  course.data().throws["second starts"] = "the leg is stuck";
  Begin(course);
  harness_.Tick(course, 4);
  ASSERT_EQ(course.Result(), Status::kFailure);
  EXPECT_THAT(harness_.controller().Switch("LowPower").degraded, ElementsAre("show"));
  EXPECT_THAT(harness_.controller().Switch("Active").degraded, ElementsAre("show"));
  course.RunOnLoop([&] {
    course.data().throws.clear();
    course.Restart();
  });
  EXPECT_THAT(harness_.controller().Switch("LowPower").degraded, ElementsAre());
}

TEST_F(ATreeActuator, LoadsAnotherTreeWhileItRunsAndHaltsTheOldOneFirst) {
  ActuatorRunner<Course> course;
  Begin(course);
  harness_.Tick(course, 2);
  const std::string other = R"(<root BTCPP_format="4"><BehaviorTree ID="Other">
    <Walk name="third" ticks="{steps}"/></BehaviorTree></root>)";
  course.TakeLog();
  const auto revision = Get({}).state.revision;
  ASSERT_TRUE(course.LoadText(other, {{"steps", "4"}}));
  EXPECT_THAT(course.TakeLog(), ElementsAre("first halted"));
  course.TakeTicks();
  harness_.Tick(course, 4);
  EXPECT_THAT(course.TakeTicks(),
              ElementsAre(Status::kRunning, Status::kRunning, Status::kRunning, Status::kSuccess));
  EXPECT_THAT(course.TakeLog(), ElementsAre("third starts"));
  EXPECT_GT(Get({}).state.revision, revision);
}

TEST_F(ATreeActuator, KeepsItsTreeWhereAnotherOneIsWrong) {
  ActuatorRunner<Course> course;
  Begin(course);
  harness_.Tick(course, 2);
  const auto wrong = course.LoadText(
      "<root BTCPP_format=\"4\"><BehaviorTree ID=\"A\"><Sequence>\n<Wlak/>\n<Walk tics=\"1\"/>\n"
      "</Sequence></BehaviorTree></root>");
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().message, HasSubstr("new.xml:2:"));
  EXPECT_THAT(wrong.error().message, HasSubstr("\nnew.xml:3:")) << "all of them";
  const auto entry = course.LoadText(testing::kCourse, {{"ticks", "some"}, {"tick", "1"}});
  ASSERT_FALSE(entry);
  EXPECT_THAT(entry.error().message, HasSubstr("entry 'ticks': "));
  EXPECT_THAT(entry.error().message, HasSubstr("entry 'tick': no node has a port with this key"));
  harness_.Tick(course, 2);
  EXPECT_EQ(course.Result(), Status::kSuccess);
}

TEST_F(ATreeActuator, DoesWhatANodeRequestsAfterTheTick) {
  ActuatorRunner<Course> course;
  course.data().does["second starts"] = [&] {
    const Result<> loaded = course.Load(tree::ReadTree(testing::kCourse, "x.xml").document);
    ASSERT_FALSE(loaded) << "not within the tick";
    EXPECT_THAT(loaded.error(), testing::IsRefused(ApplicationRefusal::kInsideOwnTree));
    course.Restart();
  };
  Begin(course);
  harness_.Tick(course, 4);
  EXPECT_THAT(course.TakeLog(), ElementsAre("resumes", "first starts", "second starts",
                                            "second halted", "first starts"));
  course.RunOnLoop([&] { course.Halt(); });
  harness_.Tick(course, 2);
  EXPECT_THAT(course.TakeLog(), ElementsAre("first halted"));
}

TEST_F(ATreeActuator, RestsAtTheNextActiveWhereANodeThatIsHaltedByThePauseHaltsIt) {
  ActuatorRunner<Course> course;
  course.data().does["first halted"] = [&] { course.Halt(); };
  Begin(course);
  harness_.Tick(course, 2);
  ASSERT_TRUE(Go("LowPower"));
  ASSERT_TRUE(Go("Active"));
  course.TakeLog();
  harness_.Tick(course, 2);
  EXPECT_THAT(course.TakeLog(), ElementsAre()) << "not one tick";
  EXPECT_EQ(course.Result(), Status::kIdle);
}

TEST_F(ATreeActuator, RestsWhereANodeThatIsHaltedByARestartHaltsIt) {
  ActuatorRunner<Course> course;
  course.data().does["first halted"] = [&] { course.Halt(); };
  Begin(course);
  harness_.Tick(course, 2);
  course.RunOnLoop([&] { course.Restart(); });
  course.TakeLog();
  harness_.Tick(course, 2);
  EXPECT_THAT(course.TakeLog(), ElementsAre());
}

TEST_F(ATreeActuator, RestsWithAnotherTreeWhereANodeOfTheOldOneHaltsIt) {
  ActuatorRunner<Course> course;
  course.data().does["first halted"] = [&] { course.Halt(); };
  Begin(course);
  harness_.Tick(course, 2);
  ASSERT_TRUE(course.LoadText(testing::kCourse));
  course.TakeLog();
  harness_.Tick(course, 2);
  EXPECT_THAT(course.TakeLog(), ElementsAre());
}

TEST_F(ATreeActuator, StaysHaltedWhereANodeThatIsHaltedRestartsIt) {
  ActuatorRunner<Course> course;
  course.data().does["first halted"] = [&] { course.Restart(); };
  Begin(course);
  harness_.Tick(course, 2);
  course.RunOnLoop([&] { course.Halt(); });
  course.TakeLog();
  harness_.Tick(course, 1);
  EXPECT_THAT(course.TakeLog(), ElementsAre());
  EXPECT_EQ(Send("START"), "");
  harness_.Tick(course, 2);
  EXPECT_THAT(course.TakeLog(), ElementsAre("first starts")) << "once: no restart is left over";
}

TEST_F(ATreeActuator, DoesNotBeginAgainWhereANodeThatIsHaltedForThatThrows) {
  ActuatorRunner<Course> course;
  course.data().throws["first halted"] = "the leg is stuck";
  Begin(course);
  harness_.Tick(course, 2);
  course.RunOnLoop([&] { course.Restart(); });
  EXPECT_THAT(course.Of([](Course& c) { return c.last_fault(); }),
              HasSubstr("Course/Sequence/first: the leg is stuck"));
  course.TakeLog();
  harness_.Tick(course, 2);
  EXPECT_THAT(course.TakeLog(), ElementsAre()) << "what moves below it is not known";
  EXPECT_EQ(course.Result(), Status::kFailure);
  EXPECT_THAT(course.Of([](Course& c) { return c.last_fault(); }), HasSubstr("the leg is stuck"));
  EXPECT_EQ(Send("START"), "") << "nothing is left to halt";
  harness_.Tick(course, 2);
  EXPECT_THAT(course.TakeLog(), ElementsAre("first starts"));
  EXPECT_EQ(course.Of([](Course& c) { return c.last_fault(); }), "");

  const auto loaded = course.LoadText(testing::kCourse, {{"ticks", "7"}});
  ASSERT_FALSE(loaded);
  EXPECT_THAT(loaded.error().message, HasSubstr("the leg is stuck"));
  course.TakeLog();
  harness_.Tick(course, 2);
  EXPECT_THAT(course.TakeLog(), ElementsAre());
  EXPECT_EQ(course.Of([](Course& c) { return c.tree().board().Get<int>("ticks").value(); }), 3)
      << "the old one is kept";
  EXPECT_TRUE(course.LoadText(testing::kCourse, {{"ticks", "7"}}));
  harness_.Tick(course, 1);
  EXPECT_THAT(course.TakeLog(), ElementsAre("first starts"));
}

TEST_F(ATreeActuator, IsDegradedWhereItsPauseThrowsUntilAPauseSucceeds) {
  ActuatorRunner<Course> course;
  course.data().throws["pauses"] = "the motors do not reply";
  Begin(course);
  static_cast<void>(harness_.controller().Switch("LowPower"));
  EXPECT_THAT(harness_.controller().Switch("Active").degraded, ElementsAre("show"));
  course.RunOnLoop([&] { course.data().throws.clear(); });
  static_cast<void>(harness_.controller().Switch("LowPower"));
  EXPECT_THAT(harness_.controller().Switch("Active").degraded, ElementsAre());
}

TEST_F(ATreeActuator, StaysHaltedAtTheNextActiveAlsoWithANewBlackboard) {
  ActuatorRunner<Course> course(
      {.rate_hz = 50, .begin = Begin::kAtActive, .resume = TreeActuator::Resume::kNewBlackboard});
  Begin(course);
  harness_.Tick(course, 2);
  course.RunOnLoop([&] { course.Halt(); });
  ASSERT_TRUE(Go("LowPower"));
  ASSERT_TRUE(Go("Active"));
  course.TakeLog();
  harness_.Tick(course, 2);
  EXPECT_THAT(course.TakeLog(), ElementsAre());
  EXPECT_EQ(Send("START"), "");
  harness_.Tick(course, 1);
  EXPECT_THAT(course.TakeLog(), ElementsAre("first starts"));
  ASSERT_TRUE(Go("LowPower"));
  ASSERT_TRUE(Go("Active"));
  course.TakeLog();
  harness_.Tick(course, 1);
  EXPECT_THAT(course.TakeLog(), ElementsAre("first starts")) << "START has ended the halt";
}

TEST_F(ATreeActuator, RestsAfterAFaultAlsoWithANewBlackboardAndShowsItUntilStart) {
  ActuatorRunner<Course> course(
      {.rate_hz = 50, .begin = Begin::kAtActive, .resume = TreeActuator::Resume::kNewBlackboard});
  course.data().throws["first starts"] = "the leg is stuck";
  Begin(course);
  harness_.Tick(course, 2);
  ASSERT_EQ(course.Result(), Status::kFailure);
  ASSERT_TRUE(Go("LowPower"));
  ASSERT_TRUE(Go("Active"));
  course.TakeLog();
  harness_.Tick(course, 2);
  EXPECT_THAT(course.TakeLog(), ElementsAre());
  EXPECT_THAT(course.Of([](Course& c) { return c.last_fault(); }), HasSubstr("the leg is stuck"));
  course.RunOnLoop([&] { course.data().throws.clear(); });
  EXPECT_EQ(Send("START"), "");
  harness_.Tick(course, 1);
  EXPECT_THAT(course.TakeLog(), ElementsAre("first starts"));
  EXPECT_EQ(course.Of([](Course& c) { return c.last_fault(); }), "");
}

TEST_F(ATreeActuator, LeavesTheBoardAroundItsTreesAsItWasWhereAnotherTreeIsRefused) {
  const auto outer = std::make_shared<tree::Board>();
  ActuatorRunner<Course> course({.rate_hz = 50, .outer_board = outer});
  Begin(course);
  course.RunOnLoop([&] { EXPECT_TRUE(outer->Set("speed", 1)); });
  const auto refused = course.LoadText(
      "<root BTCPP_format=\"4\"><BehaviorTree ID=\"New\"><Sequence><Walk ticks=\"{@speed}\"/>"
      "<Walk ticks=\"{@steps}\"/></Sequence></BehaviorTree></root>",
      {{"@speed", "9"}, {"@steps", "2"}, {"missing", "1"}});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("entry 'missing'"));
  course.RunOnLoop([&] {
    const tree::Entry* speed = outer->Find("speed");
    EXPECT_EQ(speed->value.Shown(), "1");
    EXPECT_EQ(speed->sequence, 1U) << "nothing that watches it runs";
    const tree::Entry* steps = outer->Find("steps");
    EXPECT_TRUE(steps == nullptr || (steps->value.empty() && steps->type == nullptr));
  });
}

TEST_F(ATreeActuator, ServesItsTreeAndPublishesItsState) {
  std::vector<msg::TreeState> states;
  std::unique_ptr<transport::Subscription> topic;
  harness_.node().RunOnLoop([&] {
    topic = transport::MakeSubscription<msg::TreeState>(
                harness_.node().node(), "show/tree_state",
                [&](const msg::TreeState& state, const auto&) { states.push_back(state); },
                transport::kLatchedQos)
                .value();
  });
  ActuatorRunner<Course> course;
  Begin(course);
  Await([&] { return !states.empty() && states.back().ticking; });
  harness_.Tick(course, 5);
  Await([&] { return states.back().status[0] == msg::TreeState::kSuccess; });
  EXPECT_EQ(states.back().tree, "Course");
  EXPECT_EQ(states.back().status.size(), 3U);
  msg::GetTree::Request request;
  request.format = "xml";
  request.history = 100;
  request.entries = true;
  const auto report = Get(request);
  EXPECT_EQ(report.error, "");
  ASSERT_EQ(report.nodes.size(), 3U);
  EXPECT_EQ(report.nodes[1].name, "first");
  EXPECT_EQ(report.nodes[1].type, "Walk");
  EXPECT_EQ(report.nodes[1].parent, 0);
  EXPECT_EQ(report.nodes[1].line, 4U);
  EXPECT_EQ(report.nodes[1].runs, 1U);
  EXPECT_NEAR(report.nodes[1].spent_s, 0.04, 1e-9);
  ASSERT_EQ(report.entries.size(), 1U);
  EXPECT_EQ(report.entries[0].key, "ticks");
  EXPECT_EQ(report.entries[0].value, "3");
  EXPECT_EQ(report.history.size(), 6U);
  EXPECT_THAT(report.graph, HasSubstr("<Walk name=\"first\" ticks=\"{ticks}\"/>"));
  EXPECT_EQ(tree::ReadTree(report.graph, "g.xml").document.trees.size(), 1U);
  ASSERT_TRUE(Go("LowPower"));
  Await([&] { return !states.back().ticking; });
  harness_.node().RunOnLoop([&] { topic.reset(); });
}

TEST_F(ATreeActuator, BeginsAtItsRootWhenTheWorldWasRestarted) {
  ActuatorRunner<Course> course;
  Begin(course);
  harness_.Tick(course, 2);
  course.TakeLog();
  harness_.Advance(course, -std::chrono::seconds(500));
  harness_.Tick(course, 2);
  EXPECT_THAT(course.TakeLog(), ElementsAre("first halted", "first starts"));
  harness_.Tick(course, 4);
  EXPECT_EQ(course.Result(), Status::kSuccess);
  EXPECT_LT(Get({}).state.time_s, 1);
}

TEST_F(ATreeActuator, FailsItsSetUpWithEveryErrorOfItsTree) {
  ActuatorRunner<Course> course;
  course.text =
      "<root BTCPP_format=\"4\"><BehaviorTree ID=\"A\"><Sequence>\n<Wlak/>\n<Walk tics=\"1\"/>\n"
      "</Sequence></BehaviorTree></root>";
  ASSERT_TRUE(course.Init(harness_.path()).ok());
  const musher::Result<> started = course.Start();
  ASSERT_FALSE(started);
  EXPECT_THAT(started.error().message, HasSubstr("course.xml:2:"));
  EXPECT_THAT(started.error().message, HasSubstr("course.xml:3:"));
  ActuatorRunner<Course> none;
  none.text = "";
  ASSERT_TRUE(none.Init(harness_.path()).ok());
  EXPECT_THAT(none.Start().error().message, HasSubstr("LoadTree() is not overridden"));
}

TEST_F(ATreeActuator, RecordsItsTreesIntoItsStateFolder) {
  {
    ActuatorRunner<Course> course(
        {.rate_hz = 50, .begin = Begin::kAtActive, .record = {.file = "trees/show.tree"}});
    Begin(course);
    harness_.Tick(course, 2);
    ASSERT_TRUE(Go("LowPower"));
    ASSERT_TRUE(course.LoadText(testing::kCourse, {{"ticks", "1"}}));
    ASSERT_TRUE(Go("Active"));
    harness_.Tick(course, 2);
  }
  const std::string text = ReadFile(harness_.state_dir() + "/trees/show.tree");
  const auto read = tree::ReadRecording(text, "show.tree");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read.value().actuator, "show");
  ASSERT_EQ(read.value().trees.size(), 2U);
  tree::Playback first(read.value().trees[0]);
  while (first.Step()) {
  }
  EXPECT_EQ(first.runs(1).last, Status::kIdle) << "halted by LowPower";
  EXPECT_FALSE(first.ticking());
  tree::Playback second(read.value().trees[1]);
  while (second.Step()) {
  }
  EXPECT_EQ(second.runs(1).last, Status::kSuccess);
  EXPECT_EQ(second.runs(2).starts, 1U);
}

TEST_F(ATreeActuator, ThatCannotRecordIsNotSetUp) {
  ActuatorRunner<Course> course(
      {.rate_hz = 50, .begin = Begin::kAtActive, .record = {.file = "/proc/none/show.tree"}});
  ASSERT_TRUE(course.Init(harness_.path()));
  const Result<> started = course.Start();
  ASSERT_FALSE(started);
  EXPECT_THAT(started.error().message, HasSubstr("/proc/none/show.tree cannot be written to"));
}

}  // namespace musher::tree_actuator_test
