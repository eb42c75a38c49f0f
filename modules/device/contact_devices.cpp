#include "musher/modules/device/contact_devices.hpp"

#include <utility>

#include "musher/cyberdog/codes/module_codes.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::device {

class ContactDevices::Contact {
 public:
  Contact(const Dependencies& dependencies, const ContactConfig& config)
      : dependencies_(dependencies), name_("contact " + config.name) {
    topic_ = transport::ResolveName(dependencies_.name_space, "contact/" + config.name);
    GpioInput::Events events;
    events.on_level = [this](bool active) { Publish(active); };
    events.on_gap = [] {};  // what is known now follows
    events.on_lost = [this] { publisher_.reset(); };
    events.log = [this](const std::string& line) { dependencies_.log(name_ + ": " + line); };
    input_ = std::make_unique<GpioInput>(dependencies_.node.loop(), dependencies_.open_gpio,
                                         config.line, std::move(events));
  }

  // Why it is not published; "": it is.
  std::string Fault() const {
    const std::string& why = input_->fault().empty() ? not_published_ : input_->fault();
    return why.empty() ? "" : name_ + ": " + why;
  }

 private:
  void Publish(bool active) {
    Result<> published;
    if (!publisher_) {
      auto made =
          transport::MakePublisher<msg::Bool>(dependencies_.node, topic_, transport::kLatchedQos);
      if (made) publisher_ = std::move(made).value();
      if (!made) published = made.error();
    }
    if (published) published = publisher_->Publish({active});
    const std::string why = published ? "" : published.error().message;
    if (std::exchange(not_published_, why) != why && !why.empty()) {
      dependencies_.log(name_ + ": " + why);
    }
  }

  const Dependencies dependencies_;
  const std::string name_;
  std::string topic_;
  std::string not_published_;
  std::unique_ptr<transport::Publisher<msg::Bool>> publisher_;
  std::unique_ptr<GpioInput> input_;  // last: its callbacks use the rest
};

ContactDevices::ContactDevices(const Dependencies& dependencies,
                               const std::vector<ContactConfig>& contacts) {
  for (const ContactConfig& contact : contacts) {
    contacts_.push_back(std::make_unique<Contact>(dependencies, contact));
  }
}

ContactDevices::~ContactDevices() = default;

Result<> ContactDevices::Check() const {
  std::string faults;
  for (const auto& contact : contacts_) {
    const std::string fault = contact->Fault();
    if (!fault.empty()) faults += (faults.empty() ? "" : "; ") + fault;
  }
  if (faults.empty()) return Ok();
  return Error{MakeCode(cyberdog::module_code::kDeviceManager, KeyCode::kSelfCheckFailed), faults};
}

}  // namespace musher::device
