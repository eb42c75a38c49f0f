// A client whose controller ends during the switch that it requested: it detects that within a
// second, and gets the outcome of the switch from the successor. It waited for 60 s and reported an
// error of the successor.

#include "musher/controller/client/switch_client.hpp"

#include <gmock/gmock.h>

#include <map>
#include <span>

#include "musher/base/code.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/test/controller/two_controllers.hpp"
#include "musher/test/transport/suspended_node.hpp"
#include "musher/transport/raw_server.hpp"
#include "musher/transport/service.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::testing::switch_client_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using Kind = SwitchEnd::Kind;

// Reports the exit of a controller that the test has killed to its watchers, as the kernel does.
class Kernel {
 public:
  WatchProcess Watch() {
    return [this](std::int32_t pid, std::function<void()> on_end) -> transport::LoopHandlePtr {
      if (pid == exited) return nullptr;
      watchers_[pid] = std::move(on_end);
      return std::make_unique<Handle>(*this, pid);
    };
  }
  void ReportEnd(std::int32_t pid) {
    const auto watcher = watchers_.extract(pid);
    if (!watcher.empty()) watcher.mapped()();
  }
  std::int32_t exited = 0;  // a process that has exited before it is watched

 private:
  class Handle : public transport::LoopHandle {
   public:
    Handle(Kernel& kernel, std::int32_t pid) : kernel_(kernel), pid_(pid) {}
    ~Handle() override { kernel_.watchers_.erase(pid_); }

   private:
    Kernel& kernel_;
    const std::int32_t pid_;
  };
  std::map<std::int32_t, std::function<void()>> watchers_;
};

class SwitchClients : public TwoControllers {
 protected:
  static constexpr const char* kSimHost = "sim-1/0";  // what simulated controllers say of theirs

  // `host`: the client's.
  void Request(const std::string& target, const std::string& host = kSimHost,
               std::optional<msg::MachineStatus> exited = std::nullopt) {
    options_.exited = std::move(exited);
    options_.leader = {"", host, kernel_.Watch()};
    client_ = SwitchClient::Make(
                  *desk_, options_, target, actuator_,
                  [this](const std::string& news) {
                    news_.push_back(news);
                    reported_at_ = network_.now();
                  },
                  [this](const SwitchEnd& end) {
                    ++ends_;
                    end_ = end;
                  })
                  .value();
  }
  void RequestAndGetUnderWay(const std::string& target, const std::string& host = kSimHost) {
    callback_takes_ = Milliseconds(1800);
    Request(target, host);
    ASSERT_TRUE(RunUntil([&] { return first_.machine().current.has_value(); }));
    network_.RunFor(Milliseconds(300));
    ASSERT_TRUE(first_.machine().current);
    number_ = first_.machine().last_switch.value();
    callback_takes_ = Milliseconds(5);
  }
  void KillFirst() {
    killed_at_ = network_.now();
    const std::int32_t pid = first_.process->pid();
    first_.process.reset();
    kernel_.ReportEnd(pid);
  }
  // On the same host, with the disk of the first; or elsewhere.
  void StartSecond(bool elsewhere = false) {
    Open(second_, "second", elsewhere ? nullptr : &first_.disk);
    network_.RunFor(std::chrono::seconds(1));
    second_.process->Begin(false);
  }
  SwitchEnd End(Duration limit = kEnough) {
    EXPECT_TRUE(RunUntil([this] { return end_.has_value(); }, limit));
    return end_.value_or(SwitchEnd{});
  }

  Kernel kernel_;
  SwitchClient::Options options_;
  std::string actuator_;  // that is to switch; empty: the machine
  std::unique_ptr<SwitchClient> client_;
  std::vector<std::string> news_;
  std::optional<SwitchEnd> end_;
  int ends_ = 0;
  Time reported_at_{};
  Time killed_at_{};
  std::uint64_t number_ = 0;
};

TEST_F(SwitchClients, PassOnTheAnswerOfALivingController) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  Request("LowPower");
  EXPECT_EQ(End().kind, Kind::kAnswered);
  EXPECT_EQ(end_->result.outcome, "done");
  EXPECT_THAT(news_, IsEmpty());
}

TEST_F(SwitchClients, AreNotifiedAtOnceOfAnExitedControllerOfTheirHostAndThenOfTheOutcome) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  ASSERT_NO_FATAL_FAILURE(RequestAndGetUnderWay("LowPower"));
  const std::string pid = std::to_string(first_.process->pid());
  KillFirst();
  ASSERT_TRUE(RunUntil([this] { return !news_.empty(); }));
  EXPECT_LE(reported_at_ - killed_at_, Milliseconds(300));
  EXPECT_THAT(news_[0], HasSubstr("the controller (pid " + pid +
                                  ", epoch 1) has exited during "
                                  "switch " +
                                  std::to_string(number_) + " to LowPower"));
  StartSecond();
  EXPECT_EQ(End().kind, Kind::kReported);
  EXPECT_EQ(end_->result.outcome, "interrupted");
  EXPECT_EQ(end_->result.switch_number, number_);
  EXPECT_EQ(end_->result.state, "LowPower") << "the successor ends it on the way down";
  EXPECT_THAT(end_->result.reason,
              AllOf(HasSubstr("controller of epoch 1 ended during it"),
                    HasSubstr("epoch 2 continues with the machine in LowPower")));
  EXPECT_EQ(ends_, 1);
}

