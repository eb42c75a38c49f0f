// In virtual time: what a page requests reaches the machine that is meant, and no other one; an
// emergency stop reaches each machine that may be meant.

#include "musher/view/live/robot_requests.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <optional>
#include <set>

#include "musher/base/host.hpp"
#include "musher/lifecycle/health/health.hpp"
#include "musher/lifecycle/machine/machine.hpp"
#include "musher/transport/sim/network.hpp"
#include "musher/view/live/machine_feed.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::view::robot_requests_test {

using std::chrono::seconds;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

constexpr int kDomain = 7;  // of the names that processes of this host hold
constexpr const char* kHeldNames = "requests-of-a-page";

class RequestsOfAPage : public ::testing::Test {
 protected:
  // A machine's controller, as a page sees it.
  struct Controller {
    std::unique_ptr<transport::Node> node;
    msg::MachineStatus last;
    std::unique_ptr<transport::Publisher<msg::MachineStatus>> status;
    std::unique_ptr<transport::Server<msg::GetHistory>> history;
    std::unique_ptr<transport::Server<msg::SetState>> set_state;
    std::unique_ptr<transport::Server<msg::RestartActuator>> restart;
    std::unique_ptr<transport::Server<msg::ReleaseEmergencyStop>> release;

    void Publish() { EXPECT_TRUE(status->Publish(last).ok()); }
  };
  // On a host of the machine's name.
  Controller Lead(const std::string& machine, const std::string& id, std::string host = "") {
    Controller controller{network_.MakeNode(machine + id), {}, {}, {}, {}, {}, {}};
    transport::Node& node = *controller.node;
    controller.status = transport::MakePublisher<msg::MachineStatus>(
                            node, transport::MachineStatusTopic(""), transport::kLatchedQos)
                            .value();
    controller.history =
        Serve<msg::GetHistory>(node, "get_history", [machine](const auto&, auto reply) {
          reply({machine, {}});
        });
    const auto is_meant = [own = MachineIdentity{machine, id}](const auto& request) {
      return SameMachine(own, {request.machine, request.machine_id});
    };
    controller.set_state = Serve<msg::SetState>(
        node, "set_state", [this, machine, is_meant](const auto& request, auto reply) {
          if (!is_meant(request)) return;
          done_.push_back(machine + " to " + request.target);
          by_.insert(request.by);
          msg::SetState::Response response;
          response.outcome = "done";
          reply(response);
        });
    controller.restart = Serve<msg::RestartActuator>(
        node, "restart_actuator", [this, machine, is_meant](const auto& request, auto reply) {
          if (!is_meant(request)) return;
          done_.push_back(machine + " restarts " + request.actuator);
          by_.insert(request.by);
          reply({});
        });
    controller.release = Serve<msg::ReleaseEmergencyStop>(
        node, "release_emergency_stop", [this, machine, is_meant](const auto& request, auto reply) {
          if (!is_meant(request)) return;
          done_.push_back(machine + " releases");
          by_.insert(request.by);
          reply({});
        });
    controller.last.machine = machine;
    controller.last.machine_id = id;
    controller.last.host = host.empty() ? machine : std::move(host);
    controller.last.pid = getpid();
    controller.last.actuators = {Actuator("legs")};
    controller.Publish();
    network_.RunFor(Milliseconds(100));
    return controller;
  }
  template <msg::Service S>
  static std::unique_ptr<transport::Server<S>> Serve(transport::Node& node, const char* service,
                                                     typename transport::Server<S>::Handler run) {
    return transport::MakeServer<S>(node, transport::MachineService("", service), std::move(run))
        .value();
  }
  static msg::ActuatorInfo Actuator(const std::string& name, const char* protocol = "musher") {
    msg::ActuatorInfo actuator;
    actuator.name = name;
    actuator.presence = "present";
    actuator.health = HealthName(Health::kWell);
    actuator.protocol = protocol;
    return actuator;
  }

