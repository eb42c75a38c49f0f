#include "musher/view/metrics/metrics_watch.hpp"

#include <algorithm>
#include <utility>

#include "musher/transport/lost_samples.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::view {
namespace {

constexpr std::uint32_t kMostEntries = 5000;  // of one answer

}  // namespace

MetricsWatch::MetricsWatch(transport::Node& node, Options options)
    : node_(node),
      options_(std::move(options)),
      cursor_(options_.began_wall_ns - 1, kMostEntries) {}

void MetricsWatch::Scrape(MetricsFormat format, Respond respond) {
  const bool first = !statuses_;
  if (auto subscribed = Subscribe(); !subscribed) return respond(subscribed.error());
  waiting_.push_back({format, std::move(respond)});
  if (timeout_) return;  // answered with the scrapes that wait already
  if (!first && leader_ == 0) return Answer(true);
  answer_by_ = node_.loop().Now() + kTimeout;
  timeout_ = node_.loop().At(answer_by_, [this] { Answer(leader_ == 0); });
  if (leader_ != 0) ReadHistory();
}

Result<> MetricsWatch::Subscribe() {
  if (statuses_) return Ok();
  auto client = transport::MakeClient<msg::GetHistory>(
      node_, transport::MachineService(options_.name_space, "get_history"));
  if (!client) return client.error();
  transport::Qos qos = transport::kHeartbeatQos;
  qos.partition = transport::ReaderPartition(options_.with_keys);
  auto heartbeats = transport::MakeSubscription<msg::ActuatorHeartbeat>(
      node_, transport::ActuatorHeartbeatTopic(options_.name_space),
      [this](const msg::ActuatorHeartbeat& heartbeat, const transport::SampleInfo& info) {
        if (transport::IsFrom(heartbeat.name, info)) metrics_.On(heartbeat, node_.loop().Now());
      },
      qos);
  if (!heartbeats) return heartbeats.error();
  auto statuses = transport::MakeSubscription<msg::MachineStatus>(
      node_, transport::MachineStatusTopic(options_.name_space),
      [this](const msg::MachineStatus& status, const transport::SampleInfo& info) {
        const MachineIdentity theirs{status.machine, status.machine_id};
        const MachineIdentity shown = options_.machine ? options_.machine() : MachineIdentity{};
        if (!transport::IsOwn(status.participant, info) || !SameMachine(shown, theirs)) return;
        OnStatus(status, info.writer);
      },
      transport::kLatchedFromManyQos,
      {[this](transport::EndpointId writer) { OnWriterLost(writer); }, {}});
  if (!statuses) return statuses.error();
  get_history_ = std::move(client).value();
  heartbeats_ = std::move(heartbeats).value();
  statuses_ = std::move(statuses).value();
  return Ok();
}

// Of two controllers the one with the higher epoch leads.
void MetricsWatch::OnStatus(const msg::MachineStatus& status, transport::EndpointId writer) {
  const bool outdated = leader_ != 0 && writer != leader_ && status.epoch < status_->epoch;
  if (outdated) return;
  leader_ = writer;
  status_ = status;
  metrics_.On(status, node_.loop().Now());
  const bool scrape_waits = timeout_ && !reading_;
  if (scrape_waits) ReadHistory();
}

void MetricsWatch::OnWriterLost(transport::EndpointId writer) {
  if (writer != leader_) return;
  leader_ = 0;
  metrics_.OnControllerLost();
}

void MetricsWatch::ReadHistory() {
  reading_ = ++requests_;
  msg::GetHistory::Request request;
  request.limit = cursor_.limit();
  const Duration timeout = std::max(answer_by_ - node_.loop().Now(), Duration(Milliseconds(1)));
  get_history_->Call(request, timeout, [this, number = requests_](const auto& history) {
    if (reading_ != number) return;  // of a scrape that was answered without
    reading_.reset();
    OnHistory(history);
  });
}

void MetricsWatch::OnHistory(const Result<msg::GetHistory::Response>& history) {
  if (!history || (!history.value().error.empty() && history.value().entries.empty())) {
    return Answer(false);
  }
  const auto fresh = cursor_.Take(history.value());
  if (!fresh) return ReadHistory();
  for (std::size_t i = 0; i < fresh->entries.size(); ++i) {
    metrics_.On(fresh->entries[i], fresh->events[i]);
  }
  Answer(true);
}

void MetricsWatch::Answer(bool complete) {
  timeout_ = nullptr;
  reading_.reset();
  ExamineProcesses();
  metrics_.OnLostSamples(transport::LostSamples());
  const Time now = node_.loop().Now();
  for (const WaitingScrape& scrape : std::exchange(waiting_, {})) {
    metrics_.OnScrape(complete);
    scrape.respond(metrics_.Text(now, scrape.format));
  }
}

void MetricsWatch::ExamineProcesses() {
  if (!status_) return;
  for (const msg::ActuatorInfo& actuator : status_->actuators) {
    const bool here = !options_.host.empty() && actuator.host == options_.host;
    metrics_.OnProcess(actuator.name, !here               ? std::nullopt
                                      : options_.usage_of ? options_.usage_of(actuator.pid)
                                                          : UsageOf(actuator.pid));
  }
}

}  // namespace musher::view
