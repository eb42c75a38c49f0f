#include "musher/controller/storage/log_times.hpp"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <sstream>
#include <utility>

#include "musher/base/files.hpp"
#include "musher/base/host.hpp"
#include "musher/base/unique_fd.hpp"

namespace musher {
namespace {

constexpr std::size_t kMostMarks = 50'000;  // of a log, some 1.5 MB

std::string PathOfMarks(const std::string& log) {
  return log + ".times";
}

std::string LineOf(const LogMark& mark) {
  return std::to_string(mark.part) + ' ' + std::to_string(mark.end) + ' ' +
         std::to_string(mark.wall_ns) + '\n';
}

std::vector<LogMark> ReadMarks(const std::string& log) {
  std::vector<LogMark> marks;
  std::istringstream lines(ReadFile(PathOfMarks(log)));
  for (std::string line; std::getline(lines, line);) {
    std::istringstream numbers(line);
    LogMark mark;
    std::string more;
    const bool whole = static_cast<bool>(numbers >> mark.part >> mark.end >> mark.wall_ns);
    if (whole && !(numbers >> more)) marks.push_back(mark);
  }
  return marks;
}

// The marked bytes of the live file.
std::int64_t LiveEnd(const std::vector<LogMark>& marks) {
  std::int64_t end = 0;
  for (const LogMark& mark : marks) {
    if (mark.part == kLiveLog) end = std::max(end, mark.end);
  }
  return end;
}

void RemoveLive(std::vector<LogMark>& marks) {
  std::erase_if(marks, [](const LogMark& mark) { return mark.part == kLiveLog; });
}

}  // namespace

std::vector<LogMark> MarksAfterCut(const std::vector<LogMark>& marks, std::int64_t save,
                                   std::int64_t drop, std::uint64_t number) {
  std::vector<LogMark> saved;
  std::vector<LogMark> live;
  bool covered = false;  // all that was saved
  for (const LogMark& mark : marks) {
    if (mark.part != kLiveLog) {
      saved.push_back(mark);
      continue;
    }
    if (save > 0 && !covered) saved.push_back({number, std::min(mark.end, save), mark.wall_ns});
    covered = covered || mark.end >= save;
    if (mark.end > save + drop) live.push_back({kLiveLog, mark.end - save - drop, mark.wall_ns});
  }
  saved.insert(saved.end(), live.begin(), live.end());
  return saved;
}

std::vector<LogMark> NewestMarks(std::vector<LogMark> marks, std::size_t most) {
  if (marks.size() <= most) return marks;
  const auto kept = marks.end() - static_cast<std::ptrdiff_t>(most);
  LogMark last = *std::prev(kept);
  last.wall_ns = 0;
  std::vector<LogMark> newest{last};
  newest.insert(newest.end(), kept, marks.end());
  return newest;
}

LogTimes::LogTimes(const std::string& log, std::int64_t live_bytes) {
  std::vector<LogMark> marks = ReadMarks(log);
  if (LiveEnd(marks) > live_bytes) RemoveLive(marks);
  for (const LogMark& mark : marks) parts_[mark.part].push_back(mark);
  for (auto& [part, of_part] : parts_) {
    std::stable_sort(of_part.begin(), of_part.end(),
                     [](const LogMark& a, const LogMark& b) { return a.end < b.end; });
  }
}

std::int64_t LogTimes::At(std::uint64_t part, std::int64_t end) const {
  const auto marks = parts_.find(part);
  if (marks == parts_.end()) return 0;
  const auto found =
      std::lower_bound(marks->second.begin(), marks->second.end(), end,
                       [](const LogMark& mark, std::int64_t wanted) { return mark.end < wanted; });
  return found == marks->second.end() ? 0 : found->wall_ns;
}

LogMarker::LogMarker(const std::string& log) : path_(PathOfMarks(log)), marks_(ReadMarks(log)) {
  marked_ = LiveEnd(marks_);
}

Result<> LogMarker::Mark(std::int64_t bytes, std::int64_t wall_ns) {
  const bool first = !std::exchange(any_, true);
  if (bytes < marked_) {  // another content than the marks were made for
    if (auto begun = Begin(); !begun) return begun;
  }
  if (bytes == marked_) return Ok();
  return Append({kLiveLog, bytes, first ? 0 : wall_ns});
}

Result<> LogMarker::Cut(std::int64_t save, std::int64_t drop, std::uint64_t number,
                        const std::vector<std::uint64_t>& parts) {
  marks_ = MarksAfterCut(marks_, save, drop, number);
  std::erase_if(marks_, [&](const LogMark& mark) {
    return mark.part != kLiveLog && std::find(parts.begin(), parts.end(), mark.part) == parts.end();
  });
  return Rewrite();
}

Result<> LogMarker::Begin() {
  RemoveLive(marks_);
  return Rewrite();
}

Result<> LogMarker::Rewrite() {
  marked_ = LiveEnd(marks_);
  std::string text;
  for (const LogMark& mark : marks_) text += LineOf(mark);
  Result<> replaced = ReplaceFile(path_, text, {.synced = false});
  damaged_ = !replaced.ok();
  return replaced;
}

Result<> LogMarker::Append(const LogMark& mark) {
  marks_.push_back(mark);
  marked_ = mark.end;
  const bool many = marks_.size() > kMostMarks;
  if (many) marks_ = NewestMarks(std::move(marks_), kMostMarks / 2);
  if (many || damaged_) return Rewrite();
  const UniqueFd file(
      open(path_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_NOFOLLOW | O_CLOEXEC, 0644));
  damaged_ = !file.valid() || !WriteAll(file.get(), LineOf(mark));
  return damaged_ ? SystemError("can't write " + path_) : Ok();
}

}  // namespace musher