  // The page of a program that a person has started, for the machine of that word.
  void Open(const std::string& word = "") {
    feed_ = MachineFeed::Make(*desk_, {"", "desk", word},
                              {[](const auto&, const auto&) {}, [](const auto&) {},
                               [this] { requests_->OnStatus(); }})
                .value();
    RobotRequests::Options options{"", "desk", false};
    options.stops = {kHeldNames, kDomain, false, own_};
    options.machine = word;
    options.places = [this] { return places_; };
    if (searches_) {
      options.find = [this](auto on_found) { searching_.push_back(std::move(on_found)); };
    }
    requests_ = std::make_unique<RobotRequests>(
        *desk_, options, [this]() -> const LeaderWatch& { return feed_->leader(); });
  }
  // The search that is under way ends.
  void Find(const std::vector<MachineHere>& machines) {
    ASSERT_EQ(searching_.size(), 1U) << "one after the other";
    const auto on_found = std::exchange(searching_, {}).front();
    on_found(machines);
  }
  http::Respond Collect() {
    return [this](const http::Response& response) {
      bodies_.push_back(std::to_string(response.status) + " " + *response.body);
    };
  }
  void Stop(const MachineIdentity& shown = {}) {
    requests_->Stop({"alice", shown}, "a person is near", Collect());
    network_.RunFor(Milliseconds(200));
  }
  // All requests that act but the stop; their answers.
  std::vector<std::string> Act(const MachineIdentity& shown = {}) {
    const RobotRequests::Caller caller{"alice", shown};
    bodies_.clear();
    requests_->Set(caller, "Active", "", Collect());
    requests_->Restart(caller, "legs", Collect());
    requests_->Release(caller, {}, Collect());
    network_.RunFor(seconds(1));
    return bodies_;
  }
  // What a node of another process gets of stops: "machine id" of each.
  struct Receiver {
    std::vector<std::string> stops;
    std::vector<std::uint64_t> ids;  // of them
    std::set<transport::EndpointId> writers;
    std::unique_ptr<transport::Subscription> subscription;
  };
  std::unique_ptr<Receiver> Receive(transport::Node& node) {
    auto receiver = std::make_unique<Receiver>();
    transport::SubscriptionEvents events;
    events.on_writer_lost = [to = receiver.get()](transport::EndpointId writer) {
      to->writers.erase(writer);
    };
    receiver->subscription = transport::MakeSubscription<msg::EmergencyStop>(
                                 node, transport::EmergencyStopTopic(""),
                                 [to = receiver.get()](const msg::EmergencyStop& stop,
                                                       const transport::SampleInfo& info) {
                                   to->writers.insert(info.writer);
                                   to->stops.push_back(stop.machine + " " + stop.machine_id);
                                   to->ids.push_back(stop.id);
                                 },
                                 transport::kLatchedFromManyQos, std::move(events))
                                 .value();
    return receiver;
  }

  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> desk_ = network_.MakeNode("desk");
  std::vector<MachineHere> own_;      // the machines of the page's host
  std::vector<MachinePlace> places_;  // where they run there
  bool searches_ = false;             // … are found by a search
  std::vector<std::function<void(std::vector<MachineHere>)>> searching_;
  std::vector<std::string> bodies_;  // with their statuses of HTTP
  std::vector<std::string> done_;    // by the controllers
  std::set<std::string> by_;         // the requesters of that
  std::unique_ptr<RobotRequests> requests_;
  std::unique_ptr<MachineFeed> feed_;
};

TEST_F(RequestsOfAPage, StopTheMachineThatItShows) {
  Open();
  const auto dog = Lead("dog", "uuid-a");
  const auto cat = Lead("cat", "uuid-b");
  const auto received = Receive(*cat.node);
  Stop();
  EXPECT_THAT(received->stops, ElementsAre("dog uuid-a"));
}

TEST_F(RequestsOfAPage, AreAnsweredByTheMachineThatItShows) {
  Open();
  const auto dog = Lead("dog", "uuid-a");
  const auto cat = Lead("cat", "uuid-b");
  for (int i = 0; i < 5; ++i) requests_->History(10, Collect());
  network_.RunFor(seconds(1));
  EXPECT_THAT(bodies_, ::testing::Each(R"(200 {"error":"dog","entries":[]})"));
  EXPECT_EQ(bodies_.size(), 5U);
}

