#include "musher/controller/storage/log_rotation.hpp"

#include <algorithm>
#include <limits>
#include <tuple>

namespace musher {
namespace {

constexpr std::int64_t kTail = 64 << 10;  // bytes that stay in the live file for people to look at

std::int64_t LiveBound(const LogSizes& log) {
  return log.max_bytes / 5;
}

}  // namespace

std::int64_t LogSizes::total() const {
  std::int64_t bytes = live_bytes;
  for (const LogPart& part : parts) bytes += part.bytes;
  return bytes;
}

std::int64_t LogBound(std::int64_t max_bytes, std::int64_t max_total_bytes, std::size_t logs) {
  if (logs == 0) return max_bytes;
  return std::min(max_bytes, max_total_bytes / static_cast<std::int64_t>(logs) * 5 / 2);
}

LogActions RotationOf(const LogSizes& log) {
  LogActions actions;
  const std::int64_t live = LiveBound(log);
  const bool too_large = log.live_bytes > live;
  if (too_large) {
    const std::int64_t taken = log.live_bytes - std::min(kTail, live / 4);
    actions.save = std::min(taken, 2 * live);
    actions.drop = taken - actions.save;
  }
  std::size_t kept = log.parts.size();
  std::int64_t bytes = log.total() - log.live_bytes;
  const auto remove_oldest = [&] {
    const LogPart& oldest = log.parts[log.parts.size() - kept--];
    actions.remove.push_back(oldest.number);
    bytes -= oldest.bytes;
  };
  // Assumes that the new part does not compress.
  while (kept > 0 &&
         (kept + (too_large ? 1 : 0) > kMostLogParts || bytes + actions.save > 3 * live)) {
    remove_oldest();
  }
  if (!too_large || !log.no_room || !actions.remove.empty()) return actions;
  if (kept > 0) {
    remove_oldest();
  } else if (log.live_bytes > 2 * live) {
    actions.save = 0;
    actions.drop = log.live_bytes - live;
  }
  return actions;
}

std::vector<std::pair<std::size_t, std::uint64_t>> PartsBeyond(std::int64_t max_total_bytes,
                                                               const std::vector<LogSizes>& logs) {
  std::int64_t total = 0;
  std::vector<std::tuple<std::int64_t, std::size_t, std::uint64_t, std::int64_t>> parts;
  for (std::size_t i = 0; i < logs.size(); ++i) {
    total += logs[i].total();
    // A wall clock that was set back has written a newer part earlier.
    std::int64_t written_ns = std::numeric_limits<std::int64_t>::max();
    for (auto part = logs[i].parts.rbegin(); part != logs[i].parts.rend(); ++part) {
      written_ns = std::min(written_ns, part->written_ns);
      parts.emplace_back(written_ns, i, part->number, part->bytes);
    }
  }
  std::sort(parts.begin(), parts.end());
  std::vector<std::pair<std::size_t, std::uint64_t>> beyond;
  for (const auto& [written_ns, log, number, bytes] : parts) {
    if (total <= max_total_bytes) break;
    beyond.emplace_back(log, number);
    total -= bytes;
  }
  return beyond;
}

}  // namespace musher
