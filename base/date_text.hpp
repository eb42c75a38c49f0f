#pragma once
// Points in time of the wall clock as text.
//
// Threads: any.

#include <chrono>
#include <cstdint>
#include <string>

namespace musher {

// From nanoseconds since 1970, rounded to the past.
std::chrono::sys_seconds WholeSeconds(std::int64_t wall_ns);

// "2026-11-26T09:58:09Z".
inline constexpr const char* kIsoUtc = "%Y-%m-%dT%H:%M:%SZ";

// `pattern`: of strftime(), for at most 127 characters. A time whose year does not fit into an int
// is written as date(1) reads it: "@" and the seconds since 1970.
std::string FormatUtc(std::chrono::sys_seconds time, const char* pattern = kIsoUtc);
std::string FormatLocal(std::chrono::sys_seconds time, const char* pattern);  // in the zone of TZ

}  // namespace musher
