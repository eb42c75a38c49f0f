#include "musher/view/live/machine_feed.hpp"

#include <algorithm>
#include <utility>

#include "musher/view/http/reply.hpp"
#include "musher/view/json/json.hpp"
#include "musher/view/live/watched_topics.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::view {
namespace {

constexpr Duration kQueryDelay = Milliseconds(50);  // the records of a change come together
constexpr Duration kAnswerTime = std::chrono::seconds(3);
constexpr std::size_t kMostControllers = 64;
constexpr int kSecondsOfProcesses = 2;
constexpr int kSecondsOfHistory = 5;  // beside each change of the status

SharedText GoneMessage(const std::string& topic) {
  return std::make_shared<const std::string>(R"({"op":"gone","topic":)" + http::JsonText(topic) +
                                             "}");
}

}  // namespace

std::string EntryJson(const msg::HistoryEntry& entry, const std::string& event) {
  return Dumped({{"id", entry.id},
                 {"wall_ns", std::to_string(entry.wall_ns)},
                 {"epoch", entry.epoch},
                 {"switch_number", entry.switch_number},
                 {"kind", entry.kind},
                 {"actuator", entry.actuator},
                 {"code", entry.code},
                 {"message", entry.message},
                 {"cause", entry.cause},
                 {"state", entry.state},
                 {"data", entry.data},
                 {"event", event}});
}

MachineFeed::MachineFeed(transport::Node& node, Options options, Events events)
    : node_(node),
      options_(std::move(options)),
      events_(std::move(events)),
      status_topic_("/" + transport::MachineStatusTopic(options_.name_space)),
      capabilities_topic_("/" + transport::CapabilitiesTopic(options_.name_space)) {}

Result<std::unique_ptr<MachineFeed>> MachineFeed::Make(transport::Node& node, Options options,
                                                       Events events) {
  std::unique_ptr<MachineFeed> feed(new MachineFeed(node, std::move(options), std::move(events)));
  if (auto opened = feed->Open(); !opened) return opened.error();
  return feed;
}

Result<> MachineFeed::Open() {
  auto client = transport::MakeClient<msg::GetHistory>(
      node_, transport::MachineService(options_.name_space, "get_history"));
  if (!client) return client.error();
  get_history_ = std::move(client).value();
  auto capabilities = transport::MakeSubscription<msg::Capabilities>(
      node_, transport::CapabilitiesTopic(options_.name_space),
      [this](const msg::Capabilities& latest, const transport::SampleInfo& info) {
        if (latest_capabilities_.size() >= kMostControllers) latest_capabilities_.clear();
        latest_capabilities_[info.participant] = latest;
        if (leader_ && info.participant == leader_->participant()) PublishCapabilities();
      },
      transport::kLatchedFromManyQos);
  if (!capabilities) return capabilities.error();
  capabilities_ = std::move(capabilities).value();
  LeaderWatch::Options watch{options_.name_space, options_.host, WatchByPidfd(node_.loop())};
  watch.word = options_.machine;
  watch.prefer_here = true;
  // A page that is open never comes to show, and stop, the robot beside the one that was found.
  watch.one_name = true;
  auto leader = LeaderWatch::Make(
      node_, std::move(watch), [this](const msg::MachineStatus& status) { OnStatus(status); },
      [this](const msg::MachineStatus&, const std::string&) { OnEnd(); });
  if (!leader) return leader.error();
  leader_ = std::move(leader).value();
  return Ok();
}

template <class M>
void MachineFeed::Publish(const std::string& topic, const M& message) {
  const auto text = json_.ToJson(M::kTypeName, msg::Encode(message));
  if (!text) return;
  Keep("latest " + topic,
       LatestMessage(topic, std::string(M::kTypeName), WallMilliseconds(), text.value()));
}

void MachineFeed::Keep(const std::string& key, const SharedText& message) {
  const auto same = std::find_if(latest_.begin(), latest_.end(),
                                 [&key](const auto& kept) { return kept.first == key; });
  if (same == latest_.end()) {
    latest_.emplace_back(key, message);
  } else {
    same->second = message;
  }
  events_.on_message(key, message);
}

void MachineFeed::PublishCapabilities() {
  const auto latest = latest_capabilities_.find(leader_->participant());
  if (latest != latest_capabilities_.end()) Publish(capabilities_topic_, latest->second);
}

void MachineFeed::OnStatus(const msg::MachineStatus& status) {
  last_ = status;
  if (std::exchange(followed_, leader_->participant()) != leader_->participant()) {
    PublishCapabilities();
  }
  events_.on_status();
  QueryHistorySoon();
  if (status_timer_) {
    status_waits_ = true;
  } else {
    PublishStatus();
  }
}

