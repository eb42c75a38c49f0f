#pragma once
// The name of the user of this process, where it must not wait.
//
// Threads: any.

#include <string>

namespace musher {

// UserAtHost() without the database of users, which may be on a network that is lost: by
// /etc/passwd, else by $LOGNAME, else the number.
std::string UserAtHostAtOnce();

}  // namespace musher
