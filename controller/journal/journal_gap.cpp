#include "musher/controller/journal/journal_gap.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "musher/base/date_text.hpp"
#include "musher/base/host.hpp"
#include "musher/base/unique_fd.hpp"

namespace musher {
namespace {

constexpr std::size_t kGapFileSize = 512;  // bytes: a sector, so that it is never written in part
constexpr std::size_t kLongestReason = 256;

std::string GapFileOf(const std::string& path) {
  return path + ".gap";
}

}  // namespace

std::string JournalGap::Text() const {
  return FormatUtc(WholeSeconds(since_wall_ns)) + ": " + why;
}

std::optional<JournalGap> ReadGap(const std::string& path) {
  std::ifstream file(GapFileOf(path));
  JournalGap gap;
  std::string since;
  if (!(file >> since >> gap.since_wall_ns) || since != "since") return std::nullopt;
  std::getline(file >> std::ws, gap.why);
  return gap;
}

Result<> WriteGap(const std::string& path, const std::optional<JournalGap>& gap) {
  std::string text;
  if (gap) {
    std::string why = gap->why.substr(0, kLongestReason);
    std::replace(why.begin(), why.end(), '\n', ' ');
    text = "since " + std::to_string(gap->since_wall_ns) + " " + why;
  }
  text += '\n';
  text.resize(kGapFileSize, '\n');
  const std::string name = GapFileOf(path);
  const UniqueFd file(open(name.c_str(), O_WRONLY | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0600));
  if (!file.valid()) return SystemError("can't open " + name);
  const ssize_t written = pwrite(file.get(), text.data(), text.size(), 0);
  if (written != static_cast<ssize_t>(text.size()) || fdatasync(file.get()) != 0) {
    return SystemError("can't write " + name);
  }
  return Ok();
}

}  // namespace musher
