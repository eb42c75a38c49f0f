#include "musher/transport/dds/security.hpp"

#include <string>

#include "musher/transport/security/key_folder.hpp"

namespace musher::transport::dds {

void SetCredentials(dds_qos_t* qos, const Credentials& credentials) {
  const keys::KeyFolder folder(credentials.keys);
  const auto set = [qos](const std::string& name, const std::string& value) {
    dds_qset_prop(qos, name.c_str(), value.c_str());
  };
  const auto set_file = [&set](const std::string& name, const std::string& file) {
    set(name, "file:" + file);
  };
  for (const std::string plugin : {"auth", "access", "crypto"}) {
    const std::string library = plugin == "access" ? "ac" : plugin;
    const std::string function = plugin == "auth"     ? "authentication"
                                 : plugin == "access" ? "access_control"
                                                      : "crypto";
    const std::string prefix = "dds.sec." + plugin + ".library.";
    set(prefix + "path", "dds_security_" + library);
    set(prefix + "init", "init_" + function);
    set(prefix + "finalize", "finalize_" + function);
  }
  const std::string& name = credentials.identity;
  set_file("dds.sec.auth.identity_ca", folder.IdentityCa());
  set_file("dds.sec.auth.identity_certificate", folder.Certificate(name));
  set_file("dds.sec.auth.private_key", folder.Key(name));
  set_file("org.eclipse.cyclonedds.sec.auth.crl", folder.Revocations());
  set_file("dds.sec.access.permissions_ca", folder.PermissionsCa());
  set_file("dds.sec.access.governance", folder.Governance());
  set_file("dds.sec.access.permissions", folder.Permissions(name));
}

}  // namespace musher::transport::dds
