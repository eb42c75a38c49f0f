#include "musher/test/campaign/host/keeper.hpp"

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

#include "musher/test/campaign/robot/processes.hpp"

namespace musher::campaign {
namespace {

constexpr const char* kMark = "MUSHER_CAMPAIGN";

std::filesystem::path NewFolder() {
  std::string folder = std::filesystem::temp_directory_path() / "musher-campaign-XXXXXX";
  if (mkdtemp(folder.data()) == nullptr) {
    throw std::system_error(errno, std::generic_category(), folder);
  }
  return folder;
}

// In the keeper: until the campaign has ended.
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

Keeper::Keeper() : folder_(NewFolder()) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) {
    throw std::system_error(errno, std::generic_category(), "pipe2");
  }
  const std::string mark = std::string(kMark) + "=" + std::to_string(getpid());
  pid_ = fork();
  if (pid_ == 0) {
    setsid();  // Ctrl-C is not for the keeper
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) ::signal(signal, SIG_IGN);
    close(ends[1]);
    AwaitEnd(ends[0]);
    KillMarked(mark);
    Remove(folder_);
    _exit(0);
  }
  close(ends[0]);
  alive_ = transport::UniqueFd(ends[1]);
  setenv(kMark, std::to_string(getpid()).c_str(), 1);
}

Keeper::~Keeper() {
  alive_ = {};
  waitpid(pid_, nullptr, 0);
}

}  // namespace musher::campaign
