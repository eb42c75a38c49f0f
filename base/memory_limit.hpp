#pragma once
// How much memory this process may use, from the kernel.
//
// Threads: any. Nothing throws. `root`: of the file system, for tests.

#include <cstdint>
#include <filesystem>
#include <optional>

namespace musher {

// The least limit of the process's control group and of those above it, of cgroup v1 and v2, in
// bytes; nullopt: they have none.
std::optional<std::uint64_t> MemoryLimitOfGroups(const std::filesystem::path& root = "/");

// What all processes together can still use without swapping, in bytes; nullopt if the kernel does
// not report it.
std::optional<std::uint64_t> AvailableMemory(const std::filesystem::path& root = "/");

}  // namespace musher
