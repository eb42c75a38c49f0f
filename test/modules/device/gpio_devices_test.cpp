// Touch pad, power key, contacts and lamps on GPIO lines, in virtual time, with lines of the test.

#include <gmock/gmock.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/test/modules/device/devices_fixture.hpp"
#include "musher/test/modules/device/fake_gpio.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::device::gpio_devices_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

GpioSpec Line(const std::string& name) {
  GpioSpec spec;
  spec.line = name;
  return spec;
}

class GpioDevices : public DevicesOnANetwork {
 protected:
  GpioDevices() {
    config_.battery.source = BatterySource::kNone;
    config_.touch.source = KeySource::kNone;
    config_.led.source = LedSource::kNone;
  }
  void Start() {
    Dependencies dependencies = Around();
    dependencies.open_gpio = gpio_.Opener();
    devices_ = test::Must(Devices::Make(dependencies, config_));
    Run(Milliseconds(500));  // discovery
  }

  FakeGpio gpio_;
};

// --- contacts ---

class GpioContact : public GpioDevices {
 protected:
  GpioContact() { config_.contacts = {{"bumper", Line("BUMPER")}}; }
  std::vector<bool> Published() {
    Run(Milliseconds(200));
    std::vector<bool> values;
    for (const msg::Bool& value : received_) values.push_back(value.data);
    received_.clear();
    return values;
  }

  std::vector<msg::Bool> received_;
  std::unique_ptr<transport::Subscription> contacts_ =
      Listen<msg::Bool>("dog1/contact/bumper", received_, transport::kLatchedQos);
};

TEST_F(GpioContact, IsPublishedAtTheStartAndWhenItChanges) {
  Start();
  EXPECT_THAT(Published(), ElementsAre(false));
  gpio_.Put("BUMPER", true);
  EXPECT_THAT(Published(), ElementsAre(true));
  gpio_.Put("BUMPER", false);
  EXPECT_THAT(Published(), ElementsAre(false));
  EXPECT_THAT(Failures(), IsEmpty());
}

TEST_F(GpioContact, IsKnownToAProgramThatSubscribesLater) {
  gpio_.active["BUMPER"] = true;
  Start();
  std::vector<msg::Bool> late;
  const auto subscription = Listen<msg::Bool>("dog1/contact/bumper", late, transport::kLatchedQos);
  Run(Milliseconds(500));
  ASSERT_EQ(late.size(), 1U);
  EXPECT_TRUE(late[0].data);
}

// A robot would go on as if its bumper were free.
TEST_F(GpioContact, HasNoPublisherWhileItsChipIsGone) {
  Start();
  EXPECT_EQ(contacts_->MatchedWriters(), 1U);
  gpio_.GoAway("gpiochip0:5 'BUMPER': No such device");
  Run(Milliseconds(500));
  EXPECT_EQ(contacts_->MatchedWriters(), 0U);
  EXPECT_THAT(Failures(), ElementsAre(1009));
  EXPECT_THAT(log_,
              ElementsAre("contact bumper: gpiochip0:5 'BUMPER': No such device; it is opened "
                          "again every second"));
  gpio_.active["BUMPER"] = true;
  gpio_.fault = "";
  received_.clear();
  Run(Milliseconds(1500));
  EXPECT_THAT(Published(), ElementsAre(true));
  EXPECT_THAT(Failures(), IsEmpty());
  EXPECT_EQ(log_.back(), "contact bumper: BUMPER works");
}

TEST_F(GpioContact, IsReadOnceASecondWhereItsChipReportsNoChange) {
  Start();
  received_.clear();
  gpio_.Put("BUMPER", true, false);
  Run(Milliseconds(1100));
  EXPECT_THAT(Published(), ElementsAre(true));
  gpio_.fault = "gpiochip0:5: No such device";  // and reports no loss
  Run(Milliseconds(1500));
  EXPECT_EQ(contacts_->MatchedWriters(), 0U);
}

