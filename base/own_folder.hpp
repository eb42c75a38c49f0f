#pragma once
// Threads: any.

#include <sys/types.h>

#include <optional>
#include <string>

#include "musher/base/result.hpp"

namespace musher {

// Fails with kCodePermissionDenied if another user than this one and root can change what is in the
// folder: that user could put links there to files that only this process may write, or keys of
// their own. The error names the folder, the user and what to do. A folder that does not exist is
// fine.
Result<> CheckOwnFolder(const std::string& folder);

// The id of a group of this host; nullopt: it has none of that name.
std::optional<gid_t> GroupNamed(const std::string& name);

// Lets the members of a group list a folder of ours and read the files in it, those that are made
// there later, too; never change them. Files that the group of their owner may not read stay
// closed. Fails if the group does not exist, if this process may not give files to it, or if its
// umask keeps new files from their group; the error says what to do.
Result<> ShareFolder(const std::string& folder, const std::string& group);

}  // namespace musher