void MachineFeed::PublishStatus() {
  Publish(status_topic_, *last_);
  status_timer_ = node_.loop().At(node_.loop().Now() + kStatusPeriod, [this] {
    status_timer_.reset();
    if (std::exchange(status_waits_, false)) PublishStatus();
  });
}

// The page keeps the last messages, marked as old.
void MachineFeed::OnEnd() {
  followed_ = 0;
  if (std::exchange(status_waits_, false)) Publish(status_topic_, *last_);
  for (const std::string& topic : {status_topic_, capabilities_topic_}) {
    events_.on_message("latest " + topic, GoneMessage(topic));
  }
  events_.on_status();
}

std::vector<std::pair<std::string, SharedText>> MachineFeed::Latest() const {
  auto latest = latest_;
  if (!status() && last_) {
    for (const std::string& topic : {status_topic_, capabilities_topic_}) {
      latest.emplace_back("gone " + topic, GoneMessage(topic));
    }
  }
  return latest;
}

SharedText MachineFeed::History() const {
  return HistoryMessage({entries_.begin(), entries_.end()}, true);
}

void MachineFeed::SetOpenPages(std::size_t count) {
  const bool first = pages_ == 0 && count > 0;
  pages_ = count;
  if (count == 0) every_second_.reset();
  if (!first) return;
  LookAtProcesses();
  QueryHistory();
  every_second_ = node_.loop().Every(std::chrono::seconds(1), [this, seconds = 0]() mutable {
    ++seconds;
    if (seconds % kSecondsOfProcesses == 0) LookAtProcesses();
    if (seconds % kSecondsOfHistory == 0) QueryHistory();
  });
}

void MachineFeed::QueryHistorySoon() {
  if (pages_ == 0 || query_timer_) return;
  query_timer_ = node_.loop().At(node_.loop().Now() + kQueryDelay, [this] {
    query_timer_.reset();
    QueryHistory();
  });
}

void MachineFeed::QueryHistory() {
  if (querying_) {
    query_again_ = true;
    return;
  }
  if (!status() || !get_history_->Ready()) return;
  querying_ = true;
  const MachineIdentity& machine = leader_->machine();
  get_history_->Call(
      {0, cursor_.limit(), machine.name, machine.id}, kAnswerTime,
      [this](const Result<msg::GetHistory::Response>& answer) { OnAnswer(answer); },
      leader_->participant());
}

void MachineFeed::OnAnswer(const Result<msg::GetHistory::Response>& answer) {
  querying_ = false;
  if (answer) {
    const auto history = cursor_.Take(answer.value());
    if (!history) return QueryHistory();
    std::vector<SharedText> fresh;
    for (std::size_t i = 0; i < history->entries.size(); ++i) {
      fresh.push_back(
          std::make_shared<const std::string>(EntryJson(history->entries[i], history->events[i])));
      entries_.push_back(fresh.back());
      if (entries_.size() > kKeptEntries) entries_.pop_front();
    }
    if (!fresh.empty()) events_.on_entries(fresh);
  }
  if (std::exchange(query_again_, false)) QueryHistorySoon();
}

void MachineFeed::LookAtProcesses() {
  if (!status()) return;
  OrderedJson actuators = OrderedJson::array();
  std::map<std::string, std::pair<ProcessUsage, Time>> now;
  const Time at = node_.loop().Now();
  for (const msg::ActuatorInfo& actuator : status()->actuators) {
    if (actuator.pid <= 0 || actuator.host != options_.host) continue;
    const auto usage = UsageOf(actuator.pid);
    if (!usage) continue;
    double percent = 0;
    const auto before = usage_.find(actuator.name);
    if (before != usage_.end() && before->second.first.start_time == usage->start_time &&
        at > before->second.second) {
      percent = 100 * (usage->cpu_seconds - before->second.first.cpu_seconds) /
                ToSeconds(at - before->second.second);
    }
    actuators.push_back({{"name", actuator.name},
                         {"pid", actuator.pid},
                         {"cpu_percent", percent},
                         {"rss_bytes", usage->resident_bytes},
                         {"threads", usage->threads}});
    now[actuator.name] = {*usage, at};
  }
  usage_ = std::move(now);
  Keep("processes", std::make_shared<const std::string>(
                        Dumped({{"op", "processes"}, {"actuators", std::move(actuators)}})));
}

}  // namespace musher::view
