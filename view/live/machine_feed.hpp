#pragma once
// What every page gets of one machine, as messages for pages: the status and the capabilities,
// which are latched, new entries of the history, and what the processes of this host use. It
// observes as any process on the network can; the history is queried while a page is open.
//
// Threads: loop thread only, callbacks too.

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/process_usage.hpp"
#include "musher/controller/client/leader_watch.hpp"
#include "musher/messages/musher_msgs/capabilities.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/transport/service.hpp"
#include "musher/view/json/message_json.hpp"
#include "musher/view/live/page_queue.hpp"
#include "musher/wire/journal_cursor.hpp"

namespace musher::view {

class MachineFeed {
 public:
  static constexpr std::uint32_t kKeptEntries = 400;  // of the history, for a page that opens
  // The status is passed on at once, then at most so often: a switch of many actuators has many.
  static constexpr Duration kStatusPeriod = Milliseconds(33);

  struct Options {
    std::string name_space;
    std::string host;  // HostId()
    // Its name, or the beginning of its id; empty: that of this host, else the first that is found.
    std::string machine;
  };
  struct Events {
    std::function<void(const std::string& key, const SharedText& message)> on_message;
    std::function<void(const std::vector<SharedText>& entries)> on_entries;  // of the history
    std::function<void()> on_status;  // the status has changed, or is lost
  };

  // The node must outlive it.
  static Result<std::unique_ptr<MachineFeed>> Make(transport::Node& node, Options options,
                                                   Events events);

  // While no page is open nothing is queried.
  void SetOpenPages(std::size_t count);
  // For a page that opens: the latest messages by key, without the history.
  std::vector<std::pair<std::string, SharedText>> Latest() const;
  // The newest kKeptEntries.
  SharedText History() const;

  const LeaderWatch& leader() const { return *leader_; }
  const std::optional<msg::MachineStatus>& status() const { return leader_->leader(); }
  // Status of the last controller, also after its end.
  const std::optional<msg::MachineStatus>& last_status() const { return last_; }

 private:
  MachineFeed(transport::Node& node, Options options, Events events);
  Result<> Open();
  template <class M>
  void Publish(const std::string& topic, const M& message);
  void OnStatus(const msg::MachineStatus& status);
  void PublishCapabilities();
  void PublishStatus();
  void OnEnd();
  void QueryHistorySoon();
  void QueryHistory();
  void OnAnswer(const Result<msg::GetHistory::Response>& answer);
  void LookAtProcesses();
  void Keep(const std::string& key, const SharedText& message);

  transport::Node& node_;
  const Options options_;
  const Events events_;
  const std::string status_topic_;
  const std::string capabilities_topic_;
  MessageJson json_;
  std::optional<msg::MachineStatus> last_;
  // By the controller's participant: those of another machine may be received, too.
  std::map<transport::ParticipantId, msg::Capabilities> latest_capabilities_;
  transport::ParticipantId followed_ = 0;  // the leader whose capabilities were published
  std::vector<std::pair<std::string, SharedText>> latest_;
  std::deque<SharedText> entries_;
  JournalCursor cursor_{0, kKeptEntries};
  bool querying_ = false;
  bool query_again_ = false;
  std::size_t pages_ = 0;
  std::map<std::string, std::pair<ProcessUsage, Time>> usage_;
  bool status_waits_ = false;
  transport::LoopHandlePtr status_timer_;  // until the status may be passed on again
  transport::LoopHandlePtr query_timer_;
  transport::LoopHandlePtr every_second_;  // while a page is open
  std::unique_ptr<transport::Client<msg::GetHistory>> get_history_;
  std::unique_ptr<transport::Subscription> capabilities_;
  std::unique_ptr<LeaderWatch> leader_;  // last: its callbacks use all of the above
};

// An entry of the history as the page gets it: its fields, and its event.
std::string EntryJson(const msg::HistoryEntry& entry, const std::string& event);

}  // namespace musher::view
