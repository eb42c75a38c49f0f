#pragma once
// Checksums of the journal's rows.

#include <cstdint>
#include <string>

#include "musher/base/checksum.hpp"
#include "musher/controller/journal/journal.hpp"

namespace musher {

inline std::int64_t ChecksumOf(std::int64_t id, const JournalEntry& e) {
  constexpr char kEnd = '\0';  // separates the texts
  std::string all;
  for (const std::int64_t number : {id, e.wall_ns, e.steady_ns, std::int64_t(e.epoch.value()),
                                    std::int64_t(e.switch_number.value()), std::int64_t(e.code),
                                    std::int64_t(e.id.value()), std::int64_t(e.cause.value())}) {
    all += std::to_string(number) + kEnd;
  }
  for (const auto* text : {&e.kind, &e.actuator, &e.message, &e.data, &e.state.name()}) {
    all += *text + kEnd;
  }
  if (!e.event.empty()) all += e.event + kEnd;  // entries of older versions have none
  return static_cast<std::int64_t>(Fnv1a(all));
}

inline std::int64_t ChecksumOf(std::int64_t id, std::int64_t wall_ns, const std::string& kind,
                               const std::string& data) {
  const std::string all = std::to_string(id) + ' ' + std::to_string(wall_ns) + kind + data;
  return static_cast<std::int64_t>(Fnv1a(all));
}

}  // namespace musher
