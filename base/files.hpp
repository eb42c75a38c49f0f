#pragma once
// Files and folders that may vanish while they are read, as those of /proc/<pid> do when the
// process exits. The standard library's iterators over files and folders throw then; these
// functions do not.
//
// Threads: any.

#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace musher {

// The bytes of a file; empty if it cannot be read to its end.
std::string ReadFile(const std::filesystem::path& file);

// Whether all of it was written; errno says why not. An interrupted write goes on.
bool WriteAll(int fd, std::string_view text);

// What a folder contains, in no order. `error` is set if it cannot be read to its end.
std::vector<std::filesystem::path> EntriesOf(const std::filesystem::path& folder,
                                             std::error_code& error);
// As far as the folder can be read.
std::vector<std::filesystem::path> EntriesOf(const std::filesystem::path& folder);

}  // namespace musher
