#include "musher/simulation/client.hpp"

#include <algorithm>
#include <utility>

#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::simulation {
namespace {

constexpr Duration kCallTimeout = std::chrono::seconds(3);
// As long as the command line searches for a controller of its host.
constexpr Duration kFindTimeout = std::chrono::seconds(4);

}  // namespace

Client::Client(transport::sim::Network& network, Hosts& hosts, const MachineConfig& config,
               const Layout& layout, std::size_t host)
    : network_(network),
      config_(config),
      machine_{layout.machine_id.empty() ? "" : config.name, layout.machine_id},
      host_(host),
      endpoint_("client@" + hosts.name(host)) {
  hosts.Attach(endpoint_, host);
  node_ = network.MakeNode(endpoint_);
}

Client::~Client() {
  network_.Crash(*node_);
}

void Client::SetState(const State& target, const std::string& actuator) {
  const std::uint64_t id = next_id_++;
  open_requests_.push_back(
      {.id = id, .target = target, .requested = network_.now(), .orphaned = {}});
  const auto find = [this, id] {
    return std::find_if(open_requests_.begin(), open_requests_.end(),
                        [id](const Request& request) { return request.id == id; });
  };
  SwitchClient::Options options;
  options.leader.name_space = config_.name_space;
  options.leader.machine = machine_;
  if (!machine_.id.empty()) options.by = Name(machine_.id);
  options.find = kFindTimeout;
  auto client = SwitchClient::Make(
      *node_, std::move(options), target, actuator,
      [find](const std::string&) { find()->notified = true; },
      [this, id, find](const SwitchEnd& end) {
        const Request request = *find();
        open_requests_.erase(find());
        // Deleted after its own callback.
        node_->loop().Post([this, id] {
          std::erase_if(switches_, [id](const auto& one) { return one.first == id; });
        });
        if (on_end) on_end(request, end);
      });
  switches_.emplace_back(id, std::move(client).value());
}

template <class S>
void Client::Call(const char* service, typename S::Request request) {
  if constexpr (requires { request.machine_id; }) {
    request.machine = machine_.name;
    request.machine_id = machine_.id;
  }
  auto client = std::shared_ptr<transport::Client<S>>(
      transport::MakeClient<S>(*node_, transport::MachineService(config_.name_space, service))
          .value());
  calls_.push_back(client);
  client->Call(request, kCallTimeout, [this, raw = client.get()](const auto& reply) {
    node_->loop().Post([this, raw] {
      std::erase_if(calls_, [raw](const auto& call) { return call.get() == raw; });
    });
    if (on_reply) on_reply(reply.ok());
  });
}

void Client::GetStatus() {
  Call<msg::GetStatus>("get_status", {});
}

void Client::ReleaseEmergencyStop() {
  msg::ReleaseEmergencyStop::Request request;
  request.by = Name(machine_.id);
  Call<msg::ReleaseEmergencyStop>("release_emergency_stop", std::move(request));
}

void Client::Restart(const std::string& actuator) {
  msg::RestartActuator::Request request;
  request.actuator = actuator;
  if (!machine_.id.empty()) request.by = Name(machine_.id);
  Call<msg::RestartActuator>("restart_actuator", std::move(request));
}

void Client::SetDiscoveryAtMost(Duration most) {
  network_.SetDiscoveryDelayOf(endpoint_, Milliseconds(1), most);
}

void Client::OnControllerKilled() {
  for (Request& request : open_requests_) {
    const auto one = std::find_if(switches_.begin(), switches_.end(),
                                  [&](const auto& s) { return s.first == request.id; });
    const bool pending = one != switches_.end() && one->second->found();
    if (pending && !request.orphaned && !request.notified) request.orphaned = network_.now();
  }
}

}  // namespace musher::simulation
