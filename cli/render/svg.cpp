#include "musher/cli/render/svg.hpp"

#include <cstdio>

#include "musher/base/program.hpp"

namespace musher::cli {

Result<std::string> RenderSvg(const std::string& dot) {
  const auto drawn = RunProgram({.argv = {"dot", "-Tsvg"}, .cwd = "", .env = {}}, dot);
  if (!drawn) return drawn.error();
  if (const auto& failure = drawn.value().failure) {
    if (!failure->missing) return failure->error;
    return Error{kCodeFailed,
                 "SVG needs the program 'dot', which is not installed: install the package "
                 "graphviz, or use --format dot or mermaid"};
  }
  if (!drawn.value().status.ok()) {
    return Error{kCodeFailed, "Graphviz could not draw the graph: " + drawn.value().errors};
  }
  std::fputs(drawn.value().errors.c_str(), stderr);  // warnings
  return drawn.value().output;
}

}  // namespace musher::cli
