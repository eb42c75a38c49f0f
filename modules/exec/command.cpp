#include "musher/modules/exec/command.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <optional>
#include <utility>

#include "musher/base/host.hpp"
#include "musher/base/output_thread.hpp"
#include "musher/base/toml/text.hpp"

namespace musher::exec {
namespace {

constexpr int kPollPeriodMs = 20;
constexpr std::size_t kLongestLine = 200;  // bytes
constexpr std::size_t kMostKept = 4 * kLongestLine;

// A running command.
class RunningCommand {
 public:
  RunningCommand(Child child, UniqueFd output, Duration stop_time)
      : child_(std::move(child)), output_(std::move(output)), stop_time_(stop_time) {}

  CommandEnd Finish(const std::function<Wanted()>& wanted) {
    while (!child_.Ended()) {
      Wait();
      ReadOutput();
      Handle(wanted());
    }
    ReadOutput();
    const ExitStatus status = child_.Reap();
    return {status, stopped_, line_.Get()};
  }

 private:
  void Wait() {
    std::array<pollfd, 2> sources{{{child_.pidfd(), POLLIN, 0}, {output_.get(), POLLIN, 0}}};
    poll(sources.data(), output_.valid() ? 2 : 1, kPollPeriodMs);
  }

  // Reads what is available now; a process left behind by the command may hold the other end open.
  void ReadOutput() {
    std::array<char, 4096> buffer;
    while (output_.valid()) {
      const ssize_t got = read(output_.get(), buffer.data(), buffer.size());
      if (got < 0 && errno == EINTR) continue;
      if (got < 0 && errno == EAGAIN) return;
      if (got <= 0) {
        output_ = UniqueFd();
        return;
      }
      const std::string_view text(buffer.data(), static_cast<std::size_t>(got));
      StandardOutput().Write(
          std::string(text));  // the command is watched on, whatever its log does
      line_.Add(text);
      if (child_.Ended() && text.size() < buffer.size()) return;
    }
  }

  void Handle(Wanted wanted) {
    if (wanted == Wanted::kYes) return;
    const Time now = std::chrono::steady_clock::now();
    if (wanted == Wanted::kGetDone || (kill_at_ && now >= *kill_at_)) {
      child_.Signal(SIGKILL);
    } else if (!kill_at_) {
      child_.Signal(SIGTERM);
      kill_at_ = now + stop_time_;
    }
    stopped_ = true;
  }

  Child child_;
  UniqueFd output_;
  const Duration stop_time_;
  LastLine line_;
  std::optional<Time> kill_at_;
  bool stopped_ = false;
};

}  // namespace

Result<CommandEnd> RunCommand(const ChildSpec& spec, const Reaper& reaper, Duration stop_time,
                              const std::function<Wanted()>& wanted) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return SystemError("can't make a pipe");
  UniqueFd reader(ends[0]);
  UniqueFd writer(ends[1]);
  fcntl(reader.get(), F_SETFL, O_NONBLOCK);
  auto child = Child::Start(spec, reaper, writer.get());
  if (!child) return child.error();
  writer = UniqueFd();  // so that only the command holds the write end
  return RunningCommand(std::move(child).value(), std::move(reader), stop_time).Finish(wanted);
}

void LastLine::Add(std::string_view text) {
  for (const char c : text) {
    if (c == '\n') {
      if (current_.find_first_not_of(" \t\r") != std::string::npos) last_ = current_;
      current_.clear();
    } else if (current_.size() < kMostKept) {
      current_ += c;
    }
  }
}

std::string LastLine::Get() const {
  const bool unfinished = current_.find_first_not_of(" \t\r") != std::string::npos;
  std::string_view line = unfinished ? current_ : last_;
  std::string clean;
  while (!line.empty()) {
    const std::size_t size = std::max<std::size_t>(config_toml::CharacterSize(line), 1);
    const auto byte = static_cast<unsigned char>(line.front());
    if (clean.size() + size > kLongestLine) break;
    if (config_toml::CharacterSize(line) == 0) {
      clean += '?';
    } else if (byte >= 0x20 && byte != 0x7F) {
      clean += line.substr(0, size);
    }
    line.remove_prefix(size);
  }
  return clean;
}

}  // namespace musher::exec
