#include "musher/test/fault_injection/host/reaper.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <string>
#include <system_error>

#include "musher/test/fault_injection/robot/processes.hpp"

namespace musher::fault_injection {
namespace {

constexpr const char* kMark = "MUSHER_FAULT_INJECTION";

std::filesystem::path NewFolder() {
  std::string folder = std::filesystem::temp_directory_path() / "musher-fault_injection-XXXXXX";
  if (mkdtemp(folder.data()) == nullptr) {
    throw std::system_error(errno, std::generic_category(), folder);
  }
  return folder;
}

// In the reaper: waits until the fault-injection suite has ended.
void AwaitEnd(int alive) {
  char byte = 0;
  while (read(alive, &byte, 1) < 0 && errno == EINTR) {
  }
}

void Remove(const std::filesystem::path& folder) {
  std::error_code gone;
  for (const auto& robot : std::filesystem::directory_iterator(folder, gone)) {
    umount2((robot.path() / "disk").c_str(), MNT_DETACH);
  }
  std::filesystem::remove_all(folder, gone);
}

}  // namespace

Reaper::Reaper() : folder_(NewFolder()) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) {
    throw std::system_error(errno, std::generic_category(), "pipe2");
  }
  const std::string mark = std::string(kMark) + "=" + std::to_string(getpid());
  pid_ = fork();
  if (pid_ == 0) {
    setsid();  // the reaper gets no Ctrl-C
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) ::signal(signal, SIG_IGN);
    close(ends[1]);
    AwaitEnd(ends[0]);
    KillMarked(mark);
    Remove(folder_);
    _exit(0);
  }
  close(ends[0]);
  alive_ = UniqueFd(ends[1]);
  setenv(kMark, std::to_string(getpid()).c_str(), 1);
}

Reaper::~Reaper() {
  alive_ = {};
  waitpid(pid_, nullptr, 0);
}

}  // namespace musher::fault_injection