TEST_F(SwitchClients, AreNotifiedWithinASecondOfALostControllerOfAnotherHost) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  ASSERT_NO_FATAL_FAILURE(RequestAndGetUnderWay("LowPower", "desk"));
  KillFirst();
  ASSERT_TRUE(RunUntil([this] { return !news_.empty(); }));
  EXPECT_LE(reported_at_ - killed_at_, std::chrono::seconds(1));
  StartSecond();
  EXPECT_EQ(End().kind, Kind::kReported);
  EXPECT_EQ(end_->result.switch_number, number_);
}

TEST_F(SwitchClients, GetTheOutcomeOfASwitchWhenOnlyItsReplyWasLost) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  ASSERT_NO_FATAL_FAILURE(RequestAndGetUnderWay("LowPower"));
  network_.Block("first", "desk");
  ASSERT_TRUE(RunUntil([this] { return first_.machine().state == "LowPower"; }));
  KillFirst();
  StartSecond();
  EXPECT_EQ(End().kind, Kind::kReported);
  EXPECT_EQ(end_->result.outcome, "done");
  EXPECT_EQ(end_->result.switch_number, number_);
  EXPECT_EQ(end_->result.state, "LowPower");
}

TEST_F(SwitchClients, GetAdviceWithoutASuccessor) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  ASSERT_NO_FATAL_FAILURE(RequestAndGetUnderWay("LowPower"));
  KillFirst();
  EXPECT_EQ(End(std::chrono::seconds(6)).kind, Kind::kUnknown);
  EXPECT_THAT(end_->result.reason,
              AllOf(HasSubstr("has exited during switch"), HasSubstr("no successor within 5 s"),
                    HasSubstr("musher up")));
  EXPECT_EQ(end_->result.switch_number, number_);
}

TEST_F(SwitchClients, GetAnUnknownOutcomeFromASuccessorWithoutTheJournal) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  ASSERT_NO_FATAL_FAILURE(RequestAndGetUnderWay("LowPower"));
  KillFirst();
  StartSecond(true);
  EXPECT_EQ(End().kind, Kind::kUnknown);
  EXPECT_THAT(end_->result.reason, AllOf(HasSubstr("no such switch"), HasSubstr("is recorded here"),
                                         HasSubstr("machine in LowPower")));
}

TEST_F(SwitchClients, RequestATearDownAgainFromTheSuccessor) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  ASSERT_NO_FATAL_FAILURE(RequestAndGetUnderWay("TearDown"));
  KillFirst();
  StartSecond();
  EXPECT_EQ(End().kind, Kind::kAnswered) << end_->result.reason;
  EXPECT_EQ(end_->result.state, "TearDown");
  EXPECT_EQ(second_.machine().phase, Phase::kStopped);
}

TEST_F(SwitchClients,
       RequestATearDownAgainFromTheNextControllerWhereTheFirstWasCalledInAnotherWay) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  const msg::MachineStatus exited = first_.process->shell().Status();
  KillFirst();
  Request("TearDown", kSimHost, exited);
  ASSERT_TRUE(RunUntil([this] { return !news_.empty(); }));
  EXPECT_THAT(news_[0], HasSubstr("the controller (pid " + std::to_string(exited.pid) +
                                  ", epoch 1) has exited before it reported"));
  StartSecond();
  EXPECT_EQ(End().kind, Kind::kAnswered) << end_->result.reason;
  EXPECT_EQ(end_->result.state, "TearDown");
  EXPECT_EQ(second_.machine().phase, Phase::kStopped);
}

// It waited for a successor, and ended with an unknown outcome.
TEST_F(SwitchClients, TakeTheLastStatusOfAControllerThatWasCalledInAnotherWayForItsAnswer) {
  msg::MachineStatus exited;
  exited.epoch = 3;
  exited.pid = 4711;
  exited.host = kSimHost;
  exited.phase = "stopped";
  exited.state = "TearDown";
  exited.switch_number = 5;
  Request("TearDown", kSimHost, exited);
  EXPECT_EQ(End(std::chrono::seconds(1)).kind, Kind::kReported);
  EXPECT_EQ(end_->result.outcome, "done");
  EXPECT_EQ(end_->result.switch_number, 5U);
  EXPECT_THAT(news_, IsEmpty());
}

