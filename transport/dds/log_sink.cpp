#include "musher/transport/dds/log_sink.hpp"

#include <algorithm>
#include <chrono>
#include <functional>
#include <map>
#include <mutex>
#include <string>

#include "musher/base/output_thread.hpp"

namespace musher::transport::dds {

std::string LogKey(std::string_view text) {
  constexpr std::string_view kFailed = " failed with retcode ";
  constexpr std::string_view kTo = "_write to ";
  const std::size_t failed = text.find(kFailed);
  const std::size_t to = text.find(kTo);
  if (failed == std::string_view::npos || to == std::string_view::npos || to > failed) {
    return std::string(text);
  }
  return std::string(text.substr(0, to + kTo.size())).append(text.substr(failed));
}

void LogOnceAMinute(void*, const dds_log_data_t* data) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::minutes kPause(1);
  constexpr std::size_t kMostLines = 256;  // remembered
  static std::mutex mutex;
  static std::map<std::string, Clock::time_point, std::less<>> logged;
  const std::lock_guard lock(mutex);
  const std::string_view line(data->message, data->size);
  const std::string key = LogKey(line.substr(std::min(line.size(), data->hdrsize)));
  const Clock::time_point now = Clock::now();
  if (const auto last = logged.find(key); last != logged.end()) {
    if (now - last->second < kPause) return;
    last->second = now;
  } else {
    if (logged.size() >= kMostLines) logged.clear();
    logged.emplace(key, now);
  }
  StandardError().Write(std::string(line));  // Cyclone's threads do not wait for a disk
}

}  // namespace musher::transport::dds
