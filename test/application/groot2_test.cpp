// A tree is served to a client that speaks the protocol of Groot2 over ZeroMQ.

#include "musher/application/groot2/groot2_server.hpp"

#include <zmq.h>

#include <future>
#include <nlohmann/json.hpp>
#include <thread>

#include "musher/test/application/groot2_client.hpp"
#include "musher/test/application/tree_course.hpp"
#include "musher/test/behavior/tree/trees.hpp"

namespace musher::groot2_test {

using groot2::Header;
using groot2::HookJson;
using groot2::Parts;
using groot2::Receive;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr const char* kWithSubtree = R"(<root BTCPP_format="4" main_tree_to_execute="Main">
  <BehaviorTree ID="Main">
    <Sequence>
      <Walk name="first" ticks="{ticks}"/>
      <SubTree ID="Rest" name="rest" long="7"/>
    </Sequence>
  </BehaviorTree>
  <BehaviorTree ID="Rest"><Walk name="second" ticks="{long}"/></BehaviorTree>
</root>
)";

class Watched : public TreeActuator, public testing::Inspected<Watched> {
 public:
  explicit Watched(groot2::ServeOptions options)
      : TreeActuator("show", {.rate_hz = 50, .begin = Begin::kAtActive}),
        served_(std::move(options)) {}
  std::vector<std::string> TakeLog() {
    return Of([](Watched& self) { return std::exchange(self.data_.log, {}); });
  }
  std::string Status(tree::NodeId node) {
    return Of([&](Watched& self) { return std::string(tree::Name(self.tree().status(node))); });
  }
  using TreeActuator::Halt;
  using TreeActuator::Now;
  using TreeActuator::Restart;
  using TreeActuator::tree;
  using TreeActuator::view;

 private:
  Result<> RegisterNodes(tree::Factory& factory) override {
    return factory.Add<testing::Walk>("Walk", data_);
  }
  Result<tree::Document> LoadTree() override {
    return tree::ReadTree(kWithSubtree, "main.xml").document;
  }
  Result<> FillBlackboard(tree::Board& board) override { return board.Set("ticks", 3); }
  // [serve]
  void OpenTopics(transport::Endpoints& topics) override {
    const Result<> served = groot2::Serve(
        topics,
        {.port = served_.port,
         .hooks = served_.hooks,
         .silence = served_.silence,
         .on_lost = [this] { Halt(); }},
        [this] { return view(); }, factory());
    if (!served) Log(served.error());
  }
  // [serve end]

  const groot2::ServeOptions served_;
  testing::CourseData data_;
};

class AGroot2Client : public ::testing::Test {
 protected:
  explicit AGroot2Client(bool hooks = false, Duration silence = std::chrono::seconds(60))
      : watched_(groot2::ServeOptions{.port = kPort, .hooks = hooks, .silence = silence}) {
    harness_.Open(watched_);
    Connect();
  }
  ~AGroot2Client() override {
    for (void* socket : {other_, breakpoints_, socket_}) zmq_close(socket);
    zmq_ctx_term(context_);
  }
  void Connect() {
    const int linger = 0;
    const int timeout_ms = 120'000;
    for (void* socket : {socket_, breakpoints_, other_}) {
      zmq_setsockopt(socket, ZMQ_LINGER, &linger, sizeof linger);
      zmq_setsockopt(socket, ZMQ_RCVTIMEO, &timeout_ms, sizeof timeout_ms);
    }
    zmq_setsockopt(breakpoints_, ZMQ_SUBSCRIBE, "", 0);
    for (void* socket : {socket_, other_}) {
      zmq_connect(socket, ("tcp://127.0.0.1:" + std::to_string(kPort)).c_str());
    }
    zmq_connect(breakpoints_, ("tcp://127.0.0.1:" + std::to_string(kPort + 1)).c_str());
  }
  Parts Ask(const Parts& request) { return Ask(socket_, request); }
  static Parts Ask(void* socket, const Parts& request) { return groot2::Ask(socket, request); }
  // Of each node, in the order of its id: what follows its uid.
  std::vector<int> Statuses() {
    const Parts reply = Ask({Header('S')});
    EXPECT_EQ(reply.size(), 2U);
    std::vector<int> statuses;
    for (std::size_t at = 0; at + 2 < reply.at(1).size(); at += 3) {
      EXPECT_EQ(static_cast<std::size_t>(reply[1][at]), at / 3 + 1);
      statuses.push_back(reply[1][at + 2]);
    }
    return statuses;
  }