TEST_F(SwitchClients, TakeTheStatusThatArrivesAfterTheExitOfAControllerThatWasCalledInAnotherWay) {
  const auto node = network_.MakeNode("first");
  const auto statuses = transport::MakePublisher<msg::MachineStatus>(
      *node, transport::MachineStatusTopic(""), transport::kLatchedQos);
  msg::MachineStatus status;
  status.epoch = 3;
  status.pid = 4711;
  status.host = kSimHost;
  status.phase = "stopping";
  status.participant = node->participant().value();
  Request("TearDown", kSimHost, status);
  status.phase = "stopped";
  status.state = "TearDown";
  ASSERT_TRUE(statuses.value()->Publish(status));
  EXPECT_EQ(End(std::chrono::seconds(1)).kind, Kind::kReported);
  EXPECT_EQ(end_->result.outcome, "done");
  EXPECT_THAT(news_, IsEmpty());
}

TEST_F(SwitchClients, GetInterruptedForARequestThatNeverArrivedAndItIsNotRunLater) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  Request("LowPower");
  ASSERT_TRUE(RunUntil([this] { return client_->found(); }));
  KillFirst();
  StartSecond();
  EXPECT_EQ(End().kind, Kind::kReported);
  EXPECT_EQ(end_->result.outcome, "interrupted");
  EXPECT_THAT(end_->result.reason, HasSubstr("the switch had not begun, request it again"));
  network_.RunFor(std::chrono::seconds(5));
  EXPECT_EQ(second_.machine().state, "Active");
}

TEST_F(SwitchClients, AreNotifiedOfATakeoverDuringTheirSwitch) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  ASSERT_NO_FATAL_FAILURE(RequestAndGetUnderWay("LowPower"));
  Open(second_, "second", &first_.disk);
  second_.process->Begin(true);
  End();
  EXPECT_EQ(end_->result.switch_number, number_);
  EXPECT_EQ(end_->result.outcome, "superseded");
  EXPECT_EQ(ends_, 1);
}

TEST_F(SwitchClients, StayWithAControllerThatWasOnlySilentForAWhile) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  ASSERT_NO_FATAL_FAILURE(RequestAndGetUnderWay("LowPower", "desk"));
  network_.Pause(first_.process->node());
  ASSERT_TRUE(RunUntil([this] { return !news_.empty(); }));
  EXPECT_THAT(news_[0], HasSubstr("sends no heartbeat during switch"));
  network_.Resume(first_.process->node());
  EXPECT_EQ(End().kind, Kind::kAnswered);
  EXPECT_EQ(end_->result.outcome, "done");
  EXPECT_EQ(end_->result.switch_number, number_);
}

TEST_F(SwitchClients, EndInTimeWhereNoControllerIs) {
  Request("LowPower");
  EXPECT_EQ(End(std::chrono::seconds(61)).kind, Kind::kUnknown);
  EXPECT_EQ(end_->result.code, kCodeTimeout);
}

// A laptop that is closed while it waits for the robot, and opened beside it on the next day.
class SuspendedClients : public SwitchClients {
 protected:
  // How many requests a controller receives that appears after the suspension.
  int ReceivedOf(const std::string& target) {
    SuspendedNode laptop(network_.MakeNode("laptop"));
    const auto beside = network_.MakeNode("beside");  // receives what the controller receives
    int received = 0;
    const auto server = transport::MakeServer<msg::SetState>(
                            *beside, transport::MachineService("", "set_state"),
                            [&received](const msg::SetState::Request&, const auto&) { ++received; })
                            .value();
    SwitchClient::Options options;
    options.leader = {"", "laptop", kernel_.Watch()};
    const auto client = SwitchClient::Make(
                            laptop, options, target, "", [](const std::string&) {},
                            [this](const SwitchEnd& end) { end_ = end; })
                            .value();
    network_.RunFor(std::chrono::seconds(1));
    laptop.loop().suspended = std::chrono::hours(8);
    Open(first_, "first");
    first_.process->Begin(false);
    End();
    return received;
  }
};

TEST_F(SuspendedClients, RequestNothingLater) {
  EXPECT_EQ(ReceivedOf("LowPower"), 0);
  ASSERT_TRUE(end_);
  EXPECT_EQ(end_->kind, Kind::kUnknown);
  EXPECT_EQ(end_->result.code, kCodeTimeout);
  EXPECT_THAT(end_->result.reason, HasSubstr("nothing was requested"));
}

TEST_F(SuspendedClients, RequestATearDownHoweverLate) {
  EXPECT_EQ(ReceivedOf("TearDown"), 1);
}

TEST_F(SuspendedClients, RequestErrorHoweverLate) {
  EXPECT_EQ(ReceivedOf("Error"), 1);
}

