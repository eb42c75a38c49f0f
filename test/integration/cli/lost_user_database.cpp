// A database of users on a network that is lost, for a process that preloads this library: a look
// into it waits while the file $MUSHER_USERS_LOST_WHILE exists, at most a minute, and finds none.

#include <poll.h>
#include <pwd.h>
#include <unistd.h>

#include <cstdlib>

extern "C" int getpwuid_r(uid_t, passwd*, char*, std::size_t, passwd** found) {
  constexpr int kStepMs = 1;
  constexpr int kMostSteps = 60'000;
  const char* lost = std::getenv("MUSHER_USERS_LOST_WHILE");  // NOLINT(concurrency-mt-unsafe)
  for (int step = 0; step < kMostSteps && lost != nullptr && access(lost, F_OK) == 0; ++step) {
    poll(nullptr, 0, kStepMs);
  }
  *found = nullptr;
  return 0;
}