TEST_F(RequestsOfAPage, StopTheMachineThatItShowsAlsoWhileItsHeartbeatIsLostAndAnotherOneReports) {
  Open();
  const auto dog = Lead("dog", "uuid-a");
  network_.RunFor(seconds(5));  // without a heartbeat
  ASSERT_FALSE(feed_->status());
  const auto cat = Lead("cat", "uuid-b");
  const auto received = Receive(*cat.node);
  Stop();
  EXPECT_THAT(received->stops, ElementsAre("dog "));
  EXPECT_THAT(Act(), ::testing::Each(HasSubstr("503 ")));
  EXPECT_THAT(done_, IsEmpty());
}

TEST_F(RequestsOfAPage, ActOnNoOtherMachineWhileThatOfThisHostDoesNotRun) {
  own_ = {{{"dog", "uuid-a"}}};
  Open();
  const auto cat = Lead("cat", "uuid-b");
  const auto answers = Act();
  ASSERT_EQ(answers.size(), 3U);
  EXPECT_THAT(answers, ::testing::Each(AllOf(
                           HasSubstr("409 "),
                           HasSubstr("the machine of this host, dog (id uuid-a), does not run; "
                                     "found cat (id uuid-b). Nothing was done"))));
  EXPECT_THAT(done_, IsEmpty());
}

// A page without the namespace of its robot moved the one in range.
TEST_F(RequestsOfAPage, ActOnNoOtherMachineWhileThatOfThisHostRunsInAnotherNamespace) {
  places_ = {{kDomain, "dogA"}};
  Open();
  const auto cat = Lead("cat", "uuid-b");
  const auto answers = Act();
  ASSERT_EQ(answers.size(), 3U);
  EXPECT_THAT(answers, ::testing::Each(AllOf(
                           HasSubstr("409 "),
                           HasSubstr("the machine of this host runs in namespace 'dogA'; "
                                     "found cat (id uuid-b) in the default namespace. Nothing was "
                                     "done"))));
  EXPECT_THAT(done_, IsEmpty());
  places_ = {{kDomain + 1, "dogA"}, {kDomain, ""}};
  EXPECT_EQ(Act().size(), 3U) << "of another domain, or in its own namespace";
  EXPECT_THAT(done_, ::testing::SizeIs(3));
}

TEST_F(RequestsOfAPage, StopEveryMachineWhileThatOfThisHostDoesNotRun) {
  own_ = {{{"dog", "uuid-a"}}};
  Open();
  const auto cat = Lead("cat", "uuid-b");
  const auto received = Receive(*cat.node);
  Stop();
  EXPECT_THAT(received->stops, ElementsAre(" "));
}

TEST_F(RequestsOfAPage, ActOnTheMachineOfThisHostOnceItRuns) {
  own_ = {{{"dog", "uuid-a"}}};
  Open();
  const auto cat = Lead("cat", "uuid-b");
  const auto dog = Lead("dog", "uuid-a", "desk");
  EXPECT_EQ(Act().size(), 3U);
  EXPECT_THAT(done_, UnorderedElementsAre("dog to Active", "dog restarts legs", "dog releases"));
  const auto received = Receive(*cat.node);
  Stop();
  EXPECT_THAT(received->stops, ElementsAre("dog uuid-a"));
}

// What status and history show.
TEST_F(RequestsOfAPage, NameThePersonToTheController) {
  Open();
  const auto dog = Lead("dog", "uuid-a");
  EXPECT_EQ(Act().size(), 3U);
  EXPECT_THAT(by_, ElementsAre("alice on the page"));
}