// The controller ends with its machine, and its last answer was lost on the way.
TEST_F(SwitchClients, TakeTheLatchedStatusForTheLostAnswerToATearDown) {
  const auto node = network_.MakeNode("first");
  bool called = false;
  const auto server = transport::MakeServer<msg::SetState>(
      *node, transport::MachineService("", "set_state"),
      [&called](const auto&, const auto&) { called = true; });  // never answers
  const auto statuses = transport::MakePublisher<msg::MachineStatus>(
      *node, transport::MachineStatusTopic(""), transport::kLatchedQos);
  msg::MachineStatus status;
  status.epoch = 3;
  status.pid = 4711;
  status.host = kSimHost;
  status.phase = "failed";
  status.state = "SelfCheck";
  ASSERT_TRUE(statuses.value()->Publish(status));
  Request("TearDown");
  ASSERT_TRUE(RunUntil([&] { return called; }));
  status.phase = "stopped";
  status.state = "TearDown";
  status.switch_number = 5;
  ASSERT_TRUE(statuses.value()->Publish(status));
  network_.RunFor(Milliseconds(20));
  EXPECT_FALSE(end_);
  kernel_.ReportEnd(4711);
  EXPECT_EQ(End(std::chrono::seconds(1)).kind, Kind::kReported);
  EXPECT_EQ(end_->result.outcome, "done");
  EXPECT_EQ(end_->result.state, "TearDown");
  EXPECT_EQ(end_->result.switch_number, 5U);
  EXPECT_THAT(news_, IsEmpty());
}

TEST_F(SwitchClients, DoNotTakeTheLatchedStatusOfAnotherParticipantForTheAnswerToATearDown) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  ASSERT_NO_FATAL_FAILURE(RequestAndGetUnderWay("TearDown"));
  const auto node = network_.MakeNode("bridge");
  const auto statuses = transport::MakePublisher<msg::MachineStatus>(
      *node, transport::MachineStatusTopic(""), transport::kLatchedQos);
  msg::MachineStatus status;
  status.machine = config_.name;
  status.epoch = first_.machine().epoch.value();
  status.pid = first_.process->pid();
  status.host = kSimHost;
  status.phase = "stopped";
  status.state = "TearDown";
  ASSERT_TRUE(statuses.value()->Publish(status));
  network_.RunFor(Milliseconds(100));
  KillFirst();
  EXPECT_EQ(End(std::chrono::seconds(8)).kind, Kind::kUnknown) << end_->result.outcome;
}

// A controller of which only what it sends is there: its last status, and its answers to clients.
class SentBy {
 public:
  SentBy(transport::sim::Network& network, const std::string& name, std::uint64_t epoch,
         std::int32_t pid)
      : node_(network.MakeNode(name)),
        statuses_(transport::MakePublisher<msg::MachineStatus>(
                      *node_, transport::MachineStatusTopic(""), transport::kLatchedQos)
                      .value()) {
    status.epoch = epoch;
    status.pid = pid;
    status.host = "sim-1/0";
    status.phase = "running";
    status.state = "Active";
    status.target = "Active";
    status.switch_number = 4;
    status.participant = node_->participant().value();
  }
  void Publish() { ASSERT_TRUE(statuses_->Publish(status)); }
  // Answers with Reply() only.
  void TakeRequests() {
    set_state_ = transport::MakeServer<msg::SetState>(
                     *node_, transport::MachineService("", "set_state"),
                     [this](const msg::SetState::Request& received, auto reply) {
                       ++requests;
                       request = received;
                       reply_ = std::move(reply);
                     })
                     .value();
  }
  void Reply(const std::string& outcome) {
    msg::SetState::Response answer;
    answer.outcome = outcome;
    reply_(answer);
  }
  void TakeQueries(std::optional<msg::GetSwitch::Response> answer) {
    get_switch_ = transport::MakeServer<msg::GetSwitch>(
                      *node_, transport::MachineService("", "get_switch"),
                      [this, answer = std::move(answer)](const msg::GetSwitch::Request& received,
                                                         const auto& reply) {
                        ++queries;
                        query = received;
                        query_reply_ = reply;
                        if (queries <= under_way) {
                          msg::GetSwitch::Response not_yet;
                          not_yet.outcome = msg::GetSwitch::kUnderWay;
                          reply(not_yet);
                        } else if (answer) {
                          reply(*answer);
                        }
                      })
                      .value();
  }

  void ReplyUnderWay() {
    msg::GetSwitch::Response answer;
    answer.outcome = msg::GetSwitch::kUnderWay;
    query_reply_(answer);
  }
  transport::Node& node() { return *node_; }

  msg::MachineStatus status;
  int requests = 0;
  int queries = 0;
  int under_way = 0;  // so many queries find the switch under way
  msg::SetState::Request request;
  msg::GetSwitch::Request query;

 private:
  std::function<void(const msg::SetState::Response&)> reply_;
  std::function<void(const msg::GetSwitch::Response&)> query_reply_;
  std::unique_ptr<transport::Node> node_;
  std::unique_ptr<transport::Publisher<msg::MachineStatus>> statuses_;
  std::unique_ptr<transport::Server<msg::SetState>> set_state_;
  std::unique_ptr<transport::Server<msg::GetSwitch>> get_switch_;
};

