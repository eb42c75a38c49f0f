#include "musher/view/metrics/metrics_watch.hpp"

#include <algorithm>
#include <utility>

#include "musher/transport/lost_samples.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::view {
namespace {

// A scrape reads the newest entries, and more if these are not all that it does not know. It does
// not query those since the last scrape: the wall clock of a robot may be set back, and the
// controller would search its whole journal for them.
constexpr std::uint32_t kFewEntries = 200;
constexpr std::uint32_t kManyEntries = 5000;

}  // namespace

MetricsWatch::MetricsWatch(transport::Node& node, Options options)
    : node_(node), options_(std::move(options)) {}

void MetricsWatch::Scrape(MetricsFormat format, Respond respond) {
  const bool first = !statuses_;
  if (auto subscribed = Subscribe(); !subscribed) return respond(subscribed.error());
  waiting_.push_back({format, std::move(respond)});
  if (timeout_) return;  // answered with the scrapes that wait already
  if (!first && leader_ == 0) return Answer(true);
  answer_by_ = node_.loop().Now() + kTimeout;
  timeout_ = node_.loop().At(answer_by_, [this] { Answer(leader_ == 0); });
  if (leader_ != 0) ReadHistory(kFewEntries);
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
  if (scrape_waits) ReadHistory(kFewEntries);
}

void MetricsWatch::OnWriterLost(transport::EndpointId writer) {
  if (writer != leader_) return;
  leader_ = 0;
  metrics_.OnControllerLost();
}

void MetricsWatch::ReadHistory(std::uint32_t limit) {
  reading_ = ++requests_;
  msg::GetHistory::Request request;
  request.limit = limit;
  const Duration timeout = std::max(answer_by_ - node_.loop().Now(), Duration(Milliseconds(1)));
  get_history_->Call(request, timeout, [this, limit, number = requests_](const auto& history) {
    if (reading_ != number) return;  // of a scrape that was answered without
    reading_.reset();
    OnHistory(limit, history);
  });
}

void MetricsWatch::OnHistory(std::uint32_t limit,
                             const Result<msg::GetHistory::Response>& history) {
  if (!history || (!history.value().error.empty() && history.value().entries.empty())) {
    return Answer(false);
  }
  const std::vector<msg::HistoryEntry>& entries = history.value().entries;
  const std::vector<std::string>& events = history.value().events;
  const bool reaches_back = std::ranges::any_of(entries, [this](const msg::HistoryEntry& entry) {
    return history_read_ ? Epoch(entry.epoch) == newest_epoch_ && RecordId(entry.id) == newest_id_
                         : entry.wall_ns < options_.began_wall_ns;
  });
  const bool all = reaches_back || entries.size() < limit || limit == kManyEntries;
  if (!all && timeout_) return ReadHistory(kManyEntries);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const bool counts = entries[i].id != 0 && entries[i].wall_ns >= options_.began_wall_ns;
    if (counts) metrics_.On(entries[i], i < events.size() ? events[i] : "");
    if (entries[i].id == 0) continue;
    newest_epoch_ = Epoch(entries[i].epoch);
    newest_id_ = RecordId(entries[i].id);
  }
  history_read_ = true;
  Answer(true);
}

void MetricsWatch::Answer(bool complete) {
  timeout_ = nullptr;
  reading_.reset();
  ExamineProcesses();
  metrics_.OnLostSamples(transport::LostSamples());
  const Time now = node_.loop().Now();
  for (const Waiting& scrape : std::exchange(waiting_, {})) {
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
