#include "musher/base/own_folder.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <string_view>

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

}  // namespace musher
