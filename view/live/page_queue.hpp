#pragma once
// What waits for one page until its connection can take more: of each kind of message only the
// newest, and of the history what has not been sent. So a slow page sees the present, not the past,
// and takes a bounded amount of memory. Pure.

#include <cstddef>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace musher::view {

using SharedText = std::shared_ptr<const std::string>;

class PageQueue {
 public:
  static constexpr std::size_t kMostEntries = 500;  // of the history

  // Replaces the waiting message of that key ("latest /musher/machine_status"), or appends it.
  void Put(const std::string& key, SharedText message);
  // Appends an entry of the history, a JSON object. With more than kMostEntries waiting all are
  // dropped, and history_lost() holds until TakeAll().
  void PutEntry(SharedText entry);

  bool empty() const { return messages_.empty() && entries_.empty() && !history_lost_; }
  bool history_lost() const { return history_lost_; }

  // All messages in the order in which their keys came, then the entries in one message.
  std::vector<SharedText> TakeAll();

 private:
  struct WaitingMessage {
    std::string key;
    SharedText message;
  };

  std::deque<WaitingMessage> messages_;
  std::vector<SharedText> entries_;
  bool history_lost_ = false;
};

// {"op":"history","reset":...,"entries":[...]}
SharedText HistoryMessage(const std::vector<SharedText>& entries, bool reset);

}  // namespace musher::view
