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

// A node that moves the base.
template <class N, class... Args>
void AddMover(Factory& factory, Robot& robot, std::string_view name, const std::string& does,
              Args... args) {
  if (factory.Find(name) != nullptr) return;
  static_cast<void>(
      factory.Register(name, {.kind = NodeKind::kAction,
                              .takes_time = true,
                              .make = [&robot, args...](Setup& setup) -> std::unique_ptr<Node> {
                                return std::make_unique<N>(setup, robot, args...);
                              },
                              .description = does,
                              .uses = "base"}));
}

void AddControlNodes(Factory& factory, Robot& robot);
void AddDecoratorNodes(Factory& factory, Robot& robot);
void AddConditionNodes(Factory& factory, Robot& robot);
void AddStateNodes(Factory& factory, Robot& robot);
void AddActionNodes(Factory& factory, Robot& robot);
void AddMissionNodes(Factory& factory, Robot& robot);
void AddPlaceNodes(Factory& factory, Robot& robot);
void AddPathNodes(Factory& factory, Robot& robot);
void AddRouteNodes(Factory& factory, Robot& robot);

}  // namespace musher::tree::nav2
