#include "musher/cli/machine/skill_offers.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "musher/base/words.hpp"
#include "musher/cli/machine/application_request.hpp"

namespace musher::cli {
namespace {

// The latched offers of running actuators arrive within some 10 ms of each other.
constexpr Duration kQuiet = Milliseconds(300);

}  // namespace

Result<std::unique_ptr<SkillOffers>> SkillOffers::Begin(
    Link& link, const GlobalOptions& global,
    std::function<void(const std::string& actuator)> on_lost) {
  std::unique_ptr<SkillOffers> offers(new SkillOffers(link, global, std::move(on_lost)));
  auto running = RunningActuators::Begin(link.node(), global.name_space, !global.keys.empty());
  if (!running) return running.error();
  offers->running_ = std::move(running).value();
  transport::SubscriptionEvents events;
  events.on_writer_lost = [self = offers.get()](transport::EndpointId writer) {
    for (const auto& [actuator, offer] : self->offers_) {
      if (offer.writer == writer && self->on_lost_) self->on_lost_(actuator);
    }
    std::erase_if(self->offers_, [writer](const auto& one) { return one.second.writer == writer; });
  };
  auto subscription = transport::MakeSubscription<msg::SkillOffers>(
      link.node(), transport::ResolveName(global.name_space, "skills"),
      [self = offers.get()](const msg::SkillOffers& of, const transport::SampleInfo& info) {
        self->offers_[of.actuator] = {of, info.writer};
        self->changed_ = true;
      },
      transport::kLatchedFromManyQos, std::move(events));
  if (!subscription) return subscription.error();
  offers->subscription_ = std::move(subscription).value();
  return offers;
}

void SkillOffers::AwaitUntilQuiet(const std::string& actuator, Duration timeout) {
  const auto now = [this] { return link_.loop().Now(); };
  const Time end = now() + timeout;
  while (now() < end && !link_.interrupted()) {
    changed_ = false;
    const Duration left = end - now();
    const bool waits = offers_.empty() || !actuator.empty();
    const bool more = link_.RunUntil([&] { return changed_ || Has(actuator); },
                                     waits ? left : std::min(left, kQuiet));
    if (!more || Has(actuator)) return;
  }
}

void SkillOffers::AwaitAny(Duration timeout) {
  AwaitUntilQuiet("", timeout);
}

std::optional<Failure> SkillOffers::Await(const std::string& actuator) {
  AwaitUntilQuiet(actuator, link_.discovery());
  if (actuator.empty() ? !offers_.empty() : Has(actuator)) return std::nullopt;
  return NoOffer(actuator);
}

Failure SkillOffers::NoOffer(const std::string& actuator) const {
  if (link_.interrupted()) return {ExitCode::kInterrupted, {kCodeFailed, "interrupted"}};
  std::set<std::string> present;
  for (const auto& [name, status] : running_->Now()) present.insert(name);
  for (const auto& [name, offer] : offers_) present.insert(name);
  if (present.contains(actuator)) {
    return {ExitCode::kNotDone, {kCodeUnSupport, actuator + " runs but offers no skills"}};
  }
  if (!actuator.empty()) return NoSuchActuator(link_, global_, actuator, present);
  if (present.empty() && !link_.HasMachine()) return link_.NotFound("actuator");
  return {ExitCode::kNotDone,
          {kCodeUnSupport,
           fmt::format("no actuator in {} offers skills{}", NamespaceText(global_.name_space),
                       present.empty() ? ": none runs there"
                                       : fmt::format("; running: {}", fmt::join(present, ", ")))}};
}

std::vector<msg::SkillOffers> SkillOffers::all() const {
  std::vector<msg::SkillOffers> all;
  for (const auto& [actuator, offer] : offers_) all.push_back(offer.skills);
  return all;
}

}  // namespace musher::cli
