#include "musher/controller/cli/render/svg.hpp"

#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>

#include "musher/base/host.hpp"
#include "musher/base/unique_fd.hpp"

namespace musher::cli {
namespace {

// An anonymous file in memory: `dot` reads one and writes another, so neither end ever blocks.
Result<UniqueFd> MemoryFile(const std::string& content) {
  UniqueFd file(memfd_create("musher-graph", MFD_CLOEXEC));
  if (!file.valid()) return SystemError("memfd_create");
  std::size_t done = 0;
  while (done < content.size()) {
    const ssize_t written = write(file.get(), content.data() + done, content.size() - done);
    if (written < 0) return SystemError("writing the graph");
    done += written;
  }
  lseek(file.get(), 0, SEEK_SET);
  return file;
}

std::string Content(int file) {
  std::string content;
  std::array<char, 1 << 16> part{};
  lseek(file, 0, SEEK_SET);
  for (ssize_t size = 0; (size = read(file, part.data(), part.size())) > 0;) {
    content.append(part.data(), size);
  }
  return content;
}

}  // namespace

Result<std::string> RenderSvg(const std::string& dot) {
  auto input = MemoryFile(dot);
  auto output = MemoryFile("");
  if (!input) return input.error();
  if (!output) return output.error();

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input.value().get(), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, output.value().get(), STDOUT_FILENO);
  std::string program = "dot";
  std::string option = "-Tsvg";
  std::array<char*, 3> argv = {program.data(), option.data(), nullptr};
  pid_t pid = 0;
  const int error = posix_spawnp(&pid, "dot", &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error == ENOENT) {
    return Error{kCodeFailed,
                 "SVG needs the program 'dot', which is not installed: install the package "
                 "graphviz, or use --format dot or mermaid"};
  }
  if (error != 0) return SystemError("dot", error);
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    return Error{kCodeFailed, "Graphviz could not draw the graph"};
  }
  return Content(output.value().get());
}

}  // namespace musher::cli
