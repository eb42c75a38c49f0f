// From the start of the processes to all active, and a switch of all: ROS 2 managed nodes under a
// Musher controller and under a manager like nav2's (one node after the other, without bonds), in
// turns, and as many Musher actuators; and, as lower bounds, as many processes that answer one call
// of plain Cyclone DDS each, and a switch whose requests go to all nodes at once.
//
//   benchmark_startup [NODES [TURNS]]

#include <dds/dds.h>
#include <musher_idl.h>

#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "musher/controller/machine_controller.hpp"
#include "musher/test/benchmark/common/child.hpp"
#include "musher/test/benchmark/common/fleet.hpp"
#include "musher/test/benchmark/common/plain_service.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/test/contract/plain_lifecycle_manager.hpp"

namespace musher::benchmark {
namespace {

using Clock = std::chrono::steady_clock;

struct Times {
  std::vector<double> start_s;
  std::vector<double> switch_ms;  // deactivate all, activate all, and so on
};
constexpr int kSwitches = 20;  // after each start

void UnderMusher(const Fleet& fleet, Times& times) {
  NextDomain();
  const auto begin = Clock::now();
  MachineController controller;
  if (!controller.Init(fleet.config_file())) Fail("no controller");
  if (!controller.AwaitSetUp()) Fail("not all are set up");
  MustBeDone(controller.Switch("SelfCheck"));
  MustBeDone(controller.Switch("Active"));
  times.start_s.push_back(ToSeconds(Clock::now() - begin));
  for (int i = 0; i < kSwitches; ++i) {
    const auto switched = Clock::now();
    MustBeDone(controller.Switch(i % 2 == 0 ? kDeActive : kActive));
    times.switch_ms.push_back(ToSeconds(Clock::now() - switched) * 1000);
  }
  static_cast<void>(controller.Switch("TearDown").done());  // ends its processes
}

// The least that a switch of all nodes takes: each has its request at once, and the last reply ends
// it. No order, no query of the state, no event is read.
class RequestsAtOnce {
 public:
  RequestsAtOnce(testing::PlainParticipant& participant, const std::vector<std::string>& nodes)
      : waitset_(dds_create_waitset(participant.entity())) {
    for (const std::string& node : nodes) {
      End end;
      end.writer = participant.Writer(lifecycle_msgs_srv_dds__ChangeState_Request__desc,
                                      "rq/nav/" + node + "/change_stateRequest");
      end.reader = participant.Reader(lifecycle_msgs_srv_dds__ChangeState_Response__desc,
                                      "rr/nav/" + node + "/change_stateReply", [] {});
      if (!participant.SpinUntilMatched(end.writer, end.reader)) Fail("no node " + node);
      dds_get_instance_handle(end.writer, &end.id);
      dds_waitset_attach(waitset_, dds_create_readcondition(end.reader, DDS_ANY_STATE),
                         static_cast<dds_attach_t>(ends_.size()));
      ends_.push_back(end);
    }
  }

  void Switch(std::uint8_t transition) {
    ++sequence_;
    for (const End& end : ends_) {
      std::string none;
      lifecycle_msgs_srv_dds__ChangeState_Request_ request{};
      request.client_id = end.id;
      request.sequence_number = sequence_;
      request.transition.id = transition;
      request.transition.label = none.data();
      dds_write(end.writer, &request);
    }
    std::vector<dds_attach_t> ready(ends_.size());
    for (std::size_t replies = 0; replies < ends_.size();) {
      const auto count = dds_waitset_wait(waitset_, ready.data(), ready.size(), DDS_SECS(20));
      if (count <= 0) Fail("a request has no reply");
      for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
        const End& end = ends_[static_cast<std::size_t>(ready[i])];
        testing::TakeAll<lifecycle_msgs_srv_dds__ChangeState_Response_>(
            end.reader, [&](const auto& reply) {
              if (reply.client_id == end.id && reply.sequence_number == sequence_) ++replies;
            });
      }
    }
  }

 private:
  struct End {
    dds_entity_t writer = 0;
    dds_entity_t reader = 0;
    std::uint64_t id = 0;
  };