TEST_F(GpioContact, SaysWhyItsLineCannotBeOpened) {
  gpio_.fault = "gpiochip0:5 'BUMPER' is in use by 'gpio-keys'";
  Start();
  EXPECT_THAT(Failures(), ElementsAre(1009));
  Run(Milliseconds(5000));
  EXPECT_THAT(log_, ElementsAre(HasSubstr("is in use by 'gpio-keys'"))) << "once";
  EXPECT_THAT(received_, IsEmpty());
}

// A program of a user, as its page shows it.
class Follower {
 public:
  explicit Follower(transport::Node& node) : endpoints_(node, "dog1") {
    // [contact]
    transport::SubscriptionEvents events;
    events.on_writer_lost = [this](transport::EndpointId) { bumper_.reset(); };  // not known
    endpoints_.Subscribe<msg::Bool>(
        "contact/bumper", [this](const msg::Bool& contact) { bumper_ = contact.data; },
        transport::kLatchedQos, std::move(events));
    // [contact end]
  }

  std::optional<bool> bumper() const { return bumper_; }

 private:
  std::optional<bool> bumper_;
  transport::Endpoints endpoints_;
};

TEST_F(GpioContact, IsFollowedByAProgramThatForgetsItWhileItCannotBeRead) {
  Start();
  const Follower follower(*desk_);
  Run(Milliseconds(500));
  EXPECT_EQ(follower.bumper(), false) << "it has started later";
  gpio_.Put("BUMPER", true);
  Run(Milliseconds(200));
  EXPECT_EQ(follower.bumper(), true);
  gpio_.GoAway("gpiochip0:5 'BUMPER': No such device");
  Run(Milliseconds(500));
  EXPECT_EQ(follower.bumper(), std::nullopt);
  gpio_.active["BUMPER"] = false;
  gpio_.fault = "";
  Run(Milliseconds(1500));
  EXPECT_EQ(follower.bumper(), false);
}

// --- the touch pad and the power key ---

class GpioTouch : public GpioDevices {
 protected:
  GpioTouch() {
    config_.touch.source = KeySource::kGpio;
    config_.touch.line = Line("PAD");
  }
  void Tap() {
    gpio_.Put("PAD", true);
    Run(Milliseconds(80));
    gpio_.Put("PAD", false);
  }
  std::vector<std::int32_t> Touches() {
    Run(Milliseconds(1000));
    std::vector<std::int32_t> states;
    for (const msg::TouchStatus& touch : received_) states.push_back(touch.touch_state);
    received_.clear();
    return states;
  }

  std::vector<msg::TouchStatus> received_;
  std::unique_ptr<transport::Subscription> touches_ =
      Listen<msg::TouchStatus>("dog1/touch_status", received_);
};

TEST_F(GpioTouch, KnowsTapsAndHolds) {
  Start();
  Tap();
  EXPECT_THAT(Touches(), ElementsAre(msg::TouchStatus::kSingle));
  Tap();
  Run(Milliseconds(100));
  Tap();
  EXPECT_THAT(Touches(), ElementsAre(msg::TouchStatus::kDoubleTouch));
  gpio_.Put("PAD", true);
  EXPECT_THAT(Touches(), ElementsAre(msg::TouchStatus::kHold));
}

TEST_F(GpioTouch, LeavesNoHalfDoubleTapWhenItsChipIsGoneOrItsChangesAreDropped) {
  Start();
  Tap();
  gpio_.Drop("PAD");
  Tap();
  EXPECT_THAT(Touches(), ElementsAre(msg::TouchStatus::kSingle));
  Tap();
  gpio_.GoAway("gpiochip0:2: No such device");
  EXPECT_THAT(Failures(), ElementsAre(1509));
  gpio_.fault = "";
  Run(Milliseconds(1100));
  Tap();
  EXPECT_THAT(Touches(), ElementsAre(msg::TouchStatus::kSingle));
  EXPECT_THAT(Failures(), IsEmpty());
}

class GpioPowerKey : public GpioDevices {
 protected:
  GpioPowerKey() {
    config_.power_key.source = KeySource::kGpio;
    config_.power_key.line = Line("KEY");
  }

  int power_offs_ = 0;
  std::unique_ptr<transport::Server<msg::Trigger>> manager_ = test::Must(
      transport::MakeServer<msg::Trigger>(*desk_, "dog1/poweroff", [this](const auto&, auto reply) {
        ++power_offs_;
        reply({true, ""});
      }));
};

