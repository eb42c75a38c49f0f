#pragma once
// A chart as a drawing: DOT for Graphviz (which makes SVG of it), Mermaid for a Markdown page.
//
// The start state has a dot before it, a final state a double border, the safe state corners and a
// red border. The machine can go to the safe state from every state, so those arrows are not drawn.
// A machine inside is drawn in its state. The same chart gives the same text.

#include <string>
#include <string_view>

#include "musher/behavior/fsm/chart.hpp"

namespace musher::fsm {

// `present` is marked: a path as Machine::Path() gives it, "" for none.
std::string ToDot(const Chart& chart, std::string_view present = {});
std::string ToMermaid(const Chart& chart, std::string_view present = {});

}  // namespace musher::fsm
