// Cyclone's threads wait by the steady clock.
//
// Cyclone 0.10 waits until a time of the wall clock. Where that is set back, by an hour, its
// threads for heartbeats, acknowledgements and leases wait for an hour more: other processes lose
// this one, and this one does not notice that another one has exited. Cyclone calls the functions
// below by their names, and the dynamic linker takes those of the program before its own.

#include "musher/transport/dds/steady_waits.hpp"

#include <dds/ddsrt/sync.h>
#include <dds/ddsrt/time.h>
#include <dds/version.h>
#include <pthread.h>

#include <algorithm>
#include <chrono>
#include <ctime>

#if DDS_VERSION_MAJOR == 0 && DDS_VERSION_MINOR == 10

bool ddsrt_cond_waitfor(ddsrt_cond_t* cond, ddsrt_mutex_t* mutex, dds_duration_t reltime) {
  using std::chrono::nanoseconds;
  using std::chrono::steady_clock;
  const nanoseconds now = steady_clock::now().time_since_epoch();
  const nanoseconds longest = nanoseconds::max() - now;
  const nanoseconds until = now + std::clamp(nanoseconds(reltime), nanoseconds(0), longest);
  const auto seconds = std::chrono::floor<std::chrono::seconds>(until);
  const timespec end{seconds.count(), (until - seconds).count()};
  return pthread_cond_clockwait(&cond->cond, &mutex->mutex, CLOCK_MONOTONIC, &end) == 0;
}

bool ddsrt_cond_waituntil(ddsrt_cond_t* cond, ddsrt_mutex_t* mutex, dds_time_t abstime) {
  if (abstime == DDS_NEVER) {
    ddsrt_cond_wait(cond, mutex);
    return true;
  }
  return ddsrt_cond_waitfor(cond, mutex, abstime - dds_time());
}

#endif

namespace musher::transport::dds {

void LinkSteadyWaits() {}

}  // namespace musher::transport::dds
