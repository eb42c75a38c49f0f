#include "musher/controller/storage/log_reader.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

#include "musher/base/host.hpp"
#include "musher/controller/storage/log_parts.hpp"

namespace musher {
namespace {

constexpr std::int64_t kPiece = 256 << 10;  // of the live file
constexpr std::size_t kAnchor = 1024;       // bytes by which a place is found again
constexpr std::size_t kLongestLine = 1 << 20;

// As many as there are.
std::string ReadAt(int file, std::int64_t at, std::size_t size) {
  std::string text(size, '\0');
  std::size_t done = 0;
  while (done < size) {
    const ssize_t got =
        pread(file, text.data() + done, size - done, at + static_cast<std::int64_t>(done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    done += static_cast<std::size_t>(got);
  }
  text.resize(done);
  return text;
}

// nullopt: it cannot be read to its end.
std::optional<std::string> Uncompressed(const std::string& path) {
  gzFile file = gzopen(path.c_str(), "rbe");
  if (file == nullptr) return std::nullopt;
  std::string text;
  std::array<char, 64 << 10> buffer{};
  int got = 0;
  while ((got = gzread(file, buffer.data(), buffer.size())) > 0) text.append(buffer.data(), got);
  gzclose(file);
  if (got < 0) return std::nullopt;
  return text;
}

std::int64_t SizeOfLog(int file) {
  struct stat info {};
  return fstat(file, &info) == 0 ? info.st_size : 0;
}

UniqueFd OpenLog(const std::string& path) {
  UniqueFd file(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  struct stat info {};
  if (file.valid() && (fstat(file.get(), &info) != 0 || !S_ISREG(info.st_mode))) file = {};
  return file;
}

// Takes the complete lines from the front of `text`.
std::vector<std::string> TakeLines(std::string& text) {
  std::vector<std::string> lines;
  std::size_t begin = 0;
  for (std::size_t end = 0; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1) {
    lines.push_back(text.substr(begin, end - begin));
  }
  text.erase(0, begin);
  return lines;
}

}  // namespace

Result<LogReader> LogReader::Open(const std::string& path) {
  errno = 0;
  UniqueFd file = OpenLog(path);
  if (!file.valid()) return SystemError("can't read " + path, errno == 0 ? EINVAL : errno);
  const std::int64_t size = SizeOfLog(file.get());
  return LogReader(path, std::move(file), size);
}

LogReader::LogReader(std::string path, UniqueFd file, std::int64_t end)
    : path_(std::move(path)), file_(std::move(file)), end_(end), at_(end), times_(path_, end) {
  for (const LogPart& part : LogPartsOf(path_)) parts_.push_back(part.number);
  left_ = parts_.size();
}

std::optional<LogReader::Piece> LogReader::PieceBefore() {
  if (at_ > 0) {
    const std::int64_t size = std::min(at_, kPiece);
    at_ -= size;
    return Piece{kLiveLog, at_, ReadAt(file_.get(), at_, static_cast<std::size_t>(size))};
  }
  while (left_ > 0) {
    const std::uint64_t number = parts_[--left_];
    const std::string part = LogPartPath(path_, number);
    if (auto text = Uncompressed(part)) return Piece{number, 0, std::move(*text)};
    if (access(part.c_str(), F_OK) == 0) damage_ = "can't read " + part + ": it is damaged";
  }
  return std::nullopt;
}

std::vector<WrittenLine> LogReader::Before() {
  while (auto piece = PieceBefore()) {
    auto lines = LinesOf(std::move(*piece));
    if (!lines.empty()) return lines;
  }
  if (!any_) return {};
  any_ = false;
  return {std::exchange(begun_, {})};
}

// All lines but the first, which the piece before may complete. The last one goes on in the piece
// that was read before this one.
std::vector<WrittenLine> LogReader::LinesOf(Piece piece) {
  const bool last = !any_;
  if (last && piece.text.empty()) return {};
  any_ = true;
  std::int64_t end = piece.begin;
  std::vector<WrittenLine> lines;
  for (std::string& text : TakeLines(piece.text)) {
    end += static_cast<std::int64_t>(text.size()) + 1;
    lines.push_back({std::move(text), times_.At(piece.part, end)});
  }
  const std::string& open = piece.text;  // what is left: the begin of a line
  if (!last) {
    lines.push_back({open + begun_.text, begun_.written_ns});
  } else if (!open.empty()) {
    end += static_cast<std::int64_t>(open.size());
    lines.push_back({open, times_.At(piece.part, end)});
  }
  begun_ = std::move(lines.front());
  lines.erase(lines.begin());
  return lines;
}

LogTail::LogTail(std::string path, std::int64_t at) : path_(std::move(path)), at_(at) {
  file_ = OpenLog(path_);
  if (!file_.valid()) return;
  const auto size = std::min(static_cast<std::int64_t>(kAnchor), at_);
  before_ = ReadAt(file_.get(), at_ - size, static_cast<std::size_t>(size));
}

std::vector<std::string> LogTail::Read() {
  Reopen();
  if (!file_.valid()) return {};
  FindPlace(SizeOfLog(file_.get()));
  std::vector<std::string> lines;
  for (;;) {
    const std::string text = ReadAt(file_.get(), at_, static_cast<std::size_t>(kPiece));
    if (text.empty()) return lines;
    at_ += static_cast<std::int64_t>(text.size());
    before_ += text;
    before_.erase(0, before_.size() - std::min(before_.size(), kAnchor));
    pending_ += text;
    for (std::string& line : TakeLines(pending_)) lines.push_back(std::move(line));
    if (pending_.size() > kLongestLine) lines.push_back(std::exchange(pending_, {}));
  }
}

// A removed file was made again.
void LogTail::Reopen() {
  struct stat named {};
  struct stat open_file {};
  if (stat(path_.c_str(), &named) != 0) return;
  const bool same = file_.valid() && fstat(file_.get(), &open_file) == 0 &&
                    named.st_dev == open_file.st_dev && named.st_ino == open_file.st_ino;
  if (same) return;
  file_ = OpenLog(path_);
  at_ = 0;
  before_.clear();
}

void LogTail::FindPlace(std::int64_t size) {
  const auto length = static_cast<std::int64_t>(before_.size());
  if (size >= at_ && ReadAt(file_.get(), at_ - length, before_.size()) == before_) return;
  const std::string text = ReadAt(file_.get(), 0, static_cast<std::size_t>(size));
  const std::size_t found = text.rfind(before_);
  at_ = found == std::string::npos ? 0 : static_cast<std::int64_t>(found + before_.size());
  if (found == std::string::npos) {
    before_.clear();
    pending_.clear();
  }
}

}  // namespace musher
