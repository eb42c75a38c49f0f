#include "musher/modules/device/measurement_devices.hpp"

#include <map>
#include <utility>

#include "musher/cyberdog/codes/module_codes.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/modules/device/i2c_link.hpp"

namespace musher::device {

class MeasurementDevices::Measurement {
 public:
  Measurement(const Dependencies& dependencies, const MeasurementConfig& config)
      : dependencies_(dependencies),
        name_(config.registers.bus + " " + HexadecimalByte(config.registers.address)) {
    I2cLink::Events events;
    events.on_record = [this](const I2cRecord::Values& values) { Publish(values); };
    events.on_refused = [this](const Error& error) { Log("refused: " + error.message); };
    events.on_fault = [this](const std::string& why) {
      publishers_.clear();
      Log(why);
    };
    link_ = std::make_unique<I2cLink>(dependencies_.node.loop(), dependencies_.i2c,
                                      config.registers, config.silence, std::move(events));
  }

  // Why its values are not published; "": they are.
  std::string Fault() const {
    if (!not_published_.empty()) return name_ + ": " + not_published_;
    if (link_->works()) return "";
    return name_ + ": " + (link_->fault().empty() ? "no reading received yet" : link_->fault());
  }

 private:
  using Publisher = std::unique_ptr<transport::Publisher<msg::Float32>>;

  void Publish(const I2cRecord::Values& values) {
    if (publishers_.empty()) Log("works");
    Result<> published;
    for (const auto& [name, value] : values) {
      if (const Result<> one = Publish(name, value); !one) published = one;
    }
    const std::string why = published ? "" : published.error().message;
    if (std::exchange(not_published_, why) != why && !why.empty()) Log(why);
  }
  Result<> Publish(const std::string& name, double value) {
    Publisher& publisher = publishers_[name];
    if (!publisher) {
      auto made = transport::MakePublisher<msg::Float32>(
          dependencies_.node,
          transport::ResolveName(dependencies_.name_space, "measurement/" + name),
          transport::kLatchedQos);
      if (!made) return made.error();
      publisher = std::move(made).value();
    }
    return publisher->Publish({static_cast<float>(value)});
  }
  void Log(const std::string& line) const {
    dependencies_.log("measurement " + name_ + ": " + line);
  }

  const Dependencies dependencies_;
  const std::string name_;
  std::string not_published_;
  std::map<std::string, Publisher> publishers_;
  std::unique_ptr<I2cLink> link_;  // last: its callbacks use the rest
};

MeasurementDevices::MeasurementDevices(const Dependencies& dependencies,
                                       const std::vector<MeasurementConfig>& measurements) {
  for (const MeasurementConfig& measurement : measurements) {
    measurements_.push_back(std::make_unique<Measurement>(dependencies, measurement));
  }
}

MeasurementDevices::~MeasurementDevices() = default;

Result<> MeasurementDevices::Check() const {
  std::string faults;
  for (const auto& measurement : measurements_) {
    const std::string fault = measurement->Fault();
    if (!fault.empty()) faults += (faults.empty() ? "" : "; ") + fault;
  }
  if (faults.empty()) return Ok();
  return Error{MakeCode(cyberdog::module_code::kDeviceManager, KeyCode::kSelfCheckFailed), faults};
}

}  // namespace musher::device
