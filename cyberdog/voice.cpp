#include "musher/cyberdog/voice.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "musher/cyberdog/parts.hpp"
#include "musher/cyberdog/sounds.hpp"
#include "musher/cyberdog/voice_policy.hpp"
#include "musher/messages/protocol/audio.hpp"

namespace musher::cyberdog {
namespace {

using Play = msg::AudioPlay;

// In order of urgency: nothing to say, battery_at, and the levels of the policy.
constexpr std::array<std::uint16_t, 5> kBatteryWords = {0, Play::kBattery30, Play::kBattery20,
                                                        Play::kBattery5, Play::kBattery0};
constexpr std::size_t kLongestSentence = 240;  // bytes; some ten seconds

// Cuts at a character boundary.
std::string Shortened(std::string text) {
  if (text.size() <= kLongestSentence) return text;
  std::size_t end = kLongestSentence;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
  text.resize(end);
  return text;
}

class VoiceDecision {
 public:
  VoiceDecision(const MachineConfig& config, VoiceState& voice, Time now)
      : config_(config), rules_(VoiceOf(*config.policy)), voice_(voice), now_(now) {}

  void On(const voice_event::MachineSeen& seen);
  void On(const voice_event::Recorded& recorded);
  void On(const voice_event::DoubleTapped& tapped);
  void On(const voice_event::AppConnected& connected);
  void On(const voice_event::PlayerMatched& matched);
  void On(const voice_event::PlayReported& reported);
  void On(const voice_event::PlayEnded& ended);
  void On(const voice_event::TimePassed&) {}

  void FollowClock();
  void Update();
  std::vector<VoiceAction> Take() && { return std::move(actions_); }

 private:
  bool May(Occasion occasion) const;
  bool MayStandUp() const;
  void Announce(Occasion occasion, Utterance utterance);
  void AnnounceFirst(Utterance utterance);
  void AnnounceSentence(Occasion occasion, const std::string& sentence);
  void Queue(VoiceState::WaitingUtterance waiting, bool first);

  void AnnounceStart();
  void AnnounceFaults();
  void AnnounceBattery();
  int BatteryUrgency() const;
  void AnnounceSwitch(const action::Record& record);

  void DropStandUp();
  void End();
  void DropWithoutPlayer();
  void PlayNext();