TEST_F(RequestsOfAPage, ActOnAnotherMachineThatAPersonHasNamed) {
  own_ = {{{"dog", "uuid-a"}}};
  Open("cat");
  const auto cat = Lead("cat", "uuid-b");
  EXPECT_EQ(Act().size(), 3U);
  EXPECT_THAT(done_, UnorderedElementsAre("cat to Active", "cat restarts legs", "cat releases"));
  const auto received = Receive(*cat.node);
  Stop();
  EXPECT_THAT(received->stops, ElementsAre("cat uuid-b"));
}

TEST_F(RequestsOfAPage, WaitForTheSearchOfThisHostBeforeTheyActOnAnotherOne) {
  searches_ = true;
  Open();
  const auto cat = Lead("cat", "uuid-b");
  EXPECT_THAT(Act(), ::testing::Each(HasSubstr("this host is still being searched")));
  EXPECT_THAT(done_, IsEmpty());
  const auto received = Receive(*cat.node);
  Stop();
  EXPECT_THAT(received->stops, ElementsAre(" "));
  Find({});
  Act();
  EXPECT_EQ(done_.size(), 3U);
}

TEST_F(RequestsOfAPage, ActOnNoneOfTwoMachinesOfOneName) {
  Open("dog");
  const auto dog = Lead("dog", "uuid-a");
  const auto copy = Lead("dog", "uuid-c");
  const auto answers = Act();
  ASSERT_EQ(answers.size(), 3U);
  EXPECT_THAT(answers, ::testing::Each(
                           AllOf(HasSubstr("409 "), HasSubstr("several machines are named dog: "),
                                 HasSubstr("dog (id uuid-a)"), HasSubstr("dog (id uuid-c)"),
                                 HasSubstr(". Nothing was done"))));
  EXPECT_THAT(done_, IsEmpty());
  const auto received = Receive(*copy.node);
  Stop();
  EXPECT_THAT(received->stops, ElementsAre("dog "));
}

// The page of a controller has its name; the controller of this host starts yet.
TEST_F(RequestsOfAPage, ActOnNoCopyOfTheMachineOfThisHostThatIsFoundBeforeIt) {
  own_ = {{{"dog", "uuid-a"}}};
  Open("dog");
  const auto copy = Lead("dog", "uuid-c");
  const auto answers = Act({"dog", "uuid-c"});
  ASSERT_EQ(answers.size(), 3U);
  EXPECT_THAT(answers, ::testing::Each(AllOf(
                           HasSubstr("409 "),
                           HasSubstr("the machine of this host, dog (id uuid-a), does not run; "
                                     "found dog (id uuid-c). Nothing was done"))));
  EXPECT_THAT(done_, IsEmpty());
  const auto received = Receive(*copy.node);
  Stop();
  EXPECT_THAT(received->stops, ElementsAre("dog ")) << "for both";
  const auto dog = Lead("dog", "uuid-a", "desk");
  Act({"dog", "uuid-a"});
  EXPECT_EQ(done_.size(), 3U);
}

TEST_F(RequestsOfAPage, ActOnNoMachineOfTheSameNameThatAnswersInItsPlace) {
  Open();
  std::optional dog(Lead("dog", "uuid-a"));
  dog.reset();
  network_.RunFor(seconds(20));
  const auto copy = Lead("dog", "uuid-c");
  ASSERT_TRUE(feed_->status());
  EXPECT_THAT(Act(), ::testing::Each(HasSubstr("several machines are named dog: dog (id uuid-a); "
                                               "dog (id uuid-c). Nothing was done")));
  EXPECT_THAT(done_, IsEmpty());
  const auto received = Receive(*copy.node);
  Stop();
  EXPECT_THAT(received->stops, ElementsAre(" "));
}

TEST_F(RequestsOfAPage, StopWithTheBeginningOfAnIdEachMachineThatHasIt) {
  Open("uuid-a");
  const auto cat = Lead("cat", "uuid-b");
  const auto received = Receive(*cat.node);
  Stop();
  EXPECT_THAT(received->stops, ElementsAre("uuid-a ")) << "none was found yet";
  const auto dog = Lead("dog", "uuid-a1");
  Act();
  EXPECT_THAT(done_, UnorderedElementsAre("dog to Active", "dog restarts legs", "dog releases"));
  received->stops.clear();
  Stop();
  EXPECT_THAT(received->stops, ElementsAre("dog uuid-a1"));
  received->stops.clear();
  network_.RunFor(seconds(5));  // without a heartbeat
  ASSERT_FALSE(feed_->status());
  Stop();
  EXPECT_THAT(received->stops, ElementsAre("dog uuid-a1"));
}