class ClientsOfASuccessor : public SwitchClients {
 protected:
  // The first controller gets a request for LowPower, and exits before it begins the switch.
  void RequestFromOneThatExits(const std::string& target = "LowPower") {
    ASSERT_NO_FATAL_FAILURE(RequestFromLeader(target));
    kernel_.ReportEnd(4711);
    ASSERT_TRUE(RunUntil([this] { return !news_.empty(); }));
  }
  void RequestFromLeader(const std::string& target, const std::string& host = kSimHost) {
    leader_.TakeRequests();
    leader_.Publish();
    Request(target, host);
    ASSERT_TRUE(RunUntil([this] { return leader_.requests == 1; }));
  }
  // Publishes that of the leader which is called, and it is received.
  void Publish() {
    leader_.Publish();
    network_.RunFor(Milliseconds(100));
  }
  void ExitStopped(const std::string& phase = "stopped") {
    leader_.status.phase = phase;
    leader_.status.state = "TearDown";
    leader_.status.target.clear();
    leader_.status.switch_number = 5;
    Publish();
    kernel_.ReportEnd(4711);
  }
  static msg::GetSwitch::Response Done(std::uint64_t number, const std::string& actuator) {
    msg::GetSwitch::Response answer;
    answer.found = true;
    answer.switch_number = number;
    answer.target = "LowPower";
    answer.actuator = actuator;
    answer.outcome = "done";
    answer.state = "LowPower";
    return answer;
  }
  // The end of the request where the last switch of the successor is `last`.
  SwitchEnd EndAfter(const msg::GetSwitch::Response& last) {
    RequestFromOneThatExits();
    successor_.TakeQueries(last);
    successor_.Publish();
    return End();
  }

  SentBy leader_{network_, "first", 3, 4711};
  SentBy successor_{network_, "second", 4, 4712};
};

TEST_F(ClientsOfASuccessor, TakeASwitchAfterTheirRequestForTheirs) {
  EXPECT_EQ(EndAfter(Done(5, "")).result.outcome, "done");
}

TEST_F(ClientsOfASuccessor, DoNotTakeASwitchFromBeforeTheirRequestForTheirs) {
  EXPECT_EQ(EndAfter(Done(4, "")).result.outcome, "interrupted");
}

TEST_F(ClientsOfASuccessor, DoNotTakeASwitchOfOneActuatorForThatOfTheMachine) {
  EXPECT_EQ(EndAfter(Done(5, "arm")).result.outcome, "interrupted");
}

TEST_F(ClientsOfASuccessor, QueryTheNextOneWhereTheSuccessorExitsToo) {
  ASSERT_NO_FATAL_FAILURE(RequestFromOneThatExits());
  successor_.TakeQueries(std::nullopt);
  successor_.Publish();
  ASSERT_TRUE(RunUntil([this] { return successor_.queries == 1; }));
  kernel_.ReportEnd(4712);
  SentBy next(network_, "third", 5, 4713);
  next.TakeQueries(Done(5, ""));
  next.Publish();
  EXPECT_EQ(End().result.outcome, "done") << end_->result.reason;
}

TEST_F(ClientsOfASuccessor, RequestAndQueryExactlyWhatIsMeant) {
  for (SentBy* one : {&leader_, &successor_}) {
    one->status.machine = "dog";
    one->status.machine_id = "id-1";
  }
  options_.by = "anna";
  actuator_ = "arm";
  ASSERT_NO_FATAL_FAILURE(RequestFromLeader("LowPower"));
  EXPECT_EQ(leader_.request, (msg::SetState::Request{"LowPower", "arm", "anna", "dog", "id-1"}));
  leader_.status.epoch = 7;  // it has learned of a higher one
  leader_.status.target = "LowPower";
  leader_.status.switch_number = 6;
  Publish();
  kernel_.ReportEnd(4711);
  ASSERT_TRUE(RunUntil([this] { return !news_.empty(); }));
  successor_.status.epoch = 8;
  auto answer = Done(6, "arm");
  answer.code = 17;
  answer.outcome = "failed";
  successor_.TakeQueries(answer);
  successor_.Publish();
  EXPECT_EQ(End().result.outcome, "failed");
  EXPECT_EQ(end_->result.code, 17);
  EXPECT_EQ(end_->result.actuator, "arm");
  EXPECT_EQ(successor_.query, (msg::GetSwitch::Request{7, 6, "dog", "id-1"}));
}

TEST_F(ClientsOfASuccessor, TakeTheAnswersOfTheLeaderOnlyBesideTheServicesOfAnotherController) {
  leader_.status.machine = successor_.status.machine = "dog";
  SentBy other(network_, "other", 1, 4714);  // has crashed, and its services are still matched
  other.TakeRequests();
  other.TakeQueries(Done(9, ""));
  leader_.Publish();
  Request("LowPower");
  network_.RunFor(std::chrono::seconds(2));
  leader_.TakeRequests();
  ASSERT_TRUE(RunUntil([this] { return leader_.requests == 1; }));
  ASSERT_TRUE(RunUntil([&] { return other.requests == 1; }));
  other.Reply("refused");
  network_.RunFor(std::chrono::seconds(1));
  EXPECT_FALSE(end_);
  kernel_.ReportEnd(4711);
  successor_.Publish();
  network_.RunFor(std::chrono::seconds(2));
  successor_.TakeQueries(std::nullopt);
  EXPECT_EQ(End().kind, Kind::kUnknown);
  EXPECT_EQ(successor_.queries, 1);
}

