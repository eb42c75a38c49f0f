#include "musher/test/support/wait.hpp"

#include <poll.h>
#include <sys/inotify.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>

#include "musher/base/unique_fd.hpp"

namespace musher::testing {
namespace {

constexpr auto kFileLimit = std::chrono::seconds(120);

bool AwaitChangeUntil(Time deadline, const std::string& folder,
                      const std::function<bool()>& holds) {
  const UniqueFd changes(inotify_init1(IN_CLOEXEC));
  const auto watch = [&] {  // again each time: another folder may have its name
    return inotify_add_watch(changes.get(), folder.c_str(),
                             IN_MODIFY | IN_CREATE | IN_DELETE | IN_MOVED_TO | IN_DELETE_SELF) >= 0;
  };
  for (bool watched = watch(); !holds(); watched = watch()) {
    if (!watched || !AwaitReadable(changes.get(), deadline)) return false;
    std::array<char, 4096> events{};
    if (read(changes.get(), events.data(), events.size()) < 0) return false;
  }
  return true;
}

bool AwaitFileUntil(Time deadline, const std::filesystem::path& path) {
  const auto exists = [&path] { return std::filesystem::exists(path); };
  while (!exists()) {
    const auto folder = path.parent_path();
    if (!AwaitFileUntil(deadline, folder)) return false;
    // A folder that is removed meanwhile is awaited again.
    const auto holds = [&] { return exists() || !std::filesystem::exists(folder); };
    if (!AwaitChangeUntil(deadline, folder, holds)) return false;
  }
  return true;
}

}  // namespace

Time In(Duration duration) {
  return std::chrono::steady_clock::now() + duration;
}

bool AwaitReadable(int descriptor, Time deadline) {
  const auto rest = std::chrono::ceil<std::chrono::milliseconds>(
      std::max(deadline - std::chrono::steady_clock::now(), Duration::zero()));
  pollfd readable{descriptor, POLLIN, 0};
  return poll(&readable, 1, static_cast<int>(rest.count())) == 1;
}

bool AwaitChange(const std::string& folder, const std::function<bool()>& holds) {
  return AwaitChangeUntil(In(kFileLimit), folder, holds);
}

bool AwaitFile(const std::string& path) {
  return AwaitFileUntil(In(kFileLimit), path);
}

bool Until(const std::function<bool()>& holds, Duration limit) {
  for (const Time deadline = In(limit); !holds();) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    poll(nullptr, 0, 1);  // what it waits for needs the CPU
  }
  return true;
}

}  // namespace musher::testing