TEST_F(RequestsOfAPage, ActOnNoOtherMachineThanTheOneThatAPersonSees) {
  Open();
  const auto cat = Lead("cat", "uuid-b");
  EXPECT_THAT(Act({"dog", "uuid-a"}),
              ::testing::Each(AllOf(HasSubstr("409 "),
                                    HasSubstr("the page shows dog (id uuid-a), but cat (id uuid-b)"
                                              " is followed now. Nothing was done"))));
  EXPECT_THAT(done_, IsEmpty());
  const auto received = Receive(*cat.node);
  Stop({"dog", "uuid-a"});
  const std::set<std::string> stopped(received->stops.begin(), received->stops.end());
  EXPECT_THAT(stopped, ElementsAre("cat uuid-b", "dog uuid-a"));
  Act({"cat", "uuid-b"});
  EXPECT_EQ(done_.size(), 3U);
}

TEST_F(RequestsOfAPage, StopEveryMachineWhereActuatorsOfAnotherOneRunHere) {
  const auto legs = NameLock::Acquire(NameLock::NameOf(kDomain, kHeldNames, "legs"));
  ASSERT_TRUE(legs);
  Open();
  auto cat = Lead("cat", "uuid-b");
  const auto received = Receive(*cat.node);
  Stop();
  EXPECT_THAT(received->stops, ElementsAre(" "));
  received->stops.clear();
  cat.last.actuators.front().host = "desk";
  cat.Publish();
  network_.RunFor(Milliseconds(100));
  Stop();
  EXPECT_THAT(received->stops, ElementsAre("cat uuid-b")) << "they are its own";
}

TEST_F(RequestsOfAPage, ReportAStopThatTheControllerHasNotLatched) {
  Open();
  auto dog = Lead("dog", "uuid-a");
  dog.last.actuators.clear();
  dog.Publish();
  Stop();
  EXPECT_THAT(bodies_, IsEmpty());
  for (int i = 0; i < 6; ++i) {
    dog.Publish();
    network_.RunFor(Milliseconds(500));
  }
  EXPECT_THAT(bodies_, ElementsAre(AllOf(HasSubstr(R"(200 {"code":101,)"),
                                         HasSubstr("the controller has not latched it"))));
}

TEST_F(RequestsOfAPage, ReportAnActuatorThatHasNoEmergencyStop) {
  Open();
  auto dog = Lead("dog", "uuid-a");
  dog.last.actuators = {Actuator("lidar", "ros2_lifecycle")};
  dog.last.emergency_stop = true;
  dog.last.emergency_stop_by = "alice";
  dog.Publish();
  Stop();
  for (int i = 0; i < 6; ++i) {
    dog.Publish();
    network_.RunFor(Milliseconds(500));
  }
  EXPECT_THAT(bodies_,
              ElementsAre(AllOf(HasSubstr(R"(200 {"code":101,)"),
                                HasSubstr("not stopped: lidar (emergency stop not supported"))));
}

// The button said that the robot is stopped, which an earlier stop held, and the new one was lost.
TEST_F(RequestsOfAPage, ReportAStopThatHasNotArrivedBesideAnEarlierOne) {
  Open();
  auto dog = Lead("dog", "uuid-a");
  dog.last.actuators.clear();
  dog.last.emergency_stop = true;
  dog.last.emergency_stop_by = "bob";
  dog.last.stop_ids = {"0000000000000003"};
  dog.Publish();
  Stop();
  for (int i = 0; i < 6; ++i) {
    dog.Publish();
    network_.RunFor(Milliseconds(500));
  }
  EXPECT_THAT(bodies_, ElementsAre(AllOf(HasSubstr(R"(200 {"code":101,)"),
                                         HasSubstr("this stop has not arrived"))));
}

