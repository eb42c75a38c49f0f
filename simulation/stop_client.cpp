#include "musher/simulation/stop_client.hpp"

#include <algorithm>
#include <utility>

#include "musher/wire/lifecycle_wire.hpp"

namespace musher::simulation {
namespace {

// Those of the command line.
constexpr Duration kTimeout = std::chrono::seconds(5);
constexpr Duration kLanTimeout = std::chrono::seconds(10);
constexpr Duration kFirstWait = Milliseconds(1200);
constexpr Duration kKeptPublished = std::chrono::minutes(1);

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
  Follow();
  transport::EventLoop& loop = node_->loop();
  timer_ = loop.At(loop.Now() + (lan ? kLanTimeout : kFirstWait), [this, lan] {
    if (lan) return End();
    Look();
    if (ended_) return;
    const StopView view = View();
    const bool waits = view.has_controller || latch_->Report(view).found();
    if (!waits) return End();
    transport::EventLoop& later = node_->loop();
    timer_ = later.At(later.Now() + kTimeout - kFirstWait, [this] { End(); });
  });
}

// With exit code 0 it leaves the network properly; what stays for a minute just ends.
StopClient::~StopClient() {
  if (confirmed_) {
    latch_ = nullptr;
    statuses_ = nullptr;
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

// As the command line follows the machine's status.
void StopClient::Follow() {
  machines_ = transport::MakeSubscription<msg::MachineInfo>(
                  *node_, std::string(transport::kMachinesTopic),
                  [this](const msg::MachineInfo& info, const transport::SampleInfo& from) {
                    discovered_ |= transport::IsOwn(info.participant, from) &&
                                   SameMachine(options_.machine, {info.machine, info.machine_id});
                  },
                  transport::kLatchedFromManyQos)
                  .value();
  transport::SubscriptionEvents events;
  events.on_writer_lost = [this](transport::EndpointId writer) {
    if (writer == status_writer_) Take(std::nullopt, 0);
  };
  statuses_ = transport::MakeSubscription<msg::MachineStatus>(
                  *node_, transport::MachineStatusTopic(options_.name_space),
                  [this](const msg::MachineStatus& status, const transport::SampleInfo& info) {
                    const bool older = controller_ && status.epoch < controller_->epoch;
                    const MachineIdentity theirs{status.machine, status.machine_id};
                    if (SameMachine(options_.machine, theirs) && !older) Take(status, info.writer);
                  },
                  transport::kLatchedFromManyQos, std::move(events))
                  .value();
}

void StopClient::Take(std::optional<msg::MachineStatus> status, transport::EndpointId writer) {
  controller_ = std::move(status);
  status_writer_ = writer;
  Look();
}

StopView StopClient::View() const {
  StopView view = options_.view();
  view.controller = controller_;
  view.has_controller |= discovered_;
  return view;
}

void StopClient::Look() {
  if (ended_ || !latch_) return;
  const StopView view = View();
  const EstopReport report = latch_->Report(view);
  const bool alone = !view.lan && !view.has_controller && report.found();
  if ((report.controller || alone) && report.settled()) End();
}

void StopClient::End() {
  if (std::exchange(ended_, true)) return;
  const EstopReport report = latch_->Report(View());
  confirmed_ = report.found() && report.complete();
  transport::EventLoop& loop = node_->loop();
  timer_ = loop.At(loop.Now() + (confirmed_ ? Duration::zero() : kKeptPublished), on_over_);
  on_end_(confirmed_);
}

}  // namespace musher::simulation
