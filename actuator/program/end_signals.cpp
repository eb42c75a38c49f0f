#include "musher/actuator/program/end_signals.hpp"

#include <sys/signalfd.h>
#include <unistd.h>

#include <csignal>
#include <utility>

namespace musher::program {
namespace {

sigset_t Both() {
  sigset_t both;
  sigemptyset(&both);
  sigaddset(&both, SIGTERM);
  sigaddset(&both, SIGINT);
  return both;
}

}  // namespace

EndSignals::EndSignals() {
  const sigset_t both = Both();
  pthread_sigmask(SIG_BLOCK, &both, nullptr);
  fd_ = UniqueFd(signalfd(-1, &both, SFD_CLOEXEC | SFD_NONBLOCK));
}

EndSignals::~EndSignals() {
  const sigset_t both = Both();
  pthread_sigmask(SIG_UNBLOCK, &both, nullptr);
}

transport::LoopHandlePtr EndSignals::Watch(transport::EventLoop& loop,
                                           std::function<void()> stop) const {
  return loop.WhenReadable(fd_.get(), [this, stop = std::move(stop)] {
    stop();
    End();
  });
}

void EndSignals::End() const {
  signalfd_siginfo info{};
  if (read(fd_.get(), &info, sizeof info) != static_cast<ssize_t>(sizeof info)) return;
  const sigset_t both = Both();
  pthread_sigmask(SIG_UNBLOCK, &both, nullptr);
  raise(static_cast<int>(info.ssi_signo));
}

}  // namespace musher::program
