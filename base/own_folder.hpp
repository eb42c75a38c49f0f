#pragma once
// Threads: any.

#include <string>

#include "musher/base/result.hpp"

namespace musher {

// Fails with kCodePermissionDenied if another user than this one and root can change what is in the
// folder: that user could put links there to files that only this process may write, or keys of
// their own. The error names the folder, the user and what to do. A folder that does not exist is
// fine.
Result<> CheckOwnFolder(const std::string& folder);

}  // namespace musher
