#include <signal.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "musher/view/record/commands.hpp"

namespace musher::view {

bool OnTerminal() {
  return isatty(STDERR_FILENO) == 1;
}

void ShowLine(const std::string& line) {
  std::fprintf(stderr, "\r\x1b[K%s", line.c_str());
}

void Print(const std::string& sentence) {
  if (OnTerminal()) ShowLine("");  // over the line that shows the progress
  std::fprintf(stderr, "musher-record: %s\n", sentence.c_str());
}

int Fail(const Error& error, int exit) {
  Print(error.message);
  return exit;
}

Result<std::unique_ptr<transport::Node>> JoinDomain(transport::EventLoop& loop,
                                                    const DomainOptions& where) {
  transport::DdsOptions options;
  options.domain_id = where.domain;
  options.discovery = transport::DiscoveryTiming::kAtOnce;
  options.unicast = true;
  options.hidden = true;
  const char* keys = std::getenv("MUSHER_KEYS");          // NOLINT(concurrency-mt-unsafe)
  const char* identity = std::getenv("MUSHER_IDENTITY");  // NOLINT(concurrency-mt-unsafe)
  if (keys != nullptr && *keys != '\0') {
    options.credentials = transport::Credentials{keys, identity != nullptr ? identity : "operator"};
  }
  return transport::MakeDdsNode(loop, options);
}

Result<UniqueFd> EndSignals() {
  sigset_t set;
  sigemptyset(&set);
  for (const int one : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&set, one);
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  signal(SIGXFSZ, SIG_IGN);  // a write beyond the limit of a file's size fails instead
  UniqueFd fd(signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK));
  if (!fd.valid()) {
    return Error{kCodeFailed, std::strerror(errno)};  // NOLINT(concurrency-mt-unsafe)
  }
  return fd;
}

}  // namespace musher::view