  // Of the domain, so that several runs do not meet.
  const int kPort = 21'000 + 2 * transport::TestDomain();
  testing::Harness harness_;
  ActuatorRunner<Watched> watched_;
  void* context_ = zmq_ctx_new();
  void* socket_ = zmq_socket(context_, ZMQ_REQ);
  void* breakpoints_ = zmq_socket(context_, ZMQ_SUB);
  void* other_ = zmq_socket(context_, ZMQ_REQ);  // of another client
};

constexpr int kFirstUid = 2;  // of the node `first`

std::string ReleaseJson(int uid, const std::string& status, bool remove, int position = 0) {
  return nlohmann::json{{"uid", uid},
                        {"position", position},
                        {"desired_status", status},
                        {"remove_when_done", remove}}
      .dump();
}

class AGroot2Debugger : public AGroot2Client {
 protected:
  explicit AGroot2Debugger(Duration silence = std::chrono::seconds(60))
      : AGroot2Client(true, silence) {}
  void Activate() {
    ASSERT_TRUE(harness_.controller().Switch("SelfCheck").done());
    ASSERT_TRUE(harness_.controller().Switch("Active").done());
  }
  std::string Hooks() { return Ask({Header('D')}).at(1); }
};

class AGroot2DebuggerThatIsLost : public AGroot2Debugger {
 protected:
  AGroot2DebuggerThatIsLost() : AGroot2Debugger(std::chrono::seconds(5)) {}
};

TEST_F(AGroot2Client, GetsTheTreeWithTheIdsOfItsNodes) {
  const Parts reply = Ask({Header('T')});
  ASSERT_EQ(reply.size(), 2U);
  EXPECT_EQ(reply[0].substr(0, 6), Header('T'));
  EXPECT_EQ(reply[0].size(), 22U);
  EXPECT_THAT(reply[1], HasSubstr("<BehaviorTree ID=\"Main\" _fullpath=\"\">"));
  EXPECT_THAT(reply[1], HasSubstr("<Walk name=\"first\" ticks=\"{ticks}\" _uid=\"2\"/>"));
  EXPECT_THAT(reply[1], HasSubstr("<SubTree ID=\"Rest\" name=\"rest\" long=\"7\" "
                                  "_fullpath=\"rest\" _uid=\"3\"/>"));
  EXPECT_THAT(reply[1], HasSubstr("<BehaviorTree ID=\"Rest\" _fullpath=\"rest\">"));
  EXPECT_THAT(reply[1], HasSubstr("<Action ID=\"Walk\">"));
  EXPECT_TRUE(tree::ReadTree(reply[1], "t.xml").document.Find("Rest") != nullptr);
}

TEST_F(AGroot2Client, GetsTheStatusOfEveryNodeAndWhatItWasBeforeItWasIdle) {
  EXPECT_THAT(Statuses(), ElementsAre(0, 0, 0, 0)) << "before the first tick";
  ASSERT_TRUE(harness_.controller().Switch("SelfCheck").done());
  ASSERT_TRUE(harness_.controller().Switch("Active").done());
  harness_.Tick(watched_, 1);
  EXPECT_THAT(Statuses(), ElementsAre(1, 1, 0, 0));
  harness_.Tick(watched_, 3);
  EXPECT_THAT(Statuses(), ElementsAre(1, 2, 1, 1));
  ASSERT_TRUE(harness_.controller().Switch("LowPower").done());
  EXPECT_THAT(Statuses(), ElementsAre(11, 12, 11, 11)) << "halted, halfway through";
}

TEST_F(AGroot2Client, GetsTheBlackboardsOfSubtrees) {
  const Parts reply = Ask({Header('B'), "Main;rest;nowhere"});
  ASSERT_EQ(reply.size(), 2U);
  const auto boards = nlohmann::json::from_msgpack(reply[1]);
  EXPECT_EQ(boards.at("Main").at("ticks"), 3);
  EXPECT_TRUE(boards.at("Main").at("ticks").is_number_integer()) << "Groot2 would show 3.0";
  EXPECT_EQ(boards.at("rest").at("long"), 7);
  EXPECT_EQ(boards.size(), 2U);
}

