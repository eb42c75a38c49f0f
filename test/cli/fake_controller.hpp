#pragma once
// The controller of a machine, of another host unless a test says otherwise, as the network sees
// it: its heartbeat, what it publishes of the machine, and the services that a test gives it.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "musher/base/time.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"
#include "musher/transport/dds/node_thread.hpp"
#include "musher/transport/endpoints.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::cli {

class FakeController {
 public:
  struct Process {
    std::string host;
    std::int32_t pid = 0;
  };

  // It leads the machine in that state from now on.
  FakeController(std::string name_space, const std::string& machine, const std::string& id,
                 const std::string& state, const Process& process = {"another boot/1", 7})
      : name_space_(std::move(name_space)), thread_(transport::NodeThread::Start().value()) {
    status_.machine = machine;
    status_.name_space = name_space_;
    status_.phase = "running";
    status_.state = state;
    status_.epoch = 1;
    status_.pid = process.pid;
    status_.host = process.host;
    status_.machine_id = id;
    thread_->RunOnLoop([this] { Open(); });
  }
  ~FakeController() {
    thread_->RunOnLoop([this] {
      endpoints_.reset();
      infos_.reset();
    });
  }
  FakeController(const FakeController&) = delete;
  FakeController& operator=(const FakeController&) = delete;

  // It has started the machine from that file.
  void SetConfigFile(const std::string& config_file) {
    thread_->RunOnLoop([&] {
      status_.config_file = config_file;
      statuses_(status_);
    });
  }

  // Offers a service, such as "get_status". The handler runs on the thread of the loop.
  template <msg::Service S>
  void Serve(const std::string& service, typename transport::Server<S>::Handler handler) {
    thread_->RunOnLoop(
        [&] { endpoints_->Serve<S>(transport::MachineService("", service), std::move(handler)); });
  }

 private:
  void Open() {
    endpoints_ = std::make_unique<transport::Endpoints>(thread_->node(), name_space_);
    heartbeat_.machine = status_.machine;
    heartbeat_.machine_id = status_.machine_id;
    heartbeat_.epoch = status_.epoch;
    heartbeat_.host = status_.host;
    heartbeat_.pid = status_.pid;
    heartbeat_.period_ns = Duration(kPeriod).count();
    const auto beat = endpoints_->PublishFunction<msg::ControllerHeartbeat>(
        transport::ControllerHeartbeatTopic(""), transport::kLatchedQos);
    beat(heartbeat_);
    endpoints_->Every(kPeriod, [this, beat] { beat(heartbeat_); });
    statuses_ = endpoints_->PublishFunction<msg::MachineStatus>(transport::MachineStatusTopic(""),
                                                                transport::kLatchedQos);
    statuses_(status_);
    // It is not resolved in the namespace.
    infos_ = transport::MakePublisher<msg::MachineInfo>(
                 thread_->node(), std::string(transport::kMachinesTopic), transport::kLatchedQos)
                 .value();
    static_cast<void>(infos_->Publish(
        {status_.machine, name_space_, status_.host, status_.pid, status_.machine_id}));
  }

  static constexpr Duration kPeriod = Milliseconds(100);
  const std::string name_space_;
  msg::MachineStatus status_;
  msg::ControllerHeartbeat heartbeat_;
  std::function<void(const msg::MachineStatus&)> statuses_;
  std::shared_ptr<transport::NodeThread> thread_;
  std::unique_ptr<transport::Publisher<msg::MachineInfo>> infos_;
  std::unique_ptr<transport::Endpoints> endpoints_;
};

}  // namespace musher::cli
