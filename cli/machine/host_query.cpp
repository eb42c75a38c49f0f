#include "musher/cli/machine/host_query.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <utility>

#include "musher/base/exit_status.hpp"
#include "musher/base/files.hpp"
#include "musher/base/host.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/controller/process/ssh.hpp"

namespace musher::cli {
namespace {

constexpr std::string_view kBegin = "musher-clock ";
constexpr const char* kFirstCommand = "echo \"musher-clock $(date +%s%N)\"\n";
constexpr std::size_t kMostBytes = 64 << 20;  // of a line
constexpr std::size_t kMostErrors = 4096;
constexpr int kOfSsh = 255;  // its exit code when it has not reached the host

struct Pipe {
  UniqueFd read;
  UniqueFd write;
};
Result<Pipe> MakePipe() {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) return SystemError("can't make a pipe");
  return Pipe{UniqueFd(ends[0]), UniqueFd(ends[1])};
}

// Appends what is there, up to kMostBytes in all; false at its end.
bool Drain(int fd, std::string& text) {
  std::array<char, 16 << 10> buffer{};
  while (text.size() < kMostBytes) {
    const ssize_t count = read(fd, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return errno == EAGAIN;
    if (count == 0) return false;
    text.append(buffer.data(), static_cast<std::size_t>(count));
  }
  return true;
}

}  // namespace

Result<HostScript> HostScript::Start(const HostConfig& host, const std::string& script) {
  auto input = MakePipe();
  auto output = MakePipe();
  auto errors = MakePipe();
  for (const auto* pipe : {&input, &output, &errors}) {
    if (!*pipe) return pipe->error();
  }
  // A pipe has room for a script.
  const std::string input_text = kFirstCommand + script;
  if (!WriteAll(input.value().write.get(), input_text)) return SystemError("can't write a pipe");
  input.value().write = UniqueFd();
  ProgramSpec spec;
  spec.argv = SshArguments(host);
  // From its input no shell of a login has to take it apart.
  spec.argv.emplace_back("exec sh -s");
  spec.env = {{"LC_ALL", "C"}};
  spec.without = {"SSH_ASKPASS"};
  spec.input = input.value().read.get();
  spec.output = output.value().write.get();
  spec.errors = errors.value().write.get();
  spec.after_fork = [](char* const*) { setsid(); };
  auto ssh = ForkProgram(spec);
  if (!ssh) return ssh.error();
  HostScript made(host, std::move(ssh).value());
  made.output_ = std::move(output.value().read);
  made.errors_ = std::move(errors.value().read);
  fcntl(made.output_.get(), F_SETFL, O_NONBLOCK);
  fcntl(made.errors_.get(), F_SETFL, O_NONBLOCK);
  return made;
}

HostScript::HostScript(HostScript&& other) noexcept
    : host_(std::move(other.host_)),
      ssh_(std::move(other.ssh_)),
      ended_(std::exchange(other.ended_, true)),
      output_(std::move(other.output_)),
      errors_(std::move(other.errors_)),
      begun_(other.begun_),
      text_(std::move(other.text_)),
      lines_(std::move(other.lines_)),
      said_(std::move(other.said_)),
      offset_ns_(other.offset_ns_) {}

HostScript::~HostScript() {
  if (ended_) return;
  kill(-ssh_.pid(), SIGKILL);  // with what it has started to connect
  kill(ssh_.pid(), SIGKILL);
  ReapChild(ssh_.pid());
}

bool HostScript::Read() {
  const bool more = Drain(output_.get(), text_);
  Drain(errors_.get(), said_);
  if (said_.size() > kMostErrors) said_.erase(0, said_.size() - kMostErrors);
  std::size_t begin = 0;
  for (std::size_t end = 0; (end = text_.find('\n', begin)) != std::string::npos; begin = end + 1) {
    std::string line = text_.substr(begin, end - begin);
    if (begun_) {
      lines_.push_back(std::move(line));
    } else if (line.starts_with(kBegin)) {
      begun_ = true;
      std::int64_t theirs = 0;
      const std::string clock = line.substr(kBegin.size());
      const char* const last = clock.data() + clock.size();
      const auto read = std::from_chars(clock.data(), last, theirs);
      if (read.ec == std::errc() && read.ptr == last) offset_ns_ = theirs - WallNow();
    }
  }
  text_.erase(0, begin);
  return more && text_.size() < kMostBytes;
}

std::vector<std::string> HostScript::TakeLines() {
  return std::exchange(lines_, {});
}

std::string HostScript::Late(Duration within) const {
  const std::string why = (begun_ ? "its answer was not whole within " : "no answer within ") +
                          std::to_string(ToMilliseconds(within) / 1000) + " s";
  if (begun_) return "host " + host_.name + " (" + host_.Login() + "): " + why;
  return "host " + host_.name + " (" + host_.Login() +
         "): " + SshTroubleOf(why, host_.Login()).text;
}

std::string HostScript::Trouble() {
  if (text_.size() >= kMostBytes) {  // it may print on: ~HostScript() kills it
    return "host " + host_.name + " (" + host_.Login() + "): it has printed a line of more than " +
           std::to_string(kMostBytes >> 20) + " MiB";
  }
  const auto failure = ssh_.Failure(Duration::zero());
  const auto status = ReapChild(ssh_.pid());
  ended_ = true;
  Drain(errors_.get(), said_);
  const bool reached = begun_ && status && !(!status->killed && status->number == kOfSsh);
  if (reached) return {};
  std::string why = failure ? failure->error.message : LastLineOf(said_);
  if (why.empty()) why = "ssh has ended" + (status ? " (" + status->Text() + ")" : "");
  return "host " + host_.name + " (" + host_.Login() +
         "): " + SshTroubleOf(why, host_.Login()).text;
}

std::vector<HostAnswer> QueryHosts(const std::vector<HostQuery>& queries, Duration within,
                                   int interrupt) {
  const Time until = std::chrono::steady_clock::now() + within;
  std::vector<HostAnswer> answers(queries.size());
  std::vector<std::optional<HostScript>> scripts(queries.size());
  for (std::size_t i = 0; i < queries.size(); ++i) {
    auto script = HostScript::Start(*queries[i].host, queries[i].script);
    if (script) {
      scripts[i].emplace(std::move(script).value());
    } else {
      answers[i].trouble = "host " + queries[i].host->name + ": " + script.error().message;
    }
  }
  for (;;) {
    std::vector<pollfd> waits;
    for (const auto& script : scripts) {
      if (script) waits.push_back({script->output(), POLLIN, 0});
    }
    const Duration left = until - std::chrono::steady_clock::now();
    if (waits.empty()) break;
    const auto left_ms = std::chrono::ceil<std::chrono::milliseconds>(left).count();
    if (left_ms <= 0) break;
    waits.push_back({interrupt, POLLIN, 0});
    poll(waits.data(), waits.size(), static_cast<int>(left_ms));
    if (waits.back().revents != 0) break;
    for (std::size_t i = 0; i < scripts.size(); ++i) {
      if (!scripts[i] || scripts[i]->Read()) continue;
      answers[i] = {scripts[i]->TakeLines(), scripts[i]->clock_offset_ns(), scripts[i]->Trouble()};
      scripts[i].reset();
    }
  }
  for (std::size_t i = 0; i < scripts.size(); ++i) {
    if (!scripts[i]) continue;
    answers[i] = {scripts[i]->TakeLines(), scripts[i]->clock_offset_ns(), scripts[i]->Late(within),
                  scripts[i]->begun()};
  }
  return answers;
}

}  // namespace musher::cli
