#pragma once
// Trees as the documents of the competition draw them:
//
//   <SwitchSegmentType segment_type="{segment_type}">
//     <Move segment_type="move" …/>                an attribute says which segments a child is for
//     <ForceSuccess segment_type="PLAN_DONE"/>     a decorator without a child
//   </SwitchSegmentType>
//
// Here and in the competition's own trees the name of a child decides, and <ForceSuccess> has a
// child. AcceptDrawnForm() makes that form of them, with a warning for each. A child whose name
// says something else than its segment_type is an error. Pure; never throws.

#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/behavior/tree/document.hpp"

namespace musher::meilin {

std::vector<Diagnostic> AcceptDrawnForm(tree::Document& document);

}  // namespace musher::meilin
