#include "musher/cli/start/controller_log.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <mutex>
#include <utility>

#include "musher/base/host.hpp"
#include "musher/base/own_folder.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/base/words.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/controller/storage/private_folder.hpp"

namespace musher::cli {
namespace {

constexpr std::size_t kMostWaiting = 1 << 20;  // bytes

std::string LogLine(std::string_view text, std::int32_t code) {
  return LocalText(WallNow()) + (code == kCodeOk ? " info: " : " warning: ") +
         WithCode(std::string(text), code) + "\n";
}

}  // namespace

struct ControllerLog::State {
  const std::string path;
  const bool may_be_link;

  // Used by the disk thread only.
  UniqueFd file;
  bool took_output = false;  // stdout and stderr
  bool reported = false;

  std::mutex mutex;  // guards the members below; never held during I/O
  std::string waiting;
  std::uint64_t dropped = 0;  // lines, newer than `waiting`

  State(std::string p, bool link) : path(std::move(p)), may_be_link(link) {}

  void Add(const std::string& line) {
    const std::lock_guard lock(mutex);
    if (waiting.size() + line.size() > kMostWaiting) {
      ++dropped;
      return;
    }
    waiting += TakeDropNote();
    waiting += line;
  }
  // The mutex must be held.
  std::string TakeDropNote() {
    if (dropped == 0) return "";
    return LogLine(
        Counted(std::exchange(dropped, 0), "line") + " dropped here: the disk was too slow",
        kCodeFailed);
  }

  Result<> Drain() {
    if (auto opened = Open(); !opened) return opened;
    while (true) {
      std::string text;
      {
        const std::lock_guard lock(mutex);
        text = std::exchange(waiting, {});
        if (text.empty()) text = TakeDropNote();
      }
      if (text.empty()) return Ok();
      const std::size_t written = WriteSome(text);
      if (written == text.size()) continue;
      const Error error = SystemError("can't write " + path);
      const std::lock_guard lock(mutex);
      waiting.insert(0, text, written);
      return error;
    }
  }

  // Opens the file; opens it again if it was removed.
  Result<> Open() {
    struct stat named {};
    struct stat open_file {};
    if (file.valid() && stat(path.c_str(), &named) == 0 && fstat(file.get(), &open_file) == 0 &&
        named.st_dev == open_file.st_dev && named.st_ino == open_file.st_ino) {
      return Ok();
    }
    auto made = MakePrivateFolder(std::filesystem::path(path).parent_path());
    // Where another user can put a link, or could before the folder became ours, none is followed.
    const auto folder = std::filesystem::path(path).parent_path();
    const int links = may_be_link && CheckOwnFolder(folder) ? 0 : O_NOFOLLOW;
    file = UniqueFd(open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC | links, 0644));
    if (file.valid()) made = Ok();
    if (!file.valid() && made) made = SystemError("can't write " + path);
    if (!made && !std::exchange(reported, true)) {
      std::fprintf(stderr, "musher: no log: %s\n", made.error().message.c_str());
    }
    if (file.valid() || !took_output) TakeStandardOutput();
    return made;
  }

  void TakeStandardOutput() {
    took_output = true;
    const UniqueFd nowhere(open("/dev/null", O_RDWR | O_CLOEXEC));
    // Without a free descriptor stdin serves, which is /dev/null: a reader of this process's output
    // must not wait for it.
    const int nothing = nowhere.valid() ? nowhere.get() : STDIN_FILENO;
    const int target = file.valid() ? file.get() : nothing;
    for (const int fd : {STDOUT_FILENO, STDERR_FILENO}) dup2(target, fd);
  }

  std::size_t WriteSome(std::string_view text) const {
    std::size_t done = 0;
    while (done < text.size()) {
      const ssize_t written = write(file.get(), text.data() + done, text.size() - done);
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) break;
      done += static_cast<std::size_t>(written);
    }
    return done;
  }
};

ControllerLog::ControllerLog(transport::DiskWriter& disk, std::string path, bool may_be_link)
    : disk_(disk), state_(std::make_shared<State>(std::move(path), may_be_link)) {}

void ControllerLog::Write(std::string_view line, std::int32_t code) {
  state_->Add(LogLine(line, code));
  disk_.Do("controller.log", [state = state_] { return state->Drain(); });
}

}  // namespace musher::cli
