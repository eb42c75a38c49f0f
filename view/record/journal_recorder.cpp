#include "musher/view/record/journal_recorder.hpp"

#include <utility>

namespace musher::view {
namespace {

constexpr Duration kPeriod = std::chrono::seconds(1);
constexpr Duration kTimeout = std::chrono::seconds(5);
constexpr std::uint32_t kMostEntries = 5000;  // of one answer

}  // namespace

JournalRecorder::JournalRecorder(std::string name_space, Sink& sink, std::int64_t since_ns,
                                 Events events)
    : name_space_(std::move(name_space)),
      sink_(sink),
      cursor_(since_ns, kMostEntries),
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
  request.limit = cursor_.limit();
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
  const auto fresh = cursor_.Take(answer);
  if (!fresh) return Query();
  for (std::size_t i = 0; i < fresh->entries.size(); ++i) {
    const msg::HistoryEntry& entry = fresh->entries[i];
    if (!channel_) {
      const std::string topic = "/" + transport::ResolveName(name_space_, "musher/journal");
      channel_ = sink_.AddChannel({topic, std::string(msg::HistoryEntry::kTypeName), "", false});
    }
    if (sink_.Write(*channel_, entry.wall_ns, msg::Encode(entry))) {
      ++count_;
    } else {
      ++lost_;
    }
    if (events_.on_event && !fresh->events[i].empty()) events_.on_event(fresh->events[i]);
  }
}

}  // namespace musher::view
