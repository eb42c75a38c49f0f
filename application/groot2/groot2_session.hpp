#pragma once
// A tree that Groot2 watches: replies to each request of the protocol (groot2_reply.hpp), and keeps
// what Groot2 has set: hooks and a recording of transitions.
//
// clang-format off
//   I  HOOK_INSERT        part 2: a hook as JSON, or an array of hooks; one of the same node is changed
//   R  HOOK_REMOVE        part 2: {"uid", "position"}
//   U  BREAKPOINT_UNLOCK  part 2: {"uid", "position", "desired_status", "remove_when_done"}
//   D  HOOKS_DUMP         reply: an array of {"enabled", "uid", "mode", "once", "desired_status", "position"}
//   A, X                  remove, disable all hooks
//   N  BREAKPOINT_REACHED published: part 1: as of a request, part 2: the uid as a decimal number
//   r  TOGGLE_RECORDING   part 2: start or stop; reply of start: µs since 1970 as a decimal number
//   t  GET_TRANSITIONS    reply: of each transition 6 bytes µs since the start, uint16 uid, uint8 status;
//                         each is there once, the last kMostTransitions at most
// clang-format on
//
// A hook acts on the robot, so it is refused unless Options::hooks allows it. Of its positions only
// PRE (0) is served. Modes: BREAKPOINT (0) holds the node when it is about to start, REPLACE (1)
// gives it the desired status, if that is SUCCESS or FAILURE (behavior/tree/hooks.hpp).
//
// A hook is the client's that has set it last, and a recording is the client's that has started it.
//
// Threads: the loop's.

#include <chrono>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>

#include "musher/application/groot2/groot2_reply.hpp"
#include "musher/behavior/tree/hooks.hpp"

namespace musher::groot2 {

class Session {
 public:
  static constexpr std::size_t kMostTransitions = 1000;

  struct Options {
    bool hooks = false;
    std::function<void(const Parts&)> publish{};
    std::function<void()> on_lost{};  // see groot2_server.hpp
  };
  Session(std::function<TreeView()> view, const tree::Factory& factory, Options options);

  // `client`: any name of it that no other one has.
  Parts Reply(const std::string& client, const Parts& request);
  // The client is lost: its hooks are removed. Where one of them acts, the node would begin to
  // move: on_lost halts the tree. Without on_lost that hook stays, until any client removes it.
  void Forget(const std::string& client);

 private:
  class Transitions;

  void Follow(const TreeView& view);
  Result<Parts> Change(const std::string& client, const Parts& request, const TreeView& view);
  Result<Parts> Record(const std::string& client, const std::string& command, const TreeView& view);
  std::string Dump() const;
  std::shared_ptr<tree::Hooks> MakeHooks();

  const std::function<TreeView()> view_;
  const tree::Factory& factory_;
  const Options options_;
  std::random_device random_;
  std::optional<std::uint32_t> revision_;
  TreeId id_{};
  std::shared_ptr<tree::Hooks> hooks_;                                // of the present tree
  std::map<std::pair<tree::NodeId, bool>, std::string> hook_owners_;  // by node, before and after
  std::shared_ptr<Transitions> transitions_;                          // null: nothing was recorded
  std::string recorder_;                                              // the client of these
};

}  // namespace musher::groot2