TEST_F(ClientsOfASuccessor, TakeOneThatLeadsAlreadyWhenTheExitIsNoticed) {
  ASSERT_NO_FATAL_FAILURE(RequestFromLeader("LowPower"));
  successor_.TakeQueries(Done(5, ""));
  kernel_.ReportEnd(4711);
  successor_.Publish();  // within the time in which a reply may still arrive
  EXPECT_EQ(End(std::chrono::seconds(2)).result.outcome, "done") << end_->result.reason;
  EXPECT_THAT(news_[0], HasSubstr("the controller (pid 4711, epoch 3)"));
}

TEST_F(ClientsOfASuccessor, DoNotTakeAControllerOfAnotherMachineForOne) {
  leader_.status.machine = "dog";
  successor_.status.machine = "cat";
  EXPECT_EQ(EndAfter(Done(5, "")).kind, Kind::kUnknown);
  EXPECT_THAT(end_->result.reason, HasSubstr("no successor"));
  EXPECT_EQ(successor_.queries, 0);
}

TEST_F(ClientsOfASuccessor, KnowTheirSwitchByItsNumber) {
  leader_.status.target = "LowPower";  // number 4: requested by another client as well
  EXPECT_EQ(EndAfter(Done(4, "")).result.outcome, "done");
  EXPECT_THAT(news_[0], HasSubstr("during switch 4 to LowPower"));
}

TEST_F(ClientsOfASuccessor, KnowTheNumberOfTheirOwnSwitchOnly) {
  ASSERT_NO_FATAL_FAILURE(RequestFromLeader("LowPower"));
  leader_.status.target = "SelfCheck";
  leader_.status.switch_number = 9;
  Publish();
  kernel_.ReportEnd(4711);
  ASSERT_TRUE(RunUntil([this] { return !news_.empty(); }));
  EXPECT_THAT(news_[0], HasSubstr("before it reported the number of the switch to LowPower"));
}

TEST_F(ClientsOfASuccessor, GetAnUnknownOutcomeWhereAnotherSwitchHasTheirNumber) {
  leader_.status.target = "LowPower";
  auto answer = Done(4, "arm");
  answer.reason = "the reason of the successor";
  EXPECT_EQ(EndAfter(answer).kind, Kind::kUnknown);
  EXPECT_THAT(end_->result.reason, HasSubstr("the reason of the successor"));
  EXPECT_EQ(end_->result.code, kCodeNetError);
}

TEST_F(ClientsOfASuccessor, GetAnUnknownOutcomeWhereNothingWasFound) {
  auto answer = Done(5, "");
  answer.found = false;
  answer.reason = "no record";
  actuator_ = "";
  EXPECT_EQ(EndAfter(answer).kind, Kind::kUnknown);
  EXPECT_THAT(end_->result.reason, HasSubstr("no record"));
}

TEST_F(ClientsOfASuccessor, DoNotTakeASwitchToAnotherStateForTheirs) {
  auto answer = Done(5, "");
  answer.target = "Active";
  EXPECT_EQ(EndAfter(answer).result.outcome, "interrupted");
  EXPECT_EQ(end_->result.code, kCodeNetError);
}

TEST_F(ClientsOfASuccessor, QueryASwitchUntilItIsNoLongerUnderWay) {
  successor_.under_way = 3;
  EXPECT_EQ(EndAfter(Done(5, "")).result.outcome, "done");
  EXPECT_EQ(successor_.queries, 4);
}

TEST_F(ClientsOfASuccessor, GetAnUnknownOutcomeFromOneThatDoesNotAnswer) {
  actuator_ = "arm";
  ASSERT_NO_FATAL_FAILURE(RequestFromOneThatExits());
  successor_.TakeQueries(std::nullopt);
  successor_.Publish();
  EXPECT_EQ(End(std::chrono::seconds(12)).kind, Kind::kUnknown);
  EXPECT_THAT(end_->result.reason, HasSubstr("did not report the outcome within 10 s"));
  EXPECT_EQ(end_->result.actuator, "arm");
  EXPECT_EQ(end_->result.code, kCodeNetError);
}

