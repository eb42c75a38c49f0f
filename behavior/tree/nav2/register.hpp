#pragma once
// How the nodes of nav2 are registered; only for the sources of this folder.

#include <memory>
#include <string>
#include <string_view>

#include "musher/behavior/tree/nav2/nodes.hpp"

namespace musher::tree::nav2 {

// `takes_time`: it may return RUNNING by itself.
template <class N, class... Args>
void AddNode(Factory& factory, std::string_view name, NodeKind kind, bool takes_time,
             const std::string& does, Args&... args) {
  if (factory.Find(name) != nullptr) return;
  static_cast<void>(
      factory.Register(name, {.kind = kind,
                              .takes_time = takes_time,
                              .make = [&args...](Setup& setup) -> std::unique_ptr<Node> {
                                if constexpr (std::is_constructible_v<N, Setup&, Args&...>) {
                                  return std::make_unique<N>(setup, args...);
                                } else {
                                  return std::make_unique<N>(args...);
                                }
                              },
                              .description = does}));
}

void AddControlNodes(Factory& factory);
void AddDecoratorNodes(Factory& factory, Robot& robot);
void AddConditionNodes(Factory& factory, Robot& robot);
void AddActionNodes(Factory& factory, Robot& robot);
void AddPathNodes(Factory& factory, Robot& robot);
void AddRouteNodes(Factory& factory, Robot& robot);

}  // namespace musher::tree::nav2
