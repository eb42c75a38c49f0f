#pragma once
// Drawings by Graphviz.

#include <string>

#include "musher/base/result.hpp"

namespace musher::cli {

// Renders a DOT text to SVG with the program `dot`. If it is missing, the error names what to
// install.
Result<std::string> RenderSvg(const std::string& dot);

}  // namespace musher::cli
