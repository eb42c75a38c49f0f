#pragma once
// The types of ports as BehaviorTree.CPP writes them in models; only for models.cpp and
// placeholder.cpp.

#include <string>
#include <string_view>

#include "musher/behavior/tree/setup.hpp"

namespace musher::tree {

// "unsigned int"; empty: any, or a type without a known name.
std::string TypeNameOf(const PortModel& port);
// Null: any, or an unknown name.
const Type* TypeNamed(std::string_view name);

}  // namespace musher::tree