// The answer was on its way: the switch is not under way any more.
TEST_F(ClientsOfASuccessor, WaitForTheNextOneThoughTheExitedOneHasAnsweredThatItIsUnderWay) {
  ASSERT_NO_FATAL_FAILURE(RequestFromOneThatExits());
  successor_.TakeQueries(std::nullopt);
  successor_.Publish();
  ASSERT_TRUE(RunUntil([this] { return successor_.queries == 1; }));
  kernel_.ReportEnd(4712);
  successor_.ReplyUnderWay();
  EXPECT_EQ(End(Milliseconds(5500)).kind, Kind::kUnknown);
  EXPECT_THAT(end_->result.reason, HasSubstr("no successor within 5 s"));
}

TEST_F(ClientsOfASuccessor, DoNotRequestTheTearDownOfOneActuatorAgain) {
  actuator_ = "arm";
  ASSERT_NO_FATAL_FAILURE(RequestFromOneThatExits("TearDown"));
  successor_.TakeRequests();
  auto answer = Done(5, "arm");
  answer.target = "TearDown";
  successor_.TakeQueries(answer);
  successor_.Publish();
  EXPECT_EQ(End().result.outcome, "done");
  EXPECT_EQ(successor_.requests, 0);
}

TEST_F(ClientsOfASuccessor, QueryTheSameControllerWhereItLeadsAgain) {
  ASSERT_NO_FATAL_FAILURE(RequestFromLeader("LowPower", "desk"));  // it sends no heartbeat
  ASSERT_TRUE(RunUntil([this] { return !news_.empty(); }));
  leader_.TakeQueries(Done(5, ""));
  leader_.Publish();
  EXPECT_EQ(End(std::chrono::seconds(4)).result.outcome, "done") << end_->result.reason;
}

TEST_F(ClientsOfASuccessor, EndOnceAlsoWhereAnAnswerComesLater) {
  ASSERT_NO_FATAL_FAILURE(RequestFromOneThatExits());
  EXPECT_EQ(End().kind, Kind::kUnknown);
  leader_.Reply("done");
  network_.RunFor(std::chrono::minutes(2));
  EXPECT_EQ(ends_, 1);
}

TEST_F(ClientsOfASuccessor, EndOnceAfterTheirTime) {
  options_.timeout = std::chrono::seconds(5);
  ASSERT_NO_FATAL_FAILURE(RequestFromLeader("LowPower"));
  EXPECT_EQ(End(Milliseconds(5100)).kind, Kind::kUnknown);
  EXPECT_EQ(end_->result.code, kCodeTimeout);
  network_.RunFor(std::chrono::minutes(2));
  EXPECT_EQ(ends_, 1);
}

TEST_F(ClientsOfASuccessor, TakeAnAnswerThatArrivesAfterTheExitWithoutAWord) {
  ASSERT_NO_FATAL_FAILURE(RequestFromLeader("LowPower"));
  leader_.Reply("done");
  kernel_.ReportEnd(4711);
  EXPECT_EQ(End().kind, Kind::kAnswered);
  network_.RunFor(std::chrono::minutes(2));
  EXPECT_THAT(news_, IsEmpty());
  EXPECT_EQ(ends_, 1);
}

TEST_F(ClientsOfASuccessor, AreNotifiedAtOnceWhereASuccessorExitsAtOnceToo) {
  ASSERT_NO_FATAL_FAILURE(RequestFromLeader("LowPower"));
  kernel_.ReportEnd(4711);
  const Time exited = network_.now();
  successor_.Publish();
  network_.RunFor(Milliseconds(150));
  kernel_.ReportEnd(4712);
  ASSERT_TRUE(RunUntil([this] { return !news_.empty(); }));
  EXPECT_LT(network_.now() - exited, Milliseconds(250));
}

TEST_F(ClientsOfASuccessor, DoNotTakeTheEndOfTheMachineForAnotherSwitch) {
  ASSERT_NO_FATAL_FAILURE(RequestFromLeader("LowPower"));
  ExitStopped();
  EXPECT_EQ(End().kind, Kind::kUnknown);
}

TEST_F(ClientsOfASuccessor, DoNotTakeTheEndOfTheMachineForThatOfAnActuator) {
  actuator_ = "arm";
  ASSERT_NO_FATAL_FAILURE(RequestFromLeader("TearDown"));
  ExitStopped();
  EXPECT_EQ(End().kind, Kind::kUnknown);
}

TEST_F(ClientsOfASuccessor, DoNotTakeTheEndOfTheSuccessorForThatOfTheControllerThatTheyCalled) {
  ASSERT_NO_FATAL_FAILURE(RequestFromLeader("TearDown"));
  kernel_.ReportEnd(4711);
  successor_.status.epoch = leader_.status.epoch;  // without the disk of the first
  successor_.status.phase = "stopped";
  successor_.Publish();
  EXPECT_EQ(End().kind, Kind::kUnknown) << end_->result.outcome;
}

