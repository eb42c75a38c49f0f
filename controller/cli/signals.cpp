#include "musher/controller/cli/signals.hpp"

#include <signal.h>
#include <sys/signalfd.h>

#include <cerrno>
#include <system_error>

namespace musher::cli {

transport::UniqueFd TakeEndSignals() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&set, signal);
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  transport::UniqueFd signals(signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK));
  if (!signals.valid()) throw std::system_error(errno, std::generic_category(), "signalfd");
  return signals;
}

int NextSignal(const transport::UniqueFd& signals) {
  signalfd_siginfo info{};
  if (read(signals.get(), &info, sizeof(info)) != sizeof(info)) return 0;
  return static_cast<int>(info.ssi_signo);
}

}  // namespace musher::cli
