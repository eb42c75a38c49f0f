#include "musher/lifecycle/supervision/fallback.hpp"

#include <utility>

#include "musher/lifecycle/switch/plan.hpp"

namespace musher {

bool Fallback::Begin() {
  // A switch of one actuator, which may take long, does not keep the others up.
  const bool may_begin = !machine_.current || machine_.current->only;
  if (!machine_.fallback.target || !may_begin || machine_.phase != Phase::kRunning) return false;
  const State target = *std::exchange(machine_.fallback.target, std::nullopt);
  memory_.LowerAtMostTo(target);
  const auto rank = config_.RankOf(machine_.state);
  if (!rank || *config_.RankOf(target) >= *rank) return false;  // it is that safe already
  const Plan plan = MakeSafetyPlan(config_, machine_, target);
  if (plan.refusal) {  // not of a running machine with a valid config
    RecordMachine(plan.refusal->code, texts::FallbackRefused(target, plan.refusal->message),
                  machine_.fallback.cause);
    return false;
  }
  const RecordId recorded =
      RecordMachine(kCodeOk, texts::FallbackStarted(target), machine_.fallback.cause);
  if (machine_.current) switches_.Supersede(machine_.number + 1, target, recorded);
  switches_.Begin(plan, Purpose::kFallback, {}, recorded);
  return true;
}

}  // namespace musher
