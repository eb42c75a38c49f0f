#pragma once
// Ports as BehaviorTree.CPP writes them in models; only for models.cpp, placeholder.cpp and
// write_tree.cpp.

#include <string>
#include <string_view>

#include "musher/behavior/tree/setup.hpp"

namespace musher::tree {

// "unsigned int"; empty: any, or a type without a known name.
std::string TypeNameOf(const PortModel& port);
// The XML element of a port in a model.
std::string_view PortElement(Direction direction);
// Null: any, or an unknown name.
const Type* TypeNamed(std::string_view name);

}  // namespace musher::tree
