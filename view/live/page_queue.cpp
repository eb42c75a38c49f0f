#include "musher/view/live/page_queue.hpp"

#include <algorithm>
#include <utility>

namespace musher::view {

void PageQueue::Put(const std::string& key, SharedText message) {
  const auto same =
      std::find_if(messages_.begin(), messages_.end(),
                   [&key](const WaitingMessage& waiting) { return waiting.key == key; });
  if (same != messages_.end()) {
    same->message = std::move(message);
  } else {
    messages_.push_back({key, std::move(message)});
  }
}

void PageQueue::PutEntry(SharedText entry) {
  if (history_lost_) return;
  entries_.push_back(std::move(entry));
  if (entries_.size() <= kMostEntries) return;
  entries_.clear();
  history_lost_ = true;
}

std::vector<SharedText> PageQueue::TakeAll() {
  std::vector<SharedText> all;
  all.reserve(messages_.size() + 1);
  for (WaitingMessage& waiting : messages_) all.push_back(std::move(waiting.message));
  if (!entries_.empty()) all.push_back(HistoryMessage(entries_, false));
  messages_.clear();
  entries_.clear();
  history_lost_ = false;
  return all;
}

SharedText HistoryMessage(const std::vector<SharedText>& entries, bool reset) {
  std::string text = R"({"op":"history","reset":)";
  text += reset ? "true" : "false";
  text += R"(,"entries":[)";
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (i > 0) text += ',';
    text += *entries[i];
  }
  return std::make_shared<const std::string>(text + "]}");
}

}  // namespace musher::view