// `musher estop` said so, and the button said no more than that the robot is stopped.
TEST_F(RequestsOfAPage, SayThatAStopIsOnNoDiskWhileNoControllerLeads) {
  own_ = {{.identity = {"dog", "uuid-a"}, .actuators = {"legs"}}};
  Open();
  const auto node = network_.MakeNode("legs");
  const auto statuses = transport::MakePublisher<msg::ActuatorStatus>(
                            *node, transport::ActuatorStatusTopic(""), transport::kLatchedQos)
                            .value();
  const auto stops = transport::SubscribeToStops(
      *node, "", [&](const msg::EmergencyStop& stop, const transport::SampleInfo&) {
        msg::ActuatorStatus legs;
        legs.name = "legs";
        legs.machine = "dog";
        legs.machine_id = "uuid-a";
        legs.emergency_stop = stop.id;
        EXPECT_TRUE(statuses->Publish(legs).ok());
      });
  network_.RunFor(Milliseconds(500));
  Stop();
  network_.RunFor(RobotRequests::kStopTime);
  EXPECT_THAT(bodies_, ElementsAre(AllOf(HasSubstr(R"(200 {"code":0,)"),
                                         HasSubstr("not on disk: no controller leads"))));
}

TEST_F(RequestsOfAPage, StopWithoutWaitingForASearchOfThisHostThatHangs) {
  searches_ = true;
  Open();
  const auto other = network_.MakeNode("legs");
  const auto received = Receive(*other);
  const auto legs = transport::MakePublisher<msg::ActuatorStatus>(
                        *other, transport::ActuatorStatusTopic(""), transport::kLatchedQos)
                        .value();
  msg::ActuatorStatus status;
  status.name = "legs";
  status.emergency_stop = 1;  // it is stopped
  ASSERT_TRUE(legs->Publish(status).ok());
  Stop();
  Stop();
  EXPECT_EQ(received->stops.size(), 2U);
  network_.RunFor(seconds(4));
  EXPECT_THAT(bodies_,
              ElementsAre(HasSubstr("this host is still being searched for its actuators"),
                          HasSubstr("this host is still being searched for its actuators")));
  bodies_.clear();
  Find({});  // that of the beginning, which says nothing of later
  Stop();
  network_.RunFor(seconds(2));
  status.other_stops = received->ids;
  ASSERT_TRUE(legs->Publish(status).ok());
  network_.RunFor(Milliseconds(100));
  EXPECT_THAT(bodies_, IsEmpty());
  Find({});
  Find({});
  EXPECT_THAT(bodies_, ElementsAre(HasSubstr(R"(200 {"code":0,"reason":"not on disk)")));
}

TEST_F(RequestsOfAPage, KeepOnlyTheLastStops) {
  Open();
  const auto dog = Lead("dog", "uuid-a");
  const auto received = Receive(*dog.node);
  constexpr std::size_t kStops = 50;
  for (std::size_t i = 0; i < kStops; ++i) {
    requests_->Stop({"a person without a login"}, "", Collect());
  }
  network_.RunFor(Milliseconds(500));
  EXPECT_LE(received->writers.size(), RobotRequests::kMostStops);
  EXPECT_EQ(bodies_.size(), kStops - RobotRequests::kMostStops);
  EXPECT_THAT(bodies_, ::testing::Each(HasSubstr("too many stops were sent at once")));
  bodies_.clear();
  network_.RunFor(seconds(4));
  EXPECT_EQ(bodies_.size(), RobotRequests::kMostStops) << "each of them is answered";
  bodies_.clear();
  Stop();  // instead of an answered one
  EXPECT_THAT(bodies_, IsEmpty());
  EXPECT_LE(received->writers.size(), RobotRequests::kMostStops);
  EXPECT_GE(received->writers.size(), 1U);
}

}  // namespace musher::view::robot_requests_test
