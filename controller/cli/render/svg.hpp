#pragma once
// Drawings by Graphviz.

#include <string>

#include "musher/lifecycle/result.hpp"

namespace musher::cli {

// The SVG that the program `dot` makes of a DOT text. Fails, saying what to install, where there is
// no such program.
Result<std::string> RenderSvg(const std::string& dot);

}  // namespace musher::cli