TEST_F(AGroot2Client, GetsNullForAnEntryWithoutAValueAndForNoBoard) {
  watched_.Of([](Watched& self) { return self.view().tree->board().At("unset").value.empty(); });
  const auto boards = nlohmann::json::from_msgpack(Ask({Header('B'), "Main"}).at(1));
  EXPECT_TRUE(boards.at("Main").at("unset").is_null());
  EXPECT_TRUE(nlohmann::json::from_msgpack(Ask({Header('B'), "nowhere"}).at(1)).is_null());
}

TEST_F(AGroot2Client, MayRecordTransitions) {
  EXPECT_EQ(Ask({Header('t')}).at(1), "") << "not yet";
  const Parts started = Ask({Header('r'), "start"});
  ASSERT_EQ(started.size(), 2U);
  EXPECT_GT(std::stoll(started[1]), 1'700'000'000'000'000) << "us since 1970";
  ASSERT_TRUE(harness_.controller().Switch("SelfCheck").done());
  ASSERT_TRUE(harness_.controller().Switch("Active").done());
  harness_.Tick(watched_, 4);
  const std::string made = Ask({Header('t')}).at(1);
  ASSERT_EQ(made.size() % 9, 0U);
  std::vector<std::pair<int, int>> transitions;
  for (std::size_t at = 0; at < made.size(); at += 9) {
    EXPECT_EQ(made[at + 5], 0) << "less than a day";
    transitions.emplace_back(made[at + 6], made[at + 8]);
  }
  using Made = std::pair<int, int>;
  EXPECT_THAT(transitions, ElementsAre(Made{2, 1}, Made{1, 1}, Made{2, 2}, Made{4, 1}, Made{3, 1}));
  EXPECT_EQ(Ask({Header('t')}).at(1), "") << "each once";
  EXPECT_EQ(Ask({Header('r'), "stop"}).size(), 1U);
  ASSERT_TRUE(harness_.controller().Switch("LowPower").done());
  EXPECT_EQ(Ask({Header('t')}).at(1), "");
  EXPECT_EQ(Ask({Header('r'), "pause"}).at(0), "error");
}

TEST_F(AGroot2Client, MayNotSetHooksUnlessTheConfigurationAllowsIt) {
  EXPECT_THAT(Ask({Header('D')}).at(1), "[]");
  EXPECT_EQ(Ask({Header('A')}).size(), 1U);
  EXPECT_EQ(Ask({Header('X')}).size(), 1U);
  for (const char type : {'I', 'R', 'U'}) {
    const Parts refused = Ask({Header(type), HookJson(kFirstUid, 0, "SKIPPED")});
    EXPECT_EQ(refused.at(0), "error");
    EXPECT_THAT(refused.at(1), HasSubstr("its configuration does not allow them"));
  }
  EXPECT_THAT(Ask({Header('D')}).at(1), "[]");
}

TEST_F(AGroot2Client, IsRefusedWhatIsNoRequest) {
  EXPECT_EQ(Ask({Header('I')}).at(0), "error");
  EXPECT_EQ(Ask({Header('z')}).at(1), "Request not recognized");
  EXPECT_EQ(Ask({Header('B')}).at(0), "error");
  EXPECT_EQ(Ask({"x"}).at(0), "error");
  EXPECT_EQ(Ask({std::string(5'000, 'x'), "y"}).at(0), "error");
  EXPECT_EQ(Ask({Header('S')}).size(), 2U) << "and it is still served";
}

TEST_F(AGroot2Debugger, HoldsANodeAndReceivesItWithoutDelayingTheLoop) {
  EXPECT_EQ(Ask({Header('I'), HookJson(kFirstUid, 0, "SKIPPED")}).size(), 1U);
  EXPECT_THAT(nlohmann::json::parse(Hooks()),
              nlohmann::json::parse("[" + HookJson(kFirstUid, 0, "SKIPPED") + "]"));
  Activate();
  harness_.Tick(watched_, 5);
  EXPECT_THAT(watched_.TakeLog(), ElementsAre()) << "it has not started";
  EXPECT_EQ(watched_.Status(0), "RUNNING") << "and the tree waits for it";

  EXPECT_EQ(Ask({Header('U'), ReleaseJson(kFirstUid, "SKIPPED", true)}).size(), 1U);
  EXPECT_EQ(Hooks(),
            nlohmann::json::parse("[" + HookJson(kFirstUid, 0, "SKIPPED", true) + "]").dump());
  harness_.Tick(watched_, 1);
  EXPECT_THAT(watched_.TakeLog(), ElementsAre("first starts"));
  EXPECT_EQ(Hooks(), "[]");
  EXPECT_EQ(Ask({Header('U'), ReleaseJson(kFirstUid, "SKIPPED", true)}).at(1), "Node ID not found");
}

TEST_F(AGroot2Debugger, ReceivesABreakpoint) {
  Ask({Header('I'), HookJson(kFirstUid, 1, "FAILURE")});
  Activate();
  // A subscription takes a moment: the node is replaced again and again.
  Parts breakpoint;
  const int soon_ms = 20;
  zmq_setsockopt(breakpoints_, ZMQ_RCVTIMEO, &soon_ms, sizeof soon_ms);
  testing::Until([&] {
    watched_.Of([](Watched& self) {
      self.Restart();
      return 0;
    });
    harness_.Tick(watched_, 1);
    breakpoint = Receive(breakpoints_);
    return breakpoint.size() == 2;
  });
  ASSERT_EQ(breakpoint.size(), 2U);
  EXPECT_EQ(breakpoint[0].size(), 6U);
  EXPECT_EQ(breakpoint[0].substr(0, 2), (std::string{2, 'N'}));
  EXPECT_EQ(breakpoint[1], "2");
  EXPECT_THAT(watched_.TakeLog(), ElementsAre()) << "it failed in place of its tick";
}

TEST_F(AGroot2Debugger, LeavesActiveThroughAHeldNode) {
  Ask({Header('I'), "[" + HookJson(4, 0, "SKIPPED") + "]"});
  Activate();
  harness_.Tick(watched_, 6);
  EXPECT_THAT(watched_.TakeLog(), ElementsAre("first starts"));
  EXPECT_EQ(watched_.Status(2), "RUNNING") << "the subtree around it";
  ASSERT_TRUE(harness_.controller().Switch("LowPower").done());
  EXPECT_EQ(watched_.Status(0), "IDLE");
  EXPECT_THAT(watched_.TakeLog(), ElementsAre()) << "a node that has not started is not halted";
}

TEST_F(AGroot2Debugger, ReplacesARunningNodeWhichIsHaltedFirst) {
  Activate();
  harness_.Tick(watched_, 1);
  Ask({Header('I'), HookJson(kFirstUid, 1, "SUCCESS", true)});
  harness_.Tick(watched_, 1);
  EXPECT_THAT(watched_.TakeLog(), ElementsAre("first starts", "first halted", "second starts"));
  EXPECT_EQ(Hooks(), "[]") << "once";
}

TEST_F(AGroot2Debugger, HoldsANodeWithItsResultAfterItsTick) {
  const std::string hook = HookJson(kFirstUid, 0, "SKIPPED", false, 1);
  EXPECT_EQ(Ask({Header('I'), hook}).size(), 1U);
  EXPECT_EQ(nlohmann::json::parse(Hooks()), nlohmann::json::parse("[" + hook + "]"));
  Activate();
  harness_.Tick(watched_, 6);
  EXPECT_THAT(watched_.TakeLog(), ElementsAre("first starts")) << "the next one waits";
  EXPECT_EQ(watched_.Status(kFirstUid - 1), "SUCCESS");
  EXPECT_EQ(Ask({Header('U'), ReleaseJson(kFirstUid, "SKIPPED", true)}).at(0), "error")
      << "no hook is before its tick";
  EXPECT_EQ(Ask({Header('U'), ReleaseJson(kFirstUid, "SKIPPED", true, 1)}).size(), 1U);
  harness_.Tick(watched_, 1);
  EXPECT_THAT(watched_.TakeLog(), ElementsAre("second starts"));
  EXPECT_EQ(Hooks(), "[]");
}

TEST_F(AGroot2Debugger, DisablesAndRemovesHooks) {
  Ask({Header('I'), HookJson(kFirstUid, 0, "SKIPPED")});
  Activate();
  harness_.Tick(watched_, 2);
  Ask({Header('X')});
  harness_.Tick(watched_, 1);
  EXPECT_THAT(watched_.TakeLog(), ElementsAre("first starts"));
  EXPECT_EQ(Ask({Header('R'), ReleaseJson(kFirstUid, "", false)}).size(), 1U);
  EXPECT_EQ(Ask({Header('R'), ReleaseJson(kFirstUid, "", false)}).at(1), "Node ID not found");
  Ask({Header('I'), HookJson(kFirstUid, 0, "SKIPPED")});
  Ask({Header('A')});
  EXPECT_EQ(Hooks(), "[]");
}

TEST_F(AGroot2Debugger, IsRefusedAHookThatIsWrongAndThoseBesideIt) {
  const std::string good = HookJson(kFirstUid, 0, "SKIPPED");
  nlohmann::json after = nlohmann::json::parse(good);
  after["position"] = 2;
  nlohmann::json half = nlohmann::json::parse(good);
  half.erase("once");
  for (const std::string& wrong :
       {HookJson(9, 0, "SKIPPED"), HookJson(0, 0, "SKIPPED"), HookJson(kFirstUid, 2, "SKIPPED"),
        HookJson(kFirstUid, 0, "DONE"), after.dump(), half.dump(), std::string("7"),
        std::string("{"), "[" + good + "," + HookJson(9, 0, "SKIPPED") + "]"}) {
    EXPECT_EQ(Ask({Header('I'), wrong}).at(0), "error") << wrong;
    EXPECT_EQ(Hooks(), "[]") << wrong;
  }
}

TEST_F(AGroot2Debugger, ReleasesANodeOnceWhereItsRequestComesTwice) {
  Ask({Header('I'), HookJson(kFirstUid, 0, "SKIPPED")});
  Activate();
  harness_.Tick(watched_, 2);
  EXPECT_EQ(Ask({Header('U'), ReleaseJson(kFirstUid, "SKIPPED", false)}).size(), 1U);
  harness_.Tick(watched_, 1);
  EXPECT_THAT(watched_.TakeLog(), ElementsAre("first starts"));
  EXPECT_EQ(Ask({Header('U'), ReleaseJson(kFirstUid, "SKIPPED", false)}).at(1),
            "the node is not held");
  watched_.Of([](Watched& self) {
    self.Restart();
    return 0;
  });
  watched_.TakeLog();
  harness_.Tick(watched_, 2);
  EXPECT_THAT(watched_.TakeLog(), ElementsAre()) << "its next start is held";
}

TEST_F(AGroot2Debugger, ReleasesNothingWhileTheTreeIsPausedOrRests) {
  Ask({Header('I'), HookJson(kFirstUid, 0, "SKIPPED")});
  Activate();
  harness_.Tick(watched_, 2);
  ASSERT_TRUE(harness_.controller().Switch("LowPower").done());
  EXPECT_EQ(Ask({Header('U'), ReleaseJson(kFirstUid, "SKIPPED", false)}).at(1),
            "the node is not held");
  ASSERT_TRUE(harness_.controller().Switch("Active").done());
  harness_.Tick(watched_, 2);
  EXPECT_THAT(watched_.TakeLog(), ElementsAre()) << "its next start is held";

  EXPECT_EQ(Ask({Header('U'), ReleaseJson(kFirstUid, "SKIPPED", false)}).size(), 1U);
  const auto rest = [](Watched& self) {
    self.Halt();
    return 0;
  };
  const auto go_on = [](Watched& self) {
    self.Restart();
    return 0;
  };
  watched_.Of(rest);
  EXPECT_EQ(Ask({Header('U'), ReleaseJson(kFirstUid, "SKIPPED", false)}).at(1),
            "the node is not held");
  watched_.Of(go_on);
  harness_.Tick(watched_, 2);
  EXPECT_THAT(watched_.TakeLog(), ElementsAre()) << "nor is it released by the one before the halt";
}

TEST_F(AGroot2Debugger, WhoseRequestWasAnsweredWithAnErrorChangesNothingLater) {
  std::promise<void> is_busy;
  std::promise<void> busy;
  std::thread loop([&] {
    watched_.RunOnLoop([&] {
      is_busy.set_value();
      busy.get_future().wait();
    });
  });
  is_busy.get_future().wait();
  const Parts refused = Ask({Header('I'), HookJson(kFirstUid, 0, "SKIPPED")});
  busy.set_value();
  loop.join();
  EXPECT_EQ(refused, (Parts{"error", "the robot's loop is busy"}));
  EXPECT_EQ(Hooks(), "[]");
}

TEST_F(AGroot2DebuggerThatIsLost, HoldsNothingAnyMoreAndTheTreeIsHalted) {
  Ask({Header('I'), HookJson(4, 0, "SKIPPED")});
  Activate();
  harness_.Tick(watched_, 4);
  EXPECT_THAT(watched_.TakeLog(), ElementsAre("first starts"));
  ASSERT_EQ(watched_.Status(2), "RUNNING") << "the subtree around the held node";
  EXPECT_TRUE(testing::Until([&] { return watched_.Status(0) == "IDLE"; }));
  EXPECT_EQ(Hooks(), "[]");
  harness_.Tick(watched_, 3);
  EXPECT_THAT(watched_.TakeLog(), ElementsAre()) << "nothing moves by itself";
}

// Without a server, of a tree that is ticked by hand.
struct AGroot2Session : ::testing::Test {
  void Insert(const std::string& client, const std::string& hooks) {
    EXPECT_EQ(session.Reply(client, {Header('I'), hooks}).size(), 1U);
  }
  nlohmann::json Hooks() {
    return nlohmann::json::parse(session.Reply("other", {Header('D')}).at(1));
  }

  tree::Logged logged;
  std::unique_ptr<tree::Tree> tree = tree::MakeTree(
      tree::Main("<Sequence><Say name=\"a\" does=\"R\"/><Say name=\"b\" does=\"S\"/></Sequence>"),
      logged.factory);
  groot2::Session session{[this] { return TreeView{.tree = tree.get(), .revision = 1}; },
                          logged.factory,
                          {.hooks = true}};
};

TEST_F(AGroot2Session, KeepsAHookOfALostClientThatActsWhereNothingHaltsTheTree) {
  const std::string held = HookJson(2, 0, "SKIPPED");
  Insert("lost", "[" + held + "," + HookJson(3, 0, "SKIPPED") + "]");
  EXPECT_EQ(tree::Ticks(*tree, 2), "RR");
  session.Forget("lost");
  EXPECT_EQ(Hooks(), nlohmann::json::parse("[" + held + "]"));
  EXPECT_EQ(tree::Ticks(*tree, 2, 2), "RR");
  EXPECT_EQ(logged.Take(), "") << "it does not move by itself";
}

TEST_F(AGroot2Session, KeepsItAlsoWhereTheTreeWasHaltedBefore) {
  const std::string held = HookJson(2, 0, "SKIPPED");
  Insert("lost", held);
  EXPECT_EQ(tree::Ticks(*tree, 2), "RR");
  ASSERT_TRUE(tree->Halt(tree::At(20)));  // the robot leaves Active
  session.Forget("lost");
  EXPECT_EQ(Hooks(), nlohmann::json::parse("[" + held + "]"));
  EXPECT_EQ(tree::Ticks(*tree, 2, 3), "RR");
  EXPECT_EQ(logged.Take(), "") << "it does not begin by itself";
}

TEST_F(AGroot2Session, RemovesTheHooksOfTheLostClientOnly) {
  const std::string own = HookJson(3, 0, "SKIPPED");
  Insert("lost", HookJson(2, 1, "SUCCESS"));
  Insert("other", own);
  session.Forget("lost");
  EXPECT_EQ(Hooks(), nlohmann::json::parse("[" + own + "]"));
  session.Forget("other");
  EXPECT_EQ(Hooks(), nlohmann::json::array());
}

TEST_F(AGroot2DebuggerThatIsLost, HaltsATreeInWhichItReplacesANode) {
  Ask({Header('I'), HookJson(kFirstUid, 1, "SUCCESS")});
  Activate();
  harness_.Tick(watched_, 1);
  EXPECT_TRUE(testing::Until([&] { return Ask(other_, {Header('D')}).at(1) == "[]"; }));
  EXPECT_THAT(watched_.TakeLog(), ElementsAre("second starts", "second halted"));
  harness_.Tick(watched_, 3);
  EXPECT_THAT(watched_.TakeLog(), ElementsAre());
}

// The tree would run through the breakpoint, and no person is there.
TEST_F(AGroot2DebuggerThatIsLost, HaltsATreeThatItsHooksWouldReach) {
  Ask({Header('I'), HookJson(4, 0, "SKIPPED")});
  Activate();
  harness_.Tick(watched_, 1);
  EXPECT_TRUE(testing::Until([&] { return Ask(other_, {Header('D')}).at(1) == "[]"; }));
  EXPECT_THAT(watched_.TakeLog(), ElementsAre("first starts", "first halted"));
}

}  // namespace musher::groot2_test
