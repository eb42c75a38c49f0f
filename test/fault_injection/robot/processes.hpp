#pragma once
// Processes of a robot, found and ended by their ids.

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

namespace musher::fault_injection {

// The arguments of a process; empty when it has ended.
std::vector<std::string> CommandLine(pid_t pid);
// Processes whose command line has `word` as a whole argument, as this pid namespace numbers them.
std::vector<pid_t> FindByArgument(const std::string& word);
std::vector<pid_t> ChildrenOf(pid_t pid);
bool IsAlive(pid_t pid);  // a zombie is not
// The state letter of /proc/<pid>/stat, 'T' for a stopped process; 0 when it has ended.
char StateLetterOf(pid_t pid);

// From now on orphans of this process's children become its children.
void AdoptOrphans();
// Reaps the ended children, except `but_not`.
void ReapOrphans(const std::vector<pid_t>& but_not);

// Ends every process that was started with this variable in its environment.
void KillMarked(const std::string& variable);

}  // namespace musher::fault_injection
