#include "musher/modules/device/gpio_lights.hpp"

#include <utility>

namespace musher::device {

class GpioLights::Lamp {
 public:
  using Log = std::function<void(const std::string&)>;

  Lamp(transport::EventLoop& loop, const GpioLine::Open& open, GpioSpec spec, Log log)
      : loop_(loop), open_(open), spec_(std::move(spec)), log_(std::move(log)) {
    Open();
  }

  void Show(const Look& look) {
    if (look_ == look) return;
    look_ = look;
    lit_ = look.r != 0 || look.g != 0 || look.b != 0;
    blink_.reset();
    if (lit_ && look.half_period > Duration()) {
      blink_ = loop_.Every(look.half_period, [this] { Switch(!lit_); });
    }
    Switch(lit_);
  }
  const std::string& fault() const { return fault_; }

 private:
  void Open() {
    reopen_.reset();
    line_.reset();
    auto opened = open_(loop_, spec_, GpioLine::Direction::kOutput, {});
    if (!opened) return Lose(opened.error().message);
    line_ = std::move(opened).value();
    Switch(lit_);
  }
  void Switch(bool lit) {
    lit_ = lit;
    if (!line_) return;
    if (const Result<> set = line_->Set(lit); !set) return Lose(set.error().message);
    if (!std::exchange(fault_, "").empty()) log_(spec_.line + " works");
  }
  void Lose(const std::string& why) {
    line_.reset();
    reopen_ = loop_.At(loop_.Now() + kReopen, [this] { Open(); });
    if (std::exchange(fault_, why) == why) return;
    log_((why.find(spec_.line) != std::string::npos ? "" : spec_.line + ": ") + why +
         "; it is opened again every second");
  }

  transport::EventLoop& loop_;
  const GpioLine::Open open_;
  const GpioSpec spec_;
  const Log log_;
  std::optional<Look> look_;
  bool lit_ = false;  // now: a blinking one changes
  std::string fault_;
  std::unique_ptr<GpioLine> line_;
  transport::LoopHandlePtr reopen_;
  transport::LoopHandlePtr blink_;  // these two are last: their callbacks use the rest
};

GpioLights::GpioLights(transport::EventLoop& loop, const GpioLine::Open& open,
                       const LampLines& lines, const std::function<void(const std::string&)>& log) {
  constexpr std::array<const char*, kLedTargets.size()> kNames = {"head", "tail", "mini"};
  for (std::size_t i = 0; i < lamps_.size(); ++i) {
    if (lines.at(i).line.empty()) continue;
    const std::string name = std::string("led: ") + kNames.at(i) + ": ";
    lamps_.at(i) = std::make_unique<Lamp>(
        loop, open, lines.at(i), [log, name](const std::string& line) { log(name + line); });
  }
}

GpioLights::~GpioLights() = default;

void GpioLights::Show(const Lights& lights) {
  for (std::size_t i = 0; i < lamps_.size(); ++i) {
    if (lamps_.at(i)) lamps_.at(i)->Show(LookOf(kLedTargets.at(i), lights.at(i).light));
  }
}

std::string GpioLights::FaultOf(std::uint8_t target) const {
  const auto& lamp = lamps_.at(target - kLedTargets.front());
  return lamp ? lamp->fault() : "";
}

}  // namespace musher::device
