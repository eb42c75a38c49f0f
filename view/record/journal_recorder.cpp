#include "musher/view/record/journal_recorder.hpp"

#include <utility>

namespace musher::view {
namespace {

constexpr Duration kPeriod = std::chrono::seconds(1);
constexpr Duration kTimeout = std::chrono::seconds(5);

}  // namespace

std::vector<std::size_t> JournalCursor::Take(const std::vector<msg::HistoryEntry>& entries) {
  std::vector<std::size_t> fresh;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const msg::HistoryEntry& entry = entries[i];
    const std::int64_t last_ns = since_ns_ + 1;
    if (entry.wall_ns < last_ns) continue;
    if (entry.wall_ns > last_ns) {
      since_ns_ = entry.wall_ns - 1;
      seen_.clear();
    }
    if (seen_.emplace(entry.wall_ns, entry.epoch, entry.id, entry.message).second) {
      fresh.push_back(i);
    }
  }
  return fresh;
}

JournalRecorder::JournalRecorder(std::string name_space, Sink& sink, std::int64_t since_ns,
                                 Events events)
    : name_space_(std::move(name_space)),
      sink_(sink),
      cursor_(since_ns),
      events_(std::move(events)) {}

Result<std::unique_ptr<JournalRecorder>> JournalRecorder::Make(transport::Node& node,
                                                               const std::string& name_space,
                                                               const std::string& host, Sink& sink,
                                                               std::int64_t since_ns,
                                                               Events events) {
  auto client = transport::MakeClient<msg::GetHistory>(
      node, transport::ResolveName(name_space, "musher/get_history"));
  if (!client) return client.error();
  std::unique_ptr<JournalRecorder> recorder(
      new JournalRecorder(name_space, sink, since_ns, std::move(events)));
  recorder->client_ = std::move(client).value();
  LeaderWatch::Options watch{name_space, host, WatchByPidfd(node.loop())};
  watch.prefer_here = true;
  watch.one_name = true;
  auto leader = LeaderWatch::Make(
      node, std::move(watch),
      [self = recorder.get()](const msg::MachineStatus& status) {
        if (self->events_.on_status) self->events_.on_status(status);
      },
      [](const msg::MachineStatus&, const std::string&) {});
  if (!leader) return leader.error();
  recorder->leader_ = std::move(leader).value();
  recorder->timer_ = node.loop().Every(kPeriod, [self = recorder.get()] { self->Query(); });
  return recorder;
}

void JournalRecorder::Query() {
  if (querying_ || !leader_->leader() || !client_->Ready()) return;
  querying_ = true;
  msg::GetHistory::Request request;
  request.since_wall_ns = cursor_.since_ns();
  request.machine = leader_->machine().name;
  request.machine_id = leader_->machine().id;
  client_->Call(
      request, kTimeout,
      [this](const Result<msg::GetHistory::Response>& answer) {
        querying_ = false;
        if (answer) OnAnswer(answer.value());
      },
      leader_->participant());
}

void JournalRecorder::OnAnswer(const msg::GetHistory::Response& answer) {
  for (const std::size_t i : cursor_.Take(answer.entries)) {
    const msg::HistoryEntry& entry = answer.entries[i];
    if (!channel_) {
      const std::string topic = "/" + transport::ResolveName(name_space_, "musher/journal");
      channel_ = sink_.AddChannel({topic, std::string(msg::HistoryEntry::kTypeName), "", false});
    }
    if (sink_.Write(*channel_, entry.wall_ns, msg::Encode(entry))) {
      ++count_;
    } else {
      ++lost_;
    }
    if (i < answer.events.size() && events_.on_event) events_.on_event(answer.events[i]);
  }
}

}  // namespace musher::view
