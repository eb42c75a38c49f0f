// A process with an identity, or without one, that publishes, subscribes and calls for a test:
//
//   security_peer <domain> <keys or -> <identity> ACTION...
//
//   publish:<topic>[:<partition>]    "hello" every 10 ms, as long as it runs
//   subscribe:<topic>[:<partition>]  prints "received <topic> <partition>" for each sample
//   command:<actuator>               commands the actuator to Error, like a controller
//   serve:<actuator>                 prints "called" for each command to the actuator, and replies
//   set:<state>                      requests the controller to switch the machine
//   trigger:<service>                calls a service of CyberDog's manager without parameters
//   stop                             engages the emergency stop
//   announce                         announces itself as a controller of a very high epoch
//   watch                            prints "machine <state>" for each status of the machine
//   heartbeats                       prints "heartbeat <actuator>" for each CyberDog heartbeat,
//                                    which every actuator publishes
//   pose:<actuator>[:<partition>]    publishes a status and heartbeats of that actuator
//
// Prints "ready" when all actions have begun, and "refused <action>: <reason>" for each action that
// is refused; the others continue.

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <list>
#include <string>
#include <vector>

#include "musher/base/host.hpp"
#include "musher/messages/musher_msgs/actuator_command.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"
#include "musher/messages/protocol/heartbeats.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/transport/service.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::transport {
namespace {

constexpr Duration kPeriod = Milliseconds(10);
constexpr Duration kWaitLimit = std::chrono::seconds(10);
constexpr std::uint64_t kHighEpoch = 1'000'000;

std::vector<std::string> Split(const std::string& text) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t end = 0; end != std::string::npos; begin = end + 1) {
    end = text.find(':', begin);
    parts.push_back(text.substr(begin, end - begin));
  }
  parts.resize(3);
  return parts;
}

class Peer {
 public:
  Peer(Node& node, std::string name_space) : node_(node), name_space_(std::move(name_space)) {}

  Result<> Do(const std::string& action) {
    const std::vector<std::string>& words = kept_.emplace_back(Split(action));
    if (words[0] == "publish") return Publish<msg::String>(words[1], {"hello"}, words[2]);
    if (words[0] == "subscribe") return Subscribe(words[1], words[2]);
    if (words[0] == "command") return Command(words[1]);
    if (words[0] == "serve") return Serve(words[1]);
    if (words[0] == "set") {
      msg::SetState::Request request;
      request.target = words[1];
      return Call<msg::SetState>(MachineService(name_space_, "set_state"), request);
    }
    if (words[0] == "trigger") {
      return Call<msg::Trigger>(ResolveName(name_space_, words[1]), {});
    }
    if (words[0] == "stop") {
      const msg::EmergencyStop stop{7, true, "security_peer", "a test"};
      return Publish<msg::EmergencyStop>(EmergencyStopTopic(name_space_), stop, "");
    }
    if (words[0] == "announce") {
      msg::ControllerHeartbeat heartbeat;
      heartbeat.epoch = kHighEpoch;
      return Publish<msg::ControllerHeartbeat>(ControllerHeartbeatTopic(name_space_), heartbeat,
                                               "");
    }
    if (words[0] == "watch") {
      return Watch<msg::MachineStatus>(
          MachineStatusTopic(name_space_), kLatchedQos,
          [](const msg::MachineStatus& m) { return "machine " + m.state; });
    }
    if (words[0] == "heartbeats") {
      return Watch<msg::Heartbeats>(ResolveName(name_space_, "manager_heartbeats"),
                                    kSystemDefaultQos,
                                    [](const msg::Heartbeats& m) { return "heartbeat " + m.name; });
    }
    if (words[0] == "pose") return Pose(words[1], words[2]);
    return Error{kCodeParametersInvalid, "no such action"};
  }

 private:
  template <class M>
  Result<> Publish(const std::string& topic, const M& message, const std::string& partition) {
    Qos qos = kLatchedQos;
    qos.partition = partition;
    auto publisher = MakePublisher<M>(node_, topic, qos);
    if (!publisher) return publisher.error();
    const std::shared_ptr<Publisher<M>> shared = std::move(publisher).value();
    owned_.push_back(node_.loop().Every(
        kPeriod, [shared, message] { static_cast<void>(shared->Publish(message)); }));
    return Ok();
  }

