#include "musher/modules/navigation/server/end_signals.hpp"

#include <pthread.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <csignal>

namespace musher::navigation {
namespace {

sigset_t EndSignalSet() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGTERM, SIGINT}) sigaddset(&signals, signal);
  return signals;
}

}  // namespace

EndSignals::EndSignals() {
  const sigset_t signals = EndSignalSet();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  fd_ = UniqueFd(signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK));
}

void EndSignals::End() const {
  signalfd_siginfo info{};
  if (read(fd_.get(), &info, sizeof info) != sizeof info) return;
  const sigset_t signals = EndSignalSet();
  pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
  raise(static_cast<int>(info.ssi_signo));
}

}  // namespace musher::navigation
