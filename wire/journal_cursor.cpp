#include "musher/wire/journal_cursor.hpp"

#include <algorithm>
#include <utility>

namespace musher {
namespace {

constexpr std::size_t kKnownEntries = 1000;

}  // namespace

JournalCursor::JournalCursor(std::int64_t since_ns, std::uint32_t most)
    : since_ns_(since_ns), most_(most), limit_(std::min(kFewEntries, most)) {}

std::uint32_t JournalCursor::FirstLimit(std::uint32_t shown) {
  return std::max(shown, kFewEntries);
}

JournalCursor::Id JournalCursor::IdOf(const msg::HistoryEntry& entry) {
  return {entry.epoch, entry.id, entry.wall_ns, entry.message};
}

// Whether no entry is missing between those that the reader had and these.
bool JournalCursor::IsComplete(const std::vector<msg::HistoryEntry>& entries,
                               std::size_t first_known) const {
  if (entries.size() < limit_ || limit_ == most_ || first_known < entries.size()) return true;
  return !begun_ && std::ranges::any_of(
                        entries, [this](const auto& entry) { return entry.wall_ns <= since_ns_; });
}

// Returns whether it was not known.
bool JournalCursor::Remember(Id id) {
  const auto [known, is_new] = known_.insert(std::move(id));
  if (is_new) oldest_first_.push_back(known);
  if (oldest_first_.size() > kKnownEntries) {
    known_.erase(oldest_first_.front());
    oldest_first_.pop_front();
  }
  return is_new;
}

std::optional<msg::GetHistory::Response> JournalCursor::Take(
    const msg::GetHistory::Response& answer) {
  msg::GetHistory::Response fresh;
  fresh.error = answer.error;
  const std::vector<msg::HistoryEntry>& entries = answer.entries;
  if (entries.empty() && !answer.error.empty()) return fresh;  // it could not be read
  const auto known = std::ranges::find_if(
      entries, [this](const auto& entry) { return known_.contains(IdOf(entry)); });
  const auto first_known = static_cast<std::size_t>(known - entries.begin());
  if (!IsComplete(entries, first_known)) {
    limit_ = std::min(10 * limit_, most_);
    return std::nullopt;
  }
  const bool none_known = first_known == entries.size();
  // What stands before the first known one is older than all that the reader had, once it has
  // begun.
  const std::size_t begin = none_known || !begun_ ? 0 : first_known;
  // A long journal of which nothing is known is another one, with a past of its own.
  const bool other = begun_ && none_known && entries.size() >= std::min(kFewEntries, most_);
  const std::int64_t after_ns = other ? newest_ns_ : since_ns_;
  for (std::size_t i = begin; i < entries.size(); ++i) {
    // What stands behind a known one is new in any case, also while a part cannot be read.
    const bool is_after = (begun_ && !other) || i > first_known || entries[i].wall_ns > after_ns;
    if (!Remember(IdOf(entries[i])) || !is_after) continue;
    fresh.entries.push_back(entries[i]);
    fresh.events.push_back(i < answer.events.size() ? answer.events[i] : "");
  }
  if (!entries.empty()) newest_ns_ = entries.back().wall_ns;
  begun_ |= answer.error.empty();  // else what is on disk may follow
  limit_ = std::min(begun_ ? kNextEntries : kFewEntries, most_);
  return fresh;
}

}  // namespace musher
