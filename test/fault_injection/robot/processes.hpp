#pragma once
// Processes of a robot, found and ended by their ids.

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

namespace musher::fault_injection {

// All that a process was started with; empty when it is gone.
std::vector<std::string> CommandLine(pid_t pid);
// Processes whose command line has `word` as a whole argument, as this pid namespace numbers them.
std::vector<pid_t> FindByArgument(const std::string& word);
std::vector<pid_t> ChildrenOf(pid_t pid);
bool IsAlive(pid_t pid);  // a zombie is not
// The state letter of /proc/<pid>/stat, 'T' for one that is stopped; 0 when it is gone.
char StateLetterOf(pid_t pid);

// From now on orphans of our children are our children.
void AdoptOrphans();
// Collects those children that have ended.
void ReapOrphans(const std::vector<pid_t>& but_not);

// Ends every process that was started with this variable in its environment.
void KillMarked(const std::string& variable);

}  // namespace musher::fault_injection
