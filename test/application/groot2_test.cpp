// A tree is served to a client that speaks the protocol of Groot2 over ZeroMQ.

#include "musher/application/groot2/groot2_server.hpp"

#include <zmq.h>

#include <nlohmann/json.hpp>

#include "musher/test/application/tree_course.hpp"

namespace musher::groot2_test {

using groot2::Parts;
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

class Watched : public TreeActuator {
 public:
  explicit Watched(int own_port) : TreeActuator("show", {.rate_hz = 50}), port(own_port) {}
  template <class Look>
  auto Of(Look look) {
    decltype(look(*this)) found{};
    RunOnLoop([&] { found = look(*this); });
    return found;
  }
  using TreeActuator::Now;

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
        topics, {.port = port}, [this] { return view(); }, factory());
    if (!served) Log(served.error());
  }
  // [serve end]

  const int port;
  testing::CourseData data_;
};

class AGroot2Client : public ::testing::Test {
 protected:
  AGroot2Client() {
    harness_.Open(watched_);
    Connect();
  }
  ~AGroot2Client() override {
    zmq_close(socket_);
    zmq_ctx_term(context_);
  }
  void Connect() {
    const int linger = 0;
    const int timeout_ms = 20'000;
    zmq_setsockopt(socket_, ZMQ_LINGER, &linger, sizeof linger);
    zmq_setsockopt(socket_, ZMQ_RCVTIMEO, &timeout_ms, sizeof timeout_ms);
    zmq_connect(socket_, ("tcp://127.0.0.1:" + std::to_string(kPort)).c_str());
  }
  static std::string Header(char type) { return {2, type, 'a', 'b', 'c', 'd'}; }
  Parts Ask(const Parts& request) {
    for (std::size_t i = 0; i < request.size(); ++i) {
      zmq_send(socket_, request[i].data(), request[i].size(),
               i + 1 < request.size() ? ZMQ_SNDMORE : 0);
    }
    Parts reply;
    for (int more = 1; more != 0;) {
      zmq_msg_t part;
      zmq_msg_init(&part);
      if (zmq_msg_recv(&part, socket_, 0) < 0) return reply;
      reply.emplace_back(static_cast<const char*>(zmq_msg_data(&part)), zmq_msg_size(&part));
      more = zmq_msg_more(&part);
      zmq_msg_close(&part);
    }
    return reply;
  }
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
  ActuatorRunner<Watched> watched_{kPort};
  void* context_ = zmq_ctx_new();
  void* socket_ = zmq_socket(context_, ZMQ_REQ);
};

TEST_F(AGroot2Client, GetsTheTreeWithTheIdsOfItsNodes) {
  const Parts reply = Ask({Header('T')});
  ASSERT_EQ(reply.size(), 2U);
  EXPECT_EQ(reply[0].substr(0, 6), Header('T'));
  EXPECT_EQ(reply[0].size(), 22U);
  EXPECT_THAT(reply[1], HasSubstr("<BehaviorTree ID=\"Main\" _fullpath=\"\">"));
  EXPECT_THAT(reply[1], HasSubstr("<Walk name=\"first\" ticks=\"{ticks}\" _uid=\"2\"/>"));
  EXPECT_THAT(reply[1], HasSubstr("<SubTree ID=\"Rest\" name=\"rest\" long=\"7\" "
                                  "_fullpath=\"Main/Sequence/rest\" _uid=\"3\"/>"));
  EXPECT_THAT(reply[1], HasSubstr("<BehaviorTree ID=\"Rest\" _fullpath=\"Main/Sequence/rest\">"));
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
  const Parts reply = Ask({Header('B'), "Main;Main/Sequence/rest;nowhere"});
  ASSERT_EQ(reply.size(), 2U);
  const auto boards = nlohmann::json::from_msgpack(reply[1]);
  EXPECT_EQ(boards.at("Main").at("ticks"), 3);
  EXPECT_TRUE(boards.at("Main").at("ticks").is_number_integer()) << "Groot2 would show 3.0";
  EXPECT_EQ(boards.at("Main/Sequence/rest").at("long"), 7);
  EXPECT_EQ(boards.size(), 2U);
}

TEST_F(AGroot2Client, IsRefusedWhatWouldStopTheRobotAndWhatIsNoRequest) {
  EXPECT_THAT(Ask({Header('D')}).at(1), "[]");
  EXPECT_EQ(Ask({Header('A')}).size(), 1U);
  EXPECT_EQ(Ask({Header('I'), "{}"}).at(0), "error");
  EXPECT_EQ(Ask({Header('B')}).at(0), "error");
  EXPECT_EQ(Ask({"x"}).at(0), "error");
  EXPECT_EQ(Ask({std::string(5'000, 'x'), "y"}).at(0), "error");
  EXPECT_EQ(Ask({Header('S')}).size(), 2U) << "and it is still served";
}

}  // namespace musher::groot2_test