TEST_F(GpioPowerKey, RequestsAPowerOffOnceItWasHeld) {
  Start();
  gpio_.Put("KEY", true);
  Run(Milliseconds(2900));
  EXPECT_EQ(power_offs_, 0);
  Run(Milliseconds(300));
  EXPECT_EQ(power_offs_, 1);
}

// One wrong level powers nothing off.
TEST_F(GpioPowerKey, RequestsNoPowerOffWhereItIsNotKnownToHaveBeenHeldAllTheTime) {
  Start();
  gpio_.Put("KEY", true);
  Run(Milliseconds(2000));
  gpio_.Drop("KEY");
  Run(Milliseconds(2000));
  EXPECT_EQ(power_offs_, 0);
  gpio_.GoAway("gpiochip0:2: No such device");
  Run(Milliseconds(5000));
  EXPECT_EQ(power_offs_, 0);
}

// A line whose active_low is wrong, or that has a short circuit, would power off at each start.
TEST_F(GpioPowerKey, CountsNotBeforeItWasSeenReleased) {
  gpio_.active["KEY"] = true;
  Start();
  Run(Milliseconds(10'000));
  EXPECT_EQ(power_offs_, 0);
  EXPECT_THAT(log_, ElementsAre(HasSubstr("pressed at the start")));
  gpio_.Put("KEY", false);
  gpio_.Put("KEY", true);
  Run(Milliseconds(3200));
  EXPECT_EQ(power_offs_, 1);
}

// --- lamps ---

class GpioLamps : public GpioDevices {
 protected:
  GpioLamps() {
    config_.led.source = LedSource::kGpio;
    config_.led.lines.at(0) = Line("LAMP");
  }
  std::int32_t Show(std::uint8_t effect, std::uint8_t blue) {
    using msg::LedExecute;
    return Call<LedExecute>("dog1/led_execute", {true, "vp", LedExecute::kHead,
                                                 LedExecute::kUserColor, effect, 0, 0, blue})
        .code;
  }
};

TEST_F(GpioLamps, AreOnInAnyColourAndOffInBlack) {
  Start();
  EXPECT_EQ(Show(msg::LedExecute::kRgbOn, 9), 0);
  EXPECT_TRUE(gpio_.active["LAMP"]);
  EXPECT_EQ(Show(msg::LedExecute::kRgbOn, 0), 0);
  EXPECT_FALSE(gpio_.active["LAMP"]);
  EXPECT_THAT(Failures(), IsEmpty());
}

TEST_F(GpioLamps, Blink) {
  Start();
  EXPECT_EQ(Show(msg::LedExecute::kBlink, 255), 0);
  int changes = 0;
  bool lit = gpio_.active["LAMP"];
  for (int i = 0; i < 400; ++i) {
    Run(Milliseconds(10));
    if (std::exchange(lit, gpio_.active["LAMP"]) != lit) ++changes;
  }
  EXPECT_NEAR(changes, 8, 1) << "at 1 Hz";
}

TEST_F(GpioLamps, AreOffOnceTheProgramHasEnded) {
  Start();
  EXPECT_EQ(Show(msg::LedExecute::kRgbOn, 9), 0);
  ASSERT_TRUE(gpio_.active["LAMP"]);
  devices_.reset();
  EXPECT_FALSE(gpio_.active["LAMP"]);
  EXPECT_FALSE(gpio_.IsOpen("LAMP"));
}

TEST_F(GpioLamps, AreShownOnceTheirChipIsBack) {
  Start();
  gpio_.GoAway("gpiochip0:7 'LAMP': No such device");
  EXPECT_EQ(Show(msg::LedExecute::kRgbOn, 9), 1107) << "kept";
  EXPECT_THAT(Failures(), ElementsAre(1109));
  gpio_.fault = "";
  gpio_.active["LAMP"] = false;
  Run(Milliseconds(1100));
  EXPECT_TRUE(gpio_.active["LAMP"]);
  EXPECT_THAT(Failures(), IsEmpty());
  EXPECT_THAT(log_, Contains("led: head: LAMP works"));
}

}  // namespace musher::device::gpio_devices_test
