#pragma once
// Which entries of a journal are new to a reader that queries it again and again: a page, a
// recording, metrics, `history --follow`. Pure.
//
// The journal's order decides, not the wall clock, which may be set back: new is what stands behind
// an entry that the reader had before. So it queries the newest entries, not those since a time,
// for which the controller would search its whole journal:
//
//   request.limit = cursor.limit();
//   const auto fresh = cursor.Take(answer);  // each entry once
//   if (!fresh) Query();                     // now for more entries

#include <cstdint>
#include <deque>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "musher/messages/musher_msgs/machine_services.hpp"

namespace musher {

class JournalCursor {
 public:
  static constexpr std::uint32_t kFewEntries = 200;  // of the first request
  static constexpr std::uint32_t kNextEntries = 20;  // of the next: mostly nothing is new

  // An entry that is in the journal already is new only if it is later than `since_ns` (wall clock,
  // since 1970); INT64_MAX: none is. `most`: the limit of entries in one answer; after a longer gap
  // the older entries are left out.
  JournalCursor(std::int64_t since_ns, std::uint32_t most);
  JournalCursor(const JournalCursor&) = delete;
  JournalCursor& operator=(const JournalCursor&) = delete;

  // The limit in the first request of a reader that shows the newest `shown` entries. With a lower
  // one the reader would know these alone, and take all before them for new when one is lacking.
  static std::uint32_t FirstLimit(std::uint32_t shown);
  // The limit in the next request, whose `since_wall_ns` is 0.
  std::uint32_t limit() const { return limit_; }
  // The new entries of an answer, with their events. nullopt: entries before them may be missing in
  // it; it is to be asked again, with the limit that has grown tenfold.
  std::optional<msg::GetHistory::Response> Take(const msg::GetHistory::Response& answer);

 private:
  using Id = std::tuple<std::uint64_t, std::uint64_t, std::int64_t, std::string>;

  static Id IdOf(const msg::HistoryEntry& entry);
  bool IsComplete(const std::vector<msg::HistoryEntry>& entries, std::size_t first_known) const;
  bool Remember(Id id);

  const std::int64_t since_ns_;
  const std::uint32_t most_;
  std::uint32_t limit_;
  bool begun_ = false;          // a whole answer was taken
  std::int64_t newest_ns_ = 0;  // of the last answer with entries
  // The newest entries of the answers so far: one answer may lack some of those before, while a
  // disk is slow.
  std::set<Id> known_;
  std::deque<std::set<Id>::const_iterator> oldest_first_;
};

}  // namespace musher
