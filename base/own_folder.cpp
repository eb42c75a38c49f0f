#include "musher/base/own_folder.hpp"

#include <fcntl.h>
#include <grp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <string_view>
#include <vector>

#include "musher/base/files.hpp"
#include "musher/base/host.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/base/words.hpp"

namespace musher {
namespace {

bool IsOurs(const struct stat& info) {
  return info.st_uid == geteuid() || info.st_uid == 0;
}

Error Untrusted(const std::string& what, const std::string& command) {
  return {kCodePermissionDenied, what +
                                     ", who could replace files in it and put links there; run `" +
                                     command + "`, or choose another folder"};
}

// Gives files that were made before, and have the group of their maker, the group of the folder.
void ShareFiles(const std::string& folder, gid_t group) {
  for (const std::filesystem::path& file : EntriesOf(std::filesystem::path(folder))) {
    struct stat info {};
    if (lstat(file.c_str(), &info) != 0) continue;
    const bool ours = S_ISREG(info.st_mode) && info.st_uid == geteuid() && info.st_gid != group;
    if (!ours || (info.st_mode & S_IRGRP) == 0) continue;
    if (lchown(file.c_str(), static_cast<uid_t>(-1), group) != 0) return;
  }
}

// As the process has it now.
mode_t OwnUmask() {
  const mode_t mask = umask(077);  // strict, for a file that another thread makes now
  umask(mask);
  return mask;
}

}  // namespace

Result<> CheckOwnFolder(const std::string& folder) {
  struct stat link {};
  struct stat info {};
  if (lstat(folder.c_str(), &link) != 0 || stat(folder.c_str(), &info) != 0) return Ok();
  const std::string quoted = ShellWord(folder);
  for (const struct stat& one : {link, info}) {
    if (IsOurs(one)) continue;
    return Untrusted(folder + " belongs to user " + std::to_string(one.st_uid),
                     "chown -R -h " + std::to_string(geteuid()) + " " + quoted);
  }
  // Many users have a group of their own, which new folders are writable for.
  const bool own_group = info.st_gid == getegid() && geteuid() != 0;
  const mode_t others = S_IWOTH | (own_group ? 0 : S_IWGRP);
  if ((info.st_mode & others) == 0) return Ok();
  const bool all = (info.st_mode & S_IWOTH) != 0;
  return Untrusted(
      folder + " is writable for " + (all ? "all users" : "group " + std::to_string(info.st_gid)),
      "chmod go-w " + quoted);
}

std::optional<gid_t> GroupNamed(const std::string& name) {
  std::vector<char> text(1 << 10);
  struct group entry {};
  struct group* found = nullptr;
  while (getgrnam_r(name.c_str(), &entry, text.data(), text.size(), &found) == ERANGE) {
    text.resize(2 * text.size());  // it has many members
  }
  return found == nullptr ? std::nullopt : std::optional(entry.gr_gid);
}

Result<> ShareFolder(const std::string& folder, const std::string& group) {
  const auto id = GroupNamed(group);
  if (!id) return Error{kCodeParametersInvalid, "this host has no group '" + group + "'"};
  if ((OwnUmask() & S_IRGRP) != 0) {
    return Error{kCodePermissionDenied, "group " + group + " cannot read " + folder +
                                            ": the umask keeps new files from it; use umask 027"};
  }
  const UniqueFd fd(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  struct stat info {};
  if (!fd.valid() || fstat(fd.get(), &info) != 0) return SystemError("can't open " + folder);
  if (info.st_gid != *id && fchown(fd.get(), static_cast<uid_t>(-1), *id) != 0) {
    if (errno != EPERM) return SystemError("can't give " + folder + " to group " + group);
    return Error{kCodePermissionDenied,
                 "group " + group + " cannot read " + folder +
                     ": only a member may give files to a group; run `sudo usermod -aG " + group +
                     " \"$USER\"` and log in again"};
  }
  // What is made in it has its group, not that of the process.
  const mode_t mode = (info.st_mode & 07777) | S_ISGID | S_IRGRP | S_IXGRP;
  if (mode != (info.st_mode & 07777) && fchmod(fd.get(), mode) != 0) {
    return SystemError("can't share " + folder + " with group " + group);
  }
  ShareFiles(folder, *id);
  return Ok();
}

}  // namespace musher
