#pragma once
// Reads files and folders that may vanish meanwhile: /proc/<pid> vanishes when its process exits.
// The standard library's iterators throw then, these functions do not. Replaces files while other
// processes read them.
//
// Threads: any.

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/base/unique_fd.hpp"

namespace musher {

// The bytes of a file; empty if it cannot be read to its end.
std::string ReadFile(const std::filesystem::path& file);

// Opens a regular file for reading, never through a link, and without waiting: another user may
// have put a link, a pipe or a device in its place. Not valid on failure; errno gives the reason,
// EINVAL if it is no regular file.
UniqueFd OpenRegular(const std::string& path);

// Writes a file that no process reads meanwhile, also a device such as /dev/stdout.
Result<> WriteFile(const std::string& path, std::string_view content);

// Whether all of it was written; else errno gives the reason. An interrupted write goes on.
bool WriteAll(int fd, std::string_view text);

// Replaces the content of a file, or makes it: a reader gets the old or the new content, never a
// part. It is written to `path` + `draft` first; writers of the same file at the same time need
// drafts of their own.
struct ReplaceOptions {
  mode_t mode = 0644;
  bool synced = true;  // also after a power cut; waits for the disk
  std::string draft = ".new";
};
Result<> ReplaceFile(const std::string& path, std::string_view content,
                     const ReplaceOptions& options = {});

// Waits until the names of the files in a folder are on disk; on failure errno gives the reason.
bool SyncFolder(const std::string& folder);

// What a folder contains, in no order. `error` is set if it cannot be read to its end.
std::vector<std::filesystem::path> EntriesOf(const std::filesystem::path& folder,
                                             std::error_code& error);
// As far as the folder can be read.
std::vector<std::filesystem::path> EntriesOf(const std::filesystem::path& folder);

}  // namespace musher