  const MachineConfig& config_;
  const VoicePolicy& rules_;
  VoiceState& voice_;
  const Time now_;
  std::vector<VoiceAction> actions_;
};

// The zero of /clock changes when the world restarts, and with its first sample.
void VoiceDecision::FollowClock() {
  if (voice_.now == Time{} || now_ < voice_.now) {
    const Duration jump = now_ - voice_.now;
    for (auto& waiting : voice_.waiting) waiting.until += jump;
    if (voice_.playing) voice_.playing->until += jump;
    if (voice_.tapped) *voice_.tapped += jump;
    for (auto& sentence : voice_.sentences) sentence.said += jump;
    voice_.busy_until += jump;
  }
  voice_.now = now_;
}

void VoiceDecision::On(const voice_event::MachineSeen& seen) {
  voice_.machine = seen.machine;
  if (seen.machine.stopped) DropStandUp();
  switch (seen.machine.phase) {
    case Phase::kFailed:
      if (std::exchange(voice_.failure_announced, true)) return;
      Announce(Occasion::kStart, {Play::kSelfCheckFailed, ""});
      return AnnounceFaults();
    case Phase::kRunning:
      AnnounceStart();
      return AnnounceBattery();
    case Phase::kIdle:
    case Phase::kStarting:
      return;
    case Phase::kStopping:
    case Phase::kStopped:
    case Phase::kFenced:
      voice_.waiting.clear();
  }
}

void VoiceDecision::AnnounceStart() {
  const MachineSummary& machine = voice_.machine;
  if (!std::exchange(voice_.start_announced, true)) {
    if (machine.adopted) {
      voice_.loading_announced = true;
      voice_.greeted = true;  // perhaps: a restart of the controller stands no robot up
    } else {
      Announce(Occasion::kStart, {Play::kReady, ""});
      const bool well = machine.faults.empty();
      Announce(Occasion::kStart, {well ? Play::kSelfCheckOk : Play::kSelfCheckFailed, ""});
      AnnounceFaults();
    }
  }
  if (!machine.loaded || std::exchange(voice_.loading_announced, true)) return;
  AnnounceFaults();
  const auto& all = config_.actuators;
  const bool staged =
      std::any_of(all.begin(), all.end(), [](const auto& a) { return a.stage > 1; });
  if (staged) Announce(Occasion::kStart, {Play::kStarted, ""});
}

void VoiceDecision::AnnounceFaults() {
  for (const MachineSummary::Fault& fault : voice_.machine.faults) {
    auto& announced = voice_.faults_announced;
    if (std::find(announced.begin(), announced.end(), fault) != announced.end()) continue;
    announced.push_back(fault);
    for (const std::int32_t code : FailedCodes(PartsOf(fault.actuator), fault.error)) {
      if (const auto sound = SelfCheckSound(fault.actuator, code)) {
        Announce(Occasion::kStart, {*sound, ""});
      } else {
        AnnounceSentence(Occasion::kStart, fault.actuator + ": " + fault.error.message);
      }
    }
  }
}

// 0: nothing to announce.
int VoiceDecision::BatteryUrgency() const {
  const MachineSummary& machine = voice_.machine;
  if (!machine.battery) return 0;
  switch (machine.level) {
    case BatteryLevel::kEmpty:
      return machine.empty ? 4 : 3;  // one sample announces no end
    case BatteryLevel::kLowPower:
      return 3;
    case BatteryLevel::kProtected:
      return 2;
    case BatteryLevel::kFree:
      break;
  }
  const int hysteresis = config_.policy->battery ? config_.policy->battery->hysteresis : 0;
  const int left_at = rules_.battery_at + (voice_.battery_announced > 0 ? hysteresis : 1);
  return *machine.battery < left_at ? 1 : 0;
}

// An announcement that is not permitted now is not marked as done: it follows later if still true.
void VoiceDecision::AnnounceBattery() {
  const int urgency = BatteryUrgency();
  if (urgency > voice_.battery_announced) {
    if (voice_.machine.charging || !May(Occasion::kBattery)) return;
    Announce(Occasion::kBattery, {kBatteryWords.at(static_cast<std::size_t>(urgency)), ""});
  }
  voice_.battery_announced = urgency;
}

// Before the machine is running, the start has announcements of its own.
void VoiceDecision::On(const voice_event::Recorded& recorded) {
  const action::Record& record = recorded.record;
  if (record.kind == "switch") return AnnounceSwitch(record);
  const bool announced = record.kind == "policy" && record.code != kCodeOk &&
                         record.code != kCodeTargetBusy && voice_.machine.phase == Phase::kRunning;
  if (announced) AnnounceSentence(Occasion::kRefusal, record.message);
}

void VoiceDecision::AnnounceSwitch(const action::Record& record) {
  const bool begins = record.switch_number != 0 && record.switch_number != voice_.switch_number;
  if (begins) {
    voice_.switch_number = record.switch_number;
    voice_.known.clear();
    for (const auto& fault : voice_.machine.faults) voice_.known.push_back(fault.error.code);
  }
  // No announcement if another switch superseded this one, or if the actuator was already degraded.
  const bool known =
      record.switch_number != 0 &&
      std::find(voice_.known.begin(), voice_.known.end(), record.code) != voice_.known.end();
  const bool announced = record.code != kCodeOk && record.code != kCodeTargetBusy && !known &&
                         !record.actuator && voice_.machine.phase == Phase::kRunning;
  if (!announced) return;
  const auto sound = record.switch_number == 0 ? std::nullopt : SwitchSound(record.code);
  if (sound) return Announce(Occasion::kSwitch, {*sound, ""});
  AnnounceSentence(Occasion::kSwitch, record.message);
}

void VoiceDecision::On(const voice_event::DoubleTapped&) {
  const MachineSummary& machine = voice_.machine;
  if (machine.phase != Phase::kRunning) return;
  if (voice_.tapped && now_ < *voice_.tapped + kTapPause) return;
  voice_.tapped = now_;
  if (!machine.battery || machine.battery_silent) {
    return AnnounceFirst({0, "the charge of the battery is not known"});
  }
  AnnounceFirst({static_cast<std::uint16_t>(Play::kBatteryLevel + *machine.battery), ""});
}

void VoiceDecision::On(const voice_event::AppConnected&) {
  if (!MayStandUp()) return;
  if (!May(Occasion::kApp) || std::exchange(voice_.greeted, true)) return;
  if (voice_.player) {
    Queue({{Play::kAppConnected, ""}, now_ + kVoiceTimeout, true}, false);
  } else {
    actions_.emplace_back(voice_action::StandUp{});
  }
}

void VoiceDecision::On(const voice_event::PlayerMatched& matched) {
  voice_.player = matched.available;
  if (!matched.available && voice_.playing) End();
}

void VoiceDecision::On(const voice_event::PlayReported& reported) {
  voice_.busy_until = reported.playing ? now_ + kReportLasts : now_;
}

void VoiceDecision::On(const voice_event::PlayEnded& ended) {
  if (!voice_.playing || ended.number != voice_.number) return;  // its deadline is over
  End();
}

bool VoiceDecision::MayStandUp() const {
  const MachineSummary& machine = voice_.machine;
  const bool awake = machine.state == kActive || machine.state == kProtected;
  return machine.phase == Phase::kRunning && awake && !machine.charging && !machine.stopped;
}

bool VoiceDecision::May(Occasion occasion) const {
  const bool asleep = voice_.machine.state == kLowPower;
  return rules_.Announces(occasion) &&
         (!asleep || !rules_.quiet_asleep || occasion == Occasion::kTouch);
}

void VoiceDecision::Announce(Occasion occasion, Utterance utterance) {
  if (May(occasion)) Queue({std::move(utterance), now_ + kVoiceTimeout}, false);
}

// A person waits for the answer to a double tap.
void VoiceDecision::AnnounceFirst(Utterance utterance) {
  if (May(Occasion::kTouch)) Queue({std::move(utterance), now_ + kVoiceTimeout}, true);
}

void VoiceDecision::AnnounceSentence(Occasion occasion, const std::string& sentence) {
  auto& said = voice_.sentences;
  std::erase_if(said, [&](const auto& s) { return now_ >= s.said + kSameSentence; });
  const std::string text = Shortened(sentence);
  const bool again =
      std::any_of(said.begin(), said.end(), [&](const auto& s) { return s.text == text; });
  if (again || !May(occasion)) return;
  said.push_back({text, now_});
  Announce(occasion, {0, text});
}

void VoiceDecision::Queue(VoiceState::WaitingUtterance waiting, bool first) {
  auto& all = voice_.waiting;
  const bool waits = std::any_of(all.begin(), all.end(),
                                 [&](const auto& w) { return w.utterance == waiting.utterance; });
  if (waits) return;
  if (all.size() == kMostWaiting) all.erase(all.begin());
  all.insert(first ? all.begin() : all.end(), std::move(waiting));
}

// The app connected before the stop, whose release alone moves nothing.
void VoiceDecision::DropStandUp() {
  for (auto& waiting : voice_.waiting) waiting.stand_up = false;
  if (voice_.playing) voice_.playing->stand_up = false;
}

void VoiceDecision::End() {
  const bool stand_up = voice_.playing->stand_up && MayStandUp();
  voice_.playing.reset();
  voice_.busy_until = now_;
  if (stand_up) actions_.emplace_back(voice_action::StandUp{});
}

void VoiceDecision::Update() {
  if (voice_.playing && now_ >= voice_.playing->until) End();
  if (!voice_.player) DropWithoutPlayer();
  if (voice_.player && !voice_.playing) PlayNext();
}

void VoiceDecision::DropWithoutPlayer() {
  const auto dropped =
      std::erase_if(voice_.waiting, [&](const auto& w) { return now_ >= w.until; });
  if (dropped == 0 || std::exchange(voice_.silence_announced, true)) return;
  actions_.emplace_back(voice_action::LogDropped{});
}

void VoiceDecision::PlayNext() {
  if (voice_.waiting.empty()) return;
  VoiceState::WaitingUtterance next = voice_.waiting.front();
  if (now_ < std::min(voice_.busy_until, next.until)) return;
  voice_.waiting.erase(voice_.waiting.begin());
  actions_.emplace_back(voice_action::Play{++voice_.number, next.utterance});
  next.until = now_ + (next.utterance.text.empty() ? kPhraseTime : kSentenceTime);
  voice_.playing = std::move(next);
}

}  // namespace

MachineSummary SummaryOf(const MachineConfig& config, const Machine& machine) {
  MachineSummary summary;
  summary.phase = machine.phase;
  summary.state = machine.state;
  summary.adopted = machine.last_switch == 0;
  summary.loaded = machine.policy.loaded;
  summary.battery = machine.policy.battery;
  summary.level = machine.policy.level;
  summary.empty = machine.policy.empty;
  summary.charging = machine.policy.charging;
  summary.battery_silent = machine.policy.battery_silent;
  summary.stopped = machine.emergency.stop.has_value();
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    if (const auto fault = TroubleOf(machine.actuators[i])) {
      summary.faults.push_back({config.actuators[i].name, *fault});
    }
  }
  return summary;
}

std::vector<VoiceAction> Speak(const MachineConfig& config, VoiceState& voice,
                               const VoiceEvent& event, Time now) {
  VoiceDecision decision(config, voice, now);
  decision.FollowClock();
  std::visit([&](const auto& what) { decision.On(what); }, event);
  decision.Update();
  return std::move(decision).Take();
}

std::optional<Time> NextVoiceDeadline(const VoiceState& voice) {
  if (voice.playing) return voice.playing->until;
  if (voice.waiting.empty()) return std::nullopt;
  if (voice.player) return std::min(voice.busy_until, voice.waiting.front().until);
  const auto first =
      std::min_element(voice.waiting.begin(), voice.waiting.end(),
                       [](const auto& a, const auto& b) { return a.until < b.until; });
  return first->until;
}

}  // namespace musher::cyberdog
