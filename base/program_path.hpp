#pragma once
// Where programs are: this process's own, and those that PATH finds.
//
// Threads: PutFirstInPath() changes the environment, so that no other thread may read it then.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace musher {

// The file of the running program. Empty if /proc cannot be read.
std::filesystem::path OwnProgram();

// PATH of this process; the usual folders of a host if it has none.
std::string SearchPath();
void PutFirstInPath(const std::string& folder);

// The files that `program`, a name without '/', may be, in the order of `path`. An empty entry of
// `path` is the working directory.
std::vector<std::string> CandidatesInPath(std::string_view program, std::string_view path);

// The first file in a folder of `path` that may be executed. Not one of the working directory: an
// empty entry is skipped. Empty: there is none.
std::string FindInPath(std::string_view program, std::string_view path = SearchPath());

}  // namespace musher
