#include "musher/simulation/stop_client.hpp"

#include <algorithm>
#include <utility>

#include "musher/wire/lifecycle_wire.hpp"

namespace musher::simulation {
namespace {

// The timeouts of the command line.
constexpr Duration kTimeout = std::chrono::seconds(5);
constexpr Duration kLanTimeout = std::chrono::seconds(10);

}  // namespace

StopClient::StopClient(transport::sim::Network& network, Hosts& hosts, Options options, StopId id,
                       OnEnd on_end, OnOver on_over)
    : network_(network),
      options_(std::move(options)),
      on_end_(std::move(on_end)),
      on_over_(std::move(on_over)) {
  OpenLinks(hosts);
  msg::EmergencyStop stop;
  stop.id = id.value();
  stop.engaged = true;
  stop.by = options_.endpoint;
  stop.machine = options_.machine.name;
  stop.machine_id = options_.machine.id;
  const bool lan = View().lan;
  latch_ = StopLatch::Begin(*node_, options_.name_space, stop, {false, lan, [this] { Look(); }, {}})
               .value();
  Follow(hosts);
  transport::EventLoop& loop = node_->loop();
  const Time end = loop.Now() + (lan ? kLanTimeout : kTimeout);
  timer_ = loop.At(loop.Now() + StopLatch::kDiscovery, [this, end] {
    Look();
    if (!ended_) timer_ = node_->loop().At(end, [this] { End(); });
  });
}

// With exit code 0 it leaves the network properly; what stays for a minute just ends.
StopClient::~StopClient() {
  if (ended_ && !stays_published_) {
    latch_ = nullptr;
    leader_ = nullptr;
    machines_ = nullptr;
  }
  network_.Crash(*node_);
}

void StopClient::OpenLinks(Hosts& hosts) {
  hosts.Attach(options_.endpoint, options_.host);
  transport::sim::LinkFaults faults;
  faults.delay_max = std::max(faults.delay_max, options_.delay_most);
  faults.loss = options_.loss;
  faults.retransmission = std::max(faults.retransmission, options_.delay_most);
  network_.SetFaultsOf(options_.endpoint, faults);
  network_.SetDiscoveryDelayOf(options_.endpoint, Milliseconds(1), options_.discovery_most);
  node_ = network_.MakeNode(options_.endpoint);
}

// As the command line follows the machine (cli/machine/link.hpp).
void StopClient::Follow(const Hosts& hosts) {
  transport::SubscriptionEvents events;
  events.on_writer_lost = [this](transport::EndpointId writer) { controllers_.erase(writer); };
  machines_ = transport::MakeSubscription<msg::MachineInfo>(
                  *node_, std::string(transport::kMachinesTopic),
                  [this](const msg::MachineInfo& info, const transport::SampleInfo& from) {
                    const MachineIdentity theirs{info.machine, info.machine_id};
                    const bool ours = SameMachine(options_.machine, theirs);
                    if (transport::IsOwn(info.participant, from) && ours) {
                      controllers_.insert(from.writer);
                    }
                  },
                  transport::kLatchedFromManyQos, std::move(events))
                  .value();
  LeaderWatch::Options options{options_.name_space, hosts.Id(options_.host), {}};
  options.machine = options_.machine;
  leader_ = LeaderWatch::Make(
                *node_, std::move(options), [this](const msg::MachineStatus&) { Look(); },
                [this](const msg::MachineStatus&, const std::string&) { Look(); })
                .value();
}

StopView StopClient::View() const {
  StopView view = options_.view();
  if (leader_) view.controller = leader_->leader();
  view.has_controller |= !controllers_.empty();
  return view;
}

void StopClient::Look() {
  if (ended_ || !latch_) return;
  if (latch_->withdrawn() || latch_->IsOver(latch_->Report(View()))) End();
}

void StopClient::End() {
  if (std::exchange(ended_, true)) return;
  const EstopReport report = latch_->Report(View());
  const bool confirmed = report.found() && report.complete();
  stays_published_ = !latch_->withdrawn() && !(confirmed && report.controller);
  transport::EventLoop& loop = node_->loop();
  const Duration kept = stays_published_ ? DetachedPublisher::kKeptPublished : Duration::zero();
  timer_ = loop.At(loop.Now() + kept, on_over_);
  on_end_(confirmed);
}

}  // namespace musher::simulation