TEST_F(ClientsOfASuccessor, ReadInTheLastStatusWhatWasLeftOut) {
  ASSERT_NO_FATAL_FAILURE(RequestFromLeader("TearDown"));
  const auto add = [this](const std::string& name, bool degraded, std::int32_t code,
                          const std::string& message) {
    msg::ActuatorInfo info;
    info.name = name;
    info.degraded = degraded;
    info.code = code;
    info.message = message;
    leader_.status.actuators.push_back(info);
  };
  add("legs", false, 1, "of long ago");
  add("arm", true, 17, "does not answer");
  add("eye", true, 18, "is dark");
  leader_.status.degraded = {"arm", "eye"};
  ExitStopped();
  EXPECT_EQ(End(std::chrono::seconds(1)).kind, Kind::kReported);
  EXPECT_EQ(end_->result.outcome, "done-degraded");
  EXPECT_EQ(end_->result.degraded, leader_.status.degraded);
  EXPECT_EQ(end_->result.code, 17);
  EXPECT_EQ(end_->result.reason, "arm: does not answer");
}

// No process can be watched then: the client waited for a successor, and ended with an unknown
// outcome.
TEST_F(ClientsOfASuccessor, TakeTheLastStatusOfAControllerWhoseExitItComesAfter) {
  kernel_.exited = 4711;
  leader_.status.phase = "stopping";
  Request("TearDown", kSimHost, leader_.status);
  leader_.status.phase = "stopped";
  leader_.status.state = "TearDown";
  leader_.Publish();
  const SwitchEnd end = End(std::chrono::seconds(1));
  EXPECT_EQ(end.kind, Kind::kReported);
  EXPECT_EQ(end.result.outcome, "done");
  EXPECT_THAT(news_, IsEmpty());
}

// It was called at a lower epoch, and has learned of a higher one since.
TEST_F(ClientsOfASuccessor, TakeTheLastStatusOfTheControllerThatTheyCalledAtAnyEpoch) {
  leader_.status.phase = "stopping";
  Request("TearDown", kSimHost, leader_.status);
  leader_.status.epoch = 9;
  leader_.status.phase = "stopped";
  leader_.Publish();
  EXPECT_EQ(End(std::chrono::seconds(1)).kind, Kind::kReported);
  EXPECT_THAT(news_, IsEmpty());
}

TEST_F(ClientsOfASuccessor, KnowTheSwitchOfAControllerThatWasCalledInAnotherWay) {
  leader_.status.target = "LowPower";
  Request("LowPower", kSimHost, leader_.status);
  ASSERT_TRUE(RunUntil([this] { return !news_.empty(); }));
  EXPECT_THAT(news_[0], HasSubstr("during switch 4 to LowPower"));
}

// Of another version, or of another middleware.
TEST_F(ClientsOfASuccessor, EndAtOnceWithAnAnswerThatTheyCannotDecode) {
  const auto server =
      transport::RawServer::Make(leader_.node(), transport::MachineService("", "set_state"),
                                 std::string(msg::SetState::kTypeName),
                                 [](const msg::RequestId& id, std::span<const std::byte>,
                                    const auto& reply, transport::ParticipantId) {
                                   msg::Trigger::Response shorter;
                                   reply(transport::internal::EncodeEnvelope(id, shorter));
                                   return true;
                                 })
          .value();
  leader_.Publish();
  Request("LowPower");
  EXPECT_EQ(End(std::chrono::seconds(2)).kind, Kind::kUnknown);
  EXPECT_EQ(end_->result.reason, "the reply is malformed");
}

TEST_F(ClientsOfASuccessor, RequestFromAControllerWhoseServiceComesALittleLater) {
  options_.find = std::chrono::seconds(2);
  leader_.Publish();
  Request("LowPower");
  network_.RunFor(std::chrono::seconds(4));
  leader_.TakeRequests();
  EXPECT_TRUE(RunUntil([this] { return leader_.requests == 1; }, std::chrono::seconds(2)));
  EXPECT_FALSE(end_);
}

TEST_F(ClientsOfASuccessor, RequestNothingFromAControllerWhoseServiceComesTooLate) {
  options_.find = std::chrono::seconds(2);
  SentBy other(network_, "other", 1, 4714);  // has crashed, and its services are still matched
  other.TakeRequests();
  leader_.Publish();
  Request("LowPower");
  network_.RunFor(std::chrono::seconds(10));
  leader_.TakeRequests();
  EXPECT_EQ(End().kind, Kind::kUnknown);
  EXPECT_THAT(end_->result.reason, HasSubstr("nothing was requested"));
  EXPECT_EQ(leader_.requests, 0);
}

TEST_F(SwitchClients, EndWithinTheTimeToFindAController) {
  options_.find = std::chrono::seconds(5);
  Request("LowPower");
  EXPECT_THAT(End(Milliseconds(5100)).result.reason, HasSubstr("no controller found within 5 s"));
}

TEST_F(SwitchClients, EndWithinTheirTimeWhereTheyMayLookForAControllerForLonger) {
  options_.timeout = std::chrono::seconds(5);
  Request("LowPower");
  EXPECT_THAT(End(Milliseconds(5100)).result.reason, HasSubstr("no answer within 5 s"));
}

}  // namespace musher::testing::switch_client_test
