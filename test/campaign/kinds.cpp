#include "musher/test/campaign/kind.hpp"

#include "musher/test/campaign/faults/process.hpp"

namespace musher::campaign {
namespace {

void AddProcess(std::vector<Kind>& kinds) {
  using namespace process;
  const auto add = [&](const char* name, const char* about, std::function<void(Trial&)> strike) {
    kinds.push_back({name, "process", about, std::move(strike)});
  };
  const auto exits = [](int code) { return [code](Trial& trial) { Exits(trial, code); }; };
  add("kill", "SIGKILL", Killed);
  add("kill-several", "SIGKILL of two to five at once", SeveralKilled);
  add("term", "SIGTERM", Terminated);
  add("stop-long", "SIGSTOP until it is called hung", StoppedForLong);
  add("stop-short", "SIGSTOP and SIGCONT within its limit", StoppedShortly);
  add("exit-0", "ends by itself with exit code 0", exits(0));
  add("exit-1", "ends by itself with exit code 1", exits(1));
  add("exit-77", "ends by itself with exit code 77", exits(77));
  add("abort", "calls abort()", Aborts);
  add("segfault", "a segmentation fault", Segfaults);
  add("crash-loop", "dies in each SetUp until it is given up", CrashesAgainAndAgain);
  add("wrapped-kill", "SIGKILL of the program in a musher-exec", WrappedProgramKilled);
}

}  // namespace

const std::vector<Kind>& AllKinds() {
  static const std::vector<Kind> kinds = [] {
    std::vector<Kind> all;
    AddProcess(all);
    return all;
  }();
  return kinds;
}

const Kind* FindKind(const std::string& name) {
  for (const Kind& kind : AllKinds()) {
    if (kind.name == name) return &kind;
  }
  return nullptr;
}

}  // namespace musher::campaign