  const dds_entity_t waitset_;
  std::vector<End> ends_;
  std::int64_t sequence_ = 0;
};

// `at_once`: its switches only.
void UnderNav2(const std::vector<std::string>& nodes, Times& times, Times& at_once) {
  constexpr std::uint8_t kActivate = 3;
  constexpr std::uint8_t kDeactivate = 4;
  const int domain = NextDomain();
  const Child::Environment environment = {{"CYCLONEDDS_URI", testing::kLoopback},
                                          {"RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp"}};
  const auto begin = Clock::now();
  std::vector<std::unique_ptr<Child>> processes;
  for (const std::string& node : nodes) {
    processes.push_back(std::make_unique<Child>(
        std::vector<std::string>{Program("ros_server_peer"), "nav/" + node}, environment));
  }
  testing::PlainNav2Manager manager(domain, "nav", nodes);
  if (!manager.Startup()) Fail("the plain manager: " + manager.errors().front());
  times.start_s.push_back(ToSeconds(Clock::now() - begin));
  for (int i = 0; i < kSwitches; ++i) {
    const auto switched = Clock::now();
    if (!(i % 2 == 0 ? manager.Pause() : manager.Resume())) Fail("the plain manager's switch");
    times.switch_ms.push_back(ToSeconds(Clock::now() - switched) * 1000);
  }
  RequestsAtOnce requests(manager.participant(), nodes);
  for (int i = 0; i < kSwitches; ++i) {
    const auto switched = Clock::now();
    requests.Switch(i % 2 == 0 ? kDeactivate : kActivate);
    at_once.switch_ms.push_back(ToSeconds(Clock::now() - switched) * 1000);
  }
}

// One request and one reply for each process, which has two endpoints.
void WithPlainCyclone(const std::vector<std::string>& names, Times& times) {
  const int domain = NextDomain();
  const auto begin = Clock::now();
  std::vector<std::unique_ptr<Child>> servers;
  for (const std::string& name : names) {
    servers.push_back(std::make_unique<Child>(std::vector<std::string>{
        Program("benchmark_plain_server"), name, std::to_string(domain), ""}));
  }
  const PlainParticipant participant(domain);
  std::vector<std::unique_ptr<PlainEnd>> ends;
  for (const std::string& name : names) {
    ends.push_back(std::make_unique<PlainEnd>(participant, name, PlainEnd::Role::kClient));
  }
  for (const auto& end : ends) end->CallUntil([&] { return end->Take() == 0; });
  times.start_s.push_back(ToSeconds(Clock::now() - begin));
}

void Measure(int count, int turns) {
  const Table table(std::to_string(count) + " processes: from their start to all active; a switch");
  const auto node = [](const Fleet&, const std::string& name) {
    return "protocol = \"ros2_lifecycle\"\n" + CommandKey({Program("ros_server_peer"), name});
  };
  Times musher, nav2, at_once, actuators, plain;
  for (int turn = 0; turn < turns; ++turn) {
    const Fleet nodes(node, count);
    UnderMusher(nodes, musher);
    UnderNav2(nodes.names(), nav2, at_once);
    UnderMusher(Fleet(count, true), actuators);
    WithPlainCyclone(nodes.names(), plain);
  }
  table.Row("start of ROS 2 nodes, Musher", musher.start_s, "s");
  table.Row("start of ROS 2 nodes, a manager like nav2's", nav2.start_s, "s");
  table.Row("start, Musher / the other manager", Ratios(musher.start_s, nav2.start_s), "×");
  table.Row("start of Musher actuators", actuators.start_s, "s");
  table.Row("start of plain Cyclone processes", plain.start_s, "s");
  table.Row("start, actuators / plain Cyclone", Ratios(actuators.start_s, plain.start_s), "×");
  table.Row("switch of ROS 2 nodes, Musher", musher.switch_ms, "ms");
  table.Row("switch of ROS 2 nodes, a manager like nav2's", nav2.switch_ms, "ms");
  table.Row("switch, Musher / the other manager", Ratios(musher.switch_ms, nav2.switch_ms), "×");
  table.Row("switch of ROS 2 nodes, all requests at once", at_once.switch_ms, "ms");
  table.Row("switch, Musher / all requests at once", Ratios(musher.switch_ms, at_once.switch_ms),
            "×");
  table.Row("switch, all requests at once / the other manager",
            Ratios(at_once.switch_ms, nav2.switch_ms), "×");
  table.Row("switch of Musher actuators", actuators.switch_ms, "ms");
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  musher::benchmark::Measure(argc > 1 ? std::atoi(argv[1]) : 32, argc > 2 ? std::atoi(argv[2]) : 5);
}
