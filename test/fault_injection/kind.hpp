#pragma once
// A kind of fault: how it is injected, and what must follow.

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/test/fault_injection/fault_run.hpp"

namespace musher::fault_injection {

// What a kind needs from the machine it runs on.
enum class Need { kNothing, kMounts, kNetwork };

struct Kind {
  std::string name;
  std::string family;  // the folder it is in
  std::string about;   // what is injected, in a few words
  std::function<void(FaultRun&)> inject;
  Shape shape = Shape::kHere;
  Need need = Need::kNothing;
};

// All kinds, by family.
const std::vector<Kind>& AllKinds();
// Null when there is none of this name.
const Kind* FindKind(const std::string& name);

}  // namespace musher::fault_injection