  Result<> Subscribe(const std::string& topic, const std::string& partition) {
    Qos qos = kDefaultQos;
    qos.partition = partition;
    auto subscription = MakeSubscription<msg::String>(
        node_, topic,
        [topic](const msg::String&, const SampleInfo& info) {
          std::cout << "received " << topic << " " << info.partition.value_or("-") << std::endl;
        },
        qos);
    if (!subscription) return subscription.error();
    subscriptions_.push_back(std::move(subscription).value());
    return Ok();
  }

  template <class M>
  Result<> Watch(const std::string& topic, const Qos& qos, std::string (*describe)(const M&)) {
    auto subscription = MakeSubscription<M>(
        node_, topic,
        [describe](const M& message, const SampleInfo&) {
          std::cout << describe(message) << std::endl;
        },
        qos);
    if (!subscription) return subscription.error();
    subscriptions_.push_back(std::move(subscription).value());
    return Ok();
  }

  template <class S>
  Result<> Call(const std::string& service, const typename S::Request& request) {
    auto client = MakeClient<S>(node_, service);
    if (!client) return client.error();
    const std::shared_ptr<Client<S>> shared = std::move(client).value();
    owned_.push_back(node_.loop().Every(kPeriod, [shared, request] {
      shared->Call(request, kWaitLimit, [](const auto& reply) {
        if (reply) std::cout << "answered" << std::endl;
      });
    }));
    return Ok();
  }

  Result<> Command(const std::string& actuator) {
    msg::ActuatorCommand::Request request;
    request.kind = msg::ActuatorCommand::kKindSwitch;
    request.epoch = kHighEpoch;
    request.number = 1;
    request.target = "OTA";
    request.budget_ns = kWaitLimit.count();
    return Call<msg::ActuatorCommand>(CommandService(name_space_, actuator), request);
  }

  Result<> Serve(const std::string& actuator) {
    auto server = MakeServer<msg::ActuatorCommand>(
        node_, CommandService(name_space_, actuator),
        [](const msg::ActuatorCommand::Request&, auto reply, ParticipantId) {
          std::cout << "called" << std::endl;
          reply({});
        });
    if (!server) return server.error();
    server_ = std::move(server).value();
    return Ok();
  }

  Result<> Pose(const std::string& actuator, const std::string& partition) {
    msg::ActuatorStatus status;
    status.name = actuator;
    status.state = "Error";
    status.incarnation = ~std::uint64_t{0} >> 1U;  // newer than any
    status.pid = getpid();
    status.host = HostId();
    msg::ActuatorHeartbeat heartbeat;
    heartbeat.name = actuator;
    heartbeat.incarnation = status.incarnation;
    heartbeat.work = msg::ActuatorHeartbeat::kWorkHung;
    if (auto r = Publish(ActuatorHeartbeatTopic(name_space_), heartbeat, partition); !r) return r;
    return Publish(ActuatorStatusTopic(name_space_), status, partition);
  }

  Node& node_;
  const std::string name_space_;
  std::list<std::vector<std::string>> kept_;  // what partitions view
  std::vector<LoopHandlePtr> owned_;
  std::unique_ptr<Server<msg::ActuatorCommand>> server_;
  std::vector<std::unique_ptr<Subscription>> subscriptions_;
};

int Run(int argc, char** argv) {
  if (argc < 4) return EXIT_FAILURE;
  LinuxEventLoop loop;
  DdsOptions options;
  options.domain_id = std::atoi(argv[1]);
  options.discovery = DiscoveryTiming::kAtOnce;
  if (argv[2] != std::string("-")) options.credentials = {argv[2], argv[3]};
  const auto node = MakeDdsNode(loop, options);
  if (!node) {
    std::cout << "refused node: " << node.error().message << std::endl;
    return EXIT_FAILURE;
  }
  const char* name_space = std::getenv("MUSHER_NAMESPACE");
  Peer peer(*node.value(), name_space == nullptr ? "" : name_space);
  for (int i = 4; i < argc; ++i) {
    if (auto done = peer.Do(argv[i]); !done) {
      std::cout << "refused " << argv[i] << ": " << done.error().message << std::endl;
    }
  }
  std::cout << "ready" << std::endl;
  loop.Run();
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace musher::transport

int main(int argc, char** argv) {
  return musher::transport::Run(argc, argv);
}
