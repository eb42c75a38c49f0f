#include "musher/modules/device/can_lights.hpp"

#include <tuple>
#include <utility>

namespace musher::device {
namespace {

constexpr const char* kShow = "enable_on";
constexpr const char* kShown = "enable_on_ack";

using LightBytes = std::array<std::uint8_t, 4>;

}  // namespace

const CanNames& LightCanNames() {
  static const CanNames names = {{kShown}, "", {kShow}, kShow, std::tuple_size_v<LightBytes>};
  return names;
}

class CanLights::Lamp {
 public:
  using Log = std::function<void(const std::string&)>;

  Lamp(transport::EventLoop& loop, const CanBus::Open& open, const CanProtocol& protocol, Log log)
      : loop_(loop), log_(std::move(log)), acknowledges_(protocol.HasField(kShown)) {
    CanLink::Events events;
    events.on_record = [this](const CanRecord::Values&) { OnAcknowledged(); };
    events.on_refused = [this](const Error& error) { log_(error.message); };
    events.on_fault = [this](const std::string& why) { OnFault(why); };
    events.on_working = [this] { Send(); };
    link_ = std::make_unique<CanLink>(loop, open, protocol, Duration(), std::move(events));
  }

  void Show(const LightBytes& bytes) {
    if (wanted_ == bytes) return;
    wanted_ = bytes;
    Send();
  }
  const std::string& fault() const { return fault_; }

 private:
  void Send() {
    if (!wanted_ || !link_ || !link_->works()) return;
    const Result<> sent = link_->Send(kShow, *wanted_);
    if (!sent) SetFault(sent.error().message);
    if (sent && !acknowledges_) return SetFault("");
    if (sent) ++awaited_;
    again_ = loop_.At(loop_.Now() + kAcknowledged, [this, sent = sent.ok()] {
      if (sent) SetFault("its board has not acknowledged its light; it is sent again every second");
      awaited_ = 0;
      Send();
    });
  }
  // An acknowledgement does not name its light, and may be for an earlier one.
  void OnAcknowledged() {
    if (--awaited_ > 0) return;
    awaited_ = 0;
    again_.reset();
    SetFault("");
  }
  void OnFault(const std::string& why) {
    awaited_ = 0;
    again_.reset();
    SetFault(why);
  }
  void SetFault(const std::string& fault) {
    if (std::exchange(fault_, fault) != fault) log_(fault.empty() ? "works" : fault);
  }

  transport::EventLoop& loop_;
  const Log log_;
  const bool acknowledges_;
  std::optional<LightBytes> wanted_;
  int awaited_ = 0;  // acknowledgements
  std::string fault_;
  transport::LoopHandlePtr again_;
  std::unique_ptr<CanLink> link_;  // last: its callbacks use the rest
};

CanLights::CanLights(transport::EventLoop& loop, const CanBus::Open& open,
                     const LightProtocols& protocols,
                     const std::function<void(const std::string&)>& log) {
  constexpr std::array<const char*, kLedTargets.size()> kNames = {"head", "tail", "mini"};
  for (std::size_t i = 0; i < lamps_.size(); ++i) {
    if (!protocols.at(i)) continue;
    const std::string name = std::string("led: ") + kNames.at(i) + ": ";
    lamps_.at(i) = std::make_unique<Lamp>(
        loop, open, *protocols.at(i), [log, name](const std::string& line) { log(name + line); });
  }
}

CanLights::~CanLights() = default;

void CanLights::Show(const Lights& lights) {
  for (std::size_t i = 0; i < lamps_.size(); ++i) {
    if (lamps_.at(i)) lamps_.at(i)->Show(BoardBytes(kLedTargets.at(i), lights.at(i).light));
  }
}

std::string CanLights::FaultOf(std::uint8_t target) const {
  const auto& lamp = lamps_.at(target - kLedTargets.front());
  return lamp ? lamp->fault() : "";
}

}  // namespace musher::device
