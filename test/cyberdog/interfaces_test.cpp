#include "musher/cyberdog/interfaces.hpp"

#include <gtest/gtest.h>

#include <string>

#include "musher/wire/security/permissions.hpp"

namespace musher::cyberdog::interfaces_test {

using transport::keys::Role;

TEST(Interfaces, AreTheOperatorsExceptQueriesAndWakingUp) {
  const auto may = [](Role role, const std::string& topic) {
    const std::string xml =
        transport::keys::PermissionsXml({"x", "CN=x", role, {}, {}}, Interfaces());
    const std::string allowed = xml.substr(0, xml.find("<deny_rule>"));
    return allowed.find("<topic>" + topic + "</topic>") < allowed.find("<subscribe>");
  };
  for (const char* topic : {"rq/poweroffRequest", "rq/*/poweroffRequest", "rt/machine_state_switch",
                            "rq/machine_state_switch_keepRequest"}) {
    EXPECT_TRUE(may(Role::kOperator, topic)) << topic;
    EXPECT_FALSE(may(Role::kActuator, topic)) << topic;
    EXPECT_FALSE(may(Role::kObserver, topic)) << topic;
  }
  for (const Role role : {Role::kOperator, Role::kActuator, Role::kObserver}) {
    EXPECT_TRUE(may(role, "rq/bms_infoRequest"));
    EXPECT_FALSE(may(role, "rt/state_switch_status"));
    EXPECT_EQ(may(role, "rq/low_power_exitRequest"), role != Role::kObserver);
  }
  EXPECT_TRUE(may(Role::kController, "rt/state_switch_status"));
  EXPECT_TRUE(may(Role::kController, "rr/*/poweroffReply"));
}

}  // namespace musher::cyberdog::interfaces_test
